//! `robovec rules why`.

use super::super::flags::whole;
use super::super::{CommandFailure, input};
use super::{read, why_not};
use clap::Args;
use hashbrown::HashMap;
use robovec_analysis::class::NumericClass;
use robovec_framework::manager::{self, Config};
use robovec_framework::pipeline::Pipeline;
use robovec_ir::{Function, Module, Name, Operand, OperandKind, Tables, Value, View, print};
use robovec_passes::eqsat::derive::{Derivation, DerivationEffort, derive};
use robovec_rules::{Pattern, PatternNode, Rule, RulePlaces, RuleSet};
use rustc_hash::FxBuildHasher;
use std::fmt::Write;
use std::path::PathBuf;

/// Arguments of `rules why`.
#[derive(Args, Debug)]
pub(super) struct WhyArguments {
    /// The value, as in the text after the passes: `OM16.2`
    value: String,
    /// Equations or a model (.mbs, .urdf, .xml)
    input: PathBuf,
    /// Additional rules: a .rules file
    #[arg(long, value_name = "FILE")]
    rules: Vec<String>,
    /// Passes to run before the rules are used
    #[arg(long, default_value = "atomise,zero-removal,balance,cse,dce")]
    before: String,
    /// Passes that use the rules
    #[arg(long, default_value = "eqsat")]
    passes: String,
    /// Machine whose cycles count: a name or a .toml file
    #[arg(long, default_value = "thesis")]
    machine: String,
    /// Maximum number of nodes in the graph of equal terms
    #[arg(long, value_name = "N", default_value_t = 20_000,
          add = whole(10, 2_000_000, "the graph keeps them all"))]
    nodes: u32,
}

/// The largest term that is explained, in nodes.
const LARGEST: usize = 60;

pub(super) fn run(arguments: &WhyArguments) -> Result<String, CommandFailure> {
    let machine = input::machine(&arguments.machine)?;
    let rules = read::sound(&arguments.rules, true)?;
    let read = input::equations_or_model(&arguments.input, None, None)?;
    let mut module = input::without_ranges(read, "rules why")?;
    let compile = |module: &mut Module, passes: &Pipeline| {
        let mut log = Vec::new();
        let config = Config {
            rules: Some(&rules),
            ..Config::new(&machine, &mut log)
        };
        let done = manager::run(module, passes, config);
        done.map_err(|error| CommandFailure::plain(error.to_string()))
    };
    compile(&mut module, &input::passes(&arguments.before)?)?;
    let before = module.clone();
    compile(&mut module, &input::passes(&arguments.passes)?)?;
    let wanted = arguments.value.trim_start_matches('%');
    for (old, new) in before.functions.iter().zip(&module.functions) {
        let found = new
            .values()
            .find(|(_, node)| text_of(&module.tables, node.name) == wanted);
        if let Some((value, _)) = found {
            return Ok(explain(&module.tables, old, new, value, &rules, arguments));
        }
    }
    Err(CommandFailure::advised(
        format!("there is no value '{wanted}' after the passes"),
        vec![format!(
            "robovec-opt -passes={},{} prints them",
            arguments.before, arguments.passes
        )],
    ))
}

fn text_of(tables: &Tables, name: Name) -> String {
    let base = tables.symbols.text(name.base);
    match name.suffix {
        0 => base.to_owned(),
        suffix => format!("{base}.{suffix}"),
    }
}

/// Terms of two functions over common variables.
#[derive(Default)]
struct Variables {
    numbers: HashMap<String, u32, FxBuildHasher>,
    names: Vec<String>,
}

impl Variables {
    fn number(&mut self, name: String) -> u32 {
        let next = self.names.len() as u32;
        *self.numbers.entry(name).or_insert_with_key(|name| {
            self.names.push(name.clone());
            next
        })
    }
}

/// The term of a value down to `leaf` nodes; `None` beyond the limit.
fn term(
    tables: &Tables,
    function: &Function,
    value: Value,
    variables: &mut Variables,
    leaf: &mut dyn FnMut(Value, &str) -> bool,
) -> Option<Pattern> {
    let mut pattern = Pattern::default();
    let mut places: HashMap<Operand, u32, FxBuildHasher> = HashMap::default();
    let mut open: Vec<(Operand, bool)> = vec![(value.into(), false)];
    while let Some((operand, ready)) = open.pop() {
        if places.contains_key(&operand) {
            continue;
        }
        if pattern.nodes.len() > LARGEST || open.len() > 4 * LARGEST {
            return None;
        }
        let place = match operand.kind() {
            OperandKind::Constant(constant) => {
                pattern.push(PatternNode::Number(function.constant_number(constant)))
            }
            OperandKind::Value(inner) => {
                let node = function.node(inner);
                let name = text_of(tables, node.name);
                if inner != value && leaf(inner, &name) {
                    pattern.push(PatternNode::Variable(variables.number(name)))
                } else if ready {
                    let operands: Vec<u32> = node
                        .operands()
                        .iter()
                        .map(|operand| places[operand])
                        .collect();
                    // A third operand belongs to fused operations, which
                    // rules do not speak of.
                    if operands.len() > 2 {
                        return None;
                    }
                    pattern.operation(node.operation, &operands)
                } else {
                    open.push((operand, true));
                    open.extend(
                        node.operands()
                            .iter()
                            .rev()
                            .map(|&operand| (operand, false)),
                    );
                    continue;
                }
            }
            OperandKind::Input(_) | OperandKind::None => {
                let name = print::print_operand(View { tables, function }, operand);
                pattern.push(PatternNode::Variable(variables.number(name)))
            }
        };
        places.insert(operand, place);
    }
    Some(pattern)
}

fn explain(
    tables: &Tables,
    old: &Function,
    new: &Function,
    value: Value,
    rules: &RuleSet,
    arguments: &WhyArguments,
) -> String {
    let name = new.node(value).name;
    let places: HashMap<Name, Value, FxBuildHasher> = old
        .values()
        .map(|(value, node)| (node.name, value))
        .collect();
    let Some(&origin) = places.get(&name) else {
        return format!(
            "{} is new: it has no name before these passes; ask why of the value that uses it.\n",
            arguments.value
        );
    };
    let mut variables = Variables::default();
    // New names are opened up; what had its name before is a variable.
    let after = term(tables, new, value, &mut variables, &mut |inner, _| {
        places.contains_key(&new.node(inner).name)
    });
    let known = variables.names.clone();
    let before = term(tables, old, origin, &mut variables, &mut |_, name| {
        known.iter().any(|known| known == name)
    });
    let (Some(before), Some(after)) = (before, after) else {
        return format!("the term of {} is too large to explain\n", arguments.value);
    };
    let rule = Rule {
        name: "question".to_owned(),
        group: String::new(),
        variables: variables.names,
        left: before,
        right: after,
        both_ways: false,
        conditions: Vec::new(),
        class: NumericClass::Real,
        reason: String::new(),
        places: RulePlaces::default(),
    };
    let effort = DerivationEffort {
        nodes: arguments.nodes as usize,
        iterations: 10,
    };
    let found = derive(&rule.left, &rule.right, rules, rule.class, effort);
    let left = rule.left.to_text(&rule.variables);
    let right = rule.right.to_text(&rule.variables);
    let mut text = String::new();
    // Writing to a string cannot fail.
    match found {
        _ if left == right => {
            let _ = writeln!(text, "{} was not changed: {left}", arguments.value);
        }
        Derivation::Found(steps) => {
            let _ = writeln!(text, "{}, step by step:\n", arguments.value);
            text.push_str(&why_not::listing(&rule, &steps));
        }
        Derivation::Nearest { steps, nodes, .. } => {
            let _ = writeln!(
                text,
                "{} was {left}\nand became {right}\n\nA derivation takes more than {nodes} nodes \
                 (--nodes); this is how near they lead:\n",
                arguments.value
            );
            text.push_str(&why_not::listing(&rule, &steps));
        }
    }
    text
}
