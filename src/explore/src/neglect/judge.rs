//! A scene with parts left out: equations, motion, and errors of the motion.

use super::NeglectError;
use super::document::SceneTable;
use super::omission::{Omission, without_forces};
use crate::program::{transformed_by, view};
use crate::scene::{
    self, ModelSubject, NeglectKind, PIPELINE, SceneFile, SceneMotion, SceneSubject, USUAL,
};
use robovec_dynamics::generate::{GenerationRequest, generate};
use robovec_dynamics::kinematics::MotionState;
use robovec_dynamics::motion::{
    EVENT_TOLERANCE, IntegrationMethod, Laws, MotionError, MultibodySystem, SimulationPlan,
    SimulationRun, simulate,
};
use robovec_ir::Machine;
use robovec_ir::count::Counts;
use robovec_model::Model;
use robovec_robotran::FunctionKind;
use std::path::Path;

/// Samples of a motion that are compared.
const SAMPLES: u32 = 500;

/// Maximum number of steps of a motion, as a multiple of those of the full
/// model: a model that needs more has become stiff and saves nothing.
pub(super) const STEP_FACTOR: u64 = 20;

/// Steps the full model may take.
pub(super) const FULL_STEPS: u64 = 1_000_000;

/// A scene with parts of the model left out.
pub(super) struct ReducedScene {
    pub(super) file: SceneFile,
    /// The laws of the links and external forces that remain.
    pub(super) laws: Laws,
    /// The file.
    pub(super) table: SceneTable,
}

impl ReducedScene {
    pub(super) fn subject(&self) -> &ModelSubject {
        match &self.file.subject {
            SceneSubject::Model(subject) => subject,
            SceneSubject::Equations(_) => unreachable!("a scene of equations leaves nothing out"),
        }
    }
}

/// Operations of a scene.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct SceneOperations {
    /// Of its function, without sines and cosines.
    pub function: usize,
    /// Sines and cosines of its function.
    pub sin_cos: usize,
    /// Of `link` and `extforces`, which turn lengths and places into forces.
    pub forces: usize,
}

impl SceneOperations {
    /// All of them; a sine or a cosine counts as one.
    pub fn total(&self) -> usize {
        self.function + self.sin_cos + self.forces
    }
}

/// Positions at the start that differ from those of the model.
pub(super) type Start = Vec<(usize, f64)>;

/// Measures that judge every candidate.
pub(super) struct NeglectJudge<'a> {
    pub(super) name: &'a str,
    pub(super) folder: &'a Path,
    /// The scene as written, without its section `[neglect]`.
    pub(super) own: SceneTable,
    pub(super) wish: &'a SceneMotion,
    /// The laws of the full model, every default a number.
    pub(super) laws: Laws,
    pub(super) machine: &'a Machine,
    /// Positions of locked joints: the means of their motions.
    pub(super) means: Vec<f64>,
    pub(super) step_limit: u64,
}

impl NeglectJudge<'_> {
    /// The scene of the file with further parts left out, if they can be.
    pub(super) fn build(
        &self,
        table: &SceneTable,
        model: &Model,
        omitted: &[Omission],
    ) -> Result<ReducedScene, NeglectError> {
        let mut table = table.clone();
        let locked = |joint: usize| omitted.contains(&Omission(NeglectKind::Joints, joint));
        for &Omission(kind, index) in omitted {
            match kind {
                NeglectKind::Joints => table.lock(model, index, self.means[index]),
                NeglectKind::Velocities if !locked(index) => {
                    table.clear("qd", false, index, &[&model.joints[index].name]);
                }
                NeglectKind::Angles if !locked(index) => table.small(model, index),
                NeglectKind::Inertias => table.clear_body("In", true, model, index),
                NeglectKind::Masses => {
                    table.clear_body("In", true, model, index);
                    table.clear_body("m", false, model, index);
                }
                NeglectKind::Gravity => table.clear_all("g"),
                _ => {}
            }
        }
        let laws = without_forces(&self.laws, omitted);
        table.clear_loads(model, &laws);
        let file = scene::read(self.name, &table.text(), self.folder)
            .map_err(|report| NeglectError::Scene(report.render_plain()))?;
        let mut reduced = ReducedScene { file, laws, table };
        reduced.drop_forces();
        Ok(reduced)
    }

    /// The operations of a scene after the usual pipeline.
    pub(super) fn operations(
        &self,
        reduced: &ReducedScene,
    ) -> Result<SceneOperations, NeglectError> {
        let subject = reduced.subject();
        let module = reduced.file.module()?;
        let scene = Some(&reduced.file.scene);
        let program = transformed_by(&module, PIPELINE, self.machine, scene)?;
        let counts = Counts::of(view(&program).function);
        let mut operations = SceneOperations {
            function: counts.operations,
            sin_cos: counts.sin_cos,
            forces: 0,
        };
        let model = &subject.model;
        let kinds = [
            (FunctionKind::Link, model.links.is_empty()),
            (FunctionKind::Extforces, model.forces.is_empty()),
        ];
        for (kind, none) in kinds {
            if !none {
                let module = generate(model, &GenerationRequest::new(kind))?;
                let program = transformed_by(&module, USUAL, self.machine, None)?;
                let counts = Counts::of(view(&program).function);
                operations.forces += counts.operations + counts.sin_cos;
            }
        }
        Ok(operations)
    }

    /// The motion of a scene from a start.
    pub(super) fn motion(
        &self,
        reduced: &ReducedScene,
        start: &Start,
        tolerance: f64,
    ) -> Result<SimulationRun, MotionError> {
        self.moved(reduced, start, |system, initial| {
            let plan = self.plan(tolerance);
            simulate(system, initial, &plan, &mut |_| ())
        })
    }

    fn plan(&self, tolerance: f64) -> SimulationPlan {
        SimulationPlan {
            duration: self.wish.time,
            samples: SAMPLES,
            method: IntegrationMethod::DormandPrince {
                relative: tolerance,
                absolute: tolerance,
            },
            step_limit: self.step_limit,
            event_tolerance: EVENT_TOLERANCE,
        }
    }

    /// Calls a function with the system of a scene at a start.
    pub(super) fn moved<T>(
        &self,
        reduced: &ReducedScene,
        start: &Start,
        action: impl FnOnce(&mut MultibodySystem<'_>, &MotionState) -> Result<T, MotionError>,
    ) -> Result<T, MotionError> {
        let forces = (&reduced.laws, self.machine);
        reduced.file.moving(forces, start, None, action)
    }
}

impl ReducedScene {
    /// Removes links and external forces without a law from the model.
    fn drop_forces(&mut self) {
        let SceneSubject::Model(subject) = &mut self.file.subject else {
            return;
        };
        let keep_links: Vec<bool> = self.laws.links.iter().map(|law| law.acts()).collect();
        let keep_forces: Vec<bool> = self.laws.forces.iter().map(|law| law.acts()).collect();
        for model in [&mut subject.general, &mut subject.model] {
            retain(&mut model.links, &keep_links);
            retain(&mut model.forces, &keep_forces);
        }
        retain(&mut self.laws.links, &keep_links);
        retain(&mut self.laws.forces, &keep_forces);
    }
}

fn retain<T>(list: &mut Vec<T>, keep: &[bool]) {
    let mut keep = keep.iter();
    list.retain(|_| *keep.next().expect("one law for each"));
}
