//! Programs that were made, with their figures.

use super::steps::SearchStep;
use robovec_analysis::critical_path::critical_path;
use robovec_ir::count::Counts;
use robovec_ir::{Function, Machine, Operation};
use robovec_schedule::{PlaceError, schedule_bound};

/// A program with its figures.
#[derive(Clone, Debug)]
pub struct VariantTrial<P> {
    /// The steps it went through.
    pub name: String,
    /// Index of its start.
    pub start: usize,
    /// The passes from the start on.
    pub pipeline: String,
    /// The program itself.
    pub program: P,
    /// Operations.
    pub operations: usize,
    /// The longest path, in cycles.
    pub path: u32,
    /// A lower bound of every schedule; the reason when there is no schedule.
    pub bound: Result<u32, PlaceError>,
    /// The schedule, where one was made.
    pub cycles: Option<u32>,
    /// The maximum number of words of memory that it needs in one element, both
    /// sides of a split one together.
    pub words: Option<u32>,
    /// The reason why it was not placed.
    pub remark: &'static str,
    /// The preparation, if it alone made the program from a start.
    pub preparation: Option<&'static SearchStep>,
    /// No schedule is shorter for want of elements alone.
    pub(super) shared: u32,
    /// True when moves were tried on it, or there is no sense in trying.
    pub(super) is_expanded: bool,
}

impl<P> VariantTrial<P> {
    /// A program with the figures that are available without placing it.
    pub(super) fn new(
        (name, start, pipeline): (String, usize, String),
        program: P,
        function: impl Fn(&P) -> &Function,
        machine: &Machine,
    ) -> VariantTrial<P> {
        let function = function(&program);
        let bound = schedule_bound(function, machine);
        let (operations, shared) = (Counts::of(function).operations, shared(function, machine));
        let path = critical_path(function, machine).asap_cycle;
        VariantTrial {
            name,
            start,
            pipeline,
            program,
            operations,
            path,
            remark: match bound {
                Ok(_) => "",
                Err(_) => "cannot be placed",
            },
            bound,
            cycles: None,
            words: None,
            preparation: None,
            shared,
            is_expanded: false,
        }
    }

    /// True when the figures of two programs agree, so that they are the same
    /// as far as a search is concerned.
    pub(super) fn looks_like(&self, other: &VariantTrial<P>) -> bool {
        let figures = |trial: &VariantTrial<P>| {
            let bound = trial.bound.as_ref().ok().copied();
            (trial.operations, trial.path, trial.shared, bound)
        };
        figures(self) == figures(other)
    }
}

/// The operations of the scarcest kind over its elements.
fn shared(function: &Function, machine: &Machine) -> u32 {
    let mut operations = [0_u32; Operation::ALL.len()];
    for node in function.nodes() {
        operations[node.operation as usize] += 1;
    }
    let of_kind = machine.elements.iter().map(|element| {
        let performed = Operation::ALL
            .into_iter()
            .filter(|&known| element.performs(known));
        let count: u32 = performed.map(|known| operations[known as usize]).sum();
        count.div_ceil(element.count)
    });
    of_kind.fold(0, u32::max)
}
