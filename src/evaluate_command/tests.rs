use super::*;
use robovec_ir::parse::parse_module;
use robovec_model::mbs::read_mbs;

const TEXT: &str = "\
// robovec 1
function f equations {
  in q[1..2]
  in m[1..1]
  out y[1..2]

  %a = sin(q[1])*m[1]
  y[1] = %a + q[2]/3.0
  y[2] = sqrt(q[2])
}
";

fn module() -> Module {
    parse_module("f", TEXT).unwrap_or_else(|errors| panic!("{errors:?}"))
}

fn format(name: &str) -> NumberSystem {
    name.parse().expect("a format")
}

fn evaluated(number: NumberSystem, format: ResultFormat) -> String {
    let states = "state\nq[1] 1\nq[2] 2\nm[1] 0x1p+1\n";
    let request = EvaluationRequest {
        module: &module(),
        model: None,
        states: StateSource::Text(states),
        number,
        format,
    };
    evaluate_at_states(&request).unwrap_or_else(|errors| panic!("{errors:?}"))
}

/// The first output, from the table.
fn first(number: NumberSystem) -> String {
    let table = evaluated(number, ResultFormat::Csv);
    let line = table.lines().nth(1).expect("a line");
    line.rsplit(',').next().expect("a value").to_owned()
}

#[test]
fn every_kind_of_number_has_its_digits() {
    // 2 sin 1 + 2/3.
    let exact = "2.349608636282459679971671309927264665911792788263";
    let close = |number: NumberSystem, digits: usize| {
        let found = first(number);
        assert!(found.starts_with(&exact[..digits]), "{number:?}: {found}");
    };
    close(format("f32"), 8);
    close(format("f64"), 16);
    close(format("float(11,40)"), 12);
    close(format("fixed(3,45)"), 14);
    assert_eq!(first(format("f16")), "2.349609375");
    assert_eq!(first(format("bf16")), "2.34375");
    close(NumberSystem::DoubleDouble, 31);
    close(NumberSystem::Bits(53), 18);
    close(NumberSystem::Bits(150), 46);
    let field: u64 = first(NumberSystem::Field)
        .parse()
        .expect("a natural number");
    assert!(field < PrimeField::pair(1, true)[0].prime.modulus());
}

#[test]
fn formats_hold_the_same() {
    let text = evaluated(format("f64"), ResultFormat::Hexadecimal);
    assert_eq!(
        text,
        "state 1 f y[1] 0x1.2cbff9cd9dbccp+1\nstate 1 f y[2] 0x1.6a09e667f3bcdp+0\n"
    );
    let table = evaluated(format("f64"), ResultFormat::Csv);
    assert_eq!(
        table,
        "state,function,output,value\n1,f,\"y[1]\",2.3496086362824595\n\
         1,f,\"y[2]\",1.4142135623730951\n"
    );
    for number in [format("f32"), NumberSystem::Bits(100)] {
        let json: serde_json::Value =
            serde_json::from_str(&evaluated(number, ResultFormat::Json)).expect("JSON");
        let value = &json[0]["outputs"]["y[2]"];
        let value = value.as_f64().or_else(|| value.as_str()?.parse().ok());
        let error = value.expect("a number") - 2f64.sqrt();
        assert!(error.abs() < 1e-7, "{json}");
        assert_eq!(
            (&json[0]["state"], &json[0]["function"]),
            (&1.into(), &"f".into())
        );
    }
}

#[test]
fn numbers_are_named() {
    assert_eq!("f32".parse(), Ok(format("f32")));
    assert_eq!("double-double".parse(), Ok(NumberSystem::DoubleDouble));
    assert_eq!("200".parse(), Ok(NumberSystem::Bits(200)));
    assert_eq!("float(8,17)".parse(), Ok(format("float(8,17)")));
    for wrong in ["f15", "float(8,60)", "0", "-3", "1e3", "99999999"] {
        assert!(wrong.parse::<NumberSystem>().is_err(), "{wrong}");
    }
}

const MODEL: &[u8] = b"<mbsDescR7><mbsname>one</mbsname>\
    <base><gravity><coordinates><x>0</x><y>0</y><z>-9.81</z></coordinates></gravity></base>\
    <bodytree><body><bodyname>b</bodyname>\
    <parent><bodyname>base</bodyname><pointname>origin</pointname></parent>\
    <joint><jointname>j</jointname><type>R2</type><nature>independent</nature></joint>\
    <mass>7</mass></body></bodytree></mbsDescR7>";

#[test]
fn a_model_gives_the_parameters() {
    let model = read_mbs("one.mbs", MODEL).expect("a model").model;
    let module = module();
    let evaluate = |states: StateSource<'_>, model| {
        evaluate_at_states(&EvaluationRequest {
            module: &module,
            model,
            states,
            number: format("f64"),
            format: ResultFormat::Csv,
        })
    };
    let partial = StateSource::Text("state\nq[1] 0.5\nq[2] 0\n");
    let with = evaluate(partial, Some(&model)).expect("the mass is the model's");
    assert!(
        with.contains(&format!("\"y[1]\",{:?}", 7.0 * 0.5f64.sin())),
        "{with}"
    );
    let errors = evaluate(partial, None).expect_err("there is no mass");
    assert!(errors[0].message.contains("m[1]"), "{errors:?}");
    let own = StateSource::Text("state\nq[1] 0.5\nq[2] 0\nm[1] 1\n");
    let own = evaluate(own, Some(&model)).expect("all is given");
    assert!(
        own.contains(&format!("\"y[1]\",{:?}", 0.5f64.sin())),
        "{own}"
    );
    let sources = [1, 2].map(States::new);
    let drawn = |seed: usize, model| {
        let states = &sources[seed - 1];
        evaluate(StateSource::Random { count: 3, states }, model)
    };
    assert_eq!(drawn(1, Some(&model)), drawn(1, Some(&model)));
    assert_ne!(drawn(1, Some(&model)), drawn(2, Some(&model)));
    assert_ne!(drawn(1, Some(&model)), drawn(1, None));
    let mut larger = parse_module("f", &TEXT.replace("m[1..1]", "m[1..9]")).expect("a module");
    larger.functions[0].name = "larger".to_owned();
    let errors = evaluate_at_states(&EvaluationRequest {
        module: &larger,
        model: Some(&model),
        states: StateSource::Random {
            count: 1,
            states: &States::new(1),
        },
        number: format("f64"),
        format: ResultFormat::Csv,
    })
    .expect_err("the model has one joint");
    assert!(errors[0].message.contains("m[2]"), "{errors:?}");
    assert_eq!(drawn(1, None).expect("three states").lines().count(), 7);
}
