//! Random rules over random programs: true ones never break a program, false
//! ones are refuted before they are used, and one that is used nevertheless is
//! detected and reduced to itself.

use crate::equations::{Contents, equations};
use crate::rewriting::{BELIEVE, instance, plain};
use crate::running::reduced;
use crate::statistics::{Run, Statistics};
use crate::term::Term;
use arbitrary::{Result, Unstructured};
use robovec_framework::manager::{self, Config, Executed, RunError};
use robovec_framework::pipeline::{PassStep, Pipeline, PipelineStep};
use robovec_framework::reduce::{Reduction, TrialSetting, WORK, reduce};
use robovec_framework::rewrite::lay_out;
use robovec_ir::evaluate::evaluate;
use robovec_ir::states::States;
use robovec_ir::{Input, Machine, Module, Operand, Output, Shape, SourceSet, print};
use robovec_num::field::{Field, PrimeField};
use robovec_passes::registry::REGISTRY;
use robovec_rules::check::{RuleVerdict, check};
use robovec_rules::{Rule, RuleSet};

/// Number of runs of [`false_rules_are_caught`], with their inputs.
pub static STATISTICS: Statistics = Statistics::new("false_rules_are_caught");

const CONTENTS: Contents = Contents {
    definitions: 8,
    divisions: false,
    hostile: false,
};

/// Number of trials of the rule check; the proof does not depend on it.
const TRIALS: usize = 20;

/// Makes some random rules, of which one may be false, and a random program in
/// which their left sides occur, and runs a random pipeline that trusts them.
///
/// # Panics
///
/// Panics when the rule check errs; when a pipeline with true rules breaks the
/// program; when a false rule changes the program and is not caught, or is not
/// reduced to a program of its left side and to the rewrite by it.
pub fn false_rules_are_caught(data: &[u8]) {
    // Bytes that run out make no case.
    let result = run(&mut Unstructured::new(data));
    STATISTICS.record(&result);
}

fn run(bytes: &mut Unstructured<'_>) -> Result<Run> {
    let count = bytes.int_in_range(1..=3)?;
    let planted = if bytes.arbitrary()? {
        Some(bytes.int_in_range(0..=count - 1)?)
    } else {
        None
    };
    let mut text = String::new();
    let mut falsehood = None;
    for number in 0..count {
        let (left, right) = sides(bytes, planted == Some(number))?;
        let is_false = differ(&left, &right);
        let name = if is_false { "false" } else { "true" };
        text += &format!("rule {name}-{number}: {left} => {right} class=real;\n");
        if is_false {
            falsehood = Some(format!("false-{number}"));
        }
    }
    let rules = RuleSet::parse(&text, "random.rules").expect("well formed");
    rules.rules.iter().for_each(judge);
    let seed = bytes.arbitrary()?;
    let module = program(bytes, &rules)?;
    let (pipeline, believes) = pipeline(bytes)?;
    let (result, after, executed) = execute(&module, &pipeline, &rules, seed);
    let mut outcome = Run {
        operations: module.functions[0].nodes().len() as u64,
        passes: executed.len() as u64,
        rewrites: executed.iter().map(|pass| pass.rewrites).sum(),
        ..Run::default()
    };
    match (result, falsehood) {
        (Ok(()), None) => {}
        (Ok(()), Some(_)) => {
            // The rule did not fit anywhere, or to no effect.
            assert!(
                same(&module, &after),
                "a false rule passed\n{text}{pipeline}"
            );
        }
        (Err(RunError::Check { .. }), Some(name)) => {
            outcome.planted = 1;
            outcome.caught = 1;
            let rule = rules.get(&name).expect("it was planted");
            let found = small(&module, &pipeline, &rules, seed);
            if believes {
                is_minimal(&found, rule);
            }
        }
        (Err(error), _) => panic!(
            "{pipeline}, seed {seed}: {error}\n{text}{}",
            reduced(&module, &pipeline, &ideal(), &rules, seed)
        ),
    }
    Ok(outcome)
}

/// Two sides, equal by construction or spoilt; an operation on the left, and
/// on the right no variable that the left has not.
fn sides(bytes: &mut Unstructured<'_>, spoil: bool) -> Result<(Term, Term)> {
    let depth = bytes.int_in_range(1..=3)?;
    let left = Term::random(bytes, depth)?;
    let steps = bytes.int_in_range(1..=12)?;
    let mut right = left.rewritten(bytes, steps)?;
    if right == left {
        // A rule must change something.
        right = right.twice_minus();
    }
    if !spoil {
        return Ok((left, right));
    }
    let spoilt = right.mutated(bytes)?;
    let (known, used) = (left.variables(), spoilt.variables());
    let bound = known.iter().zip(used).all(|(known, used)| *known || !used) && spoilt != left;
    Ok((left, if bound { spoilt } else { right }))
}

/// Tests whether small whole numbers distinguish the sides. These are
/// polynomials of low degree, and the arithmetic is exact.
fn differ(left: &Term, right: &Term) -> bool {
    let numbers = [-3.0, -1.0, 2.0, 5.0, 7.0];
    (0..numbers.len().pow(2)).any(|number| {
        let at = |step: usize| numbers[(number * step + number / 5) % numbers.len()];
        let values = [at(1), at(2) + 1.0, at(3) - 2.0, at(4) + 3.0];
        left.evaluate(values) != right.evaluate(values)
    })
}

/// The rule check must prove true rules and refute false ones.
fn judge(rule: &Rule) {
    let verdict = check(rule, TRIALS).verdict;
    let right = if rule.name.starts_with("true") {
        matches!(verdict, RuleVerdict::Proved(_))
    } else {
        matches!(verdict, RuleVerdict::False(_))
    };
    assert!(right, "{}: {verdict:?}\n{rule:?}", rule.name);
}

/// Random equations, and more in which the left sides of the rules occur.
fn program(bytes: &mut Unstructured<'_>, rules: &RuleSet) -> Result<Module> {
    let mut module = equations(bytes, CONTENTS)?;
    let tables = &mut module.tables;
    let function = &mut module.functions[0];
    let inputs = function.input_len() as u32;
    let values: Vec<Operand> = function
        .values()
        .filter(|(_, node)| !node.name.is_none())
        .map(|(value, _)| value.into())
        .collect();
    let output = function.add_output(
        tables.symbols.intern("w"),
        Shape::Vector(rules.rules.len() as u32),
    );
    for (number, rule) in (0..).zip(&rules.rules) {
        let mut bound = Vec::new();
        for _ in &rule.variables {
            bound.push(match bytes.arbitrary()? {
                true if !values.is_empty() => *bytes.choose(&values)?,
                _ => Input(bytes.int_in_range(0..=inputs - 1)?).into(),
            });
        }
        let operand = instance(&rule.left, &bound, function);
        if let Some(value) = operand.value() {
            function.node_mut(value).name = plain(&format!("W{number}"), tables);
        }
        function.assign(Output(output.offset + number), operand, SourceSet::EMPTY);
    }
    module.functions[0] = lay_out(&module.functions[0]);
    Ok(module)
}

/// A pipeline that uses the rules, and a flag: true when the trusting pass uses
/// them.
fn pipeline(bytes: &mut Unstructured<'_>) -> Result<(Pipeline, bool)> {
    let parse = |text: &str| REGISTRY.pipeline(text).expect("made of known passes").steps;
    let mut steps = parse("atomise");
    let believes = !bytes.ratio(1, 4)?;
    if believes {
        steps.push(PipelineStep::Pass(PassStep {
            info: &BELIEVE,
            options: Vec::new(),
            span: 0..0,
        }));
    } else {
        steps.extend(parse("eqsat{rounds=2}"));
    }
    let after = bytes.choose(&["fold,cse", "balance", "zero-removal,dce", "inline"])?;
    steps.extend(parse(after));
    let registry = &REGISTRY;
    Ok((Pipeline { steps, registry }, believes))
}

fn ideal() -> Machine {
    Machine::built_in("ideal").expect("it ships")
}

fn execute(
    module: &Module,
    pipeline: &Pipeline,
    rules: &RuleSet,
    seed: u64,
) -> (std::result::Result<(), RunError>, Module, Vec<Executed>) {
    let machine = ideal();
    let mut after = module.clone();
    let mut executed = Vec::new();
    let result = manager::run(
        &mut after,
        pipeline,
        Config {
            check_each: Some(2),
            rules: Some(rules),
            states: States::new(seed),
            executed: Some(&mut executed),
            ..Config::new(&machine, &mut std::io::sink())
        },
    );
    (result.map(|_| ()), after, executed)
}

/// Equal at a point of the field that no check has seen.
fn same(before: &Module, after: &Module) -> bool {
    let [field, _] = PrimeField::pair(0x5eed, false);
    let inputs = field.point(before.functions[0].input_len());
    let values = |module: &Module| evaluate(&module.functions[0], &field, &inputs);
    values(before) == values(after)
}

fn small(module: &Module, pipeline: &Pipeline, rules: &RuleSet, seed: u64) -> Reduction {
    let setting = TrialSetting {
        machine: &ideal(),
        rules,
        scene: None,
        target: None,
        points: 2,
        seed,
    };
    reduce(module, pipeline, setting, WORK).expect("it went wrong a moment ago")
}

/// Asserts that the small program is exactly the left side of the rule.
fn is_minimal(found: &Reduction, rule: &Rule) {
    let text = || format!("{rule:?}\n{found}{}", print::print_module(&found.program));
    let rewrite = found.small_rewrite.as_ref();
    assert_eq!(
        rewrite.map(|rewrite| &rewrite.rule),
        Some(&rule.name),
        "{}",
        text()
    );
    let size = found.program.functions[0].nodes().len();
    assert!(size <= rule.left.operations().count(), "{}", text());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn random_rules_are_judged_and_planted_ones_reduced() {
        cases::of_one_size(150, 4000, |bytes| {
            let result = run(bytes);
            STATISTICS.record(&result);
            result.map(|_| ())
        });
        eprintln!("{STATISTICS}");
        let (planted, caught) = STATISTICS.faults();
        assert!(STATISTICS.valid() > 120, "{STATISTICS}");
        assert!(planted > 25 && planted == caught, "{STATISTICS}");
    }
}
