//! The models under `examples/` run.

use robovec::model::{Model, mbs::read_mbs};
use robovec::motion::{Laws, Method, Plan, Setting, System, simulate};
use std::fs;
use std::path::Path;

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
        let plan = Plan {
            duration: if joints < 30 { 0.2 } else { 2e-3 },
            samples: 2,
            method: Method::RungeKutta { step: 1e-3 },
            step_limit: 1000,
        };
        let laws = Laws::none(&model);
        let run = System::new(&model, laws, &Setting::default())
            .and_then(|(mut system, state)| simulate(&mut system, &state, &plan, &mut |_| {}))
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let total = run.samples[0].energy;
        let scale = total.kinetic.abs() + total.gravity.abs() + 1.0;
        let drift = run.energy_drift();
        assert!(drift < 1e-8 * scale, "{name}: {drift:e} of {scale:e}");
        assert!(run.largest_gap() < 1e-10, "{name}: {:e}", run.largest_gap());
    }
}
