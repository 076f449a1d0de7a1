//! The tree as a template reads it, one object at a time.

use super::tree::TargetTree;
use crate::c::layout::extents;
use minijinja::Value as Seen;
use minijinja::value::{Enumerator, Object, ObjectRepr};
use robovec_ir::{Array, Constant, Input, Operand, OperandKind, Output, Shape, Value};
use std::sync::Arc;

/// Inputs or outputs.
#[derive(Clone, Copy, Debug)]
enum ArraySide {
    Input,
    Output,
}

/// An object or a list of the tree.
#[derive(Clone, Copy, Debug)]
enum TreePart {
    Function,
    Arrays(ArraySide),
    Array(ArraySide, usize),
    /// All elements of an array, row by row.
    Elements(ArraySide, usize),
    Element(ArraySide, usize, u32),
    /// Elements of inputs that are read.
    Loads,
    Constants,
    Constant(Constant),
    Statements,
    Statement(Value),
    Operands(Value),
    Operand(Operand),
}

/// A part of a tree.
#[derive(Debug)]
pub(super) struct TreeObject {
    tree: Arc<TargetTree>,
    part: TreePart,
}

impl TreeObject {
    /// The names that a template finds.
    pub(super) fn root(tree: TargetTree) -> Seen {
        Seen::from_object(TreeObject {
            tree: Arc::new(tree),
            part: TreePart::Function,
        })
    }

    fn part(&self, part: TreePart) -> Option<Seen> {
        let tree = Arc::clone(&self.tree);
        Some(Seen::from_object(TreeObject { tree, part }))
    }

    fn arrays(&self, side: ArraySide) -> (&[Array], &[String]) {
        let tree = &self.tree;
        match side {
            ArraySide::Input => (tree.function.inputs(), &tree.inputs),
            ArraySide::Output => (tree.function.outputs(), &tree.outputs),
        }
    }

    /// Length of a list; `None` for other objects.
    fn length(&self) -> Option<usize> {
        match self.part {
            TreePart::Arrays(side) => Some(self.arrays(side).0.len()),
            TreePart::Elements(side, array) => Some(self.arrays(side).0[array].shape.len()),
            TreePart::Loads => Some(self.tree.read_inputs.len()),
            TreePart::Constants => Some(self.tree.read_constants.len()),
            TreePart::Statements => Some(self.tree.statements.len()),
            TreePart::Operands(value) => Some(self.tree.function.node(value).operands().len()),
            _ => None,
        }
    }

    /// An item of a list.
    fn item(&self, index: usize) -> Option<Seen> {
        let tree = &self.tree;
        let part = match self.part {
            TreePart::Arrays(side) => TreePart::Array(side, index),
            TreePart::Elements(side, array) => TreePart::Element(side, array, index as u32),
            TreePart::Loads => {
                let input = tree.read_inputs[index];
                let array = tree.function.input_array(input);
                let offset = input.0 - tree.function.inputs()[array].offset;
                TreePart::Element(ArraySide::Input, array, offset)
            }
            TreePart::Constants => TreePart::Constant(tree.read_constants[index]),
            TreePart::Statements => TreePart::Statement(tree.statements[index]),
            TreePart::Operands(value) => {
                TreePart::Operand(tree.function.node(value).operands[index])
            }
            _ => return None,
        };
        self.part(part)
    }

    fn function(&self, key: &str) -> Option<Seen> {
        let function = &self.tree.function;
        match key {
            "name" => Some(self.tree.title.as_str().into()),
            "source" => Some(function.name.as_str().into()),
            "inputs" => self.part(TreePart::Arrays(ArraySide::Input)),
            "outputs" => self.part(TreePart::Arrays(ArraySide::Output)),
            "loads" => self.part(TreePart::Loads),
            "constants" => self.part(TreePart::Constants),
            "statements" => self.part(TreePart::Statements),
            "operations" => Some(self.tree.operations().into_iter().collect()),
            "extent" => {
                let arrays = function.inputs().iter().chain(function.outputs());
                let longest = arrays.flat_map(|array| extents(array.shape)).max();
                Some(longest.unwrap_or(1).into())
            }
            _ => None,
        }
    }

    fn array(&self, side: ArraySide, number: usize, key: &str) -> Option<Seen> {
        let (arrays, names) = self.arrays(side);
        let array = &arrays[number];
        let [rows, columns] = extents(array.shape);
        match key {
            "name" => Some(names[number].as_str().into()),
            "shape" => Some(Seen::from(match array.shape {
                Shape::Scalar => "scalar",
                Shape::Vector(_) => "vector",
                Shape::Matrix(..) => "matrix",
            })),
            "rows" => Some(rows.into()),
            "columns" => Some(columns.into()),
            "count" => Some(array.shape.len().into()),
            "offset" => Some(array.offset.into()),
            "elements" => self.part(TreePart::Elements(side, number)),
            _ => None,
        }
    }

    fn element(&self, side: ArraySide, number: usize, offset: u32, key: &str) -> Option<Seen> {
        let tree = &self.tree;
        let (arrays, names) = self.arrays(side);
        let array = &arrays[number];
        let place = tree.place(array, offset);
        let all = array.offset + offset;
        let own = match side {
            ArraySide::Input => tree.element_name(Input(all)),
            ArraySide::Output => "",
        };
        match (key, side) {
            ("index", _) => Some(place[0].into()),
            ("row", _) => Some(place[1].into()),
            ("column", _) => Some(place[2].into()),
            ("array", _) => self.part(TreePart::Array(side, number)),
            ("text", _) => Some(tree.element(array, &names[number], offset, own).into()),
            ("name", ArraySide::Input) => Some(own.into()),
            ("value", ArraySide::Output) => {
                Some(tree.operand(tree.assigned(Output(all))).text.into())
            }
            ("is_set", ArraySide::Output) => Some(tree.set[all as usize].is_some().into()),
            _ => None,
        }
    }

    fn statement(&self, value: Value, key: &str) -> Option<Seen> {
        match key {
            "name" => Some(self.tree.value_name(value).into()),
            "text" => Some(self.tree.expression(value).text.into()),
            "operation" => Some(self.tree.function.node(value).operation.name().into()),
            "operands" => self.part(TreePart::Operands(value)),
            _ => None,
        }
    }
}

impl Object for TreeObject {
    fn repr(self: &Arc<Self>) -> ObjectRepr {
        match self.length() {
            Some(_) => ObjectRepr::Seq,
            None => ObjectRepr::Map,
        }
    }

    fn get_value(self: &Arc<Self>, key: &Seen) -> Option<Seen> {
        if let Some(length) = self.length() {
            let index = key.as_usize().filter(|&index| index < length)?;
            return self.item(index);
        }
        let key = key.as_str()?;
        match self.part {
            TreePart::Function => self.function(key),
            TreePart::Array(side, number) => self.array(side, number, key),
            TreePart::Element(side, number, offset) => self.element(side, number, offset, key),
            TreePart::Constant(constant) => match key {
                "name" => Some(self.tree.constant_name(constant).into()),
                "number" => Some(self.tree.number(constant).into()),
                _ => None,
            },
            TreePart::Statement(value) => self.statement(value, key),
            TreePart::Operand(operand) => match key {
                "text" => Some(self.tree.operand(operand).text.into()),
                "kind" => Some(Seen::from(match operand.kind() {
                    OperandKind::Input(_) => "input",
                    OperandKind::Constant(_) => "constant",
                    OperandKind::Value(_) | OperandKind::None => "value",
                })),
                _ => None,
            },
            _ => None,
        }
    }

    fn enumerate(self: &Arc<Self>) -> Enumerator {
        match self.length() {
            Some(length) => Enumerator::Seq(length),
            None => Enumerator::NonEnumerable,
        }
    }
}
