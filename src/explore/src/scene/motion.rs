//! The sections `[motion]` and `[neglect]` of a scene file: the motion by which
//! a program is judged, and the parts it may leave out.

use super::document::{
    DocumentProblems, DocumentRange, DocumentTable, DocumentValue, array, get, limited, only_keys,
    string, strings, table,
};
use super::inputs::InputReader;
use super::{ERROR, INPUT, PIPELINE, SceneFile, SceneSubject};
use robovec_dynamics::kinematics::MotionState;
use robovec_dynamics::motion::{
    EquationSetting, Laws, MotionError, MultibodySystem, SimulationRun, mean_position,
};
use robovec_framework::option_words;
use robovec_framework::options::OptionValue;
use robovec_framework::scene::Scene;
use robovec_ir::{Format, Machine, Module};
use robovec_model::{Model, Nature};
use robovec_num::limits::NumberLimit;
use robovec_passes::registry::REGISTRY;
use robovec_robotran::FunctionKind;
use std::path::PathBuf;
use toml::de::DeValue;

/// Length of the motion, in seconds.
pub(super) const TIME: NumberLimit =
    NumberLimit::real(1e-6, 1e3, "every candidate is simulated for this time");

option_words! {
    /// A kind of part that can be left out.
    #[derive(PartialOrd, Ord)]
    pub enum NeglectKind {
        /// The velocity of a joint in the equations of motion: its effect on
        /// centrifugal, Coriolis and gyroscopic forces.
        Velocities = "velocities",
        /// The curvature of sine and cosine of a joint's angle.
        Angles = "angles",
        /// The moments of inertia of a body.
        Inertias = "inertias",
        /// The mass and the moments of inertia of a body.
        Masses = "masses",
        /// The law of forces of a joint.
        JointForces = "joint-forces",
        /// A link.
        Links = "links",
        /// An external force.
        ExternalForces = "external-forces",
        /// Gravity.
        Gravity = "gravity",
        /// A joint, which is locked at its mean position.
        Joints = "joints",
    }
}

/// The motion that a scene is judged by, as its file describes it.
#[derive(Clone, PartialEq, Debug)]
pub struct SceneMotion {
    /// The file of laws that make the motion, else gravity alone does.
    pub laws: Option<PathBuf>,
    /// Length of the motion, s.
    pub time: f64,
    /// Error allowed of every watched joint, over its largest displacement.
    pub error: f64,
    /// Drift of energy allowed without work, over the largest kinetic energy.
    pub energy: Option<f64>,
    /// The joints whose motion is watched, by index: those that the file
    /// names, else those whose accelerations the scene needs.
    pub watch: Vec<usize>,
    /// Joints, by index, with the range their position at the start is drawn
    /// from, m or rad; the others start as in the model.
    pub start: Vec<(usize, [f64; 2])>,
}

impl SceneMotion {
    /// Positions at the start: a draw within the range of every joint that has
    /// one. The draws are those of a sequence of Weyl, so that no two are near
    /// each other; draw 0 is the high end of every range.
    pub fn start(&self, draw: u32) -> Vec<(usize, f64)> {
        let place = |&(joint, [low, high]): &(usize, [f64; 2])| {
            let turn = f64::from(draw) * (0.618_033_988_75 + 0.754_877_666_25 * joint as f64);
            (joint, high - (high - low) * turn.fract())
        };
        self.start.iter().map(place).collect()
    }

    /// True when starts differ from each other.
    pub fn varies(&self) -> bool {
        self.start.iter().any(|(_, [low, high])| low < high)
    }

    /// Tolerance of a step, absolute and relative, which adds next to no error.
    pub fn tolerance(&self) -> f64 {
        (1e-5 * self.error).clamp(1e-10, 1e-6)
    }
}

/// Parts that a scene may leave out, from its file.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct NeglectWish {
    /// The kinds of parts that may be left out; empty: all.
    pub kinds: Vec<NeglectKind>,
    /// The names of the parts that must not be left out.
    pub keep: Vec<String>,
}

/// The keys of the sections.
const MOTION_KEYS: [&str; 6] = ["laws", "time", "error", "energy", "watch", "start"];
const NEGLECT_KEYS: [&str; 2] = ["kinds", "keep"];

impl InputReader<'_> {
    /// The numbers, from 1, of the joints listed under `small`.
    pub(super) fn small(&mut self, file: &DocumentTable<'_>) -> Vec<u32> {
        let Some(value) = get(file, "small") else {
            return Vec::new();
        };
        let Some(model) = self.model else {
            let message = "the equations have their sines and cosines already: only a model's \
                           angles can be taken as small";
            self.problems.add(value.span(), message);
            return Vec::new();
        };
        let mut small: Vec<u32> = Vec::new();
        for (name, span) in strings(value, self.problems) {
            let Some(number) = self.problems.take(&span, self.arrays.joint(name)) else {
                continue;
            };
            if !model.joints[number as usize - 1].kind.is_revolute() {
                let message = format!("the joint '{name}' slides: it has no angle");
                self.problems.add(span, message);
            } else if small.contains(&number) {
                let message = format!("the joint '{name}' is listed already");
                self.problems.add(span, message);
            } else {
                small.push(number);
            }
        }
        small.sort_unstable();
        small
    }

    /// Content of the section `[motion]`.
    pub(super) fn motion(&mut self, value: &DocumentValue<'_>) -> Option<SceneMotion> {
        let section = self.section(value, &MOTION_KEYS)?;
        let laws = get(section, "laws").and_then(|value| string(value, self.problems));
        let watch = get(section, "watch").map_or(Vec::new(), |value| self.watched(value));
        let start = get(section, "start").map_or(Vec::new(), |value| self.starts(value));
        let number = |key: &str, limit, default: f64, problems: &mut DocumentProblems| {
            let value = get(section, key);
            value.map_or(Some(default), |value| {
                limited(value, (key, limit), problems)
            })
        };
        let time = number("time", TIME, 10.0, self.problems)?;
        let error = number("error", ERROR, 0.01, self.problems)?;
        let energy = get(section, "energy")
            .map(|value| limited(value, ("energy", ERROR), self.problems).ok_or(()));
        let energy = energy.transpose().ok()?;
        Some(SceneMotion {
            laws: laws.map(PathBuf::from),
            time,
            error,
            energy,
            watch,
            start,
        })
    }

    /// Content of the section `[neglect]`.
    pub(super) fn neglect(&mut self, value: &DocumentValue<'_>) -> Option<NeglectWish> {
        let section = self.section(value, &NEGLECT_KEYS)?;
        Some(NeglectWish {
            kinds: get(section, "kinds").map_or(Vec::new(), |value| self.kinds(value)),
            keep: get(section, "keep").map_or(Vec::new(), |value| self.kept(value)),
        })
    }

    /// A section about a model that moves.
    fn section<'a, 't>(
        &mut self,
        value: &'a DocumentValue<'t>,
        keys: &[&str],
    ) -> Option<&'a DocumentTable<'t>> {
        let section = table(value, self.problems)?;
        only_keys(section, keys, self.problems);
        if self.model.is_none() {
            let message = "only a model moves and can leave something out, equations do not";
            return self.problems.refuse(value.span(), message);
        }
        Some(section)
    }

    fn kinds(&mut self, value: &DocumentValue<'_>) -> Vec<NeglectKind> {
        let mut kinds = Vec::new();
        for (word, span) in strings(value, self.problems) {
            match NeglectKind::parse(word) {
                Ok(kind) => kinds.push(kind),
                Err(_) => {
                    let names = NeglectKind::type_name();
                    let names: Vec<&str> = names.split(" | ").collect();
                    let what = "there is no kind of parts to leave out";
                    self.problems.unknown(span, what, word, &names);
                }
            }
        }
        kinds.sort_unstable();
        kinds.dedup();
        kinds
    }

    /// Names of joints, bodies, links and external forces.
    fn kept(&mut self, value: &DocumentValue<'_>) -> Vec<String> {
        let model = self.model.expect("a model was asked for");
        let mut names: Vec<&str> = model.joints.iter().map(|joint| &*joint.name).collect();
        names.extend(model.bodies.iter().map(|body| &*body.name));
        names.extend(model.links.iter().map(|link| &*link.name));
        names.extend(model.forces.iter().map(|force| &*force.name));
        let mut kept = Vec::new();
        for (word, span) in strings(value, self.problems) {
            if names.contains(&word) {
                kept.push(word.to_owned());
            } else {
                let what = "the model has no joint, body, link or external force";
                self.problems.unknown(span, what, word, &names);
            }
        }
        kept
    }

    fn watched(&mut self, value: &DocumentValue<'_>) -> Vec<usize> {
        let mut watched = Vec::new();
        for (name, span) in strings(value, self.problems) {
            if let Some(joint) = self.index(name, &span) {
                watched.push(joint);
            }
        }
        watched.sort_unstable();
        watched.dedup();
        watched
    }

    fn starts(&mut self, value: &DocumentValue<'_>) -> Vec<(usize, [f64; 2])> {
        let mut starts = Vec::new();
        for (word, value) in table(value, self.problems).into_iter().flatten() {
            let Some(joint) = self.index(word.get_ref(), &word.span()) else {
                continue;
            };
            if let Some(range) = self.start(value) {
                starts.push((joint, range));
            }
        }
        starts.sort_by_key(|&(joint, _)| joint);
        starts
    }

    /// A position, or the two ends of a range of positions.
    fn start(&mut self, value: &DocumentValue<'_>) -> Option<[f64; 2]> {
        let limit = ("motion.start", INPUT);
        if !matches!(value.get_ref(), DeValue::Array(_)) {
            return limited(value, limit, self.problems).map(|number| [number; 2]);
        }
        let list = array(value, self.problems)?;
        let [low, high] = list.as_ref() else {
            let message = "a range has two ends: [low, high]";
            return self.problems.refuse(value.span(), message);
        };
        let low = limited(low, limit, self.problems)?;
        let high = limited(high, limit, self.problems)?;
        if low > high {
            let message = "the low end of the range is above the high end";
            return self.problems.refuse(value.span(), message);
        }
        Some([low, high])
    }

    /// The index of a joint by name or number.
    fn index(&mut self, name: &str, span: &DocumentRange) -> Option<usize> {
        let number = self.problems.take(span, self.arrays.joint(name))?;
        Some(number as usize - 1)
    }
}

/// A watched joint that moves by less, m or rad, is at rest.
const REST: f64 = 1e-9;

impl SceneFile {
    /// Does something with the scene's model as it starts: its equations of
    /// motion in binary64 by the usual pipeline for the scene, those of its
    /// outputs that a program computes by the program in its format. `start`
    /// holds positions of joints, by index, that differ from the model's.
    ///
    /// # Errors
    ///
    /// See [`MotionError`].
    ///
    /// # Panics
    ///
    /// Panics for a scene of equations, which has no motion.
    pub fn moving<T>(
        &self,
        (laws, machine): (&Laws, &Machine),
        start: &[(usize, f64)],
        program: Option<(&Module, Format)>,
        action: impl FnOnce(&mut MultibodySystem<'_>, &MotionState) -> Result<T, MotionError>,
    ) -> Result<T, MotionError> {
        let SceneSubject::Model(subject) = &self.subject else {
            unreachable!("the reader of scenes refuses [motion] without a model");
        };
        let mut model = subject.model.clone();
        for &(joint, position) in start {
            if model.joints[joint].nature != Nature::Driven {
                model.joints[joint].initial[0] = position;
            }
        }
        // The integrator needs every acceleration, not those of the scene only.
        let scene = Scene {
            outputs: Vec::new(),
            ..self.scene.clone()
        };
        let pipeline = REGISTRY
            .pipeline(PIPELINE)
            .expect("the usual pipeline is well formed");
        let setting = EquationSetting {
            formulation: self.formulation(),
            passes: Some((&pipeline, machine)),
            format: Format::BINARY64,
            accelerations: subject.function == FunctionKind::Accelred,
            whole_step: false,
            scene: Some((&scene, &subject.options)),
            program,
        };
        // What a run of `sim` looks out for does not end the motions of scenes.
        let laws = Laws {
            events: Vec::new(),
            ..laws.clone()
        };
        let (mut system, initial) = MultibodySystem::new(&model, laws, &setting)?;
        action(&mut system, &initial)
    }
}

/// Joints of interest, with the range of motion of each.
pub struct WatchedJoints {
    joints: Vec<usize>,
    /// The largest displacement of each from its mean, m or rad.
    pub scales: Vec<f64>,
}

impl WatchedJoints {
    /// Measures the range of motion of joints, by index, over all given runs.
    ///
    /// # Errors
    ///
    /// [`MotionError::Still`] where one of them does not move.
    pub fn new(
        joints: &[usize],
        model: &Model,
        runs: &[SimulationRun],
    ) -> Result<WatchedJoints, MotionError> {
        let scale = |&joint: &usize| {
            let mean = mean_position(runs, joint);
            let samples = runs.iter().flat_map(|run| &run.samples);
            let away = samples.map(|sample| (sample.state.q[joint] - mean).abs());
            away.fold(0.0, f64::max)
        };
        let scales: Vec<f64> = joints.iter().map(scale).collect();
        if let Some(still) = scales.iter().position(|&scale| scale < REST) {
            let name = model.joints[joints[still]].name.clone();
            return Err(MotionError::Still(name));
        }
        Ok(WatchedJoints {
            joints: joints.to_vec(),
            scales,
        })
    }

    /// The largest distance of one between two runs, over its displacement.
    pub fn share(&self, one: &SimulationRun, other: &SimulationRun) -> f64 {
        let watched = self.joints.iter().zip(&self.scales);
        let parts = watched.map(|(&joint, scale)| one.distance(other, joint) / scale);
        parts.fold(0.0, f64::max)
    }
}
