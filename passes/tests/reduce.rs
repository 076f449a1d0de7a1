//! Planted faults are found and made small.
#![allow(unreachable_pub, reason = "the macro declares public passes")]

use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError, PassInfo};
use robovec_framework::pipeline::{PassStep, Pipeline, PipelineStep};
use robovec_framework::reduce::*;
use robovec_framework::rewrite::lay_out;
use robovec_ir::{Function, Level, Machine, Operation, Value, parse, print, verify};
use robovec_passes::registry::REGISTRY;
use robovec_rules::RuleSet;

/// True when an operation reads the result of such an operation.
fn reads(function: &Function, value: Value, operation: Operation) -> bool {
    let operands = function.node(value).operands().iter();
    operands
        .filter_map(|operand| operand.value())
        .any(|operand| function.node(operand).operation == operation)
}

declare_pass! {
    /// Exchanges the operands of subtractions of products, which is wrong.
    pub struct Exchange("exchange") {}
    takes: [Equations, Atomic],
    gives: Gives::Same,
    class: Real,
}

impl Pass for Exchange {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        for index in 0..function.nodes().len() as u32 {
            let value = Value(index);
            let node = *function.node(value);
            let sum = matches!(node.operation, Operation::Add | Operation::Sub);
            if !sum || !reads(function, value, Operation::Mul) {
                continue;
            }
            if context.allow_rewrite(node.name, "a-b = b-a") {
                function.node_mut(value).operands.swap(0, 1);
            }
        }
        if function.level == Level::Equations {
            // Inner nodes stand in the order of the text.
            *function = lay_out(function);
        }
        Ok(())
    }
}

declare_pass! {
    /// Cannot do products of products.
    pub struct Fragile("fragile") {
        /// Panic instead of giving up.
        pub panics: bool = false,
    }
    takes: [Atomic],
    gives: Gives::Same,
    class: Exact,
}

impl Pass for Fragile {
    fn run(&self, function: &mut Function, _: &mut Context<'_>) -> Result<(), PassError> {
        let square = |&(value, node): &(Value, &robovec_ir::Node)| {
            node.operation == Operation::Mul && reads(function, value, Operation::Mul)
        };
        let Some((value, _)) = function.values().find(square) else {
            return Ok(());
        };
        assert!(!self.panics, "a product of products, value {}", value.0);
        Err(PassError::new(format!(
            "'{}' is a product of products",
            value.0
        )))
    }
}

declare_pass! {
    /// Forgets the name of the last root.
    pub struct Unname("unname") {}
    takes: [Atomic],
    gives: Gives::Same,
    class: Exact,
}

impl Pass for Unname {
    fn run(&self, function: &mut Function, _: &mut Context<'_>) -> Result<(), PassError> {
        let root = |&(_, node): &(Value, &robovec_ir::Node)| node.operation == Operation::Sqrt;
        let found = function.values().rev().find(root).map(|(value, _)| value);
        if let Some(value) = found {
            function.node_mut(value).name = robovec_ir::Name::NONE;
        }
        Ok(())
    }
}

static EXCHANGE: PassInfo = Exchange::INFO;
static FRAGILE: PassInfo = Fragile::INFO;
static UNNAME: PassInfo = Unname::INFO;

const TEXT: &str = "function f equations {
  in q[1..3]
  in m[1..2]
  out M[1..2,1..2]
  out c

  %C1 = cos(q[1])
  %S1 = sin(q[1])
  %A = q[2]*m[1]+%C1*(%S1-q[3])
  %B = %A-%C1*%S1+m[2]
  %D = sqrt(%A*%A+%B*%B)

  M[1,1] = %A*%B*9.81
  M[1,2] = %A+%B
  M[2,2] = -%B*%S1
  c = %D*%B-%A*%C1
}
";

fn step(info: &'static PassInfo, options: &[(&str, &str)]) -> PipelineStep {
    PipelineStep::Pass(PassStep {
        info,
        options: options
            .iter()
            .map(|(name, value)| ((*name).to_owned(), (*value).to_owned()))
            .collect(),
        span: 0..0,
    })
}

fn reduced(steps: &[PipelineStep]) -> Option<Reduction> {
    let module = parse::parse_module("test", TEXT).expect("well formed");
    let machine = Machine::built_in("thesis").expect("it ships");
    let setting = TrialSetting {
        machine: &machine,
        rules: &RuleSet::default(),
        scene: None,
        target: None,
        points: 2,
        seed: 3,
    };
    let pipeline = Pipeline {
        steps: steps.to_vec(),
        registry: &REGISTRY,
    };
    reduce(&module, &pipeline, setting, WORK)
}

fn registered(name: &str) -> PipelineStep {
    step(REGISTRY.find(name).expect("registered"), &[])
}

fn text(reduction: &Reduction) -> String {
    print::print_module(&reduction.program)
}

#[test]
fn a_wrong_rewrite_is_reduced_to_itself() {
    let steps = [
        registered("atomise"),
        registered("cse"),
        step(&EXCHANGE, &[]),
        registered("dce"),
    ];
    let found = reduced(&steps).expect("it is wrong");
    assert_eq!(
        (found.ordinal, found.problem.kind),
        (3, ProblemKind::Changed)
    );
    let rewrite = found.rewrite.as_ref().expect("the pass asks");
    // The first sum of products is an addition.
    assert_eq!((rewrite.number, rewrite.name.as_str()), (2, "%B.2"));
    assert_eq!(rewrite.rule, "a-b = b-a");
    let function = &found.program.functions[0];
    let operations: Vec<Operation> = function.nodes().iter().map(|n| n.operation).collect();
    assert_eq!(
        operations,
        [Operation::Mul, Operation::Sub],
        "{}",
        text(&found)
    );
    assert_eq!(function.assignments.len(), 1);
    assert_eq!(
        found.small_rewrite.as_ref().map(|r| (r.number, r.of)),
        Some((1, 1))
    );
    let difference = found.difference.as_deref().expect("both are well formed");
    assert_eq!(
        difference
            .lines()
            .filter(|l| l.starts_with(['-', '+']))
            .count(),
        2
    );
    let witness = found
        .witness
        .as_ref()
        .expect("small numbers distinguish them");
    assert!((witness.before + witness.after).abs() < 1e-12, "{witness}");
    assert!(found.to_string().contains("a-b = b-a"));
}

#[test]
fn equations_are_reduced_as_equations() {
    let found = reduced(&[step(&EXCHANGE, &[])]).expect("it is wrong");
    let function = &found.program.functions[0];
    assert_eq!(function.level, Level::Equations);
    assert_eq!(function.nodes().len(), 2, "{}", text(&found));
    let view = found.program.tables.view(function);
    assert_eq!(verify::verify(view), []);
}

#[test]
fn errors_and_panics_are_reduced() {
    for panics in ["false", "true"] {
        let steps = [registered("atomise"), step(&FRAGILE, &[("panics", panics)])];
        let found = reduced(&steps).expect("it goes wrong");
        let kind = match panics {
            "true" => ProblemKind::Panicked,
            _ => ProblemKind::Refused,
        };
        assert_eq!(found.problem.kind, kind);
        assert_eq!(found.rewrite, None);
        let operations = found.program.functions[0].nodes().iter();
        let operations: Vec<Operation> = operations.map(|n| n.operation).collect();
        assert_eq!(operations, [Operation::Mul, Operation::Mul]);
    }
}

#[test]
fn malformed_results_are_reduced() {
    let found = reduced(&[registered("atomise"), step(&UNNAME, &[])]).expect("malformed");
    assert_eq!(found.problem.kind, ProblemKind::Malformed);
    assert_eq!(
        found.program.functions[0].nodes().len(),
        1,
        "{}",
        text(&found)
    );
}

#[test]
fn what_is_right_is_not_reduced() {
    let names = ["atomise", "cse", "balance", "dce"];
    assert!(reduced(&names.map(registered)).is_none());
}
