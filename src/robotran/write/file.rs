//! A file: header comments, prologue, statements, end.

use super::arrays::{Arrays, Role};
use super::error::WriteError;
use super::expression::{Printer, Source};
use super::extents;
use super::kind::Kind;
use super::names::{Names, is_word};
use super::plan::{Statement, common_prefix, plan};
use super::prologue::Prologue;
use super::text::{Text, comment_mark};
use super::{Member, WriteOptions, calls};
use crate::robotran::Language;
use hashbrown::{HashMap, HashSet};
use robovec_ir::{Assignment, Function, Input, Module, Output, Shape, Symbols, Value};
use rustc_hash::FxBuildHasher;

/// The functions of one file.
pub(super) struct File<'a> {
    kind: Kind,
    language: Language,
    symbols: &'a Symbols,
    model: String,
    /// The model's name as part of a file name.
    stem: String,
    joints: Option<u32>,
    functions: Vec<&'a Function>,
    /// The number of each, for sensors.
    cases: Vec<Option<u32>>,
    plans: Vec<Vec<Statement>>,
    arrays: Arrays,
    names: Names,
    /// Per function the temporaries of input elements that are overwritten.
    kept: Vec<HashMap<Input, Box<str>, FxBuildHasher>>,
    zeros: bool,
    all_parameter_symbols: bool,
}

/// The text being written, and what it has come to.
struct Body {
    text: Text,
    printer: Printer,
    /// The temporaries of C, in order, each once.
    declared: Vec<Box<str>>,
    known: HashSet<Box<str>, FxBuildHasher>,
    section: Section,
}

/// What stands under the title printed last.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Debug)]
enum Section {
    Start,
    Trigonometry,
    Main,
    Outputs,
}

impl<'a> File<'a> {
    pub(super) fn new(
        module: &'a Module,
        members: &[Member<'a>],
        language: Language,
        options: &WriteOptions,
    ) -> Result<File<'a>, WriteError> {
        let symbols = &module.tables.symbols;
        let kind = members[0].kind;
        let functions: Vec<&Function> = members.iter().map(|member| member.function).collect();
        let first = functions[0];
        let unnumbered = members.iter().find(|member| {
            kind.is_sensor() && member.case.is_none() && !member.function.assignments.is_empty()
        });
        if let Some(member) = unnumbered {
            return Err(WriteError::Case {
                function: member.function.name.clone(),
            });
        }
        let mut functions_of_numbers = functions.iter();
        if let Some(function) = functions_of_numbers.find(|function| {
            function
                .constants()
                .iter()
                .any(|number| !number.is_finite())
        }) {
            return Err(WriteError::Number {
                function: function.name.clone(),
            });
        }
        let arrays = Arrays::new(&functions, kind, symbols, language)?;
        let shared = language != Language::Matlab;
        let plans: Vec<Vec<Statement>> = functions
            .iter()
            .map(|function| plan(function, symbols, shared))
            .collect::<Result<_, _>>()?;
        let mut names = identifiers(&functions, symbols, &arrays);
        let kept = (functions.iter().zip(&plans))
            .map(|(function, plan)| kept(function, plan, &mut names, symbols))
            .collect();
        let model = options.model.as_deref().or(first.metadata("model"));
        let model: String = model
            .unwrap_or("model")
            .chars()
            .filter(|character| !character.is_control())
            .collect();
        Ok(File {
            kind,
            language,
            symbols,
            stem: stem(&model),
            model,
            joints: joints(first, &arrays),
            cases: members.iter().map(|member| member.case).collect(),
            plans,
            functions,
            arrays,
            names,
            kept,
            zeros: options.zeros,
            all_parameter_symbols: first.metadata("all_parameter_symbols").is_some(),
        })
    }

    /// The files: the equations, and in C the header beside them.
    pub(super) fn write(&self) -> Result<Vec<(String, String)>, WriteError> {
        let mut body = Body {
            text: Text::new(self.language),
            printer: Printer::default(),
            declared: Vec::new(),
            known: HashSet::default(),
            section: Section::Start,
        };
        self.statements(&mut body)?;
        let most = body.text.most_continuations();
        let (statements, _) = body.text.finish();
        let mut text = Text::new(self.language);
        self.header(&mut text, body.printer.count());
        Prologue {
            kind: self.kind,
            stem: &self.stem,
            joints: self.joints,
            arrays: &self.arrays,
            function: self.functions[0],
        }
        .write(&mut text);
        let (mut file, _) = text.finish();
        file.push_str(&statements);
        let mark = comment_mark(self.language);
        if self.language == Language::C && self.kind.has_status() {
            file.push_str("\nreturn 0;\n");
        }
        file.push_str(&format!("\n{mark} Number of continuation lines = {most}\n"));
        if self.language == Language::C {
            file.push_str("\n}\n");
        }
        let stem = format!("mbs_{}_{}", self.kind.name, self.stem);
        let extension = match self.language {
            Language::C => "c",
            Language::Matlab => "m",
            Language::Python => "py",
        };
        let mut files = vec![(format!("{stem}.{extension}"), file)];
        if self.language == Language::C {
            files.push((format!("{stem}.h"), declarations(&body.declared)));
        }
        Ok(files)
    }

    fn header(&self, text: &mut Text, flops: usize) {
        text.comment("");
        text.comment(&format!(
            "\trobovec - Version {}",
            env!("CARGO_PKG_VERSION")
        ));
        text.comment("");
        text.comment(&format!("\t==> Project name : {}", self.model));
        if self.all_parameter_symbols {
            text.comment("\t==> All Parameter Symbols included");
        }
        if let Some(joints) = self.joints {
            text.comment(&format!("\t==> Number of joints : {joints}"));
        }
        let number = match self.kind.number {
            0 => String::new(),
            number => format!("F {number} : "),
        };
        text.comment(&format!("\t==> Function : {number}{}", self.kind.title));
        text.comment(&format!("\t==> Flops complexity : {flops}"));
        let extents = extents::line(&self.functions, &self.arrays, self.joints.unwrap_or(0));
        if let Some(extents) = extents {
            text.comment(&format!("\t==> Array extents : {extents}"));
        }
        text.comment("");
        text.line("");
    }

    fn statements(&self, body: &mut Body) -> Result<(), WriteError> {
        body.text.indent(match self.language {
            Language::C => 0,
            Language::Matlab => 2,
            Language::Python => 4,
        });
        if self.cases.iter().all(Option::is_none) {
            let function = self.functions[0];
            self.function(body, 0, 0, u32::MAX)?;
            let nothing = function.assignments.is_empty() && function.nodes().is_empty();
            if nothing && self.language == Language::Python {
                body.text.statement("pass");
            }
            return Ok(());
        }
        let common = common_prefix(&self.functions) as u32;
        self.function(body, 0, 0, common)?;
        self.title(body, Section::Main);
        match self.language {
            Language::C => {
                body.text.line("switch(isens)");
                body.text.line("{");
            }
            Language::Matlab => body.text.line("switch isens"),
            Language::Python => body.text.indent(8),
        }
        for (index, case) in self.cases.iter().enumerate() {
            let case = case.unwrap_or(0);
            match self.language {
                Language::C => body.text.line(&format!("case {case}:")),
                Language::Matlab => body.text.line(&format!("case {case},")),
                Language::Python => body.text.line(&format!("    if (isens == {case}):")),
            }
            if self.language == Language::Python && self.is_empty_case(index, common) {
                body.text.statement("pass");
            }
            body.text.line("");
            self.function(body, index, common, u32::MAX)?;
            if self.language == Language::C {
                body.text.line("");
                body.text.line("break;");
            }
            body.text.line("");
        }
        match self.language {
            Language::C => {
                body.text.line("default:");
                body.text.line("break;");
                body.text.line("}");
            }
            Language::Matlab => body.text.line("end"),
            Language::Python => {}
        }
        Ok(())
    }

    fn is_empty_case(&self, index: usize, common: u32) -> bool {
        self.plans[index]
            .iter()
            .all(|statement| matches!(statement, Statement::Define(value) if value.0 < common))
    }

    /// The statements of a function whose nodes lie in a range; its outputs
    /// and calls belong to the end of it.
    fn function(
        &self,
        body: &mut Body,
        index: usize,
        first: u32,
        end: u32,
    ) -> Result<(), WriteError> {
        let function = self.functions[index];
        let inputs: Vec<String> = function
            .inputs()
            .iter()
            .map(|array| self.arrays.of(array.name).input_text(self.language))
            .collect();
        let outputs: Vec<String> = function
            .outputs()
            .iter()
            .map(|array| self.arrays.of(array.name).output_text(self.language))
            .collect();
        let source = Source {
            function,
            symbols: self.symbols,
            names: &self.names,
            inputs: &inputs,
            kept: &self.kept[index],
        };
        for &statement in &self.plans[index] {
            let here = match statement {
                Statement::Define(value) => (first..end).contains(&value.0),
                _ => end == u32::MAX,
            };
            if !here {
                continue;
            }
            match statement {
                Statement::Define(value) => self.define(body, &source, value),
                Statement::Call(call) => {
                    let call = &function.boundaries[call];
                    let statement = calls::statement(function, call, self.language)?;
                    self.title(body, Section::Main);
                    if let Some(result) = &call.result
                        && self
                            .arrays
                            .find(result)
                            .is_none_or(|array| array.shape == Shape::Scalar)
                    {
                        body.declare(result);
                    }
                    body.text.statement(&statement);
                }
                Statement::Argument(index) => {
                    self.title(body, Section::Main);
                    self.assign(body, &source, &outputs, &function.assignments[index], false);
                }
                Statement::Output(index) => {
                    if self.cases[0].is_none() {
                        self.title(body, Section::Outputs);
                    }
                    self.assign(body, &source, &outputs, &function.assignments[index], true);
                }
                Statement::Keep(input) => {
                    let name = &source.kept[&input];
                    body.declare(name);
                    body.text.begin();
                    body.text.push(name);
                    body.text.push(" = ");
                    body.printer
                        .right_side(&mut body.text, &source, input.into(), false);
                    body.text.end();
                }
            }
        }
        if self.zeros && end == u32::MAX {
            self.set_zeros(body, function, &outputs);
        }
        Ok(())
    }

    fn define(&self, body: &mut Body, source: &Source<'_>, value: Value) {
        let node = source.function.node(value);
        let trigonometric = node.operation.is_trigonometric() && body.section < Section::Main;
        self.title(
            body,
            if trigonometric {
                Section::Trigonometry
            } else {
                Section::Main
            },
        );
        let name = self.names.text(node.name, self.symbols);
        body.declare(name);
        body.text.begin();
        body.text.push(name);
        body.text.push(" = ");
        body.printer.definition(&mut body.text, source, value);
        body.text.end();
    }

    fn assign(
        &self,
        body: &mut Body,
        source: &Source<'_>,
        outputs: &[String],
        assignment: &Assignment,
        last: bool,
    ) {
        let function = source.function;
        let (array, indices, rank) = function.output_element(assignment.output);
        if rank == 0 && self.is_its_own(function, array.name, assignment) {
            return;
        }
        let place = function.outputs().iter().position(|other| other == array);
        let name = place.map_or("", |place| &outputs[place]);
        if rank == 0 {
            body.declare(name);
        }
        body.text.begin();
        body.text.element(name, &indices[..rank]);
        body.text.push(" = ");
        body.printer
            .right_side(&mut body.text, source, assignment.operand, last);
        body.text.end();
    }

    /// True for a number handed to a user function under the name that its
    /// temporary bears anyhow.
    fn is_its_own(
        &self,
        function: &Function,
        name: robovec_ir::Symbol,
        assignment: &Assignment,
    ) -> bool {
        assignment.operand.value().is_some_and(|value| {
            let own = function.node(value).name;
            own.base == name && self.names.text(own, self.symbols) == self.symbols.text(name)
        })
    }

    fn set_zeros(&self, body: &mut Body, function: &Function, outputs: &[String]) {
        let mut set = vec![false; function.output_len()];
        for assignment in &function.assignments {
            set[assignment.output.index()] = true;
        }
        for (array, name) in function.outputs().iter().zip(outputs) {
            let known = self.arrays.of(array.name);
            // What is also given keeps what it was given.
            if known.is_input || matches!(known.role, Role::Argument) {
                continue;
            }
            let first = array.offset as usize;
            for output in (first..first + array.shape.len()).filter(|&output| !set[output]) {
                let (_, indices, rank) = function.output_element(Output(output as u32));
                body.text.begin();
                body.text.element(name, &indices[..rank]);
                body.text.push(" = 0");
                body.text.end();
            }
        }
    }

    /// Prints the title of a section where it begins.
    fn title(&self, body: &mut Body, section: Section) {
        if section <= body.section {
            return;
        }
        body.section = section;
        let title = match (section, self.kind.name) {
            (Section::Start | Section::Trigonometry, _) => "Trigonometric functions",
            (Section::Outputs, _) => "Symbolic model output",
            (Section::Main, "dirdyna" | "invdyna" | "dirdyna_odn") => "Kinematics and Dynamics",
            (Section::Main, "sensor" | "gensensor") => "Sensor Kinematics",
            (Section::Main, "link" | "link3D") => "Link Kinematics and Forces",
            (Section::Main, "extforces") => "Sensor Kinematics and Forces",
            (Section::Main, "cons_hJ" | "cons_jdqd") => "Constraints",
            (Section::Main, _) => "Equations",
        };
        body.text.section(title);
    }
}

impl Body {
    /// Notes a temporary, for the header of C.
    fn declare(&mut self, name: &str) {
        if self.text.language == Language::C && !self.known.contains(name) {
            self.known.insert(name.into());
            self.declared.push(name.into());
        }
    }
}

/// Gives every value of the file its identifier.
fn identifiers(functions: &[&Function], symbols: &Symbols, arrays: &Arrays) -> Names {
    let mut names = Names::new();
    let own = |function: &Function, output: &str| {
        function.assignments.iter().any(|assignment| {
            let (array, _, rank) = function.output_element(assignment.output);
            rank == 0
                && symbols.text(array.name) == output
                && assignment.operand.value().is_some_and(|value| {
                    let name = function.node(value).name;
                    name.base == array.name && name.suffix == 0
                })
        })
    };
    for array in &arrays.all {
        let scalar = array.shape == Shape::Scalar && array.role == Role::Argument;
        if !(scalar && own(functions[0], &array.name)) {
            names.reserve(&array.name);
        }
    }
    for function in functions {
        for call in &function.boundaries {
            let words = call.arguments.iter().chain(&call.result);
            for word in words.filter(|word| is_word(word) && arrays.find(word).is_none()) {
                names.reserve(word);
            }
        }
    }
    for function in functions {
        names.keep(function.nodes().iter().map(|node| node.name), symbols);
    }
    for function in functions {
        names.derive(function.nodes().iter().map(|node| node.name), symbols);
    }
    names
}

/// A temporary for every input element that must be kept.
fn kept(
    function: &Function,
    plan: &[Statement],
    names: &mut Names,
    symbols: &Symbols,
) -> HashMap<Input, Box<str>, FxBuildHasher> {
    let mut kept = HashMap::default();
    for statement in plan {
        if let Statement::Keep(input) = *statement {
            let (array, indices, rank) = function.input_element(input);
            let mut wanted = symbols.text(array.name).to_owned();
            for index in &indices[..rank] {
                wanted.push_str(&format!("_{index}"));
            }
            kept.insert(input, names.fresh(&wanted, 0, symbols));
        }
    }
    kept
}

/// The header's number of joints, else the length of what has one element per
/// joint.
fn joints(function: &Function, arrays: &Arrays) -> Option<u32> {
    let said = function
        .metadata("joints")
        .and_then(|text| text.parse().ok());
    let per_joint = ["q", "qd", "qdd", "c", "Qq", "m"];
    let mut known = arrays
        .all
        .iter()
        .filter(|array| per_joint.contains(&array.name.as_str()));
    said.or_else(|| match known.next()?.shape {
        Shape::Vector(length) => Some(length),
        Shape::Scalar | Shape::Matrix(..) => None,
    })
}

/// A model's name as part of a file name.
fn stem(model: &str) -> String {
    let word = |c: char| {
        if c.is_ascii_alphanumeric() || c == '-' {
            c
        } else {
            '_'
        }
    };
    let stem: String = model.trim().chars().map(word).collect();
    if stem.is_empty() {
        "model".to_owned()
    } else {
        stem
    }
}

fn declarations(declared: &[Box<str>]) -> String {
    let mut text = String::with_capacity(24 * declared.len());
    for name in declared {
        text.push_str("double    ");
        text.push_str(name);
        text.push_str(";\n");
    }
    text
}
