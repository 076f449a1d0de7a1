//! Memory images of a placed function.

use super::ImageError;
use super::binding::PreloadBinding;
use super::hex::HexWriter;
use super::layout::{Sizes, WordLayout};
use super::manifest::{self, Manifest};
use super::mif::MifWriter;
use super::traffic::Traffic;
use super::words::NonzeroWords;
use robovec_framework::pass::Artifact;
use robovec_ir::placement::{Bank, Element, Preload};
use robovec_ir::{Format, Machine, View};
use robovec_num::fnv::Fnv;
use robovec_num::soft_float::FormatArithmetic;
use robovec_num::trigonometry::host::KEY;
use serde::Serialize;
use std::io;

/// A function that writes the content of a file.
pub type FileContent<'a> = &'a mut dyn FnMut(&mut dyn io::Write) -> io::Result<()>;

/// The receiver of generated files.
pub trait Artifacts {
    /// Takes one file: its name, and a function that writes its content.
    ///
    /// # Errors
    ///
    /// Hashes of the content and of its destination.
    fn file(&mut self, name: &str, content: FileContent<'_>) -> io::Result<()>;
}

/// Files kept in memory: name and text.
impl Artifacts for Vec<(String, String)> {
    fn file(&mut self, name: &str, content: FileContent<'_>) -> io::Result<()> {
        let mut bytes = Vec::new();
        content(&mut bytes)?;
        let text = String::from_utf8(bytes).map_err(io::Error::other)?;
        self.push((name.to_owned(), text));
        Ok(())
    }
}

/// Files that a pass gives.
impl Artifacts for Vec<Artifact> {
    fn file(&mut self, name: &str, content: FileContent<'_>) -> io::Result<()> {
        let mut files: Vec<(String, String)> = Vec::new();
        files.file(name, content)?;
        self.extend(
            files
                .into_iter()
                .map(|(name, text)| Artifact { name, text }),
        );
        Ok(())
    }
}

/// The memory images of a placed function, as (file name, text); file names
/// start with the function's name and a dot. With `inputs`, one number per
/// input element, the data images hold all initial data; without, constants
/// only, and the rest as comments.
///
/// # Errors
///
/// Fails when the function is not placed on this machine, or the placement
/// cannot be expressed in the machine's instruction words; see [`ImageError`].
pub fn images(
    view: View<'_>,
    machine: &Machine,
    inputs: Option<&[f64]>,
) -> Result<Vec<(String, String)>, ImageError> {
    let mut files = Vec::new();
    write_images(view, machine, inputs, &mut files)?;
    Ok(files)
}

/// As [`images`], written file by file into `artifacts`; the manifest comes
/// last, so that it is only beside complete images. Needs memory for an index
/// of the placement, whatever the length of the files.
///
/// # Errors
///
/// As [`images`], and those of `artifacts`.
pub fn write_images(
    view: View<'_>,
    machine: &Machine,
    inputs: Option<&[f64]>,
    artifacts: &mut dyn Artifacts,
) -> Result<(), ImageError> {
    let traffic = Traffic::new(view, machine)?;
    write_traffic(&traffic, inputs, None, artifacts)
}

/// The hardware that images are made for.
pub(super) struct ImageHardware {
    /// The sizes that lay out the instruction words.
    pub(super) sizes: Sizes,
    /// Words of the instruction memories as built.
    pub(super) instruction_depth: u32,
    /// The addresses at which the host finds everything.
    pub(super) window: manifest::AddressMap,
}

/// The images of a program whose traffic is sorted; with hardware, those
/// that this hardware takes: its sizes instead of the program's, a `.hex`
/// file beside every `.mif` file, and the addresses of the host's window in
/// the manifest. The hardware must have room for the program.
pub(super) fn write_traffic(
    traffic: &Traffic<'_>,
    inputs: Option<&[f64]>,
    hardware: Option<&ImageHardware>,
    artifacts: &mut dyn Artifacts,
) -> Result<(), ImageError> {
    let (view, machine) = (traffic.view, traffic.machine);
    check_formats(view, machine)?;
    let format = machine.number;
    if !format.is_possible() {
        let message = format!("there is no arithmetic in the machine's format, {format}");
        return Err(ImageError::Number(message));
    }
    let arithmetic = FormatArithmetic::new(format);
    let binding = PreloadBinding::new(traffic)?;
    let loaded = binding.loaded(&arithmetic, inputs)?;
    let writer = ImageWriter {
        sizes: match hardware {
            Some(hardware) => hardware.sizes.clone(),
            None => Sizes::new(machine, &traffic.usage),
        },
        traffic,
        width: format.width(),
        hardware,
    };
    let mut artifacts = Hashed {
        artifacts,
        files: Vec::new(),
    };
    let mut hash = Fnv::new();
    let mut elements = Vec::new();
    for element in traffic.elements() {
        let layout = writer.layout(element);
        hash = writer.instruction_image(element, &layout, hash, &mut artifacts)?;
        writer.data_images(element, &loaded, &mut artifacts)?;
        elements.push(writer.element(element, &layout));
    }
    let manifest = Manifest {
        robovec: env!("CARGO_PKG_VERSION").to_owned(),
        format: manifest::FORMAT,
        function: view.function.name.clone(),
        machine: manifest::MachineIdentity {
            name: machine.name.clone(),
            hash: machine.content_hash().text(),
        },
        number: machine.number,
        schedule_hash: hash.text(),
        cycles: writer.depth(),
        files: artifacts.files,
        elements,
        sources: writer.sources(),
        inputs: binding.inputs(),
        constants: binding.constants(),
        host: binding.host()?,
        trigonometry: view.function.metadata(KEY).map(str::to_owned),
        outputs: binding.outputs()?,
        window: hardware.map(|hardware| hardware.window.clone()),
    };
    let artifacts = artifacts.artifacts;
    artifacts.file(&writer.file_name("manifest.json"), &mut |target| {
        write_manifest(target, &manifest)
    })?;
    Ok(())
}

/// Takes note of every file that passes through.
struct Hashed<'a> {
    artifacts: &'a mut dyn Artifacts,
    files: Vec<manifest::FileHash>,
}

impl Artifacts for Hashed<'_> {
    fn file(&mut self, name: &str, content: FileContent<'_>) -> io::Result<()> {
        let mut hash = Fnv::new();
        self.artifacts.file(name, &mut |target| {
            hash = Fnv::new();
            content(&mut HashedWriter {
                target,
                hash: &mut hash,
            })
        })?;
        self.files.push(manifest::FileHash {
            file: name.to_owned(),
            hash: hash.text(),
        });
        Ok(())
    }
}

/// Hashes the written bytes.
struct HashedWriter<'a> {
    target: &'a mut dyn io::Write,
    hash: &'a mut Fnv,
}

impl io::Write for HashedWriter<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.target.write(bytes)?;
        self.hash.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.target.flush()
    }
}

/// All elements compute in the machine's format, so no value may have another.
fn check_formats(view: View<'_>, machine: &Machine) -> Result<(), ImageError> {
    let own = machine.number;
    match foreign_format(view, own) {
        None => Ok(()),
        Some((value, format)) => Err(ImageError::Format {
            value,
            format,
            machine: own,
        }),
    }
}

/// The first value with another format than `own`, and that format.
pub fn foreign_format(view: View<'_>, own: Format) -> Option<(String, Format)> {
    let formats = view.function.formats.as_ref()?;
    let mut values = view.function.values();
    values.find_map(|(value, node)| {
        let format = formats.get(value).filter(|format| *format != own)?;
        let name = node.name.display(&view.tables.symbols).to_string();
        Some((name, format))
    })
}

/// The `.hex` file beside a `.mif` file.
fn hex_name(mif: &str) -> String {
    let stem = mif.strip_suffix("mif");
    stem.expect("images of memories are .mif files").to_owned() + "hex"
}

/// One list element per line: readable, and short enough to compare.
fn write_manifest(target: &mut dyn io::Write, manifest: &Manifest) -> io::Result<()> {
    fn list<T: Serialize>(
        target: &mut dyn io::Write,
        name: &str,
        items: &[T],
        last: bool,
    ) -> io::Result<()> {
        write!(target, "  \"{name}\": [")?;
        for (index, item) in items.iter().enumerate() {
            let comma = if index == 0 { "" } else { "," };
            write!(target, "{comma}\n    {}", serde_json::to_string(item)?)?;
        }
        let (end, comma) = (
            if items.is_empty() { "" } else { "\n  " },
            if last { "" } else { "," },
        );
        writeln!(target, "{end}]{comma}")
    }
    fn scalar<T: Serialize>(target: &mut dyn io::Write, name: &str, item: &T) -> io::Result<()> {
        writeln!(target, "  \"{name}\": {},", serde_json::to_string(item)?)
    }
    writeln!(target, "{{")?;
    scalar(target, "robovec", &manifest.robovec)?;
    scalar(target, "format", &manifest.format)?;
    scalar(target, "function", &manifest.function)?;
    scalar(target, "machine", &manifest.machine)?;
    scalar(target, "number", &manifest.number)?;
    scalar(target, "schedule_hash", &manifest.schedule_hash)?;
    scalar(target, "cycles", &manifest.cycles)?;
    list(target, "files", &manifest.files, false)?;
    list(target, "elements", &manifest.elements, false)?;
    list(target, "sources", &manifest.sources, false)?;
    list(target, "inputs", &manifest.inputs, false)?;
    list(target, "constants", &manifest.constants, false)?;
    list(target, "host", &manifest.host, false)?;
    if let Some(name) = &manifest.trigonometry {
        scalar(target, "trigonometry", name)?;
    }
    if let Some(window) = &manifest.window {
        write_window(target, window)?;
    }
    list(target, "outputs", &manifest.outputs, true)?;
    writeln!(target, "}}")
}

/// The window, one memory per line.
fn write_window(target: &mut dyn io::Write, window: &manifest::AddressMap) -> io::Result<()> {
    let head = serde_json::to_string(&manifest::AddressMap {
        units: Vec::new(),
        ..window.clone()
    })?;
    let head = head.strip_suffix("]}");
    let head = head.expect("the list of units is empty and comes last");
    write!(target, "  \"window\": {head}")?;
    for (index, unit) in window.units.iter().enumerate() {
        let comma = if index == 0 { "" } else { "," };
        write!(target, "{comma}\n    {}", serde_json::to_string(unit)?)?;
    }
    writeln!(target, "\n  ]}},")
}

struct ImageWriter<'a> {
    traffic: &'a Traffic<'a>,
    sizes: Sizes,
    /// Bits of a data word.
    width: u32,
    /// The hardware of the images; absent when the machine file alone describes
    /// it.
    hardware: Option<&'a ImageHardware>,
}

impl ImageWriter<'_> {
    /// Words per instruction image: the length of the schedule, and one for an
    /// empty program.
    fn depth(&self) -> u32 {
        self.traffic.schedule.cycles.max(1)
    }

    fn file_name(&self, name: &str) -> String {
        format!("{}.{name}", self.traffic.view.function.name)
    }

    fn instruction_file(&self, element: &str) -> String {
        self.file_name(&format!("{element}.instructions.mif"))
    }

    fn data_file(&self, memory: &str) -> String {
        self.file_name(&format!("{memory}.data.mif"))
    }

    fn layout(&self, element: Element) -> WordLayout {
        let kind = &self.traffic.machine.elements[self.traffic.kinds[element.index()]];
        WordLayout::new(&self.sizes, kind.operations.len(), kind.is_fused())
    }

    fn banks(&self) -> &'static [Bank] {
        if self.sizes.memories == 1 {
            &[Bank::Unified]
        } else {
            &[Bank::Left, Bank::Right]
        }
    }

    /// The sources that the select codes represent: all results, then all
    /// buffers' first read ports, then the second ones ….
    fn sources(&self) -> Vec<String> {
        let elements = self.sizes.elements;
        (0..self.sizes.sources())
            .map(|code| {
                let name = self.traffic.element_name(Element::new(code % elements));
                match (code / elements, self.sizes.buffer) {
                    (0, _) => name,
                    (1, Some((_, 1))) => format!("{name}.buffer"),
                    (port, _) => format!("{name}.buffer.{}", port - 1),
                }
            })
            .collect()
    }

    fn instruction_image(
        &self,
        element: Element,
        layout: &WordLayout,
        hash: Fnv,
        artifacts: &mut dyn Artifacts,
    ) -> Result<Fnv, ImageError> {
        let name = self.traffic.element_name(element);
        let title = self.title(&format!("instructions of {name}"));
        let mut after = hash;
        let file = self.instruction_file(&name);
        artifacts.file(&file, &mut |target| {
            let mut mif = MifWriter::new(target, hash, &title, layout.width(), self.depth())?;
            let mut words = NonzeroWords::new(self.traffic, element, layout);
            let mut next = 0;
            while let Some(cycle) = words.advance() {
                if cycle > next {
                    mif.zeros(next, cycle - 1)?;
                }
                mif.word(cycle, words.word())?;
                next = cycle + 1;
            }
            if next < self.depth() {
                mif.zeros(next, self.depth() - 1)?;
            }
            after = mif.finish()?;
            Ok(())
        })?;
        if let Some(hardware) = self.hardware {
            self.instruction_hex(element, layout, hardware.instruction_depth, artifacts)?;
        }
        Ok(after)
    }

    /// The same words for simulators and synthesis, over the whole memory.
    fn instruction_hex(
        &self,
        element: Element,
        layout: &WordLayout,
        depth: u32,
        artifacts: &mut dyn Artifacts,
    ) -> Result<(), ImageError> {
        let name = self.traffic.element_name(element);
        let title = self.title(&format!("instructions of {name}"));
        let file = hex_name(&self.instruction_file(&name));
        artifacts.file(&file, &mut |target| {
            let mut hex = HexWriter::new(target, &title, layout.width())?;
            let mut words = NonzeroWords::new(self.traffic, element, layout);
            let mut next = 0;
            while let Some(cycle) = words.advance() {
                hex.zeros(cycle - next)?;
                hex.word(words.word())?;
                next = cycle + 1;
            }
            hex.zeros(depth - next)?;
            hex.finish()
        })?;
        Ok(())
    }

    fn data_images(
        &self,
        element: Element,
        loaded: &[(Preload, Option<u64>)],
        artifacts: &mut dyn Artifacts,
    ) -> Result<(), ImageError> {
        for &bank in self.banks() {
            let key = (element, bank);
            let of = |load: &Preload| (load.word.element, load.word.bank);
            let start = loaded.partition_point(|(load, _)| of(load) < key);
            let count = loaded[start..].partition_point(|(load, _)| of(load) == key);
            let own = &loaded[start..start + count];
            let name = self.traffic.memory_name(element, bank);
            let title = self.title(&format!("initial data of {name}"));
            let file = self.data_file(&name);
            artifacts.file(&file, &mut |target| {
                let hash = Fnv::new();
                let mut mif = MifWriter::new(target, hash, &title, self.width, self.sizes.words)?;
                for (load, word) in own {
                    let comment = robovec_ir::print::print_operand(self.traffic.view, load.operand);
                    let address = load.word.address.number();
                    match word {
                        Some(word) => mif.word_with(address, &[*word], &comment)?,
                        None => mif.unknown(address, &comment)?,
                    }
                }
                mif.finish().map(|_| ())
            })?;
            if self.hardware.is_some() {
                artifacts.file(&hex_name(&file), &mut |target| {
                    let mut hex = HexWriter::new(target, &title, self.width)?;
                    let known = own.iter().filter_map(|(load, word)| Some((load, (*word)?)));
                    for (load, word) in known.clone() {
                        hex.word_at(load.word.address.number(), &[word])?;
                    }
                    // Readers complain of a file without any word.
                    if known.count() == 0 {
                        hex.unknown_at(0)?;
                    }
                    hex.finish()
                })?;
            }
        }
        Ok(())
    }

    fn title(&self, what: &str) -> String {
        let function = &self.traffic.view.function.name;
        let machine = &self.traffic.machine.name;
        format!("{what}: function {function} on machine {machine}").replace(['\n', '\r'], " ")
    }

    fn element(&self, element: Element, layout: &WordLayout) -> manifest::ProcessingElement {
        let name = self.traffic.element_name(element);
        let kind = self.traffic.kinds[element.index()];
        let memories = self.banks().iter().map(|&bank| {
            let name = self.traffic.memory_name(element, bank);
            manifest::OperandMemory {
                file: self.data_file(&name),
                name,
                words: self.sizes.words,
                write_ports: self.sizes.write_ports,
            }
        });
        let fields = layout.fields().iter().filter(|field| field.width > 0);
        manifest::ProcessingElement {
            kind: self.traffic.machine.elements[kind].kind.clone(),
            operations: self.traffic.operations(element).to_vec(),
            instructions: manifest::Instructions {
                file: self.instruction_file(&name),
                width: layout.width(),
                fields: fields.cloned().collect(),
            },
            memories: memories.collect(),
            buffer: (self.sizes.buffer)
                .map(|(words, read_ports)| manifest::Buffer { words, read_ports }),
            name,
        }
    }
}
