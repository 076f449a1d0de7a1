//! Cases of a given model or function in difficult states: nearly singular
//! masses or loops, limits, high speeds, large angles, worst found states.

use super::StressError;
use super::case::{CaseClass, StressCase, StressSubject};
use super::dynamics::{DynamicsSubject, Metric};
use super::equations::EquationsSubject;
use super::linear::{condition, estimated_condition};
use super::loops::LoopsSubject;
use super::numbers::{Draw, WorkingPrecision};
use super::program::{ModelProgram, ProgramRecipe};
use super::units::Units;
use robovec_analysis::interval::{GivenData, input_ranges};
use robovec_dynamics::kinematics::{LoopClosure, MotionState, StateError};
use robovec_dynamics::motion::{EquationSetting, MotionEquations};
use robovec_error::adversary::{SearchSubject, largest_errors};
use robovec_ir::print::print_module;
use robovec_ir::states::States;
use robovec_ir::{Format, Module};
use robovec_model::{JointKind, Model};
use robovec_robotran::FunctionKind;
use std::f64::consts::{PI, TAU};

/// Operations of the search for a pose, its linear algebra included.
const WORK: usize = 400_000_000;
/// Minimum and maximum number of poses tried.
const POSES: [usize; 2] = [32, 4096];
/// Speed of joints in the case of high speeds, rad/s or m/s.
const SPEED: f64 = 100.0;
/// Turns added to angles in the case of large ones.
const TURNS: f64 = 1000.0;
/// States of a function beside those of its largest errors.
const DRAWN: u32 = 5;
/// Maximum number of positions in a text.
const NAMED: usize = 16;
/// Seed of the states; the choice is arbitrary.
const SEED: u64 = 7;

/// The cases of a model, hard ones after random states.
///
/// # Errors
///
/// Fails when the model gives no equations, or its loops do not close.
pub fn of_model(model: &Model) -> Result<Vec<StressCase>, StressError> {
    if model.cuts.is_empty() {
        of_tree(model)
    } else {
        of_loops(model)
    }
}

/// The cases of a function with a range for every input: random states, and
/// those of the largest errors in binary32 that a search finds.
pub fn of_function(module: &Module, states: &States) -> Vec<StressCase> {
    let view = module.tables.view(&module.functions[0]);
    let ranges = input_ranges(view, states).into_iter();
    let ranges: Vec<_> = ranges.map(|range| range.range).collect();
    let subject = SearchSubject {
        view,
        inputs: &ranges,
        format: Format::BINARY32,
        data: GivenData::Held,
    };
    let found = largest_errors(subject, states.seed(), 1);
    let drawn = (0..DRAWN).map(|index| states.draw(view, index)).collect();
    let text = print_module(module);
    let mut worst = found.states;
    worst.retain(|state| !state.is_empty());
    worst.dedup();
    let mut cases = vec![case(
        ("random", "base"),
        format!("{DRAWN} random states"),
        EquationsSubject::new(text.clone(), drawn).of("outputs"),
    )];
    if !worst.is_empty() {
        cases.push(case(
            ("worst", "cancellation"),
            format!(
                "the states of the largest errors of {} searched",
                found.tried
            ),
            EquationsSubject::new(text, worst).of("outputs"),
        ));
    }
    cases
}

fn case(
    (name, class): (&str, &str),
    construction: String,
    subject: impl StressSubject + 'static,
) -> StressCase {
    StressCase {
        name: name.to_owned(),
        class: CaseClass::from_name(class).expect("a class"),
        construction,
        breaks: String::new(),
        expected: None,
        long: false,
        subject: Box::new(subject),
    }
}

/// A random state within the limits of joints, or around the initial ones.
fn drawn(model: &Model, draw: &mut Draw) -> MotionState {
    let mut state = MotionState::initial(model);
    for (index, joint) in model.joints.iter().enumerate() {
        let first = joint.initial[0];
        let reach = if is_hinge(joint.kind) { PI } else { 0.5 };
        let [low, high] = joint.limits.unwrap_or([first - reach, first + reach]);
        state.q[index] = draw.between(low, high);
        state.qd[index] = draw.within(1.0);
        state.qdd[index] = draw.within(1.0);
    }
    state
}

fn is_hinge(kind: JointKind) -> bool {
    matches!(kind, JointKind::Revolute(_))
}

fn of_tree(model: &Model) -> Result<Vec<StressCase>, StressError> {
    let mut draw = Draw::new(SEED);
    let accelerations = |states| DynamicsSubject::new(model.clone(), states, Metric::Accelerations);
    let random: Vec<MotionState> = (0..3).map(|_| drawn(model, &mut draw)).collect();
    let moving = random[0].clone();
    let with = |change: &dyn Fn(usize, &mut MotionState)| {
        let mut state = moving.clone();
        (0..model.joints.len()).for_each(|joint| change(joint, &mut state));
        accelerations(vec![state])
    };
    let (hard, worst, tried) = singular_pose(model, &mut draw)?;
    let mut cases = vec![
        case(
            ("random", "base"),
            "three random states".to_owned(),
            accelerations(random),
        ),
        case(
            ("initial", "pose"),
            "the initial pose, moving".to_owned(),
            with(&|joint, state| state.q[joint] = model.joints[joint].initial[0]),
        ),
        case(
            ("singular", "pose"),
            format!(
                "the worst of {tried} poses searched, condition of M {worst:.1e}, at {}",
                positions(&hard)
            ),
            accelerations(vec![hard]),
        ),
        case(
            ("fast", "swamped"),
            format!("speeds of {SPEED} rad/s or m/s in turn"),
            with(&|joint, state| state.qd[joint] = if joint % 2 == 0 { SPEED } else { -SPEED }),
        ),
    ];
    if model.joints.iter().any(|joint| joint.limits.is_some()) {
        cases.push(case(
            ("limits", "pose"),
            "every joint at a limit".to_owned(),
            with(&|joint, state| {
                if let Some(limits) = model.joints[joint].limits {
                    state.q[joint] = limits[joint % 2];
                }
            }),
        ));
    }
    if model.joints.iter().any(|joint| is_hinge(joint.kind)) {
        cases.push(case(
            ("turns", "scale"),
            format!("angles of {TURNS} turns and more"),
            with(&|joint, state| {
                if is_hinge(model.joints[joint].kind) {
                    state.q[joint] += TURNS * TAU;
                }
            }),
        ));
    }
    Ok(cases)
}

/// The first positions of a state, for users.
fn positions(state: &MotionState) -> String {
    let numbers = state.q.iter().take(NAMED).map(|q| format!("{q:.4}"));
    let more = if state.q.len() > NAMED { " …" } else { "" };
    format!("q = {}{more}", numbers.collect::<Vec<_>>().join(" "))
}

/// The state with the largest condition of the mass matrix that a search
/// finds, the condition, and the number of poses tried.
fn singular_pose(model: &Model, draw: &mut Draw) -> Result<(MotionState, f64, usize), StressError> {
    let recipe = ProgramRecipe {
        only: Some("M"),
        ..ProgramRecipe::default()
    };
    let program = ModelProgram::new(model, FunctionKind::Dirdyna, recipe)?;
    let size = model.joints.len();
    let measure = |state: &mut MotionState| {
        let numbers = WorkingPrecision::In(Format::BINARY64);
        let flat = program.evaluate(numbers, Units::SI, &program.inputs(state));
        let entries = program.array("M", &flat, size * size).into_iter();
        let entries: Vec<f64> = entries.map(|entry| entry.high).collect();
        Some(estimated_condition(size, &entries)).filter(|condition| condition.is_finite())
    };
    let each = program.function.nodes().len() + 200 * size * size;
    Ok(climb(model, draw, each, &measure))
}

/// Poses drawn, then changed joint by joint where that makes a measure larger.
fn climb(
    model: &Model,
    draw: &mut Draw,
    each: usize,
    measure: &dyn Fn(&mut MotionState) -> Option<f64>,
) -> (MotionState, f64, usize) {
    let [least, most] = POSES;
    let poses = (WORK / each).clamp(least, most);
    let mut best = MotionState::initial(model);
    let mut largest = measure(&mut best).unwrap_or(0.0);
    for pose in 0..poses {
        let mut state = drawn(model, draw);
        if pose >= poses / 4 {
            let fresh = std::mem::replace(&mut state, best.clone());
            let joint = (draw.bits() % model.joints.len() as u64) as usize;
            let scale = 0.5f64.powi((draw.bits() % 16) as i32);
            state.q[joint] += scale * (fresh.q[joint] - state.q[joint]);
        }
        if let Some(found) = measure(&mut state).filter(|found| *found > largest) {
            (best, largest) = (state, found);
        }
    }
    best.qd = drawn(model, draw).qd;
    (best, largest, poses)
}

fn of_loops(model: &Model) -> Result<Vec<StressCase>, StressError> {
    let equations = MotionEquations::new(model, &EquationSetting::default())?;
    let loops = LoopClosure {
        model,
        constraints: equations.constraints(),
    };
    let failed = |error: StateError| StressError::Passes(error.to_string());
    let mut start = MotionState::initial(model);
    let partition = loops.start(&mut start).map_err(failed)?;
    let measure = |state: &mut MotionState| {
        for &joint in &partition.dependent {
            state.q[joint] = start.q[joint];
        }
        loops.close(state, &partition).ok()?;
        let jacobian = loops.constraints.evaluate(state).1;
        let dependent = jacobian.select(&partition.rows, &partition.dependent);
        let condition = condition(dependent.product(&dependent.transposed()));
        (condition >= 0.0).then(|| condition.sqrt())
    };
    let size = model.joints.len();
    let each = 100 * (size + partition.rows.len()).pow(3);
    let mut draw = Draw::new(SEED);
    let (mut hard, worst, tried) = climb(model, &mut draw, each, &measure);
    loops.close(&mut hard, &partition).map_err(failed)?;
    let closed = |state: MotionState| LoopsSubject::in_states([(model.clone(), state)]);
    Ok(vec![
        case(
            ("initial", "base"),
            "the closed initial state".to_owned(),
            closed(start.clone()),
        ),
        case(
            ("singular", "loop"),
            format!(
                "the worst of {tried} poses searched, condition of the loops {worst:.1e}, at {}",
                positions(&hard)
            ),
            closed(hard),
        ),
        case(
            ("whole-step", "loop"),
            "the closed initial state, loops closed in the same numbers".to_owned(),
            closed(start).whole_step(),
        ),
    ])
}
