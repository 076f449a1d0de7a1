//! Free motion of trees, all in one arithmetic, the integrator's state too.
//!
//! Elsewhere in this room only equations are evaluated in short numbers and the
//! integrator keeps binary64. On a machine with one format for everything,
//! every step adds a small change to a state of many digits: shorter steps are
//! more, and the total rounding error is larger, as these functions show.

use super::MotionError;
use super::energy::{self, Momenta};
use super::integrate::{IntegratedState, TimeStep};
use crate::generate::{Formulation, GenerationRequest, Options, generate};
use crate::kinematics::{InputSources, MotionState, StateError};
use robovec_ir::evaluate::evaluate;
use robovec_ir::{Function, Input, Module, View};
use robovec_model::Model;
use robovec_num::arithmetic::Arithmetic;
use robovec_robotran::FunctionKind;

/// The accelerations of a model without loops, forces and drives.
pub struct FreeMotion<'m> {
    model: &'m Model,
    function: Function,
    inputs: InputSources,
    /// Places of positions and velocities among the inputs, and their joints.
    positions: Vec<(usize, usize)>,
    velocities: Vec<(usize, usize)>,
    /// The joint of each assignment.
    joints: Vec<usize>,
}

/// Length of steps.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Stepping {
    /// Way in which one is made.
    pub how: TimeStep,
    /// Number of steps.
    pub steps: u64,
    /// Number of times energies and momenta are computed.
    pub samples: u64,
}

/// Drift of a conserved quantity.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub struct Drift {
    /// Largest change of the energy, relative to the largest kinetic energy.
    pub energy: f64,
    /// The largest change of linear or angular momentum about the base's
    /// origin, relative to the sum of the sizes over all bodies.
    pub momentum: f64,
}

/// An arithmetic, and how its numbers are read.
pub struct Calculus<'a, A: Arithmetic> {
    /// The arithmetic.
    pub arithmetic: &'a A,
    /// A number in binary64.
    pub read: fn(A::Number) -> f64,
}

impl<'m> FreeMotion<'m> {
    /// Generates the accelerations of a model.
    ///
    /// # Errors
    ///
    /// [`MotionError::Generate`]; [`StateError::Element`] when the equations
    /// read an element that the model does not have.
    pub fn new(model: &'m Model, formulation: Formulation) -> Result<FreeMotion<'m>, MotionError> {
        let request = GenerationRequest {
            function: FunctionKind::Accelred,
            formulation,
            options: Options {
                external_forces: false,
                ..Options::default()
            },
        };
        let Module {
            tables,
            mut functions,
        } = generate(model, &request)?;
        // One function is what was asked for.
        let function = functions.pop().expect("the generator gives a function");
        let view = View {
            tables: &tables,
            function: &function,
        };
        let inputs = InputSources::new(model, view).map_err(|element| StateError::Element {
            function: FunctionKind::Accelred.name().to_owned(),
            element,
        })?;
        let places = |name: &str| {
            let elements = (0..function.input_len()).filter_map(|place| {
                let (array, indices, _) = function.input_element(Input(place as u32));
                let named = tables.symbols.text(array.name) == name;
                named.then(|| (place, indices[0] as usize - 1))
            });
            elements.collect::<Vec<(usize, usize)>>()
        };
        let joints = function.assignments.iter().map(|assignment| {
            let (_, indices, _) = function.output_element(assignment.output);
            indices[0] as usize - 1
        });
        Ok(FreeMotion {
            positions: places("q"),
            velocities: places("qd"),
            joints: joints.collect(),
            model,
            inputs,
            function,
        })
    }

    /// Integrates from an initial state and returns the changes of energy and
    /// momenta; not a number when the motion does not stay finite.
    pub fn drift<A: Arithmetic, S: Arithmetic>(
        &self,
        slopes: Calculus<'_, A>,
        state: Calculus<'_, S>,
        initial: &MotionState,
        stepping: Stepping,
    ) -> Drift {
        let inputs = self.inputs.gather(initial);
        let literal = |&number: &f64| slopes.arithmetic.literal(number);
        let start: Vec<f64> = initial.q.iter().chain(&initial.qd).copied().collect();
        let (kept, read) = (state.arithmetic, state.read);
        let mut numbers = IntegratedState::new(kept, &start);
        let mut run = FreeSlopes {
            motion: self,
            inputs: inputs.iter().map(literal).collect(),
            slopes,
            state,
        };
        let read = |numbers: &[S::Number]| -> Vec<f64> {
            numbers.iter().map(|&number| read(number)).collect()
        };
        let mut watch = EnergyMonitor::new(self.model, initial.clone());
        watch.look(&read(&numbers.numbers));
        let samples = stepping.samples.clamp(1, stepping.steps.max(1));
        let mut done = 0;
        for sample in 1..=samples {
            let until =
                (u128::from(stepping.steps) * u128::from(sample) / u128::from(samples)) as u64;
            while done < until {
                numbers.step(kept, stepping.how, &mut |place| run.slope(place));
                done += 1;
            }
            if !watch.look(&read(&numbers.numbers)) {
                break;
            }
        }
        watch.drift
    }
}

/// The slopes of a run under way.
struct FreeSlopes<'a, A: Arithmetic, S: Arithmetic> {
    motion: &'a FreeMotion<'a>,
    inputs: Vec<A::Number>,
    slopes: Calculus<'a, A>,
    state: Calculus<'a, S>,
}

impl<A: Arithmetic, S: Arithmetic> FreeSlopes<'_, A, S> {
    /// The slopes at a place: the velocities there and the accelerations.
    fn slope(&mut self, place: &[S::Number]) -> Vec<S::Number> {
        let joints = place.len() / 2;
        let motion = self.motion;
        for &(input, joint) in &motion.positions {
            self.inputs[input] = self
                .slopes
                .arithmetic
                .literal((self.state.read)(place[joint]));
        }
        for &(input, joint) in &motion.velocities {
            let number = (self.state.read)(place[joints + joint]);
            self.inputs[input] = self.slopes.arithmetic.literal(number);
        }
        let found = evaluate(&motion.function, self.slopes.arithmetic, &self.inputs);
        assert_eq!(
            found.len(),
            motion.joints.len(),
            "one acceleration per joint"
        );
        let mut slope = place[joints..].to_vec();
        slope.resize(place.len(), self.state.arithmetic.literal(0.0));
        for (&joint, number) in motion.joints.iter().zip(found) {
            slope[joints + joint] = self.state.arithmetic.literal((self.slopes.read)(number));
        }
        slope
    }
}

struct EnergyMonitor<'m> {
    model: &'m Model,
    state: MotionState,
    start: Option<(f64, Momenta)>,
    kinetic: f64,
    change: f64,
    drift: Drift,
}

impl<'m> EnergyMonitor<'m> {
    fn new(model: &'m Model, state: MotionState) -> EnergyMonitor<'m> {
        EnergyMonitor {
            model,
            state,
            start: None,
            kinetic: 0.0,
            change: 0.0,
            drift: Drift::default(),
        }
    }

    /// Looks at a state; false when it is not finite.
    fn look(&mut self, numbers: &[f64]) -> bool {
        let joints = self.state.q.len();
        self.state.q.copy_from_slice(&numbers[..joints]);
        self.state.qd.copy_from_slice(&numbers[joints..]);
        let (kinetic, potential) = energy::energies(self.model, &self.state);
        let momenta = energy::momenta(self.model, &self.state);
        let (energy, start) = *self.start.get_or_insert((kinetic + potential, momenta));
        if !(kinetic + potential).is_finite() {
            self.drift = Drift {
                energy: f64::NAN,
                momentum: f64::NAN,
            };
            return false;
        }
        self.kinetic = self.kinetic.max(kinetic);
        self.change = self.change.max((kinetic + potential - energy).abs());
        self.drift.energy = self.change / self.kinetic.max(f64::MIN_POSITIVE);
        self.drift.momentum = self.drift.momentum.max(momenta.distance(&start));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_model::family::built_in;
    use robovec_num::arithmetic::{Binary32, Binary64};

    fn pendulum(compensated: bool, short: bool) -> Drift {
        let model = built_in("double-pendulum").expect("a family");
        let motion = FreeMotion::new(&model, Formulation::Recursive).expect("it has equations");
        let stepping = Stepping {
            how: TimeStep {
                step: 1e-4,
                compensated,
            },
            steps: 20_000,
            samples: 20,
        };
        let initial = MotionState::initial(&model);
        let wide = || Calculus {
            arithmetic: &Binary64,
            read: |x| x,
        };
        let narrow = || Calculus {
            arithmetic: &Binary32,
            read: f64::from,
        };
        if short {
            motion.drift(narrow(), narrow(), &initial, stepping)
        } else {
            motion.drift(wide(), wide(), &initial, stepping)
        }
    }

    #[test]
    fn energy_stays_and_compensation_keeps_it() {
        let wide = pendulum(false, false).energy;
        assert!(wide < 1e-12, "{wide:e}");
        let (plain, kept) = (pendulum(false, true).energy, pendulum(true, true).energy);
        assert!(plain < 1e-3 && kept * 4.0 < plain, "{plain:e} {kept:e}");
    }
}
