//! Functions as a network of choices: of one function one form per class.

use super::network::{ChoiceNetwork, Opaque, RANK_STEP};
use super::order::common_levels;
use super::term::{Class, ProductTerm, SignedClass};
use super::timing::{Arrivals, NEVER};
use crate::sums::groups::{GroupFamily, GroupLeaf, GroupReach, OperandGroups, single_product};
use robovec_analysis::critical_path::{Weights, arrivals};
use robovec_framework::fingerprint::{Fingerprint, Images};
use robovec_framework::pass::Context;
use robovec_framework::rewrite::owners;
use robovec_ir::{Function, Name, Operand, OperandKind, SourceSet, Value};

/// A function read into a network.
pub(crate) struct Import {
    pub(crate) network: ChoiceNetwork,
    /// The class that each assignment is set to; `None` for zero.
    pub(crate) outputs: Vec<Option<SignedClass>>,
    /// The classes of sums and products of the function, in program order,
    /// each once; of several functions those of one after the other.
    pub(crate) classes: Vec<Class>,
    /// The name of the value a class was made for.
    pub(crate) names: Vec<Name>,
    /// Earliest arrivals of the function as it is read.
    pub(crate) arrivals: Arrivals,
}

impl Import {
    /// Counts of the network for statistics.
    pub(crate) fn counts(&self) -> [(&'static str, u64); 2] {
        [
            ("values considered", self.network.len() as u64),
            ("forms considered", self.network.form_count() as u64),
        ]
    }

    /// Numbers the classes in order of rank; none can be added any more.
    pub(crate) fn sort(&mut self) {
        let places = self.network.sort();
        for output in self.outputs.iter_mut().flatten() {
            output.class = places[output.class.index()];
        }
        let mut names = vec![Name::NONE; places.len()];
        for (name, place) in self.names.iter().zip(&places) {
            names[place.index()] = *name;
        }
        self.names = names;
        // They are only needed to compose forms.
        self.classes = Vec::new();
        self.arrivals = Arrivals::default();
    }
}

/// Reads functions at the atomic level that compute the same outputs, all of
/// them into one network: a value that several compute gets a form from each.
/// `None`, with a remark, when some value is undefined (a division by a value
/// that is always zero), so that nothing can be proved about it.
///
/// A form of a later function is left out where it would close a cycle with
/// those of earlier ones; the first function is imported completely.
pub(crate) fn import(
    functions: &[&Function],
    context: &mut Context<'_>,
    timing: Weights,
    images: Images,
) -> Option<Import> {
    let values = functions.iter();
    let values = values.map(|function| defined_values(function, &images));
    let Some(values) = values.collect::<Option<Vec<_>>>() else {
        let reason = "a value is undefined everywhere; nothing is changed";
        context.remark(reason.to_owned());
        return None;
    };
    let tables = &mut *context.tables;
    let levels = match functions {
        [only] => vec![arrivals(only, &Weights::operations())],
        _ => common_levels(functions, &values, &images),
    };
    let mut merges = Vec::new();
    let mut import = Import {
        network: ChoiceNetwork::new(images),
        outputs: Vec::new(),
        classes: Vec::new(),
        names: Vec::new(),
        arrivals: Arrivals::default(),
    };
    let operations = functions.iter().map(|function| function.nodes().len());
    import.network.reserve(operations.sum());
    for (at, (values, levels)) in values.into_iter().zip(levels).enumerate() {
        let function = functions[at];
        let groups = OperandGroups::find(function, GroupReach::Maximal);
        let mut reader = ChoiceImporter {
            function,
            levels,
            inlined: inlined(function, &groups),
            groups,
            values,
            timing,
            map: Vec::with_capacity(function.nodes().len()),
            products: Vec::new(),
            merges: &mut merges,
            is_first: at == 0,
            import: &mut import,
        };
        reader.read(&owners(tables, function));
    }
    merges.sort_unstable();
    merges.dedup();
    for group in merges.chunk_by(|a, b| a.0 == b.0) {
        let class = group[0].0;
        let mut sets = vec![import.network.origin_of(class).1];
        sets.extend(group.iter().map(|(_, sources)| *sources));
        let union = tables.sources.union(&sets);
        import.network.set_sources(class, union);
    }
    Some(import)
}

/// The values of a function, unless one is undefined or a constant is not
/// finite.
fn defined_values(function: &Function, images: &Images) -> Option<Vec<Fingerprint>> {
    let values = images.values(function);
    let undefined = |constant: &f64| !constant.is_finite();
    let is_defined = !values.iter().any(Fingerprint::is_undefined)
        && !function.constants().iter().any(undefined);
    is_defined.then_some(values)
}

struct ChoiceImporter<'a> {
    function: &'a Function,
    /// Operations on the longest chain to each value: the rank of its class.
    levels: Vec<u32>,
    groups: OperandGroups,
    /// Products that one sum alone uses: they become terms of that sum.
    inlined: Vec<bool>,
    values: Vec<Fingerprint>,
    timing: Weights,
    /// The classes that old values have become; `None` for zero.
    map: Vec<Option<SignedClass>>,
    /// Products that became terms of the sum being read.
    products: Vec<Value>,
    /// Classes and equations they also come from.
    merges: &'a mut Vec<(Class, SourceSet)>,
    /// True for the first function of a network.
    is_first: bool,
    import: &'a mut Import,
}

impl ChoiceImporter<'_> {
    fn read(&mut self, owners: &[robovec_ir::Symbol]) {
        let function = self.function;
        for (value, node) in function.values() {
            self.import.network.origin = (owners[value.index()], node.sources);
            self.node(value);
        }
        for assignment in &function.assignments {
            self.import.network.origin = (robovec_ir::Symbol(0), assignment.sources);
            let output = self.operand(assignment.operand);
            if self.is_first {
                self.import.outputs.push(output);
            }
        }
    }

    fn node(&mut self, value: Value) {
        if self.groups.is_absorbed(value) || self.inlined[value.index()] {
            self.map.push(None);
            return;
        }
        let fingerprint = self.values[value.index()];
        if fingerprint.is_zero() {
            self.map.push(None);
            return;
        }
        let rank = (u64::from(self.levels[value.index()]) + 1) * RANK_STEP;
        let known = self.import.network.find(fingerprint);
        let signed = match known {
            Some(signed) if self.is_first => signed,
            _ => self.define(value, fingerprint, rank),
        };
        self.note_sources(signed.class, value);
        self.map.push(Some(signed));
    }

    /// Notes that a class also comes from the equations of a value: of one
    /// merged into it, or absorbed.
    fn note_sources(&mut self, class: Class, value: Value) {
        let own = self.import.network.origin_of(class).1;
        let function = self.function;
        let inner = self.groups.inner(value).iter();
        for sources in inner
            .map(|&inner| function.node(inner).sources)
            .chain([function.node(value).sources])
        {
            if sources != own {
                self.merges.push((class, sources));
            }
        }
    }

    fn define(&mut self, value: Value, fingerprint: Fingerprint, rank: u64) -> SignedClass {
        let node = self.function.node(value);
        match GroupFamily::of(node.operation) {
            Some(GroupFamily::Sum) => {
                self.products.clear();
                let terms = self.terms(value);
                let used = terms.iter().flat_map(|term| [term.a, term.b()]);
                let rank = self.above(rank, used);
                let signed = self.class(fingerprint, rank, node.name);
                for product in std::mem::take(&mut self.products) {
                    self.note_sources(signed.class, product);
                }
                let mut terms = terms;
                let network = &mut self.import.network;
                network.tidy(&mut terms);
                let value = network.sum_value(&terms);
                let negated = value.is_negation_of(&network.value(signed.class));
                network.add_sum(signed.class, &mut terms, negated);
                self.settle(signed.class, true);
                signed
            }
            Some(GroupFamily::Product) => {
                let factors: Vec<GroupLeaf> = self.groups.leaves(value).to_vec();
                let mut classes: Vec<Class> = factors
                    .iter()
                    .filter_map(|leaf| self.operand(leaf.operand))
                    .map(|factor| factor.class)
                    .filter(|&class| class != Class::ONE)
                    .collect();
                let rank = self.above(rank, classes.iter().copied());
                let signed = self.class(fingerprint, rank, node.name);
                let network = &mut self.import.network;
                let value = network.product_value(&classes);
                let negated = value.is_negation_of(&network.value(signed.class));
                network.add_product(signed.class, &mut classes, negated);
                self.settle(signed.class, true);
                signed
            }
            None => {
                let mut operands = [None; Operand::MAX_COUNT];
                for (slot, &operand) in operands.iter_mut().zip(node.operands()) {
                    *slot = Some(self.operand_or_zero(operand));
                }
                let used = operands.iter().flatten().map(|operand| operand.class);
                let rank = self.above(rank, used);
                let signed = self.class(fingerprint, rank, node.name);
                let operation = node.operation;
                self.import.network.add_opaque(
                    signed.class,
                    Opaque {
                        operation,
                        operands,
                        negative: signed.negative,
                    },
                );
                self.settle(signed.class, false);
                signed
            }
        }
    }

    /// A rank above those of the classes used. That of a value's level is not
    /// always: a value merged with an equal one may be deeper.
    fn above(&self, rank: u64, used: impl Iterator<Item = Class>) -> u64 {
        let ranks = used.map(|class| self.import.network.rank(class) + 1);
        ranks.fold(rank.max(1), u64::max)
    }

    fn class(&mut self, fingerprint: Fingerprint, rank: u64, name: Name) -> SignedClass {
        let signed = self.import.network.class(fingerprint, rank);
        let index = signed.class.index();
        if self.import.names.len() <= index {
            self.import.names.resize(index + 1, Name::NONE);
        }
        // Later functions have other values of the same names.
        if self.is_first {
            self.import.names[index] = name;
        }
        signed
    }

    /// Notes a class and its arrival after its form is known.
    fn settle(&mut self, class: Class, listed: bool) {
        if self.import.arrivals.of(class) != NEVER {
            return;
        }
        if listed {
            self.import.classes.push(class);
        }
        self.time(class);
    }

    /// Notes when a class is available by the form it was made with.
    fn time(&mut self, class: Class) {
        let Import {
            network, arrivals, ..
        } = &mut *self.import;
        if let Some(form) = network.first_form(class) {
            arrivals.take(network, &self.timing, class, form);
        }
    }

    fn terms(&mut self, root: Value) -> Vec<ProductTerm> {
        let leaves: Vec<GroupLeaf> = self.groups.leaves(root).to_vec();
        let mut terms = Vec::with_capacity(leaves.len());
        for leaf in leaves {
            let inline = leaf.operand.value();
            let inline = inline.filter(|value| self.inlined[value.index()]);
            self.products.extend(inline);
            let term = match inline {
                Some(product) => self.product_term(product),
                None => self
                    .operand(leaf.operand)
                    .map(|signed| ProductTerm::new(signed.class, Class::ONE, signed.negative)),
            };
            terms.extend(term.map(|term| term.opposite_if(leaf.negative)));
        }
        terms
    }

    /// A product as the latest factor times the product of the others.
    fn product_term(&mut self, product: Value) -> Option<ProductTerm> {
        let factors: Vec<GroupLeaf> = self.groups.leaves(product).to_vec();
        let mut classes: Vec<Class> = Vec::with_capacity(factors.len());
        let mut negative = false;
        for factor in factors {
            let signed = self.operand(factor.operand)?;
            negative ^= signed.negative;
            if signed.class != Class::ONE {
                classes.push(signed.class);
            }
        }
        classes.sort_by_key(|&class| (self.import.arrivals.of(class), class));
        let last = classes.pop().unwrap_or(Class::ONE);
        let rest = self.import.network.product(&mut classes);
        self.time(rest.class);
        Some(ProductTerm::new(rest.class, last, negative ^ rest.negative))
    }

    fn operand_or_zero(&mut self, operand: Operand) -> SignedClass {
        match self.operand(operand) {
            Some(signed) => signed,
            None => self.import.network.constant(0.0),
        }
    }

    fn operand(&mut self, operand: Operand) -> Option<SignedClass> {
        let saved = self.import.network.origin;
        self.import.network.origin = (saved.0, SourceSet::EMPTY);
        let signed = match operand.kind() {
            OperandKind::Value(value) => self.map[value.index()],
            OperandKind::None => None,
            OperandKind::Input(input) => {
                let value = self.import.network.values.images.input(input);
                Some(self.import.network.input(input, value))
            }
            OperandKind::Constant(constant) => {
                let number = self.function.constant_number(constant);
                (number != 0.0).then(|| self.import.network.constant(number))
            }
        };
        self.import.network.origin = saved;
        if let Some(signed) = signed.filter(|_| operand.value().is_none()) {
            self.import.arrivals.set(signed.class, 0);
        }
        signed
    }
}

/// For each value whether it is a product that only one sum uses.
fn inlined(function: &Function, groups: &OperandGroups) -> Vec<bool> {
    let uses = function.use_counts();
    let mut inlined = vec![false; function.nodes().len()];
    let family = |value: Value| GroupFamily::of(function.node(value).operation);
    for (value, _) in function.values() {
        if groups.is_absorbed(value) || family(value) != Some(GroupFamily::Sum) {
            continue;
        }
        for leaf in groups.leaves(value) {
            if let Some(product) = single_product(function, &uses, leaf.operand) {
                inlined[product.index()] = true;
            }
        }
    }
    inlined
}
