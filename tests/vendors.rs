//! The Verilog that is shipped goes through open synthesis for the devices of
//! three vendors. Where yosys is missing, a line reports it and its tests are
//! skipped.

use crate::support::programs::{model, robovec, said};
use robovec::synthesis::Yosys;
use std::fs;
use std::process::Command;

#[test]
fn open_synthesis_for_three_vendors_takes_the_hardware() {
    let Ok(tool) = Yosys::find() else {
        eprintln!("SKIPPED: no yosys is installed that is new enough, nothing was mapped");
        return;
    };
    let folder = tempfile::tempdir().expect("a folder can be made");
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/machines/side-split.toml");
    let text = fs::read_to_string(shipped).expect("it ships");
    let machine = folder.path().join("machine.toml");
    fs::write(&machine, text.replace("count = 4", "count = 1")).expect("a folder of our own");
    let input = model("quarter-car.mbs").display().to_string();
    let [machine, output] =
        [machine, folder.path().join("hardware")].map(|path| path.display().to_string());
    let words = [
        "rtl",
        &input,
        "--function",
        "dirdyna",
        "--machine",
        &machine,
    ];
    let passes = ["--passes", "atomise,cse,dce,place", "-o", &output];
    said(&robovec(&[&words[..], &passes].concat()));
    let sources = fs::read_to_string(folder.path().join("hardware/rtl/files.f")).expect("written");
    let read: String = (sources.lines())
        .map(|name| format!("read_verilog {name}; "))
        .collect();
    // Whatever is left unmapped stays a memory or a cell of yosys' own.
    let left = "select -assert-none t:$mem_v2 t:$mul t:$add";
    // Pads belong to the machine alone, one for every input but the clock's.
    for (synthesis, cells) in [
        ("synth_ecp5", "-assert-min 1 t:TRELLIS_DPR16X4"),
        ("synth_gowin", "-assert-min 1 t:RAM16SDP*"),
        ("synth_gowin", "-assert-max 99 t:IBUF"),
        ("synth_intel_alm -nodsp", "-assert-min 1 t:MISTRAL_MLAB"),
    ] {
        let script = format!(
            "{read}chparam -set INITIAL 0 robovec_machine; {synthesis} -top robovec_machine; \
             {left}; select {cells}"
        );
        let run = Command::new(&tool.program)
            .args(["-q", "-p", &script])
            .current_dir(folder.path().join("hardware/rtl"))
            .output()
            .expect("yosys starts");
        let errors = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.success(), "{synthesis}: {errors}");
    }
}
