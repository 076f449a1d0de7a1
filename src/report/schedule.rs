//! What a schedule costs, and how well it uses its machine.

use robovec_ir::machine::NumberFormat;
use robovec_ir::placement::{Bank, ElementKind, Placement, Schedule, Word};
use robovec_ir::{Function, Machine, Operation};
use serde::{Serialize, Serializer};

/// Cycles, processing elements and what they hold.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ScheduleReport {
    /// The machine's name.
    pub machine: String,
    /// Its number format: `binary32`, `binary64`, or `e8m10` for 8 bits of
    /// exponent and 10 of mantissa; absent as `time_us` is.
    pub number: Option<String>,
    /// Elements that add.
    pub n_add: u32,
    /// Elements that multiply.
    pub n_multi: u32,
    /// Length: the first cycle in which every result can be read.
    pub cycles: u32,
    /// No schedule on this machine is shorter (proved).
    pub lower_bound: u32,
    /// Length at the machine's clock, in microseconds; absent when the
    /// machine at hand is another one than that of the schedule.
    pub time_us: Option<f64>,
    /// Operations over elements times cycles: the share of all issue slots
    /// that is used.
    pub parallelisation_rate: f64,
    /// Words of memory used per element; absent before `place`.
    pub memory: Option<ByKind>,
    /// Words of buffer used per element; absent before `place`.
    pub buffer: Option<ByKind>,
    /// The kinds of elements and how busy they are.
    pub elements: Vec<KindReport>,
}

/// A kind of processing element.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct KindReport {
    /// The kind's name.
    pub kind: String,
    /// How many there are.
    pub count: u32,
    /// Operations they perform.
    pub operations: usize,
    /// For each of 64 equal slices of the run the share of their
    /// issue slots that is used.
    pub occupation: Vec<f64>,
}

/// Words used by the elements of a kind.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Usage {
    /// By the element that uses fewest.
    pub min: u32,
    /// On average.
    pub mean: f64,
    /// By the element that uses most.
    pub max: u32,
}

/// Usage per kind of element, in the machine's order; an object in JSON.
#[derive(Clone, PartialEq, Debug)]
pub struct ByKind(pub Vec<(String, Usage)>);

impl Serialize for ByKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(kind, usage)| (kind, usage)))
    }
}

/// Into how many slices a run is divided to show its occupation.
pub(super) const SLICES: usize = 64;

impl ScheduleReport {
    pub(super) fn collect(function: &Function, machine: &Machine) -> Option<ScheduleReport> {
        let schedule = function.schedule.as_ref()?;
        let performs = |operation| {
            let kind = machine.kind_of(operation)?;
            let name = &machine.elements[kind].kind;
            let mut kinds = schedule.kinds.iter();
            kinds.find(|kind| kind.name == *name).map(|kind| kind.count)
        };
        let issued = schedule.slots.iter().filter(|slot| !slot.is_host()).count();
        let capacity = f64::from(schedule.element_count()) * f64::from(schedule.cycles);
        let words = function
            .placement
            .as_ref()
            .map(|_| words_used(function, schedule));
        let own = (machine.name == schedule.machine).then_some(machine);
        Some(ScheduleReport {
            machine: schedule.machine.clone(),
            number: own.map(|machine| format_name(machine.number)),
            n_add: performs(Operation::Add).unwrap_or(0),
            n_multi: performs(Operation::Mul).unwrap_or(0),
            cycles: schedule.cycles,
            lower_bound: schedule.lower_bound,
            time_us: own.map(|machine| f64::from(schedule.cycles) / machine.clock_mhz),
            parallelisation_rate: if capacity > 0.0 {
                issued as f64 / capacity
            } else {
                0.0
            },
            memory: words.as_ref().map(|(memory, _)| by_kind(schedule, memory)),
            buffer: words.as_ref().map(|(_, buffer)| by_kind(schedule, buffer)),
            elements: occupation(schedule),
        })
    }
}

/// The name of a number format; flushing subnormals to zero is marked.
fn format_name(format: NumberFormat) -> String {
    let name = match (format.exponent, format.mantissa) {
        (8, 23) => "binary32".to_owned(),
        (11, 52) => "binary64".to_owned(),
        (exponent, mantissa) => format!("e{exponent}m{mantissa}"),
    };
    if format.subnormals {
        name
    } else {
        format!("{name}, subnormals as zero")
    }
}

/// Words of memory (both sides of a split one together) and of buffer that
/// each element uses: one more than the highest address.
fn words_used(function: &Function, schedule: &Schedule) -> (Vec<u32>, Vec<u32>) {
    let elements = schedule.element_count() as usize;
    let mut sides = vec![[0u32; 2]; elements];
    let mut buffers = vec![0u32; elements];
    let Some(placement) = &function.placement else {
        return (buffers.clone(), buffers);
    };
    let mut touch = |word: Word| {
        let side = usize::from(word.bank == Bank::Right);
        let used = &mut sides[word.element as usize][side];
        *used = (*used).max(word.address + 1);
    };
    placement
        .preloads
        .iter()
        .for_each(|preload| touch(preload.word));
    placement.writes.iter().for_each(|write| touch(write.word));
    for (slot, &buffer) in schedule.slots.iter().zip(&placement.buffers) {
        if buffer != Placement::NONE && !slot.is_host() {
            let used = &mut buffers[slot.element as usize];
            *used = (*used).max(buffer + 1);
        }
    }
    (sides.into_iter().map(|[a, b]| a + b).collect(), buffers)
}

fn by_kind(schedule: &Schedule, words: &[u32]) -> ByKind {
    let mut rest = words;
    let mut kinds = Vec::new();
    for kind in &schedule.kinds {
        let (own, others) = rest.split_at(kind.count as usize);
        rest = others;
        let total: u64 = own.iter().map(|&words| u64::from(words)).sum();
        let usage = Usage {
            min: own.iter().copied().min().unwrap_or(0),
            mean: total as f64 / own.len().max(1) as f64,
            max: own.iter().copied().max().unwrap_or(0),
        };
        kinds.push((kind.name.clone(), usage));
    }
    ByKind(kinds)
}

/// How busy each kind is, slice by slice.
fn occupation(schedule: &Schedule) -> Vec<KindReport> {
    let cycles = u64::from(schedule.cycles.max(1));
    let mut kinds: Vec<usize> = Vec::new();
    for (index, kind) in schedule.kinds.iter().enumerate() {
        kinds.extend((0..kind.count).map(|_| index));
    }
    let mut issued = vec![[0u32; SLICES]; schedule.kinds.len()];
    for slot in schedule.slots.iter().filter(|slot| !slot.is_host()) {
        let slice = u64::from(slot.cycle) * SLICES as u64 / cycles;
        issued[kinds[slot.element as usize]][slice as usize] += 1;
    }
    // Slices differ by a cycle when the length is no multiple of their
    // number: the first cycle of a slice is where the division rounds up.
    let start = |slice: usize| (slice as u64 * cycles).div_ceil(SLICES as u64);
    let describe = |(kind, issued): (&ElementKind, &[u32; SLICES])| {
        let share = |slice: usize| {
            let slots = (start(slice + 1) - start(slice)) * u64::from(kind.count);
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
