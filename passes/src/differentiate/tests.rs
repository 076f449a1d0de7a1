//! Cost of derivatives, and the verdict of the check on wrong ones.

use super::Differentiate;
use crate::registry::REGISTRY;
use robovec_framework::check::{FailureKind, check_derivative};
use robovec_framework::manager::{self, Config};
use robovec_framework::pass::Pass;
use robovec_ir::parse::parse_module;
use robovec_ir::states::States;
use robovec_ir::{Machine, Module, Operation};
use std::fmt::Write;

fn module(text: &str) -> Module {
    parse_module("f", text).expect("it is sound")
}

fn run(module: &Module, options: &str) -> Module {
    let mut module = module.clone();
    let text = format!("atomise,differentiate{{{options}}}");
    let pipeline = REGISTRY.pipeline(&text).expect("it is a pipeline");
    let machine = Machine::built_in("ideal").expect("it ships");
    let mut log = Vec::new();
    let config = Config {
        check_each: Some(8),
        ..Config::new(&machine, &mut log)
    };
    manager::run(&mut module, &pipeline, config).expect("it runs");
    module
}

fn size(module: &Module) -> usize {
    module.functions[0].nodes().len()
}

/// A function with one part that has many inputs and one output, and one with
/// one input and many outputs.
fn wide_and_tall(count: u32) -> Module {
    let mut text = format!(
        "function f equations {{\n  in x[1..{count}]\n  in y\n  out s\n  out F[1..{count}]\n"
    );
    let write = &mut text;
    let mut line = |line: String| writeln!(write, "  {line}").expect("strings take all text");
    line("%p1 = x[1]".to_owned());
    for at in 2..=count {
        line(format!("%p{at} = sin(%p{})*x[{at}]", at - 1));
    }
    line("%z1 = y*y".to_owned());
    for at in 2..=count {
        line(format!("%z{at} = sin(%z{})*y", at - 1));
    }
    line(format!("s = %p{count}"));
    for at in 1..=count {
        line(format!("F[{at}] = %z{at}*%z{at}"));
    }
    module(&(text + "}\n"))
}

#[test]
fn every_part_is_eliminated_in_its_cheapest_order() {
    let function = wide_and_tall(12);
    let [mixed, forward, reverse] =
        ["mixed", "forward", "reverse"].map(|mode| size(&run(&function, &format!("mode={mode}"))));
    assert!(
        mixed < forward && mixed < reverse,
        "{mixed} {forward} {reverse}"
    );
}

#[test]
fn a_gradient_costs_a_few_times_the_function() {
    let function = wide_and_tall(200);
    let own = size(&run(&function, "result=direction of=s by=y"));
    for (result, by) in [("gradient", "x+y"), ("direction", "x+y")] {
        let cost = size(&run(&function, &format!("result={result} by={by}")));
        // Griewank and Walther (2008), section 4.4: at most five times.
        assert!(cost <= 5 * own, "{result}: {cost} operations, not {own}");
    }
}

#[test]
fn the_element_that_is_wrong_is_named() {
    let function = module(
        "function f atomic {\n  in x[1..2]\n  out F[1..2]\n  %a = sin(x[1])\n  %b = %a*x[2]\n  \
         F[1] = %b\n  F[2] = x[1]\n}\n",
    );
    let mut wrong = run(&function, "");
    let derivative = &mut wrong.functions[0];
    let product = derivative.values().rev();
    let product = product
        .map(|(value, _)| value)
        .find(|&value| derivative.node(value).operation == Operation::Mul);
    let product = product.expect("cos(x[1])*x[2] is a product");
    derivative.node_mut(product).operation = Operation::Add;
    let views = [&function, &wrong].map(|module| module.tables.view(&module.functions[0]));
    let wanted = Differentiate::default().differentiation();
    let wanted = wanted.expect("it differentiates");
    let verdict = check_derivative(views[0], views[1], &wanted, &States::new(1), 2);
    let failure = verdict.failure.expect("a sum is no product");
    assert_eq!(failure.name, "F_x[1,1]");
    assert!(matches!(failure.kind, FailureKind::Derivative(_)));
    assert!(
        failure
            .to_string()
            .starts_with("F_x[1,1] is not the derivative: "),
        "{failure}"
    );
}
