//! Table 1.4: what a machine of 4 adders and 4 multipliers takes on a
//! Cyclone V, from the words and cycles of its placement.
//!
//! The figures are those of [`robovec_fpga::hardware`] for the
//! hardware that `robovec rtl` writes, beside the ones the thesis prints for
//! the machine it built. Parts do not match one to one: our instruction word
//! has the selects of the crossbar and the addresses of the buffer too.

use super::super::printed::SystemTopology;
use super::super::results::Results;
use crate::captions;
use robovec_fpga::hardware::{MachinePart, MachineShape, PartKind, ResourceUse, parts};
use robovec_present::{DataTable, columns};

/// Machine that the thesis built: adders, multipliers.
const BUILT: [u32; 2] = [4, 4];

/// Numbers that the thesis prints for one of a part: look-up tables, blocks of
/// memory, multiplier blocks; and a remark.
fn printed(part: PartKind, adds: bool) -> ([&'static str; 3], &'static str) {
    match (part, adds) {
        (PartKind::Operators, true) => (["565", "0", "2"], "an adder needs no multiplier block"),
        (PartKind::Operators, false) => (["169", "0", "3"], ""),
        (PartKind::Instructions, _) => (
            ["0", "5-7", "0"],
            "3-4 for the word without selects, though 47 bits x 1024 words fill 5 blocks; 2-3 for \
             the buffer, the bits of the instructions of an adder repeated",
        ),
        (PartKind::Operands, _) => (
            ["4", "7", "0"],
            "the thesis gives it 2048 words, whatever the program needs",
        ),
        (PartKind::Buffer, _) => (
            ["0", "1", "0"],
            "ours is a memory in logic, so that it can be read without a clock",
        ),
        (PartKind::Crossbar, _) => (
            ["2560", "20", "0"],
            "the blocks are for the selects, which our instruction words hold; 64 bits x 1024 \
             words fit into 7; the thesis' formula 2N sqrt(2N) should be 2N log2(2N), which is \
             the same for 8 elements",
        ),
        (PartKind::Sequencer | PartKind::Window, _) => (["-", "-", "-"], "the thesis has none"),
    }
}

/// A part of the machine, or all of them: what one takes, beside what the thesis
/// prints for it.
struct PartRow {
    name: String,
    count: Option<u32>,
    memory: Option<String>,
    each: ResourceUse,
    printed: Option<([&'static str; 3], &'static str)>,
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
            let remark = "the parts the thesis prints add up to 124 to 140 blocks";
            (["-", "120", "20"], remark)
        } else {
            ([""; 3], "")
        }),
    });
    let amount = |amount: f64| amount.round() as u32;
    let printed = |column: usize| move |row: &PartRow| Some(row.printed?.0[column]);
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
        "remark", [Hidden, All], |row| Some(row.printed?.1);
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
        printed: is_bogie.then(|| printed(part.part, adds)),
    }
}
