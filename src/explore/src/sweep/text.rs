//! A sweep as aligned text, as a table for programs, and as a figure.

use super::{FunctionSweep, SweepPoint, SweptProgram};
use crate::captions;
use crate::exploration::Exploration;
use robovec_error::yardstick::account::{ERROR_HEADS, measure_text};
use robovec_ir::diagnostic::counted;
use robovec_present::page;
use robovec_present::text::distinct;
use robovec_present::{
    AxisScale, ColumnList, Curve, DataTable, Figure, Mark, Paint, Panel, PlotAxis, Stroke, columns,
};

/// The table of programs.
fn programs(sweep: &FunctionSweep) -> String {
    type Row<'a> = (usize, &'a SweptProgram);
    let [median, worst] = ERROR_HEADS;
    let rows: Vec<Row<'_>> = sweep.programs.iter().enumerate().collect();
    let columns = columns! { Row<'_>;
        "program", [All, Hidden], |row| row.0 + 1;
        "operations", [All, Hidden], |row| row.1.operations;
        "longest chain", [All, Hidden], |row| row.1.path;
        median, [Exponent(1), Hidden], |row| row.1.normwise.median;
        worst, [Exponent(1), Hidden], |row| row.1.normwise.worst;
        "made by", [All, Hidden], |row| row.1.name.as_str();
    };
    columns.text(&rows)
}

type DesignRow<'a> = (&'a FunctionSweep, &'a SweepPoint);

fn design_columns<'a>() -> ColumnList<'a, DesignRow<'a>> {
    let [median, worst] = ERROR_HEADS;
    let error = |row: &DesignRow<'_>| row.0.programs[row.1.program].normwise;
    let elements =
        |row: &DesignRow<'_>| format!("{}+{}", row.1.design.adders, row.1.design.multipliers);
    let stages = |row: &DesignRow<'_>| {
        row.1
            .design
            .stages
            .map(|count| count.to_string())
            .join(", ")
    };
    columns! { DesignRow<'_>;
        "function", [Hidden, All], |row| row.0.name.as_str();
        "share %", [Decimals(1), Hidden], |row| 100.0 * row.1.share;
        "add+multi", [All, Hidden], elements;
        "adders", [Hidden, All], |row| row.1.design.adders;
        "multipliers", [Hidden, All], |row| row.1.design.multipliers;
        "stages", [All, Hidden], stages;
        "adder stages", [Hidden, All], |row| row.1.design.stages[0];
        "multiplier stages", [Hidden, All], |row| row.1.design.stages[1];
        "estimated clock (MHz)", [Decimals(0), Decimals(1)], |row| row.1.clock.mhz;
        "memory", [All, All], |row| row.1.design.memory.name();
        "buffer words", [All, All], |row| buffer_name(row.1.design.buffer);
        "instances", [All, All], |row| row.1.design.instances;
        "interconnect", [All, All], |row| row.1.design.interconnect.name();
        "program", [All, Hidden], |row| row.1.program + 1;
        "program", [Hidden, All], |row| row.0.programs[row.1.program].name.as_str();
        "cycles", [All, All], |row| row.1.cycles;
        "lower bound", [All, All], |row| row.1.lower_bound;
        "latency (us)", [Decimals(2), Decimals(4)], |row| row.1.latency_us;
        "us per evaluation", [Decimals(3), Decimals(4)], |row| row.1.us_per_evaluation;
        "energy (uJ)", [Decimals(3), Decimals(4)], |row| row.1.energy_uj;
        "look-up tables", [Decimals(0), Decimals(0)], |row| row.1.resources.look_up_tables;
        "memory blocks", [Decimals(0), Decimals(0)], |row| row.1.resources.memory_blocks;
        "multiplier blocks", [Decimals(0), Decimals(0)], |row| row.1.resources.multiplier_blocks;
        "share", [Hidden, Decimals(4)], |row| row.1.share;
        "CPU (us)", [Hidden, Decimals(4)], |row| row.0.cpu_us;
        "CPU/FPGA", [Decimals(2), Hidden], |row| Some(row.0.cpu_us? / row.1.us_per_evaluation);
        median, [Hidden, Exponent(1)], move |row| error(row).median;
        worst, [Hidden, Exponent(1)], move |row| error(row).worst;
        "on front", [Hidden, All], |row| if row.1.on_front { "yes" } else { "" };
    }
}

/// Winner, in a sentence.
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
            let (winner, factor) = if cpu < own {
                ("processor", own / cpu)
            } else {
                ("design", cpu / own)
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

/// Variation of times from one evaluation to the next.
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

fn buffer_name(buffer: Option<u32>) -> String {
    buffer.map_or("none".to_owned(), |words| words.to_string())
}

impl Exploration for FunctionSweep {
    const POINTS: &'static str = "All designs";
    const METHOD: &'static str = include_str!("method.html");

    fn name(&self) -> &str {
        &self.name
    }

    /// The front with the processor's time beside it, and what did not work.
    fn text(&self) -> String {
        let rows: Vec<DesignRow<'_>> = self
            .front()
            .into_iter()
            .map(|point| (self, point))
            .collect();
        let mut text = format!(
            "{}: {} on {}, {} on the front\n\n{}\n{}\n",
            self.name,
            counted(self.points.len(), "design"),
            self.device,
            rows.len(),
            programs(self),
            design_columns().text(&rows)
        );
        text += &format!(
            "errors of the programs in {}, in parts {}\n",
            self.number,
            measure_text(&self.states)
        );
        text += &verdict(self);
        text += &self.energy_text();
        if let Some((_, reason)) = self.failures.first() {
            let count = self.failures.len();
            text += &format!(
                "{} could not be placed, the first because {reason}\n",
                counted(count, "design")
            );
        }
        text
    }

    fn table(sweeps: &[FunctionSweep]) -> DataTable {
        let rows = sweeps.iter();
        let rows = rows.flat_map(|sweep| sweep.points.iter().map(move |point| (sweep, point)));
        let rows: Vec<DesignRow<'_>> = rows.collect();
        let numbers = distinct(sweeps.iter().map(|sweep| sweep.number.as_str()));
        let words = [("devices", &*devices(sweeps)), ("numbers", &numbers)];
        DataTable {
            name: "explore".to_owned(),
            ..captions::table("sweep", &words, &design_columns(), &rows)
        }
    }

    /// One panel per function: share of the device against time per evaluation.
    fn figure(sweeps: &[FunctionSweep]) -> Figure {
        let panels = sweeps.iter().map(panel).collect();
        let words = [("devices", &*devices(sweeps))];
        let line = "The line joins the designs that no other one beats.";
        let dashed = "The dashed line is a core of this computer.";
        captions::figure("sweep", "explore", &words, panels)
            .expect("a function has a panel")
            .with_note(Stroke::Plain, line)
            .with_note(Stroke::Dashed, dashed)
    }

    fn machines(sweeps: &[FunctionSweep]) -> [String; 2] {
        let devices = devices(sweeps);
        [format!("{devices}."), devices]
    }

    fn opening(sweeps: &[FunctionSweep], figure: String) -> String {
        let mut fronts = Self::table(sweeps);
        let last = fronts.columns.len() - 1;
        fronts.rows.retain(|row| !row[last].plain().is_empty());
        fronts.title = "Designs that no other one beats".to_owned();
        figure + &page::table(&fronts, "explore.csv")
    }
}

/// The devices of some sweeps.
fn devices(sweeps: &[FunctionSweep]) -> String {
    distinct(sweeps.iter().map(|sweep| sweep.device.as_str()))
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
