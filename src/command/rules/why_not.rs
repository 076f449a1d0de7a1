//! `robovec rules why-not`.

use super::super::CommandFailure;
use super::super::flags::whole;
use super::read;
use clap::Args;
use robovec_analysis::class::NumericClass;
use robovec_ir::diagnostic::counted;
use robovec_passes::eqsat::derive::{Derivation, DerivationEffort, DerivationStep, derive};
use robovec_rules::check::{self, RuleVerdict};
use robovec_rules::{Pattern, Rule, RuleSet};
use std::fmt::Write;

/// Arguments of `rules why-not`.
#[derive(Args, Debug)]
pub(super) struct WhyNotArguments {
    /// The term to start from: `a*x + b*x`
    #[arg(allow_hyphen_values = true)]
    left: String,
    /// The term to reach: `(a + b)*x`
    #[arg(allow_hyphen_values = true)]
    right: String,
    /// Additional rules: a .rules file
    #[arg(long, value_name = "FILE")]
    rules: Vec<String>,
    /// Only the rules named by --rules
    #[arg(long, requires = "rules")]
    only: bool,
    /// Also use the rules for sine and cosine
    #[arg(long)]
    trig: bool,
    /// Maximum number of nodes in the graph of equal terms
    #[arg(long, value_name = "N", default_value_t = 20_000,
          add = whole(10, 2_000_000, "the graph keeps them all"))]
    nodes: u32,
    /// Maximum number of rounds in which all rules are applied
    #[arg(long, value_name = "N", default_value_t = 10,
          add = whole(1, 100, "every round matches each rule against the whole graph"))]
    iterations: u32,
}

pub(super) fn run(arguments: &WhyNotArguments) -> Result<String, CommandFailure> {
    let rules = read::sound(&arguments.rules, !arguments.only)?;
    let class = if arguments.trig {
        NumericClass::RealTrig
    } else {
        NumericClass::Real
    };
    let text = format!(
        "rule question: {} => {} class={};",
        arguments.left, arguments.right, class
    );
    let question = RuleSet::parse(&text, "<question>")?;
    let Some(rule) = question.rules.first() else {
        return Err(CommandFailure::plain("there is no question".to_owned()));
    };
    let finding = check::check(rule, check::TRIALS);
    match &finding.verdict {
        RuleVerdict::False(example) => {
            return Ok(format!(
                "No rules lead there, since the terms are not equal: {example}.\n"
            ));
        }
        RuleVerdict::Proved(proof) if proof.circle && !arguments.trig => {
            return Ok(
                "The terms are equal only where sine and cosine lie on the circle: \
                       ask with --trig.\n"
                    .to_owned(),
            );
        }
        RuleVerdict::Proved(_) | RuleVerdict::Unproved(_) => {}
    }
    let effort = DerivationEffort {
        nodes: arguments.nodes as usize,
        iterations: arguments.iterations,
    };
    let found = derive(&rule.left, &rule.right, &rules, class, effort);
    Ok(answer(rule, &found, finding.is_sound(), effort))
}

fn answer(rule: &Rule, found: &Derivation, is_proved: bool, effort: DerivationEffort) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    match found {
        Derivation::Found(steps) => {
            let count = counted(steps.len(), "step");
            let _ = writeln!(text, "The rules lead there in {count}:\n");
            text.push_str(&listing(rule, steps));
        }
        Derivation::Nearest {
            term,
            steps,
            complete,
            nodes,
        } => {
            let equal = if is_proved {
                "The terms are equal"
            } else {
                "No counterexample to the equality of the terms was found"
            };
            let reason = if *complete {
                format!(
                    "{equal}, but no rule leads there: all of {} were tried.",
                    counted(*nodes, "term")
                )
            } else {
                format!(
                    "Not reached within {} and {}; --nodes and --iterations allow for more.",
                    counted(effort.nodes, "node"),
                    counted(effort.iterations, "round")
                )
            };
            let nearest = term.to_text(&rule.variables);
            let _ = writeln!(text, "{reason}\nThe nearest that was reached: {nearest}\n");
            text.push_str(&listing(rule, steps));
            text.push_str(&closing(rule, term));
        }
    }
    text
}

/// The missing rule, from the nearest term to the wanted one, with its class.
fn closing(question: &Rule, nearest: &Pattern) -> String {
    let rule = Rule {
        left: nearest.clone(),
        ..question.clone()
    };
    let finding = check::check(&rule, check::TRIALS);
    let doubt = if finding.is_sound() {
        ""
    } else {
        ", which is not proved"
    };
    format!(
        "\nA rule that closes the gap{doubt}:\n  rule new: {} => {}  class={};\n",
        rule.left.to_text(&rule.variables),
        rule.right.to_text(&rule.variables),
        finding.class
    )
}

/// The steps, aligned.
pub(super) fn listing(rule: &Rule, steps: &[DerivationStep]) -> String {
    let name = |step: &DerivationStep| {
        if step.backwards {
            format!("{} backwards", step.rule)
        } else {
            step.rule.clone()
        }
    };
    let width = steps
        .iter()
        .map(|step| name(step).len())
        .fold(0, usize::max);
    let mut text = format!("  {:width$}  {}\n", "", rule.left.to_text(&rule.variables));
    for step in steps {
        let term = step.term.to_text(&rule.variables);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {:width$}  {term}", name(step));
    }
    text
}
