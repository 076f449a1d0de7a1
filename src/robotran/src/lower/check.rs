//! Names that are read before, or without, a definition.

use super::StatementBlock;
use crate::explain::refusal;
use crate::storage::Storage;
use crate::syntax::{LeafKind, StatementKind, SyntaxTree};
use crate::token::{RobotranName, SourceSpan};
use hashbrown::HashMap;
use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, NodeIndex};
use robovec_ir::diagnostic::{Diagnostic, Label, did_you_mean};
use robovec_ir::{Symbol, Symbols};
use rustc_hash::FxBuildHasher;

/// The scalars a function defines, with their statements, in order.
struct Definitions {
    order: Vec<(Symbol, usize)>,
    statements: HashMap<Symbol, usize, FxBuildHasher>,
}

/// Explains every name that had no definition where it was read.
pub(super) fn explain_missing(
    missing: &[(Symbol, usize)],
    syntax: &SyntaxTree,
    storage: &Storage,
    symbols: &Symbols,
    block: &StatementBlock<'_>,
    text: &str,
) -> Vec<Diagnostic> {
    if missing.is_empty() {
        return Vec::new();
    }
    let definitions = definitions(syntax, block);
    let cycles = if missing
        .iter()
        .any(|(symbol, _)| definitions.statements.contains_key(symbol))
    {
        cycles(syntax, &definitions)
    } else {
        HashMap::default()
    };
    let mut reported: Vec<usize> = Vec::new();
    let mut diagnostics = Vec::new();
    for &(symbol, statement) in missing.iter().take(crate::ERROR_LIMIT) {
        let name = symbols.text(symbol);
        let span = occurrence(text, syntax.statements[statement].span, name);
        if storage.find(RobotranName::local(symbol)).is_some() {
            diagnostics.push(refusal(
                &format!("the array `{name}` is read without an index"),
                span,
                "which element is meant?",
                "write the index",
            ));
            continue;
        }
        let Some(&defined) = definitions.statements.get(&symbol) else {
            diagnostics.push(undefined(name, span, &definitions, symbols));
            continue;
        };
        match cycles.get(&symbol) {
            Some((number, members)) => {
                if !reported.contains(number) {
                    reported.push(*number);
                    diagnostics.push(cycle(members, &definitions, syntax, symbols));
                }
            }
            None => diagnostics.push(too_early(name, span, syntax.statements[defined].span)),
        }
    }
    diagnostics
}

fn definitions(syntax: &SyntaxTree, block: &StatementBlock<'_>) -> Definitions {
    let mut definitions = Definitions {
        order: Vec::new(),
        statements: HashMap::default(),
    };
    for index in block.runs.iter().cloned().flatten() {
        if let StatementKind::Equation { target, .. } = syntax.statements[index].kind
            && let LeafKind::Scalar(name) = target.kind()
        {
            definitions.order.push((name.symbol(), index));
            definitions.statements.entry(name.symbol()).or_insert(index);
        }
    }
    definitions
}

type DefinitionCycles = HashMap<Symbol, (usize, Vec<Symbol>), FxBuildHasher>;

/// The groups of equations that need one another.
fn cycles(syntax: &SyntaxTree, definitions: &Definitions) -> DefinitionCycles {
    let mut graph: DiGraph<Symbol, ()> = DiGraph::new();
    let mut nodes: HashMap<Symbol, NodeIndex, FxBuildHasher> = HashMap::default();
    for &(symbol, _) in &definitions.order {
        nodes
            .entry(symbol)
            .or_insert_with(|| graph.add_node(symbol));
    }
    for &(symbol, statement) in &definitions.order {
        let StatementKind::Equation {
            root, first, end, ..
        } = syntax.statements[statement].kind
        else {
            continue;
        };
        let run = &syntax.nodes[first as usize..end as usize];
        for leaf in run.iter().flat_map(|node| node.operands()).chain([&root]) {
            if let LeafKind::Scalar(name) = leaf.kind()
                && let Some(&read) = nodes.get(&name.symbol())
            {
                graph.add_edge(nodes[&symbol], read, ());
            }
        }
    }
    let mut cycles = DefinitionCycles::default();
    for (number, group) in kosaraju_scc(&graph).into_iter().enumerate() {
        let alone = group.len() == 1;
        if alone && !graph.contains_edge(group[0], group[0]) {
            continue;
        }
        let mut members: Vec<Symbol> = group.iter().map(|&node| graph[node]).collect();
        members.sort_by_key(|symbol| definitions.statements[symbol]);
        for &member in &members {
            let shown = members.iter().copied().take(8).collect();
            cycles.insert(member, (number, shown));
        }
    }
    cycles
}

fn cycle(
    members: &[Symbol],
    definitions: &Definitions,
    syntax: &SyntaxTree,
    symbols: &Symbols,
) -> Diagnostic {
    let labels = members.iter().enumerate().map(|(index, symbol)| {
        let span = syntax.statements[definitions.statements[symbol]].span;
        let label = match index {
            0 => Label::primary(0, span.range()),
            _ => Label::secondary(0, span.range()),
        };
        label.with_message(format!("`{}` needs the others", symbols.text(*symbol)))
    });
    let message = match members {
        [only] => format!("`{}` needs its own value", symbols.text(*only)),
        _ => "these equations depend on one another".to_owned(),
    };
    Diagnostic::error()
        .with_message(message)
        .with_labels(labels.collect())
        .with_note("there is no order in which they could be evaluated; look for a misspelt name")
}

fn too_early(name: &str, used: SourceSpan, defined: SourceSpan) -> Diagnostic {
    Diagnostic::error()
        .with_message(format!("`{name}` is read before it is defined"))
        .with_labels(vec![
            Label::primary(0, used.range()).with_message("read here"),
            Label::secondary(0, defined.range()).with_message("defined here"),
        ])
        .with_note("move its equation before the first that reads it")
}

fn undefined(
    name: &str,
    span: SourceSpan,
    definitions: &Definitions,
    symbols: &Symbols,
) -> Diagnostic {
    if ["nan", "inf", "infinity", "pi"].contains(&name.to_ascii_lowercase().as_str()) {
        return refusal(
            &format!("`{name}` is not understood"),
            span,
            "neither a name of the file nor a number",
            "write numbers as decimals; what is not finite cannot be compiled",
        );
    }
    let candidates = definitions
        .order
        .iter()
        .map(|&(symbol, _)| symbols.text(symbol));
    let note = match did_you_mean(name, candidates) {
        Some(near) => format!("did you mean `{near}`?"),
        None => "no equation of this function defines it; define it or correct the name".to_owned(),
    };
    refusal(
        &format!("`{name}` is not defined"),
        span,
        "not defined",
        &note,
    )
}

/// Place of a name in a statement, not on its left, or the statement's.
fn occurrence(text: &str, span: SourceSpan, name: &str) -> SourceSpan {
    let statement = &text[span.range()];
    let word = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
    let bytes = statement.as_bytes();
    let from = statement.find('=').unwrap_or(0);
    let mut found = statement.match_indices(name).filter(|&(at, _)| {
        let after = at + name.len();
        (at == 0 || !word(bytes[at - 1])) && (after >= bytes.len() || !word(bytes[after]))
    });
    let hit = found.find(|&(at, _)| at > from);
    match hit {
        Some((at, _)) => {
            let start = span.start as usize + at;
            SourceSpan::new(start, start + name.len())
        }
        None => span,
    }
}
