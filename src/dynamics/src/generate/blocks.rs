//! Linear equations of loops, solved block by block.
//!
//! The Jacobian of dependent joints falls into blocks: joints of a loop need
//! one another, joints of other loops do not, or need those of an earlier one.
//! In this order no entry arises outside blocks, and each is solved for itself.
//!
//! **Pivots.** Equations are written once, and a pivot that is good at one
//! position vanishes at another through which the mechanism passes: the
//! four-bar does so twice a turn. Blocks of up to three rows, those of a planar
//! loop and of a ball, therefore have none: the last unknown follows from the
//! direction at right angles to all other columns, and each before it from the
//! remainder,
//!
//! ```text
//! x_3 = d_3.b / d_3.a_3,    d_3 = a_1 x a_2
//! x_2 = d_2.b' / d_2.a_2,   d_2 = d_3 x a_1,    b' = b - a_3 x_3
//! x_1 = a_1.b" / a_1.a_1,                       b" = b' - a_2 x_2
//! ```
//!
//! This is a factorisation `QR` without roots. It fails only where the block
//! itself is singular, and there the joints are no valid choice of dependent
//! ones; near it, unlike with cofactors, unknowns compensate earlier errors.
//! Larger blocks keep the order of pivots of the initial state.

use super::algebra::{Scalar, Sum, dot};
use super::equations::{Equations, QuantityLabel};
use super::factor::{SparseRow, entry, product, solve_square};
use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, NodeIndex};

/// The maximum number of rows of a block that directions are written for.
const DIRECTIONS: usize = 3;

/// Solves `A X = B` for a square matrix whose rows and columns are in an order
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
        let system = LoopBlock::new(equations, names[0], rows, (&block, sides), &solution);
        let found = match block.len() {
            1..=DIRECTIONS => system.by_directions(equations, names),
            _ => system.by_pivots(equations, names),
        };
        let found = found.map_err(|place| block[place])?;
        assert_eq!(found.len(), block.len(), "every row of a block is solved");
        for (row, values) in block.into_iter().zip(found) {
            solution[row] = values;
        }
    }
    Ok(solution)
}

/// The strongly connected parts of a matrix, ascending, needed ones first.
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
struct LoopBlock<'r> {
    /// Its rows and columns in the whole matrix.
    places: &'r [usize],
    matrix: Vec<Vec<Scalar>>,
    /// The right sides, minus known terms.
    right: Vec<SparseRow>,
}

impl<'r> LoopBlock<'r> {
    fn new(
        equations: &mut Equations,
        name: &'static str,
        rows: &[SparseRow],
        (places, sides): (&'r [usize], usize),
        solution: &[SparseRow],
    ) -> LoopBlock<'r> {
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
        LoopBlock {
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
        solve_square(equations, names, &rows, sides).map(|(solution, _)| solution)
    }

    /// One more than the last side that is not zero.
    fn sides(&self) -> usize {
        let last = self.right.iter().filter_map(|row| row.last());
        last.map(|(side, _)| side + 1).fold(0, usize::max)
    }

    /// The solution by directions, from the last unknown to the first.
    fn by_directions(
        &self,
        equations: &mut Equations,
        names: [&'static str; 5],
    ) -> Result<Vec<SparseRow>, usize> {
        let [rest_name, factor, inverse, half, name] = names;
        let count = self.places.len();
        let label = |name, place: usize, column: usize| {
            QuantityLabel::new(name, 0, self.places[place] + 1).column(column + 1)
        };
        let directions = self.directions(equations, factor);
        let mut inverses = Vec::with_capacity(count);
        for (place, direction) in directions.iter().enumerate() {
            let length = dot(direction, &self.column(place));
            let length = equations.define(label(half, place, place), length);
            if length.is_zero() {
                return Err(place);
            }
            let own = QuantityLabel::new(inverse, 0, self.places[place] + 1);
            inverses.push(equations.quotient(own, Scalar::ONE, length));
        }
        let mut solution = vec![SparseRow::new(); count];
        for side in 0..self.sides() {
            let mut rest: Vec<Scalar> = self.right.iter().map(|row| entry(row, side)).collect();
            for place in (0..count).rev() {
                let value = dot(&directions[place], &rest);
                let value = equations.define(label(half, place, side), value);
                let value = product(equations, label(name, place, side), value, inverses[place]);
                if value.is_zero() {
                    continue;
                }
                solution[place].push((side, value));
                for (row, rest) in rest.iter_mut().enumerate().filter(|_| place > 0) {
                    let mut sum = Sum::of(*rest);
                    sum.subtract(&[self.matrix[row][place], value]);
                    *rest = equations.define(label(rest_name, row, side), sum);
                }
            }
        }
        Ok(solution)
    }

    fn column(&self, column: usize) -> Vec<Scalar> {
        self.matrix.iter().map(|row| row[column]).collect()
    }

    /// For every column a direction at right angles to those before it.
    fn directions(&self, equations: &mut Equations, name: &'static str) -> Vec<Vec<Scalar>> {
        let first = self.column(0);
        let mut cross = |number: usize, a: &[Scalar], b: &[Scalar]| {
            let components = (0..3).map(|axis| {
                let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut sum = Sum::new();
                sum.add(&[a[next], b[last]]).subtract(&[a[last], b[next]]);
                let label = QuantityLabel::new(name, axis + 1, self.places[number] + 1);
                equations.define(label, sum)
            });
            components.collect::<Vec<_>>()
        };
        match self.places.len() {
            1 => vec![vec![Scalar::ONE]],
            2 => vec![first.clone(), vec![-first[1], first[0]]],
            3 => {
                let last = cross(2, &first, &self.column(1));
                let middle = cross(1, &last, &first);
                vec![first, middle, last]
            }
            _ => unreachable!("larger blocks are solved by pivots"),
        }
    }
}
