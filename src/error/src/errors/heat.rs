//! The heat of equations: their shares in the error of the outputs.

use robovec_analysis::adjoint::{AdjointRun, Blame, LANES, Tape, output_weights};
use robovec_ir::print::print_operand;
use robovec_ir::states::States;
use robovec_ir::{Format, View};
use serde::Serialize;

/// Number of equations named as the hottest.
pub const MAX_EQUATIONS: usize = 12;

/// Number of inputs named.
const MAX_INPUTS: usize = 4;

/// Maximum of values times outputs times states for heat, under a second.
const WORK: usize = 1 << 25;

/// States that heat is averaged over where the work allows it.
const STATES: usize = 4;

/// The equations with the largest shares in the error.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Heat {
    /// The number format that was run.
    pub format: String,
    /// Number of states over which shares are averaged.
    pub states: u32,
    /// Seed of the states.
    pub seed: u64,
    /// Number of outputs of each state whose errors were traced: those with the
    /// largest errors, relative to the largest element of their array.
    pub outputs: usize,
    /// Number of states without a result, such as after an overflow.
    pub refused: u32,
    /// The hottest equations.
    pub equations: Vec<HotEquation>,
    /// Inputs that the format cannot hold.
    pub inputs: Vec<HotInput>,
    /// The share of literals that the format cannot hold.
    pub literals: f64,
}

/// The share of an equation.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct HotEquation {
    /// Name of the equation, where it has one.
    pub name: Option<String>,
    /// Its file, where that is known.
    pub file: Option<String>,
    /// Its line, from 1.
    pub line: Option<u32>,
    /// Its column, from 1.
    pub column: Option<u32>,
    /// Its part of the error, 0 to 1.
    pub share: f64,
    /// Number of its operations that lost something.
    pub operations: u32,
}

/// The share of an input that the format cannot hold.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct HotInput {
    /// The element (`q[3]`).
    pub name: String,
    /// Its part of the error, 0 to 1.
    pub share: f64,
}

/// Blames operations for the errors of outputs in the first states, within a
/// bounded amount of work; with the number of states and of outputs in each.
pub fn blame(view: View<'_>, tape: &Tape, format: Format, states: &States) -> (Blame, u32, usize) {
    let outputs: Vec<usize> = (0..tape.outputs()).collect();
    let size = tape.nodes().max(1);
    let count = WORK / size / outputs.len().max(1);
    let count = count.clamp(1, STATES);
    let most = (WORK / size / count).clamp(LANES, outputs.len().max(LANES));
    let blame = blame_of(view, tape, format, states, 0..count as u32, &outputs, most);
    (blame, count as u32, most.min(outputs.len()))
}

/// As [`blame`], over given states and some of the worst of given outputs.
pub(super) fn blame_of(
    view: View<'_>,
    tape: &Tape,
    format: Format,
    states: &States,
    range: std::ops::Range<u32>,
    outputs: &[usize],
    most: usize,
) -> Blame {
    let mut blame = Blame::new(tape);
    for state in range {
        let run = AdjointRun::of(view.function, tape, format, &states.draw(view, state));
        let mut chosen = outputs.to_vec();
        if most < chosen.len() {
            let weights = output_weights(view.function, &run);
            let error =
                |output: usize| run.errors()[tape.output_slot(output)].abs() * weights[output];
            chosen.sort_by(|&a, &b| error(b).total_cmp(&error(a)));
            chosen.truncate(most);
        }
        blame.add(view.function, &run, &chosen);
    }
    blame
}

impl Heat {
    /// The heat of a function in a format, over random states.
    pub fn measure(view: View<'_>, format: Format, states: &States) -> Heat {
        let tape = Tape::new(view.function);
        let (found, count, outputs) = blame(view, &tape, format, states);
        Heat::new(
            view,
            &tape,
            format,
            &found,
            (states.seed(), count, outputs),
            MAX_EQUATIONS,
        )
    }

    /// Results with names and places.
    pub(super) fn new(
        view: View<'_>,
        tape: &Tape,
        format: Format,
        blame: &Blame,
        (seed, states, outputs): (u64, u32, usize),
        most: usize,
    ) -> Heat {
        let sources = &view.tables.sources;
        let equations = blame.equations(view, most).into_iter().map(|equation| {
            let place = equation.place;
            let name = equation.name.map(|name| view.tables.symbols.text(name));
            HotEquation {
                name: name.map(str::to_owned),
                file: place.map(|place| sources.files[place.file as usize].clone()),
                line: place.map(|place| place.line),
                column: place.map(|place| place.column),
                share: equation.share,
                operations: equation.operations,
            }
        });
        let inputs = blame.inputs(tape, MAX_INPUTS).into_iter();
        Heat {
            format: format.to_string(),
            states,
            seed,
            outputs,
            refused: blame.refused(),
            equations: equations.collect(),
            inputs: inputs
                .map(|(input, share)| HotInput {
                    name: print_operand(view, input.into()),
                    share,
                })
                .collect(),
            literals: blame.literals(tape),
        }
    }
}
