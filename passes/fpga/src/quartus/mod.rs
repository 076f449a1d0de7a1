//! A Quartus project for the DE10-Nano.
//!
//! The board of the thesis carries a 5CSEBA6U23I7. The project compiles the
//! generated machine under a board module (`hdl/board/`) that gives it a
//! clock, a reset and a host on the programming cable, so that no generated
//! system of bridges is needed; scripts load programs and read results over
//! that cable. `docs/quartus.md` describes it.
//!
//! **Quartus is not part of any test of robovec.** What can be checked
//! without it is: every file that the project names is written, its scripts
//! are well-formed Tcl, the Verilog elaborates, and the host on the cable
//! answers in simulation.

mod constraints;
mod map;

use super::manifest::Manifest;
use crate::hardware::{MachineShape, estimate_of};
use constraints::constraints;
use map::map;
use robovec_framework::template::fill;
use robovec_ir::Machine;

/// The device of the board.
pub const DEVICE: &str = "5CSEBA6U23I7";

/// The board's own clock, MHz.
const BOARD_MHZ: f64 = 50.0;

/// Verilog that is written by hand.
const BOARD: [(&str, &str); 2] = hdl!["board", "de10_nano_board.v", "virtual_jtag_host.v"];

/// The script that talks to the host on the cable.
const HOST: &str = include_str!("../../hdl/board/host.tcl");

/// Pins of the board (its user manual, tables 3-5, 3-7 and 3-8).
const PINS: [(&str, &str); 11] = [
    ("FPGA_CLK1_50", "PIN_V11"),
    ("KEY[0]", "PIN_AH17"),
    ("KEY[1]", "PIN_AH16"),
    ("LED[0]", "PIN_W15"),
    ("LED[1]", "PIN_AA24"),
    ("LED[2]", "PIN_V16"),
    ("LED[3]", "PIN_V15"),
    ("LED[4]", "PIN_AF26"),
    ("LED[5]", "PIN_AE26"),
    ("LED[6]", "PIN_Y16"),
    ("LED[7]", "PIN_AA23"),
];

/// The clock of the machine in the project, MHz, and its origin.
struct Clock {
    megahertz: f64,
    why: String,
}

/// The clock of the project: that of the machine file, if given, unless even
/// the lower end of the estimate is below it; then the lower end.
fn clock(machine: &Machine, shape: &MachineShape) -> Clock {
    let phases = f64::from(shape.phases());
    let estimate = estimate_of(shape);
    let lowest = estimate.low.floor();
    let origin = machine.clock_origin.name();
    let (element, why) = match machine.clock_mhz {
        Some(known) if known <= estimate.low => (known, format!("{origin} in the machine file")),
        Some(known) => (
            lowest,
            format!("the lower end of the estimate, below the {known} MHz {origin}"),
        ),
        None => (lowest, "the lower end of the estimate".to_owned()),
    };
    Clock {
        megahertz: element * phases,
        why: format!(
            "{element} MHz per cycle, {why}; estimated {:.0} to {:.0}",
            estimate.low, estimate.high
        ),
    }
}

/// The files of the project, below `quartus/`: name and text.
///
/// `sources` are the names of the Verilog files in `rtl/`, `images` those of
/// the `.mif` files in `img/`.
pub fn project(
    machine: &Machine,
    shape: &MachineShape,
    manifest: &Manifest,
    sources: &[String],
    images: &[String],
) -> Vec<(String, String)> {
    let clock = clock(machine, shape);
    let mut files = vec![
        ("robovec.qpf".to_owned(), PROJECT.to_owned()),
        ("robovec.qsf".to_owned(), settings(&clock, sources, images)),
        (
            "robovec.sdc".to_owned(),
            constraints(shape, clock.megahertz == BOARD_MHZ),
        ),
        ("de10_nano_top.v".to_owned(), top(&clock, manifest)),
        ("map.tcl".to_owned(), map(manifest)),
        ("host.tcl".to_owned(), HOST.to_owned()),
    ];
    files.extend(BOARD.map(|(name, text)| (name.to_owned(), text.to_owned())));
    files
}

/// The project file: one revision.
const PROJECT: &str = "# DE10-Nano project of a robovec machine.\n\
    PROJECT_REVISION = \"robovec\"\n";

/// The settings: device, files, pins.
fn settings(clock: &Clock, sources: &[String], images: &[String]) -> String {
    let file =
        |(kind, path): (&str, String)| format!("set_global_assignment -name {kind} {path}\n");
    let verilog = ["de10_nano_top.v"]
        .into_iter()
        .chain(BOARD.map(|(name, _)| name));
    let verilog = verilog.map(str::to_owned);
    let sources = sources.iter().map(|name| format!("../rtl/{name}"));
    let images = images.iter().map(|name| format!("../img/{name}"));
    let files = [("SDC_FILE", "robovec.sdc".to_owned())]
        .into_iter()
        .chain(verilog.chain(sources).map(|path| ("VERILOG_FILE", path)))
        .chain(images.map(|path| ("MIF_FILE", path)));
    // Brackets are quoted: a bare one would be a command of Tcl.
    let places = PINS.map(|(port, pin)| format!("set_location_assignment {pin} -to {{{port}}}\n"));
    let standards = PINS.map(|(port, _)| {
        format!("set_instance_assignment -name IO_STANDARD \"3.3-V LVTTL\" -to {{{port}}}\n")
    });
    fill(
        include_str!("robovec.qsf"),
        &[
            ("clock", &clock.why),
            ("device", &DEVICE),
            ("files", &files.map(file).collect::<String>()),
            ("pins", &(places.concat() + &standards.concat())),
        ],
    )
}

/// The top: pins, and the parameters of this machine.
fn top(clock: &Clock, manifest: &Manifest) -> String {
    let window = manifest.window.as_ref();
    let window = window.expect("the images of hardware have a window");
    fill(
        include_str!("top.v"),
        &[
            ("clock", &clock.why),
            ("address", &window.address_bits),
            ("pll", &u32::from(clock.megahertz != BOARD_MHZ)),
            ("frequency", &format!("{:.6}", clock.megahertz)),
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(machine: &Machine) -> MachineShape {
        MachineShape::of(machine, 1024, 1024)
    }

    fn machine() -> Machine {
        Machine::built_in("de10-nano").expect("it ships")
    }

    #[test]
    fn a_clock_that_is_too_fast_gives_way_to_the_estimate() {
        let mut machine = machine();
        let as_built = clock(&machine, &shape(&machine));
        assert_eq!(as_built.megahertz, 50.0);
        machine.clock_mhz = Some(1000.0);
        let limited = clock(&machine, &shape(&machine));
        assert!(limited.megahertz < 240.0 && limited.why.contains("lower end"));
    }

    #[test]
    fn settings_name_every_file_and_quote_brackets() {
        let clock = clock(&machine(), &shape(&machine()));
        let text = settings(&clock, &["a.v".to_owned()], &["F.add0.data.mif".to_owned()]);
        for wanted in [
            "VERILOG_FILE ../rtl/a.v",
            "MIF_FILE ../img/F.add0.data.mif",
            "VERILOG_FILE de10_nano_board.v",
            "-to {KEY[0]}",
            "DEVICE 5CSEBA6U23I7",
            "PIN_V11 -to {FPGA_CLK1_50}",
        ] {
            assert!(text.contains(wanted), "{wanted}\n{text}");
        }
        assert!(
            text.lines()
                .all(|line| line.is_empty() || line.starts_with('#') || line.starts_with("set_"))
        );
    }

    #[test]
    fn only_cycles_of_several_clocks_have_exceptions() {
        let machine = machine();
        let mut shape = MachineShape::of(&machine, 1024, 1024);
        assert!(constraints(&shape, true).contains("set_multicycle_path -setup -end"));
        shape.style = robovec_ir::machine::MemoryStyle::SideSplit;
        shape.write_ports = 1;
        let text = constraints(&shape, false);
        assert!(!text.contains("multicycle") && text.contains("derive_pll_clocks"));
    }
}
