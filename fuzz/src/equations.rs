//! Random equations that look like Robotran's.
//!
//! Random terms rarely make a pass fail; patterns of real equations do: values
//! used many times, wide sums of products, sums whose terms are all negative,
//! the same term twice, `x - x`, `0*x`, parentheses in parentheses, equations
//! that repeat others with their operands exchanged. The bytes decide
//! everything, so a fuzzer can steer and a failure can be replayed.

use crate::hostile;
use arbitrary::{Result, Unstructured};
use robovec_framework::rewrite::lay_out;
use robovec_ir::verify::verify;
use robovec_ir::{
    Function, Input, Level, Module, Name, Node, Operand, Operation, Output, Shape, SourceSet, Value,
};

/// Contents of random equations.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Contents {
    /// Most definitions.
    pub definitions: u32,
    /// Divisions and square roots, which Robotran hardly writes.
    pub divisions: bool,
    /// Constants that are easily taken for others, poles, and roots of any
    /// sign.
    pub hostile: bool,
}

const BASES: [&str; 8] = ["OM", "OP", "BS", "BETA", "AF", "CF", "CM", "FB"];
const NUMBERS: [f64; 7] = [0.0, 1.0, 2.0, 0.5, -1.0, 9.81, 0.1];
/// Number of terms a sum has; wide ones are rare.
const WIDTHS: [u32; 12] = [1, 1, 2, 2, 2, 3, 3, 4, 5, 7, 12, 30];
const DEEPEST: u32 = 3;

/// A module of one function at the equations level.
///
/// # Errors
///
/// Fails when the bytes run out.
pub fn equations(bytes: &mut Unstructured<'_>, contents: Contents) -> Result<Module> {
    let joints = bytes.int_in_range(1..=4)?;
    let mut module = Module::new();
    let mut function = Function::new("dirdyna", Level::Equations);
    for (name, rows) in [("q", 1), ("qd", 1), ("m", 1), ("dpt", 3), ("In", 9)] {
        let shape = match rows {
            1 => Shape::Vector(joints),
            _ => Shape::Matrix(rows, joints),
        };
        function.add_input(module.tables.symbols.intern(name), shape);
    }
    let square = Shape::Matrix(joints, joints);
    function.add_output(module.tables.symbols.intern("M"), square);
    function.add_output(module.tables.symbols.intern("c"), Shape::Vector(joints));
    let mut maker = Maker {
        bytes,
        module: &mut module,
        function,
        contents,
        named: Vec::new(),
    };
    maker.angles(joints)?;
    for number in 0..maker.bytes.int_in_range(1..=contents.definitions)? {
        maker.definition(number)?;
    }
    maker.outputs(joints)?;
    let function = lay_out(&maker.function);
    assert_eq!(verify(module.tables.view(&function)), []);
    module.functions.push(function);
    Ok(module)
}

struct Maker<'a, 'b> {
    bytes: &'a mut Unstructured<'b>,
    module: &'a mut Module,
    function: Function,
    contents: Contents,
    named: Vec<Value>,
}

impl Maker<'_, '_> {
    fn push<const COUNT: usize>(
        &mut self,
        operation: Operation,
        operands: [Operand; COUNT],
    ) -> Operand {
        let value = self.function.push(Node {
            name: Name::NONE,
            sources: SourceSet::EMPTY,
            operands: Operand::list(operands),
            operation,
        });
        value.into()
    }

    fn constant(&mut self, number: f64) -> Operand {
        self.function.constant(number).into()
    }

    /// Gives an expression a name; an operand that is no operation becomes a
    /// copy.
    fn name(&mut self, operand: Operand, name: &str) -> Value {
        let inner = operand
            .value()
            .filter(|&v| self.function.node(v).name.is_none());
        let value = match inner {
            Some(value) => value,
            None => {
                let copy = self.push(Operation::Copy, [operand, Operand::NONE]);
                copy.value().expect("an operation was made")
            }
        };
        let symbol = self.module.tables.symbols.intern(name);
        self.function.node_mut(value).name = Name::plain(symbol);
        self.named.push(value);
        value
    }

    /// Sines and cosines of coordinates, now and then of their sum.
    fn angles(&mut self, joints: u32) -> Result<()> {
        for joint in 0..joints {
            let mut angle = Operand::from(Input(joint));
            if joint > 0 && self.bytes.ratio(1, 4)? {
                let sum = self.push(Operation::Add, [Input(joint - 1).into(), angle]);
                angle = self.name(sum, &format!("ANG{joint}")).into();
            }
            for (operation, name) in [(Operation::Cos, "C"), (Operation::Sin, "S")] {
                let value = self.push(operation, [angle, Operand::NONE]);
                self.name(value, &format!("{name}{joint}"));
            }
        }
        Ok(())
    }

    fn definition(&mut self, number: u32) -> Result<()> {
        let operand = match self.bytes.int_in_range(0..=9)? {
            0 | 1 if self.named.len() > 1 => {
                let known = *self.bytes.choose(&self.named)?;
                self.again(known)?
            }
            2 if self.contents.divisions => self.quotient()?,
            _ => self.sum(0)?,
        };
        let base = self.bytes.choose(&BASES)?;
        self.name(operand, &format!("{base}{number}"));
        Ok(())
    }

    /// A named expression once more, with some operands exchanged and some
    /// inner values written out again.
    fn again(&mut self, known: Value) -> Result<Operand> {
        let node = *self.function.node(known);
        if node.operation == Operation::Copy {
            return Ok(node.operands[0]);
        }
        let mut operands = node.operands;
        for operand in &mut operands {
            let Some(value) = operand.value() else {
                continue;
            };
            // An inner node has one user; another one needs a copy of it.
            let inner = *self.function.node(value);
            let same = inner.operands.iter().all(|operand| {
                let value = operand.value();
                value.is_none_or(|value| !self.function.node(value).name.is_none())
            });
            if inner.name.is_none() || (same && self.bytes.ratio(1, 2)?) {
                *operand = match same {
                    // A copy stands only where it has a name.
                    true if inner.operation == Operation::Copy => inner.operands[0],
                    true => self.push(inner.operation, inner.operands),
                    false => self.leaf()?,
                };
            }
        }
        if node.operation.is_commutative() && self.bytes.arbitrary()? {
            operands.swap(0, 1);
        }
        Ok(self.push(node.operation, operands))
    }

    fn quotient(&mut self) -> Result<Operand> {
        if self.contents.hostile && self.bytes.arbitrary()? {
            return self.hostile_quotient();
        }
        let above = self.product(1)?;
        let below = self.leaf()?;
        // Away from zero, so that the quotient says something.
        let square = self.push(Operation::Mul, [below, below]);
        let one = self.constant(1.0);
        let mut divisor = self.push(Operation::Add, [square, one]);
        if self.bytes.ratio(1, 3)? {
            divisor = self.push(Operation::Sqrt, [divisor, Operand::NONE]);
        }
        Ok(self.push(Operation::Div, [above, divisor]))
    }

    /// A pole, or a root whose sign or domain is easily lost.
    fn hostile_quotient(&mut self) -> Result<Operand> {
        let inner = self.sum(DEEPEST)?;
        let inner = self.name_inner(inner)?;
        Ok(match self.bytes.int_in_range(0..=3)? {
            0 => {
                let above = self.product(DEEPEST)?;
                self.push(Operation::Div, [above, inner])
            }
            1 => {
                let above = self.push(Operation::Mul, [inner, inner]);
                self.push(Operation::Div, [above, inner])
            }
            2 => {
                let square = self.push(Operation::Mul, [inner, inner]);
                self.push(Operation::Sqrt, [square, Operand::NONE])
            }
            _ => self.push(Operation::Sqrt, [inner, Operand::NONE]),
        })
    }

    /// Gives an expression a name, so that it can be read twice.
    fn name_inner(&mut self, operand: Operand) -> Result<Operand> {
        let name = format!("IN{}", self.named.len());
        Ok(self.name(operand, &name).into())
    }

    /// A sum of products.
    fn sum(&mut self, depth: u32) -> Result<Operand> {
        let width = match depth {
            0 => *self.bytes.choose(&WIDTHS)?,
            _ => self.bytes.int_in_range(1..=3)?,
        };
        let all_negative = self.bytes.ratio(1, 6)?;
        let mut sum: Option<Operand> = None;
        let mut last: Option<Node> = None;
        for _ in 0..width {
            let negative = all_negative || self.bytes.ratio(1, 3)?;
            let term = self.term(depth, &mut last)?;
            sum = Some(match (sum, negative) {
                (None, false) => term,
                (None, true) => self.push(Operation::Neg, [term, Operand::NONE]),
                (Some(sum), false) => self.push(Operation::Add, [sum, term]),
                (Some(sum), true) => self.push(Operation::Sub, [sum, term]),
            });
        }
        sum.map_or_else(|| self.leaf(), Ok)
    }

    /// A product, the product before it again, or one with 0 or 1.
    fn term(&mut self, depth: u32, last: &mut Option<Node>) -> Result<Operand> {
        let term = match (self.bytes.int_in_range(0..=11)?, *last) {
            (0 | 1, Some(node)) => return Ok(self.push(node.operation, node.operands)),
            (2, _) => {
                let known = self.product(depth)?;
                let number = *self.bytes.choose(&[0.0, 1.0, -1.0])?;
                let number = self.constant(number);
                self.push(Operation::Mul, [number, known])
            }
            _ => self.product(depth)?,
        };
        let Some(value) = term.value() else {
            return Ok(term);
        };
        let node = *self.function.node(value);
        let repeatable = node.name.is_none()
            && node.operands().iter().all(|operand| {
                let value = operand.value();
                value.is_none_or(|value| !self.function.node(value).name.is_none())
            });
        if repeatable {
            *last = Some(node);
        }
        Ok(term)
    }

    fn product(&mut self, depth: u32) -> Result<Operand> {
        let factors = *self.bytes.choose(&[1, 1, 2, 2, 2, 2, 3, 3, 5])?;
        let mut product = self.factor(depth)?;
        for _ in 1..factors {
            let factor = self.factor(depth)?;
            product = self.push(Operation::Mul, [product, factor]);
        }
        Ok(product)
    }

    fn factor(&mut self, depth: u32) -> Result<Operand> {
        if depth < DEEPEST && self.bytes.ratio(1, 5)? {
            return self.sum(depth + 1);
        }
        self.leaf()
    }

    /// A value (of the last ones, mostly), an input or a number.
    fn leaf(&mut self) -> Result<Operand> {
        let inputs = self.function.input_len() as u32;
        let count = self.named.len();
        Ok(match self.bytes.int_in_range(0..=9)? {
            // Constants are what a hostile program is about.
            0 | 1 if self.contents.hostile => self.hostile_leaf()?,
            0..=3 if count > 0 => {
                let recent = count.saturating_sub(8);
                self.named[self.bytes.int_in_range(recent..=count - 1)?].into()
            }
            4 if count > 0 => (*self.bytes.choose(&self.named)?).into(),
            0..=8 => Input(self.bytes.int_in_range(0..=inputs - 1)?).into(),
            _ if self.contents.hostile => self.hostile_leaf()?,
            _ => {
                let number = *self.bytes.choose(&NUMBERS)?;
                self.constant(number)
            }
        })
    }

    /// A hostile constant, or two that make a prime together.
    fn hostile_leaf(&mut self) -> Result<Operand> {
        if self.bytes.ratio(1, 6)? {
            let [high, low] = hostile::prime(self.bytes)?.map(|number| self.constant(number));
            let sum = self.push(Operation::Add, [high, low]);
            // It may be read twice.
            return self.name_inner(sum);
        }
        let number = hostile::number(self.bytes)?;
        Ok(self.constant(number))
    }

    /// A symmetric matrix and a vector.
    fn outputs(&mut self, joints: u32) -> Result<()> {
        let mut elements: Vec<(u32, Operand)> = Vec::new();
        for row in 0..joints {
            for column in 0..=row {
                let operand = self.output(&format!("M{row}_{column}"))?;
                elements.push((row * joints + column, operand));
                if row != column {
                    elements.push((column * joints + row, operand));
                }
            }
        }
        for row in 0..joints {
            let operand = self.sum(0)?;
            elements.push((joints * joints + row, operand));
        }
        elements.sort_by_key(|&(place, _)| place);
        for (place, operand) in elements {
            self.function
                .assign(Output(place), operand, SourceSet::EMPTY);
        }
        Ok(())
    }

    /// A value that may be used twice.
    fn output(&mut self, name: &str) -> Result<Operand> {
        match self.bytes.int_in_range(0..=3)? {
            0 => self.leaf(),
            _ => {
                let sum = self.sum(0)?;
                Ok(self.name(sum, name).into())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn random_equations_are_well_formed_and_have_what_robotrans_have() {
        let (mut largest, mut negative, mut shared) = (0, 0, 0);
        cases::of_one_size(150, 4096, |bytes| {
            let contents = Contents {
                definitions: 20,
                divisions: true,
                hostile: false,
            };
            let module = equations(bytes, contents)?;
            let function = &module.functions[0];
            let tables = &module.tables;
            assert_eq!(verify(tables.view(function)), []);
            largest = largest.max(function.nodes().len());
            let minus = |node: &&Node| node.operation == Operation::Neg;
            negative += function.nodes().iter().filter(minus).count();
            shared += function
                .use_counts()
                .iter()
                .filter(|&&uses| uses > 2)
                .count();
            Ok(())
        });
        assert!(largest > 150, "the largest has {largest} nodes");
        assert!(
            negative > 100 && shared > 100,
            "{negative} minuses, {shared} shared"
        );
    }
}
