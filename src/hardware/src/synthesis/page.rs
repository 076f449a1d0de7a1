//! A mapped machine as a page: parts, totals, the clock.

use super::Yosys;
use super::machine::MappedMachine;
use super::timing::{FAST_NET, Path, SLOW_NET};
use robovec_fpga::hardware::{PartKind, ResourceUse};
use robovec_present::number::or_nothing;
use robovec_present::text_table;
use std::fmt::Write;

/// Numbers that Table 1.4 of the thesis prints for all of a part of its 4
/// adders and 4 multipliers: look-up tables, registers, blocks of memory,
/// multiplier blocks; empty where it prints nothing.
fn printed(part: PartKind, kind: Option<&str>) -> [&'static str; 4] {
    match (part, kind) {
        (PartKind::Operators, Some("add")) => ["4x565", "4x600", "0", "4x2"],
        (PartKind::Operators, Some("multi")) => ["4x169", "4x170", "0", "4x3"],
        (PartKind::Instructions, Some(_)) => ["0", "", "4x3-4", "0"],
        (PartKind::Operands, Some(_)) => ["4x4", "", "4x7", "0"],
        (PartKind::Buffer, Some(_)) => ["0", "", "4x1", "0"],
        (PartKind::Crossbar, None) => ["2560", "", "20", "0"],
        _ => [""; 4],
    }
}

/// The totals of Table 1.4.
const PRINTED: [&str; 4] = ["4413 ALM", "", "120", "20"];

/// The page of a mapped machine.
pub fn page(machine: &MappedMachine, tool: &Yosys) -> String {
    let mut text = format!(
        "{} {}, synth_intel_alm for Cyclone V. Nothing was placed, routed or given to Quartus.\n\n",
        tool.program, tool.version
    );
    text += &resources(machine);
    text += "\n\nEach: yosys / formula, and what the formula is off by. MLABs beside, as yosys has \
             them / by formula: ";
    // Writing to a string cannot fail, here and below.
    let _ = writeln!(
        text,
        "{:.0} / {:.0}.",
        machine.total().lab_memories,
        machine.estimate().lab_memories
    );
    text += "Thesis: Table 1.4, its machine of 4 adders and 4 multipliers as built, with unified \
             memories; its selects are a separate memory.\n\
             Every memory is mapped to memory blocks; no bit of a memory is a register.\n\n";
    text += &clock(machine);
    text
}

fn resources(machine: &MappedMachine) -> String {
    let mut rows = Vec::new();
    assert_eq!(
        machine.estimated.len(),
        machine.counted.len(),
        "every part is estimated and counted"
    );
    for (part, counted) in machine.estimated.iter().zip(&machine.counted) {
        let mut row = vec![
            or_nothing(part.kind.as_deref(), str::to_owned),
            part.part.name().to_owned(),
            part.count.to_string(),
        ];
        let estimated = part.each * f64::from(part.count);
        let thesis = printed(part.part, part.kind.as_deref());
        row.extend(pairs(counted, &estimated));
        row.extend(thesis.map(str::to_owned));
        rows.push(row);
    }
    let mut all = vec!["all".to_owned(), String::new(), String::new()];
    all.extend(pairs(&machine.total(), &machine.estimate()));
    all.extend(PRINTED.map(str::to_owned));
    rows.push(all);
    let head = "kind | part | >count | >ALUT | >% | >registers | >% | >M10K | >% | >DSP | >% | \
         >thesis ALUT | >registers | >M10K | >DSP";
    text_table(head, &rows)
}

/// Tables, registers, memory and multipliers: both counts, the difference.
fn pairs(counted: &ResourceUse, estimated: &ResourceUse) -> Vec<String> {
    let of = |value: fn(&ResourceUse) -> f64| (value(counted), value(estimated));
    let all = [
        of(|taken| taken.aluts),
        of(|taken| taken.registers),
        of(|taken| taken.memory_blocks),
        of(|taken| taken.multiplier_blocks),
    ];
    let texts = all.into_iter().flat_map(|(counted, estimated)| {
        let difference = if counted > 0.0 {
            format!("{:+.0}", 100.0 * (estimated / counted - 1.0))
        } else {
            String::new()
        };
        [format!("{counted:.0} / {estimated:.0}"), difference]
    });
    texts.collect()
}

fn clock(machine: &MappedMachine) -> String {
    let (Some(quick), Some(slow)) = (&machine.quick, &machine.slow) else {
        return "There is no path from register to register.\n".to_owned();
    };
    let (high, low) = (quick.megahertz(), slow.megahertz());
    let mut text = format!(
        "Clock: {low:.0} to {high:.0} MHz with {SLOW_NET} to {FAST_NET} ps per net, {:.0} between.\n\
         An estimate from published cell delays, not calibrated against Quartus.\n",
        2e6 / f64::from(quick.delay + slow.delay)
    );
    if machine.phases > 1 {
        let _ = writeln!(
            text,
            "A cycle has {} clocks; paths that have a whole cycle are not distinguished here, so \
             the machine may be faster.",
            machine.phases
        );
    }
    let _ = writeln!(
        text,
        "\nThe longest path, {} ps with quick nets:",
        quick.delay
    );
    text += &steps(quick);
    text
}

/// The cells of a path, with neighbours of a carry chain in one line.
pub fn steps(path: &Path) -> String {
    let mut text = String::new();
    let mut steps = path.steps.iter().peekable();
    while let Some(step) = steps.next() {
        let mut last = step;
        let mut places = 1;
        while let Some(next) = steps.next_if(|next| {
            step.kind == "MISTRAL_ALUT_ARITH"
                && next.kind == step.kind
                && next.module == step.module
        }) {
            last = next;
            places += 1;
        }
        let name = match places {
            1 => short(&last.name),
            _ => format!("{} ({places} places of a carry chain)", short(&last.name)),
        };
        let _ = writeln!(
            text,
            "  {:>6} ps  {:<19} {:<20} {name}",
            last.at, last.kind, last.module
        );
    }
    text
}

/// A cell's name without the suffixes of yosys.
fn short(name: &str) -> String {
    let first = |text: &str, end: &str| {
        let part = text.split(end).next();
        part.expect("a text has a first part").to_owned()
    };
    first(&first(name, "_MISTRAL_"), "_$")
}
