//! Placing one program on machines with other numbers of elements.

use robovec_ir::placement::Schedule;
use robovec_ir::{Function, Machine, Module, Operation, verify};
use robovec_schedule::{
    PlaceError, PlaceOptions, PlaceSummary, PlacementStatistics, most_memory_words, place,
    placement_statistics,
};

/// A machine with this number of adders and multipliers, else unchanged.
pub fn with_elements(machine: &Machine, [add, multi]: [u32; 2]) -> Machine {
    with_counts(machine, &[(Operation::Add, add), (Operation::Mul, multi)])
}

/// A machine with these numbers of adders, and of multipliers and fused ones.
pub fn with_fused(machine: &Machine, [add, multi]: [u32; 2]) -> Machine {
    let machine = with_elements(machine, [add, multi]);
    with_counts(&machine, &[(Operation::Fma, multi)])
}

/// A machine with this number of elements that perform these operations; a kind
/// of several operations has the last number, others are unchanged.
fn with_counts(machine: &Machine, counts: &[(Operation, u32)]) -> Machine {
    let mut machine = machine.clone();
    for &(operation, count) in counts {
        if let Some(kind) = machine.kind_of(operation) {
            machine.elements[kind].count = count;
        }
    }
    machine
}

/// A function on a machine.
pub struct PlacedFunction {
    /// The function, with schedule and placement.
    pub function: Function,
    /// Summary of the placer.
    pub summary: PlaceSummary,
}

/// Places the first function of a module.
pub fn placed(
    module: &Module,
    machine: &Machine,
    options: PlaceOptions,
) -> Result<PlacedFunction, PlaceError> {
    let mut function = module.functions[0].clone();
    let summary = place(&mut function, machine, options)?;
    Ok(PlacedFunction { function, summary })
}

/// As [`placed`], accepted by the verifier.
///
/// # Errors
///
/// The reason why there is no placement, for users.
pub fn verified(
    module: &Module,
    machine: &Machine,
    options: PlaceOptions,
) -> Result<PlacedFunction, String> {
    let placed = placed(module, machine, options).map_err(|error| error.to_string())?;
    let view = module.tables.view(&placed.function);
    match verify::verify_placement(view, machine).first() {
        Some(violation) => {
            let message = &violation.message;
            Err(format!("the verifier refuses the placement: {message}"))
        }
        None => Ok(placed),
    }
}

impl PlacedFunction {
    /// Use of the machine by its placement.
    pub fn statistics(&self, machine: &Machine) -> PlacementStatistics {
        placement_statistics(&self.function, machine).expect("what is placed has a placement")
    }

    /// The maximum number of words of one operand memory of an element.
    pub fn most_words(&self, machine: &Machine) -> u32 {
        let words = most_memory_words(&self.function).expect("what is placed has a placement");
        words_of_a_side(words, machine)
    }
}

/// Words of one memory of an element whose memories have this sum.
pub fn words_of_a_side(words: u32, machine: &Machine) -> u32 {
    words.div_ceil(machine.memory.style.banks() as u32)
}

/// A machine with the numbers of elements that a schedule was made for.
pub fn scheduled_machine(machine: &Machine, schedule: &Schedule) -> Machine {
    let mut machine = machine.clone();
    for element in &mut machine.elements {
        let mut kinds = schedule.kinds.iter();
        if let Some(kind) = kinds.find(|kind| kind.name == element.kind) {
            element.count = kind.count;
        }
    }
    machine
}
