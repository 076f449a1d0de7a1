//! The models under `examples/` run.

use robovec::model::{Model, mbs::read_mbs};
use robovec::motion::{
    EVENT_TOLERANCE, EquationSetting, IntegrationMethod, Laws, MultibodySystem, SimulationPlan,
    simulate,
};
use std::fs;
use std::path::{Path, PathBuf};

fn models() -> Vec<(String, Model)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    let mut models = Vec::new();
    for entry in fs::read_dir(folder).expect("example models") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|extension| extension == "mbs") {
            let name = path
                .file_name()
                .map(|name| name.to_string_lossy().into_owned());
            let name = name.expect("a name");
            let read = read_mbs(&name, &fs::read(&path).expect("a file"));
            models.push((name, read.expect("a model").model));
        }
    }
    models.sort_by(|a, b| a.0.cmp(&b.0));
    models
}

/// Small models run for a while, large ones for a few steps.
#[test]
fn all_example_models_keep_their_energy() {
    let models = models();
    assert!(models.len() >= 6);
    for (name, mut model) in models {
        let joints = model.joints.len();
        for (index, joint) in model.joints.iter_mut().enumerate() {
            joint.initial[1] += 0.01 * (index % 5) as f64;
        }
        let plan = SimulationPlan {
            duration: if joints < 30 { 0.2 } else { 1e-3 },
            samples: 1,
            method: IntegrationMethod::RungeKutta { step: 1e-3 },
            step_limit: 1000,
            event_tolerance: EVENT_TOLERANCE,
        };
        let laws = Laws::of_model(&model);
        let run = MultibodySystem::new(&model, laws, &EquationSetting::default())
            .and_then(|(mut system, state)| simulate(&mut system, &state, &plan, &mut |_| {}))
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let total = run.samples[0].energy;
        let scale = total.kinetic.abs() + total.gravity.abs() + 1.0;
        let drift = run.energy_drift();
        assert!(drift < 1e-8 * scale, "{name}: {drift:e} of {scale:e}");
        assert!(run.largest_gap() < 1e-10, "{name}: {:e}", run.largest_gap());
    }
}

fn sorted(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("example laws");
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| entry.expect("readable").path())
        .collect();
    paths.sort();
    paths
}

/// Every file of laws fits the model whose name it begins with; energy changes
/// by the work of dampers, weights and drives alone, and without drives the
/// bodies come to rest.
#[test]
fn example_laws_bring_their_models_to_rest() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/laws");
    let models = models();
    let mut tried = 0;
    for path in sorted(&folder) {
        let text = fs::read_to_string(&path).expect("it is readable");
        let stem = path
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        let own = |name: &str| stem.starts_with(name.trim_end_matches(".mbs"));
        let of = models.iter().filter(|(name, _)| own(name));
        let (name, model) = of
            .max_by_key(|(name, _)| name.len())
            .unwrap_or_else(|| panic!("{stem}: no model has this name"));
        tried += 1;
        let laws = Laws::parse(model, &text).unwrap_or_else(|errors| panic!("{errors:?}"));
        let plan = SimulationPlan {
            duration: 1.5,
            samples: 15,
            method: IntegrationMethod::DormandPrince {
                relative: 1e-7,
                absolute: 1e-7,
            },
            step_limit: 20_000,
            event_tolerance: EVENT_TOLERANCE,
        };
        let run = MultibodySystem::new(model, laws, &EquationSetting::default())
            .and_then(|(mut system, state)| simulate(&mut system, &state, &plan, &mut |_| {}))
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let last = run.samples.last().expect("samples");
        let most = run.energy_scale();
        let moved = text.contains("amplitude");
        assert!(
            moved || last.energy.kinetic < 0.01 * most,
            "{name} still moves"
        );
        assert!(last.work.abs() > 0.1 * most, "{name}: {} J", last.work);
        let drift = run.energy_drift();
        assert!(drift < 1e-3 * most, "{name}: {drift:e} of {most:e}");
    }
    assert!(tried >= 5, "the laws that ship");
}
