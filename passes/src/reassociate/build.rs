//! Writing the groups again.

use super::negations::{Negations, Turns};
use super::share::{self, PairCounts};
use super::signs::{NaturalSigns, Wishes};
use crate::sums::fused::turned;
use crate::sums::groups::{GroupFamily, GroupLeaf, GroupReach, OperandGroups};
use crate::sums::writer::{SignedOperand, SumWriter, ValueNaming};
use robovec_analysis::critical_path::{Weights, tails};
use robovec_framework::rewrite::{lay_out, owners};
use robovec_framework::rewrite_limit::RewriteLimit;
use robovec_ir::{
    FreshNames, Function, Level, Name, Node, Operand, Operation, Symbol, Tables, Value,
};
use std::cell::OnceCell;
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

/// Rewrites all groups of a function, with a test before each.
pub(crate) fn reassociate(
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
    natural: NaturalSigns,
    /// The signs that outputs require, before early negations.
    asked: Wishes,
    /// The earliest negation of each group, computed on first use.
    turns: OnceCell<Turns>,
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
        let natural = NaturalSigns::find(function, &groups);
        let asked = Wishes::find(function, &groups, &natural);
        ReassociationPlan {
            function,
            wishes: asked.clone(),
            asked,
            turns: OnceCell::new(),
            natural,
            negations: Negations::default(),
            groups,
            owners: owners(tables, function),
        }
    }

    /// Decides where to negate; see [`super::negations`].
    fn negate(&mut self, weights: &Weights, latest: Option<&[u32]>) {
        let (function, groups, natural) = (self.function, &self.groups, &self.natural);
        let turns = || Turns::find(function, groups, natural, weights);
        self.wishes = self.asked.clone();
        self.negations = Negations::plan(
            (function, groups),
            natural,
            &mut self.wishes,
            || self.turns.get_or_init(turns),
            (weights, latest),
        );
    }
}

/// A term or factor while its group is being combined.
#[derive(Clone, Copy, Debug)]
pub(super) struct GroupTerm {
    pub(super) value: SignedOperand,
    /// Its leaf, for pair counts.
    pub(super) leaf: Option<GroupLeaf>,
}

/// The rank of a pair: its number of requests, and its time.
pub(super) type Score = (u32, Reverse<u32>);

/// Latest times of the groups' results, and the pairs worth sharing.
pub(super) struct Deadlines {
    /// Indexed by old value.
    pub(super) latest: Vec<u32>,
    pub(super) pairs: PairCounts,
}

pub(super) struct TreeBuilder<'p> {
    plan: &'p ReassociationPlan<'p>,
    pub(super) writer: SumWriter,
    pub(super) shape: TreeShape,
    pub(super) deadlines: Option<Deadlines>,
    /// The result is thrown away after its times are known: names, sources
    /// and sharing do not matter.
    pub(super) draft: bool,
    map: Vec<SignedOperand>,
    /// The terms of the group being written; one allocation serves all.
    terms: Vec<GroupTerm>,
}

impl<'p> TreeBuilder<'p> {
    fn new(
        plan: &'p ReassociationPlan<'p>,
        weights: Weights,
        shape: TreeShape,
        deadlines: Option<Deadlines>,
    ) -> TreeBuilder<'p> {
        let draft = shape == TreeShape::Earliest && deadlines.is_none();
        let (old, level) = (plan.function, plan.function.level);
        TreeBuilder {
            plan,
            writer: match shape {
                TreeShape::Earliest if draft => SumWriter::draft(old, level, weights),
                TreeShape::Earliest => SumWriter::new(old, level, weights).sharing(),
                TreeShape::Written | TreeShape::Cascade => SumWriter::new(old, level, weights),
            },
            shape,
            deadlines,
            draft,
            map: Vec::with_capacity(plan.function.nodes().len()),
            terms: Vec::new(),
        }
    }

    fn run(mut self, tables: &mut Tables) -> TreeBuilder<'p> {
        let function = self.plan.function;
        let groups = &self.plan.groups;
        for (root, node) in function.values() {
            if groups.is_absorbed(root) {
                // Never read: its one user is in the same group.
                self.map.push(SignedOperand::NONE);
                continue;
            }
            let result = match GroupFamily::of(node.operation) {
                None => self.other(root, node),
                Some(_) if groups.is_frozen(root) => self.as_it_was(root, node),
                Some(family) => {
                    let mut naming = self.naming(root, node);
                    if !self.draft && !groups.inner(root).is_empty() {
                        let parts = groups.inner(root).iter().map(|&part| function.node(part));
                        let parts = parts.map(|part| (part.name, part.sources));
                        naming = naming.with_parts(parts, tables);
                    }
                    self.group(family, root, groups.leaves(root), &mut naming)
                }
            };
            self.map.push(result);
        }
        let map = &self.map;
        self.writer.outputs(function, tables, |writer, place| {
            writer.translate(function, map, function.assignments[place].operand)
        });
        self
    }

    fn naming(&self, root: Value, node: &Node) -> ValueNaming {
        ValueNaming::new(node.name, self.plan.owners[root.index()], node.sources)
    }

    fn signed(&mut self, operand: Operand) -> SignedOperand {
        self.writer
            .translate(self.plan.function, &self.map, operand)
    }

    /// An operation that is neither a sum nor a product.
    fn other(&mut self, root: Value, node: &Node) -> SignedOperand {
        let [a, b, c] = node.operands.map(|operand| self.signed(operand));
        let mut naming = self.naming(root, node);
        if node.operation.is_fused() {
            let (operation, negative) = turned(node.operation, a.negative ^ b.negative, c.negative);
            let operands = [a.operand, b.operand, c.operand];
            let operand = (self.writer).write(operation, operands, node.name, node.sources);
            return self.writer.signed(operand, negative);
        }
        let (operand, negative) = match node.operation {
            Operation::Copy => return a,
            Operation::Div => (a.operand, a.negative ^ b.negative),
            Operation::Sin => (a.operand, a.negative),
            Operation::Cos => (a.operand, false),
            _ => (self.writer.true_sign(a, &mut naming), false),
        };
        let operands = [operand, b.operand];
        let operand = (self.writer).write(node.operation, operands, node.name, node.sources);
        self.writer.signed(operand, negative)
    }

    /// A sum or product of two operands that must not be rewritten.
    fn as_it_was(&mut self, root: Value, node: &Node) -> SignedOperand {
        let mut naming = self.naming(root, node);
        let operands = node.operands.map(|operand| {
            let value = self.signed(operand);
            self.writer.true_sign(value, &mut naming)
        });
        let operand = (self.writer).write(node.operation, operands, node.name, node.sources);
        self.writer.signed(operand, false)
    }

    fn group(
        &mut self,
        family: GroupFamily,
        root: Value,
        leaves: &[GroupLeaf],
        naming: &mut ValueNaming,
    ) -> SignedOperand {
        let is_product = family == GroupFamily::Product;
        let mut product_negative = false;
        let mut terms = std::mem::take(&mut self.terms);
        let term = |&leaf: &GroupLeaf| {
            let mut value = self.signed(leaf.operand);
            if is_product {
                product_negative ^= value.negative;
                value.negative = false;
            } else {
                value.negative ^= leaf.negative;
            }
            GroupTerm {
                value,
                leaf: Some(leaf),
            }
        };
        terms.clear();
        terms.extend(leaves.iter().map(term));
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
            product_negative ^= is_product;
        }
        let flip = wish == Some(true) && !turned;
        let result = match self.shape {
            TreeShape::Written => self.cascade(family, &terms, flip, naming),
            TreeShape::Cascade => {
                terms.sort_by_key(|term| term.value.arrival);
                self.cascade(family, &terms, flip, naming)
            }
            TreeShape::Earliest => self.earliest(family, root, &mut terms, flip, naming),
        };
        self.terms = terms;
        result.flip(product_negative ^ turned)
    }

    /// The latest time of each old value that does not lengthen the longest
    /// path, and which pairs occur more than once.
    fn deadlines(self) -> Deadlines {
        let tails = tails(&self.writer.out, &self.writer.times.weights);
        let longest = self.writer.times.longest();
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

    fn finish(self, tables: &mut Tables) -> Function {
        let (mut out, mut names) = self.writer.finish(tables);
        if out.level == Level::Equations {
            name_shared(&mut out, tables, &mut names);
            return lay_out(&out);
        }
        out
    }
}

/// At the equations level an unnamed node has exactly one user; those that
/// sharing has given more get names. Nodes without a path to a definition or an
/// output are left out when the function is laid out: there is no name to
/// derive theirs from.
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
