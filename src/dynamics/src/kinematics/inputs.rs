//! Sources of the inputs of equations: the model's parameters, then a state.

use super::LoopClosure;
use robovec_ir::{Input, View};
use robovec_model::{CutKind, Joint, Model, Nature};
use robovec_num::random::Random;

/// Inputs of a model's equations besides parameters, counted from 0.
#[derive(Clone, PartialEq, Debug)]
pub struct MotionState {
    /// Time, s.
    pub time: f64,
    /// Joint positions, m or rad.
    pub q: Vec<f64>,
    /// Joint velocities.
    pub qd: Vec<f64>,
    /// Joint accelerations.
    pub qdd: Vec<f64>,
    /// Forces and torques of the joints.
    pub joint_forces: Vec<f64>,
    /// External force on the body of each joint, in its frame, N.
    pub frc: Vec<[f64; 3]>,
    /// External torque about its centre of mass, in its frame, N m.
    pub trq: Vec<[f64; 3]>,
    /// The forces of the links, N.
    pub links: Vec<f64>,
    /// The external forces: force and torque in the base frame, and where the
    /// force acts in the body's frame.
    pub external: Vec<[f64; 9]>,
}

impl MotionState {
    /// The direction without any change.
    pub fn none(model: &Model) -> MotionState {
        let mut state = MotionState::initial(model);
        for numbers in [&mut state.q, &mut state.qd, &mut state.qdd] {
            numbers.fill(0.0);
        }
        state
    }

    /// A model at rest in its initial position, without forces.
    pub fn initial(model: &Model) -> MotionState {
        let joints = model.joints.len();
        let initial = |place: usize| {
            let number = |joint: &Joint| joint.initial[place];
            model.joints.iter().map(number).collect()
        };
        MotionState {
            time: 0.0,
            q: initial(0),
            qd: initial(1),
            qdd: initial(2),
            joint_forces: vec![0.0; joints],
            frc: vec![[0.0; 3]; joints],
            trq: vec![[0.0; 3]; joints],
            links: vec![0.0; model.links.len()],
            external: vec![[0.0; 9]; model.forces.len()],
        }
    }
}

/// Source of one input element.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum InputSource {
    Parameter(f64),
    Time,
    Position(usize),
    Velocity(usize),
    Acceleration(usize),
    JointForce(usize),
    Force(usize, usize),
    Torque(usize, usize),
    Link(usize),
    External(usize, usize),
}

/// The source of every input element of a function.
#[derive(Clone, PartialEq, Debug)]
pub struct InputSources {
    sources: Vec<InputSource>,
}

impl InputSources {
    /// Finds the sources of a function's inputs in a model. Elements beyond
    /// the model's joints, points or rods are an error even where no equation
    /// reads them: the function belongs to another model.
    ///
    /// # Errors
    ///
    /// The name of the first element that the model does not have.
    pub fn new(model: &Model, view: View<'_>) -> Result<InputSources, String> {
        InputSources::with_numbers(model, view, |_, _| None)
    }

    /// As [`InputSources::new`], with numbers of the user that the model lacks.
    ///
    /// # Errors
    ///
    /// The name of the first element that neither has.
    pub fn with_numbers(
        model: &Model,
        view: View<'_>,
        numbers: impl Fn(&str, &[u32]) -> Option<f64>,
    ) -> Result<InputSources, String> {
        let function = view.function;
        let mut sources = Vec::with_capacity(function.input_len());
        for index in 0..function.input_len() {
            let (array, indices, rank) = function.input_element(Input(index as u32));
            let name = view.tables.symbols.text(array.name);
            let given = || numbers(name, &indices[..rank]).map(InputSource::Parameter);
            let source = source(model, name, &indices[..rank]).or_else(given);
            sources.push(source.ok_or_else(|| element_name(name, &indices[..rank]))?);
        }
        Ok(InputSources { sources })
    }

    /// The flattened inputs in a state of the model.
    pub fn gather(&self, state: &MotionState) -> Vec<f64> {
        self.sources
            .iter()
            .map(|source| match *source {
                InputSource::Parameter(number) => number,
                InputSource::Time => state.time,
                InputSource::Position(joint) => state.q[joint],
                InputSource::Velocity(joint) => state.qd[joint],
                InputSource::Acceleration(joint) => state.qdd[joint],
                InputSource::JointForce(joint) => state.joint_forces[joint],
                InputSource::Force(component, joint) => state.frc[joint][component],
                InputSource::Torque(component, joint) => state.trq[joint][component],
                InputSource::Link(link) => state.links[link],
                InputSource::External(force, component) => state.external[force][component],
            })
            .collect()
    }
}

impl InputSources {
    /// Derivatives of the inputs along a direction; `None` for parameters.
    pub fn gather_along(&self, direction: &MotionState) -> Vec<Option<f64>> {
        let numbers = self.gather(direction).into_iter().zip(&self.sources);
        let moves = |(number, source): (f64, &InputSource)| {
            let fixed = matches!(source, InputSource::Parameter(_));
            (!fixed).then_some(number)
        };
        numbers.map(moves).collect()
    }
}

/// An element as Robotran's text form writes it: `dpt[3,1]`.
pub fn element_name(array: &str, indices: &[u32]) -> String {
    if indices.is_empty() {
        return array.to_owned();
    }
    let indices: Vec<String> = indices.iter().map(u32::to_string).collect();
    format!("{array}[{}]", indices.join(","))
}

/// The parameter of a model that an element of Robotran's arrays `dpt`, `l`,
/// `m`, `In`, `g` and `lrod` names; `None` when it names none.
pub fn parameter(model: &Model, array: &str, indices: &[u32]) -> Option<f64> {
    match source(model, array, indices)? {
        InputSource::Parameter(number) => Some(number),
        _ => None,
    }
}

/// The source of an element of an input array; `None` if the model has none.
pub(crate) fn source(model: &Model, array: &str, indices: &[u32]) -> Option<InputSource> {
    // Indices count from 1.
    let place = |index: u32| index.checked_sub(1).map(|index| index as usize);
    let joint = |index: u32| place(index).filter(|&joint| joint < model.joints.len());
    match (array, indices) {
        ("tsim", []) => Some(InputSource::Time),
        ("q", &[i]) => joint(i).map(InputSource::Position),
        ("qd", &[i]) => joint(i).map(InputSource::Velocity),
        ("qdd", &[i]) => joint(i).map(InputSource::Acceleration),
        ("Qq", &[i]) => joint(i).map(InputSource::JointForce),
        ("frc" | "trq", &[component, i]) => {
            let (component, joint) = (place(component).filter(|&c| c < 3)?, joint(i)?);
            Some(match array {
                "frc" => InputSource::Force(component, joint),
                _ => InputSource::Torque(component, joint),
            })
        }
        ("dpt", &[component, i]) => {
            let point = model.points.get(place(i)?)?;
            let number = point.coordinates.get(place(component)?)?;
            Some(InputSource::Parameter(*number))
        }
        ("g", &[component]) => {
            let number = model.gravity.get(place(component)?)?;
            Some(InputSource::Parameter(*number))
        }
        ("m", &[i]) => {
            let (mass, _, _) = moved(model, joint(i)?);
            Some(InputSource::Parameter(mass))
        }
        ("l", &[component, i]) => {
            let (_, center, _) = moved(model, joint(i)?);
            Some(InputSource::Parameter(*center.get(place(component)?)?))
        }
        ("In", &[entry, i]) => {
            let (_, _, matrix) = moved(model, joint(i)?);
            Some(InputSource::Parameter(*matrix.get(place(entry)?)?))
        }
        ("lrod", &[i]) => {
            let lengths = model.cuts.iter().filter_map(|cut| match cut.kind {
                CutKind::Rod(length) => Some(length),
                CutKind::Ball | CutKind::Solid | CutKind::Coupling(_) => None,
            });
            lengths.skip(place(i)?).map(InputSource::Parameter).next()
        }
        (_, []) => {
            let number = ["Flink", "Flnk"]
                .into_iter()
                .find_map(|prefix| array.strip_prefix(prefix))?;
            let link = place(number.parse().ok()?)?;
            (link < model.links.len()).then_some(InputSource::Link(link))
        }
        (_, &[component]) => {
            let force = place(array.strip_prefix("SWr")?.parse().ok()?)?;
            let component = place(component).filter(|&component| component < 9)?;
            (force < model.forces.len()).then_some(InputSource::External(force, component))
        }
        _ => None,
    }
}

/// Mass, centre of mass and inertia that a joint moves.
fn moved(model: &Model, joint: usize) -> (f64, [f64; 3], [f64; 9]) {
    match model.body_of(joint) {
        Some(body) => (body.mass, body.center, body.inertia_matrix()),
        None => (0.0, [0.0; 3], [0.0; 9]),
    }
}

/// Maximum distance of drawn joints from their start, m or rad.
const REACH: f64 = 0.2;

/// Maximum number of times a state is drawn again, ever nearer to the start.
const ATTEMPTS: i32 = 20;

/// Random states around the closed initial one, with random forces. Positions
/// of joints are drawn near their start, and the loops closed again. Empty
/// where the loops do not close; a state that is not found is left out.
pub fn closed_states(loops: &LoopClosure<'_>, count: usize, seed: u64) -> Vec<MotionState> {
    let mut start = MotionState::initial(loops.model);
    let Ok(partition) = loops.start(&mut start) else {
        return Vec::new();
    };
    let mut random = Random::new(seed);
    let drawn = (0..count).filter_map(|_| {
        (0..ATTEMPTS).find_map(|attempt| {
            let reach = REACH * 0.5f64.powi(attempt);
            let mut state = drawn(loops.model, &start, reach, &mut random);
            loops.close(&mut state, &partition).ok().map(|()| state)
        })
    });
    drawn.collect()
}

/// A state around another one: positions within `reach`, all else within one.
fn drawn(model: &Model, start: &MotionState, reach: f64, random: &mut Random) -> MotionState {
    let mut state = start.clone();
    for (joint, description) in model.joints.iter().enumerate() {
        // Dependent joints only start to be closed from here.
        if description.nature != Nature::Dependent {
            state.q[joint] += reach * random.signed();
            state.qd[joint] = random.signed();
            state.qdd[joint] = random.signed();
        }
        state.joint_forces[joint] = random.signed();
        state.frc[joint] = [(); 3].map(|()| random.signed());
        state.trq[joint] = [(); 3].map(|()| random.signed());
    }
    state
}
