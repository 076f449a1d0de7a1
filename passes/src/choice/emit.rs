//! Writing the chosen forms as a function.

use super::import::Import;
use super::map::{Mapper, Mapping};
use super::network::{ChoiceForm, ChoiceNetwork, Class, ProductTerm};
use super::timing::NetworkTiming;
use crate::sums::earliest::{TieOrder, join_earliest};
use robovec_ir::{
    Assignment, FreshNames, Function, Level, Name, Node, Operand, Operation, SourceSet, Symbol,
    Tables,
};
use smallvec::SmallVec;

/// An operand that holds a value or its negation.
#[derive(Clone, Copy, Debug)]
struct Held {
    operand: Operand,
    negative: bool,
    arrival: u32,
}

/// Writes the function a mapping stands for, at the atomic level, with the
/// signature and the names of the function that was read.
pub(crate) fn emit(
    old: &Function,
    import: &Import,
    mapper: &Mapper,
    mapping: &Mapping,
    timing: NetworkTiming,
    tables: &mut Tables,
) -> Function {
    let network = &import.network;
    let used: Vec<(Class, u32)> = mapper.used(mapping).collect();
    let mut writer = ChoiceWriter {
        network,
        sources: sources(import, &used, tables),
        timing,
        out: old.skeleton(Level::Atomic),
        held: vec![None; network.len()],
        names: old.fresh_names(),
    };
    for &(class, form) in &used {
        let name = import.names.get(class.index()).copied();
        let name = name.unwrap_or(Name::NONE);
        writer.class(class, network.form(form), name);
    }
    for (assignment, output) in old.assignments.iter().zip(&import.outputs) {
        let operand = match output {
            None => writer.out.constant(0.0).into(),
            Some(signed) => {
                let naming = writer.naming(signed.class, Name::NONE, assignment.sources);
                writer.true_sign(signed.class, signed.negative, naming)
            }
        };
        writer.out.assignments.push(Assignment {
            operand,
            ..*assignment
        });
    }
    writer.out
}

/// A value made on the way comes from the equations it was made for; it names
/// at most so many.
const MAX_SERVED: usize = 8;

/// The equations each class comes from: its own and, of values that are new,
/// those of the values of the function that they lead to.
fn sources(import: &Import, used: &[(Class, u32)], tables: &mut Tables) -> Vec<SourceSet> {
    let network = &import.network;
    let named = |class: Class| {
        import
            .names
            .get(class.index())
            .is_some_and(|name| !name.is_none())
    };
    let mut served: Vec<SmallVec<[SourceSet; 2]>> = vec![SmallVec::new(); network.len()];
    let mut sources = vec![SourceSet::EMPTY; network.len()];
    // Users come behind their operands.
    for &(class, form) in used.iter().rev() {
        let own = network.origin_of(class).1;
        let mut sets = std::mem::take(&mut served[class.index()]);
        if named(class) {
            sets.clear();
        }
        if !sets.contains(&own) {
            sets.insert(0, own);
        }
        sources[class.index()] = match network.form(form) {
            ChoiceForm::Input(..) | ChoiceForm::Constant(_) => SourceSet::EMPTY,
            _ => tables.sources.union(&sets),
        };
        network.operands(network.form(form), |operand| {
            let list = &mut served[operand.index()];
            for &set in &sets {
                if list.len() < MAX_SERVED && !list.contains(&set) {
                    list.push(set);
                }
            }
        });
    }
    sources
}

/// The names and sources of the operations of one class.
#[derive(Clone, Copy)]
struct ClassNaming {
    last: Name,
    owner: Symbol,
    sources: SourceSet,
}

struct ChoiceWriter<'a> {
    network: &'a ChoiceNetwork,
    /// By class: the equations it comes from or serves.
    sources: Vec<SourceSet>,
    timing: NetworkTiming,
    out: Function,
    held: Vec<Option<Held>>,
    names: FreshNames,
}

impl ChoiceWriter<'_> {
    fn naming(&self, class: Class, last: Name, sources: SourceSet) -> ClassNaming {
        let owner = self.network.origin_of(class).0;
        let own = self.sources[class.index()];
        let sources = if own == SourceSet::EMPTY {
            sources
        } else {
            own
        };
        ClassNaming {
            last,
            owner,
            sources,
        }
    }

    fn held(&self, class: Class) -> Held {
        self.held[class.index()].expect("a class is written before those that use it")
    }

    fn class(&mut self, class: Class, form: ChoiceForm, name: Name) {
        let naming = self.naming(class, name, SourceSet::EMPTY);
        let held = match form {
            ChoiceForm::Input(input, negative) => Held {
                operand: input.into(),
                negative,
                arrival: 0,
            },
            ChoiceForm::Constant(bits) => Held {
                operand: self.out.constant(f64::from_bits(bits)).into(),
                negative: false,
                arrival: 0,
            },
            ChoiceForm::Opaque(index) => self.opaque(index, naming),
            ChoiceForm::Product(..) => {
                let factors = self.network.terms(form);
                let held: Vec<Held> = factors.iter().map(|term| self.held(term.a)).collect();
                let values = factors.iter().map(|term| self.network.value(term.a));
                let value = self.network.images.product(values);
                let negated = value.is_negation_of(&self.network.value(class));
                self.tree(held, true, negated, naming)
            }
            ChoiceForm::Sum(..) => {
                let terms = self.network.terms(form);
                let value = self.network.sum_value(terms);
                let negated = value.is_negation_of(&self.network.value(class));
                let held = terms.iter().map(|&term| self.term(term, naming)).collect();
                self.tree(held, false, negated, naming)
            }
        };
        self.held[class.index()] = Some(held);
    }

    fn opaque(&mut self, index: u32, naming: ClassNaming) -> Held {
        let opaque = self.network.opaques[index as usize];
        let mut operands = [Operand::NONE; Operand::MAX_COUNT];
        let mut arrival = 0;
        for (slot, operand) in operands.iter_mut().zip(opaque.operands) {
            if let Some(signed) = operand {
                let inner = ClassNaming {
                    last: Name::NONE,
                    ..naming
                };
                *slot = self.true_sign(signed.class, signed.negative, inner);
                arrival = arrival.max(self.held(signed.class).arrival);
            }
        }
        let operand = self.push(opaque.operation, operands, naming.last, naming);
        Held {
            operand,
            negative: opaque.negative,
            arrival: arrival + self.timing.weights.of(opaque.operation),
        }
    }

    /// A signed term; products are written.
    fn term(&mut self, term: ProductTerm, naming: ClassNaming) -> Held {
        let a = self.held(term.a);
        if !term.is_product() {
            return Held {
                negative: a.negative ^ term.negative,
                ..a
            };
        }
        let b = self.held(term.b);
        let operand = self.push(Operation::Mul, [a.operand, b.operand], Name::NONE, naming);
        Held {
            operand,
            negative: a.negative ^ b.negative ^ term.negative,
            arrival: a.arrival.max(b.arrival) + self.timing.multiply,
        }
    }

    /// Combines the two earliest first.
    fn tree(
        &mut self,
        leaves: Vec<Held>,
        product: bool,
        negated: bool,
        naming: ClassNaming,
    ) -> Held {
        let weight = match product {
            true => self.timing.multiply,
            false => self.timing.add,
        };
        let arrival = |held: &Held| held.arrival;
        let last = join_earliest(leaves, TieOrder::Made, arrival, |[a, b], last| {
            let name = if last { naming.last } else { Name::NONE };
            let (operation, operands, negative) = match (product, a.negative, b.negative) {
                (true, a_negative, b_negative) => (
                    Operation::Mul,
                    [a.operand, b.operand],
                    a_negative ^ b_negative,
                ),
                (false, false, true) => (Operation::Sub, [a.operand, b.operand], false),
                (false, true, false) => (Operation::Sub, [b.operand, a.operand], false),
                (false, negative, _) => (Operation::Add, [a.operand, b.operand], negative),
            };
            Held {
                operand: self.push(operation, operands, name, naming),
                negative,
                arrival: a.arrival.max(b.arrival) + weight,
            }
        });
        let last = last.expect("a sum or product has operands");
        Held {
            negative: last.negative ^ negated,
            ..last
        }
    }

    fn true_sign(&mut self, class: Class, negative: bool, naming: ClassNaming) -> Operand {
        let held = self.held(class);
        if held.negative == negative {
            return held.operand;
        }
        if let Some(number) = self.out.number(held.operand) {
            return self.out.constant(-number).into();
        }
        let zero = Operand::from(self.out.constant(0.0));
        self.push(Operation::Sub, [zero, held.operand], naming.last, naming)
    }

    fn push<const COUNT: usize>(
        &mut self,
        operation: Operation,
        operands: [Operand; COUNT],
        name: Name,
        naming: ClassNaming,
    ) -> Operand {
        let name = match name.is_none() {
            true => self.names.fresh(naming.owner),
            false => name,
        };
        self.out
            .push(Node {
                name,
                sources: naming.sources,
                operands: Operand::list(operands),
                operation,
            })
            .into()
    }
}
