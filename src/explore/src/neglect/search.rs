//! The search: the effect of every omission alone, and the largest allowed set.

use super::NeglectError;
use super::document::SceneTable;
use super::judge::{FULL_STEPS, NeglectJudge, ReducedScene, STEP_FACTOR, SceneOperations, Start};
use super::omission::{Omission, candidates};
use super::starts::StartSearch;
use crate::program::{ExplorationError, transformed_by, view};
use crate::scene::{PIPELINE, SceneEffect, SceneFile, SceneSubject, WatchedJoints, effects};
use rayon::prelude::*;
use robovec_dynamics::kinematics::{InputSources, StateError};
use robovec_dynamics::motion::{Laws, MotionError, MultibodySystem, SimulationRun, mean_position};
use robovec_error::yardstick::{ErrorSpread, Yardstick};
use robovec_ir::{Format, Machine, View};
use robovec_model::Model;
use std::collections::VecDeque;
use std::path::Path;

/// Number of starts that parts are left out by before any is refused.
const DRAWS: u32 = 2;

/// Maximum number of searches for parts, each with the worst starts of the last.
const REFUSALS: usize = 6;

/// Of this number of samples of a motion, equations are compared at one.
const COMPARED: usize = 8;

/// A scene that permits omissions.
pub struct NeglectTask<'a> {
    /// The scene as read.
    pub file: &'a SceneFile,
    /// The name of its file.
    pub name: &'a str,
    /// Its text.
    pub text: &'a str,
    /// Folder of the files that it names.
    pub folder: &'a Path,
    /// The laws of its forces, for the model with the scene's joints held.
    pub laws: Laws,
    /// The machine that passes compile for, whose speed and cost are reported.
    pub machine: &'a Machine,
}

/// Effect of leaving out one thing.
#[derive(Clone, PartialEq, Debug)]
pub struct NeglectFinding {
    /// The thing, in words.
    pub what: String,
    /// Operations saved when it alone is left out, if that scene has a motion.
    pub saved: Option<i64>,
    /// The largest error of a watched joint, relative to its largest
    /// displacement, when it alone is left out; or why it cannot be.
    pub alone: Result<f64, String>,
    /// Its order of omission with others, and their largest error then.
    pub taken: Option<(usize, f64)>,
    /// A larger omission contains it.
    pub within: bool,
}

/// Speed, error and cost of one scene.
#[derive(Clone, Debug)]
pub struct SceneFigures {
    /// Kind of the thing.
    pub what: &'static str,
    /// Its operations.
    pub operations: SceneOperations,
    /// Path, cycles, cost and rounding errors on the machine.
    pub effect: SceneEffect,
    /// Largest error of a watched joint over the motion, over its displacement.
    pub motion: f64,
    /// Errors of needed outputs at states of the full motion, against full
    /// equations in double-double, over the largest element of the array.
    pub equations: ErrorSpread,
}

/// Findings of the search.
#[derive(Debug)]
pub struct NeglectFindings {
    /// Watched joints, and largest displacements from their means, m or rad.
    pub watched: Vec<(String, f64)>,
    /// The full scene, the scene as written, and the scene with parts left out.
    pub figures: Vec<SceneFigures>,
    /// The findings of all omissions tried alone.
    pub findings: Vec<NeglectFinding>,
    /// Starts at which the reduced scene was compared; `None` for equal starts.
    pub searched: Option<StartSearch>,
    /// The part of the error allowed that is left of all motions compared.
    pub rest: f64,
    /// Error of the integrator itself: the largest change of the full motion
    /// with a hundredth of the tolerance, in the same parts.
    pub integration: f64,
    /// Every watched joint in the first motion.
    pub curves: Vec<WatchedCurve>,
    /// The table of the reduced scene's file.
    pub(super) reduced: SceneTable,
    /// Its model and laws, without the omitted links and forces.
    pub(super) model: Model,
    pub(super) laws: Laws,
}

/// Times, s, and positions, m or rad, of a watched joint.
#[derive(Clone, PartialEq, Debug)]
pub struct WatchedCurve {
    /// In the full model.
    pub full: Vec<(f64, f64)>,
    /// With parts left out.
    pub reduced: Vec<(f64, f64)>,
}

/// Motions of the full model, and their measures.
pub(super) struct FullMotion {
    pub(super) scene: ReducedScene,
    /// Motions for the selection of omissions.
    pub(super) runs: Vec<(Start, SimulationRun)>,
    pub(super) watched: WatchedJoints,
}

/// The search of a scene: its judge, the full motion, and the model as read.
pub(super) struct NeglectSearch<'a> {
    pub(super) judge: NeglectJudge<'a>,
    pub(super) full: FullMotion,
    /// Motions from all starts at which the omissions must keep the limits.
    pub(super) known: Vec<(Start, SimulationRun)>,
    /// Number of steps of motions from them.
    pub(super) steps: u64,
    model: &'a Model,
}

/// Finds the parts that a scene need not model. `progress` receives each step.
pub fn neglect(
    task: &NeglectTask<'_>,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<NeglectFindings, NeglectError> {
    let wish = task.file.motion.as_ref().ok_or(NeglectError::NoMotion)?;
    if wish.watch.is_empty() {
        return Err(NeglectError::NothingWatched);
    }
    let SceneSubject::Model(subject) = &task.file.subject else {
        return Err(NeglectError::NoMotion);
    };
    let own = SceneTable::of(task.text);
    let mut judge = NeglectJudge {
        name: task.name,
        folder: task.folder,
        wish,
        laws: settled(task, &own)?,
        machine: task.machine,
        means: Vec::new(),
        step_limit: FULL_STEPS,
        own,
    };
    progress("the motion of the full model");
    let full = full_motion(&mut judge, &subject.general)?;
    let mut search = NeglectSearch {
        judge,
        full,
        known: Vec::new(),
        steps: 0,
        model: &subject.general,
    };
    if wish.varies() {
        search.learn_listed();
    }
    let judge = &search.judge;
    let own = search.without(&[])?;
    let own_model = &own.subject().model;
    let all = candidates(own_model, &judge.laws, &task.file.neglect, &wish.watch);
    let operations = judge.operations(&own)?;
    progress("every omission alone");
    let alone = |&one: &Omission| (one, search.alone(operations, one));
    let mut tried: Vec<(Omission, NeglectFinding)> = all.par_iter().map(alone).collect();
    progress("omissions together");
    let (taken, worst) = search.confirmed(&mut tried, progress)?;
    let taken = without_subsumed(&taken, &mut tried);
    let reduced = search.without(&taken)?;
    let (judge, full) = (&search.judge, &search.full);
    let fine = judge.motion(&full.scene, &full.runs[0].0, wish.tolerance() / 100.0)?;
    let integration = full.watched.share(&full.runs[0].1, &fine);
    let scenes = [
        ("the full model", &full.scene),
        ("the scene as written", &own),
        ("with things left out", &reduced),
    ];
    let figures = scenes.map(|(what, scene)| search.figures_of(what, scene));
    let mut figures = figures.into_iter().collect::<Result<Vec<_>, _>>()?;
    let curves = search.curves(&reduced)?;
    let last = figures.last_mut().expect("three scenes were measured");
    last.motion = last.motion.max(worst);
    let rest = wish.error - last.motion;
    let joints = &full.scene.subject().model.joints;
    let names = wish.watch.iter().map(|&joint| joints[joint].name.clone());
    Ok(NeglectFindings {
        watched: names.zip(full.watched.scales.iter().copied()).collect(),
        figures,
        findings: tried.into_iter().map(|(_, finding)| finding).collect(),
        rest,
        searched: wish.varies().then_some(StartSearch {
            starts: search.known.len(),
            steps: search.steps,
            worst,
        }),
        integration,
        curves,
        model: reduced.subject().general.clone(),
        laws: reduced.laws.clone(),
        reduced: reduced.table,
    })
}

/// The laws with every default a number, as the full model starts.
fn settled(task: &NeglectTask<'_>, own: &SceneTable) -> Result<Laws, NeglectError> {
    let full = crate::scene::read(task.name, &own.full().text(), task.folder)
        .map_err(|report| NeglectError::Scene(report.render_plain()))?;
    let SceneSubject::Model(subject) = &full.subject else {
        return Err(NeglectError::NoMotion);
    };
    Ok(MultibodySystem::settled(&subject.model, task.laws.clone())?)
}

/// The full model from every start; sets the judge's means and steps.
fn full_motion(judge: &mut NeglectJudge<'_>, model: &Model) -> Result<FullMotion, NeglectError> {
    let scene = judge.build(&judge.own.full(), model, &[])?;
    let draws = if judge.wish.varies() { DRAWS } else { 1 };
    let starts: Vec<Start> = (0..draws).map(|draw| judge.wish.start(draw)).collect();
    let runs: Result<Vec<SimulationRun>, MotionError> = starts
        .par_iter()
        .map(|start| judge.motion(&scene, start, judge.wish.tolerance()))
        .collect();
    let runs = runs?;
    judge.means = (0..model.joints.len())
        .map(|joint| mean_position(&runs, joint))
        .collect();
    let steps = runs.iter().map(|run| run.steps + run.rejected).max();
    judge.step_limit = STEP_FACTOR * steps.expect("there is a start") + 1000;
    let watched = WatchedJoints::new(&judge.wish.watch, model, &runs)?;
    Ok(FullMotion {
        scene,
        runs: starts.into_iter().zip(runs).collect(),
        watched,
    })
}

impl NeglectSearch<'_> {
    /// The scene as written, with parts left out.
    fn without(&self, omitted: &[Omission]) -> Result<ReducedScene, NeglectError> {
        self.judge.build(&self.judge.own, self.model, omitted)
    }

    pub(super) fn run(
        &self,
        scene: &ReducedScene,
        start: &Start,
    ) -> Result<SimulationRun, MotionError> {
        self.judge.motion(scene, start, self.judge.wish.tolerance())
    }

    /// The largest error of a scene over some of the searched motions.
    fn error(&self, scene: &ReducedScene, motions: usize) -> Result<f64, MotionError> {
        let runs = &self.full.runs[..motions.min(self.full.runs.len())];
        let errors = runs.par_iter().map(|(start, run)| {
            let other = self.run(scene, start)?;
            Ok(self.full.watched.share(run, &other))
        });
        let errors = errors.collect::<Result<Vec<f64>, MotionError>>()?;
        Ok(errors.into_iter().fold(0.0, f64::max))
    }

    /// Effect of one omission alone, judged by the first motion.
    fn alone(&self, before: SceneOperations, one: Omission) -> NeglectFinding {
        let mut finding = NeglectFinding {
            what: one.describe(self.model),
            saved: None,
            alone: Err(String::new()),
            taken: None,
            within: false,
        };
        let tried = self.without(&[one]).and_then(|scene| {
            let operations = self.judge.operations(&scene)?;
            finding.saved = Some(before.total() as i64 - operations.total() as i64);
            Ok(self.error(&scene, 1)?)
        });
        finding.alone = tried.map_err(|error| {
            let text = error.to_string();
            text.lines().next().unwrap_or_default().to_owned()
        });
        finding
    }

    /// Parts that can be left out together at every known start, with the
    /// largest error there. A refused list is searched again with the worst
    /// starts; after the last refusal, lists are shortened from their ends.
    fn confirmed(
        &mut self,
        tried: &mut [(Omission, NeglectFinding)],
        progress: &(dyn Fn(&str) + Sync),
    ) -> Result<(Vec<Omission>, f64), NeglectError> {
        let mut taken = Vec::new();
        for refusals in 0.. {
            if refusals < REFUSALS && !self.is_exhausted() {
                taken = self.together(tried);
            } else {
                taken.truncate(taken.len() * 3 / 4);
                for (_, finding) in tried.iter_mut().filter(|(one, _)| !taken.contains(one)) {
                    finding.taken = None;
                }
            }
            progress("the worst start of the reduced scene");
            let scene = self.without(&taken)?;
            let worst = self.worst(&scene);
            if worst <= self.judge.wish.error || taken.is_empty() {
                return Ok((taken, worst));
            }
        }
        unreachable!("nothing left out ends the search")
    }

    /// Combines omissions: those that save operations alone first, then, as
    /// long as there are any, those that save operations after the others (the
    /// last joint across a plane, the mass beyond a locked joint).
    fn together(&self, tried: &mut [(Omission, NeglectFinding)]) -> Vec<Omission> {
        tried
            .iter_mut()
            .for_each(|(_, finding)| finding.taken = None);
        let harm = |finding: &NeglectFinding| finding.alone.clone().unwrap_or(f64::INFINITY);
        // What does too much alone is not tried with others; what could not be
        // judged alone is, last.
        let mut harmless: Vec<usize> = (0..tried.len())
            .filter(|&place| {
                let alone = tried[place].1.alone.iter();
                alone.copied().all(|error| error <= self.judge.wish.error)
            })
            .collect();
        harmless.sort_by(|&a, &b| harm(&tried[a].1).total_cmp(&harm(&tried[b].1)));
        let saves = |&place: &usize| tried[place].1.saved.is_some_and(|saved| saved > 0);
        let judged = |&place: &usize| tried[place].1.alone.is_ok();
        let first = harmless.iter().copied().filter(judged).filter(saves);
        let mut rest: VecDeque<usize> = first.collect();
        let mut taken: Vec<Omission> = Vec::new();
        let mut refused: Vec<usize> = Vec::new();
        while !rest.is_empty() {
            self.as_many(tried, (&mut taken, &mut refused), rest);
            let goes = |one: &Omission| one.goes_with().is_some_and(|whole| taken.contains(&whole));
            let open: Vec<usize> = harmless
                .iter()
                .copied()
                .filter(|place| tried[*place].1.taken.is_none() && !refused.contains(place))
                .filter(|&place| !goes(&tried[place].0))
                .collect();
            let operations = |omitted: &[Omission]| {
                let scene = self.without(omitted);
                scene.and_then(|scene| self.judge.operations(&scene)).ok()
            };
            let now = operations(&taken);
            let saves = open.par_iter().copied().filter(|&place| {
                let with: Vec<Omission> = taken.iter().copied().chain([tried[place].0]).collect();
                let less = now.zip(operations(&with));
                less.is_some_and(|(now, with)| with.total() < now.total())
            });
            rest = saves.collect::<Vec<usize>>().into();
        }
        taken
    }

    /// Leaves out as many of a list as possible: all together, then fewer.
    fn as_many(
        &self,
        tried: &mut [(Omission, NeglectFinding)],
        (taken, refused): (&mut Vec<Omission>, &mut Vec<usize>),
        mut rest: VecDeque<usize>,
    ) {
        let mut size = rest.len();
        while !rest.is_empty() {
            size = size.clamp(1, rest.len());
            let mut attempt = taken.clone();
            attempt.extend(rest.iter().take(size).map(|&place| tried[place].0));
            let worst = self
                .without(&attempt)
                .and_then(|scene| Ok(self.error(&scene, usize::MAX)?));
            match worst {
                Ok(worst) if worst <= self.judge.wish.error => {
                    for place in rest.drain(..size) {
                        tried[place].1.taken = Some((taken.len() + 1, worst));
                        taken.push(tried[place].0);
                    }
                    size *= 2;
                }
                _ if size == 1 => refused.extend(rest.pop_front()),
                _ => size /= 2,
            }
        }
    }

    /// Speed, error and cost of a scene.
    fn figures_of(
        &self,
        what: &'static str,
        scene: &ReducedScene,
    ) -> Result<SceneFigures, NeglectError> {
        let module = self.full.scene.file.module()?;
        let yardstick = Yardstick::at(view(&module), self.states(view(&module))?);
        let reduced = scene.file.module()?;
        let known = Some(&scene.file.scene);
        let program = transformed_by(&reduced, PIPELINE, self.judge.machine, known)?;
        let errors = yardstick.errors(view(&program), Format::BINARY64);
        let errors = errors.map_err(ExplorationError::from)?;
        let mut steps = effects(&scene.file, self.judge.machine)?;
        Ok(SceneFigures {
            what,
            operations: self.judge.operations(scene)?,
            effect: steps.pop().expect("the last step uses the whole scene"),
            motion: self.error(scene, usize::MAX)?,
            equations: errors.normwise,
        })
    }

    /// The inputs of the full function at states of the full motions.
    fn states(&self, view: View<'_>) -> Result<Vec<Vec<f64>>, MotionError> {
        let model = &self.full.scene.subject().model;
        let inputs = InputSources::new(model, view).map_err(|element| StateError::Element {
            function: self.full.scene.subject().name.clone(),
            element,
        })?;
        let mut states = Vec::new();
        for (start, run) in self.full.runs.iter().take(DRAWS as usize) {
            let samples = run.samples.iter().step_by(COMPARED);
            let loaded = self.judge.moved(&self.full.scene, start, |system, _| {
                Ok(samples
                    .map(|sample| system.loaded(&sample.state))
                    .collect::<Vec<_>>())
            })?;
            states.extend(loaded.iter().map(|state| inputs.gather(state)));
        }
        Ok(states)
    }

    /// The positions of every watched joint in the first motion, full and reduced.
    fn curves(&self, reduced: &ReducedScene) -> Result<Vec<WatchedCurve>, NeglectError> {
        let (start, run) = &self.full.runs[0];
        let other = self.run(reduced, start)?;
        let curve = |run: &SimulationRun, joint: usize| {
            let samples = run.samples.iter();
            samples
                .map(|sample| (sample.state.time, sample.state.q[joint]))
                .collect()
        };
        let watched = self.judge.wish.watch.iter();
        Ok(watched
            .map(|&joint| WatchedCurve {
                full: curve(run, joint),
                reduced: curve(&other, joint),
            })
            .collect())
    }
}

/// Omissions that do not follow from others, such as a held joint's force.
fn without_subsumed(taken: &[Omission], tried: &mut [(Omission, NeglectFinding)]) -> Vec<Omission> {
    let goes = |one: &Omission| one.goes_with().is_some_and(|whole| taken.contains(&whole));
    for (one, finding) in tried.iter_mut() {
        if goes(one) {
            finding.within = finding.taken.take().is_some();
        }
    }
    let mut order: Vec<&mut usize> = tried
        .iter_mut()
        .filter_map(|(_, finding)| Some(&mut finding.taken.as_mut()?.0))
        .collect();
    order.sort();
    for (place, number) in order.into_iter().enumerate() {
        *number = place + 1;
    }
    taken.iter().copied().filter(|one| !goes(one)).collect()
}
