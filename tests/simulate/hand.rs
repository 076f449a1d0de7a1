//! A program placed by hand, and a way to edit its images.
//!
//! On one adder and two multipliers of the thesis' machine:
//!
//! ```text
//! preload add0[0] = a, add0[1] = b, multi0[0] = b
//! %x = a + b   on add0 at 0    read 0 1  buffer 0  write multi0[1] at 11, add0[2] at 13
//! %y = %x*b    on multi0 at 12 read 1 0            write add0[3] at 18
//! %z = %x - %y on add0 at 19   read 2 3            write add0[4] at 30
//! out[1] = %z in add0[4], out[2] = %y in add0[3]
//! ```

use robovec::simulate::mif::Image;
use robovec::simulate::{Hazard, LoadError, LoadedProgram};
use robovec_fpga::images;
use robovec_fpga::manifest::Manifest;
use robovec_ir::placement::{
    Address, Bank, BufferWord, Element, ElementKind, Placement, Preload, Schedule, Slot, Word,
    Write,
};
use robovec_ir::{
    Assignment, Function, Input, Level, Machine, Module, Name, Node, Operand, Operation, Output,
    Shape, SourceSet,
};
use std::fmt::Write as _;

pub(crate) const ADD0: u32 = 0;
pub(crate) const MULTI0: u32 = 1;

pub(crate) fn word(element: u32, address: u32) -> Word {
    Word {
        element: Element::new(element),
        bank: Bank::Unified,
        address: Address::new(address),
    }
}

fn write(element: u32, address: u32, cycle: u32) -> Write {
    Write {
        word: word(element, address),
        cycle,
    }
}

/// The atomic function, without its placement.
fn function(module: &mut Module) -> Function {
    let mut function = Function::new("hand", Level::Placed);
    let symbols = &mut module.tables.symbols;
    function.add_input(symbols.intern("a"), Shape::Scalar);
    function.add_input(symbols.intern("b"), Shape::Scalar);
    function.add_output(symbols.intern("out"), Shape::Vector(2));
    let names = ["x", "y", "z"].map(|name| Name::plain(symbols.intern(name)));
    let (a, b) = (Input(0), Input(1));
    let node = |name, operation, operands| Node {
        name,
        sources: SourceSet::EMPTY,
        operands,
        operation,
    };
    let x = function.push(node(
        names[0],
        Operation::Add,
        Operand::list([a.into(), b.into()]),
    ));
    let y = function.push(node(
        names[1],
        Operation::Mul,
        Operand::list([x.into(), b.into()]),
    ));
    let z = function.push(node(
        names[2],
        Operation::Sub,
        Operand::list([x.into(), y.into()]),
    ));
    function.assignments = [z, y]
        .into_iter()
        .enumerate()
        .map(|(index, value)| Assignment {
            output: Output(index as u32),
            operand: value.into(),
            sources: SourceSet::EMPTY,
        })
        .collect();
    function
}

/// The placed module.
pub(crate) fn module() -> Module {
    let mut module = Module::new();
    let mut function = function(&mut module);
    let slot = |cycle, element| {
        let element = Element::new(element);
        Some(Slot { cycle, element })
    };
    let kind = |name: &str, count| ElementKind {
        name: name.to_owned(),
        count,
    };
    let preload = |element, address, input| Preload {
        word: word(element, address),
        operand: Input(input).into(),
    };
    function.schedule = Some(Schedule {
        machine: "thesis".to_owned(),
        machine_hash: None,
        kinds: vec![kind("add", 1), kind("multi", 2)],
        slots: vec![slot(0, ADD0), slot(12, MULTI0), slot(19, ADD0)],
        cycles: 31,
        lower_bound: 31,
    });
    function.placement = Some(Placement {
        preloads: vec![
            preload(ADD0, 0, 0),
            preload(ADD0, 1, 1),
            preload(MULTI0, 0, 1),
        ],
        reads: [[0, 1], [1, 0], [2, 3]]
            .map(|[left, right]| [Some(Address::new(left)), Some(Address::new(right)), None])
            .to_vec(),
        buffers: vec![Some(BufferWord::new(0)), None, None],
        write_starts: vec![0, 2, 3, 4],
        writes: vec![
            write(MULTI0, 1, 11),
            write(ADD0, 2, 13),
            write(ADD0, 3, 18),
            write(ADD0, 4, 30),
        ],
        homes: vec![Some(word(ADD0, 4)), Some(word(ADD0, 3))],
    });
    module.functions.push(function);
    module
}

/// Images that can be edited field by field.
pub(crate) struct Edited {
    pub(crate) files: Vec<(String, String)>,
    pub(crate) manifest: Manifest,
    pub(crate) machine: Machine,
}

impl Edited {
    pub(crate) fn new() -> Edited {
        let machine = Machine::built_in("thesis").expect("it ships");
        let files = images(super::view(&module()), &machine, None).expect("it has images");
        let (_, text) = files.last().expect("the manifest");
        let manifest = serde_json::from_str(text).expect("it is JSON");
        Edited {
            files,
            manifest,
            machine,
        }
    }

    pub(crate) fn file(&mut self, suffix: &str) -> &mut String {
        let mut files = self.files.iter_mut();
        let found = files.find(|(name, _)| name.ends_with(suffix));
        &mut found.expect("there is such a file").1
    }

    /// Sets one field of one instruction word.
    pub(crate) fn set(&mut self, element: &str, cycle: u32, field: &str, content: u32) {
        let described = self.manifest.elements.iter().find(|e| e.name == element);
        let fields = &described.expect("an element").instructions.fields;
        let field = fields.iter().find(|known| known.name == field);
        let field = field.expect("a field").clone();
        assert!(content < 1 << field.width, "{content} does not fit");
        let text = self.file(&format!("{element}.instructions.mif"));
        let image = Image::parse(text).expect("it is an image");
        let mut words: Vec<u64> = (0..image.depth())
            .map(|cycle| image.word(cycle)[0])
            .collect();
        let mask = ((1 << field.width) - 1) << field.low;
        let word = &mut words[cycle as usize];
        *word = *word & !mask | u64::from(content) << field.low;
        *text = mif(image.width(), &words);
    }

    pub(crate) fn clear(&mut self, element: &str, cycle: u32, fields: &[&str]) {
        for field in fields {
            self.set(element, cycle, field, 0);
        }
    }

    pub(crate) fn load(&self) -> Result<LoadedProgram, LoadError> {
        let mut files = self.files.clone();
        let text = serde_json::to_string(&self.manifest).expect("it is JSON");
        files.last_mut().expect("the manifest").1 = text;
        LoadedProgram::load_edited(&files, &self.machine)
    }

    pub(crate) fn hazard(&self) -> Hazard {
        let program = self.load().expect("it can be loaded");
        program.run(&[1.5, 0.25]).expect_err("a hazard is planted")
    }
}

/// An image of words of at most 64 bits.
pub(crate) fn mif(width: u32, words: &[u64]) -> String {
    let mut text = format!(
        "WIDTH={width};DEPTH={};ADDRESS_RADIX=DEC;DATA_RADIX=HEX;CONTENT BEGIN\n",
        words.len()
    );
    for (address, word) in words.iter().enumerate() {
        writeln!(text, "{address}:{word:X};").expect("a string");
    }
    text + "END;\n"
}
