//! What a scene is worth: operations with more and more of it used.

use super::{SceneFile, SceneSubject};
use robovec_analysis::critical_path::critical_path;
use robovec_framework::manager::{self, Config};
use robovec_framework::scene::{Bindings, Scene};
use robovec_ir::count::Counts;
use robovec_ir::{Machine, Module};
use robovec_passes::registry::REGISTRY;
use thiserror::Error;

/// The function with a part of the scene used, after the usual pipeline.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SceneEffect {
    /// What is used.
    pub what: &'static str,
    /// Operations: everything but sines, cosines and copies.
    pub operations: usize,
    /// Sines and cosines.
    pub sin_cos: usize,
    /// The longest chain, in cycles of the machine.
    pub cycles: u32,
}

/// Why nothing could be told.
#[derive(Debug, Error)]
pub enum EffectError {
    /// The equations could not be made.
    #[error(transparent)]
    Generate(#[from] crate::generate::GenerateError),
    /// A pass gave up.
    #[error(transparent)]
    Run(#[from] manager::RunError),
}

/// The usual pipeline.
pub const USUAL: &str = "atomise,zero-removal,balance,cse,dce";

/// The usual pipeline, with the scene used in it.
pub const PIPELINE: &str = "atomise,specialise,zero-removal,balance,cse,dce";

/// The general function, then the same with joints held, with the needed
/// outputs only, and with the numbers of inputs: each with all before it.
///
/// # Errors
///
/// Those of the generator and of passes.
pub fn effects(file: &SceneFile, machine: &Machine) -> Result<Vec<SceneEffect>, EffectError> {
    let sliced = Scene {
        bound: Bindings::default(),
        ..file.scene.clone()
    };
    let general = effect("the general function", file.general()?, None, machine)?;
    let mut effects = vec![general];
    if matches!(file.subject, SceneSubject::Model(_)) && !file.scene.joints.is_empty() {
        let held = effect("with joints held", file.module()?, None, machine)?;
        effects.push(held);
    }
    if !file.scene.outputs.is_empty() {
        let needed = "needed outputs only";
        effects.push(effect(needed, file.module()?, Some(&sliced), machine)?);
    }
    let bound = "numbers of inputs";
    effects.push(effect(bound, file.module()?, Some(&file.scene), machine)?);
    Ok(effects)
}

fn effect(
    what: &'static str,
    mut module: Module,
    scene: Option<&Scene>,
    machine: &Machine,
) -> Result<SceneEffect, EffectError> {
    let pipeline = if scene.is_some() { PIPELINE } else { USUAL };
    let pipeline = REGISTRY
        .pipeline(pipeline)
        .expect("the usual pipeline is well formed");
    let mut log = std::io::sink();
    let config = Config {
        scene,
        ..Config::new(machine, &mut log)
    };
    manager::run(&mut module, &pipeline, config)?;
    let mut effect = SceneEffect {
        what,
        operations: 0,
        sin_cos: 0,
        cycles: 0,
    };
    for function in &module.functions {
        let counts = Counts::of(function);
        effect.operations += counts.operations;
        effect.sin_cos += counts.sin_cos;
        effect.cycles = effect
            .cycles
            .max(critical_path(function, machine).asap_cycle);
    }
    Ok(effect)
}
