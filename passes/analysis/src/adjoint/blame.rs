//! Operations, equations and inputs that cause the error.

use super::{AdjointRun, LANES, Tape, Workspace};
use robovec_ir::{Function, Input, SourcePlace, Symbol, View};

/// Contributions to the error of outputs, summed over outputs and states.
///
/// An operation contributes the size of its adjoint times its actual rounding
/// error. Outputs of different units are made comparable by dividing each by
/// the largest exact element of its array in that state.
#[derive(Clone, Debug)]
pub struct Blame {
    contributions: Vec<f64>,
    total: f64,
    refused: u32,
}

/// The part of an equation of the user in the error.
#[derive(Clone, PartialEq, Debug)]
pub struct EquationBlame {
    /// Its place; `None` when the function does not specify it, and operations are
    /// gathered by name.
    pub place: Option<SourcePlace>,
    /// The symbol it defines; `None` for an operation without a name.
    pub name: Option<Symbol>,
    /// Its part of all contributions, 0 to 1. An operation that represents
    /// several equations counts for each with an equal part.
    pub share: f64,
    /// The number of its operations that lost something.
    pub operations: u32,
}

impl Blame {
    /// Nobody is to blame yet.
    pub fn new(tape: &Tape) -> Blame {
        Blame {
            contributions: vec![0.0; tape.slots()],
            total: 0.0,
            refused: 0,
        }
    }

    /// Adds the contributions to some outputs of a run, by their places in
    /// [`Function::assignments`]. A run in which one of them is not finite
    /// determines no shares and is refused.
    ///
    /// # Panics
    ///
    /// Panics when an output does not exist or the run is one of another
    /// function.
    pub fn add(&mut self, function: &Function, run: &AdjointRun<'_>, outputs: &[usize]) {
        let adjoint = run.adjoint();
        let tape = run.tape();
        assert_eq!(
            tape.slots(),
            self.contributions.len(),
            "the run is one of the same function"
        );
        let weights = output_weights(function, run);
        let mut workspace = Workspace::default();
        let mut sums = vec![0.0; tape.slots()];
        for group in outputs.chunks(LANES) {
            adjoint.sweep_lanes(&mut workspace, group, |slot, gradient| {
                let lost = run.local_errors()[slot];
                if lost != 0.0 {
                    let lanes = gradient.0.iter().zip(group);
                    let reached = lanes.map(|(lane, &output)| lane.abs() * weights[output]);
                    sums[slot] += lost.abs() * reached.sum::<f64>();
                }
            });
        }
        let total: f64 = sums.iter().sum();
        if !total.is_finite() {
            self.refused += 1;
            return;
        }
        self.total += total;
        for (all, sum) in self.contributions.iter_mut().zip(&sums) {
            *all += sum;
        }
    }

    /// The number of runs that were refused.
    pub fn refused(&self) -> u32 {
        self.refused
    }

    /// The part of a slot in all contributions, 0 to 1.
    pub fn share(&self, slot: usize) -> f64 {
        if self.total > 0.0 {
            self.contributions[slot] / self.total
        } else {
            0.0
        }
    }

    /// The inputs with the largest shares: data that the format cannot
    /// represent.
    pub fn inputs(&self, tape: &Tape, most: usize) -> Vec<(Input, f64)> {
        let inputs = (0..tape.inputs()).map(|index| Input(index as u32));
        let shares = inputs.map(|input| (input, self.share(tape.input_slot(input))));
        largest(shares.collect(), most)
    }

    /// The share of all literals that the format could not hold.
    pub fn literals(&self, tape: &Tape) -> f64 {
        let slots = tape.nodes() + tape.inputs()..tape.slots();
        slots.map(|slot| self.share(slot)).sum()
    }

    /// The source equations with the largest shares, the largest first.
    pub fn equations(&self, view: View<'_>, most: usize) -> Vec<EquationBlame> {
        let function = view.function;
        let owners = owners(function);
        let mut parts = Vec::new();
        for (value, node) in function.values() {
            let share = self.share(value.index());
            if share == 0.0 {
                continue;
            }
            let owner = owners[value.index()];
            // A name without a number is that of the equation itself.
            let derived = node.name.is_none() || node.name.suffix > 0;
            let places = view.tables.sources.places(node.sources);
            let part = share / places.len().max(1) as f64;
            if places.len() == 0 {
                parts.push((None, owner, false, part));
            }
            parts.extend(places.map(|place| (Some(place), owner, derived, part)));
        }
        let key = |&(place, owner, ..): &(Option<SourcePlace>, Option<Symbol>, bool, f64)| {
            // Operations of one place are one equation whatever their names.
            (place, if place.is_some() { None } else { owner })
        };
        // Stable, so that sums and names do not depend on anything but the
        // function.
        parts.sort_by_key(key);
        let equations = parts.chunk_by(|a, b| key(a) == key(b)).map(|parts| {
            let itself = parts.iter().find(|(_, _, derived, _)| !derived);
            EquationBlame {
                place: parts[0].0,
                name: itself.unwrap_or(&parts[0]).1,
                share: parts.iter().map(|part| part.3).sum(),
                operations: parts.len() as u32,
            }
        });
        let mut equations: Vec<EquationBlame> = equations.collect();
        equations.sort_by(|a, b| b.share.total_cmp(&a.share));
        equations.truncate(most);
        equations
    }
}

/// The entries with the largest shares that are not zero.
fn largest<T>(mut shares: Vec<(T, f64)>, most: usize) -> Vec<(T, f64)> {
    shares.retain(|(_, share)| *share > 0.0);
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    shares.truncate(most);
    shares
}

/// For every assignment one over the largest exact element of its array; 0
/// for arrays that are zero. Errors times weights are comparable.
pub fn output_weights(function: &Function, run: &AdjointRun<'_>) -> Vec<f64> {
    let holds = |assignment: usize| function.output_array(function.assignments[assignment].output);
    let size = |assignment: usize| run.exact()[run.tape().output_slot(assignment)].abs();
    let mut sizes = vec![0.0f64; function.outputs().len()];
    for assignment in 0..function.assignments.len() {
        let array = &mut sizes[holds(assignment)];
        *array = array.max(size(assignment));
    }
    let assignments = 0..function.assignments.len();
    let weight = |assignment| match sizes[holds(assignment)] {
        0.0 => 0.0,
        size => 1.0 / size,
    };
    assignments.map(weight).collect()
}

/// For every node the symbol of its definition: its own, or that of the
/// expression of which it is an inner node. Expressions of outputs have none.
fn owners(function: &Function) -> Vec<Option<Symbol>> {
    let named = |value: &robovec_ir::Node| (!value.name.is_none()).then_some(value.name.base);
    let mut owners: Vec<Option<Symbol>> = function.nodes().iter().map(named).collect();
    for (value, node) in function.values().rev() {
        for operand in node.operands().iter().filter_map(|operand| operand.value()) {
            if owners[operand.index()].is_none() {
                owners[operand.index()] = owners[value.index()];
            }
        }
    }
    owners
}
