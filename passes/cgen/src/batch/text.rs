//! The source and the header.

use super::driver;
use super::plan::{AngleGroup, BatchItem, OperandPlace};
use super::writer::BatchWriter;
use crate::emit::Real;
use crate::emit::arrays::{extent, place};
use crate::emit::expression::{BoundText, Operands, apply, lane_literal};
use crate::emit::frame::{self, APART, ParameterList};
use crate::emit::order::CodeStep;
use robovec_ir::{Operand, Operation, Value};
use std::fmt::Write;

/// The first lines of the source.
const HEAD: &str = include_str!("head.c");

/// The function for square roots of all lanes.
const ROOT: &str = "\
static inline void robovec_root(const @vector@ *of, @vector@ *root)
{
#if @width@
    for (int lane = 0; lane < @width@; lane++)
        (*root)[lane] = @root@((*of)[lane]);
#else
    *root = @root@(*of);
#endif
}

";

/// The same for one lane.
const ROOT_OF_ONE: &str = "\
static inline void robovec_root(const @vector@ *of, @vector@ *root)
{
    *root = @root@(*of);
}

";

impl BatchWriter<'_> {
    /// The header, with the contract.
    pub(super) fn header(&self) -> String {
        let name = &self.names.function;
        assert_eq!(
            self.names.inputs.len(),
            self.plan.shared.len(),
            "every input array is shared or not"
        );
        let shared = self.names.inputs.iter().zip(&self.plan.shared);
        let shared: Vec<&str> = shared
            .filter(|(_, shared)| **shared)
            .map(|(name, _)| name.as_str())
            .collect();
        let shared = if shared.is_empty() {
            format!("\n   {name}_prepare fills numbers that are the same for all states, once.\n")
        } else {
            format!(
                "\n   The same for all states, one number per element: {}.
   {name}_prepare computes what depends on nothing else, once; _many and _states call it.\n",
                shared.join(", ")
            )
        };
        let inputs = self.function().inputs().iter().zip(&self.names.inputs);
        let outputs = self.function().outputs().iter().zip(&self.names.outputs);
        let size = |(array, own)| format!("#define {name}_SIZE_{own} {}\n", extent(array));
        let declaration = |(returns, own, list)| format!("{returns} {own}({list});\n\n");
        let declarations = driver::signatures(self).into_iter().map(declaration);
        self.fill(
            include_str!("batch.h"),
            &[
                ("shared", &shared),
                ("boundaries", &frame::boundaries(self.function())),
                ("upper", &name.to_ascii_uppercase()),
                ("prepared", &self.plan.prepared.len().max(1)),
                (
                    "sizes",
                    &inputs.chain(outputs).map(size).collect::<String>(),
                ),
                ("declarations", &declarations.collect::<String>()),
            ],
        )
    }

    pub(super) fn source(&self) -> String {
        let runs = match self.plan.angles {
            0 => String::new(),
            _ => format!("\n{}", self.kernel.runs()),
        };
        let mut text = self.fill(
            HEAD,
            &[
                ("types", &self.kernel.types()),
                ("runs", &runs),
                ("unaligned", &self.kernel.unaligned()),
                ("apart", &APART),
                ("root_function", &self.root()),
            ],
        );
        text += &self.prepare();
        for number in 0..self.plan.parts.len() {
            self.part(&mut text, number);
        }
        self.lanes(&mut text);
        text += &driver::functions(self);
        text
    }

    /// Square roots of all lanes, where there are any.
    fn root(&self) -> String {
        let roots = self.function().values().any(|(value, node)| {
            node.operation == Operation::Sqrt && !self.plan.uniform[value.index()]
        });
        let root = match self.options.real {
            Real::Double => "sqrt",
            Real::Float => "sqrtf",
        };
        match (roots, self.options.lanes) {
            (false, _) => String::new(),
            (true, 1) => self.fill(ROOT_OF_ONE, &[("root", &root)]),
            (true, _) => self.fill(ROOT, &[("root", &root)]),
        }
    }

    /// The parameters of the parts: inputs that differ, outputs, and the
    /// arrays between parts.
    fn part_list(&self) -> ParameterList {
        let real = self.options.real.name();
        let vector = self.kernel.vector();
        let [numbers, reads, writes] = [
            format!("const {real} *restrict "),
            format!("const {vector} *restrict "),
            format!("{vector} *restrict "),
        ];
        let mut list = ParameterList::default();
        self.add_inputs(&mut list, &[false], "restrict ");
        self.add_outputs(&mut list, "restrict ");
        if !self.plan.prepared.is_empty() {
            list.add(&numbers, "prepared");
        }
        if self.plan.angles > 0 {
            list.add(&reads, "sines");
            list.add(&reads, "cosines");
        }
        if self.plan.has_computed_angles() {
            list.add(&writes, "angles");
        }
        list.add(&writes, "work");
        list
    }

    fn part(&self, text: &mut String, number: usize) {
        let vector = self.kernel.vector();
        let crossing = &self.plan.crossing;
        let mut body = String::new();
        for &value in &crossing.loads[number] {
            let word = crossing.word(value);
            let word = word.expect("a value that is loaded has a word");
            let name = &self.names.values[value.index()];
            let _ = writeln!(body, "    const {vector} {name} = work[{word}];");
        }
        for &step in &self.plan.parts[number] {
            match step {
                CodeStep::Define(value) => self.define(&mut body, value),
                CodeStep::Assign(index) => self.assign(&mut body, index),
            }
        }
        let number = number + 1;
        let head = format!(
            "static ROBOVEC_APART void {}_part_{number}",
            self.names.function
        );
        *text += &self.part_list().definition(&head, &body);
        text.push('\n');
    }

    fn define(&self, text: &mut String, value: Value) {
        let vector = self.kernel.vector();
        let node = self.function().node(value);
        let name = &self.names.values[value.index()];
        let operands: Vec<BoundText> = node
            .operands()
            .iter()
            .map(|&operand| self.operand(operand))
            .collect();
        if node.operation == Operation::Sqrt {
            let _ = writeln!(
                text,
                "    {vector} {name} = {};\n    robovec_root(&{name}, &{name});",
                operands[0].text
            );
        } else {
            let real = self.options.real;
            let expression = apply(node.operation, &operands, real, Operands::Lanes).text;
            let _ = writeln!(text, "    const {vector} {name} = {expression};");
        }
        if let Some(word) = self.plan.crossing.word(value) {
            let _ = writeln!(text, "    work[{word}] = {name};");
        }
        if let Some(angle) = self.plan.angle(value) {
            let _ = writeln!(text, "    angles[{angle}] = {name};");
        }
    }

    fn assign(&self, text: &mut String, index: u32) {
        let assignment = &self.function().assignments[index as usize];
        let (array, _, _) = self.function().output_element(assignment.output);
        let name = &self.names.outputs[self.function().output_array(assignment.output)];
        let element = place(array, assignment.output.0 - array.offset);
        let operand = self.operand(assignment.operand).text;
        let spread = match self.plan.place(self.function(), assignment.operand) {
            OperandPlace::Prepared(_) | OperandPlace::Literal(_) => {
                format!("({}){{0}} + ", self.kernel.vector())
            }
            OperandPlace::Variable(_) | OperandPlace::Circular(..) | OperandPlace::Input(_) => {
                String::new()
            }
        };
        let _ = writeln!(text, "    OUT({name}, {element}) = {spread}{operand};");
    }

    fn operand(&self, operand: Operand) -> BoundText {
        let text = match self.plan.place(self.function(), operand) {
            OperandPlace::Variable(value) => self.names.values[value.index()].clone(),
            OperandPlace::Circular(Operation::Sin, angle) => format!("sines[{angle}]"),
            OperandPlace::Circular(_, angle) => format!("cosines[{angle}]"),
            OperandPlace::Prepared(place) => format!("prepared[{place}]"),
            OperandPlace::Literal(number) => return lane_literal(number, self.options.real),
            OperandPlace::Input(input) => {
                let index = self.function().input_array(input);
                let array = &self.function().inputs()[index];
                let element = place(array, input.0 - array.offset);
                format!("IN({}, {element})", self.names.inputs[index])
            }
        };
        BoundText::primary(text)
    }

    /// The function that calls kernel and parts in turn.
    fn lanes(&self, text: &mut String) {
        let name = &self.names.function;
        let vector = self.kernel.vector();
        let parameters = self.batch_list().declared();
        let _ = write!(text, "static void {name}_lanes({parameters})\n{{\n");
        if self.plan.prepared.is_empty() {
            *text += "    (void)prepared;\n";
        }
        let (count, words) = (self.plan.angles, self.plan.crossing.length.max(1));
        if count > 0 {
            let _ = writeln!(text, "    {vector} sines[{count}], cosines[{count}];");
        }
        if self.plan.has_computed_angles() {
            let _ = writeln!(text, "    {vector} angles[{count}];");
        }
        let _ = writeln!(text, "    {vector} work[{words}];");
        let list = self.part_list();
        let arguments = list.arguments();
        for item in &self.plan.items {
            match item {
                BatchItem::Part(number) => {
                    let _ = writeln!(text, "    {name}_part_{}({arguments});", number + 1);
                }
                BatchItem::Circular(group) => self.circular(text, group),
            }
        }
        if self.plan.parts.is_empty() {
            let own = ["prepared", "sines", "cosines", "angles"];
            *text += &frame::unused(list.names().filter(|name| !own.contains(name)), "");
        }
        *text += "}\n\n";
    }

    fn circular(&self, text: &mut String, group: &AngleGroup) {
        let (first, count) = (group.first, group.angles.len());
        let function = self.function();
        let places = group.angles.iter().zip(first..).map(|(angle, number)| {
            let place = match angle.input() {
                Some(input) => {
                    let array = &function.inputs()[function.input_array(input)];
                    place(array, input.0 - array.offset)
                }
                None => u64::from(number),
            };
            place.to_string()
        });
        let places = places.collect::<Vec<_>>().join(", ");
        for (&angle, number) in group.angles.iter().zip(first..) {
            if let OperandPlace::Circular(..) = self.plan.place(function, angle) {
                let _ = writeln!(text, "    angles[{number}] = {};", self.operand(angle).text);
            }
        }
        let real = self.options.real.name();
        let (from, stride) = match group.array {
            Some(array) => (
                self.names.inputs[array].clone(),
                self.options.lanes.to_string(),
            ),
            None => (
                format!("(const {real} *)angles"),
                format!("(long)(sizeof(angles[0]) / sizeof({real}))"),
            ),
        };
        let _ = writeln!(
            text,
            "    {{\n        static const int places[] = {{{places}}};\n        \
             {}({count}, {from}, places, {stride}, sines + {first}, cosines + {first});\n    }}",
            self.kernel.runs_name()
        );
    }
}
