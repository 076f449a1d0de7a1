//! The report of a small placed function.

use super::*;
use robovec_analysis::class::NumericClass;
use robovec_analysis::rounding::rounding;
use robovec_framework::check::check;
use robovec_ir::placement::{
    Address, Bank, BufferWord, Element, ElementKind, Placement, Preload, Schedule, Slot, Word,
    Write,
};
use robovec_ir::states::States;
use robovec_ir::{
    Boundary, Input, Level, Name, Node, Operand, Operation, Output, Shape, SourceSet,
};

/// `y[1] = (0 - q[1]*q[2]) + q[1]`, `y[2] = sin(q[2])`, on one adder and one
/// multiplier.
fn sample() -> Module {
    let mut module = Module::new();
    let symbols = &mut module.tables.symbols;
    let mut function = Function::new("sample", Level::Placed);
    function
        .metadata
        .push(("model".to_owned(), "Sample".to_owned()));
    function.add_input(symbols.intern("q"), Shape::Vector(2));
    function.add_input(symbols.intern("F"), Shape::Scalar);
    function.add_output(symbols.intern("y"), Shape::Vector(2));
    function.boundaries.push(Boundary {
        callee: "user_Force".to_owned(),
        arguments: vec!["y".to_owned(), "tsim".to_owned()],
        result: Some("F".to_owned()),
        sources: SourceSet::EMPTY,
    });
    let (a, b) = (Operand::from(Input(0)), Operand::from(Input(1)));
    let zero = Operand::from(function.constant(0.0));
    let mut push = |name: &str, operation, operands: [Operand; 2]| {
        let name = Name::plain(symbols.intern(name));
        Operand::from(function.push(Node {
            name,
            sources: SourceSet::EMPTY,
            operands: Operand::list(operands),
            operation,
        }))
    };
    let sine = push("S", Operation::Sin, [b, Operand::NONE]);
    let product = push("P", Operation::Mul, [a, b]);
    let minus = push("N", Operation::Sub, [zero, product]);
    let sum = push("A", Operation::Add, [minus, a]);
    for (index, operand) in [sum, sine].into_iter().enumerate() {
        function.assign(Output(index as u32), operand, SourceSet::EMPTY);
    }
    place(&mut function, [a, b, zero]);
    module.functions.push(function);
    module
}

fn place(function: &mut Function, [a, b, zero]: [Operand; 3]) {
    let kind = |name: &str| ElementKind {
        name: name.to_owned(),
        count: 1,
    };
    let slot = |cycle, element| {
        let element = Element::new(element);
        Some(Slot { cycle, element })
    };
    function.schedule = Some(Schedule {
        machine: "thesis".to_owned(),
        machine_hash: None,
        kinds: vec![kind("add"), kind("multi")],
        slots: vec![None, slot(0, 1), slot(9, 0), slot(21, 0)],
        cycles: 33,
        lower_bound: 31,
    });
    let word = |element, address| Word {
        element: Element::new(element),
        bank: Bank::Unified,
        address: Address::new(address),
    };
    let preload = |element, address, operand| Preload {
        word: word(element, address),
        operand,
    };
    let write = |address, cycle| Write {
        word: word(0, address),
        cycle,
    };
    function.placement = Some(Placement {
        preloads: vec![
            preload(0, 0, zero),
            preload(0, 1, a),
            preload(1, 0, a),
            preload(1, 1, b),
        ],
        reads: [None, Some([0, 1]), Some([0, 2]), Some([3, 1])]
            .map(|read| match read {
                None => [None; Operand::MAX_COUNT],
                Some([left, right]) => [Some(Address::new(left)), Some(Address::new(right)), None],
            })
            .to_vec(),
        buffers: vec![None, Some(BufferWord::new(0)), None, None],
        write_starts: vec![0, 0, 1, 2, 3],
        writes: vec![write(2, 8), write(3, 20), write(0, 32)],
        homes: vec![Some(word(0, 0)), None],
    });
}

fn report() -> ModuleReport {
    let module = sample();
    let machine = Machine::built_in("thesis").expect("it ships");
    let view = module.tables.view(&module.functions[0]);
    let record = |name: &str, verdict| PassRunRecord {
        function: "sample".to_owned(),
        name: name.to_owned(),
        cpu_s: 0.001,
        peak_mb: None,
        operations: 3,
        asap_cycle: 31,
        verdict,
        rounding: None,
    };
    let measured = Arc::new(rounding(view, &States::new(1), 32));
    let passes = [
        PassRunRecord {
            rounding: Some([measured.clone(), measured]),
            ..record(
                "atomise",
                Some(check(view, view, NumericClass::Exact, &States::new(1), 3)),
            )
        },
        record("place{n_add=1 n_multi=1}", None),
        PassRunRecord {
            function: "another".to_owned(),
            ..record("dce", None)
        },
    ];
    ModuleReport::collect(&module, &machine, &passes, &ReportOptions::default())
}

#[test]
fn the_json_form_has_the_documented_names_and_the_right_numbers() {
    let json: serde_json::Value = serde_json::from_str(&report().to_json()).expect("it is JSON");
    let function = &json["functions"][0];
    for (name, expected) in [
        ("equations", 4),
        ("operations", 3),
        ("add_sub", 2),
        ("mul", 1),
        ("div", 0),
        ("sqrt", 0),
        ("sin_cos", 1),
        ("negations", 1),
        ("vectors", 3),
        ("asap", 3),
        ("asap_cycle", 31),
    ] {
        assert_eq!(function[name], expected, "{name}");
    }
    assert_eq!(json["robovec"], env!("CARGO_PKG_VERSION"));
    assert_eq!(function["model"], "Sample");
    assert_eq!(function["level"], "placed");
    assert_eq!(function["number_y"], 3.0 / 31.0);
    assert_eq!(function["passes"].as_array().expect("a list").len(), 2);
    assert_eq!(function["passes"][0]["check"]["result"], "bit-equal");
    assert_eq!(function["passes"][1]["check"], serde_json::Value::Null);
    let schedule = &function["schedule"];
    assert_eq!(schedule["number"], "binary32");
    assert_eq!(schedule["n_add"], 1);
    // The estimated clock of the machine.
    assert_eq!(schedule["time_us"], 33.0 / 120.0);
    assert_eq!(schedule["parallelisation_rate"], 3.0 / 66.0);
    assert_eq!(schedule["memory"]["add"]["max"], 4);
    assert_eq!(schedule["memory"]["multi"]["mean"], 2.0);
    assert_eq!(schedule["buffer"]["add"]["max"], 0);
    assert_eq!(schedule["buffer"]["multi"]["min"], 1);
    assert_eq!(schedule["transfers"]["direct"], 2);
    assert_eq!(schedule["transfers"]["indirect"], 1);
    let error = &function["error"];
    assert_eq!(error["reference"], "certified");
    assert_eq!(error["certain"], 1.0);
    let elements = &error["binary32"]["arrays"][0]["elements"];
    assert_eq!(elements[1]["name"], "y[2]");
    let ulps = elements[1]["ulps"]["worst"].as_f64().expect("a number");
    assert!(ulps <= 0.5 && ulps > 0.0, "a sine rounded once: {ulps}");
}

#[test]
fn occupation_sums_to_the_operations() {
    let report = report();
    let schedule = report.functions[0].schedule.as_ref().expect("it is placed");
    // 33 cycles in 64 slices: every slice holds one cycle or none.
    let busy = |kind: &KindReport| kind.occupation.iter().sum::<f64>();
    let counts: Vec<f64> = schedule.elements.iter().map(busy).collect();
    assert_eq!(counts, [2.0, 1.0]);
}

#[test]
fn the_text_form_is_aligned() {
    insta::assert_snapshot!(report().to_text());
}

/// All names in a JSON value, those of objects keyed by kind left out.
fn names(value: &serde_json::Value, found: &mut std::collections::BTreeSet<String>) {
    match value {
        serde_json::Value::Object(object) => {
            for (name, value) in object {
                found.insert(name.clone());
                names(value, found);
            }
        }
        serde_json::Value::Array(list) => list.iter().for_each(|value| names(value, found)),
        _ => {}
    }
}

#[test]
fn every_name_of_the_json_form_is_documented() {
    let json = serde_json::from_str(&report().to_json()).expect("it is JSON");
    let mut found = std::collections::BTreeSet::new();
    names(&json, &mut found);
    let manual = include_str!("../../../../docs/report.md");
    for name in found {
        // The kinds of elements are the user's own names.
        if name != "add" && name != "multi" {
            assert!(
                manual.contains(&format!("`{name}`")),
                "{name} is not documented"
            );
        }
    }
}

#[test]
fn what_is_not_finite_is_null() {
    let mut report = report();
    report.functions[0].error.binary32.summary.worst_ulps = f64::INFINITY;
    report.functions[0].error.binary64.summary.median_relative = f64::NAN;
    let json: serde_json::Value = serde_json::from_str(&report.to_json()).expect("it is JSON");
    let error = &json["functions"][0]["error"];
    assert_eq!(error["binary32"]["worst_ulps"], serde_json::Value::Null);
    assert_eq!(
        error["binary64"]["median_relative"],
        serde_json::Value::Null
    );
}
