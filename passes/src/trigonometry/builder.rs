//! Recipes while they are written.

use hashbrown::HashMap;
use robovec_ir::{
    Function, Input, Level, Name, Node, Operand, Operation, Shape, SourceSet, Symbol,
};

/// A recipe being written; equal operations are written once.
pub(super) struct RecipeBuilder {
    pub(super) function: Function,
    pub(super) angle: Operand,
    known: HashMap<(Operation, [Operand; Operand::MAX_COUNT]), Operand>,
}

impl RecipeBuilder {
    pub(super) fn new() -> RecipeBuilder {
        let mut function = Function::new("recipe", Level::Atomic);
        // The symbol belongs to no table: nobody prints a recipe.
        function.add_input(Symbol(0), Shape::Scalar);
        RecipeBuilder {
            function,
            angle: Input(0).into(),
            known: HashMap::new(),
        }
    }

    /// The angle that the polynomials see.
    pub(super) fn angle(&self) -> Operand {
        self.angle
    }

    pub(super) fn constant(&mut self, number: f64) -> Operand {
        self.function.constant(number).into()
    }

    pub(super) fn push(&mut self, operation: Operation, a: Operand, b: Operand) -> Operand {
        let (a, b) = if operation.is_commutative() && b < a {
            (b, a)
        } else {
            (a, b)
        };
        let operands = Operand::list([a, b]);
        let function = &mut self.function;
        *self.known.entry((operation, operands)).or_insert_with(|| {
            let node = Node {
                name: Name::NONE,
                sources: SourceSet::EMPTY,
                operands,
                operation,
            };
            function.push(node).into()
        })
    }
}
