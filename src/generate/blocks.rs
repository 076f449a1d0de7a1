//! Linear equations of loops, solved block by block.
//!
//! The Jacobian of dependent joints falls into blocks: joints of a loop need one
//! another, joints of other loops do not, or need those of an earlier one. In
//! this order no entry arises outside blocks, and each is solved for itself.
//!
//! **Pivots.** Equations are written once, and a pivot that is good at one
//! position vanishes at another through which the mechanism passes: the four-bar
//! does so twice a turn. Blocks of up to three rows, those of a planar loop and
//! of a ball, are therefore solved by cofactors, `x = adj(A) b / det(A)`, which
//! need no pivot and one division; only where the block itself is singular do
//! they fail, and there the joints are no choice of dependent ones. Larger blocks
//! keep the order of pivots of the initial state.

use super::algebra::{Scalar, Sum};
use super::equations::{Equations, QuantityLabel};
use super::factor::{SparseRow, entry, product, solve_square};
use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, NodeIndex};

/// The most rows of a block that cofactors are written for.
const COFACTORS: usize = 3;

/// Solves `A X = B` for a square matrix whose rows and columns stand in an order
/// of pivots. A row holds its columns, then those of the right sides. The names
/// are those of entries, of factors, of inverses, and of the solution before and
/// after its division. The number of a row without a pivot is an error.
pub(super) fn solve_blocks(
    equations: &mut Equations,
    names: [&'static str; 5],
    rows: &[SparseRow],
    sides: usize,
) -> Result<Vec<SparseRow>, usize> {
    let count = rows.len();
    let mut solution: Vec<SparseRow> = vec![SparseRow::new(); count];
    for block in blocks(rows) {
        let system = Block::new(equations, names[0], rows, (&block, sides), &solution);
        let found = match block.len() {
            1..=COFACTORS => system.by_cofactors(equations, names),
            _ => system.by_pivots(equations, names),
        };
        let found = found.map_err(|place| block[place])?;
        for (row, values) in block.into_iter().zip(found) {
            solution[row] = values;
        }
    }
    Ok(solution)
}

/// The strongly connected parts of a matrix, those first that need no other;
/// each ascending.
fn blocks(rows: &[SparseRow]) -> Vec<Vec<usize>> {
    let mut graph = DiGraph::<(), ()>::with_capacity(rows.len(), rows.len());
    let nodes: Vec<NodeIndex> = rows.iter().map(|_| graph.add_node(())).collect();
    for (row, entries) in rows.iter().enumerate() {
        let columns = entries.iter().map(|&(column, _)| column);
        for column in columns.filter(|&column| column < rows.len() && column != row) {
            graph.add_edge(nodes[row], nodes[column], ());
        }
    }
    // Rows point to the unknowns they need, and these come first.
    let parts = kosaraju_scc(&graph).into_iter().map(|part| {
        let mut part: Vec<usize> = part.into_iter().map(NodeIndex::index).collect();
        part.sort_unstable();
        part
    });
    parts.collect()
}

/// Rows of a block in its own columns.
struct Block<'r> {
    /// Its rows and columns in the whole matrix.
    places: &'r [usize],
    matrix: Vec<Vec<Scalar>>,
    /// The right sides, less what is known.
    right: Vec<SparseRow>,
}

impl<'r> Block<'r> {
    fn new(
        equations: &mut Equations,
        name: &'static str,
        rows: &[SparseRow],
        (places, sides): (&'r [usize], usize),
        solution: &[SparseRow],
    ) -> Block<'r> {
        let own = |&row: &usize| {
            places
                .iter()
                .map(|&column| entry(&rows[row], column))
                .collect()
        };
        let mut right = Vec::with_capacity(places.len());
        for &row in places {
            let outside = rows[row].iter();
            let outside = outside.filter(|(column, _)| *column < rows.len());
            let outside: Vec<_> = outside
                .filter(|(column, _)| !places.contains(column))
                .collect();
            let mut values = SparseRow::new();
            for side in 0..sides {
                let mut sum = Sum::of(entry(&rows[row], rows.len() + side));
                for &&(column, value) in &outside {
                    sum.subtract(&[value, entry(&solution[column], side)]);
                }
                let label = QuantityLabel::new(name, 0, row + 1).column(rows.len() + side + 1);
                values.push((side, equations.define(label, sum)));
            }
            values.retain(|(_, value)| !value.is_zero());
            right.push(values);
        }
        Block {
            places,
            matrix: places.iter().map(own).collect(),
            right,
        }
    }

    /// The solution with the pivots in their order.
    fn by_pivots(
        &self,
        equations: &mut Equations,
        names: [&'static str; 5],
    ) -> Result<Vec<SparseRow>, usize> {
        let count = self.places.len();
        let sides = self.sides();
        let rows = self.matrix.iter().zip(&self.right).map(|(row, right)| {
            let own = row.iter().copied().enumerate();
            let right = right.iter().map(|&(side, value)| (count + side, value));
            own.filter(|(_, value)| !value.is_zero())
                .chain(right)
                .collect()
        });
        let rows: Vec<SparseRow> = rows.collect();
        solve_square(equations, names, &rows, sides)
    }

    /// One more than the last side that is not zero.
    fn sides(&self) -> usize {
        let last = self.right.iter().filter_map(|row| row.last());
        last.map(|(side, _)| side + 1).max().unwrap_or(0)
    }

    /// The solution by cofactors.
    fn by_cofactors(
        &self,
        equations: &mut Equations,
        [_, factor, inverse, half, name]: [&'static str; 5],
    ) -> Result<Vec<SparseRow>, usize> {
        let count = self.places.len();
        let label = |name, row: usize, column: usize| {
            QuantityLabel::new(name, 0, self.places[row] + 1).column(self.places[column] + 1)
        };
        // The cofactor of an entry stands at the entry's place.
        let mut cofactors = vec![vec![Scalar::ONE; count]; count];
        for row in 0..count {
            for column in 0..count {
                let sum = self.cofactor(row, column);
                cofactors[row][column] = equations.define(label(factor, row, column), sum);
            }
        }
        let mut determinant = Sum::new();
        for column in 0..count {
            determinant.add(&[self.matrix[0][column], cofactors[0][column]]);
        }
        let own = |name| QuantityLabel::new(name, 0, self.places[0] + 1);
        let determinant = equations.define(own(half), determinant);
        if determinant.is_zero() {
            return Err(0);
        }
        let inverse = equations.quotient(own(inverse), Scalar::ONE, determinant);
        let mut solution = vec![SparseRow::new(); count];
        for side in 0..self.sides() {
            for (unknown, values) in solution.iter_mut().enumerate() {
                let mut sum = Sum::new();
                for (row, right) in self.right.iter().enumerate() {
                    sum.add(&[cofactors[row][unknown], entry(right, side)]);
                }
                let label =
                    |name| QuantityLabel::new(name, 0, self.places[unknown] + 1).column(side + 1);
                let value = equations.define(label(half), sum);
                let value = product(equations, label(name), value, inverse);
                if !value.is_zero() {
                    values.push((side, value));
                }
            }
        }
        Ok(solution)
    }

    /// The determinant of what is left without a row and a column, with its
    /// sign; one for a block of one row.
    fn cofactor(&self, row: usize, column: usize) -> Sum {
        // In cyclic order the signs are those of the products.
        let count = self.places.len();
        let at = |i: usize, j: usize| self.matrix[(row + i) % count][(column + j) % count];
        match count {
            1 => Sum::of(Scalar::ONE),
            2 => Sum::of(match (row + column).is_multiple_of(2) {
                true => at(1, 1),
                false => -at(1, 1),
            }),
            3 => {
                let mut sum = Sum::new();
                sum.add(&[at(1, 1), at(2, 2)]);
                sum.subtract(&[at(1, 2), at(2, 1)]);
                sum
            }
            _ => unreachable!("larger blocks are solved by pivots"),
        }
    }
}
