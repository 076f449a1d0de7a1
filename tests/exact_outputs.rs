//! The exact outputs that errors are measured against, compared with
//! arbitrary precision on the models that ship: each must be the nearest
//! binary64 number. With the feature `mpfr` also with GNU MPFR at 400 bits, on
//! all models:
//!
//!     cargo test --features mpfr --test all exact_outputs::

use astro_float::{BigFloat, Consts, RoundingMode};
use robovec::generate::{GenerationRequest, generate};
use robovec::model::mbs::read_mbs;
use robovec::robotran::FunctionKind;
use robovec_analysis::reference::{
    ExactEvidence, ExactOutput, ReferenceEffort, ReferenceEvaluator,
};
use robovec_ir::plan::EvaluationPlan;
use robovec_ir::states::States;
use robovec_ir::{Function, Module, Operation, View};
use std::fs;
use std::path::Path;

const ROUNDING: RoundingMode = RoundingMode::ToEven;

/// The direct dynamics of an example.
fn module(file: &str) -> Module {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    let bytes = fs::read(folder.join(file)).expect("it is in the repository");
    let model = read_mbs(file, &bytes).expect("it is well formed").model;
    let request = GenerationRequest::new(FunctionKind::Dirdyna);
    generate(&model, &request).expect("it has equations")
}

/// Some states with their certified outputs, all of which are certain.
fn certified(name: &str, module: &Module, count: u32) -> Vec<(Vec<f64>, Vec<ExactOutput>)> {
    let function = &module.functions[0];
    let view = View {
        tables: &module.tables,
        function,
    };
    let states: Vec<Vec<f64>> = (0..count)
        .map(|state| States::new(1).draw(view, state))
        .collect();
    let exact = ReferenceEvaluator::new(function, ReferenceEffort::Certified).evaluate(&states);
    for (place, value) in exact.iter().flatten().enumerate() {
        assert!(value.is_certain(), "{name}: {place}: {value:?}");
    }
    states.into_iter().zip(exact).collect()
}

/// The outputs at this number of bits, without any bound.
fn evaluate(function: &Function, inputs: &[f64], bits: usize) -> Vec<BigFloat> {
    let mut constants = Consts::new().expect("there is memory");
    EvaluationPlan::new(function).run_with(
        inputs,
        |number| BigFloat::from_f64(number, bits),
        |operation, [a, b, _]| match operation {
            Operation::Neg => a.neg(),
            Operation::Add => a.add(b, bits, ROUNDING),
            Operation::Sub => a.sub(b, bits, ROUNDING),
            Operation::Mul => a.mul(b, bits, ROUNDING),
            Operation::Div => a.div(b, bits, ROUNDING),
            Operation::Sin => a.sin(bits, ROUNDING, &mut constants),
            Operation::Cos => a.cos(bits, ROUNDING, &mut constants),
            Operation::Sqrt => a.sqrt(bits, ROUNDING),
            other => unreachable!("{other:?} is not generated"),
        },
    )
}

/// True when no binary64 number is nearer than this one.
fn is_nearest(number: f64, exact: &BigFloat) -> bool {
    let distance = |number: f64| {
        let number = BigFloat::from_f64(number, 448);
        exact.sub(&number, 448, ROUNDING).abs()
    };
    let own = distance(number);
    [number.next_up(), number.next_down()]
        .into_iter()
        .all(|other| own.cmp(&distance(other)).is_some_and(|order| order <= 0))
}

#[test]
fn certified_outputs_are_the_nearest_to_those_at_448_bits() {
    let mut compared = 0;
    for name in [
        "bogie",
        "double-pendulum",
        "four-bar",
        "quarter-car",
        "slider-crank",
        "serial-23",
        "parallel-23",
    ] {
        let module = module(&format!("{name}.mbs"));
        for (inputs, exact) in certified(name, &module, 2) {
            let wide = evaluate(&module.functions[0], &inputs, 448);
            let least = BigFloat::from_f64(1e-100, 64);
            for (place, (value, wide)) in exact.iter().zip(&wide).enumerate() {
                let right = match value.kind {
                    ExactEvidence::Zero => wide.abs().cmp(&least).is_some_and(|order| order < 0),
                    _ => is_nearest(value.value.high, wide),
                };
                assert!(right, "{name}, output {place}: {value:?}");
                compared += 1;
            }
        }
    }
    assert!(compared > 2000, "{compared}");
}

#[test]
fn the_audit_agrees_with_what_is_certified() {
    for name in ["bogie", "four-bar", "serial-23"] {
        let module = module(&format!("{name}.mbs"));
        for (inputs, exact) in certified(name, &module, 2) {
            let mut audit = ReferenceEvaluator::new(&module.functions[0], ReferenceEffort::Audit);
            let audited = audit.evaluate(&[inputs]);
            for (place, (value, other)) in exact.iter().zip(&audited[0]).enumerate() {
                assert_eq!(value.value.high, other.value.high, "{name}, output {place}");
                assert!(matches!(
                    other.kind,
                    ExactEvidence::Precise(_) | ExactEvidence::Zero
                ));
            }
        }
    }
}

/// Every model that ships, up to 130 joints. The larger ones in fewer states.
#[cfg(feature = "mpfr")]
#[test]
fn certified_outputs_are_those_of_mpfr_at_400_bits() {
    use robovec_analysis::reference::mpfr;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    let mut files: Vec<String> = fs::read_dir(folder)
        .expect("it is there")
        .map(|entry| entry.expect("it is readable").file_name())
        .filter_map(|name| name.into_string().ok())
        .filter(|name| name.ends_with(".mbs"))
        .collect();
    files.sort();
    assert!(files.len() >= 20, "{files:?}");
    for file in &files {
        let module = module(file);
        let function = &module.functions[0];
        let count = (1_000_000 / function.nodes().len()).clamp(1, 8) as u32;
        let (mut zeros, mut precise, mut all) = (0, 0, 0);
        for (inputs, exact) in certified(file, &module, count) {
            let wide = mpfr::evaluate(function, &inputs, 400);
            for (place, (value, wide)) in exact.iter().zip(wide).enumerate() {
                all += 1;
                precise += u32::from(matches!(value.kind, ExactEvidence::Precise(_)));
                if value.kind == ExactEvidence::Zero {
                    zeros += 1;
                    assert!(wide.abs() < 1e-90, "{file}, output {place}: {wide:e}");
                } else {
                    let high = value.value.high;
                    assert_eq!(high.to_bits(), wide.to_bits(), "{file}, output {place}");
                }
            }
        }
        println!(
            "{file}: {count} states, {all} outputs, {precise} in arbitrary precision, {zeros} zero by identity"
        );
    }
}
