//! Writing sums and products as operations.
//!
//! Signs cost nothing until the outputs: a value may be stored with the wrong
//! sign, and its users subtract instead of adding or pass the sign on. Rounding
//! to nearest is symmetric, so a flipped sign changes no bit. Only what needs
//! the true sign of a value, an output or a root, forces a `0 - x`.

use super::earliest::{TieOrder, join_earliest};
use super::groups::GroupFamily;
use crate::cse::{Key, KnownValues, SourceMerges};
use hashbrown::HashMap;
use robovec_analysis::critical_path::{Weights, longest};
use robovec_framework::rewrite::output_symbol;
use robovec_ir::{
    FreshNames, Function, Level, Name, Node, Operand, OperandKind, Operation, SourceSet, Symbol,
    Tables, Value,
};
use rustc_hash::FxBuildHasher;
use smallvec::{SmallVec, smallvec};

/// An operand that holds a value or its negation, and its arrival time.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct SignedOperand {
    pub(crate) operand: Operand,
    pub(crate) negative: bool,
    pub(crate) arrival: u32,
}

impl SignedOperand {
    pub(crate) const NONE: SignedOperand = SignedOperand {
        operand: Operand::NONE,
        negative: false,
        arrival: 0,
    };

    /// The operand, representing the negation on request.
    pub(crate) fn flip(self, flip: bool) -> SignedOperand {
        SignedOperand {
            negative: self.negative ^ flip,
            ..self
        }
    }
}

/// The operation that joins two signed terms or factors, its operands, and a
/// flag: true when its result is stored negated; `flip` chooses the negated
/// form where both cost the same.
pub(crate) fn joining<T>(
    family: GroupFamily,
    [(a, a_negative), (b, b_negative)]: [(T, bool); 2],
    flip: bool,
) -> (Operation, [T; 2], bool) {
    match (family, a_negative, b_negative) {
        (GroupFamily::Product, _, _) => (Operation::Mul, [a, b], a_negative ^ b_negative),
        (GroupFamily::Sum, false, false) => (Operation::Add, [a, b], false),
        (GroupFamily::Sum, true, true) => (Operation::Add, [a, b], true),
        (GroupFamily::Sum, false, true) if flip => (Operation::Sub, [b, a], true),
        (GroupFamily::Sum, false, true) => (Operation::Sub, [a, b], false),
        (GroupFamily::Sum, true, false) if flip => (Operation::Sub, [a, b], true),
        (GroupFamily::Sum, true, false) => (Operation::Sub, [b, a], false),
    }
}

/// Names and sources of the operations that one value becomes.
pub(crate) struct ValueNaming {
    /// For the last operation; [`Name::NONE`] when it has no special name.
    root: Name,
    /// Of values that became part of this one, to be used again; last first.
    spare: SmallVec<[Name; 4]>,
    /// The symbol that further names start with.
    owner: Symbol,
    pub(crate) sources: SourceSet,
}

impl ValueNaming {
    /// Without names to be used again.
    pub(crate) fn new(root: Name, owner: Symbol, sources: SourceSet) -> ValueNaming {
        ValueNaming {
            root,
            spare: SmallVec::new(),
            owner,
            sources,
        }
    }

    /// Takes over the names and sources of values that became part of this
    /// one. The name of an equation goes with its value.
    pub(crate) fn with_parts(
        mut self,
        parts: impl Iterator<Item = (Name, SourceSet)>,
        tables: &mut Tables,
    ) -> ValueNaming {
        let mut sets: SmallVec<[SourceSet; 8]> = smallvec![self.sources];
        for (name, sources) in parts {
            if !sets.contains(&sources) || sets.len() > 8 {
                sets.push(sources);
            }
            if !name.is_none() && name.suffix > 0 && name != self.root {
                self.spare.push(name);
            }
        }
        // By their texts: numbers of symbols depend on what was read first, and
        // the same program read from its text must give the same.
        let symbols = &tables.symbols;
        let text = |name: &Name| (symbols.text(name.base), name.suffix);
        self.spare.sort_unstable_by(|a, b| text(b).cmp(&text(a)));
        self.spare.dedup();
        self.sources = tables.sources.union(&sets);
        self
    }

    /// The name of the next operation.
    pub(crate) fn next(&mut self, last: bool, names: &mut FreshNames) -> Name {
        if last && !self.root.is_none() {
            return self.root;
        }
        let spare = self.spare.pop();
        spare.unwrap_or_else(|| names.fresh(self.owner))
    }
}

/// Times at which the values of a function are there, one known after the
/// other.
pub(crate) struct ArrivalTimes {
    pub(crate) weights: Weights,
    times: Vec<u32>,
}

impl ArrivalTimes {
    /// Of no value yet, with memory for about this number.
    pub(crate) fn new(weights: Weights, count: usize) -> ArrivalTimes {
        ArrivalTimes {
            weights,
            times: Vec::with_capacity(count),
        }
    }

    pub(crate) fn of(&self, operand: Operand) -> u32 {
        operand.entry_or_default(&self.times)
    }

    /// Time at which the last value is available.
    pub(crate) fn longest(&self) -> u32 {
        longest(&self.times)
    }

    /// Time at which an operation is done.
    pub(crate) fn finish(&self, operation: Operation, operands: &[Operand]) -> u32 {
        let ready = operands.iter().map(|&operand| self.of(operand));
        let weight = self.weights.of(operation);
        ready.fold(0, u32::max).saturating_add(weight)
    }

    /// Records when the next value is available.
    pub(crate) fn note(&mut self, time: u32) {
        self.times.push(time);
    }

    /// Appends an operation to the function.
    pub(crate) fn push(&mut self, out: &mut Function, node: Node) -> Value {
        assert_eq!(
            self.times.len(),
            out.nodes().len(),
            "every value has a time"
        );
        self.note(self.finish(node.operation, node.operands()));
        out.push(node)
    }
}

/// Writes a function of sums, products and other operations.
pub(crate) struct SumWriter {
    pub(crate) out: Function,
    pub(crate) times: ArrivalTimes,
    names: FreshNames,
    /// True when operations inside sums and products have names.
    named: bool,
    /// The operations written, for finding equal ones, and the origins of
    /// merged ones; `None` when equal operations are written again.
    shared: Option<(KnownValues, SourceMerges)>,
    negated: HashMap<Operand, Operand, FxBuildHasher>,
}

impl SumWriter {
    /// Starts with an empty body at a level.
    pub(crate) fn new(old: &Function, level: Level, weights: Weights) -> SumWriter {
        SumWriter {
            names: old.fresh_names(),
            named: level != Level::Equations,
            ..SumWriter::draft(old, level, weights)
        }
    }

    /// The same for a tentative result, which needs no names.
    pub(crate) fn draft(old: &Function, level: Level, weights: Weights) -> SumWriter {
        let count = old.nodes().len();
        let mut out = old.skeleton(level);
        out.reserve(count);
        SumWriter {
            out,
            times: ArrivalTimes::new(weights, count),
            names: FreshNames::new(std::iter::empty()),
            named: false,
            shared: None,
            negated: HashMap::default(),
        }
    }

    /// The same, but equal operations are written once.
    pub(crate) fn sharing(self) -> SumWriter {
        let known = KnownValues::with_capacity(self.times.times.capacity());
        SumWriter {
            shared: Some((known, SourceMerges::default())),
            ..self
        }
    }

    /// The operand with a sign and its arrival.
    pub(crate) fn signed(&self, operand: Operand, negative: bool) -> SignedOperand {
        SignedOperand {
            operand,
            negative,
            arrival: self.times.of(operand),
        }
    }

    pub(crate) fn number(&mut self, number: f64) -> SignedOperand {
        let operand = self.out.constant(number).into();
        self.signed(operand, false)
    }

    /// Operand in the new function for one of the function read; `map` has
    /// those of values.
    pub(crate) fn translate(
        &mut self,
        old: &Function,
        map: &[SignedOperand],
        operand: Operand,
    ) -> SignedOperand {
        match operand.kind() {
            OperandKind::Value(value) => map[value.index()],
            OperandKind::Constant(constant) => self.number(old.constant_number(constant)),
            OperandKind::Input(_) | OperandKind::None => self.signed(operand, false),
        }
    }

    /// The value that an operation has been written as, when equal operations
    /// are written once.
    pub(crate) fn find<const COUNT: usize>(
        &self,
        operation: Operation,
        operands: [Operand; COUNT],
    ) -> Option<Value> {
        let (known, _) = self.shared.as_ref()?;
        known.find(&self.out, Key::new(operation, operands))
    }

    /// The name of the next operation of a value.
    pub(crate) fn name(&mut self, last: bool, naming: &mut ValueNaming) -> Name {
        match (self.named, last) {
            (true, _) => naming.next(last, &mut self.names),
            (false, true) => naming.root,
            (false, false) => Name::NONE,
        }
    }

    /// Appends an operation, or finds an equal one; only a new one needs a
    /// name.
    fn append<const COUNT: usize>(
        &mut self,
        operation: Operation,
        operands: [Operand; COUNT],
        sources: SourceSet,
        name: impl FnOnce(&mut SumWriter) -> Name,
    ) -> Operand {
        let next = Value(self.out.nodes().len() as u32);
        if let Some((known, merges)) = &mut self.shared {
            let key = Key::new(operation, operands);
            if let Some(same) = known.find_or_insert(&self.out, key, next) {
                merges.add(same, sources);
                return same.into();
            }
        }
        let node = Node {
            name: name(self),
            sources,
            operands: Operand::list(operands),
            operation,
        };
        let value = self.times.push(&mut self.out, node);
        assert_eq!(value, next, "a name is no operation");
        value.into()
    }

    /// Appends an operation of this name, or finds an equal one.
    pub(crate) fn write<const COUNT: usize>(
        &mut self,
        operation: Operation,
        operands: [Operand; COUNT],
        name: Name,
        sources: SourceSet,
    ) -> Operand {
        self.append(operation, operands, sources, |_| name)
    }

    /// Appends the next operation of a value, or finds an equal one.
    pub(crate) fn push<const COUNT: usize>(
        &mut self,
        operation: Operation,
        operands: [Operand; COUNT],
        last: bool,
        naming: &mut ValueNaming,
    ) -> Operand {
        self.append(operation, operands, naming.sources, |writer| {
            writer.name(last, naming)
        })
    }

    /// Joins two terms or factors; returns whether it is the last operation of its
    /// value, and which of two equal forms is taken ([`joining`]).
    pub(crate) fn join(
        &mut self,
        family: GroupFamily,
        [a, b]: [SignedOperand; 2],
        (last, flip): (bool, bool),
        naming: &mut ValueNaming,
    ) -> SignedOperand {
        let pair = [(a.operand, a.negative), (b.operand, b.negative)];
        let (operation, operands, negative) = joining(family, pair, flip);
        let ready = a.arrival.max(b.arrival);
        SignedOperand {
            operand: self.push(operation, operands, last, naming),
            negative,
            arrival: ready.saturating_add(self.times.weights.of(operation)),
        }
    }

    /// Writes a sum or product as the tree that joins the two earliest first;
    /// the last sum takes the negated form where it is wished and free.
    pub(crate) fn tree(
        &mut self,
        family: GroupFamily,
        mut terms: Vec<SignedOperand>,
        (ties, flip): (TieOrder, bool),
        naming: &mut ValueNaming,
    ) -> SignedOperand {
        let arrival = |term: &SignedOperand| term.arrival;
        let root = join_earliest(&mut terms, ties, arrival, |pair, last| {
            self.join(family, pair, (last, flip && last), naming)
        });
        root.expect("a sum or product has operands")
    }

    /// The operand with its true sign; costs `0 - x` when it is stored with
    /// the other one, once per operand.
    pub(crate) fn true_sign(&mut self, value: SignedOperand, naming: &mut ValueNaming) -> Operand {
        if !value.negative {
            return value.operand;
        }
        if let Some(number) = self.out.number(value.operand) {
            return self.out.constant(-number).into();
        }
        if let Some(&known) = self.negated.get(&value.operand) {
            return known;
        }
        let name = self.name(false, naming);
        let zero = Operand::from(self.out.constant(0.0));
        let (operation, operands) = match self.out.level {
            Level::Equations => (Operation::Neg, [value.operand, Operand::NONE]),
            _ => (Operation::Sub, [zero, value.operand]),
        };
        let negated = self.write(operation, operands, name, naming.sources);
        self.negated.insert(value.operand, negated);
        negated
    }

    /// Permits new negations of all values: a negation for another equation
    /// gets that equation as its source.
    pub(crate) fn forget_negations(&mut self) {
        self.negated.clear();
    }

    /// Sets the outputs to operands, by place; an output that needs a `0 - x`
    /// gives it its name.
    pub(crate) fn outputs(
        &mut self,
        old: &Function,
        tables: &mut Tables,
        mut stored: impl FnMut(&mut SumWriter, usize) -> SignedOperand,
    ) {
        let mut assignments = old.assignments.clone();
        for (place, assignment) in assignments.iter_mut().enumerate() {
            let value = stored(self, place);
            assignment.operand = value.operand;
            if value.negative {
                let owner = output_symbol(tables, old, assignment.output);
                let mut naming = ValueNaming::new(Name::NONE, owner, assignment.sources);
                assignment.operand = self.true_sign(value, &mut naming);
            }
        }
        self.out.assignments = assignments;
    }

    /// Returns the function, and the unused names in it.
    pub(crate) fn finish(mut self, tables: &mut Tables) -> (Function, FreshNames) {
        if let Some((_, merges)) = self.shared {
            merges.apply(&mut self.out, tables);
        }
        (self.out, self.names)
    }
}
