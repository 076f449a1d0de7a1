//! The text of a rolled C function.

mod expression;

use super::super::emit::Real;
use super::super::emit::arrays::{Rows, parameter};
use super::super::emit::expression::literal;
use super::super::emit::frame::{self, ParameterList};
use super::super::emit::names::CNames;
use super::super::sincos::SineKernel;
use super::nest::BodyElement;
use super::program::{Copy, LeafSource, RolledProgram, SpaceElement, StorageSpace};
use super::{Options, RolledCircular};
use robovec_ir::{Function, View};
use std::fmt::Write;

/// The source and the header.
pub(super) fn files(
    view: View<'_>,
    options: Options,
    program: &RolledProgram,
) -> [(String, String); 2] {
    let writer = RolledWriter::new(view, options, program);
    let name = writer.name.clone();
    [
        (format!("{name}.c"), writer.source()),
        (format!("{name}.h"), writer.header()),
    ]
}

struct RolledWriter<'a> {
    function: &'a Function,
    program: &'a RolledProgram,
    real: Real,
    /// The kernel of sines and cosines, where one is wanted and used.
    kernel: Option<SineKernel>,
    name: String,
    inputs: Vec<String>,
    outputs: Vec<String>,
    work: String,
    constants: String,
    tables: Vec<String>,
    /// For each position its variable.
    variables: Vec<String>,
    carried: Vec<String>,
    /// For each loop its index and its counter of passes.
    indices: Vec<String>,
    counters: Vec<String>,
    parts: Vec<String>,
    independent: String,
    apart: String,
    aligned: String,
}

/// The arrays that a part touches.
#[derive(Clone, Default)]
struct Used {
    inputs: Vec<bool>,
    outputs: Vec<bool>,
    work: bool,
}

impl<'a> RolledWriter<'a> {
    fn new(view: View<'a>, options: Options, program: &'a RolledProgram) -> RolledWriter<'a> {
        let function = view.function;
        let mut names = CNames::new();
        let name = names.take(&function.name);
        let inputs = names.take_arrays(view, function.inputs());
        let outputs = names.take_arrays(view, function.outputs());
        let parts = (1..=program.parts.last().map_or(0, |&last| last))
            .map(|number| names.take(&format!("{name}_part_{number}")))
            .collect();
        let upper = name.to_ascii_uppercase();
        let independent = names.take(&format!("{upper}_INDEPENDENT"));
        let apart = names.take(&format!("{upper}_APART"));
        let aligned = names.take(&format!("{upper}_ALIGNED"));
        let work = names.take("w");
        let constants = names.take("numbers");
        let mut list = |prefix: &str, count: usize| -> Vec<String> {
            (0..count)
                .map(|number| names.take(&format!("{prefix}{number}")))
                .collect()
        };
        let tables = list("table", program.tables.len());
        let carried = list("last", program.carried.len());
        let indices = list("i", program.loops.len());
        let counters = list("pass", program.loops.len());
        let variables = list("x", program.codes.len());
        let vector = options.circular == RolledCircular::Vector;
        let circular = program.loops.iter().any(|place| place.circular);
        let kernel = (vector && circular).then(|| SineKernel::widest(options.real));
        RolledWriter {
            function,
            program,
            real: options.real,
            kernel,
            name,
            inputs,
            outputs,
            work,
            constants,
            tables,
            variables,
            carried,
            indices,
            counters,
            parts,
            independent,
            apart,
            aligned,
        }
    }

    fn comment(&self) -> String {
        format!(
            "/* {} by robovec, rolled. Arrays count from 1; element 0 is not used.\n   \
             No two of the arrays may overlap.\n{}*/\n",
            self.name,
            frame::boundaries(self.function)
        )
    }

    fn header(&self) -> String {
        frame::header(&self.comment(), &self.name, None, &self.declared())
    }

    fn declared(&self) -> String {
        format!("void {}({})", self.name, self.parameters(None).declared())
    }

    fn source(&self) -> String {
        let mut text = self.comment();
        match self.kernel {
            Some(kernel) => text.push_str(&kernel.types()),
            None => text.push_str("#include <math.h>\n"),
        }
        text.push('\n');
        self.macros(&mut text);
        if let Some(kernel) = self.kernel {
            text.push('\n');
            text.push_str(&kernel.arrays());
        }
        self.data(&mut text);
        let mut calls = String::new();
        let mut start = 0;
        while start < self.program.items.len() {
            let part = self.program.parts[start];
            let parts = &self.program.parts[start..];
            let end = start + parts.partition_point(|&other| other == part);
            let used = self.used(start..end);
            let name = &self.parts[part as usize - 1];
            let mut body = String::new();
            self.part(&mut body, start..end);
            let list = self.parameters(Some(&used));
            let head = format!("\n{} static void {name}", self.apart);
            text += &list.definition(&head, &body);
            let _ = writeln!(calls, "    {name}({});", list.arguments());
            start = end;
        }
        let everything = self.used(0..self.program.items.len());
        let mut work = String::new();
        if everything.work {
            let (real, words) = (self.real.name(), self.program.work);
            let _ = writeln!(work, "    {} {real} {}[{words}];", self.aligned, self.work);
        }
        let list = self.parameters(None);
        text + &list.definition(&format!("\nvoid {}", self.name), &(work + &calls))
    }

    fn macros(&self, text: &mut String) {
        let (independent, apart, aligned) = (&self.independent, &self.apart, &self.aligned);
        let _ = write!(
            text,
            "#if defined(__GNUC__) && !defined(__clang__)\n\
             #define {independent} _Pragma(\"GCC ivdep\")\n\
             #else\n\
             #define {independent}\n\
             #endif\n\
             #if defined(__GNUC__)\n\
             #define {apart} __attribute__((noinline))\n\
             #define {aligned} __attribute__((aligned(64)))\n\
             #else\n\
             #define {apart}\n\
             #define {aligned}\n\
             #endif\n"
        );
    }

    fn data(&self, text: &mut String) {
        if !self.program.constants.is_empty() {
            let numbers = self.program.constants.iter();
            let numbers: Vec<String> = numbers
                .map(|&number| literal(number, self.real).text)
                .collect();
            let real = self.real.name();
            self.list(
                text,
                &format!("static const {real} {}", self.constants),
                &numbers,
            );
        }
        assert_eq!(
            self.program.tables.len(),
            self.tables.len(),
            "every table has a name"
        );
        for (table, name) in self.program.tables.iter().zip(&self.tables) {
            let kind = if table.iter().all(|&entry| entry <= u32::from(u16::MAX)) {
                "unsigned short"
            } else {
                "unsigned int"
            };
            let entries: Vec<String> = table.iter().map(u32::to_string).collect();
            self.list(text, &format!("static const {kind} {name}"), &entries);
        }
    }

    fn list(&self, text: &mut String, declaration: &str, entries: &[String]) {
        let _ = write!(text, "\n{declaration}[{}] = {{", entries.len());
        for line in entries.chunks(12) {
            let _ = write!(text, "\n    {},", line.join(", "));
        }
        text.push_str("\n};\n");
    }

    /// The parameters of the function, or of a part with the arrays it uses.
    ///
    /// None of them is `restrict`: with it gcc 12 vectorises some loops into
    /// code that stores wrong numbers (seen on a program of 18,764 operations,
    /// right without optimisation), and independent loops state it themselves.
    fn parameters(&self, used: Option<&Used>) -> ParameterList {
        let mut list = ParameterList::default();
        let function = self.function;
        for (arrays, names, used, is_output) in [
            (
                function.inputs(),
                &self.inputs,
                used.map(|used| &used.inputs),
                false,
            ),
            (
                function.outputs(),
                &self.outputs,
                used.map(|used| &used.outputs),
                true,
            ),
        ] {
            assert_eq!(arrays.len(), names.len(), "every array has a name");
            for (number, (array, name)) in arrays.iter().zip(names).enumerate() {
                if used.is_none_or(|used| used[number]) {
                    let shape = array.shape;
                    let declared = parameter(self.real, name, shape, is_output, Rows::Pointer);
                    list.push(declared, name);
                }
            }
        }
        if used.is_some_and(|used| used.work) {
            list.add(&format!("{} *", self.real.name()), &self.work);
        }
        list
    }

    /// The arrays that a stretch of the program touches.
    fn used(&self, range: std::ops::Range<usize>) -> Used {
        let mut used = Used {
            inputs: vec![false; self.inputs.len()],
            outputs: vec![false; self.outputs.len()],
            work: false,
        };
        let mut space = |space: StorageSpace| match space {
            StorageSpace::Work => used.work = true,
            StorageSpace::Input(array) => used.inputs[array] = true,
            StorageSpace::Output(array) => used.outputs[array] = true,
            StorageSpace::Constants => {}
        };
        let program = self.program;
        for (top, copy) in self.copies(range.clone()) {
            assert!(range.contains(&top));
            space(StorageSpace::Work);
            space(copy.space);
        }
        let mut elements = Vec::new();
        for &item in &program.items[range] {
            program.below(item, &mut elements);
        }
        let mut source = |source: &LeafSource| {
            if let LeafSource::Place(place) = source {
                space(place.space);
            }
        };
        for &element in &elements {
            match element {
                BodyElement::Position(position) => {
                    program.codes[position].sources.iter().for_each(&mut source);
                }
                BodyElement::Loop(number) => {
                    for &carried in &program.carries[number] {
                        source(&program.carried[carried].first);
                    }
                }
            }
        }
        for element in elements {
            if let BodyElement::Position(position) = element {
                for store in &program.codes[position].stores {
                    space(store.space);
                }
            }
        }
        used
    }

    fn copies(&self, range: std::ops::Range<usize>) -> impl Iterator<Item = (usize, Copy)> + '_ {
        let all = &self.program.copies;
        let start = all.partition_point(|&(top, _)| top < range.start);
        let end = all.partition_point(|&(top, _)| top < range.end);
        all[start..end].iter().copied()
    }

    fn part(&self, text: &mut String, range: std::ops::Range<usize>) {
        let mut elements = Vec::new();
        for &item in &self.program.items[range.clone()] {
            self.program.below(item, &mut elements);
        }
        for element in elements {
            if let BodyElement::Loop(number) = element
                && self.program.loops[number].counted
            {
                let _ = writeln!(text, "    long {} = 0;", self.counters[number]);
            }
        }
        for top in range {
            for (_, copy) in self.copies(top..top + 1) {
                self.copy(text, copy);
            }
            self.element(text, self.program.items[top], 1);
        }
    }

    fn copy(&self, text: &mut String, copy: Copy) {
        let index = |base: i64, step: i64| match (base, step) {
            (base, 0) => base.to_string(),
            (base, step) => format!("{base} + {step} * copied"),
        };
        let [row, column] = [0, 1].map(|axis| index(copy.from[axis], copy.step[axis]));
        let from = self.at(copy.space, &row, &column);
        let to = self.at(StorageSpace::Work, "", &index(copy.to, copy.advance));
        if copy.count == 1 {
            let _ = writeln!(text, "    {to} = {from};");
        } else {
            let _ = writeln!(
                text,
                "    for (long copied = 0; copied < {}; copied++)\n        {to} = {from};",
                copy.count
            );
        }
    }

    /// Writes an element of a body. Loops nest a few deep, which bounds the
    /// recursion.
    fn element(&self, text: &mut String, element: BodyElement, depth: usize) {
        let number = match element {
            BodyElement::Position(position) => return self.statement(text, position, depth),
            BodyElement::Loop(number) => number,
        };
        let indent = "    ".repeat(depth);
        let place = &self.program.loops[number];
        if let Some(call) = self.circles(number) {
            let _ = writeln!(text, "{indent}{call}");
            return;
        }
        let real = self.real.name();
        for &carried in &self.program.carries[number] {
            let first = self.source_text(&self.program.carried[carried].first).text;
            let name = &self.carried[carried];
            let _ = writeln!(text, "{indent}{real} {name} = {first};");
        }
        if place.independent {
            let _ = writeln!(text, "{indent}{}", self.independent);
        }
        let (index, count) = (&self.indices[number], self.index(&place.count));
        let _ = writeln!(
            text,
            "{indent}for (long {index} = 0; {index} < {count}; {index}++) {{"
        );
        for &inner in &place.body {
            self.element(text, inner, depth + 1);
        }
        for &carried in &self.program.carries[number] {
            let result = &self.variables[self.program.carried[carried].position];
            let _ = writeln!(text, "{indent}    {} = {result};", self.carried[carried]);
        }
        if place.counted {
            let _ = writeln!(text, "{indent}    {}++;", self.counters[number]);
        }
        let _ = writeln!(text, "{indent}}}");
    }

    /// The call that computes the loop of sines and cosines, if the kernel
    /// is wanted.
    fn circles(&self, number: usize) -> Option<String> {
        let kernel = self.kernel?;
        let place = &self.program.loops[number];
        let (&[BodyElement::Position(sine), BodyElement::Position(cosine)], true) =
            (place.body.as_slice(), place.circular)
        else {
            return None;
        };
        let start = |place: &SpaceElement| {
            let column = &place.column;
            let steps = column.factors == [(number, 1)] && column.table.is_none();
            (steps && place.row.factors.is_empty() && place.row.table.is_none()).then(|| {
                let (row, column) = (place.row.base.to_string(), column.base.to_string());
                format!("&{}", self.at(place.space, &row, &column))
            })
        };
        let stored = |position: usize| match self.program.codes[position].stores.as_slice() {
            [store] => start(store),
            _ => None,
        };
        let angles = match self.program.codes[sine].sources.as_slice() {
            [LeafSource::Place(place)] => start(place),
            _ => None,
        };
        Some(format!(
            "{}({}, {}, {}, {});",
            kernel.arrays_name(),
            self.index(&place.count),
            angles?,
            stored(sine)?,
            stored(cosine)?
        ))
    }

    fn statement(&self, text: &mut String, position: usize, depth: usize) {
        let indent = "    ".repeat(depth);
        let code = &self.program.codes[position];
        let expression = self.expression(position);
        let is_copy = self.program.templates[code.template as usize].operations() == 0;
        if is_copy {
            for store in &code.stores {
                let _ = writeln!(text, "{indent}{} = {expression};", self.place(store));
            }
            return;
        }
        let (real, variable) = (self.real.name(), &self.variables[position]);
        let _ = writeln!(text, "{indent}const {real} {variable} = {expression};");
        for store in &code.stores {
            let _ = writeln!(text, "{indent}{} = {variable};", self.place(store));
        }
    }
}
