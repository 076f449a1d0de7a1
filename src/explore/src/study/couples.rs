//! The machines of the couples of Table 1.3.

use super::plan::NamedMachine;
use crate::operators::{Couple, couples, with_stages};
use robovec_ir::Machine;
use robovec_ir::machine::ClockOrigin;

/// The word for all couples in lists of machines.
pub(super) const ALL: &str = "couples";

/// The machines of all couples: the thesis' machine with their stages and
/// clock.
pub(super) fn machines() -> impl Iterator<Item = NamedMachine> {
    couples().into_iter().map(machine)
}

/// The machine of a name like `couple-7-4`.
pub(super) fn machine_named(name: &str) -> Option<NamedMachine> {
    machines().find(|machine| machine.name == name)
}

fn machine(couple: Couple) -> NamedMachine {
    let thesis = Machine::built_in("thesis").expect("it ships, and a test parses it");
    let [add, multi] = couple.stages();
    let mut machine = with_stages(&thesis, [add, multi]);
    let name = format!("couple-{add}-{multi}");
    machine.name.clone_from(&name);
    machine.description = format!(
        "adders of {add} stages, multipliers of {multi}, at {} MHz (thesis, Table 1.3)",
        couple.mhz()
    );
    machine.clock_mhz = Some(f64::from(couple.mhz()));
    machine.clock_origin = ClockOrigin::Published;
    NamedMachine {
        name,
        machine,
        couple: Some([add, multi]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_couple_is_a_machine() {
        assert_eq!(machines().count(), 15);
        let machine = machine_named("couple-10-5").expect("it is a couple");
        let thesis = Machine::built_in("thesis").expect("it ships");
        assert_eq!(machine.machine.elements, thesis.elements);
        assert_eq!(machine.machine.clock_mhz, thesis.clock_mhz);
        assert_eq!(machine_named("couple-10-9"), None);
    }
}
