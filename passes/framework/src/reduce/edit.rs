//! Making a function smaller.
//!
//! An edit gives the replacement of each value and the outputs that stay;
//! applying it also removes everything that is no longer needed: values, input
//! arrays, output arrays, user calls. There is no test here whether the smaller
//! function still shows the problem.

use crate::rewrite::{lay_out, owners};
use hashbrown::HashSet;
use robovec_ir::{
    Array, Assignment, Function, Input, Level, Node, Operand, OperandKind, Output, Shape, Symbol,
    Tables, Value,
};

/// The fate of a value.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Fate {
    /// It stays.
    Keep,
    /// Its users read a new input instead.
    Cut,
    /// Its users read its first (0), second (1) or last operand instead.
    Operand(usize),
}

/// A smaller version of a function.
#[derive(Clone, Debug)]
pub(super) struct Edit {
    /// One per value.
    pub(super) fates: Vec<Fate>,
    /// True for each assignment that stays.
    pub(super) outputs: Vec<bool>,
    /// Values of the outputs that stay instead of the former ones.
    pub(super) root: Option<Value>,
    /// Numbers written for others.
    pub(super) numbers: Vec<(f64, f64)>,
    /// Arrays become single numbers.
    pub(super) scalars: bool,
}

impl Edit {
    /// The edit that removes only unneeded values.
    pub(super) fn nothing(function: &Function) -> Edit {
        Edit {
            fates: vec![Fate::Keep; function.nodes().len()],
            outputs: vec![true; function.assignments.len()],
            root: None,
            numbers: Vec::new(),
            scalars: false,
        }
    }

    pub(super) fn apply(&self, old: &Function, tables: &mut Tables) -> Function {
        let mut writer = EditWriter {
            sources: self.resolve(old),
            edit: self,
            old,
            new: Function::new(&old.name, old.level),
            live: Vec::new(),
            inputs: vec![None; old.input_len()],
            cuts: vec![None; old.nodes().len()],
            map: vec![Operand::NONE; old.nodes().len()],
        };
        writer.find_live();
        writer.declare_inputs(tables);
        writer.body();
        writer.declare_outputs(tables);
        let mut new = writer.new;
        if new.level == Level::Equations {
            name_shared(&mut new, tables);
            return lay_out(&new);
        }
        new
    }

    /// The source that represents each value: itself, something before it, or
    /// its own input.
    fn resolve(&self, old: &Function) -> Vec<NumberSource> {
        let mut sources: Vec<NumberSource> = Vec::with_capacity(old.nodes().len());
        for (value, node) in old.values() {
            let source = match self.fates[value.index()] {
                Fate::Keep => NumberSource::Operand(value.into()),
                Fate::Cut => NumberSource::Cut(value),
                Fate::Operand(side) => {
                    let operand = node.operands()[side.min(node.operation.arity() - 1)];
                    match operand.value() {
                        Some(earlier) => sources[earlier.index()],
                        None => NumberSource::Operand(operand),
                    }
                }
            };
            sources.push(source);
        }
        sources
    }
}

/// The source of the number of an old value.
#[derive(Clone, Copy, PartialEq, Debug)]
enum NumberSource {
    /// An old operand; a value among them stays.
    Operand(Operand),
    /// A new input for this value.
    Cut(Value),
}

struct EditWriter<'a> {
    edit: &'a Edit,
    old: &'a Function,
    new: Function,
    sources: Vec<NumberSource>,
    live: Vec<bool>,
    /// New element of an old one that is read.
    inputs: Vec<Option<Input>>,
    cuts: Vec<Option<Input>>,
    map: Vec<Operand>,
}

impl EditWriter<'_> {
    fn source(&self, operand: Operand) -> NumberSource {
        match operand.value() {
            Some(value) => self.sources[value.index()],
            None => NumberSource::Operand(operand),
        }
    }

    fn kept_outputs(&self) -> impl Iterator<Item = Assignment> {
        assert_eq!(
            self.edit.outputs.len(),
            self.old.assignments.len(),
            "an edit decides on every output"
        );
        let outputs = self.old.assignments.iter().zip(&self.edit.outputs);
        let root = self.edit.root.map(Operand::from);
        outputs
            .filter(|(_, kept)| **kept)
            .map(move |(output, _)| Assignment {
                operand: root.unwrap_or(output.operand),
                ..*output
            })
    }

    /// Marks values, inputs and cuts that the kept outputs need.
    fn find_live(&mut self) {
        let nodes = self.old.nodes();
        self.live = vec![false; nodes.len()];
        let roots: Vec<Operand> = self.kept_outputs().map(|output| output.operand).collect();
        for root in roots {
            self.mark(root);
        }
        for (index, node) in nodes.iter().enumerate().rev() {
            if self.live[index] {
                for &operand in node.operands() {
                    self.mark(operand);
                }
            }
        }
    }

    fn mark(&mut self, operand: Operand) {
        // Which element it becomes is decided when all are known.
        match self.source(operand) {
            NumberSource::Cut(value) => self.cuts[value.index()] = Some(Input(0)),
            NumberSource::Operand(operand) => match operand.kind() {
                OperandKind::Value(value) => self.live[value.index()] = true,
                OperandKind::Input(input) => self.inputs[input.index()] = Some(Input(0)),
                OperandKind::Constant(_) | OperandKind::None => {}
            },
        }
    }

    fn declare_inputs(&mut self, tables: &mut Tables) {
        let mut taken = HashSet::new();
        for array in self.old.inputs() {
            let elements = array.offset..array.offset + array.shape.len() as u32;
            let used: Vec<u32> = elements
                .clone()
                .filter(|&element| self.inputs[element as usize].is_some())
                .collect();
            if used.is_empty() {
                continue;
            }
            if !self.edit.scalars {
                taken.insert(array.name);
                let new = self.new.add_input(array.name, array.shape);
                for element in elements {
                    let place = new.offset + element - array.offset;
                    self.inputs[element as usize] = Some(Input(place));
                }
                continue;
            }
            for element in used {
                let name = element_name(array, element - array.offset, tables);
                let name = free_name(&name, &mut taken, tables);
                let new = self.new.add_input(name, Shape::Scalar);
                self.inputs[element as usize] = Some(Input(new.offset));
            }
        }
        for (value, node) in self.old.values() {
            if self.cuts[value.index()].is_some() {
                let name = if node.name.is_none() {
                    "x".to_owned()
                } else {
                    node.name.display(&tables.symbols).replace('.', "_")
                };
                let name = free_name(&name, &mut taken, tables);
                let new = self.new.add_input(name, Shape::Scalar);
                self.cuts[value.index()] = Some(Input(new.offset));
            }
        }
    }

    fn body(&mut self) {
        for (value, node) in self.old.values() {
            if self.live[value.index()] {
                let operands = node.operands.map(|operand| self.translate(operand));
                let new = self.new.push(Node { operands, ..*node });
                self.map[value.index()] = new.into();
                if let Some(old) = &self.old.formats {
                    let formats = self.new.formats.get_or_insert_default();
                    formats.resize(new.index() + 1);
                    formats.set(new, old.get(value));
                }
            }
        }
    }

    fn translate(&mut self, operand: Operand) -> Operand {
        let input = |input: Option<Input>| input.map_or(Operand::NONE, Operand::from);
        match self.source(operand) {
            NumberSource::Cut(value) => input(self.cuts[value.index()]),
            NumberSource::Operand(operand) => match operand.kind() {
                OperandKind::Value(value) => self.map[value.index()],
                OperandKind::Input(old) => input(self.inputs[old.index()]),
                OperandKind::Constant(constant) => {
                    let number = self.old.constant_number(constant);
                    let replaced = self.edit.numbers.iter().find(|(from, _)| *from == number);
                    let number = replaced.map_or(number, |(_, to)| *to);
                    self.new.constant(number).into()
                }
                OperandKind::None => Operand::NONE,
            },
        }
    }

    fn declare_outputs(&mut self, tables: &mut Tables) {
        let kept: Vec<Assignment> = self.kept_outputs().collect();
        let mut taken = HashSet::new();
        let mut last: Option<(u32, Array)> = None;
        for assignment in kept {
            let (array, _, _) = self.old.output_element(assignment.output);
            let place = assignment.output.0 - array.offset;
            let output = if self.edit.scalars {
                let name = element_name(array, place, tables);
                let name = free_name(&name, &mut taken, tables);
                self.new.add_output(name, Shape::Scalar).offset
            } else {
                let new = match last {
                    Some((offset, new)) if offset == array.offset => new,
                    Some(_) | None => self.new.add_output(array.name, array.shape),
                };
                last = Some((array.offset, new));
                new.offset + place
            };
            let operand = self.translate(assignment.operand);
            self.new.assignments.push(Assignment {
                output: Output(output),
                operand,
                ..assignment
            });
        }
        self.new.sort_assignments();
    }
}

/// `q_3` for `q[3]`.
fn element_name(array: &Array, place: u32, tables: &Tables) -> String {
    let mut name = tables.symbols.text(array.name).to_owned();
    let (indices, rank) = array.shape.indices(place);
    for index in &indices[..rank] {
        name += &format!("_{index}");
    }
    name
}

/// The name, or the name with a number, that no array has yet.
fn free_name(name: &str, taken: &mut HashSet<Symbol>, tables: &mut Tables) -> Symbol {
    let mut symbol = tables.symbols.intern(name);
    let mut number = 1;
    while !taken.insert(symbol) {
        number += 1;
        symbol = tables.symbols.intern(&format!("{name}_{number}"));
    }
    symbol
}

/// At the equations level an unnamed node has exactly one user; one that has
/// taken the place of a named value may have more, and gets a name.
fn name_shared(function: &mut Function, tables: &mut Tables) {
    let owners = owners(tables, function);
    let mut names = function.fresh_names();
    for (index, uses) in function.use_counts().into_iter().enumerate() {
        let value = Value(index as u32);
        if function.node(value).name.is_none() && uses != 1 {
            let owner = owners[index];
            let known = owner.index() < tables.symbols.len();
            let owner = if known {
                owner
            } else {
                tables.symbols.intern("x")
            };
            function.node_mut(value).name = names.fresh(owner);
        }
    }
}
