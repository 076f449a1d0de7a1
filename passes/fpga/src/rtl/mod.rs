//! Hardware in Verilog.
//!
//! The parts that do not depend on the shape of a machine are written by hand
//! under `hdl/` and included in the compiler; the parts that are chosen or
//! generated for one machine are here: the elements, the crossbar, the top
//! `robovec_machine`, and the images that it runs. Their frame is Verilog
//! beside the writers, with words between `@` for the parts that depend on the
//! machine. `docs/rtl.md` describes the result.
//!
//! [`Hardware`] is the machine file with every size settled. The program that
//! it was built for gives the sizes that the file leaves open; every later
//! program is only an image, if it [fits](fits()).

pub mod bench;
pub mod cores;
mod crossbar;
mod element;
mod error;
mod fits;
mod hardware;
mod legs;
mod text;
mod top;
mod unit;
mod window;

pub use error::RtlError;
pub use fits::{HardwareDemand, HardwareFit, fits};
pub use hardware::{Crossbar, CrossbarChoice, ElementGroup, Hardware};
pub(crate) use unit::cores as cores_of;

use super::images::{ImageHardware, write_traffic};
use super::manifest::{FileHash, Manifest};
use super::traffic::Traffic;
use super::{Artifacts, FileContent, ImageError};
use cores::OperatorCore;
use robovec_ir::machine::MemoryStyle;
use robovec_ir::{Machine, View};
use robovec_num::fnv::Fnv;
use std::io;

/// Name of the description of the hardware, beside the Verilog files.
pub const DESCRIPTION: &str = "machine.json";

/// The Verilog files of the machine that are written by hand.
const COMMON: [(&str, &str); 6] = hdl![
    "machine",
    "host_window.v",
    "instruction_memory.v",
    "multiplexer_4.v",
    "result_buffer.v",
    "sequencer.v",
    "simple_dual_port_memory.v",
];

/// Cores of memories that are split by side.
const SPLIT: [(&str, &str); 2] = hdl!["machine", "operand_side.v", "pe_split.v"];

/// Cores of unified memories.
const PUMPED: [(&str, &str); 3] = hdl![
    "machine",
    "pe_pumped.v",
    "pumped_operand.v",
    "true_dual_port_memory.v",
];

/// Builds hardware for a placed function and writes it: `rtl/` with the
/// Verilog files, the list of them (`files.f`) and the description
/// (`machine.json`), and `img/` with the images.
///
/// # Errors
///
/// Fails when the function has no images, the machine cannot be built, or
/// `artifacts` fails.
pub fn write_rtl(
    view: View<'_>,
    machine: &Machine,
    choice: CrossbarChoice,
    artifacts: &mut dyn Artifacts,
) -> Result<Hardware, RtlError> {
    let traffic = Traffic::new(view, machine)?;
    let hardware = Hardware::new(&traffic, choice)?;
    let manifest = write_images_on(&traffic, &hardware, artifacts)?;
    let program = top::ConfiguredProgram {
        function: &manifest.function,
        cycles: manifest.cycles,
        schedule_hash: &manifest.schedule_hash,
    };
    write_files(hardware, &program, artifacts)
}

/// The images of another placed function for existing hardware, into `img/`.
///
/// # Errors
///
/// Fails when the function has no images or does not fit, with all reasons, or
/// `artifacts` fails.
pub fn write_program(
    view: View<'_>,
    hardware: &Hardware,
    artifacts: &mut dyn Artifacts,
) -> Result<(), RtlError> {
    let traffic = Traffic::new(view, &hardware.machine)?;
    let fit = fits::of_traffic(&traffic, hardware);
    if !fit.reasons.is_empty() {
        return Err(RtlError::Misfit {
            function: view.function.name.clone(),
            reasons: fit.reasons,
        });
    }
    write_images_on(&traffic, hardware, artifacts)?;
    Ok(())
}

/// Puts files into a folder, and keeps the manifest.
struct ManifestFolder<'a> {
    name: &'static str,
    artifacts: &'a mut dyn Artifacts,
    manifest: Vec<u8>,
}

impl Artifacts for ManifestFolder<'_> {
    fn file(&mut self, name: &str, content: FileContent<'_>) -> io::Result<()> {
        let path = format!("{}/{name}", self.name);
        if !name.ends_with(".manifest.json") {
            return self.artifacts.file(&path, content);
        }
        content(&mut self.manifest)?;
        let manifest = &self.manifest;
        self.artifacts
            .file(&path, &mut |target| target.write_all(manifest))
    }
}

fn write_images_on(
    traffic: &Traffic<'_>,
    hardware: &Hardware,
    artifacts: &mut dyn Artifacts,
) -> Result<Manifest, RtlError> {
    let mut folder = ManifestFolder {
        name: "img",
        artifacts,
        manifest: Vec::new(),
    };
    let target = ImageHardware {
        sizes: hardware.sizes(),
        instruction_depth: hardware.instruction_depth(),
        window: hardware.address_map(),
    };
    write_traffic(traffic, None, Some(&target), &mut folder)?;
    let manifest = serde_json::from_slice(&folder.manifest).map_err(io::Error::from)?;
    Ok(manifest)
}

/// Writes the hardware; gives it back with the hashes of its files.
fn write_files(
    mut hardware: Hardware,
    program: &top::ConfiguredProgram<'_>,
    artifacts: &mut dyn Artifacts,
) -> Result<Hardware, RtlError> {
    let mut files: Vec<(String, String)> = Vec::new();
    let own: &[(&str, &str)] = match hardware.machine.memory.style {
        MemoryStyle::SideSplit => &SPLIT,
        MemoryStyle::Unified | MemoryStyle::FourPort => &PUMPED,
    };
    let mut fixed: Vec<(&str, &str)> = COMMON.iter().chain(own).copied().collect();
    fixed.extend(core_files(&hardware));
    fixed.sort_unstable();
    for (name, text) in fixed {
        files.push((name.to_owned(), text.to_owned()));
    }
    for group in &hardware.elements {
        let name = element::module_name(group) + ".v";
        files.push((name, element::text(&hardware, group)));
    }
    files.extend(crossbar::multiplexers(&hardware));
    files.push(("robovec_crossbar.v".to_owned(), crossbar::text(&hardware)));
    files.push((
        "robovec_machine.v".to_owned(),
        top::text(&hardware, program),
    ));
    let list: String = files.iter().map(|(name, _)| format!("{name}\n")).collect();
    files.push(("files.f".to_owned(), list));
    let hashes = files.iter().map(|(name, text)| FileHash {
        file: name.clone(),
        hash: Fnv::of(text.as_bytes()).text(),
    });
    hardware.files = hashes.collect();
    // Behind all others, so that it stands only beside complete hardware.
    files.push((DESCRIPTION.to_owned(), hardware.text()?));
    for (name, text) in files {
        artifacts.file(&format!("rtl/{name}"), &mut |target| {
            target.write_all(text.as_bytes())
        })?;
    }
    Ok(hardware)
}

/// The files of the cores that the elements instantiate, and of the cores
/// inside these.
fn core_files(hardware: &Hardware) -> Vec<(&'static str, &'static str)> {
    let file = |module: &str| {
        let mut all = cores::SOURCES.into_iter();
        all.find(|(name, _)| name.trim_end_matches(".v") == module)
    };
    let mut wanted: Vec<&str> = (hardware.elements.iter())
        .flat_map(|group| cores_of(hardware.kind(group)))
        .map(OperatorCore::name)
        .collect();
    let mut files = Vec::new();
    while let Some(module) = wanted.pop() {
        let (name, text) = file(module).expect("every core has a file");
        if files.contains(&(name, text)) {
            continue;
        }
        files.push((name, text));
        let lines = text.lines().map(|line| line.split("//").next());
        let words = lines
            .flatten()
            .flat_map(|line| line.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')));
        wanted.extend(words.filter(|word| file(word).is_some()));
    }
    files
}

/// The advice about an error.
pub fn advice(error: &RtlError) -> Option<String> {
    let fixed = match error {
        RtlError::Images(ImageError::NotPlaced { .. }) => Some("run 'place' before"),
        RtlError::Images(ImageError::OtherMachine(mismatch)) => return Some(mismatch.advice()),
        RtlError::Number(_) => Some("choose a machine with a format such as f32 or float(8,17)"),
        RtlError::Interconnect(_) => Some("choose a machine with 'interconnect = \"crossbar\"'"),
        RtlError::FourPort => {
            Some("choose the style 'unified', whose schedules are the same, or 'side-split'")
        }
        _ => None,
    };
    fixed.map(str::to_owned)
}
