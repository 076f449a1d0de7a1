//! Placing one program on machines with other numbers of elements.

use robovec_ir::{Function, Machine, Module, Operation, View, verify};
use robovec_schedule::{
    PlaceError, PlaceOptions, PlaceSummary, PlacementStatistics, place, placement_statistics,
};

/// A machine with so many elements of the kinds that perform these operations;
/// a kind that performs several has the last number, others stay as they are.
pub fn with_counts(machine: &Machine, counts: &[(Operation, u32)]) -> Machine {
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
    /// What the placer tells.
    pub summary: PlaceSummary,
}

/// Places the first function of a module.
///
/// # Errors
///
/// When the machine cannot hold it.
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
/// Why there is no placement, for people.
pub fn verified(
    module: &Module,
    machine: &Machine,
    options: PlaceOptions,
) -> Result<PlacedFunction, String> {
    let placed = placed(module, machine, options).map_err(|error| error.to_string())?;
    let view = View {
        tables: &module.tables,
        function: &placed.function,
    };
    match verify::verify_placement(view, machine).first() {
        Some(violation) => {
            let message = &violation.message;
            Err(format!("the verifier refuses the placement: {message}"))
        }
        None => Ok(placed),
    }
}

impl PlacedFunction {
    /// What the placement uses of the machine it was made for.
    pub fn statistics(&self, machine: &Machine) -> PlacementStatistics {
        placement_statistics(&self.function, machine).expect("what is placed has a placement")
    }

    /// The most words of memory of one element, both sides of a split one
    /// together.
    pub fn most_words(&self, machine: &Machine) -> u32 {
        let kinds = self.statistics(machine).kinds.into_iter();
        let words = kinds.map(|kind| kind.memory.max).max();
        words.expect("a machine has elements")
    }
}
