//! Hardware that is built, programs that fit it, and those that are refused.

use robovec_fpga::manifest::Manifest;
use robovec_fpga::rtl::*;
use robovec_framework::manager::{self, Config};
use robovec_ir::parse::parse_module;
use robovec_ir::{Format, Machine, Module, View};
use robovec_passes::registry::REGISTRY;

const PRODUCTS: &str = "// robovec 1
source 0 \"mbs_dirdyna_small.m\"

function small equations {
  in q[1..4]
  out f[1..2]

  f[1] = q[1]*q[2] + q[3]*q[4] @3:1-5
  f[2] = q[1]*q[3] - q[2] @3:1-5
}
";

const CHAIN: &str = "// robovec 1
source 0 \"mbs_dirdyna_small.m\"

function chain equations {
  in q[1..4]
  out f[1..2]

  %a = q[1]*q[2] - q[3]*q[4] @3:1-5
  %b = %a*%a + q[1]*%a @3:1-5
  %c = %b*%a - %b*q[2] @3:1-5
  f[1] = %c*%c + %b @3:1-5
  f[2] = %c*%b - %a*q[4] @3:1-5
}
";

/// A small machine of two adders and two multipliers.
fn machine(more: &str) -> Machine {
    let text = include_str!("../../machines/side-split.toml").replace("count = 4", "count = 2");
    Machine::parse(&(text + more)).expect("a machine")
}

fn placed(text: &str, machine: &Machine) -> Module {
    let mut module = parse_module("small", text).expect("a well-formed text");
    let pipeline = REGISTRY.pipeline("atomise,place").expect("a pipeline");
    let mut log = Vec::new();
    manager::run(&mut module, &pipeline, Config::new(machine, &mut log)).expect("it fits");
    module
}

fn view(module: &Module) -> View<'_> {
    module.tables.view(&module.functions[0])
}

type Files = Vec<(String, String)>;

fn built(text: &str, machine: &Machine, choice: CrossbarChoice) -> (Hardware, Files) {
    let module = placed(text, machine);
    let mut files = Files::new();
    let hardware = write_rtl(view(&module), machine, choice, &mut files).expect("it can be built");
    (hardware, files)
}

fn file<'a>(files: &'a Files, name: &str) -> &'a str {
    let found = files.iter().find(|(known, _)| known == name);
    found.map(|(_, text)| text.as_str()).expect("it is written")
}

#[test]
fn every_file_of_the_list_is_written_and_nothing_else() {
    let (_, files) = built(PRODUCTS, &machine(""), CrossbarChoice::Full);
    let mut listed: Vec<String> = file(&files, "rtl/files.f")
        .lines()
        .map(|name| format!("rtl/{name}"))
        .collect();
    listed.extend(["rtl/files.f".to_owned(), "rtl/machine.json".to_owned()]);
    let mut written: Vec<&String> = (files.iter().map(|(name, _)| name))
        .filter(|name| name.starts_with("rtl/"))
        .collect();
    listed.sort();
    written.sort();
    assert_eq!(listed.iter().collect::<Vec<_>>(), written);
    assert!(listed.contains(&"rtl/fp_add.v".to_owned()));
    // Every module that is instantiated is there.
    assert!(!listed.contains(&"rtl/pe_pumped.v".to_owned()));
}

#[test]
fn the_same_program_gives_the_same_bytes() {
    let one = built(CHAIN, &machine(""), CrossbarChoice::Pruned);
    let two = built(CHAIN, &machine(""), CrossbarChoice::Pruned);
    assert!(one == two);
}

#[test]
fn a_description_reads_back_and_keeps_its_hash() {
    for choice in [CrossbarChoice::Full, CrossbarChoice::Pruned] {
        let (hardware, files) = built(CHAIN, &machine(""), choice);
        let again = Hardware::parse(file(&files, "rtl/machine.json")).expect("a description");
        assert_eq!(again, hardware);
        assert_eq!(again.hash(), hardware.hash());
        let top = file(&files, "rtl/robovec_machine.v");
        assert!(top.contains(&hardware.hash()));
        let manifest = file(&files, "img/chain.manifest.json");
        let manifest: Manifest = serde_json::from_str(manifest).expect("a manifest");
        let window = manifest.window.expect("it is for hardware");
        assert_eq!(window.machine_hash, hardware.hash());
    }
}

#[test]
fn units_of_the_window_do_not_overlap() {
    for more in ["", "\n[instructions]\nwords = 4096\n"] {
        let (_, files) = built(PRODUCTS, &machine(more), CrossbarChoice::Full);
        let manifest = file(&files, "img/small.manifest.json");
        let manifest: Manifest = serde_json::from_str(manifest).expect("a manifest");
        let window = manifest.window.expect("it is for hardware");
        let mut units = window.units;
        units.sort_by_key(|unit| unit.address);
        let mut end = 8;
        for unit in &units {
            assert!(unit.address >= end, "{}", unit.name);
            assert!(unit.limbs <= unit.stride);
            end = unit.address + unit.words * unit.stride;
        }
        assert!(end <= 1 << window.address_bits);
    }
}

#[test]
fn a_program_fits_hardware_with_room_and_its_images_have_that_layout() {
    let roomy = machine("\n[instructions]\nwords = 256\n");
    let (hardware, _) = built(CHAIN, &roomy, CrossbarChoice::Full);
    let other = placed(PRODUCTS, &roomy);
    let fit = fits(view(&other), &hardware).expect("it has images");
    assert_eq!(fit.reasons, Vec::<String>::new());
    let mut files = Files::new();
    write_program(view(&other), &hardware, &mut files).expect("it fits");
    assert!(files.iter().all(|(name, _)| name.starts_with("img/")));
    let manifest: Manifest =
        serde_json::from_str(file(&files, "img/small.manifest.json")).expect("a manifest");
    let window = manifest.window.expect("it is for hardware");
    assert_eq!(window.machine_hash, hardware.hash());
    assert_eq!(manifest.elements[0].memories[0].words, hardware.words);
}

#[test]
fn instruction_files_fill_the_memories_of_the_hardware() {
    let (_, files) = built(
        CHAIN,
        &machine("\n[instructions]\nwords = 256\n"),
        CrossbarChoice::Full,
    );
    let instructions = files
        .iter()
        .filter(|(name, _)| name.ends_with(".instructions.hex"));
    let mut count = 0;
    for (name, text) in instructions {
        let is_word = |line: &&str| !line.is_empty() && !line.starts_with("//");
        assert_eq!(text.lines().filter(is_word).count(), 256, "{name}");
        count += 1;
    }
    assert_eq!(count, 4, "one for every element");
}

#[test]
fn everything_that_is_lacking_is_named() {
    let (hardware, _) = built(PRODUCTS, &machine(""), CrossbarChoice::Pruned);
    let other = placed(CHAIN, &machine(""));
    let reasons = fits(view(&other), &hardware).expect("images").reasons;
    let all = reasons.join("\n");
    assert!(all.contains("cycles, and the hardware has"), "{all}");
    let error = write_program(view(&other), &hardware, &mut Files::new());
    assert!(matches!(error, Err(RtlError::Misfit { .. })));

    let deep = machine("\n[instructions]\nwords = 256\n");
    let (hardware, _) = built(PRODUCTS, &deep, CrossbarChoice::Pruned);
    let roomy = Hardware {
        words: 64,
        buffer: Some(robovec_fpga::manifest::Buffer {
            words: 16,
            read_ports: 1,
        }),
        ..hardware
    };
    let other = placed(CHAIN, &deep);
    let reasons = fits(view(&other), &roomy).expect("images").reasons;
    assert!(
        matches!(&reasons[..], [reason] if reason.contains("pruned crossbar lacks")),
        "{reasons:?}"
    );

    let fewer = Hardware {
        elements: vec![ElementGroup {
            kind: "add".to_owned(),
            count: 2,
        }],
        crossbar: Crossbar::Full,
        ..roomy
    };
    let reasons = fits(view(&other), &fewer).expect("images").reasons;
    assert!(reasons[0].contains("2 add + 2 multi"), "{reasons:?}");
}

#[test]
fn what_cannot_be_built_is_refused() {
    let short = machine("\n[instructions]\nwords = 8\n");
    let module = placed(CHAIN, &short);
    let error = write_rtl(
        view(&module),
        &short,
        CrossbarChoice::Full,
        &mut Files::new(),
    );
    assert!(matches!(error, Err(RtlError::Misfit { .. })), "{error:?}");

    let mut fixed = machine("");
    fixed.number = "fixed(12,19)".parse::<Format>().expect("a format");
    let module = placed(PRODUCTS, &fixed);
    let error = write_rtl(
        view(&module),
        &fixed,
        CrossbarChoice::Full,
        &mut Files::new(),
    );
    assert!(matches!(error, Err(RtlError::Number(_))), "{error:?}");

    for text in ["", "{}", "[1, 2", "{\"format\": 1}"] {
        let error = Hardware::parse(text);
        assert!(matches!(error, Err(RtlError::Description(_))), "{text}");
    }
}
