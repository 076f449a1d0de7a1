//! From statements to functions of the representation.

mod calls;
mod check;
mod emit;
mod names;
mod parts;
mod scan;

use self::emit::{
    CrossingScalars, EmittedFunction, FunctionEmitter, FunctionSignature, Shared, SymbolSet,
};
use self::scan::Scan;
use super::explain::refusal;
use super::header::Header;
use super::places::LineIndex;
use super::storage::{Storage, StorageBuilder};
use super::structure::{FunctionBlock, Region};
use super::syntax::{FunctionHeader, StatementKind, SyntaxTree};
use super::token::RobotranName;
use super::{ERROR_LIMIT, Language};
use robovec_cgen::kind::bare_name;
use robovec_ir::diagnostic::{Diagnostic, Label};
use robovec_ir::{Function, Level, Module, Operand, Symbol};
use std::ops::Range;

/// A file repeats the common part in each sensor case, and every function needs
/// tables of all names; more work than this is refused.
const LARGEST_REPETITION: u64 = 200_000_000;

/// Outputs without which a file means nothing.
const REQUIRED_OUTPUTS: [&str; 7] = ["M", "c", "Qq", "h", "Jac", "Jdqd", "qdd"];

/// Statements that become one function.
pub(super) struct StatementBlock<'a> {
    name: String,
    runs: Vec<Range<usize>>,
    metadata: Vec<(String, String)>,
    crossing: Option<&'a CrossingScalars>,
}

/// Lowers the functions of a file into a module.
pub(super) struct Lowering<'a, 't> {
    pub(super) syntax: SyntaxTree,
    pub(super) text: &'t str,
    pub(super) file_name: &'a str,
    pub(super) language: Language,
    pub(super) header: Header,
    pub(super) places: LineIndex<'t>,
    pub(super) module: Module,
    pub(super) errors: Vec<Diagnostic>,
    pub(super) warnings: Vec<Diagnostic>,
    /// The file holds a message instead of equations, once it was requested.
    pub(super) guard: Option<bool>,
    /// Cost of the functions so far; see [`LARGEST_REPETITION`].
    pub(super) work: u64,
}

impl Lowering<'_, '_> {
    pub(super) fn run(&mut self, blocks: &[FunctionBlock]) {
        for (index, block) in blocks.iter().enumerate() {
            let first = match block.head {
                Some(head) => self.syntax.heads[head as usize].first_element,
                None => 0,
            };
            let next = blocks.get(index + 1).and_then(|next| next.head);
            let end = match next {
                Some(head) => self.syntax.heads[head as usize].first_element as usize,
                None => self.syntax.elements.len(),
            };
            self.function(block, first as usize..end);
            if self.errors.len() >= ERROR_LIMIT {
                break;
            }
        }
        self.refuse_equal_names(blocks);
    }

    fn refuse_equal_names(&mut self, blocks: &[FunctionBlock]) {
        let mut known = hashbrown::HashSet::new();
        let functions = &self.module.functions;
        let twice = functions
            .iter()
            .find(|function| !known.insert(function.name.as_str()));
        if let (Some(function), Some(block)) = (twice, blocks.last()) {
            self.errors.push(refusal(
                &format!("there are two functions `{}`", function.name),
                block.span,
                "in this file",
                "rename or delete one of them, or renumber the cases",
            ));
        }
    }

    fn storage(&mut self, block: &FunctionBlock, elements: Range<usize>) -> Storage {
        let head = block
            .head
            .map(|head| self.syntax.heads[head as usize].clone());
        let mut builder = StorageBuilder {
            syntax: &mut self.syntax,
            symbols: &self.module.tables.symbols,
            language: self.language,
            head: head.as_ref(),
            statements: block.statements(),
            elements,
            joints: self.header.joints.unwrap_or(0),
            foreign: !self
                .header
                .generator
                .as_deref()
                .is_some_and(|name| name.starts_with("robovec ")),
            extents: &self.header.extents,
            errors: Vec::new(),
            warnings: Vec::new(),
        };
        let storage = builder.build();
        let (errors, warnings) = (builder.errors, builder.warnings);
        self.errors.extend(errors);
        self.warnings.extend(warnings);
        storage
    }

    fn function(&mut self, block: &FunctionBlock, elements: Range<usize>) {
        let before = self.errors.len();
        let storage = self.storage(block, elements);
        if self.errors.len() > before {
            return;
        }
        let name = self.function_name(block);
        let kind = self.kind(&name);
        let metadata = self.header.metadata(self.language, &kind);
        self.report_dead(block);
        let head = block
            .head
            .map(|head| self.syntax.heads[head as usize].clone());
        let signature = FunctionSignature {
            parameters: parameters(head.as_ref(), &storage),
            counters: self.counters(block),
            given: named(head.as_ref(), |head| &head.parameters).to_vec(),
            whole: named(head.as_ref(), |head| &head.whole).to_vec(),
        };
        let cases = block.cases();
        let plain = StatementBlock {
            name,
            runs: Vec::new(),
            metadata,
            crossing: None,
        };
        let written = if block.has_control() {
            self.parts(block, &storage, &plain, &signature)
        } else if !cases.is_empty() {
            self.cases(block, &storage, &plain, &signature, &cases)
        } else {
            if !self.afford(1, 0, &storage, block) {
                return;
            }
            let runs = live_runs(block, None);
            let whole = StatementBlock { runs, ..plain };
            let scan = scan::scan(&self.syntax, &storage, &whole.runs, false);
            let written = scan.written.clone();
            self.report_empty(&whole, block, &scan);
            self.emit(&whole, &storage, scan, &signature);
            written
        };
        self.check_outputs(
            block,
            &kind,
            &signature.parameters,
            head.as_ref(),
            &storage,
            &written,
        );
    }

    /// `mbs_dirdyna` is `dirdyna`; without a function the file's name counts.
    fn function_name(&self, block: &FunctionBlock) -> String {
        let name = match block.head {
            Some(head) => {
                let name = self.syntax.heads[head as usize].name;
                self.module.tables.symbols.text(name).to_owned()
            }
            None => file_stem(self.file_name)
                .chars()
                .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
                .collect(),
        };
        let bare = bare_name(&name);
        let starts_well = bare.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
        if starts_well {
            bare.to_owned()
        } else {
            format!("equations_{bare}")
        }
    }

    /// The kind of file: from its name (Python's `mbs_gensensor_*.py` holds a
    /// function `sensor`), else from the function's name.
    fn kind(&self, function: &str) -> String {
        let from_file = file_stem(self.file_name)
            .strip_prefix("mbs_")
            .and_then(|rest| {
                let mut kinds = KINDS.iter().filter(|kind| {
                    rest.strip_prefix(**kind)
                        .is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
                });
                kinds.next_back()
            });
        from_file.map_or_else(|| function.to_owned(), |&kind| kind.to_owned())
    }

    fn counters(&self, block: &FunctionBlock) -> SymbolSet {
        let runs = block.runs.iter().flat_map(|run| run.statements.clone());
        runs.filter_map(|index| match self.syntax.statements[index].kind {
            StatementKind::Counter(name) => Some(name.symbol()),
            _ => None,
        })
        .collect()
    }

    /// Warns of equations that control never reaches.
    fn report_dead(&mut self, block: &FunctionBlock) {
        let cases = block.cases();
        let unreached = |region: &Region| match region {
            Region::Dead => true,
            Region::Others(numbers) => cases.iter().all(|case| numbers.contains(case)),
            Region::Common | Region::Cases(_) | Region::Control(_) => false,
        };
        for run in block.runs.iter().filter(|run| unreached(&run.region)) {
            let mut equations = run.statements.clone().filter(|&index| {
                matches!(
                    self.syntax.statements[index].kind,
                    StatementKind::Equation { .. }
                )
            });
            if let Some(first) = equations.next() {
                let span = self.syntax.statements[first].span;
                self.warnings.push(
                    Diagnostic::warning()
                        .with_message(
                            "some equations are left out, because no sensor number reaches them",
                        )
                        .with_labels(vec![
                            Label::primary(0, span.range()).with_message("the first of them"),
                        ])
                        .with_note("they are in `default` or `else`, or after a `return`"),
                );
            }
        }
    }

    fn report_empty(&mut self, whole: &StatementBlock<'_>, block: &FunctionBlock, scan: &Scan) {
        if scan.equations > 1 {
            return;
        }
        let text = self.text;
        let guard = *self
            .guard
            .get_or_insert_with(|| text.contains("seem obsolete") || text.contains("flag_stop"));
        let lowered = scan.equations > usize::from(guard);
        if lowered {
            return;
        }
        let (message, note) = if guard {
            (
                format!("`{}` holds a message instead of equations", whole.name),
                "the generator writes it when the model has nothing for this function, or when the model was changed since; generate the files again if it should have equations",
            )
        } else {
            (
                format!("`{}` has no equations", whole.name),
                "the generator leaves such a stub when the model has nothing for this function",
            )
        };
        self.warnings.push(
            Diagnostic::warning()
                .with_message(message)
                .with_labels(vec![Label::primary(0, block.span.range())])
                .with_note(note),
        );
    }

    fn cases(
        &mut self,
        block: &FunctionBlock,
        storage: &Storage,
        plain: &StatementBlock<'_>,
        signature: &FunctionSignature,
        cases: &[u32],
    ) -> Vec<bool> {
        let common: usize = live_runs(block, None)
            .iter()
            .map(ExactSizeIterator::len)
            .sum();
        let each = common + block.runs.len();
        if !self.afford(cases.len(), each, storage, block) {
            return vec![true; storage.arrays.len()];
        }
        for case in cases {
            let mut metadata = plain.metadata.clone();
            metadata.push(("case".to_owned(), case.to_string()));
            let one = StatementBlock {
                name: format!("{}_{case}", plain.name),
                runs: live_runs(block, Some(*case)),
                metadata,
                crossing: None,
            };
            let scan = scan::scan(&self.syntax, storage, &one.runs, false);
            self.emit(&one, storage, scan, signature);
            if self.errors.len() >= ERROR_LIMIT {
                break;
            }
        }
        // A sensor need not fill every field.
        vec![true; storage.arrays.len()]
    }

    /// True when there is room for more functions, else an error.
    fn afford(
        &mut self,
        functions: usize,
        each: usize,
        storage: &Storage,
        block: &FunctionBlock,
    ) -> bool {
        let parameters = match block.head {
            Some(head) => {
                let head = &self.syntax.heads[head as usize];
                head.parameters.len() + head.outputs.len()
            }
            None => 0,
        };
        let each = each + parameters + storage.len + self.module.tables.symbols.len();
        self.work = self.work.saturating_add(each as u64 * functions as u64);
        let affordable = self.work <= LARGEST_REPETITION;
        if !affordable {
            self.errors.push(refusal(
                "too many functions, sensor cases or parts for the size of the file",
                block.span,
                "from here on",
                "split the file",
            ));
        }
        affordable
    }

    fn emit(
        &mut self,
        block: &StatementBlock<'_>,
        storage: &Storage,
        scan: Scan,
        signature: &FunctionSignature,
    ) {
        let mut function = Function::new(&block.name, Level::Equations);
        function.metadata = block.metadata.clone();
        let symbols = self.module.tables.symbols.len();
        let mut shared = Shared {
            syntax: &self.syntax,
            text: self.text,
            tables: &mut self.module.tables,
            places: &mut self.places,
            language: self.language,
            definitions: vec![Operand::NONE; symbols],
        };
        let mut emitter = FunctionEmitter::new(
            function,
            &mut shared,
            storage,
            &scan,
            signature,
            block.crossing,
        );
        emitter.run(&block.runs);
        let EmittedFunction {
            function,
            missing,
            errors,
            warnings,
        } = emitter.finish();
        self.errors.extend(scan.errors);
        self.errors.extend(errors);
        self.warnings.extend(warnings);
        self.errors.extend(check::explain_missing(
            &missing,
            &self.syntax,
            storage,
            &self.module.tables.symbols,
            block,
            self.text,
        ));
        self.module.functions.push(function);
    }

    /// Checks for an output that a function of this kind must have.
    fn check_outputs(
        &mut self,
        block: &FunctionBlock,
        kind: &str,
        parameters: &[RobotranName],
        head: Option<&FunctionHeader>,
        storage: &Storage,
        written: &[bool],
    ) {
        let mut runs = block.runs.iter().flat_map(|run| run.statements.clone());
        let has_equations = runs.any(|index| {
            matches!(self.syntax.statements[index].kind, StatementKind::Equation { first, end, .. } if first < end)
        });
        // robovec's own files keep Robotran's signature even where some outputs
        // are not set; their closing comment shows that nothing was lost.
        let ours = self.header.generator.as_deref();
        if !has_equations
            || ours.is_some_and(|name| name.starts_with("robovec "))
            || crate::is_for_processors(self.text)
        {
            return;
        }
        let declared = named(head, |head| &head.outputs);
        let symbols = &self.module.tables.symbols;
        let solved = matches!(kind, "accelred" | "dirdyna_odn");
        let mut expected: Vec<Symbol> = parameters
            .iter()
            .chain(declared)
            .map(|name| name.symbol())
            .filter(|&symbol| REQUIRED_OUTPUTS.contains(&symbols.text(symbol)))
            .collect();
        if solved {
            expected.extend(symbols.find("qdd"));
        }
        expected.sort_unstable();
        expected.dedup();
        for symbol in expected {
            let names = [RobotranName::local(symbol), RobotranName::of_data(symbol)];
            let found = names.iter().filter_map(|&name| storage.find(name));
            if found.into_iter().any(|array| written[array as usize]) {
                continue;
            }
            let text = self.module.tables.symbols.text(symbol);
            self.errors.push(refusal(
                &format!("the output `{text}` is never written"),
                block.span,
                "of this function",
                "the file is incomplete; generate or copy it again",
            ));
        }
    }
}

/// The kinds of files, a longer name after a shorter one it starts with.
const KINDS: [&str; 12] = [
    "dirdyna",
    "dirdyna_odn",
    "invdyna",
    "invdynared",
    "cons_hJ",
    "cons_jdqd",
    "link",
    "link3D",
    "extforces",
    "sensor",
    "gensensor",
    "accelred",
];

fn file_stem(name: &str) -> &str {
    let base = name.rsplit(['/', '\\']).next();
    let mut parts = base.expect("a text has a last part").split('.');
    parts.next().expect("a text has a first part")
}

/// Names in the head of a function; none without a head.
fn named(
    head: Option<&FunctionHeader>,
    names: impl Fn(&FunctionHeader) -> &Vec<RobotranName>,
) -> &[RobotranName] {
    match head {
        Some(head) => names(head),
        None => &[],
    }
}

/// The parameters under the names the equations use.
fn parameters(head: Option<&FunctionHeader>, storage: &Storage) -> Vec<RobotranName> {
    let parameters = named(head, |head| &head.parameters);
    let outputs = named(head, |head| &head.outputs);
    let all = outputs.iter().chain(parameters);
    all.map(|&name| storage.canonical(name)).collect()
}

/// The runs of a function, or of one of its sensor cases.
fn live_runs(block: &FunctionBlock, case: Option<u32>) -> Vec<Range<usize>> {
    let live = block.runs.iter().filter(|run| match &run.region {
        Region::Common => true,
        Region::Cases(numbers) => case.is_some_and(|case| numbers.contains(&case)),
        Region::Others(numbers) => case.is_some_and(|case| !numbers.contains(&case)),
        Region::Control(_) | Region::Dead => false,
    });
    live.map(|run| run.statements.clone()).collect()
}
