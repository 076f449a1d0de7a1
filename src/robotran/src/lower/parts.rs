//! Functions with loops or conditions: the reduced accelerations of a model
//! with closed loops, whose Newton iteration closes the loops at each call.
//!
//! Only straight-line code can be compiled, so the function is cut at every
//! loop and condition. Each part becomes a function; a scalar that one part
//! defines and another reads leaves the first as an output and enters the
//! second as an input. The caller keeps the loop.

use super::emit::{CrossingScalars, FunctionSignature, SymbolSet};
use super::{ERROR_LIMIT, Lowering, StatementBlock, scan};
use crate::storage::Storage;
use crate::structure::{FunctionBlock, Region, StatementRun};
use crate::syntax::{LeafKind, StatementKind, SyntaxLeaf};
use crate::token::SourceSpan;
use robovec_ir::Symbol;
use robovec_ir::diagnostic::{Diagnostic, Label};

impl Lowering<'_, '_> {
    /// Lowers the parts; returns which arrays they write.
    pub(super) fn parts(
        &mut self,
        block: &FunctionBlock,
        storage: &Storage,
        plain: &StatementBlock<'_>,
        signature: &FunctionSignature,
    ) -> Vec<bool> {
        let counters = &signature.counters;
        let live: Vec<&StatementRun> = block
            .runs
            .iter()
            .filter(|run| run.region != Region::Dead && self.computes(run, counters))
            .collect();
        let crossing = self.crossing(&live, &conditions(block), counters);
        let mut written = vec![false; storage.arrays.len()];
        if !self.afford(live.len(), 0, storage, block) {
            return written;
        }
        for (index, run) in live.iter().enumerate() {
            let number = index + 1;
            let name = format!("{}_part_{number}", plain.name);
            let mut metadata = plain.metadata.clone();
            metadata.push(("part".to_owned(), format!("{number} of {}", live.len())));
            if let Region::Control(span) = run.region {
                metadata.push(("control".to_owned(), self.one_line(span)));
            }
            self.warn(run, &name);
            let part = StatementBlock {
                name,
                runs: vec![run.statements.clone()],
                metadata,
                crossing: Some(&crossing[index]),
            };
            let scan = scan::scan(&self.syntax, storage, &part.runs, true);
            assert_eq!(
                scan.written.len(),
                written.len(),
                "every part is scanned with the same arrays"
            );
            for (all, one) in written.iter_mut().zip(&scan.written) {
                *all |= one;
            }
            self.emit(&part, storage, scan, signature);
            if self.errors.len() >= ERROR_LIMIT {
                break;
            }
        }
        written
    }

    /// True for a run that contains an equation or a call.
    fn computes(&self, run: &StatementRun, counters: &SymbolSet) -> bool {
        run.statements.clone().any(|index| match self.syntax.statements[index].kind {
            StatementKind::Equation { target, .. } => {
                !matches!(target.kind(), LeafKind::Scalar(name) if counters.contains(&name.symbol()))
            }
            StatementKind::Call(_) => true,
            _ => false,
        })
    }

    fn one_line(&self, span: SourceSpan) -> String {
        self.text[span.range()]
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ")
    }

    fn warn(&mut self, run: &StatementRun, name: &str) {
        let Region::Control(span) = run.region else {
            return;
        };
        self.warnings.push(
            Diagnostic::warning()
                .with_message("a loop or condition is not compiled, only its contents")
                .with_labels(vec![
                    Label::primary(0, span.range())
                        .with_message(format!("its equations are the function `{name}`")),
                ])
                .with_note("the program that calls the parts must make the decision of this line; counters are left out"),
        );
    }

    /// Values that each part takes from the others and passes to them.
    fn crossing(
        &self,
        runs: &[&StatementRun],
        conditions: &[SourceSpan],
        counters: &SymbolSet,
    ) -> Vec<CrossingScalars> {
        let uses: Vec<(SymbolSet, SymbolSet)> =
            runs.iter().map(|run| self.uses(run, counters)).collect();
        let defined_somewhere: SymbolSet = uses
            .iter()
            .flat_map(|(_, defined)| defined.iter().copied())
            .collect();
        let mut wanted: SymbolSet = uses
            .iter()
            .flat_map(|(read, _)| read.iter().copied())
            .collect();
        for condition in conditions {
            let text = &self.text[condition.range()];
            let words = text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
            wanted.extend(words.filter_map(|word| self.module.tables.symbols.find(word)));
        }
        uses.into_iter()
            .map(|(read, defined)| CrossingScalars {
                inputs: &read & &defined_somewhere,
                outputs: &defined & &wanted,
            })
            .collect()
    }

    /// The scalars a run reads before it defines them, and those it defines.
    fn uses(&self, run: &StatementRun, counters: &SymbolSet) -> (SymbolSet, SymbolSet) {
        let mut read = SymbolSet::default();
        let mut defined = SymbolSet::default();
        let mut visit = |leaf: &SyntaxLeaf, defined: &SymbolSet| {
            if *leaf != SyntaxLeaf::NONE
                && let LeafKind::Scalar(name) = leaf.kind()
                && !defined.contains(&name.symbol())
            {
                read.insert(name.symbol());
            }
        };
        let define = |target: SyntaxLeaf, defined: &mut SymbolSet| {
            let symbol: Option<Symbol> = match target.kind() {
                LeafKind::Scalar(name) => Some(name.symbol()),
                _ => None,
            };
            defined.extend(symbol.filter(|symbol| !counters.contains(symbol)));
        };
        for index in run.statements.clone() {
            match self.syntax.statements[index].kind {
                StatementKind::Equation {
                    target,
                    root,
                    first,
                    end,
                } => {
                    let nodes = &self.syntax.nodes[first as usize..end as usize];
                    nodes
                        .iter()
                        .flat_map(|node| node.operands())
                        .chain([&root])
                        .for_each(|leaf| visit(leaf, &defined));
                    define(target, &mut defined);
                }
                StatementKind::Call(call) => {
                    let call = self.syntax.calls[call as usize];
                    let (first, last) = call.arguments;
                    self.syntax.arguments[first as usize..last as usize]
                        .iter()
                        .for_each(|argument| visit(&argument.leaf, &defined));
                    if let Some(target) = call.target {
                        define(target, &mut defined);
                    }
                }
                _ => {}
            }
        }
        (read, defined)
    }
}

/// The heads of all loops and conditions.
fn conditions(block: &FunctionBlock) -> Vec<SourceSpan> {
    let spans = block.runs.iter().filter_map(|run| match run.region {
        Region::Control(span) => Some(span),
        Region::Common | Region::Cases(_) | Region::Others(_) | Region::Dead => None,
    });
    spans.collect()
}
