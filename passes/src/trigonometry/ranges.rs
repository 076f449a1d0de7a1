//! The angles that are the same, and the bounds between which they lie.
//!
//! An angle is mostly a joint coordinate or a sum of several. Angles with the
//! same expression share their intermediate values, for any number of
//! occurrences of the expression; their bounds follow from those of the inputs
//! by interval arithmetic.

use hashbrown::HashMap;
use robovec_analysis::slice::needed;
use robovec_ir::{Function, Input, Node, Operand, OperandKind, Operation};
use robovec_num::interval::Interval;
use rustc_hash::FxBuildHasher;

/// An expression: the operation, and the numbers of its operand expressions.
type NumberedExpression = (Operation, [u64; Operand::MAX_COUNT]);

/// Numbers expressions: equal ones have the same number.
pub(super) struct Angles {
    /// The number of every value that an angle needs.
    keys: Vec<u64>,
    bounds: Vec<Option<Interval>>,
}

/// A value that no angle needs.
const UNKNOWN: u64 = u64::MAX;

/// Keys of inputs and constants carry their kind above their index.
const INPUT: u64 = 1 << 40;
const CONSTANT: u64 = 2 << 40;

impl Angles {
    /// Follows the operands of all sines and cosines; `input` gives between
    /// which bounds an element lies.
    pub(super) fn new(function: &Function, input: &dyn Fn(Input) -> Interval) -> Angles {
        let angles = function.nodes().iter();
        let angles = angles.filter(|node| node.operation.is_trigonometric());
        let needed = needed(function, angles.map(|node| node.operands[0]), |_| false);
        let mut known: HashMap<NumberedExpression, u64, FxBuildHasher> = HashMap::default();
        let mut angles = Angles {
            keys: vec![UNKNOWN; needed.len()],
            bounds: vec![None; needed.len()],
        };
        for (value, node) in function.values() {
            if !needed[value.index()] {
                continue;
            }
            let mut keys = node.operands.map(|operand| angles.key(operand));
            if node.operation.is_commutative() {
                keys[..2].sort_unstable();
            }
            angles.keys[value.index()] = match node.operation {
                Operation::Copy => keys[0],
                operation => *known.entry((operation, keys)).or_insert(u64::from(value.0)),
            };
            angles.bounds[value.index()] = angles.node_bounds(function, node, input);
        }
        angles
    }

    /// A number that equal angles share.
    pub(super) fn key(&self, operand: Operand) -> u64 {
        match operand.kind() {
            OperandKind::Value(value) => self.keys[value.index()],
            OperandKind::Input(input) => INPUT | u64::from(input.0),
            OperandKind::Constant(constant) => CONSTANT | u64::from(constant.0),
            OperandKind::None => UNKNOWN,
        }
    }

    /// The bounds of an angle; `None` when they are not known.
    pub(super) fn bounds(
        &self,
        function: &Function,
        operand: Operand,
        input: &dyn Fn(Input) -> Interval,
    ) -> Option<Interval> {
        match operand.kind() {
            OperandKind::Value(value) => self.bounds[value.index()],
            OperandKind::Input(element) => Some(input(element)),
            OperandKind::Constant(constant) => {
                Some(Interval::point(function.constant_number(constant)))
            }
            OperandKind::None => None,
        }
        .filter(|bounds| bounds.is_finite())
    }

    fn node_bounds(
        &self,
        function: &Function,
        node: &Node,
        input: &dyn Fn(Input) -> Interval,
    ) -> Option<Interval> {
        let operand = |index: usize| self.bounds(function, node.operands[index], input);
        Some(match node.operation {
            Operation::Copy => operand(0)?,
            Operation::Neg => -operand(0)?,
            Operation::Add => operand(0)? + operand(1)?,
            Operation::Sub => operand(0)? - operand(1)?,
            Operation::Mul => operand(0)? * operand(1)?,
            Operation::Fma => operand(0)? * operand(1)? + operand(2)?,
            Operation::Fms => operand(0)? * operand(1)? - operand(2)?,
            Operation::Fnma => operand(2)? - operand(0)? * operand(1)?,
            Operation::Sin | Operation::Cos => Interval::within(1.0),
            Operation::Div | Operation::Sqrt => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::parse;

    #[test]
    fn equal_angles_share_a_number_and_sums_add_bounds() {
        let text = "function f equations {
          in q[1..3]
          out o[1..5]
          %a = q[1] + q[2]
          o[1] = sin(%a)
          o[2] = cos(q[2] + q[1])
          o[3] = sin(q[1] - q[2] + 0.5)
          o[4] = sin(-q[3])
          o[5] = sin(q[1]/q[2])
        }";
        let module = parse::parse_module("angles", text).expect("it is well formed");
        let function = &module.functions[0];
        let input = |input: Input| Interval::within(0.1 * f64::from(input.0 + 1));
        let angles = Angles::new(function, &input);
        let operands: Vec<Operand> = function
            .nodes()
            .iter()
            .filter(|node| node.operation.is_trigonometric())
            .map(|node| node.operands[0])
            .collect();
        let keys: Vec<u64> = operands.iter().map(|&angle| angles.key(angle)).collect();
        assert_eq!(keys[0], keys[1]);
        assert!(keys[2] != keys[0] && keys[3] != keys[2]);
        let bounds = |index: usize| angles.bounds(function, operands[index], &input);
        let close = |bounds: Option<Interval>, low: f64, high: f64| {
            let bounds = bounds.expect("they are known");
            assert!((bounds.low - low).abs() < 1e-12 && (bounds.high - high).abs() < 1e-12);
        };
        close(bounds(0), -0.3, 0.3);
        close(bounds(2), 0.2, 0.8);
        close(bounds(3), -0.3, 0.3);
        assert_eq!(bounds(4), None);
    }
}
