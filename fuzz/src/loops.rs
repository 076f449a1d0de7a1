//! Whatever model with loops is given, the generated functions of the whole
//! step move it as dense solutions do, or show why they cannot.

use crate::generated::decorate;
use arbitrary::{Result, Unstructured};
use robovec::model::family::random_tree;
use robovec::model::{Model, Nature};
use robovec::motion::{
    EVENT_TOLERANCE, EquationSetting, IntegrationMethod, Laws, LoopKeeping, MotionError,
    MultibodySystem, SimulationPlan, SimulationRun, simulate,
};
use robovec_ir::{Format, Machine};
use robovec_passes::registry::REGISTRY;

/// Pipelines that are run over the equations.
const PIPELINES: [&str; 4] = [
    "atomise",
    "atomise,zero-removal,balance,cse,dce",
    "atomise,factor,cse,dce",
    "atomise,accurate,fma",
];

/// Moves a random model with loops by generated functions and by dense
/// solutions.
///
/// # Panics
///
/// Panics when the motions differ, a loop opens, or an error means nothing.
pub fn whole_steps_move_models(data: &[u8]) {
    // Too few bytes for a model are no finding.
    let _ = moves(&mut Unstructured::new(data));
}

fn moves(bytes: &mut Unstructured<'_>) -> Result<()> {
    let mut model = random_tree(bytes.arbitrary()?, bytes.int_in_range(1..=6)?);
    decorate(&mut model, bytes)?;
    for body in &mut model.bodies {
        if bytes.ratio(1, 6)? {
            (body.mass, body.center, body.inertia) = (0.0, [0.0; 3], [0.0; 6]);
        }
    }
    for joint in &mut model.joints {
        if joint.nature == Nature::Independent && bytes.arbitrary()? {
            joint.nature = Nature::Dependent;
        }
    }
    let text = *bytes.choose(&PIPELINES)?;
    let rate = 1.0 + f64::from(bytes.arbitrary::<u8>()?);
    let keeping = *bytes.choose(&[
        LoopKeeping::Project,
        LoopKeeping::Project,
        LoopKeeping::Stabilise { rate },
        LoopKeeping::Free,
    ])?;
    let passed = bytes.arbitrary::<bool>()?;
    assert!(model.check());
    let pipeline = REGISTRY.pipeline(text).expect("a pipeline");
    let machine = Machine::built_in("thesis").expect("a machine");
    let whole = EquationSetting {
        passes: passed.then_some((&pipeline, &machine)),
        whole_step: true,
        ..EquationSetting::default()
    };
    let narrow = EquationSetting {
        format: Format::BINARY32,
        ..whole
    };
    if let Err(error) = run(&model, &narrow, keeping) {
        assert!(!error.to_string().is_empty());
    }
    match (
        run(&model, &EquationSetting::default(), keeping),
        run(&model, &whole, keeping),
    ) {
        (Ok((dense, _)), Ok((found, weak))) if !weak => agree(&model, &dense, &found, keeping),
        (_, Err(MotionError::Passes(reason))) => panic!("{text}: {reason}"),
        (_, Err(error)) => assert!(!error.to_string().is_empty()),
        _ => {}
    }
    Ok(())
}

/// A short run; true when it came near a dead point.
fn run(
    model: &Model,
    setting: &EquationSetting<'_>,
    keeping: LoopKeeping,
) -> std::result::Result<(SimulationRun, bool), MotionError> {
    let plan = SimulationPlan {
        duration: 0.01,
        samples: 2,
        method: IntegrationMethod::RungeKutta { step: 0.0025 },
        step_limit: 100,
        event_tolerance: EVENT_TOLERANCE,
    };
    let (mut system, initial) = MultibodySystem::new(model, Laws::of_model(model), setting)?;
    system.keep_loops(keeping);
    let run = simulate(&mut system, &initial, &plan, &mut |_| {})?;
    Ok((run, system.weak_since().is_some()))
}

/// Velocities from which on rounding moves positions too far in so short a
/// time to be compared.
const WILD: f64 = 1e3;

fn agree(model: &Model, dense: &SimulationRun, found: &SimulationRun, keeping: LoopKeeping) {
    let velocities = dense.samples.iter().flat_map(|sample| &sample.state.qd);
    let fastest = velocities.fold(0.0f64, |most, rate| most.max(rate.abs()));
    if fastest > WILD {
        return;
    }
    for joint in 0..model.joints.len() {
        let moved = dense.distance(found, joint);
        assert!(
            moved <= 1e-7 * (1.0 + fastest),
            "{}: {moved:e} apart at velocities up to {fastest:e}",
            model.joints[joint].name
        );
    }
    if keeping == LoopKeeping::Project {
        let gap = found.largest_gap();
        assert!(gap <= 1e-10, "a loop is {gap:e} open");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn random_loops_move() {
        cases::of_sizes(300, 4000, moves);
    }
}
