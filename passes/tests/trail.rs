use robovec_framework::manager::{Config, run};
use robovec_framework::trail::*;
use robovec_ir::parse::parse_module;
use robovec_ir::print::print_module;
use robovec_ir::{Machine, Module};
use robovec_passes::registry::REGISTRY;

const TEXT: &str = "// robovec 1
source 0 \"arm.m\"

function arm equations {
  in q[1..4]
  out M[1..2]

  %C1 = cos(q[1]) @1:1-9
  %A = q[1] + q[2]*%C1 + q[3] + q[4] @2:1-9
  %B = q[2]*%C1*q[4] @3:1-9
  %D = q[4]*%C1 @4:1-9
  %E = q[4]*%C1 @5:1-9

  M[1] = %A*%B - %D @6:1-9
  M[2] = %E + 2.0 @7:1-9
}
";

fn compiled(passes: &str) -> (Module, Trail) {
    compile(TEXT, passes)
}

fn compile(text: &str, passes: &str) -> (Module, Trail) {
    let mut module = parse_module("arm.rvir", text).expect("the text is sound");
    let machine = Machine::built_in("thesis").expect("it ships");
    let pipeline = REGISTRY.pipeline(passes).expect("the pipeline is sound");
    let mut trail = Trail::new();
    let mut log = Vec::new();
    let config = Config {
        histories: true,
        trail: Some(&mut trail),
        ..Config::new(&machine, &mut log)
    };
    run(&mut module, &pipeline, config).expect("the passes run");
    (module, trail)
}

fn account(module: &Module, trail: &Trail, asked: &str) -> Account {
    let machine = Machine::built_in("thesis").expect("it ships");
    let (index, item) = find(module, trail, asked).expect("it exists");
    let function = &module.functions[index];
    explain(&module.tables, function, trail, &machine, item)
}

/// Passes and expressions of an account, without the times.
fn story(account: &Account) -> Vec<String> {
    let mut lines: Vec<String> = account.read.iter().map(|read| read.text.clone()).collect();
    for entry in &account.entries {
        for change in &entry.changes {
            let rules = change.rules.join(", ");
            lines.push(format!("{} [{rules}] {}", entry.pass, change.after.text));
        }
    }
    lines
}

#[test]
fn the_story_of_a_value_has_its_expressions() {
    let (module, trail) = compiled("atomise,balance,cse,dce");
    let told = account(&module, &trail, "%A");
    assert_eq!(
        story(&told),
        [
            "%A = q[1] + q[2]*%C1 + q[3] + q[4]",
            "atomise [] %A = q[1] + q[2]*%C1 + q[3] + q[4]",
            "balance [] %A = q[1] + q[3] + (%A.1 + q[4])",
        ]
    );
    let now = told.now.expect("it is still there");
    assert_eq!((now.arrival, now.path), (31, 50));
}

#[test]
fn the_story_of_an_output_goes_on_with_the_value_made_for_it() {
    let (module, trail) = compiled("atomise,cse");
    let told = account(&module, &trail, "M[2]");
    assert_eq!(
        story(&told),
        [
            "M[2] = %E + 2.0",
            "atomise [] M[2] = %E + 2.0",
            "atomise [] %M_2 = %E + 2.0",
            "cse [] M[2] = %D + 2.0",
            "cse [] %M_2 = %D + 2.0",
        ]
    );
}

#[test]
fn a_value_that_was_merged_away_is_found_and_led_on() {
    let (module, trail) = compiled("atomise,cse,dce");
    let told = account(&module, &trail, "E");
    let gone = told.gone.expect("D took its place");
    assert_eq!(
        (gone.pass.as_str(), gone.into.as_deref()),
        ("cse", Some("%D"))
    );
    assert!(told.now.is_none());
    let kept = account(&module, &trail, "%D");
    let merged = kept.entries.last().expect("it was merged into");
    assert_eq!(merged.changes[0].rules, ["equal to %E"]);
    let sources = merged.changes[0].merged.expect("only its places changed");
    assert_eq!(module.tables.sources.places(sources).len(), 2);
}

#[test]
fn a_wrong_name_gets_advice() {
    let (module, trail) = compiled("atomise,balance");
    let help = |asked: &str| {
        let error = find(&module, &trail, asked).expect_err("there is none");
        error.help
    };
    assert_eq!(help("%C2"), "did you mean '%C1'?");
    assert_eq!(help("M[3]"), "did you mean 'M[1]'?");
    assert_eq!(help("q[1]"), "'q' is an input and has no history");
    assert!(help("%whatever").starts_with("write a value as"));
}

#[test]
fn histories_name_the_passes_and_survive_the_text() {
    let (module, _) = compiled("atomise,cse,balance,dce");
    let text = print_module(&module);
    assert!(text.contains("history 1 = \"atomise\""), "{text}");
    assert!(text.contains(" = 1 \"balance\""), "{text}");
    assert!(text.contains(" = \"cse\" \"equal to %E\""), "{text}");
    let again = parse_module("arm.rvir", &text).expect("it reads back");
    assert!(again == module);
    assert_eq!(print_module(&again), text);
}

#[test]
fn histories_go_on_where_a_text_left_them() {
    let (whole, _) = compiled("atomise,balance,cse,dce");
    let (half, _) = compiled("atomise,balance");
    let (rest, trail) = compile(&print_module(&half), "cse,dce");
    assert!(rest == whole);
    let told = account(&rest, &trail, "%A");
    let [(name, steps)] = &told.earlier[..] else {
        panic!("one value has a history: {:?}", told.earlier);
    };
    let steps: Vec<&str> = steps.iter().map(|step| step.pass.as_str()).collect();
    assert_eq!(
        (name.as_str(), &steps[..]),
        ("%A", &["atomise", "balance"][..])
    );
}

#[test]
fn a_value_left_alone_has_no_history_and_nobody_asking_leaves_none() {
    let (module, _) = compiled("atomise,balance");
    let function = &module.functions[0];
    let histories = function.histories.as_ref().expect("they were asked for");
    let cosine = function
        .values()
        .find(|(_, node)| node.operation == robovec_ir::Operation::Cos);
    let (cosine, _) = cosine.expect("there is one");
    assert!(histories.chain(histories.values[cosine.index()]).is_empty());
    let mut plain = parse_module("arm.rvir", TEXT).expect("the text is sound");
    let machine = Machine::built_in("thesis").expect("it ships");
    let pipeline = REGISTRY
        .pipeline("atomise,balance")
        .expect("the pipeline is sound");
    let mut log = Vec::new();
    run(&mut plain, &pipeline, Config::new(&machine, &mut log)).expect("the passes run");
    assert!(plain.functions[0].histories.is_none());
}

#[test]
fn notes_of_a_pass_reach_the_story() {
    use robovec_analysis::class::NumericClass;
    use robovec_framework::pass::{Context, Gives, Pass, PassError, PassInfo};
    use robovec_framework::pipeline::{PassStep, Pipeline, PipelineStep};
    use robovec_ir::{Function, Level, Name, Operand, Operation};

    /// Turns `%D = q[4]*%C1` around and notes it.
    struct Turn;
    impl Pass for Turn {
        fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
            let base = context.tables.symbols.find("D").expect("it is in the text");
            let name = Name::plain(base);
            let found = function.values().find(|(_, node)| node.name == name);
            let (value, node) = found.expect("it is in the text");
            assert_eq!(node.operation, Operation::Mul);
            let [a, b, _] = node.operands;
            function.node_mut(value).operands = Operand::list([b, a]);
            context.note(name, "commute");
            Ok(())
        }
    }
    const INFO: PassInfo = PassInfo {
        name: "turn",
        documentation: "",
        options: &[],
        takes: &[Level::Atomic],
        gives: Gives::Same,
        class: NumericClass::Exact,
        requires: &[],
        sets: &[],
        destroys: &[],
        build: |_| Ok(Box::new(Turn)),
    };
    let mut module = parse_module("arm.rvir", TEXT).expect("the text is sound");
    let machine = Machine::built_in("thesis").expect("it ships");
    let mut pipeline: Pipeline = REGISTRY.pipeline("atomise").expect("the pipeline is sound");
    let span = 0..0;
    pipeline.steps.push(PipelineStep::Pass(PassStep {
        info: &INFO,
        options: Vec::new(),
        span,
    }));
    let mut trail = Trail::new();
    let mut log = Vec::new();
    let config = Config {
        histories: true,
        trail: Some(&mut trail),
        ..Config::new(&machine, &mut log)
    };
    run(&mut module, &pipeline, config).expect("the passes run");
    let told = account(&module, &trail, "%D");
    assert_eq!(
        story(&told).last().map(String::as_str),
        Some("turn [commute] %D = %C1*q[4]")
    );
    assert!(print_module(&module).contains(" = \"turn\" \"commute\""));
}
