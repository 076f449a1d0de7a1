//! Tables 1.1 to 1.3: operators of the Cyclone V, and which share a clock.
//! Table 1.4: the resources of a machine of 4 adders and 4 multipliers on a
//! Cyclone V, from the words and cycles of its placement.
//!
//! The figures are those of [`robovec_fpga::hardware`] for the
//! hardware that `robovec rtl` writes, beside the ones the thesis prints for
//! the machine it built. Parts do not match one to one: our instruction word
//! has the selects of the crossbar and the addresses of the buffer too.

use super::super::printed::{PrintedPart, SystemTopology, thesis};
use super::super::results::Results;
use crate::captions;
use crate::operators::{ADDERS, Couple, MEMORY_CAP_MHZ, MULTIPLIERS, Operator, couples};
use robovec_fpga::hardware::{MachinePart, MachineShape, PartKind, ResourceUse, parts};
use robovec_present::{DataTable, columns};

/// Machine that the thesis built: adders, multipliers.
const BUILT: [u32; 2] = [4, 4];

/// Key of a part in the thesis' figures.
fn key(part: PartKind, adds: bool) -> &'static str {
    match part {
        PartKind::Operators if adds => "adders",
        PartKind::Operators => "multipliers",
        PartKind::Instructions => "instructions",
        PartKind::Operands => "operands",
        PartKind::Buffer => "buffer",
        PartKind::Crossbar => "crossbar",
        PartKind::Sequencer | PartKind::Window => "other",
    }
}

/// A part of the machine, or all: resources, beside the thesis' figures.
struct PartRow {
    name: String,
    count: Option<u32>,
    memory: Option<String>,
    each: ResourceUse,
    printed: Option<PrintedPart>,
}

pub(super) fn table(results: &Results) -> Option<DataTable> {
    let program = results.original_headline()?;
    let placed = program.usual().find(|placed| placed.counts() == BUILT)?;
    let shape = placed.shape();
    let system = results.system(results.plan.headline);
    let is_bogie = system.is_some_and(|system| system.topology == SystemTopology::Bogie);
    let parts = parts(&shape);
    let row = |part: &MachinePart| row(part, &shape, is_bogie);
    let mut rows: Vec<PartRow> = parts.iter().map(row).collect();
    let each = parts.iter();
    rows.push(PartRow {
        name: "all".to_owned(),
        count: None,
        memory: None,
        each: each.map(|part| part.each * f64::from(part.count)).sum(),
        printed: Some(if is_bogie {
            thesis().table_1_4["all"].clone()
        } else {
            PrintedPart::default()
        }),
    });
    let amount = |amount: f64| amount.round() as u32;
    let printed =
        |column: usize| move |row: &PartRow| Some(row.printed.as_ref()?.figures[column].clone());
    let columns = columns! { PartRow;
        "part", [Hidden, All], |row| row.name.clone();
        "count", [Hidden, All], |row| row.count;
        "memory (words x bits)", [Hidden, All], |row| row.memory.clone();
        "look-up tables", [Hidden, All], move |row| amount(row.each.aluts);
        "registers", [Hidden, All], move |row| amount(row.each.registers);
        "blocks of 10 kbit", [Hidden, All], move |row| amount(row.each.memory_blocks);
        "multiplier blocks", [Hidden, All], move |row| amount(row.each.multiplier_blocks);
        "thesis: look-up tables", [Hidden, All], printed(0);
        "thesis: blocks", [Hidden, All], printed(1);
        "thesis: multiplier blocks", [Hidden, All], printed(2);
        "remark", [Hidden, All], |row| Some(row.printed.as_ref()?.remark.clone());
    };
    let words = [("headline", results.headline())];
    captions::filled("table-1.4", &words, &columns, &rows)
}

fn row(part: &MachinePart, shape: &MachineShape, is_bogie: bool) -> PartRow {
    let mut kinds = shape.kinds.iter();
    let kind = kinds.find(|kind| part.kind.as_ref() == Some(&kind.element.kind));
    let words = |address: u32, width: u32| Some(format!("{} x {width}", 1_u32 << address));
    let adds = kind.is_some_and(|kind| kind.element.operations.iter().any(|op| op == "add"));
    PartRow {
        name: match kind {
            Some(kind) => format!("{} of '{}'", part.part.name(), kind.element.kind),
            None => part.part.name().to_owned(),
        },
        count: Some(part.count),
        memory: match (part.part, kind) {
            (PartKind::Instructions, Some(kind)) => {
                words(shape.instruction_address(), shape.instruction_width(kind))
            }
            (PartKind::Operands, _) => words(shape.operand_address(), shape.number.width()),
            (PartKind::Buffer, _) => shape
                .buffer
                .map(|(words, _)| format!("{words} x {}", shape.number.width())),
            _ => None,
        },
        each: part.each,
        printed: is_bogie.then(|| thesis().table_1_4[key(part.part, adds)].clone()),
    }
}

pub(super) fn tables() -> Vec<DataTable> {
    let operators = columns! { Operator;
        "stages", [Hidden, All], |operator| operator.stages;
        "clock (MHz)", [Hidden, All], |operator| operator.mhz;
        "look-up tables", [Hidden, All], |operator| operator.luts;
    };
    let adders = captions::table("table-1.1", &[], &operators, &ADDERS);
    let blocks = columns! { Operator;
        "multiplier blocks", [Hidden, All], |operator| operator.multipliers;
    };
    let operators = operators.and(blocks);
    let multipliers = captions::table("table-1.2", &[], &operators, &MULTIPLIERS);
    let time = |couple: &Couple, kind: usize| {
        1e3 * f64::from(couple.stages()[kind] + 2) / f64::from(couple.mhz())
    };
    let capped = format!("clock under the {MEMORY_CAP_MHZ} MHz cap (MHz)");
    let pairs = columns! { Couple;
        "adder stages", [Hidden, All], |couple| couple.stages()[0];
        "multiplier stages", [Hidden, All], |couple| couple.stages()[1];
        "clock (MHz)", [Hidden, All], Couple::mhz;
        capped, [Hidden, All], |couple| couple.mhz().min(MEMORY_CAP_MHZ);
        "addition (ns)", [Hidden, Decimals(1)], move |couple| time(couple, 0);
        "multiplication (ns)", [Hidden, Decimals(1)], move |couple| time(couple, 1);
    };
    let couples = captions::table("table-1.3", &[], &pairs, &couples());
    vec![adders, multipliers, couples]
}
