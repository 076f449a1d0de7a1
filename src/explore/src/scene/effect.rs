//! Worth of a scene: operations, time, error and cost with more of it used.

use super::{SceneFile, SceneSubject};
use crate::device;
use crate::program::{ExplorationError, transformed, view};
use robovec_analysis::critical_path::critical_path;
use robovec_analysis::rounding::usual_states;
use robovec_error::yardstick::{ErrorSpread, Yardstick};
use robovec_framework::scene::{Bindings, Scene};
use robovec_ir::count::Counts;
use robovec_ir::states::States;
use robovec_ir::{Function, Machine, Module};
use robovec_passes::registry::REGISTRY;

/// The function with a part of the scene used, after the usual pipeline.
#[derive(Clone, PartialEq, Debug)]
pub struct SceneEffect {
    /// Part of the scene in use.
    pub what: &'static str,
    /// Operations: everything but sines, cosines and copies.
    pub operations: usize,
    /// Sines and cosines.
    pub sin_cos: usize,
    /// The longest chain, in cycles of the machine.
    pub path: u32,
    /// The schedule on the machine, in cycles, and its share of the thesis'
    /// device, estimated; `None` where the machine cannot hold it.
    pub placed: Option<(u32, f64)>,
    /// Errors in the machine's number format at states of the scene, over the
    /// largest element of the array, against double-double arithmetic.
    pub normwise: ErrorSpread,
}

/// The seed of the states that errors are measured at.
const STATE_SEED: u64 = 1;

/// The usual pipeline.
pub const USUAL: &str = "atomise,zero-removal,balance,cse,dce";

/// The usual pipeline, with the scene.
pub const PIPELINE: &str = "atomise,specialise,zero-removal,balance,cse,dce";

/// The general function, then the same with joints held, with the needed
/// outputs only, and with the numbers of inputs: each with all before it.
pub fn effects(file: &SceneFile, machine: &Machine) -> Result<Vec<SceneEffect>, ExplorationError> {
    let sliced = Scene {
        bound: Bindings::default(),
        ..file.scene.clone()
    };
    let states = file.scene.states(STATE_SEED);
    let effect = |what, module, scene| effect(what, module, scene, (machine, &states));
    let general = effect("the general function", file.general()?, None)?;
    let mut effects = vec![general];
    if matches!(file.subject, SceneSubject::Model(_)) && !file.scene.joints.is_empty() {
        let held = effect("with joints held", file.module()?, None)?;
        effects.push(held);
    }
    if !file.scene.outputs.is_empty() {
        let needed = "needed outputs only";
        effects.push(effect(needed, file.module()?, Some(&sliced))?);
    }
    let bound = "numbers of inputs";
    effects.push(effect(bound, file.module()?, Some(&file.scene))?);
    Ok(effects)
}

fn effect(
    what: &'static str,
    module: Module,
    scene: Option<&Scene>,
    (machine, states): (&Machine, &States),
) -> Result<SceneEffect, ExplorationError> {
    let pipeline = if scene.is_some() { PIPELINE } else { USUAL };
    let pipeline = REGISTRY
        .pipeline(pipeline)
        .expect("the usual pipeline is well formed");
    let general = alone(&module);
    let module = transformed(&module, &pipeline, machine, scene)?;
    let mut effect = SceneEffect {
        what,
        operations: 0,
        sin_cos: 0,
        path: 0,
        placed: Some((0, 0.0)),
        normwise: ErrorSpread::default(),
    };
    for (general, function) in general.iter().zip(alone(&module)) {
        let counts = Counts::of(&function.functions[0]);
        effect.operations += counts.operations;
        effect.sin_cos += counts.sin_cos;
        let path = critical_path(&function.functions[0], machine).asap_cycle;
        effect.path = effect.path.max(path);
        let all = effect.placed.zip(device::placed_share(&function, machine));
        // One machine runs all functions, one after the other.
        effect.placed = all.map(|(all, one)| (all.0 + one.0, all.1.max(one.1)));
        let count = usual_states(Counts::of(&general.functions[0]).operations);
        let yardstick = Yardstick::new(view(general), states, count);
        let errors = yardstick.errors(view(&function), machine.number)?.normwise;
        if errors.worst >= effect.normwise.worst {
            effect.normwise = errors;
        }
    }
    Ok(effect)
}

/// Every function of a module in a separate module.
fn alone(module: &Module) -> Vec<Module> {
    let functions = module.functions.iter();
    let one = |function: &Function| Module {
        tables: module.tables.clone(),
        functions: vec![function.clone()],
    };
    functions.map(one).collect()
}
