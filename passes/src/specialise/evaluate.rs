//! Partial evaluation: a function with some inputs known, rewritten.

use super::constants::{Known, KnownNumbers};
use super::form::{LinearForm, MAX_TERMS, Reading, ScaledOperand};
use super::write::{is_function, known};
use crate::cse::{Key, KnownValues};
use robovec_framework::rewrite::owners;
use robovec_framework::rewrite_limit::RewriteLimit;
use robovec_ir::{
    Assignment, FreshNames, Function, Level, Name, Node, Operand, OperandKind, Operation,
    SourceSet, Symbol, Tables, Value,
};

/// The counts of folded and removed operations.
#[derive(Clone, Copy, Default, Debug)]
pub(super) struct OperationTally {
    /// Their result is a number.
    pub(super) known: u64,
    /// Their result is another value, or its terms went into a sum or product
    /// that is computed later.
    pub(super) absorbed: u64,
    /// They were computed already.
    pub(super) merged: u64,
}

/// Writes a function again; the number of a constant in it is its index among
/// the constants.
pub(super) struct PartialEvaluator<'a> {
    old: &'a Function,
    tables: &'a mut Tables,
    rewrites: &'a RewriteLimit,
    pub(super) constants: &'a mut KnownNumbers,
    new: Function,
    readings: Vec<Reading>,
    /// The numbers of inputs.
    bound: &'a [Option<f64>],
    /// For every old value its only user's operation, when it has one user
    /// that can take it uncomputed.
    only_user: Vec<Option<Operation>>,
    owners: Vec<Symbol>,
    fresh: FreshNames,
    computed: KnownValues,
    pub(super) tally: OperationTally,
}

impl<'a> PartialEvaluator<'a> {
    pub(super) fn new(
        old: &'a Function,
        tables: &'a mut Tables,
        rewrites: &'a RewriteLimit,
        constants: &'a mut KnownNumbers,
        bound: &'a [Option<f64>],
    ) -> PartialEvaluator<'a> {
        let mut new = old.skeleton(old.level);
        new.reserve(old.nodes().len());
        PartialEvaluator {
            owners: owners(tables, old),
            fresh: old.fresh_names(),
            only_user: only_users(old),
            computed: KnownValues::with_capacity(old.nodes().len()),
            readings: Vec::with_capacity(old.nodes().len()),
            tally: OperationTally::default(),
            old,
            tables,
            rewrites,
            constants,
            new,
            bound,
        }
    }

    /// Writes all nodes and outputs.
    pub(super) fn run(mut self) -> (Function, OperationTally) {
        let old = self.old;
        for (value, node) in old.values() {
            let reading = self.node(value, node);
            self.readings.push(reading);
        }
        let mut assignments = Vec::with_capacity(old.assignments.len());
        for assignment in &old.assignments {
            let reading = self.reading(assignment.operand);
            // What an output reads was computed, or is a number.
            let operand = self.operand(reading, Symbol(u32::MAX));
            assignments.push(Assignment {
                operand,
                ..*assignment
            });
        }
        self.new.assignments = assignments;
        (self.new, self.tally)
    }

    fn reading(&mut self, operand: Operand) -> Reading {
        let number = match operand.kind() {
            OperandKind::Value(value) => return self.readings[value.index()].clone(),
            OperandKind::Constant(constant) => Some(self.old.constant_number(constant)),
            OperandKind::Input(input) => self.bound[input.index()],
            OperandKind::None => None,
        };
        match number {
            Some(number) => Reading::Known(self.constants.literal(number)),
            None => Reading::Operand(operand),
        }
    }

    fn node(&mut self, value: Value, node: &Node) -> Reading {
        let readings = [0, 1, 2].map(|place| match node.operands().get(place) {
            Some(&operand) => self.reading(operand),
            None => Reading::Operand(Operand::NONE),
        });
        let equal = node.operation == Operation::Sub && node.operands[0] == node.operands[1];
        if !equal && !readings.iter().any(Reading::is_touched) {
            let operands = readings.map(|reading| match reading {
                Reading::Operand(operand) => operand,
                Reading::Known(_) | Reading::Form(_) => Operand::NONE,
            });
            return self.same(node, operands);
        }
        let owner = self.owners[value.index()];
        if self.rewrites.allow(node.name, "inputs known")
            && let Some(form) = self.calculate(node, &readings, owner)
        {
            return self.settle(value, node, form);
        }
        let operands = readings.map(|reading| self.operand(reading, owner));
        Reading::Operand(self.push(node.operation, operands, node.name, node.sources))
    }

    /// An operation on values that are unchanged.
    fn same(&mut self, node: &Node, operands: [Operand; Operand::MAX_COUNT]) -> Reading {
        let found = self.known(node.operation, operands);
        let merged = found.filter(|_| self.rewrites.allow(node.name, "equal operations"));
        Reading::Operand(match merged {
            Some(found) => self.merge(found, node.sources),
            None => self.push(node.operation, operands, node.name, node.sources),
        })
    }

    /// The result of an operation as a form; `None` when it is not folded.
    fn calculate(
        &mut self,
        node: &Node,
        readings: &[Reading; 3],
        owner: Symbol,
    ) -> Option<LinearForm> {
        let [a, b, _] = readings;
        let mut form = match node.operation {
            Operation::Copy => self.form(a),
            Operation::Neg => self.form(a).times(Known::MINUS_ONE, self.constants)?,
            Operation::Add | Operation::Sub => {
                let (first, second) = (self.short_form(a, owner), self.short_form(b, owner));
                first.plus(&second, node.operation, self.constants)?
            }
            Operation::Mul => self.product(a, b, node, owner)?,
            Operation::Div => self.quotient(a, b, node, owner)?,
            Operation::Sin | Operation::Cos | Operation::Sqrt => match a {
                Reading::Known(known) => {
                    LinearForm::number(self.constants.apply(node.operation, [*known; 2])?)
                }
                Reading::Operand(_) | Reading::Form(_) => return None,
            },
            // A fused operation keeps its single rounding.
            Operation::Fma | Operation::Fms | Operation::Fnma => return None,
        };
        let mut sources = vec![node.sources, form.sources];
        for reading in readings {
            if let Reading::Form(form) = reading {
                sources.push(form.sources);
            }
        }
        form.sources = self.tables.sources.union(&sources);
        form.name = node.name;
        Some(form)
    }

    fn form(&self, reading: &Reading) -> LinearForm {
        match reading {
            Reading::Known(known) => LinearForm::number(*known),
            Reading::Operand(operand) => LinearForm::term(Known::ONE, *operand),
            Reading::Form(form) => (**form).clone(),
        }
    }

    /// As [`PartialEvaluator::form`], with long forms computed as values.
    fn short_form(&mut self, reading: &Reading, owner: Symbol) -> LinearForm {
        match reading {
            Reading::Form(form) if form.terms.len() > MAX_TERMS => {
                let operand = self.compute((**form).clone(), owner);
                LinearForm::term(Known::ONE, operand)
            }
            _ => self.form(reading),
        }
    }

    fn product(
        &mut self,
        a: &Reading,
        b: &Reading,
        node: &Node,
        owner: Symbol,
    ) -> Option<LinearForm> {
        match (a, b) {
            (Reading::Known(known), other) | (other, Reading::Known(known)) => {
                self.form(other).times(*known, self.constants)
            }
            _ => {
                let (first, a) = self.factored(a, owner);
                let (second, b) = self.factored(b, owner);
                let factor = self.constants.apply(Operation::Mul, [first, second])?;
                let name = self.inner_name(factor, node.name, owner);
                let product = self.shared(Operation::Mul, [a, b], name, node.sources);
                Some(LinearForm::term(factor, product))
            }
        }
    }

    fn quotient(
        &mut self,
        a: &Reading,
        b: &Reading,
        node: &Node,
        owner: Symbol,
    ) -> Option<LinearForm> {
        if let Reading::Known(divisor) = b {
            let inverse = self
                .constants
                .apply(Operation::Div, [Known::ONE, *divisor])?;
            return self.form(a).times(inverse, self.constants);
        }
        let (divisor, b) = self.factored(b, owner);
        if let Reading::Known(dividend) = a {
            let dividend = self.constants.apply(Operation::Div, [*dividend, divisor])?;
            let dividend = match dividend {
                Known::ZERO => return Some(LinearForm::number(Known::ZERO)),
                dividend => self.number(dividend),
            };
            let name = self.inner_name(Known::ONE, node.name, owner);
            let quotient = self.shared(Operation::Div, [dividend, b], name, node.sources);
            return Some(LinearForm::term(Known::ONE, quotient));
        }
        let (dividend, a) = self.factored(a, owner);
        let factor = self.constants.apply(Operation::Div, [dividend, divisor])?;
        let name = self.inner_name(factor, node.name, owner);
        let quotient = self.shared(Operation::Div, [a, b], name, node.sources);
        Some(LinearForm::term(factor, quotient))
    }

    /// The name of a product: that of the value if it is the value.
    fn inner_name(&mut self, factor: Known, name: Name, owner: Symbol) -> Name {
        if factor == Known::ONE {
            name
        } else {
            self.helper_name(owner)
        }
    }

    /// A name for an operation that is no old value's.
    fn helper_name(&mut self, owner: Symbol) -> Name {
        match self.new.level {
            Level::Equations => Name::NONE,
            _ => self.fresh.fresh(owner),
        }
    }

    /// A reading as a number times an operand.
    fn factored(&mut self, reading: &Reading, owner: Symbol) -> (Known, Operand) {
        let form = match reading {
            Reading::Known(known) => return (*known, Operand::NONE),
            Reading::Operand(operand) => return (Known::ONE, *operand),
            Reading::Form(form) => &**form,
        };
        if form.constant == Known::ZERO {
            if let [term] = form.terms.as_slice() {
                return (term.factor, term.operand);
            }
            let (common, _) = self.constants.magnitude(form.terms[0].factor);
            let mut all = form.terms.iter();
            if common != Known::ONE
                && all.all(|term| self.constants.magnitude(term.factor).0 == common)
            {
                let (negative, operand) = self.group(&form.terms, form.sources, owner);
                let common = if negative {
                    self.constants.negative(common)
                } else {
                    common
                };
                return (common, operand);
            }
        }
        (Known::ONE, self.compute(form.clone(), owner))
    }

    /// Further form of a value: a number, another operand, a form for its only
    /// user, or an operation.
    fn settle(&mut self, value: Value, node: &Node, form: LinearForm) -> Reading {
        if let Some(known) = form.as_number() {
            self.tally.known += 1;
            return Reading::Known(known);
        }
        if let Some(operand) = form.as_operand() {
            self.tally.absorbed += 1;
            // At the equations level only what has a name can be read twice.
            if let Some(computed) = operand.value()
                && self.new.node(computed).name.is_none()
            {
                self.new.node_mut(computed).name = node.name;
            }
            return Reading::Operand(operand);
        }
        if let Some(user) = self.only_user[value.index()]
            && !is_function(user)
            && !user.is_fused()
        {
            self.tally.absorbed += 1;
            return Reading::Form(Box::new(form));
        }
        let owner = self.owners[value.index()];
        Reading::Operand(self.compute(form, owner))
    }

    fn operand(&mut self, reading: Reading, owner: Symbol) -> Operand {
        match reading {
            Reading::Known(known) => self.number(known),
            Reading::Operand(operand) => operand,
            Reading::Form(form) => self.compute(*form, owner),
        }
    }

    fn number(&mut self, known: Known) -> Operand {
        self.new.constant(f64::from(known.0)).into()
    }

    /// Computes a form: terms with the same factor are summed before they are
    /// multiplied by it.
    fn compute(&mut self, form: LinearForm, owner: Symbol) -> Operand {
        let mut items: Vec<(bool, Operand)> = Vec::with_capacity(form.terms.len() + 1);
        let mut groups: Vec<(Known, Vec<ScaledOperand>)> = Vec::new();
        for &term in &form.terms {
            let (magnitude, _) = self.constants.magnitude(term.factor);
            match groups.iter_mut().find(|(other, _)| *other == magnitude) {
                Some((_, group)) => group.push(term),
                None => groups.push((magnitude, vec![term])),
            }
        }
        for (magnitude, group) in groups {
            if magnitude == Known::ONE {
                for term in group {
                    items.push((term.factor != Known::ONE, term.operand));
                }
                continue;
            }
            let (negative, operand) = self.group(&group, form.sources, owner);
            let factor = self.number(magnitude);
            let name = self.helper_name(owner);
            let product = self.shared(Operation::Mul, [factor, operand], name, form.sources);
            items.push((negative, product));
        }
        if form.constant != Known::ZERO {
            let (magnitude, negative) = self.constants.magnitude(form.constant);
            items.push((negative, self.number(magnitude)));
        }
        let (negative, sum) = self.chain(&items, form.sources, owner);
        let result = match (negative, self.new.level) {
            (false, _) => sum,
            (true, Level::Equations) => self.push(
                Operation::Neg,
                Operand::list([sum]),
                Name::NONE,
                form.sources,
            ),
            (true, _) => {
                let zero = self.number(Known::ZERO);
                let name = self.helper_name(owner);
                self.shared(Operation::Sub, [zero, sum], name, form.sources)
            }
        };
        self.bear(result, form.name);
        result
    }

    /// Gives the result of a form the name of its value.
    fn bear(&mut self, result: Operand, name: Name) {
        if let Some(value) = result.value()
            && !name.is_none()
            && value.index() + 1 == self.new.nodes().len()
        {
            self.new.node_mut(value).name = name;
        }
    }

    /// The sum of terms of one magnitude, without it; true for a negative.
    fn group(
        &mut self,
        terms: &[ScaledOperand],
        sources: SourceSet,
        owner: Symbol,
    ) -> (bool, Operand) {
        let mut items = Vec::with_capacity(terms.len());
        for term in terms {
            items.push((self.constants.magnitude(term.factor).1, term.operand));
        }
        self.chain(&items, sources, owner)
    }

    /// A sum of signed operands, the first positive one leading; true when
    /// there is none, for the negative of the sum.
    fn chain(
        &mut self,
        items: &[(bool, Operand)],
        sources: SourceSet,
        owner: Symbol,
    ) -> (bool, Operand) {
        let lead = items.iter().position(|(negative, _)| !negative);
        let first = lead.unwrap_or(0);
        let mut sum = items[first].1;
        for (place, &(negative, operand)) in items.iter().enumerate() {
            if place == first {
                continue;
            }
            let operation = if negative && lead.is_some() {
                Operation::Sub
            } else {
                Operation::Add
            };
            let name = self.helper_name(owner);
            sum = self.shared(operation, [sum, operand], name, sources);
        }
        (lead.is_none(), sum)
    }

    /// An operation, or the value that computes the same already.
    fn shared(
        &mut self,
        operation: Operation,
        operands: [Operand; 2],
        name: Name,
        sources: SourceSet,
    ) -> Operand {
        let operands = Operand::list(operands);
        match self.known(operation, operands) {
            Some(found) => self.merge(found, sources),
            None => self.push(operation, operands, name, sources),
        }
    }

    /// The value that computes the same already; at the level of equations none
    /// is looked for.
    fn known(&self, operation: Operation, operands: [Operand; 3]) -> Option<Value> {
        let key = Key::new(operation, operands);
        self.computed.find(&self.new, key)
    }

    fn merge(&mut self, found: Value, sources: SourceSet) -> Operand {
        self.tally.merged += 1;
        let merged = &mut self.new.node_mut(found).sources;
        *merged = self.tables.sources.union(&[*merged, sources]);
        found.into()
    }

    fn push(
        &mut self,
        operation: Operation,
        operands: [Operand; Operand::MAX_COUNT],
        name: Name,
        sources: SourceSet,
    ) -> Operand {
        let value = self.new.push(Node {
            name,
            sources,
            operands,
            operation,
        });
        if self.new.level == Level::Atomic {
            let key = Key::new(operation, operands);
            self.computed.find_or_insert(&self.new, key, value);
        }
        value.into()
    }
}

/// For every value that is read once, by an operation, that operation.
fn only_users(function: &Function) -> Vec<Option<Operation>> {
    let counts = function.use_counts();
    let mut users = vec![None; counts.len()];
    for node in function.nodes() {
        for value in node.operands().iter().filter_map(|operand| operand.value()) {
            if counts[value.index()] == 1 {
                users[value.index()] = Some(node.operation);
            }
        }
    }
    users
}

/// The numbers that a function with numbered constants reads.
pub(super) fn constants_read(function: &Function) -> u64 {
    let read = function.reads();
    let mut read: Vec<Known> = read
        .filter_map(|operand| known(function, operand))
        .collect();
    read.sort_unstable();
    read.dedup();
    read.len() as u64
}
