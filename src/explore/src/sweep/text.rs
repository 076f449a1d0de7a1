//! A sweep as aligned text, as a table for programs, and as a figure.

use super::{FunctionSweep, SweepPoint, SweptProgram};
use crate::captions;
use crate::exploration::Exploration;
use crate::front::{STEPS, front_curve};
use robovec_error::yardstick::account::{ERROR_HEADS, measure_text};
use robovec_ir::diagnostic::counted;
use robovec_present::number::{exponential, share_percent};
use robovec_present::page;
use robovec_present::text::{distinct, thinned};
use robovec_present::{
    AxisScale, ColumnList, Curve, DataTable, Figure, Mark, Paint, Panel, PlotAxis, Stroke, columns,
};

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

/// Maximum number of rows on the terminal.
const SHOWN: usize = 10;

type DesignRow<'a> = (&'a FunctionSweep, &'a SweepPoint);

fn elements_text((_, point): &DesignRow<'_>) -> String {
    format!("{}+{}", point.design.adders, point.design.multipliers)
}

fn stages_text((_, point): &DesignRow<'_>) -> String {
    point
        .design
        .stages
        .map(|count| count.to_string())
        .join(", ")
}

fn short_columns<'a>() -> ColumnList<'a, DesignRow<'a>> {
    columns! { DesignRow<'_>;
        "share %", [Decimals(1), All], |row| 100.0 * row.1.share;
        "elements", [All, All], elements_text;
        "stages", [All, All], stages_text;
        "memory", [All, All], |row| row.1.design.memory.name();
        "buffer", [All, All], |row| buffer_name(row.1.design.buffer);
        "at once", [All, All], |row| row.1.design.instances;
        "us per evaluation", [Decimals(3), All], |row| row.1.us_per_evaluation;
    }
}

fn design_columns<'a>() -> ColumnList<'a, DesignRow<'a>> {
    let [median, worst] = ERROR_HEADS;
    let error = |row: &DesignRow<'_>| row.0.programs[row.1.program].normwise;
    columns! { DesignRow<'_>;
        "function", [Hidden, All], |row| row.0.name.as_str();
        "share %", [Decimals(1), Hidden], |row| 100.0 * row.1.share;
        "add+multi", [All, Hidden], elements_text;
        "adders", [Hidden, All], |row| row.1.design.adders;
        "multipliers", [Hidden, All], |row| row.1.design.multipliers;
        "stages", [All, Hidden], stages_text;
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

impl FunctionSweep {
    /// The fastest design that fits the device, the smallest of equal ones.
    fn fastest(&self) -> Option<&SweepPoint> {
        let mut front = self.front();
        front.retain(|point| point.share <= 1.0);
        front.last().copied()
    }

    /// The time of the processor beside that of a design.
    fn processor_text(&self, own: f64) -> Option<String> {
        let Some(cpu) = self.cpu_us else {
            let remark = &self.cpu_remark;
            return (!remark.is_empty()).then(|| format!("not timed: {remark}"));
        };
        let batch = self
            .cpu_batch_us
            .map(|batch| format!(" ({batch:.3} us each when it makes eight at once)"));
        let (winner, factor) = if cpu < own {
            ("processor", own / cpu)
        } else {
            ("design", cpu / own)
        };
        Some(format!(
            "one core of this computer takes {cpu:.3} us{}: the {winner} wins by {factor:.1}",
            batch.unwrap_or_default()
        ))
    }

    /// Variation of times from one evaluation to the next.
    fn jitter_text(&self) -> String {
        let core = self.cpu_jitter_us.map(|jitter| {
            format!(
                "; on this core one evaluation in a thousand takes {jitter:.3} us longer than the \
                 median one"
            )
        });
        format!(
            "0 us: a design takes the same cycles for every evaluation, loading and reading by the \
             host not counted{}",
            core.unwrap_or_default()
        )
    }
}

/// A design with its speed and its share of the device.
fn design_text(point: &SweepPoint) -> String {
    let design = &point.design;
    let bound = if point.cycles == point.lower_bound {
        ", no schedule is shorter"
    } else {
        ""
    };
    format!(
        "{}+{} elements of {}+{} stages, {} memories, buffer {}, {}, {} at once: {} cycles{bound}, \
         {}, {:.3} us per evaluation, {} of the device (estimated)",
        design.adders,
        design.multipliers,
        design.stages[0],
        design.stages[1],
        design.memory.name(),
        buffer_name(design.buffer),
        design.interconnect.name(),
        design.instances,
        point.cycles,
        point.clock.text(),
        point.us_per_evaluation,
        share_percent(point.share),
    )
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

    fn headline(&self) -> String {
        let (front, fastest) = (self.front(), self.fastest());
        let Some(([smallest, ..], fastest)) = Some(front.as_slice()).zip(fastest) else {
            return "no design fits the device".to_owned();
        };
        let (before, after) = (smallest.us_per_evaluation, fastest.us_per_evaluation);
        if front.len() == 1 {
            return format!("{after:.3} us per evaluation in the only design of the front");
        }
        format!(
            "{:.2} times faster than the smallest design: {before:.3} -> {after:.3} us",
            before / after
        )
    }

    fn lines(&self) -> Vec<(&'static str, String)> {
        let mut lines = Vec::new();
        if let Some(fastest) = self.fastest() {
            let smallest = self.front()[0];
            lines.push(("fastest", design_text(fastest)));
            if smallest != fastest {
                lines.push(("smallest", design_text(smallest)));
            }
            let program = &self.programs[fastest.program];
            lines.push(("program", program.name.clone()));
            lines.push((
                "worst error",
                format!(
                    "{} in {}, median {}, {}",
                    exponential(program.normwise.worst),
                    self.number,
                    exponential(program.normwise.median),
                    measure_text(&self.states)
                ),
            ));
            let processor = self.processor_text(fastest.us_per_evaluation);
            lines.extend(processor.map(|text| ("processor", text)));
        }
        lines.push(("jitter", self.jitter_text()));
        lines.extend(self.energy().into_iter().map(|text| ("energy", text)));
        let designs = counted(self.points.len(), "design");
        let front = self.front().len();
        let designs = format!("{designs} on {}, {front} on the front", self.device);
        lines.push(("compared", designs));
        if let Some((_, reason)) = self.failures.first() {
            let count = counted(self.failures.len(), "design");
            lines.push(("not placed", format!("{count}, the first because {reason}")));
        }
        lines
    }

    fn short_table(&self) -> String {
        let rows: Vec<DesignRow<'_>> = thinned(&self.front(), SHOWN)
            .into_iter()
            .map(|point| (self, point))
            .collect();
        short_columns().text(&rows)
    }

    fn details(&self) -> String {
        let front = self.front().into_iter();
        let rows: Vec<DesignRow<'_>> = front.map(|point| (self, point)).collect();
        format!("{}\n{}\n", programs(self), design_columns().text(&rows))
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

    fn figure(sweeps: &[FunctionSweep]) -> Figure {
        let panels = sweeps.iter().map(panel).collect();
        let words = [("devices", &*devices(sweeps))];
        let dashed = "The dashed line is a core of this computer.";
        captions::figure("sweep", "explore", &words, panels)
            .expect("a function has a panel")
            .with_note(Stroke::Steps, STEPS)
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
        fronts.caption = "Every other design takes more of the device or more time.".to_owned();
        figure + &page::table(&fronts, "explore.csv")
    }
}

fn devices(sweeps: &[FunctionSweep]) -> String {
    distinct(sweeps.iter().map(|sweep| sweep.device.as_str()))
}

fn panel(sweep: &FunctionSweep) -> Panel {
    let mark = |point: &SweepPoint| Mark::at(100.0 * point.share, point.us_per_evaluation);
    let mut instances: Vec<u32> = sweep.points.iter().map(|p| p.design.instances).collect();
    instances.sort_unstable();
    instances.dedup();
    let mut curves = vec![front_curve(sweep.front().into_iter().map(mark))];
    for (place, count) in instances.into_iter().enumerate() {
        let own = sweep.points.iter();
        let own = own.filter(|point| point.design.instances == count);
        curves.push(Curve::points(
            format!("{count} at once"),
            place + 3,
            own.map(mark),
        ));
    }
    let smallest = sweep.front().into_iter().next();
    for (name, point, colour) in [("smallest", smallest, 1), ("fastest", sweep.fastest(), 2)] {
        let marks = point.map(mark);
        let label = marks
            .iter()
            .map(|mark| format!("{name} {:.1} %, {:.3}", mark.x, mark.y));
        curves.push(Curve::points(label.collect::<String>(), colour, marks));
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
