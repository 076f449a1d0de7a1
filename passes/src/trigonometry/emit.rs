//! Writing recipes into a function.

use super::ranges::Angles;
use super::recipe::{Recipe, place};
use robovec_analysis::slice::slice;
use robovec_framework::pass::Context;
use robovec_framework::rewrite::{Rewriter, lay_out, owners};
use robovec_ir::{
    FreshNames, Function, Level, Name, Node, Operand, Operation, SourceSet, Symbol, Value,
};
use robovec_num::trigonometry::Circular;
use std::collections::BTreeMap;

/// The treatment of one angle.
pub(super) enum Treatment {
    /// No recipe: its sines and cosines stay.
    Left,
    /// It is a number, and so are its sine and cosine.
    Known([f64; 2]),
    /// They are computed; the number is a place in the list of recipes.
    Computed(usize),
}

/// The state of one angle while the function is written.
struct AngleState {
    /// The angle's own operand, of the first sine or cosine met.
    operand: Operand,
    /// The operand that each node of the recipe has become.
    written: Vec<Operand>,
    /// The equations of all its sines and cosines.
    sources: SourceSet,
    /// The numbers of times that its sine and its cosine are written.
    copies: [u32; 2],
}

/// The function of a node that is a sine or a cosine.
pub(super) fn circular(node: &Node) -> Option<Circular> {
    match node.operation {
        Operation::Sin => Some(Circular::Sine),
        Operation::Cos => Some(Circular::Cosine),
        _ => None,
    }
}

pub(super) struct Emitter<'a> {
    rewriter: Rewriter<'a>,
    names: FreshNames,
    owners: Vec<Symbol>,
    angles: BTreeMap<u64, AngleState>,
    recipes: &'a [Recipe],
    /// Sines and cosines replaced.
    replaced: u64,
}

impl<'a> Emitter<'a> {
    /// Replaces the sines and cosines whose angles have a recipe, and returns
    /// their number.
    pub(super) fn run(
        function: &'a Function,
        keys: &Angles,
        treatments: &BTreeMap<u64, Treatment>,
        recipes: &'a [Recipe],
        rule: &str,
        context: &mut Context<'_>,
    ) -> (Function, u64) {
        let mut emitter = Emitter {
            rewriter: Rewriter::new(function, function.level),
            names: function.fresh_names(),
            owners: owners(context.tables, function),
            angles: BTreeMap::new(),
            recipes,
            replaced: 0,
        };
        emitter.survey(function, keys, treatments, context);
        for (value, node) in function.values() {
            let key = circular(node).map(|of| (keys.key(node.operands[0]), of));
            let treatment = key.and_then(|(key, of)| Some((key, of, treatments.get(&key)?)));
            let replaced = match treatment {
                None | Some((_, _, Treatment::Left)) => None,
                Some(_) if !context.allow_rewrite(node.name, rule) => None,
                Some((_, of, Treatment::Known(numbers))) => {
                    let number = numbers[place(of)];
                    Some(emitter.rewriter.new.constant(number).into())
                }
                Some((key, of, Treatment::Computed(recipe))) => {
                    Some(emitter.compute(value, key, of, *recipe, rule, context))
                }
            };
            match replaced {
                Some(operand) => {
                    emitter.replaced += 1;
                    emitter.rewriter.record(operand);
                }
                None => {
                    let operands = emitter.rewriter.translate_operands(node);
                    emitter.rewriter.keep(Node { operands, ..*node });
                }
            }
        }
        let new = emitter.rewriter.finish();
        // The expressions of angles that were written several times are used
        // no more, and inner nodes stand before the definition they belong to.
        let new = match function.level {
            Level::Equations => lay_out(&new),
            _ => new,
        };
        (new, emitter.replaced)
    }

    /// Counts the occurrences of every angle, and joins the equations that
    /// contain it.
    fn survey(
        &mut self,
        function: &Function,
        keys: &Angles,
        treatments: &BTreeMap<u64, Treatment>,
        context: &mut Context<'_>,
    ) {
        let mut sets: BTreeMap<u64, Vec<SourceSet>> = BTreeMap::new();
        for node in function.nodes() {
            let Some(of) = circular(node) else { continue };
            let key = keys.key(node.operands[0]);
            let Some(Treatment::Computed(recipe)) = treatments.get(&key) else {
                continue;
            };
            let nodes = self.recipes[*recipe].function.nodes().len();
            let angle = self.angles.entry(key).or_insert_with(|| AngleState {
                operand: Operand::NONE,
                written: vec![Operand::NONE; nodes],
                sources: SourceSet::EMPTY,
                copies: [0; 2],
            });
            angle.copies[place(of)] += 1;
            sets.entry(key).or_default().push(node.sources);
        }
        for (key, mut sets) in sets {
            sets.dedup();
            if let Some(angle) = self.angles.get_mut(&key) {
                angle.sources = context.tables.sources.union(&sets);
            }
        }
    }

    /// The operand that is the sine or cosine of an angle.
    fn compute(
        &mut self,
        value: Value,
        key: u64,
        of: Circular,
        recipe: usize,
        rule: &str,
        context: &mut Context<'_>,
    ) -> Operand {
        let recipe = &self.recipes[recipe];
        let old = *self.rewriter.old.node(value);
        let mut angle = self
            .angles
            .remove(&key)
            .expect("every angle with a recipe was surveyed");
        if angle.operand.is_none() {
            angle.operand = self.rewriter.translate(old.operands[0]);
            self.name_angle(angle.operand, recipe.angle_uses, value);
        }
        let result = recipe.results[place(of)];
        let read = |constant| recipe.function.constant_number(constant);
        for inner in slice(&recipe.function, &[result]) {
            if !angle.written[inner.index()].is_none() {
                continue;
            }
            let node = recipe.function.node(inner);
            let operands = node.operands.map(|operand| {
                if let Some(value) = operand.value() {
                    angle.written[value.index()]
                } else if let Some(constant) = operand.constant() {
                    self.rewriter.new.constant(read(constant)).into()
                } else if operand.input().is_some() {
                    angle.operand
                } else {
                    operand
                }
            });
            let uses = recipe.uses[inner.index()];
            let name = if result.value() == Some(inner) {
                self.result_name(value, uses + angle.copies[place(of)] - 1)
            } else {
                self.inner_name(value, uses)
            };
            let shared = uses > 1;
            let node = Node {
                name,
                operands,
                sources: if shared { angle.sources } else { old.sources },
                operation: node.operation,
            };
            context.note(name, rule);
            angle.written[inner.index()] = self.rewriter.new.push(node).into();
        }
        let operand = match result.value() {
            Some(inner) => angle.written[inner.index()],
            None => match result.constant() {
                Some(constant) => self.rewriter.new.constant(read(constant)).into(),
                None => {
                    self.rename_angle(angle.operand, old.name);
                    angle.operand
                }
            },
        };
        self.angles.insert(key, angle);
        operand
    }

    /// An angle that is an inner node and read more than once needs a name.
    fn name_angle(&mut self, angle: Operand, uses: u32, user: Value) {
        let Some(value) = angle.value() else { return };
        if self.rewriter.new.node(value).name.is_none() && uses > 1 {
            let name = self.names.fresh(self.owners[user.index()]);
            self.rewriter.new.node_mut(value).name = name;
        }
    }

    /// An angle that represents its sine can be read as often as the sine was.
    fn rename_angle(&mut self, angle: Operand, name: Name) {
        if let Some(value) = angle.value()
            && self.rewriter.new.node(value).name.is_none()
        {
            self.rewriter.new.node_mut(value).name = name;
        }
    }

    /// The name of a node of a recipe: inner nodes of equations have none.
    fn inner_name(&mut self, owner: Value, uses: u32) -> Name {
        let equations = self.rewriter.old.level == Level::Equations;
        if equations && uses <= 1 {
            Name::NONE
        } else {
            self.names.fresh(self.owners[owner.index()])
        }
    }

    /// The name of a sine or cosine: that of the node it replaces.
    fn result_name(&mut self, value: Value, uses: u32) -> Name {
        let name = self.rewriter.old.node(value).name;
        if name.is_none() {
            self.inner_name(value, uses)
        } else {
            name
        }
    }
}
