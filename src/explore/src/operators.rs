//! Floating-point operators of the Cyclone V (thesis, Tables 1.1 to 1.3).
//!
//! The two tables of operators are data; the couples that share one clock
//! are computed from them: a couple runs at the slower of its two operators.

use robovec_ir::{Machine, Operation};

/// Clock with double-pumped M10K memories (240 MHz), MHz (thesis 1.3).
pub const MEMORY_CAP_MHZ: u32 = 120;

/// An operator with a number of pipeline stages.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Operator {
    /// Pipeline stages.
    pub stages: u32,
    /// Highest clock, MHz.
    pub mhz: u32,
    /// Look-up tables.
    pub luts: u32,
    /// Multiplier blocks.
    pub multipliers: u32,
}

const fn operator(stages: u32, mhz: u32, luts: u32, multipliers: u32) -> Operator {
    Operator {
        stages,
        mhz,
        luts,
        multipliers,
    }
}

/// Table 1.1: adders and subtractors.
pub const ADDERS: [Operator; 10] = [
    operator(1, 37, 538, 0),
    operator(2, 55, 569, 0),
    operator(3, 72, 587, 0),
    operator(4, 89, 630, 0),
    operator(5, 103, 652, 0),
    operator(6, 120, 656, 0),
    operator(7, 144, 695, 0),
    operator(9, 159, 762, 0),
    operator(10, 178, 796, 0),
    operator(14, 233, 905, 0),
];

/// Table 1.2: multipliers.
pub const MULTIPLIERS: [Operator; 6] = [
    operator(2, 63, 170, 2),
    operator(3, 109, 193, 2),
    operator(4, 153, 207, 2),
    operator(5, 199, 231, 2),
    operator(8, 218, 362, 4),
    operator(9, 230, 391, 4),
];

/// An adder and a multiplier on one clock.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Couple {
    /// The adder.
    pub adder: Operator,
    /// The multiplier.
    pub multiplier: Operator,
}

impl Couple {
    /// The clock both can follow, MHz.
    pub fn mhz(&self) -> u32 {
        self.adder.mhz.min(self.multiplier.mhz)
    }

    /// Its name, `7-4`: stages of the adder and of the multiplier.
    pub fn name(&self) -> String {
        format!("{}-{}", self.adder.stages, self.multiplier.stages)
    }

    /// Stages of the adder and of the multiplier.
    pub fn stages(&self) -> [u32; 2] {
        [self.adder.stages, self.multiplier.stages]
    }
}

/// Table 1.3: the couples worth considering, slowest first. A couple is left
/// out when another one with no more stages of either kind is as fast.
pub fn couples() -> Vec<Couple> {
    let all = ADDERS.iter().flat_map(|&adder| {
        MULTIPLIERS
            .iter()
            .map(move |&multiplier| Couple { adder, multiplier })
    });
    let all: Vec<Couple> = all.collect();
    let beats = |other: &Couple, couple: &Couple| {
        let fewer = other.adder.stages <= couple.adder.stages
            && other.multiplier.stages <= couple.multiplier.stages;
        fewer && other != couple && other.mhz() >= couple.mhz()
    };
    let mut kept: Vec<Couple> = all
        .iter()
        .filter(|couple| !all.iter().any(|other| beats(other, couple)))
        .copied()
        .collect();
    kept.sort_by_key(|couple| (couple.mhz(), couple.stages()));
    kept
}

/// A machine whose adders and multipliers have this number of stages.
pub fn with_stages(machine: &Machine, [add, multi]: [u32; 2]) -> Machine {
    let mut machine = machine.clone();
    for (operation, stages) in [(Operation::Add, add), (Operation::Mul, multi)] {
        if let Some(kind) = machine.kind_of(operation) {
            machine.elements[kind].stages = stages;
        }
    }
    machine
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_couples_of_table_1_3_follow_from_tables_1_1_and_1_2() {
        let printed = [
            (1, 2, 37),
            (2, 2, 55),
            (3, 2, 63),
            (3, 3, 72),
            (4, 3, 89),
            (5, 3, 103),
            (6, 3, 109),
            (6, 4, 120),
            (7, 4, 144),
            (9, 4, 153),
            (9, 5, 159),
            (10, 5, 178),
            (14, 5, 199),
            (14, 8, 218),
            (14, 9, 230),
        ];
        let computed: Vec<(u32, u32, u32)> = couples()
            .iter()
            .map(|couple| (couple.adder.stages, couple.multiplier.stages, couple.mhz()))
            .collect();
        assert_eq!(computed, printed);
    }
}
