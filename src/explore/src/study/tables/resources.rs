//! Table 1.4: what a machine of 4 adders and 4 multipliers takes on a
//! Cyclone V, from the words and cycles of its placement.
//!
//! The figures are those of [`robovec_fpga::hardware`] for the
//! hardware that `robovec rtl` writes, beside the ones the thesis prints for
//! the machine it built. Parts do not match one to one: our instruction word
//! has the selects of the crossbar and the addresses of the buffer too.

use super::super::captions;
use super::super::cost::shape;
use super::super::printed::SystemTopology;
use super::super::results::Results;
use robovec_fpga::hardware::{MachinePart, MachineShape, PartKind, ResourceUse, parts};
use robovec_present::{DataCell, DataTable};

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

pub(super) fn table(results: &Results) -> Option<DataTable> {
    let model = results.plan.headline;
    let machine = results.main_machine()?;
    let pipeline = results.original();
    let mut usual = results.usual(model, pipeline, machine);
    let placed = usual.find(|placed| [placed.request.n_add, placed.request.n_multi] == BUILT)?;
    let shape = shape(results, placed);
    let parts = parts(&shape);
    let is_bogie = results
        .system(model)
        .is_some_and(|system| system.topology == SystemTopology::Bogie);
    let mut rows: Vec<Vec<DataCell>> = parts
        .iter()
        .map(|part| row(part, &shape, is_bogie))
        .collect();
    rows.push(total(&parts, is_bogie));
    let words = [("headline", captions::headline(results))];
    captions::filled("table-1.4", &words, rows)
}

fn total(parts: &[MachinePart], is_bogie: bool) -> Vec<DataCell> {
    let all: ResourceUse = parts
        .iter()
        .map(|part| part.each * f64::from(part.count))
        .sum();
    let mut cells = vec![DataCell::text("all"), DataCell::Empty, DataCell::Empty];
    cells.extend(amounts(&all));
    let printed = if is_bogie {
        ["-", "120", "20"]
    } else {
        [""; 3]
    };
    cells.extend(printed.map(DataCell::text));
    cells.push(DataCell::text(if is_bogie {
        "the parts the thesis prints add up to 124 to 140 blocks"
    } else {
        ""
    }));
    cells
}

/// Tables, registers, blocks of memory and multiplier blocks.
fn amounts(taken: &ResourceUse) -> [DataCell; 4] {
    let all = [
        taken.aluts,
        taken.registers,
        taken.memory_blocks,
        taken.multiplier_blocks,
    ];
    all.map(|amount| DataCell::count(amount.round() as u32))
}

fn row(part: &MachinePart, shape: &MachineShape, is_bogie: bool) -> Vec<DataCell> {
    let kind = shape
        .kinds
        .iter()
        .find(|kind| part.kind.as_ref() == Some(&kind.element.kind));
    let name = match kind {
        Some(kind) => format!("{} of '{}'", part.part.name(), kind.element.kind),
        None => part.part.name().to_owned(),
    };
    let memory = match (part.part, kind) {
        (PartKind::Instructions, Some(kind)) => Some(format!(
            "{} x {}",
            1_u32 << shape.instruction_address(),
            shape.instruction_width(kind)
        )),
        (PartKind::Operands, _) => Some(format!(
            "{} x {}",
            1_u32 << shape.operand_address(),
            shape.number.width()
        )),
        (PartKind::Buffer, _) => shape
            .buffer
            .map(|(words, _)| format!("{words} x {}", shape.number.width())),
        _ => None,
    };
    let mut cells = vec![
        DataCell::text(&name),
        DataCell::count(part.count),
        memory.map_or(DataCell::Empty, DataCell::Text),
    ];
    cells.extend(amounts(&part.each));
    if is_bogie {
        let adds = kind.is_some_and(|kind| kind.element.operations.iter().any(|op| op == "add"));
        let (figures, remark) = printed(part.part, adds);
        cells.extend(figures.map(DataCell::text));
        cells.push(DataCell::text(remark));
    } else {
        cells.extend(std::iter::repeat_n(DataCell::Empty, 4));
    }
    cells
}
