//! Text before the equations: signature, arrays, aliases.

use super::arrays::{ArrayRole, FileArray, FileArrays};
use super::file::{EquationKind, function_name};
use super::text::FileText;
use crate::Language;
use robovec_cgen::kind::{Generation, ProjectStructure};
use robovec_ir::{Function, Shape};

pub(super) struct Prologue<'a> {
    pub(super) kind: EquationKind,
    /// Model name, as in file names.
    pub(super) stem: &'a str,
    pub(super) joints: Option<u32>,
    pub(super) arrays: &'a FileArrays,
    /// The first function of the file, for the common part.
    pub(super) function: &'a Function,
}

impl Prologue<'_> {
    pub(super) fn write(&self, text: &mut FileText) {
        match text.language {
            Language::C => self.c(text),
            Language::Matlab => self.matlab(text),
            Language::Python => self.python(text),
        }
    }

    /// Parameters that are filled, by the function's own arrays where known.
    fn outputs(&self) -> Vec<(&str, usize, Option<&FileArray>)> {
        let outputs = self.kind.outputs.iter();
        outputs
            .map(|&(name, rank)| {
                let array = self.arrays.find(name);
                match (array, name) {
                    (None, "Flink") => match self.arrays.find("Flnk") {
                        Some(array) => ("Flnk", rank, Some(array)),
                        None => (name, rank, None),
                    },
                    (array, _) => (name, rank, array),
                }
            })
            .collect()
    }

    fn with_role(&self, role: ArrayRole) -> impl Iterator<Item = &FileArray> {
        self.arrays
            .all
            .iter()
            .filter(move |array| array.role == role)
    }

    fn aliases(&self, language: Language) -> impl Iterator<Item = &FileArray> {
        let arrays = self.arrays.all.iter();
        arrays.filter(move |array| array.has_alias(language))
    }

    fn c(&self, text: &mut FileText) {
        let names = ProjectStructure::of(self.function);
        let (data, prefix) = (names.name, names.prefix);
        let name = format!("{prefix}{}", function_name(self.kind, Language::C));
        text.line("#include <math.h>");
        text.line("");
        text.line(&format!("#include \"{}\"", names.header));
        // The old header of functions declares sensors too.
        let is_old = Generation::of(self.function) == Generation::Old;
        if self.kind.is_sensor() && !is_old {
            text.line("#include \"mbs_sensor.h\"");
        }
        if !self.function.boundaries.is_empty()
            || self.kind.updates_forces()
            || self.kind.has_status()
            || is_old
        {
            text.line(&format!("#include \"{}\"", names.functions));
        }
        text.line("");
        let outputs = self.outputs();
        let outputs: String = outputs
            .iter()
            .map(|(name, rank, _)| format!("double {}{name}, ", "*".repeat(*rank)))
            .collect();
        let status = if self.kind.has_status() {
            "int"
        } else {
            "void"
        };
        if self.kind.is_sensor() {
            text.line(&format!("void {name}({} *sens,", names.sensor));
            text.line(&format!("{data} *s, int isens)"));
        } else if outputs.is_empty() {
            text.line(&format!("{status} {name}({data} *s, double tsim)"));
        } else {
            text.line(&format!("{status} {name}({}", outputs.trim_end()));
            text.line(&format!("{data} *s, double tsim)"));
        }
        text.line("{");
        text.line(&format!(
            "#include \"mbs_{}_{}.h\"",
            self.kind.name, self.stem
        ));
        self.c_locals(text);
        self.c_aliases(text);
    }

    fn c_locals(&self, text: &mut FileText) {
        let mut lines = Vec::new();
        for array in self.with_role(ArrayRole::Argument) {
            match array.shape {
                Shape::Scalar => {}
                Shape::Vector(length) => {
                    lines.push(format!("double {}[{}];", array.name, u64::from(length) + 1));
                }
                Shape::Matrix(rows, columns) => {
                    let (rows, columns) = (u64::from(rows) + 1, u64::from(columns) + 1);
                    lines.push(format!("double {}[{rows}][{columns}];", array.name));
                }
            }
        }
        for array in self
            .with_role(ArrayRole::Result)
            .filter(|array| array.rank() > 0)
        {
            lines.push(format!(
                "double {}{};",
                "*".repeat(array.rank()),
                array.name
            ));
        }
        if !lines.is_empty() {
            text.line("");
        }
        lines.iter().for_each(|line| text.line(line));
    }

    fn c_aliases(&self, text: &mut FileText) {
        let aliases: Vec<&FileArray> = self.aliases(Language::C).collect();
        let declare = |rank: usize| {
            let stars = "*".repeat(rank);
            let names: Vec<String> = aliases
                .iter()
                .filter(|array| array.rank() == rank)
                .map(|array| format!("{stars}{}", array.name))
                .collect();
            (!names.is_empty()).then(|| format!("double {};", names.join(", ")))
        };
        let declarations: Vec<String> = [1, 2].into_iter().filter_map(declare).collect();
        let mut pairs: Vec<&str> = aliases.iter().map(|array| array.name.as_str()).collect();
        if self.kind.updates_forces() {
            pairs.extend(["frc", "trq"]);
        }
        if !declarations.is_empty() {
            text.line("");
        }
        declarations.iter().for_each(|line| text.line(line));
        if !pairs.is_empty() {
            text.line("");
        }
        for name in pairs {
            text.line(&format!("{name} = s->{name};"));
        }
    }

    fn matlab(&self, text: &mut FileText) {
        let name = function_name(self.kind, Language::Matlab);
        let outputs = self.outputs();
        let mut returned: Vec<&str> = outputs.iter().map(|(name, _, _)| *name).collect();
        let own = self.function.outputs().iter();
        let own = own.map(|array| self.arrays.of(array.name));
        let data: Vec<&FileArray> = own.filter(|array| array.role == ArrayRole::Data).collect();
        returned.extend(data.iter().map(|array| array.name.as_str()));
        if self.kind.is_sensor() {
            text.line(&format!("function [sens] = {name}(s,tsim,usrfun,isens)"));
        } else {
            let returned = returned.join(",");
            text.line(&format!("function [{returned}] = {name}(s,tsim,usrfun)"));
        }
        text.line("");
        if self.kind.is_sensor() {
            self.matlab_sensor(text);
        }
        for (name, rank, array) in outputs {
            match (name, array) {
                ("frc" | "trq", _) => text.line(&format!(" {name} = s.{name};")),
                (_, array) => self.zeros(text, name, rank, array.map(|array| array.shape)),
            }
        }
        for array in data {
            if array.is_input {
                text.line(&format!(" {0} = s.{0};", array.name))
            } else {
                self.zeros(text, &array.name, array.rank(), Some(array.shape))
            }
        }
        text.line("");
        for array in self.aliases(Language::Matlab) {
            text.line(&format!("{0} = s.{0};", array.name));
        }
    }

    /// Number of joints, 1 if unknown.
    fn joint_count(&self) -> u32 {
        self.joints.unwrap_or(1)
    }

    fn zeros(&self, text: &mut FileText, name: &str, rank: usize, shape: Option<Shape>) {
        let joints = self.joint_count();
        let (rows, columns) = match shape {
            Some(Shape::Vector(length)) => (length, 1),
            Some(Shape::Matrix(rows, columns)) => (rows, columns),
            Some(Shape::Scalar) => (1, 1),
            None => match (name, rank) {
                ("M", _) => (joints, joints),
                ("c" | "Qq", _) => (joints, 1),
                ("Jac", _) => (1, joints),
                _ => (1, 1),
            },
        };
        text.line(&format!(" {name} = zeros({rows},{columns});"));
    }

    fn matlab_sensor(&self, text: &mut FileText) {
        let joints = self.joint_count();
        for (field, rows, columns) in [
            ("P", 3, 1),
            ("R", 3, 3),
            ("V", 3, 1),
            ("OM", 3, 1),
            ("A", 3, 1),
            ("OMP", 3, 1),
            ("J", 6, joints),
        ] {
            let known = self.arrays.find(&format!("sens.{field}"));
            let (rows, columns) = match known.map(|array| array.shape) {
                Some(Shape::Vector(length)) => (length, 1),
                Some(Shape::Matrix(rows, columns)) => (rows, columns),
                Some(Shape::Scalar) | None => (rows, columns),
            };
            text.line(&format!(" sens.{field} = zeros({rows},{columns});"));
        }
    }

    fn python(&self, text: &mut FileText) {
        text.line("from math import sin, cos, sqrt");
        if self
            .with_role(ArrayRole::Argument)
            .any(|array| array.rank() > 0)
        {
            text.line("from numpy import zeros");
        }
        text.line("");
        let name = function_name(self.kind, Language::Python);
        let outputs = self.outputs();
        let mut parameters: Vec<&str> = outputs.iter().map(|(name, _, _)| *name).collect();
        if self.kind.is_sensor() {
            parameters.extend(["sens", "s", "isens"]);
        } else if matches!(self.kind.name, "cons_hJ" | "cons_jdqd") {
            parameters.push("s");
        } else {
            parameters.extend(["s", "tsim"]);
        }
        let inverse = self.kind.name == "invdyna";
        if inverse {
            // The parameter's name in Robotran's own files.
            parameters[0] = "phi";
        }
        text.line(&format!("def {name}({}):", parameters.join(", ")));
        if inverse {
            text.line("    Qq = phi");
        }
        for array in self.aliases(Language::Python) {
            text.line(&format!("    {0} = s.{0}", array.name));
        }
        if self.kind.name == "extforces" {
            text.line("    frc = s.frc");
            text.line("    trq = s.trq");
        }
        for array in self.with_role(ArrayRole::Argument) {
            match array.shape {
                Shape::Scalar => {}
                Shape::Vector(length) => {
                    text.line(&format!(
                        "    {} = zeros({})",
                        array.name,
                        u64::from(length) + 1
                    ));
                }
                Shape::Matrix(rows, columns) => {
                    let (rows, columns) = (u64::from(rows) + 1, u64::from(columns) + 1);
                    text.line(&format!("    {} = zeros(({rows}, {columns}))", array.name));
                }
            }
        }
    }
}
