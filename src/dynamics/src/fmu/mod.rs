//! FMUs of FMI 3.0: a model with laws, for model exchange and co-simulation.
//!
//! It computes as `sim --whole-step`: an evaluation moves driven joints, closes
//! the loops with `loop_positions` and `loop_velocities`, computes forces by the
//! laws, and takes accelerations from `accelred`. States are positions and
//! velocities of the independent joints. Directional derivatives come from the
//! same functions differentiated along a direction; at closed loops the
//! derivative of a round of Newton's method is that of the closed positions.
//!
//! Sensors and named frames are outputs that are computed when they are read.
//!
//! All variables are in one array, whose places are the value references; a
//! generated function has a table of the places of inputs and results.

mod description;
mod functions;
mod laws;
mod source;
mod variables;

use crate::generate::{Formulation, GenerateError, cuts_of_rows};
use crate::motion::{
    EquationSetting, EventDirection, EventQuantity, Laws, MotionError, MultibodySystem,
};
use robovec_cgen::kind::file_stem;
use robovec_model::{Model, Nature};
use variables::FmuVariables;
use variables::VariableRole::{Guess, Input, Output, Parameter, Sensed, State};

/// Files of an FMU.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Fmu {
    /// Name of its binary and its C, without extension.
    pub identifier: String,
    /// Texts by their paths in the archive.
    pub files: Vec<(String, String)>,
    /// Numbers of states, inputs, parameters and outputs.
    pub counts: [usize; 4],
}

/// Facts about a model in motion.
struct FmuPlan {
    /// Joints from 0, ascending.
    independent: Vec<usize>,
    dependent: Vec<usize>,
    row_cuts: Vec<usize>,
    /// Signs of the lengths of links.
    link_signs: Vec<f64>,
    watched: Vec<WatchedSlot>,
}

/// A quantity that passes a value.
struct WatchedSlot {
    slot: u32,
    value: f64,
    /// 1 for rising, -1 for falling, 0 for both.
    direction: i8,
    stops: bool,
}

impl Fmu {
    /// Makes the FMU of a model with its laws.
    pub fn new(model: &Model, laws: &Laws, formulation: Formulation) -> Result<Fmu, MotionError> {
        let setting = EquationSetting {
            formulation,
            whole_step: true,
            ..EquationSetting::default()
        };
        let (system, state) = MultibodySystem::new(model, laws.clone(), &setting)?;
        let partition = system.partition();
        let signs = system.link_lengths().iter().map(|length| length.signum());
        let mut plan = FmuPlan {
            independent: sorted(&partition.independent),
            dependent: sorted(&partition.dependent),
            row_cuts: cuts_of_rows(model)?,
            link_signs: signs.collect(),
            watched: Vec::new(),
        };
        if plan.independent.is_empty() {
            return Err(GenerateError::Motionless(model.name.clone()).into());
        }
        let prescribed = prescribed(model, laws);
        let rows = plan.row_cuts.len();
        let mut variables =
            FmuVariables::new(model, &plan.independent, &prescribed, &state.q, rows);
        variables.add_laws(&system.settled_laws(), &prescribed);
        plan.watch(laws, &variables);
        let functions = functions::functions(&mut variables, formulation)?;
        let identifier = identifier(&model.name);
        // The token names the content.
        let untitled = source::source(&plan, &variables, &functions, "");
        let token = format!("robovec-{:016x}", fingerprint(&untitled));
        let code = source::source(&plan, &variables, &functions, &token);
        let description = description::description(&plan, &variables, (&identifier, &token));
        let count = |role| variables.list.iter().filter(|one| one.role == role).count();
        Ok(Fmu {
            counts: [
                count(State),
                count(Input),
                count(Parameter),
                count(State) + count(Guess) + count(Output) + count(Sensed),
            ],
            files: vec![
                ("modelDescription.xml".to_owned(), description),
                (format!("sources/{identifier}.c"), code),
                (
                    "sources/buildDescription.xml".to_owned(),
                    description::build_description(&identifier),
                ),
            ],
            identifier,
        })
    }
}

impl FmuPlan {
    /// Contacts, and events of the laws.
    fn watch(&mut self, laws: &Laws, variables: &FmuVariables<'_>) {
        let at = |block: &str, index: usize| variables.block(block) + index as u32;
        let forces = variables.laws.ground.iter().enumerate();
        let contacts = forces.filter(|(_, ground)| **ground != 0);
        let contacts = contacts.map(|(force, _)| WatchedSlot {
            slot: at("AT_GAPS", force),
            value: 0.0,
            direction: 0,
            stops: false,
        });
        let events = laws.events.iter().map(|event| WatchedSlot {
            slot: match event.quantity {
                EventQuantity::Position => at("AT_Q", event.subject),
                EventQuantity::Velocity => at("AT_QD", event.subject),
                EventQuantity::Gap => at("AT_GAPS", event.subject),
            },
            value: event.value,
            direction: match event.direction {
                EventDirection::Both => 0,
                EventDirection::Rising => 1,
                EventDirection::Falling => -1,
            },
            stops: event.stop,
        });
        self.watched = contacts.chain(events).collect();
    }
}

/// Driven joints that a law moves; the importer moves the others.
fn prescribed(model: &Model, laws: &Laws) -> Vec<usize> {
    let joints = model.joints.iter().zip(&laws.drives).enumerate();
    let moved = joints.filter(|(_, (joint, law))| {
        let moves = joint.has_velocity && joint.has_acceleration;
        joint.nature == Nature::Driven && moves && (law.amplitude != 0.0 || law.offset.is_some())
    });
    moved.map(|(index, _)| index).collect()
}

fn sorted(joints: &[usize]) -> Vec<usize> {
    let mut sorted = joints.to_vec();
    sorted.sort_unstable();
    sorted
}

/// A model's name as an identifier of C.
fn identifier(name: &str) -> String {
    let stem = file_stem(name).replace('-', "_");
    match stem.starts_with(|first: char| first.is_ascii_digit()) {
        true => format!("model_{stem}"),
        false => stem,
    }
}

/// The hash of Fowler, Noll and Vo (FNV-1a, 64 bits).
fn fingerprint(text: &str) -> u64 {
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    text.bytes().fold(0xcbf2_9ce4_8422_2325, step)
}
