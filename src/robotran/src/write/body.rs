//! The statements of a file.

use super::arrays::ArrayRole;
use super::error::RobotranWriteError;
use super::expression::PrinterSource;
use super::file::RobotranFile;
use super::function_text::{BodySection, FunctionText, common_prefix};
use super::plan::{WrittenStatement, call_statement};
use crate::Language;
use robovec_ir::{Assignment, Boundary, Function, Output, Shape, Symbol, Value};

impl RobotranFile<'_> {
    pub(super) fn statements(&self, body: &mut FunctionText) -> Result<(), RobotranWriteError> {
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
        self.switch(body)
    }

    /// Common beginning of all cases, then the cases.
    fn switch(&self, body: &mut FunctionText) -> Result<(), RobotranWriteError> {
        let common = common_prefix(&self.functions) as u32;
        self.function(body, 0, 0, common)?;
        self.title(body, BodySection::Main);
        match self.language {
            Language::C => {
                body.text.line("switch(isens)");
                body.text.line("{");
            }
            Language::Matlab => body.text.line("switch isens"),
            Language::Python => body.text.indent(8),
        }
        for (index, case) in self.cases.iter().enumerate() {
            // Only a function that sets nothing may lack the number of its sensor.
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
        self.plans[index].iter().all(
            |statement| matches!(statement, WrittenStatement::Define(value) if value.0 < common),
        )
    }

    /// The statements of a function with nodes in a range, outputs at its end.
    fn function(
        &self,
        body: &mut FunctionText,
        index: usize,
        first: u32,
        end: u32,
    ) -> Result<(), RobotranWriteError> {
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
        let source = PrinterSource {
            function,
            symbols: self.symbols,
            names: &self.names,
            inputs: &inputs,
            kept: &self.kept[index],
        };
        for &statement in &self.plans[index] {
            let here = match statement {
                WrittenStatement::Define(value) => (first..end).contains(&value.0),
                _ => end == u32::MAX,
            };
            if here {
                self.statement(body, &source, &outputs, statement)?;
            }
        }
        if self.zeros && end == u32::MAX {
            self.set_zeros(body, function, &outputs);
        }
        Ok(())
    }

    fn statement(
        &self,
        body: &mut FunctionText,
        source: &PrinterSource<'_>,
        outputs: &[String],
        statement: WrittenStatement,
    ) -> Result<(), RobotranWriteError> {
        let function = source.function;
        match statement {
            WrittenStatement::Define(value) => self.define(body, source, value),
            WrittenStatement::Call(call) => {
                self.call(body, function, &function.boundaries[call])?
            }
            WrittenStatement::Argument(index) => {
                self.title(body, BodySection::Main);
                self.assign(body, source, outputs, &function.assignments[index], false);
            }
            WrittenStatement::Output(index) => {
                // In a sensor's case the title of the cases stands over all.
                if self.cases[0].is_none() {
                    self.title(body, BodySection::Outputs);
                }
                self.assign(body, source, outputs, &function.assignments[index], true);
            }
            WrittenStatement::Keep(input) => {
                let name = &source.kept[&input];
                body.declare(name);
                body.text.begin();
                body.text.push(name);
                body.text.push(" = ");
                body.printer
                    .right_side(&mut body.text, source, input.into(), false);
                body.text.end();
            }
        }
        Ok(())
    }

    fn call(
        &self,
        body: &mut FunctionText,
        function: &Function,
        call: &Boundary,
    ) -> Result<(), RobotranWriteError> {
        let statement = call_statement(function, call, self.language)?;
        self.title(body, BodySection::Main);
        if let Some(result) = &call.result {
            let known = self.arrays.find(result);
            // An array's pointer is declared with the other arrays.
            if known.is_none_or(|array| array.shape == Shape::Scalar) {
                body.declare(result);
            }
        }
        body.text.statement(&statement);
        Ok(())
    }

    fn define(&self, body: &mut FunctionText, source: &PrinterSource<'_>, value: Value) {
        let node = source.function.node(value);
        let trigonometric = node.operation.is_trigonometric() && body.section < BodySection::Main;
        self.title(
            body,
            if trigonometric {
                BodySection::Trigonometry
            } else {
                BodySection::Main
            },
        );
        let name = self.names.text(node.name, self.symbols);
        // The names of one function differ; those of its cases need not.
        match self.functions.len() {
            1 => body.declare(name),
            _ => body.declare_once(name),
        }
        body.text.begin();
        body.text.push(name);
        body.text.push(" = ");
        body.printer.definition(&mut body.text, source, value);
        body.text.end();
    }

    fn assign(
        &self,
        body: &mut FunctionText,
        source: &PrinterSource<'_>,
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
        let name = &outputs[place.expect("an assignment sets an array of its function")];
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

    /// True for a number handed to a user function under its temporary's name.
    fn is_its_own(&self, function: &Function, name: Symbol, assignment: &Assignment) -> bool {
        assignment.operand.value().is_some_and(|value| {
            let own = function.node(value).name;
            own.base == name && self.names.text(own, self.symbols) == self.symbols.text(name)
        })
    }

    fn set_zeros(&self, body: &mut FunctionText, function: &Function, outputs: &[String]) {
        let mut set = vec![false; function.output_len()];
        for assignment in &function.assignments {
            set[assignment.output.index()] = true;
        }
        assert_eq!(
            outputs.len(),
            function.outputs().len(),
            "every output array has a name"
        );
        for (array, name) in function.outputs().iter().zip(outputs) {
            let known = self.arrays.of(array.name);
            // What is also given keeps what it was given.
            if known.is_input || matches!(known.role, ArrayRole::Argument) {
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
    fn title(&self, body: &mut FunctionText, section: BodySection) {
        if section <= body.section {
            return;
        }
        body.section = section;
        let title = match (section, self.kind.name) {
            (BodySection::Start | BodySection::Trigonometry, _) => "Trigonometric functions",
            (BodySection::Outputs, _) => "Symbolic model output",
            (BodySection::Main, "dirdyna" | "invdyna" | "dirdyna_odn") => "Kinematics and Dynamics",
            (BodySection::Main, "sensor" | "gensensor") => "Sensor Kinematics",
            (BodySection::Main, "link" | "link3D") => "Link Kinematics and Forces",
            (BodySection::Main, "extforces") => "Sensor Kinematics and Forces",
            (BodySection::Main, "cons_hJ" | "cons_jdqd") => "Constraints",
            (BodySection::Main, _) => "Equations",
        };
        body.text.section(title);
    }
}
