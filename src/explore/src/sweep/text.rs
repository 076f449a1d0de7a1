//! A sweep as aligned text, as a table for programs, and as a figure.

use super::{FunctionSweep, SweepPoint};
use robovec_error::yardstick::account::{ERROR_COLUMNS, ERROR_HEADS, measure_text};
use robovec_ir::diagnostic::counted;
use robovec_ir::machine::MemoryStyle;
use robovec_present::number::{exponential, or_dash};
use robovec_present::text::distinct;
use robovec_present::{
    AxisScale, Curve, DataCell, DataTable, Figure, Mark, Paint, Panel, PlotAxis, Stroke, text_table,
};

/// The front with the processor's time beside it, and what did not work.
pub fn text(sweep: &FunctionSweep) -> String {
    let head = ">share % | >tables | >memories | >multipliers | add+multi | stages | >estimated MHz | memory | buffer | \
         >instances | interconnect | >cycles | >bound | >latency us | >us/evaluation | \
         >uJ/evaluation | >CPU/FPGA | >program";
    let rows: Vec<Vec<String>> = sweep
        .front()
        .into_iter()
        .map(|point| row(point, sweep.cpu_us))
        .collect();
    let mut text = format!(
        "{}: {} on {}, {} on the front\n\n{}\n{}\n",
        sweep.name,
        counted(sweep.points.len(), "design"),
        sweep.device,
        rows.len(),
        text_table(&programs_head(), &programs(sweep)),
        text_table(head, &rows)
    );
    text += &format!(
        "errors of the programs in {}, in parts {}\n",
        sweep.number,
        measure_text(&sweep.states)
    );
    text += &verdict(sweep);
    text += &sweep.energy_text();
    if let Some((_, reason)) = sweep.failures.first() {
        let count = sweep.failures.len();
        text += &format!(
            "{} could not be placed, the first because {reason}\n",
            counted(count, "design")
        );
    }
    text
}

/// Heads of the table of programs.
fn programs_head() -> String {
    format!(">program | >operations | >longest chain | {ERROR_HEADS} | made by")
}

/// The programs: number, operations, longest chain on the thesis' machine,
/// the median and the worst error, and what made them.
fn programs(sweep: &FunctionSweep) -> Vec<Vec<String>> {
    let programs = sweep.programs.iter().enumerate();
    let rows = programs.map(|(index, program)| {
        vec![
            (index + 1).to_string(),
            program.operations.to_string(),
            program.path.to_string(),
            exponential(program.normwise.median),
            exponential(program.normwise.worst),
            program.name.clone(),
        ]
    });
    rows.collect()
}

fn row(point: &SweepPoint, cpu_us: Option<f64>) -> Vec<String> {
    let design = &point.design;
    vec![
        format!("{:.1}", 100.0 * point.share),
        format!("{:.0}", point.resources.look_up_tables),
        format!("{:.0}", point.resources.memory_blocks),
        format!("{:.0}", point.resources.multiplier_blocks),
        format!("{}+{}", design.adders, design.multipliers),
        format!("{}, {}", design.stages[0], design.stages[1]),
        format!("{:.0}", point.clock.mhz),
        memory_name(design.memory).to_owned(),
        buffer_name(design.buffer),
        design.instances.to_string(),
        design.interconnect.name().to_owned(),
        point.cycles.to_string(),
        point.lower_bound.to_string(),
        format!("{:.2}", point.latency_us),
        format!("{:.3}", point.us_per_evaluation),
        or_dash(point.energy_uj, |energy| format!("{energy:.3}")),
        or_dash(cpu_us, |cpu| {
            format!("{:.2}", cpu / point.us_per_evaluation)
        }),
        (point.program + 1).to_string(),
    ]
}

/// Which wins, in a sentence.
fn verdict(sweep: &FunctionSweep) -> String {
    let fitting = sweep.points.iter().filter(|point| point.share <= 1.0);
    let fastest = fitting.min_by(|a, b| a.us_per_evaluation.total_cmp(&b.us_per_evaluation));
    let Some(fastest) = fastest else {
        return "no design fits the device\n".to_owned();
    };
    let own = fastest.us_per_evaluation;
    let mut text = format!("the fastest design that fits takes {own:.3} us per evaluation");
    match sweep.cpu_us {
        Some(cpu) => {
            text += &format!(", one core of this computer {cpu:.3} us");
            if let Some(batch) = sweep.cpu_batch_us {
                text += &format!(" ({batch:.3} us each when it makes eight at once)");
            }
            let (winner, factor) = match cpu < own {
                true => ("processor", own / cpu),
                false => ("design", cpu / own),
            };
            text += &format!(": the {winner} wins by {factor:.1}");
        }
        None if !sweep.cpu_remark.is_empty() => {
            text += &format!("; there is no time of the processor: {}", sweep.cpu_remark);
        }
        None => {}
    }
    format!("{text}\n{}\n", jitter(sweep))
}

/// How much times differ from one evaluation to the next.
fn jitter(sweep: &FunctionSweep) -> String {
    let design = "jitter: a design takes the same cycles for every evaluation, 0 us (loading and \
                  reading by the host not counted)";
    match sweep.cpu_jitter_us {
        Some(jitter) => format!(
            "{design}; on this core one evaluation in a thousand takes {jitter:.3} us longer than \
             the median one"
        ),
        None => design.to_owned(),
    }
}

fn memory_name(style: MemoryStyle) -> &'static str {
    match style {
        MemoryStyle::Unified => "unified",
        MemoryStyle::SideSplit => "side-split",
        MemoryStyle::FourPort => "four-port",
    }
}

fn buffer_name(buffer: Option<u32>) -> String {
    buffer.map_or("none".to_owned(), |words| words.to_string())
}

/// All points of all functions as one table.
pub fn points_table(sweeps: &[FunctionSweep]) -> DataTable {
    let rows = sweeps.iter().flat_map(|sweep| {
        sweep.points.iter().map(|point| {
            let design = &point.design;
            let taken = &point.resources;
            vec![
                DataCell::text(&sweep.name),
                DataCell::count(design.adders),
                DataCell::count(design.multipliers),
                DataCell::count(design.stages[0]),
                DataCell::count(design.stages[1]),
                DataCell::number(point.clock.mhz, 1),
                DataCell::text(memory_name(design.memory)),
                DataCell::text(buffer_name(design.buffer)),
                DataCell::count(design.instances),
                DataCell::text(design.interconnect.name()),
                DataCell::text(&sweep.programs[point.program].name),
                DataCell::count(point.cycles),
                DataCell::count(point.lower_bound),
                DataCell::number(point.latency_us, 4),
                DataCell::number(point.us_per_evaluation, 4),
                (point.energy_uj).map_or(DataCell::Empty, |energy| DataCell::number(energy, 4)),
                DataCell::number(taken.look_up_tables, 0),
                DataCell::number(taken.memory_blocks, 0),
                DataCell::number(taken.multiplier_blocks, 0),
                DataCell::number(point.share, 4),
                sweep
                    .cpu_us
                    .map_or(DataCell::Empty, |time| DataCell::number(time, 4)),
                DataCell::text(exponential(sweep.programs[point.program].normwise.median)),
                DataCell::text(exponential(sweep.programs[point.program].normwise.worst)),
                DataCell::text(if point.on_front { "yes" } else { "" }),
            ]
        })
    });
    DataTable::new(
        "sweep",
        "Resources against time",
        format!(
            "Every design. The share is the largest of those of look-up tables, memory blocks and \
             multiplier blocks of the device ({}), by formulas; nothing is synthesised. The clock \
             is that which the model of the device estimates, as in every other command. Errors \
             are those of the program in {}, in parts of the largest element of an array, at \
             random states against double-double arithmetic.",
            devices(sweeps),
            distinct(sweeps.iter().map(|sweep| sweep.number.as_str())),
        ),
        &format!(
            "function | adders | multipliers | adder stages | multiplier stages | estimated clock (MHz) | \
         memory | buffer words | instances | interconnect | program | cycles | lower bound | \
         latency (us) | us per evaluation | energy (uJ) | look-up tables | memory blocks | multiplier blocks | share | CPU (us) | {ERROR_COLUMNS} | on front"
        ),
        rows,
    )
}

/// The devices of some sweeps.
pub(super) fn devices(sweeps: &[FunctionSweep]) -> String {
    distinct(sweeps.iter().map(|sweep| sweep.device.as_str()))
}

/// One panel per function: share of the device against time per evaluation.
pub fn figure(sweeps: &[FunctionSweep]) -> Figure {
    let panels: Vec<Panel> = sweeps.iter().map(panel).collect();
    Figure::new(
        "sweep",
        "Resources against time",
        format!(
            "Share of the device ({}) against the time of one evaluation.",
            devices(sweeps)
        ),
        panels.len().clamp(1, 2),
        panels,
    )
    .with_note(
        Stroke::Plain,
        "The line joins the designs that no other one beats.",
    )
    .with_note(
        Stroke::Dashed,
        "The dashed line is a core of this computer.",
    )
}

fn panel(sweep: &FunctionSweep) -> Panel {
    let mark = |point: &SweepPoint| Mark::at(100.0 * point.share, point.us_per_evaluation);
    let mut instances: Vec<u32> = sweep.points.iter().map(|p| p.design.instances).collect();
    instances.sort_unstable();
    instances.dedup();
    let mut curves = vec![Curve::new(
        "front",
        Paint::Distinct(0),
        Stroke::Plain,
        sweep.front().into_iter().map(mark),
    )];
    for (place, count) in instances.into_iter().enumerate() {
        let own = sweep.points.iter();
        let own = own.filter(|point| point.design.instances == count);
        curves.push(Curve::points(
            format!("{count} at once"),
            place + 1,
            own.map(mark),
        ));
    }
    if let Some(cpu) = sweep.cpu_us {
        let shares = || sweep.points.iter().map(|point| 100.0 * point.share);
        let ends = [
            shares().fold(f64::INFINITY, f64::min),
            shares().fold(0.0, f64::max),
        ];
        curves.push(Curve::new(
            "processor",
            Paint::Distinct(curves.len()),
            Stroke::Dashed,
            ends.map(|share| Mark::at(share, cpu)),
        ));
    }
    Panel::curves(
        sweep.name.clone(),
        PlotAxis::new("share of the device (%)", AxisScale::Decades),
        PlotAxis::new("time per evaluation (us)", AxisScale::Decades),
        curves,
    )
}
