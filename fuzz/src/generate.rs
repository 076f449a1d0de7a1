//! Random well-formed functions at the equations level.
//!
//! The bytes decide everything, so a fuzzer can steer and a failure can be
//! replayed. Expressions are made as in reverse Polish notation, which is the
//! order the text form keeps its nodes in.

use crate::hostile;
use arbitrary::{Result, Unstructured};
use robovec_ir::{
    Array, Boundary, Function, Input, Level, Module, Name, Node, Operand, Operation, Output, Shape,
    SourcePlace, SourceSet, Tables, Value,
};
use std::collections::BTreeSet;

/// Contents of a random function.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// Operations of the thesis' machine: sums, products, and sine and cosine
    /// of inputs.
    Placeable,
    /// Operations that Robotran writes: moderate constants, sine and cosine of
    /// inputs only, now and then a division or a root. The result is valid for
    /// passes and checks.
    Tame,
    /// As [`Kind::Tame`], with constants that are easily taken for others.
    Hostile,
    /// Whatever the text form can express.
    Wild,
}

const INPUTS: [&str; 8] = ["q", "qd", "dpt", "m", "sens.P", "in", "on", "frc"];
const OUTPUTS: [&str; 6] = ["M", "c", "frc", "sens.J", "out", "Z1"];
const BASES: [&str; 14] = [
    "C1", "S1", "OM16", "AF23", "x", "y", "BS9", "sin", "host", "sens.P", "frc_3", "a.b_c.d", "_",
    "at",
];
const TAME: [f64; 8] = [0.0, 1.0, 2.0, 0.5, -3.0, 0.1, 9.81, -0.25];
const WILD: [f64; 10] = [
    -0.0,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    1e16,
    1e-7,
    0.1 + 0.2,
    1e300,
    -1.0,
];
const TEXTS: [&str; 8] = [
    "Suspension",
    "",
    "a \"quoted\" word",
    "back\\slash",
    "line\nbreak\r\ttab",
    "Été §",
    "// no comment",
    "user_LinkForces",
];
/// The last one is not placeable.
const BINARY: [Operation; 8] = [
    Operation::Add,
    Operation::Add,
    Operation::Sub,
    Operation::Sub,
    Operation::Mul,
    Operation::Mul,
    Operation::Mul,
    Operation::Div,
];
const LARGEST: u32 = 60;

/// A random module of one to three functions.
///
/// # Errors
///
/// Fails when the bytes run out.
pub fn module(bytes: &mut Unstructured<'_>, kind: Kind) -> Result<Module> {
    let mut module = Module::new();
    for file in 0..bytes.int_in_range(0..=2)? {
        let name = format!("{}{file}.m", bytes.choose(&TEXTS)?);
        module.tables.sources.files.push(name);
    }
    for index in 0..bytes.int_in_range(1..=3)? {
        let name = format!("f{index}");
        let function = function(bytes, &mut module.tables, &name, kind)?;
        module.functions.push(function);
    }
    Ok(module)
}

/// A random function at the equations level that the verifier accepts.
///
/// # Errors
///
/// Fails when the bytes run out.
pub fn function(
    bytes: &mut Unstructured<'_>,
    tables: &mut Tables,
    name: &str,
    kind: Kind,
) -> Result<Function> {
    let mut generator = Generator {
        bytes,
        tables,
        function: Function::new(name, Level::Equations),
        kind,
        taken: BTreeSet::new(),
        named: Vec::new(),
        start: 0,
    };
    generator.header()?;
    let definitions = generator.bytes.int_in_range(0..=LARGEST)?;
    for _ in 0..definitions {
        generator.definition()?;
    }
    generator.assignments()?;
    Ok(generator.function)
}

struct Generator<'a, 'b> {
    bytes: &'a mut Unstructured<'b>,
    tables: &'a mut Tables,
    function: Function,
    kind: Kind,
    taken: BTreeSet<Name>,
    named: Vec<Value>,
    /// The first node of the statement being made.
    start: u32,
}

impl Generator<'_, '_> {
    fn header(&mut self) -> Result<()> {
        for index in 0..self.bytes.int_in_range(0..=2)? {
            let content = (*self.bytes.choose(&TEXTS)?).to_owned();
            self.function
                .metadata
                .push((format!("key{index}"), content));
        }
        for name in INPUTS {
            if self.bytes.ratio(1, 2)? || name == "q" {
                let shape = self.shape()?;
                let name = self.tables.symbols.intern(name);
                self.function.add_input(name, shape);
            }
        }
        for name in OUTPUTS {
            if self.bytes.ratio(1, 2)? {
                let shape = self.shape()?;
                let name = self.tables.symbols.intern(name);
                self.function.add_output(name, shape);
            }
        }
        for _ in 0..self.bytes.int_in_range(0..=2)? {
            self.boundary()?;
        }
        Ok(())
    }

    fn shape(&mut self) -> Result<Shape> {
        Ok(match self.bytes.int_in_range(0..=4)? {
            0 => Shape::Scalar,
            1 | 2 => Shape::Vector(self.bytes.int_in_range(0..=6)?),
            _ => Shape::Matrix(
                self.bytes.int_in_range(0..=4)?,
                self.bytes.int_in_range(1..=9)?,
            ),
        })
    }

    fn boundary(&mut self) -> Result<()> {
        let names: Vec<&str> = TEXTS.to_vec();
        let mut arguments = Vec::new();
        for _ in 0..self.bytes.int_in_range(0..=3)? {
            arguments.push((*self.bytes.choose(&names)?).to_owned());
        }
        let inputs: Vec<Array> = self.function.inputs().to_vec();
        let result = if self.bytes.ratio(1, 2)? {
            let array = self.bytes.choose(&inputs)?;
            Some(self.tables.symbols.text(array.name).to_owned())
        } else {
            None
        };
        let sources = self.sources()?;
        self.function.boundaries.push(Boundary {
            callee: (*self.bytes.choose(&names)?).to_owned(),
            arguments,
            result,
            sources,
        });
        Ok(())
    }

    /// No place, one, or several.
    fn sources(&mut self) -> Result<SourceSet> {
        let files = self.tables.sources.files.len() as u32;
        if files == 0 {
            return Ok(SourceSet::EMPTY);
        }
        let count = [0, 1, 1, 1, 2, 3];
        let mut sets = Vec::new();
        for _ in 0..*self.bytes.choose(&count)? {
            let line = self.bytes.int_in_range(1..=40)?;
            let column = self.bytes.int_in_range(1..=9)?;
            let lines = self.bytes.int_in_range(0..=1)?;
            sets.push(self.tables.sources.single(SourcePlace {
                file: self.bytes.int_in_range(0..=files - 1)?,
                line,
                column,
                end_line: line + lines,
                end_column: column + self.bytes.int_in_range(0..=30)?,
            }));
        }
        Ok(self.tables.sources.union(&sets))
    }

    fn definition(&mut self) -> Result<()> {
        self.start = self.function.nodes().len() as u32;
        let root = self.expression()?;
        let root = match root.value().filter(|value| value.0 >= self.start) {
            Some(root) => root,
            None => self.push(Operation::Copy, [root, Operand::NONE]),
        };
        let name = self.name()?;
        self.function.node_mut(root).name = name;
        self.set_sources()?;
        self.named.push(root);
        Ok(())
    }

    fn set_sources(&mut self) -> Result<SourceSet> {
        let sources = self.sources()?;
        for node in self.start..self.function.nodes().len() as u32 {
            self.function.node_mut(Value(node)).sources = sources;
        }
        Ok(sources)
    }

    fn name(&mut self) -> Result<Name> {
        let base = self.tables.symbols.intern(self.bytes.choose(&BASES)?);
        let suffix = match (self.kind, self.bytes.int_in_range(0..=7)?) {
            (_, 0..=3) => 0,
            (Kind::Wild, 4) => self.bytes.int_in_range(1..=Name::MAX_NUMBER)?,
            _ => self.bytes.int_in_range(1..=40)?,
        };
        let mut name = Name { base, suffix };
        while !self.taken.insert(name) {
            name.suffix = (name.suffix + 1) % Name::MAX_NUMBER;
        }
        Ok(name)
    }

    fn push(&mut self, operation: Operation, operands: [Operand; 2]) -> Value {
        self.function.push(Node {
            name: Name::NONE,
            sources: SourceSet::EMPTY,
            operands: Operand::list(operands),
            operation,
        })
    }

    /// A tree of up to a dozen leaves; the operand that holds its value.
    fn expression(&mut self) -> Result<Operand> {
        let mut stack = vec![self.leaf()?];
        let steps = self.bytes.int_in_range(0..=20)?;
        for _ in 0..steps {
            match self.bytes.int_in_range(0..=5)? {
                0 | 1 => {
                    let leaf = self.leaf()?;
                    stack.push(leaf);
                }
                2 => self.unary(&mut stack)?,
                _ => self.binary(&mut stack)?,
            }
        }
        while stack.len() > 1 {
            self.binary(&mut stack)?;
        }
        stack.pop().map_or_else(|| self.leaf(), Ok)
    }

    fn unary(&mut self, stack: &mut Vec<Operand>) -> Result<()> {
        let Some(operand) = stack.pop() else {
            return Ok(());
        };
        let angle = self.kind == Kind::Wild || operand.input().is_some();
        let operation = match self.bytes.int_in_range(0..=5)? {
            0 | 1 if angle => Operation::Sin,
            2 | 3 if angle => Operation::Cos,
            4 if self.kind != Kind::Placeable => Operation::Sqrt,
            _ => Operation::Neg,
        };
        let value = self.push(operation, [operand, Operand::NONE]);
        stack.push(value.into());
        Ok(())
    }

    fn binary(&mut self, stack: &mut Vec<Operand>) -> Result<()> {
        if stack.len() < 2 {
            return Ok(());
        }
        let operations = match self.kind {
            Kind::Placeable => &BINARY[..BINARY.len() - 1],
            Kind::Tame | Kind::Hostile | Kind::Wild => &BINARY[..],
        };
        let operation = *self.bytes.choose(operations)?;
        if let (Some(right), Some(left)) = (stack.pop(), stack.pop()) {
            let value = self.push(operation, [left, right]);
            stack.push(value.into());
        }
        Ok(())
    }

    /// A value, an input or a constant.
    fn leaf(&mut self) -> Result<Operand> {
        let inputs = self.function.input_len() as u32;
        Ok(match self.bytes.int_in_range(0..=9)? {
            0..=5 if !self.named.is_empty() => (*self.bytes.choose(&self.named)?).into(),
            0..=7 if inputs > 0 => Input(self.bytes.int_in_range(0..=inputs - 1)?).into(),
            _ => {
                let number = match self.kind {
                    Kind::Placeable | Kind::Tame => *self.bytes.choose(&TAME)?,
                    Kind::Hostile => hostile::number(self.bytes)?,
                    Kind::Wild => self.number()?,
                };
                self.function.constant(number).into()
            }
        })
    }

    fn number(&mut self) -> Result<f64> {
        let number: f64 = if self.bytes.ratio(1, 2)? {
            *self.bytes.choose(&WILD)?
        } else {
            f64::from_bits(self.bytes.arbitrary()?)
        };
        Ok(if number.is_finite() { number } else { 2.5 })
    }

    /// Sets the first element of every output array and some of the others.
    fn assignments(&mut self) -> Result<()> {
        let outputs: Vec<Array> = self.function.outputs().to_vec();
        for array in outputs {
            for element in 0..array.shape.len() as u32 {
                if element > 0 && self.bytes.ratio(1, 2)? {
                    continue;
                }
                self.start = self.function.nodes().len() as u32;
                let operand = if self.bytes.ratio(1, 3)? {
                    self.expression()?
                } else {
                    self.leaf()?
                };
                let sources = self.set_sources()?;
                self.function
                    .assign(Output(array.offset + element), operand, sources);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;
    use robovec_ir::View;
    use robovec_ir::verify::verify;

    #[test]
    fn random_functions_are_well_formed_and_not_all_small() {
        let mut largest = 0;
        cases::of_one_size(200, 4096, |bytes| {
            for kind in [Kind::Placeable, Kind::Tame, Kind::Hostile, Kind::Wild] {
                let module = module(bytes, kind)?;
                for function in &module.functions {
                    largest = largest.max(function.nodes().len());
                    let tables = &module.tables;
                    assert_eq!(verify(View { tables, function }), []);
                }
            }
            Ok(())
        });
        assert!(largest > 100, "the largest has {largest} nodes");
    }
}
