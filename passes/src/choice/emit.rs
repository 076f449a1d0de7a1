//! Writing the chosen forms as a function.

use super::forms::ChoiceForm;
use super::import::Import;
use super::map::{Mapper, Mapping};
use super::network::ChoiceNetwork;
use super::term::{Class, ProductTerm, SignedClass};
use crate::sums::earliest::TieOrder;
use crate::sums::groups::GroupFamily;
use crate::sums::writer::{SignedOperand, SumWriter, ValueNaming};
use robovec_analysis::critical_path::Weights;
use robovec_ir::{Assignment, Function, Level, Name, Operand, SourceSet, Tables};
use smallvec::SmallVec;

/// Writes the function a mapping represents, at the atomic level, with the
/// signature and the names of the function that was read.
pub(crate) fn emit(
    old: &Function,
    import: &Import,
    mapper: &Mapper<'_>,
    mapping: &Mapping,
    timing: Weights,
    tables: &mut Tables,
) -> Function {
    let network = &import.network;
    let used: Vec<(Class, u32)> = mapper.used(mapping).collect();
    let mut writer = ChoiceWriter {
        network,
        sources: sources(import, &used, tables),
        writer: SumWriter::new(old, Level::Atomic, timing),
        held: vec![None; network.len()],
    };
    for &(class, form) in &used {
        let name = import.names.get(class.index()).copied();
        let name = name.unwrap_or(Name::NONE);
        writer.class(class, form, name);
    }
    for (assignment, output) in old.assignments.iter().zip(&import.outputs) {
        let operand = match output {
            None => writer.writer.number(0.0).operand,
            Some(signed) => {
                let mut naming = writer.naming(signed.class, Name::NONE, assignment.sources);
                writer.true_sign(*signed, &mut naming)
            }
        };
        writer.writer.out.assignments.push(Assignment {
            operand,
            ..*assignment
        });
    }
    writer.writer.finish(tables).0
}

/// A new intermediate value comes from the equations for which it was made; it
/// names at most this number of them.
const MAX_SERVED: usize = 8;

/// The equations of each class: its own and, for new values, those of the
/// values of the function that depend on them.
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
        network.operands(form, |operand| {
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

struct ChoiceWriter<'a> {
    network: &'a ChoiceNetwork,
    /// By class: the equations it comes from or serves.
    sources: Vec<SourceSet>,
    writer: SumWriter,
    held: Vec<Option<SignedOperand>>,
}

impl ChoiceWriter<'_> {
    fn naming(&self, class: Class, last: Name, sources: SourceSet) -> ValueNaming {
        let owner = self.network.origin_of(class).0;
        let own = self.sources[class.index()];
        let sources = if own == SourceSet::EMPTY {
            sources
        } else {
            own
        };
        ValueNaming::new(last, owner, sources)
    }

    fn held(&self, class: Class) -> SignedOperand {
        self.held[class.index()].expect("a class is written before those that use it")
    }

    fn class(&mut self, class: Class, form: u32, name: Name) {
        let mut naming = self.naming(class, name, SourceSet::EMPTY);
        let network = self.network;
        let negated = network.is_negated(form);
        let held = match network.form(form) {
            ChoiceForm::Input(input, negative) => self.writer.signed(input.into(), negative),
            ChoiceForm::Constant(bits) => self.writer.number(f64::from_bits(bits)),
            ChoiceForm::Opaque(index) => self.opaque(index, &mut naming),
            ChoiceForm::Product(factors) => {
                let held = factors.iter().map(|term| self.held(term.a)).collect();
                self.tree(GroupFamily::Product, held, &mut naming)
                    .flip(negated)
            }
            ChoiceForm::Sum(terms) => {
                let terms = terms.iter();
                let held = terms.map(|&term| self.term(term, &mut naming)).collect();
                self.tree(GroupFamily::Sum, held, &mut naming).flip(negated)
            }
        };
        self.held[class.index()] = Some(held);
    }

    fn opaque(&mut self, index: u32, naming: &mut ValueNaming) -> SignedOperand {
        let opaque = self.network.opaques[index as usize];
        let mut operands = [Operand::NONE; Operand::MAX_COUNT];
        let mut arrival = 0;
        for (slot, operand) in operands.iter_mut().zip(opaque.operands) {
            if let Some(signed) = operand {
                *slot = self.true_sign(signed, naming);
                arrival = arrival.max(self.held(signed.class).arrival);
            }
        }
        // As the network counts times: signs cost none.
        let weight = self.writer.times.weights.of(opaque.operation);
        SignedOperand {
            operand: self.writer.push(opaque.operation, operands, true, naming),
            negative: opaque.negative,
            arrival: arrival + weight,
        }
    }

    fn term(&mut self, term: ProductTerm, naming: &mut ValueNaming) -> SignedOperand {
        let a = self.held(term.a).flip(term.negative());
        if !term.is_product() {
            return a;
        }
        let pair = [a, self.held(term.b())];
        self.writer
            .join(GroupFamily::Product, pair, (false, false), naming)
    }

    /// Combines the two earliest first.
    fn tree(
        &mut self,
        family: GroupFamily,
        terms: Vec<SignedOperand>,
        naming: &mut ValueNaming,
    ) -> SignedOperand {
        self.writer
            .tree(family, terms, (TieOrder::Made, false), naming)
    }

    /// Every place that needs a negation has its own; equal ones are merged
    /// later, and then come from all the equations they serve.
    fn true_sign(&mut self, signed: SignedClass, naming: &mut ValueNaming) -> Operand {
        let held = self.held(signed.class).flip(signed.negative);
        self.writer.forget_negations();
        self.writer.true_sign(held, naming)
    }
}
