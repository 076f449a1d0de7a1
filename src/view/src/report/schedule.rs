//! Cost of a schedule, and the use of its machine.

use robovec_fpga::hardware::{self, MachineClock};
use robovec_ir::placement::{ElementKind, Schedule};
use robovec_ir::{Format, Function, Machine, Operation};
use robovec_schedule::{ElementSpread, KindStatistics, PlacementStatistics, placement_statistics};
use serde::{Serialize, Serializer};

/// Cycles, processing elements and their content.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ScheduleReport {
    /// The machine's name.
    pub machine: String,
    /// Hash of the machine's content; absent when the schedule does not specify it.
    pub machine_hash: Option<String>,
    /// Its number format: `binary32`, `binary64`, or a name as
    /// `float(8,10)`; absent as `time_us` is.
    pub number: Option<String>,
    /// Elements that add.
    pub n_add: u32,
    /// Elements that multiply.
    pub n_multi: u32,
    /// Length: the first cycle in which every result can be read.
    pub cycles: u32,
    /// No schedule on this machine is shorter (proved).
    pub lower_bound: u32,
    /// The machine's clock with the elements of the schedule, and its origin;
    /// absent when the machine available is not that of the schedule.
    pub clock: Option<MachineClock>,
    /// Length at that clock, in microseconds.
    pub time_us: Option<f64>,
    /// Operations over elements times cycles: the used share of issue slots.
    pub parallelisation_rate: f64,
    /// Words of memory used per element; absent before `place`.
    pub memory: Option<ByKind>,
    /// Words of buffer used per element; absent before `place`.
    pub buffer: Option<ByKind>,
    /// Travel of results; absent before `place`.
    pub transfers: Option<TransferReport>,
    /// The kinds of elements and their use.
    pub elements: Vec<KindReport>,
}

/// A kind of processing element.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct KindReport {
    /// The kind's name.
    pub kind: String,
    /// Number of all.
    pub count: u32,
    /// Operations they perform.
    pub operations: usize,
    /// For each of 64 equal slices of the run the used share of issue slots.
    pub occupation: Vec<f64>,
}

/// Travel of results between the elements.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct TransferReport {
    /// Words filled before the run.
    pub preloads: u32,
    /// Writes in the cycle in which the result appears.
    pub direct: u32,
    /// Writes through a buffer.
    pub indirect: u32,
    /// Results that pass through a buffer.
    pub buffered: u32,
    /// Number of operations of each rank of the thesis' Table 2.1, from rank
    /// 1 (both operands wait in memory) on.
    pub ranks: [u32; 9],
}

impl TransferReport {
    fn new(statistics: &PlacementStatistics) -> TransferReport {
        TransferReport {
            preloads: statistics.preloads,
            direct: statistics.direct_writes,
            indirect: statistics.indirect_writes,
            buffered: statistics.buffered_results,
            ranks: statistics.ranks,
        }
    }
}

/// Usage per kind of element, in the machine's order; an object in JSON.
#[derive(Clone, PartialEq, Debug)]
pub struct ByKind(pub Vec<(String, ElementSpread)>);

impl Serialize for ByKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(kind, usage)| (kind, usage)))
    }
}

/// Number of slices of a run for the chart of its occupation.
pub(super) const SLICES: usize = 64;

impl ScheduleReport {
    pub(super) fn collect(function: &Function, machine: &Machine) -> Option<ScheduleReport> {
        let schedule = function.schedule.as_ref()?;
        let performs = |operation| {
            let kind = machine.kind_of(operation);
            let own = kind.and_then(|kind| {
                let name = &machine.elements[kind].kind;
                schedule.kinds.iter().find(|kind| kind.name == *name)
            });
            own.map_or(0, |kind| kind.count)
        };
        let issued = schedule.slots.iter().flatten().count();
        let capacity = f64::from(schedule.element_count()) * f64::from(schedule.cycles);
        let placed = placement_statistics(function, machine);
        let words = |pick: fn(&KindStatistics) -> ElementSpread| {
            let kinds = placed.as_ref()?.kinds.iter();
            let words = kinds.map(|kind| (kind.kind.clone(), pick(kind)));
            Some(ByKind(words.collect()))
        };
        let own = schedule.check_machine(machine).is_ok().then_some(machine);
        let clock = own.map(|machine| {
            let kinds = schedule.kinds.iter();
            let counts = kinds.map(|kind| (kind.name.as_str(), kind.count));
            hardware::clock_with_elements(machine, counts)
        });
        Some(ScheduleReport {
            machine: schedule.machine.clone(),
            machine_hash: schedule.machine_hash.map(|hash| hash.text()),
            number: own.map(|machine| format_name(machine.number)),
            n_add: performs(Operation::Add),
            n_multi: performs(Operation::Mul),
            cycles: schedule.cycles,
            lower_bound: schedule.lower_bound,
            clock,
            time_us: clock.map(|clock| clock.microseconds(schedule.cycles)),
            parallelisation_rate: if capacity > 0.0 {
                issued as f64 / capacity
            } else {
                0.0
            },
            memory: words(|kind| kind.memory),
            buffer: words(|kind| kind.buffer),
            transfers: placed.as_ref().map(TransferReport::new),
            elements: occupation(schedule),
        })
    }
}

fn format_name(format: Format) -> String {
    match format {
        Format::BINARY32 => "binary32".to_owned(),
        Format::BINARY64 => "binary64".to_owned(),
        other => other.to_string(),
    }
}

/// Share of the time in which each kind is busy, slice by slice.
fn occupation(schedule: &Schedule) -> Vec<KindReport> {
    let cycles = u64::from(schedule.cycles.max(1));
    let mut kinds: Vec<usize> = Vec::new();
    for (index, kind) in schedule.kinds.iter().enumerate() {
        kinds.extend((0..kind.count).map(|_| index));
    }
    let mut issued = vec![[0u32; SLICES]; schedule.kinds.len()];
    for slot in schedule.slots.iter().flatten() {
        assert!(
            u64::from(slot.cycle) < cycles,
            "an operation starts within the schedule"
        );
        let slice = u64::from(slot.cycle) * SLICES as u64 / cycles;
        issued[kinds[slot.element.index()]][slice as usize] += 1;
    }
    // Slices differ by a cycle when the length is no multiple of their
    // number: the first cycle of a slice is where the division rounds up.
    let start = |slice: usize| (slice as u64 * cycles).div_ceil(SLICES as u64);
    let describe = |(kind, issued): (&ElementKind, &[u32; SLICES])| {
        let share = |slice: usize| {
            let slots = (start(slice + 1) - start(slice)) * u64::from(kind.count);
            debug_assert!(
                u64::from(issued[slice]) <= slots,
                "an element starts one operation in a cycle"
            );
            if slots == 0 {
                0.0
            } else {
                f64::from(issued[slice]) / slots as f64
            }
        };
        KindReport {
            kind: kind.name.clone(),
            count: kind.count,
            operations: issued.iter().map(|&count| count as usize).sum(),
            occupation: (0..SLICES).map(share).collect(),
        }
    };
    schedule.kinds.iter().zip(&issued).map(describe).collect()
}
