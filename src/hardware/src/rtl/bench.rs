//! Results that a bench expects, from the simulator.

use robovec_fpga::manifest::Manifest;
use robovec_fpga::rtl::bench::{BenchError, BenchRun, BusResult, Load, TestBench};
use robovec_ir::{Machine, View};
use robovec_simulate::mif::{Image, MifError};
use robovec_simulate::{Hazard, LoadError, LoadedProgram, Trace};

/// Reason why there is no bench.
#[derive(Debug, thiserror::Error)]
pub enum BenchFailure {
    /// The images are not those of a program for this machine.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The program does not run.
    #[error(transparent)]
    Run(#[from] Hazard),
    /// An instruction image cannot be read.
    #[error("'{0}', {1}")]
    Image(String, MifError),
    /// The manifest or an image is missing or no manifest.
    #[error("{0}")]
    Manifest(String),
    /// Images and runs do not fit together.
    #[error(transparent)]
    Bench(#[from] BenchError),
}

/// The files of the folder `tb/` for a placed function and the images that
/// were made of it, as (name, text); one run per vector of inputs.
pub fn bench_files(
    view: View<'_>,
    machine: &Machine,
    images: &[(String, String)],
    inputs: &[Vec<f64>],
) -> Result<Vec<(String, String)>, BenchFailure> {
    let program = LoadedProgram::load(images, machine)?;
    let manifest = manifest(images)?;
    let instructions = instructions(&manifest, images)?;
    let mut runs = Vec::with_capacity(inputs.len());
    for state in inputs {
        runs.push(run(&program.run_traced(state)?));
    }
    let bench = TestBench {
        view,
        machine,
        manifest: &manifest,
        instructions: &instructions,
        runs: &runs,
    };
    Ok(bench.files()?)
}

fn find<'a>(images: &'a [(String, String)], end: &str) -> Result<&'a str, BenchFailure> {
    let mut files = images.iter();
    let found = files.find(|(name, _)| {
        let base = name.rsplit(['/', '\\']).next();
        base == Some(end) || end.starts_with('.') && name.ends_with(end)
    });
    found
        .map(|(_, text)| text.as_str())
        .ok_or_else(|| BenchFailure::Manifest(format!("there is no '{end}' among the images")))
}

fn manifest(images: &[(String, String)]) -> Result<Manifest, BenchFailure> {
    let text = find(images, ".manifest.json")?;
    serde_json::from_str(text).map_err(|error| BenchFailure::Manifest(error.to_string()))
}

/// For every element its instruction words, in limbs of 32 bits.
fn instructions(
    manifest: &Manifest,
    images: &[(String, String)],
) -> Result<Vec<Vec<Vec<u32>>>, BenchFailure> {
    let mut all = Vec::with_capacity(manifest.elements.len());
    for element in &manifest.elements {
        let file = &element.instructions.file;
        let image = Image::parse(find(images, file)?);
        let image = image.map_err(|error| BenchFailure::Image(file.clone(), error))?;
        assert_eq!(image.depth(), manifest.cycles, "a word for every cycle");
        let words = (0..manifest.cycles).map(|cycle| {
            let limbs = image.word(cycle).iter();
            limbs
                .flat_map(|&limb| [limb as u32, (limb >> 32) as u32])
                .collect()
        });
        all.push(words.collect());
    }
    Ok(all)
}

fn run(trace: &Trace) -> BenchRun {
    let loads = trace.loaded.iter().map(|load| Load {
        memory: load.memory,
        address: load.address,
        word: load.word,
        stays: load.constant && !load.overwritten,
    });
    let results = trace.results.iter().map(|result| BusResult {
        cycle: result.cycle,
        element: result.element,
        word: result.word,
    });
    BenchRun {
        loads: loads.collect(),
        results: results.collect(),
        outputs: trace.outputs.words.clone(),
    }
}
