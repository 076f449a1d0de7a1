#![allow(unreachable_pub, reason = "the macro declares public passes")]

use robovec_framework::declare_pass;
use robovec_framework::manager::*;
use robovec_framework::pass::{Context, Gives, Pass, PassError, PassInfo};
use robovec_framework::pipeline::{PassStep, Pipeline, PipelineStep};
use robovec_ir::states::States;
use robovec_ir::{Function, Machine, Module, Operation, parse};
use robovec_passes::registry::REGISTRY;

declare_pass! {
    /// Exchanges the operands of the last subtraction, which is wrong.
    pub struct Wrong("wrong") {}
    takes: [Atomic],
    gives: Gives::Same,
    class: Real,
}

impl Pass for Wrong {
    fn run(&self, function: &mut Function, _: &mut Context<'_>) -> Result<(), PassError> {
        let last = function
            .values()
            .rev()
            .find(|(_, node)| node.operation == Operation::Sub)
            .map(|(value, _)| value);
        if let Some(value) = last {
            function.node_mut(value).operands.swap(0, 1);
        }
        Ok(())
    }
}

declare_pass! {
    /// Uses a value before it is defined, which is not well formed.
    pub struct Malformed("malformed") {}
    takes: [Atomic],
    gives: Gives::Same,
    class: Exact,
}

impl Pass for Malformed {
    fn run(&self, function: &mut Function, _: &mut Context<'_>) -> Result<(), PassError> {
        let last = robovec_ir::Value(function.nodes().len() as u32 - 1);
        function.node_mut(robovec_ir::Value(0)).operands[0] = last.into();
        Ok(())
    }
}

declare_pass! {
    /// Needs times.
    pub struct Timely("timely") {}
    takes: [Atomic],
    gives: Gives::Same,
    class: Exact,
    requires: [Timed],
}

impl Pass for Timely {
    fn run(&self, _: &mut Function, _: &mut Context<'_>) -> Result<(), PassError> {
        Ok(())
    }
}

const TEXT: &str = "function f atomic {\n  in x\n  in y\n  out o\n\n  %a = x*y\n  %b = %a - y\n  \
                    %c = %b + %a\n\n  o = %c\n}\n";

fn step(info: &'static PassInfo) -> PipelineStep {
    PipelineStep::Pass(PassStep {
        info,
        options: Vec::new(),
        span: 0..0,
    })
}

fn run_steps(
    steps: Vec<PipelineStep>,
    check_each: Option<u32>,
) -> Result<(Module, RunOutcome), RunError> {
    let mut module = parse::parse_module("test", TEXT).expect("well formed");
    let machine = Machine::built_in("thesis").expect("it ships");
    let mut log = Vec::new();
    let config = Config {
        check_each,
        states: States::new(3),
        ..Config::new(&machine, &mut log)
    };
    let outcome = run(
        &mut module,
        &Pipeline {
            steps,
            registry: &REGISTRY,
        },
        config,
    )?;
    Ok((module, outcome))
}

static WRONG: PassInfo = Wrong::INFO;
static MALFORMED: PassInfo = Malformed::INFO;
static TIMELY: PassInfo = Timely::INFO;

#[test]
fn a_planted_wrong_rewrite_is_caught_and_named() {
    let cse = REGISTRY.find("cse").expect("registered");
    let error = run_steps(vec![step(cse), step(&WRONG), step(cse)], Some(2)).expect_err("wrong");
    match error {
        RunError::Check {
            pass,
            function,
            reason,
        } => {
            assert_eq!((pass.as_str(), function.as_str()), ("wrong", "f"));
            assert!(reason.contains('o'), "{reason}");
        }
        other => panic!("{other}"),
    }
}

#[test]
fn a_malformed_result_is_caught_by_the_verifier() {
    let error = run_steps(vec![step(&MALFORMED)], None).expect_err("malformed");
    assert!(matches!(error, RunError::Verify { .. }), "{error}");
}

#[test]
fn properties_are_asked_for_before_anything_runs() {
    let asap = REGISTRY.find("asap-alap").expect("registered");
    let dce = REGISTRY.find("dce").expect("registered");
    assert!(run_steps(vec![step(asap), step(&TIMELY)], None).is_ok());
    for steps in [
        vec![step(&TIMELY)],
        vec![step(asap), step(dce), step(&TIMELY)],
    ] {
        let error = run_steps(steps, None).expect_err("not timed");
        assert!(matches!(error, RunError::Plan(_)), "{error}");
        assert!(error.to_string().contains("timed"), "{error}");
    }
}

#[test]
fn groups_repeat_until_nothing_changes() {
    let pipeline = REGISTRY
        .pipeline("fixpoint{max=5}(fold,cse,dce)")
        .expect("well formed");
    let (_, outcome) = run_steps(pipeline.steps, Some(2)).expect("sound passes");
    assert_eq!(
        outcome.records.len(),
        3,
        "one round suffices when nothing changes"
    );
    assert!(outcome.records.iter().all(|record| !record.changed));
    assert!(outcome.records.iter().all(|record| record.check.is_some()));
}

#[test]
fn groups_end_without_records_too() {
    let pipeline = REGISTRY
        .pipeline("fixpoint{max=5}(fold,cse,dce)")
        .expect("well formed");
    let mut module = parse::parse_module("test", TEXT).expect("well formed");
    let machine = Machine::built_in("thesis").expect("it ships");
    let (mut executed, mut log) = (Vec::new(), Vec::new());
    let config = Config {
        records: false,
        executed: Some(&mut executed),
        ..Config::new(&machine, &mut log)
    };
    let outcome = run(&mut module, &pipeline, config).expect("sound passes");
    assert!(outcome.records.is_empty());
    assert_eq!(executed.len(), 3, "one round suffices");
}
