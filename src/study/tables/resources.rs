//! Table 1.4: an estimate of what a machine of 4 adders and 4 multipliers
//! takes on a Cyclone V, from the words and cycles of its placement.
//!
//! Memories count in blocks of 10 kbit by the shapes a block can take; the
//! crossbar as one multiplexer per write port, three inputs of it per look-up
//! table of six inputs, the operators as Tables 1.1 and 1.2 give them.

use super::super::couples::{ADDERS, MULTIPLIERS, Operator};
use super::super::plan::Printed;
use super::super::printed::Topology;
use super::super::results::{Placed, Results};
use super::super::table::{Cell, Table};
use robovec_ir::Operation;

/// Words and bits per word that an M10K block can have.
const SHAPES: [[u32; 2]; 6] = [
    [8192, 1],
    [4096, 2],
    [2048, 5],
    [1024, 10],
    [512, 20],
    [256, 40],
];

/// Bits of a word.
const WORD: u32 = 32;

/// What the thesis built: adders, multipliers.
const BUILT: [u32; 2] = [4, 4];

/// Blocks for a memory of some words of some bits, all of one shape.
pub(crate) fn blocks(words: u32, bits: u32) -> u32 {
    let shapes = SHAPES
        .iter()
        .map(|[depth, width]| words.div_ceil(*depth) * bits.div_ceil(*width));
    shapes.min().unwrap_or(0)
}

/// Look-up tables of a full crossbar between so many elements: each of two
/// write ports chooses among the results and the buffers of all.
pub(crate) fn crossbar_luts(elements: u32, width: u32) -> u32 {
    2 * elements * width * (2 * elements).saturating_sub(1).div_ceil(3)
}

/// Bits of an address among so many words.
fn address(words: u32) -> u32 {
    words.max(2).next_power_of_two().ilog2()
}

/// A part: name, how many, words and bits of its memory, look-up tables,
/// multiplier blocks, and what the thesis prints for one.
struct Part {
    name: &'static str,
    count: u32,
    memory: Option<[u32; 2]>,
    luts: u32,
    multipliers: u32,
    printed: [&'static str; 3],
    remark: &'static str,
}

pub(super) fn table(results: &Results) -> Option<Table> {
    let model = results.plan.headline;
    let machine = results.main_machine()?;
    let pipeline = results.pipeline(Printed::Original).unwrap_or(0);
    let mut usual = results.usual(model, pipeline, machine);
    let placed = usual.find(|placed| [placed.request.n_add, placed.request.n_multi] == BUILT)?;
    let description = &results.plan.machines[machine].machine;
    let stages = |operation| {
        description
            .kind_of(operation)
            .map_or(0, |kind| description.elements[kind].stages)
    };
    let operator =
        |all: &[Operator], stages: u32| all.iter().copied().find(|one| one.stages == stages);
    let adder = operator(&ADDERS, stages(Operation::Add))?;
    let multiplier = operator(&MULTIPLIERS, stages(Operation::Mul))?;
    let parts = parts(placed, adder, multiplier);
    let is_bogie = results
        .system(model)
        .is_some_and(|system| system.topology == Topology::Bogie);
    let mut rows: Vec<Vec<Cell>> = parts.iter().map(|part| row(part, is_bogie)).collect();
    let total = |value: fn(&Part) -> u32| -> u32 {
        parts.iter().map(|part| part.count * value(part)).sum()
    };
    let printed = if is_bogie {
        ["-", "120", "20"]
    } else {
        [""; 3]
    };
    rows.push(vec![
        Cell::text("all"),
        Cell::Empty,
        Cell::Empty,
        Cell::count(total(|part| part.luts)),
        Cell::count(total(part_blocks)),
        Cell::count(total(|part| part.multipliers)),
        Cell::text(printed[0]),
        Cell::text(printed[1]),
        Cell::text(printed[2]),
        Cell::text(if is_bogie {
            "the parts the thesis prints add up to 124 to 140 blocks"
        } else {
            ""
        }),
    ]);
    Some(Table {
        name: "table-1.4".to_owned(),
        title: format!(
            "Table 1.4: resources of 4 adders and 4 multipliers, {}",
            results.plan.models[model].name
        ),
        caption: "An estimate from the words and cycles of the placement, by the rules in \
            docs/study.md; nothing was synthesised. Look-up tables and blocks are for one part. \
            The device of the thesis has 553 blocks of 10 kbit and 112 multiplier blocks."
            .to_owned(),
        columns: [
            "part",
            "count",
            "memory (words x bits)",
            "look-up tables",
            "blocks of 10 kbit",
            "multiplier blocks",
            "thesis: look-up tables",
            "thesis: blocks",
            "thesis: multiplier blocks",
            "remark",
        ]
        .map(str::to_owned)
        .to_vec(),
        rows,
    })
}

fn part_blocks(part: &Part) -> u32 {
    part.memory.map_or(0, |[words, bits]| blocks(words, bits))
}

fn row(part: &Part, is_bogie: bool) -> Vec<Cell> {
    let memory = part.memory.map(|[words, bits]| format!("{words} x {bits}"));
    let mut cells = vec![
        Cell::text(part.name),
        Cell::count(part.count),
        memory.map_or(Cell::Empty, Cell::Text),
        Cell::count(part.luts),
        Cell::count(part_blocks(part)),
        Cell::count(part.multipliers),
    ];
    if is_bogie {
        cells.extend(part.printed.map(Cell::text));
        cells.push(Cell::text(part.remark));
    } else {
        cells.extend(std::iter::repeat_n(Cell::Empty, 4));
    }
    cells
}

fn parts(placed: Placed<'_>, adder: Operator, multiplier: Operator) -> Vec<Part> {
    let all: u32 = BUILT.iter().sum();
    let cycles = placed.point.cycles;
    let most = |words: fn(usize, Placed<'_>) -> f64| {
        let words = (0..2).map(|kind| words(kind, placed)).fold(0.0, f64::max);
        words as u32
    };
    let memory = most(|kind, placed| placed.point.kinds[kind].memory[2]);
    let buffer = most(|kind, placed| placed.point.kinds[kind].buffer[2]).max(1);
    // Two reads, two writes with their enables.
    let instruction = 4 * address(memory) + 2;
    let part = |name, count, printed, remark| Part {
        name,
        count,
        memory: None,
        luts: 0,
        multipliers: 0,
        printed,
        remark,
    };
    vec![
        Part {
            luts: adder.luts,
            ..part(
                "adder",
                BUILT[0],
                ["565", "0", "2"],
                "an adder needs no multiplier block",
            )
        },
        Part {
            luts: multiplier.luts,
            multipliers: multiplier.multipliers,
            ..part("multiplier", BUILT[1], ["169", "0", "3"], "")
        },
        Part {
            memory: Some([cycles, instruction + 1]),
            ..part(
                "instructions of an adder",
                BUILT[0],
                ["0", "3-4", "0"],
                "47 bits x 1024 words, as the thesis has them, fill 5 blocks",
            )
        },
        Part {
            memory: Some([cycles, instruction]),
            ..part(
                "instructions of a multiplier",
                BUILT[1],
                ["0", "3-4", "0"],
                "",
            )
        },
        Part {
            memory: Some([memory, WORD]),
            ..part(
                "operand memory",
                all,
                ["4", "7", "0"],
                "the thesis gives it 2048 words, whatever the program needs",
            )
        },
        Part {
            memory: Some([cycles, 2 * address(buffer) + 1]),
            ..part(
                "buffer instructions",
                all,
                ["0", "2-3", "0"],
                "the thesis repeats the bits of the instructions of an adder here; 16 words need \
                 two addresses of 4 bits and an enable",
            )
        },
        Part {
            memory: Some([buffer, WORD]),
            ..part("buffer", all, ["0", "1", "0"], "")
        },
        Part {
            luts: crossbar_luts(all, WORD),
            ..part("crossbar", 1, ["2560", "0", "0"], "")
        },
        Part {
            memory: Some([cycles, 2 * all * address(2 * all)]),
            ..part(
                "selects of the crossbar",
                1,
                ["0", "20", "0"],
                "64 bits x 1024 words fit into 7 blocks; the thesis' formula 2N sqrt(2N) should \
                 be 2N log2(2N), which is the same for 8 elements",
            )
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_follow_the_shapes_of_an_m10k() {
        // Thesis 1.3.1: 2048 words of 32 bits in 7 blocks, 16 of 32 in one.
        assert_eq!(
            [blocks(2048, 32), blocks(16, 32), blocks(1024, 64)],
            [7, 1, 7]
        );
        assert_eq!(blocks(1024, 47), 5);
        assert_eq!(
            [address(1), address(16), address(17), address(2048)],
            [1, 4, 5, 11]
        );
    }
}
