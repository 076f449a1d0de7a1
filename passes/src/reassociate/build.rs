//! Writing the groups anew.

use super::negations::Negations;
use super::share::{self, PairCounts};
use super::signs::Wishes;
use crate::cse::{Key, KnownValues, SourceMerges};
use crate::sums::groups::{GroupFamily, GroupLeaf, GroupReach, OperandGroups};
use hashbrown::HashMap;
use robovec_analysis::critical_path::{Weights, tails};
use robovec_framework::rewrite::{lay_out, output_symbol, owners};
use robovec_framework::rewrite_limit::RewriteLimit;
use robovec_ir::{
    FreshNames, Function, Level, Name, Node, Operand, OperandKind, Operation, SourceSet, Symbol,
    Tables, Value,
};
use rustc_hash::FxBuildHasher;
use std::cmp::Reverse;

/// The shape of the tree a group becomes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum TreeShape {
    /// Left to right as written.
    Written,
    /// One operand after the other, the earliest first.
    Cascade,
    /// The two earliest operands first; equal pairs are shared.
    Earliest,
}

/// Rewrites all groups of a function.
#[cfg(test)]
pub(crate) fn reassociate(
    function: &Function,
    tables: &mut Tables,
    weights: &Weights,
    reach: GroupReach,
    shape: TreeShape,
) -> Function {
    let rewrites = RewriteLimit::default();
    reassociate_asking(function, tables, weights, reach, shape, &rewrites)
}

/// As [`reassociate`], asking before each group.
pub(crate) fn reassociate_asking(
    function: &Function,
    tables: &mut Tables,
    weights: &Weights,
    reach: GroupReach,
    shape: TreeShape,
    rewrites: &RewriteLimit,
) -> Function {
    let mut plan = ReassociationPlan::new(function, tables, reach, rewrites);
    if shape == TreeShape::Earliest {
        plan.negate(weights, None);
    }
    let first = TreeBuilder::new(&plan, *weights, shape, None).run(tables);
    if shape != TreeShape::Earliest {
        return first.finish(tables);
    }
    // The first round tells how late each group may be without lengthening
    // the longest path; the second uses that freedom to share more pairs.
    let deadlines = first.deadlines();
    plan.negate(weights, Some(&deadlines.latest));
    TreeBuilder::new(&plan, *weights, shape, Some(deadlines))
        .run(tables)
        .finish(tables)
}

/// The facts about the function read, collected before anything is written.
struct ReassociationPlan<'a> {
    function: &'a Function,
    groups: OperandGroups,
    wishes: Wishes,
    negations: Negations,
    owners: Vec<Symbol>,
}

impl<'a> ReassociationPlan<'a> {
    fn new(
        function: &'a Function,
        tables: &mut Tables,
        reach: GroupReach,
        rewrites: &RewriteLimit,
    ) -> ReassociationPlan<'a> {
        let groups = OperandGroups::find_allowed(function, reach, rewrites);
        let wishes = Wishes::find(function, &groups);
        ReassociationPlan {
            function,
            wishes,
            negations: Negations::default(),
            groups,
            owners: owners(tables, function),
        }
    }

    /// Decides where to negate; see [`super::negations`].
    fn negate(&mut self, weights: &Weights, latest: Option<&[u32]>) {
        self.wishes = Wishes::find(self.function, &self.groups);
        self.negations = Negations::plan(
            self.function,
            &self.groups,
            &mut self.wishes,
            weights,
            latest,
        );
    }
}

/// The operand that an old value has become, perhaps with the wrong sign.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct SignedOperand {
    pub(super) operand: Operand,
    pub(super) negative: bool,
}

/// A term or factor while its group is being combined.
#[derive(Clone, Copy, Debug)]
pub(super) struct GroupTerm {
    pub(super) arrival: u32,
    pub(super) value: SignedOperand,
    /// The leaf it still is, for pair counts.
    pub(super) leaf: Option<GroupLeaf>,
}

/// The rank of a pair: how often it is wanted, and how early it is ready.
pub(super) type Score = (u32, Reverse<u32>);

/// Latest times of the groups' results, and the pairs worth sharing.
pub(super) struct Deadlines {
    /// Indexed by old value.
    pub(super) latest: Vec<u32>,
    pub(super) pairs: PairCounts,
}

pub(super) struct TreeBuilder<'p> {
    plan: &'p ReassociationPlan<'p>,
    pub(super) weights: Weights,
    pub(super) shape: TreeShape,
    pub(super) deadlines: Option<Deadlines>,
    pub(super) out: Function,
    pub(super) known: KnownValues,
    /// The result is thrown away after its times are known: names, sources
    /// and sharing do not matter.
    pub(super) draft: bool,
    negated: HashMap<Operand, Operand, FxBuildHasher>,
    pub(super) arrivals: Vec<u32>,
    map: Vec<SignedOperand>,
    names: FreshNames,
    merges: SourceMerges,
}

/// Names and sources for the operations of one group.
pub(super) struct GroupNaming {
    /// For the last operation.
    pub(super) root: Name,
    /// Of absorbed operations, to be used again; last first.
    spare: Vec<Name>,
    owner: Symbol,
    sources: SourceSet,
}

impl<'p> TreeBuilder<'p> {
    fn new(
        plan: &'p ReassociationPlan<'p>,
        weights: Weights,
        shape: TreeShape,
        deadlines: Option<Deadlines>,
    ) -> TreeBuilder<'p> {
        let count = plan.function.nodes().len();
        let mut out = plan.function.skeleton(plan.function.level);
        out.reserve(count);
        let draft = shape == TreeShape::Earliest && deadlines.is_none();
        let capacity = if shape == TreeShape::Earliest && !draft {
            count
        } else {
            0
        };
        TreeBuilder {
            plan,
            weights,
            shape,
            deadlines,
            out,
            known: KnownValues::with_capacity(capacity),
            draft,
            negated: HashMap::default(),
            arrivals: Vec::with_capacity(count),
            map: Vec::with_capacity(count),
            names: plan.function.fresh_names(),
            merges: SourceMerges::default(),
        }
    }

    fn run(mut self, tables: &mut Tables) -> TreeBuilder<'p> {
        let function = self.plan.function;
        let groups = &self.plan.groups;
        for (root, node) in function.values() {
            if groups.is_absorbed(root) {
                // Never read: its one user is in the same group.
                self.map.push(SignedOperand {
                    operand: Operand::NONE,
                    negative: false,
                });
                continue;
            }
            let result = match GroupFamily::of(node.operation) {
                None => self.other(root, node),
                Some(_) if groups.is_frozen(root) => self.as_it_was(root, node),
                Some(family) => {
                    let mut naming = self.naming(root, node, groups.inner(root), tables);
                    self.group(family, root, groups.leaves(root), &mut naming)
                }
            };
            self.map.push(result);
        }
        self.outputs(tables);
        self
    }

    fn naming(
        &self,
        root: Value,
        node: &Node,
        inner: &[Value],
        tables: &mut Tables,
    ) -> GroupNaming {
        let function = self.plan.function;
        let mut naming = GroupNaming {
            root: node.name,
            spare: Vec::new(),
            owner: self.plan.owners[root.index()],
            sources: node.sources,
        };
        if self.draft || inner.is_empty() {
            return naming;
        }
        let mut sets: Vec<SourceSet> = vec![node.sources];
        for &value in inner {
            let absorbed = function.node(value);
            if !sets.contains(&absorbed.sources) || sets.len() > 8 {
                sets.push(absorbed.sources);
            }
            if !absorbed.name.is_none() && absorbed.name.suffix > 0 {
                naming.spare.push(absorbed.name);
            }
        }
        naming.spare.sort_unstable_by_key(|&name| Reverse(name));
        naming.sources = tables.sources.union(&sets);
        naming
    }

    fn signed(&mut self, operand: Operand) -> SignedOperand {
        match operand.kind() {
            OperandKind::Value(value) => self.map[value.index()],
            OperandKind::Constant(constant) => {
                let number = self.plan.function.constant_number(constant);
                SignedOperand {
                    operand: self.out.constant(number).into(),
                    negative: false,
                }
            }
            OperandKind::Input(_) | OperandKind::None => SignedOperand {
                operand,
                negative: false,
            },
        }
    }

    pub(super) fn arrival(&self, operand: Operand) -> u32 {
        operand
            .value()
            .map_or(0, |value| self.arrivals[value.index()])
    }

    /// An operation that is neither a sum nor a product.
    fn other(&mut self, root: Value, node: &Node) -> SignedOperand {
        let [a, b, c] = node.operands.map(|operand| self.signed(operand));
        let mut naming = GroupNaming {
            root: node.name,
            spare: Vec::new(),
            owner: self.plan.owners[root.index()],
            sources: node.sources,
        };
        if node.operation.is_fused() {
            let (operation, negative) = fused(node.operation, a.negative ^ b.negative, c.negative);
            let operands = [a.operand, b.operand, c.operand];
            let operand = self.emit(operation, operands, node.name, &mut naming);
            return SignedOperand { operand, negative };
        }
        let (operand, negative) = match node.operation {
            Operation::Copy => return a,
            Operation::Div => (a.operand, a.negative ^ b.negative),
            Operation::Sin => (a.operand, a.negative),
            Operation::Cos => (a.operand, false),
            _ => (self.true_sign(a, &mut naming), false),
        };
        let operand = self.emit(node.operation, [operand, b.operand], node.name, &mut naming);
        SignedOperand { operand, negative }
    }

    /// A sum or product of two operands that must not be rewritten.
    fn as_it_was(&mut self, root: Value, node: &Node) -> SignedOperand {
        let mut naming = GroupNaming {
            root: node.name,
            spare: Vec::new(),
            owner: self.plan.owners[root.index()],
            sources: node.sources,
        };
        let operands = node.operands.map(|operand| {
            let value = self.signed(operand);
            self.true_sign(value, &mut naming)
        });
        SignedOperand {
            operand: self.emit(node.operation, operands, node.name, &mut naming),
            negative: false,
        }
    }

    /// Appends an operation, or finds an equal one.
    pub(super) fn emit<const COUNT: usize>(
        &mut self,
        operation: Operation,
        operands: [Operand; COUNT],
        name: Name,
        naming: &mut GroupNaming,
    ) -> Operand {
        let sharing = self.shape == TreeShape::Earliest && !self.draft;
        if sharing && let Some(same) = self.known.find(&self.out, Key::new(operation, operands)) {
            self.merges.add(same, naming.sources);
            return same.into();
        }
        let ready = operands.iter().map(|&operand| self.arrival(operand));
        let ready = ready.max().unwrap_or(0);
        let value = self.out.push(Node {
            name,
            sources: naming.sources,
            operands: Operand::list(operands),
            operation,
        });
        self.arrivals.push(ready + self.weights.of(operation));
        if sharing {
            self.known.insert(&self.out, value);
        }
        value.into()
    }

    /// The operand with its true sign; costs `0 - x` when it is stored with
    /// the other one, once per operand.
    pub(super) fn true_sign(&mut self, value: SignedOperand, naming: &mut GroupNaming) -> Operand {
        if !value.negative {
            return value.operand;
        }
        if let Some(number) = self.out.number(value.operand) {
            return self.out.constant(-number).into();
        }
        if let Some(&known) = self.negated.get(&value.operand) {
            return known;
        }
        let name = self.inner_name(naming);
        let zero = Operand::from(self.out.constant(0.0));
        let (operation, operands) = match self.out.level {
            Level::Equations => (Operation::Neg, [value.operand, Operand::NONE]),
            _ => (Operation::Sub, [zero, value.operand]),
        };
        let negated = self.emit(operation, operands, name, naming);
        self.negated.insert(value.operand, negated);
        negated
    }

    pub(super) fn inner_name(&mut self, naming: &mut GroupNaming) -> Name {
        if self.draft || self.out.level == Level::Equations {
            return Name::NONE;
        }
        match naming.spare.pop() {
            Some(name) => name,
            None => self.names.fresh(naming.owner),
        }
    }

    fn group(
        &mut self,
        family: GroupFamily,
        root: Value,
        leaves: &[GroupLeaf],
        naming: &mut GroupNaming,
    ) -> SignedOperand {
        let mut terms: Vec<GroupTerm> = Vec::with_capacity(leaves.len());
        let mut product_negative = false;
        for &leaf in leaves {
            let mut value = self.signed(leaf.operand);
            if family == GroupFamily::Product {
                product_negative ^= value.negative;
                value.negative = false;
            } else {
                value.negative ^= leaf.negative;
            }
            terms.push(GroupTerm {
                arrival: self.arrival(value.operand),
                value,
                leaf: Some(leaf),
            });
        }
        let wish = self.plan.wishes.of(root);
        // A sum stored with the other sign is the sum of its terms with the
        // other signs; one that is added makes it one that needs no minus.
        let turned =
            self.shape == TreeShape::Earliest && family == GroupFamily::Sum && wish == Some(true);
        for term in terms.iter_mut().filter(|_| turned) {
            term.value.negative ^= true;
        }
        if let Some(leaf) = self.plan.negations.leaf(root) {
            self.negate_early(family, &mut terms[leaf as usize], naming);
            product_negative ^= family == GroupFamily::Product;
        }
        let flip = wish == Some(true) && !turned;
        let result = match self.shape {
            TreeShape::Written => self.cascade(family, &terms, flip, naming),
            TreeShape::Cascade => {
                terms.sort_by_key(|term| term.arrival);
                self.cascade(family, &terms, flip, naming)
            }
            TreeShape::Earliest => self.earliest(family, root, terms, flip, naming),
        };
        SignedOperand {
            negative: result.negative ^ product_negative ^ turned,
            ..result
        }
    }

    fn outputs(&mut self, tables: &mut Tables) {
        let function = self.plan.function;
        let mut assignments = function.assignments.clone();
        for assignment in &mut assignments {
            let value = self.signed(assignment.operand);
            let owner = if value.negative {
                output_symbol(tables, function, assignment.output)
            } else {
                Symbol(u32::MAX)
            };
            let mut naming = GroupNaming {
                root: Name::NONE,
                spare: Vec::new(),
                owner,
                sources: assignment.sources,
            };
            assignment.operand = self.true_sign(value, &mut naming);
        }
        self.out.assignments = assignments;
    }

    /// The latest time of each old value that does not lengthen the longest
    /// path, and which pairs occur more than once.
    fn deadlines(self) -> Deadlines {
        let tails = tails(&self.out, &self.weights);
        let longest = self.arrivals.iter().copied().max().unwrap_or(0);
        let latest = self
            .map
            .iter()
            .map(|signed| match signed.operand.value() {
                Some(value) => longest - tails[value.index()],
                None => 0,
            })
            .collect();
        let function = self.plan.function;
        let groups = &self.plan.groups;
        let count = function
            .values()
            .map(|(root, _)| share::pairs_of(groups.leaves(root).len()))
            .sum();
        let mut pairs = PairCounts::with_capacity(count);
        for (root, node) in function.values() {
            if let Some(family) = GroupFamily::of(node.operation) {
                pairs.add(family, groups.leaves(root));
            }
        }
        Deadlines { latest, pairs }
    }

    fn finish(mut self, tables: &mut Tables) -> Function {
        self.merges.apply(&mut self.out, tables);
        if self.out.level == Level::Equations {
            name_shared(&mut self.out, tables, &mut self.names);
            return lay_out(&self.out);
        }
        self.out
    }
}

/// The fused operation whose product and addend change sign where said, and
/// whether its result is stored negated. Signs cost nothing: rounding to
/// nearest is symmetric.
fn fused(operation: Operation, product: bool, addend: bool) -> (Operation, bool) {
    let product = product ^ (operation == Operation::Fnma);
    let addend = addend ^ (operation == Operation::Fms);
    match (product, addend) {
        (false, false) => (Operation::Fma, false),
        (false, true) => (Operation::Fms, false),
        (true, false) => (Operation::Fnma, false),
        (true, true) => (Operation::Fma, true),
    }
}

/// At the equations level an unnamed node has exactly one user; those that
/// sharing has given more get names. Those that no definition and no output
/// depends on are left out when the function is laid out, whatever uses them:
/// there is no name to derive theirs from.
fn name_shared(function: &mut Function, tables: &mut Tables, names: &mut FreshNames) {
    let owners = owners(tables, function);
    for (index, uses) in function.use_counts().into_iter().enumerate() {
        let value = Value(index as u32);
        let belongs = owners[index] != Name::NONE.base;
        if function.node(value).name.is_none() && uses > 1 && belongs {
            function.node_mut(value).name = names.fresh(owners[index]);
        }
    }
}
