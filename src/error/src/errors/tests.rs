//! Tables of small functions.

use super::*;
use robovec_analysis::interval::GivenData;
use robovec_ir::parse::parse_module;
use robovec_ir::states::States;
use robovec_ir::{Format, Module};

fn module() -> Module {
    let text = "source 0 \"f.c\"
function f equations {
  in q[1..3]
  out c[1..2]
  %big = q[1]*q[2] @1:1-20
  %small = (%big - q[3])*0.1 @2:1-20
  c[1] = %small @3:1-20
  c[2] = %big @4:1-20
}";
    parse_module("sample", text).expect("it is well formed")
}

fn settings(methods: &[ErrorMethod], format: &str) -> ErrorSettings {
    ErrorSettings {
        format: format.parse().expect("it is one"),
        states: States::new(1),
        state: 0,
        blamed: 3,
        methods: methods.to_vec(),
        outputs: vec![0, 1],
        most_equations: 12,
        window: 100,
        samples: 8,
        boxes: 100,
        effort: 1,
        data: GivenData::Held,
    }
}

#[test]
fn all_methods_agree_with_the_error() {
    let module = module();
    let view = module.tables.view(&module.functions[0]);
    let all = [
        ErrorMethod::Proof,
        ErrorMethod::Bound,
        ErrorMethod::Predict,
        ErrorMethod::Stochastic,
        ErrorMethod::Interval,
    ];
    let table = ErrorTable::measure(view, &settings(&all, "f32")).expect("f32 can be sampled");
    assert_eq!(table.outputs.len(), 2);
    for row in &table.outputs {
        let error = row.error.abs();
        assert!(error > 0.0 && error <= row.bound.expect("it was asked for"));
        let predicted = row.predicted.expect("it was asked for");
        assert!((predicted - row.error).abs() <= 1e-9 * error);
        assert!(error <= 4.0 * row.sigma.expect("it was asked for"));
        let interval = row.interval.as_ref().expect("it was asked for");
        assert!(interval.low <= row.exact && row.exact <= interval.high);
        assert!(error <= interval.error && interval.ranges == "drawn");
        let proof = row.proof.as_ref().expect("it was asked for");
        assert!(proof.low <= row.exact && row.exact <= proof.high);
        assert!(error <= proof.error && proof.found <= proof.error && proof.found > 0.0);
    }
    let shares: f64 = table
        .heat
        .equations
        .iter()
        .map(|equation| equation.share)
        .sum();
    assert!((shares + table.heat.literals - 1.0).abs() < 1e-9);
    let text = text(&table);
    assert!(
        text.contains("predicted") && text.contains("window loses"),
        "{text}"
    );
    assert!(text.contains('█') && text.contains("f.c:2:1"), "{text}");
    let csv = csv(std::slice::from_ref(&table));
    assert_eq!(csv.lines().count(), 3);
    let value: serde_json::Value = serde_json::from_str(&json(&[table])).expect("it is JSON");
    assert_eq!(value[0]["outputs"][1]["name"], "c[2]");
}

#[test]
fn a_proof_is_printed_alone_or_before_the_state() {
    let module = module();
    let view = module.tables.view(&module.functions[0]);
    let shown = |methods: &[ErrorMethod], format| {
        let table = ErrorTable::measure(view, &settings(methods, format));
        text(&table.expect("nothing is sampled"))
    };
    let alone = shown(&[ErrorMethod::Proof], "f32");
    assert!(
        alone.contains("largest proved") && !alone.contains("at state"),
        "{alone}"
    );
    let both = shown(&[ErrorMethod::Proof, ErrorMethod::Predict], "f32");
    assert!(
        both.contains("largest proved") && both.contains("predicted"),
        "{both}"
    );
    let refused = shown(&[ErrorMethod::Proof], "fixed(2,8)");
    assert!(refused.contains("may overflow"), "{refused}");
    assert!(
        refused.contains("without a bound, the first by %big"),
        "{refused}"
    );
}

#[test]
fn a_narrow_format_blames_inputs_and_a_wide_one_cannot_be_sampled() {
    let module = module();
    let view = module.tables.view(&module.functions[0]);
    let table = ErrorTable::measure(view, &settings(&[], "f16")).expect("nothing is sampled");
    assert!(!table.heat.inputs.is_empty() && table.heat.literals > 0.0);
    assert!(text(&table).contains("which it cannot hold"));
    let sampled = ErrorTable::measure(view, &settings(&[ErrorMethod::Stochastic], "f64"));
    assert!(sampled.is_err());
    let heat = Heat::measure(view, Format::BINARY32, &States::new(1));
    assert_eq!((heat.states, heat.outputs), (4, 2));
    assert!(heat.equations[0].share >= heat.equations[1].share);
}
