//! Effect of series for sines and cosines on models, and runs of programs with
//! them.

use robovec::generate::{GenerationRequest, generate};
use robovec::model::Model;
use robovec::model::mbs::read_mbs;
use robovec::robotran::FunctionKind;
use robovec::simulate::LoadedProgram;
use robovec::simulate::mif::Image;
use robovec::trigonometry::{
    TrigonometryEffect, TrigonometrySetting, figure, measure, table, text,
};
use robovec_fpga::manifest::Manifest;
use robovec_fpga::{images, write_images};
use robovec_framework::manager::{self, Config, RunOutcome};
use robovec_ir::evaluate::evaluate;
use robovec_ir::states::States;
use robovec_ir::{Format, Machine, Module, View};
use robovec_num::arithmetic::{Arithmetic, Binary32};
use robovec_num::trigonometry::host::TrigonometricUnit;
use robovec_passes::registry::REGISTRY;
use robovec_passes::trigonometry::CircularMethod;
use std::fs;
use std::path::Path;

fn example(name: &str) -> (Model, Module) {
    let file = format!("{name}.mbs");
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    let bytes = fs::read(models.join(&file)).expect("it is in the repository");
    let model = read_mbs(&file, &bytes).expect("it is well formed").model;
    let module =
        generate(&model, &GenerationRequest::new(FunctionKind::Dirdyna)).expect("it has equations");
    (model, module)
}

fn thesis() -> Machine {
    Machine::built_in("thesis").expect("it ships")
}

fn run(module: &mut Module, passes: &str) -> RunOutcome {
    let pipeline = REGISTRY.pipeline(passes).expect("a sound pipeline");
    let mut log = std::io::sink();
    manager::run(module, &pipeline, Config::new(&thesis(), &mut log)).expect("it runs")
}

fn effect(
    name: &str,
    method: CircularMethod,
    orders: &[u32],
    angles: &[f64],
) -> TrigonometryEffect {
    let (model, module) = example(name);
    let setting = TrigonometrySetting {
        method,
        orders: orders.to_vec(),
        angles: angles.to_vec(),
        halvings: 0,
        format: Format::BINARY32,
        states: 12,
        seed: 1,
    };
    let effects = measure(name, &module, Some(&model), &thesis(), &setting);
    effects.expect("it can be measured").remove(0)
}

/// The median error of the mass matrix.
fn mass_matrix(effect: &TrigonometryEffect, angle: f64, order: Option<u32>) -> f64 {
    let array = effect.arrays.iter().position(|array| array == "M");
    let rows = effect.rows.iter();
    let mut rows = rows.filter(|row| row.angle == angle && row.order == order);
    let row = rows.next().expect("it was measured");
    row.errors[array.expect("there is a mass matrix")].median
}

#[test]
fn series_of_taylor_spoil_the_bogie_as_is_known() {
    let angles = [0.01, 0.1, 0.5];
    let effect = effect("bogie", CircularMethod::Taylor, &[1, 3, 5, 7], &angles);
    // Orders of magnitude known from another model of a bogie: 1.3e-4, 7e-3
    // and 0.34 for order 1; 2.6e-6 and 4e-3 for order 3; 8.6e-8, which is
    // the rounding of binary32, for order 7.
    for (angle, order, known) in [
        (0.01, 1, 1.3e-4),
        (0.1, 1, 7e-3),
        (0.5, 1, 0.34),
        (0.1, 3, 2.6e-6),
        (0.5, 3, 4e-3),
        (0.5, 7, 8.6e-8),
    ] {
        let found = mass_matrix(&effect, angle, Some(order));
        let ratio = found / known;
        assert!(
            (0.5..2.0).contains(&ratio),
            "order {order} at {angle}: {found:e} instead of {known:e}"
        );
    }
    let rounding = mass_matrix(&effect, 0.5, None);
    assert!(mass_matrix(&effect, 0.5, Some(7)) < 2.0 * rounding);
    assert!(mass_matrix(&effect, 0.5, Some(5)) > 20.0 * rounding);
    let shown = text(&effect);
    assert!(
        shown.contains("M: median") && shown.contains("true"),
        "{shown}"
    );
    let effects = [effect];
    // 3 ranges, 5 ways, 2 arrays.
    assert_eq!(table(&effects).rows.len(), 30);
    assert_eq!(figure(&effects).panels.len(), 2);
}

#[test]
fn fitted_polynomials_reach_rounding_with_a_lower_order() {
    let fitted = effect("bogie", CircularMethod::Minimax, &[3, 5], &[0.5]);
    let series = effect("bogie", CircularMethod::Taylor, &[3, 5], &[0.5]);
    for order in [3, 5] {
        let (fitted, series) = (
            mass_matrix(&fitted, 0.5, Some(order)),
            mass_matrix(&series, 0.5, Some(order)),
        );
        assert!(fitted < series / 4.0, "{order}: {fitted:e}, {series:e}");
    }
}

#[test]
fn polynomials_are_shortened_placed_and_simulated() {
    let (_, mut module) = example("double-pendulum");
    let passes = "trigonometry{error=1e-6 range=0.5},$shorten,place";
    run(&mut module, passes);
    let function = &module.functions[0];
    let nodes = function.nodes().iter();
    assert_eq!(
        nodes
            .filter(|node| node.operation.is_trigonometric())
            .count(),
        0
    );
    simulate(&module, None);
}

#[test]
fn the_host_computes_what_it_is_told_to() {
    for method in [
        "method=cordic iterations=20 bits=26",
        "method=table entries=32 degree=3 bits=30",
        "method=polynomial order=7 bits=30",
    ] {
        let (_, mut module) = example("double-pendulum");
        run(
            &mut module,
            &format!("trigonometry{{on=host {method}}},$shorten,place"),
        );
        let unit = module.functions[0]
            .trigonometry_unit()
            .expect("it is named");
        simulate(&module, Some(&unit.expect("it is one")));
    }
}

#[test]
fn images_with_numbers_hold_the_sines_of_the_method() {
    // So coarse a table that the library's sines are others.
    let (_, mut module) = example("double-pendulum");
    run(
        &mut module,
        "trigonometry{on=host method=table entries=8 degree=1 bits=12 error=1},$shorten,place",
    );
    let function = &module.functions[0];
    let unit = function.trigonometry_unit().expect("it is named");
    let unit = unit.expect("it is one");
    let unit = unit.within(Binary32);
    let view = View {
        tables: &module.tables,
        function,
    };
    let inputs = vec![0.7; function.input_len()];
    let files = images(view, &thesis(), Some(&inputs)).expect("it has images");
    let file = |name: &str| {
        let found = files.iter().find(|(known, _)| known.ends_with(name));
        &found.expect("it is written").1
    };
    let manifest: Manifest = serde_json::from_str(file("manifest.json")).expect("it is one");
    let memories: Vec<_> = manifest
        .elements
        .iter()
        .flat_map(|it| &it.memories)
        .collect();
    let mut found = 0;
    for (value, word) in manifest
        .host
        .iter()
        .flat_map(|it| it.words.iter().map(move |word| (it, word)))
    {
        let (sine, usual) = match value.operation.as_str() {
            "sin" => (unit.sin(0.7), 0.7f32.sin()),
            "cos" => (unit.cos(0.7), 0.7f32.cos()),
            _ => continue,
        };
        assert_ne!(sine, usual);
        let memory = memories.iter().find(|memory| memory.name == word.memory);
        let image = Image::parse(file(&memory.expect("a memory").file)).expect("an image");
        // Those of sums of angles are left out.
        found += u32::from(image.word(word.address) == [u64::from(sine.to_bits())]);
    }
    assert!(found >= 2, "{found}");
}

/// Runs the images and compares with the evaluator, bit for bit.
fn simulate(module: &Module, unit: Option<&TrigonometricUnit>) {
    let function = &module.functions[0];
    let view = View {
        tables: &module.tables,
        function,
    };
    let mut files: Vec<(String, String)> = Vec::new();
    write_images(view, &thesis(), None, &mut files).expect("it can be written");
    let program = LoadedProgram::load(&files, &thesis()).expect("it can be loaded");
    for state in 0..4 {
        let inputs = States::new(5).draw(view, state);
        let found = program.run(&inputs).expect("no hazard").values;
        let narrow: Vec<f32> = inputs.iter().map(|&x| x as f32).collect();
        let exact = match unit {
            None => evaluate(function, &Binary32, &narrow),
            Some(unit) => evaluate(function, &unit.within(Binary32), &narrow),
        };
        let exact: Vec<f64> = exact.into_iter().map(f64::from).collect();
        assert_eq!(found, exact);
    }
}
