//! From the trees of a core to a function.

use super::core::{Core, TakenNames, named_format, rounds_to_nearest, unlike, word};
use super::number::{CoreLiteral, literal};
use super::terms::{Term, Terms};
use super::{CoreProblems, ERROR_LIMIT};
use robovec_ir::diagnostic::{Label, did_you_mean, suggestion};
use robovec_ir::parenthesised::{Forest, TreeKind, error};
use robovec_ir::{Format, Function, Level, Operation, Shape, Symbol, Tables};
use robovec_robotran::LineIndex;
use std::collections::BTreeMap;

pub(super) struct LoweredCore {
    pub(super) function: Function,
    /// The inputs by the names they have in the file.
    pub(super) arguments: BTreeMap<String, String>,
}

/// Remaining work; the last entry comes first.
enum Step<'text> {
    Read(u32),
    /// Make an operation of the terms read last.
    Apply(Operation),
    /// Bind variables to the terms read last, each with its expression.
    Bind(Vec<(&'text str, u32)>),
    /// Forget the innermost bindings of variables.
    Leave(Vec<&'text str>),
}

struct CoreLowering<'f, 'text, 'p> {
    forest: &'f Forest<'text>,
    problems: &'p mut CoreProblems,
    tables: &'p mut Tables,
    terms: Terms,
    /// The terms that a name represents, the innermost last.
    scope: BTreeMap<&'text str, Vec<u32>>,
    steps: Vec<Step<'text>>,
    results: Vec<u32>,
    format: Option<Format>,
}

/// Reads arguments and body of a core.
pub(super) fn lower(
    forest: &Forest<'_>,
    core: &Core,
    tables: &mut Tables,
    places: &mut LineIndex<'_>,
    problems: &mut CoreProblems,
) -> LoweredCore {
    let mut function = Function::new(&core.name, Level::Equations);
    // What is wrong with the format is told by whoever asks for it.
    let format = core.property(forest, ":precision");
    let format = format.and_then(|tree| named_format(forest.atom(tree)?));
    let mut lowering = CoreLowering {
        forest,
        problems,
        tables,
        terms: Terms::default(),
        scope: BTreeMap::new(),
        steps: vec![Step::Read(core.body)],
        results: Vec::new(),
        format: format.unwrap_or(Some(Format::BINARY64)),
    };
    let mut taken = TakenNames::default();
    let arguments = lowering.arguments(&core.arguments, &mut function, &mut taken);
    lowering.run();
    let CoreLowering { terms, results, .. } = lowering;
    let [result] = results[..] else {
        panic!("an expression leaves one result");
    };
    let output = unlike("result".to_owned(), &mut taken);
    function.add_output(tables.symbols.intern(&output), Shape::Scalar);
    if problems.errors.is_empty() {
        terms.emit((result, core.body), forest, tables, places, &mut function);
    }
    LoweredCore {
        function,
        arguments,
    }
}

impl<'text> CoreLowering<'_, 'text, '_> {
    fn fail(&mut self, tree: u32, message: String, help: Option<&str>) {
        if self.problems.errors.len() < ERROR_LIMIT {
            let diagnostic = error(self.forest.get(tree).span.clone(), message);
            let notes = help.map(str::to_owned).into_iter().collect();
            self.problems.errors.push(diagnostic.with_notes(notes));
        }
    }

    /// Declares the arguments; gives their names as inputs.
    fn arguments(
        &mut self,
        arguments: &[u32],
        function: &mut Function,
        taken: &mut TakenNames,
    ) -> BTreeMap<String, String> {
        let mut names = BTreeMap::new();
        for &argument in arguments {
            let elements = self.forest.elements(argument);
            let name = match (self.forest.head(argument), elements.split_last()) {
                (Some("!"), Some((&last, properties))) => {
                    self.annotations(&properties[1..]);
                    last
                }
                _ => argument,
            };
            let Some(atom) = self.forest.atom(name) else {
                self.fail(
                    argument,
                    "an argument is a number, with a name only".into(),
                    Some("arrays are read element by element: name each element"),
                );
                continue;
            };
            if self.scope.contains_key(atom) {
                self.fail(argument, format!("'{atom}' is an argument already"), None);
                continue;
            }
            let input = unlike(word(atom), taken);
            let symbol = self.tables.symbols.intern(&input);
            let array = function.add_input(symbol, Shape::Scalar);
            let term = self.terms.push(Term::Input(array.offset));
            self.scope.insert(atom, vec![term]);
            names.insert(atom.to_owned(), input);
        }
        names
    }

    fn run(&mut self) {
        while let Some(step) = self.steps.pop() {
            match step {
                Step::Read(tree) => self.read(tree),
                Step::Apply(operation) => {
                    let mut operands = [0; 3];
                    let first = self.results.len() - operation.arity();
                    for (place, term) in operands.iter_mut().zip(self.results.drain(first..)) {
                        *place = term;
                    }
                    let node = Term::Node {
                        operation,
                        operands,
                    };
                    let term = self.terms.push(node);
                    self.results.push(term);
                }
                Step::Bind(variables) => {
                    let first = self.results.len() - variables.len();
                    let terms: Vec<u32> = self.results.drain(first..).collect();
                    for ((name, tree), term) in variables.into_iter().zip(terms) {
                        let symbol: Symbol = self.tables.symbols.intern(&word(name));
                        self.terms.define(term, symbol, tree);
                        self.scope.entry(name).or_default().push(term);
                    }
                }
                Step::Leave(names) => {
                    for name in names {
                        self.scope.entry(name).or_default().pop();
                    }
                }
            }
        }
    }

    fn read(&mut self, tree: u32) {
        if self.forest.get(tree).kind == TreeKind::Atom {
            let term = self.atom(tree);
            self.results.push(term);
            return;
        }
        let elements = self.forest.elements(tree);
        let head = self.forest.head(tree);
        let read = match (head, elements) {
            (Some("let" | "let*"), &[_, bindings, body]) => {
                self.bindings(bindings, body, head == Some("let*"))
            }
            (Some("!"), [_, properties @ .., last]) => {
                self.annotations(properties);
                self.steps.push(Step::Read(*last));
                true
            }
            (Some(name), [_, operands @ ..]) => self.operation(tree, name, operands),
            _ => {
                self.fail(tree, "an expression starts with an operation".into(), None);
                false
            }
        };
        if !read {
            // Stands for what could not be read, so that reading goes on.
            let term = self.terms.push(Term::Number(0.0));
            self.results.push(term);
        }
    }

    fn atom(&mut self, tree: u32) -> u32 {
        let atom = self.forest.atom(tree).expect("an atom has a text");
        if let Some(&term) = self.scope.get(atom).and_then(|terms| terms.last()) {
            return term;
        }
        match literal(atom) {
            CoreLiteral::Number(number) => return self.terms.push(Term::Number(number)),
            CoreLiteral::Long(number) => {
                let diagnostic = error(
                    self.forest.get(tree).span.clone(),
                    format!("the nearest number of binary64 is {number:e}"),
                );
                let warning = robovec_ir::diagnostic::Diagnostic::warning()
                    .with_message(diagnostic.message)
                    .with_labels(diagnostic.labels);
                self.problems.warnings.push(warning);
                return self.terms.push(Term::Number(number));
            }
            CoreLiteral::TooLarge => {
                self.fail(tree, "no number of binary64 is this large".into(), None);
            }
            CoreLiteral::TooSmall => {
                self.fail(
                    tree,
                    "no number of binary64 but 0 is this small".into(),
                    None,
                );
            }
            CoreLiteral::None => {
                let known = self.scope.iter().filter(|(_, terms)| !terms.is_empty());
                let help = suggestion(atom, known.map(|(name, _)| *name));
                let message = "this is neither a number nor a variable".to_owned();
                self.fail(tree, message, help.as_deref());
            }
        }
        self.terms.push(Term::Number(0.0))
    }

    /// Plans a `let` or `let*`.
    fn bindings(&mut self, list: u32, body: u32, one_by_one: bool) -> bool {
        let mut bound: Vec<(&'text str, u32)> = Vec::new();
        for &binding in self.forest.elements(list) {
            let elements = self.forest.elements(binding);
            let [name, value] = *elements else {
                self.fail(
                    binding,
                    "a binding is a name and an expression".into(),
                    None,
                );
                return false;
            };
            let Some(atom) = self.forest.atom(name) else {
                self.fail(name, "this is not a name".into(), None);
                return false;
            };
            bound.push((atom, value));
        }
        if self.forest.get(list).kind == TreeKind::Atom {
            self.fail(list, "bindings are in parentheses".into(), None);
            return false;
        }
        let names = bound.iter().map(|(name, _)| *name).collect();
        self.steps.push(Step::Leave(names));
        self.steps.push(Step::Read(body));
        if one_by_one {
            for (name, value) in bound.into_iter().rev() {
                self.steps.push(Step::Bind(vec![(name, value)]));
                self.steps.push(Step::Read(value));
            }
        } else {
            let values: Vec<u32> = bound.iter().map(|(_, value)| *value).collect();
            self.steps.push(Step::Bind(bound));
            self.steps.extend(values.into_iter().rev().map(Step::Read));
        }
        true
    }

    /// Properties of a part: those that change the numbers are refused.
    fn annotations(&mut self, properties: &[u32]) {
        for pair in properties.chunks(2) {
            let (key, value) = (self.forest.atom(pair[0]), pair.get(1));
            match (key, value) {
                (Some(":precision"), Some(&value)) => {
                    let own = self.forest.atom(value).and_then(named_format);
                    if own != Some(self.format) {
                        let help = "'mixed' chooses a format for each value";
                        let message = "all of a core is computed in one precision".to_owned();
                        self.fail(value, message, Some(help));
                    }
                }
                (Some(":round"), Some(&value)) => {
                    rounds_to_nearest(self.forest, value, self.problems);
                }
                (Some(key), Some(_)) if key.starts_with(':') => {}
                _ => self.fail(
                    pair[0],
                    "properties come in pairs ':name value'".into(),
                    None,
                ),
            }
        }
    }

    fn operation(&mut self, tree: u32, name: &str, operands: &[u32]) -> bool {
        let operation = match (name, operands.len()) {
            ("+", 2) => Operation::Add,
            ("-", 1) => Operation::Neg,
            ("-", 2) => Operation::Sub,
            ("*", 2) => Operation::Mul,
            ("/", 2) => Operation::Div,
            ("sqrt", 1) => Operation::Sqrt,
            ("sin", 1) => Operation::Sin,
            ("cos", 1) => Operation::Cos,
            ("fma", 3) => Operation::Fma,
            _ => {
                self.refuse(tree, name);
                return false;
            }
        };
        self.steps.push(Step::Apply(operation));
        self.steps
            .extend(operands.iter().rev().map(|&operand| Step::Read(operand)));
        true
    }

    /// Reports why an operation is not read.
    fn refuse(&mut self, tree: u32, name: &str) {
        const OURS: [&str; 8] = ["+", "-", "*", "/", "sqrt", "sin", "cos", "fma"];
        let reason = match name {
            _ if OURS.contains(&name) => format!("'{name}' does not take this number of operands"),
            "if" | "<" | "<=" | ">" | ">=" | "==" | "!=" | "and" | "or" | "not" => {
                format!("'{name}' is a branch, and only code without branches can be compiled")
            }
            "while" | "while*" | "for" | "for*" | "tensor" | "tensor*" => {
                format!("'{name}' is a loop, and only code without loops can be compiled")
            }
            "let" | "let*" => format!("'{name}' takes bindings and one expression"),
            "array" | "ref" | "dim" | "size" => format!("'{name}': only numbers are read"),
            "pow" => "there is no operation 'pow'; a whole power is a product".to_owned(),
            _ => format!(
                "there is no operation '{}'",
                robovec_ir::diagnostic::clip(name)
            ),
        };
        if self.problems.errors.len() >= ERROR_LIMIT {
            return;
        }
        let head = self.forest.elements(tree)[0];
        let span = self.forest.get(head).span.clone();
        let help = format!("operations: {}, and let, let*", OURS.join(", "));
        let mut diagnostic = error(span, reason).with_notes(vec![help]);
        if let Some(near) = did_you_mean(name, OURS) {
            let label: &mut Label = &mut diagnostic.labels[0];
            label.message = format!("did you mean '{near}'?");
        }
        self.problems.errors.push(diagnostic);
    }
}
