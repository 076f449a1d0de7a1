//! The floating-point operators of `hdl/cores`, and the places for their
//! registers.
//!
//! An operator is one Verilog module for every latency: between its steps are
//! cuts, any of which may hold a register. Which of them do is chosen here, so
//! that the slowest step between two registers is as fast as possible, from a
//! model of the delay of every step ([`steps`]).
//!
//! **Invariant.** The last cut, at the result, always holds a register: a
//! result crosses the machine's interconnect in its own cycle.

mod steps;

use robovec_ir::Operation;
use robovec_ir::machine::Device;
use robovec_num::NumberFormat;
pub use steps::{CoreStep, stage_delay};

robovec_num::named! {
    /// A floating-point operator in hardware.
    #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
    pub enum OperatorCore {
        /// Sum and difference: `fp_add`.
        Add = "fp_add",
        /// Product: `fp_mul`.
        Multiply = "fp_mul",
        /// Quotient: `fp_div`.
        Divide = "fp_div",
        /// Square root: `fp_sqrt`.
        Root = "fp_sqrt",
        /// Product and sum, rounded once: `fp_fma`.
        Fused = "fp_fma",
    }
}

/// The files of all operators, in alphabetic order, each named as its only
/// module: name and text. They can be compiled in any order, without other
/// files.
pub const SOURCES: [(&str, &str); 12] = hdl![
    "cores",
    "fp_add.v",
    "fp_div.v",
    "fp_fma.v",
    "fp_leading.v",
    "fp_mul.v",
    "fp_normalise.v",
    "fp_pack.v",
    "fp_shift_right.v",
    "fp_sqrt.v",
    "fp_unpack.v",
    "pipeline_cut.v",
    "pipeline_delay.v",
];

impl OperatorCore {
    /// The operator that performs an operation, if hardware does: sine and
    /// cosine are the host's.
    pub fn of(operation: Operation) -> Option<OperatorCore> {
        match operation {
            Operation::Add | Operation::Sub => Some(OperatorCore::Add),
            Operation::Mul => Some(OperatorCore::Multiply),
            Operation::Div => Some(OperatorCore::Divide),
            Operation::Sqrt => Some(OperatorCore::Root),
            Operation::Fma | Operation::Fms | Operation::Fnma => Some(OperatorCore::Fused),
            Operation::Copy | Operation::Neg | Operation::Sin | Operation::Cos => None,
        }
    }

    /// Its steps on a device with fast nets, each with the cut at its end.
    pub fn steps(self, format: NumberFormat, device: &Device) -> Vec<CoreStep> {
        self.steps_with_nets(format, device, device.nets.quick)
    }

    /// The same for nets with a delay of this number of picoseconds.
    pub fn steps_with_nets(self, format: NumberFormat, device: &Device, net: u32) -> Vec<CoreStep> {
        steps::of(self, format, device, net)
    }

    /// The parameters of its module that depend on the device: names and
    /// values.
    pub fn device_parameters(self, device: &Device) -> Vec<(&'static str, u32)> {
        match self {
            OperatorCore::Multiply => vec![("BLOCK", device.blocks.factor)],
            OperatorCore::Add | OperatorCore::Divide | OperatorCore::Root | OperatorCore::Fused => {
                Vec::new()
            }
        }
    }
}

/// The parameters `CUTS` and `EXTRA` of an operator.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Cuts {
    /// Bit `i` is set when cut `i` holds a register.
    pub mask: u64,
    /// Registers after the result.
    pub extra: u32,
}

impl Cuts {
    /// Registers between operands and result.
    pub fn stages(self) -> u32 {
        self.mask.count_ones() + self.extra
    }
}

/// The cuts of an operator for this number of pipeline stages: such that the
/// slowest stage is as fast as possible, and among these choices the one with
/// the fewest registers. Stages beyond the last cut are plain registers. No
/// stages give no cut at all.
pub fn cuts(core: OperatorCore, format: NumberFormat, stages: u32, device: &Device) -> Cuts {
    let steps = behind_memory(core, format, device);
    let places = steps.len() as u32;
    let count = stages.min(places) as usize;
    let cuts = Cuts {
        mask: if count == 0 {
            0
        } else {
            best_mask(&steps, count, slowest(&steps, count))
        },
        extra: stages.saturating_sub(places),
    };
    assert_eq!(cuts.stages(), stages, "every stage ends at a register");
    assert!(
        stages == 0 || cuts.mask >> (places - 1) == 1,
        "the last cut holds a register"
    );
    cuts
}

/// The steps of an operator whose operands leave a block memory, later in the
/// clock than they would leave a register.
fn behind_memory(core: OperatorCore, format: NumberFormat, device: &Device) -> Vec<CoreStep> {
    let mut steps = core.steps(format, device);
    let later = device.cells.memory.saturating_sub(device.cells.register);
    steps[0].delay += later;
    steps[0].through += later;
    steps
}

/// The delay of a stage that begins after step `first - 1` and ends at the
/// cut of step `last`, in picoseconds.
fn delay(steps: &[CoreStep], first: usize, last: usize) -> u32 {
    stage_delay(&steps[first..=last])
}

/// The delay of the slowest stage at its best, with this number of registers.
fn slowest(steps: &[CoreStep], count: usize) -> u32 {
    let least = steps.iter().map(|step| step.delay).fold(0, u32::max);
    let (mut low, mut high) = (least, delay(steps, 0, steps.len() - 1));
    while low < high {
        let middle = low + (high - low) / 2;
        if stages_within(steps, middle) <= count {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}

/// The fewest stages within a delay; no step alone exceeds it.
fn stages_within(steps: &[CoreStep], limit: u32) -> usize {
    let (mut stages, mut first) = (1, 0);
    for last in 0..steps.len() {
        if delay(steps, first, last) > limit {
            stages += 1;
            first = last;
        }
    }
    stages
}

/// The mask with `count` registers, the last at the last cut, whose stages
/// keep to a delay and whose registers hold the fewest bits. Such a mask
/// exists: a stage can always be divided as long as there are cuts.
fn best_mask(steps: &[CoreStep], count: usize, limit: u32) -> u64 {
    // best[k][i]: the fewest bits of k registers, the last at cut i, and the
    // cut of the register before.
    let mut best = vec![vec![None; steps.len()]; count + 1];
    for last in 0..steps.len() {
        if delay(steps, 0, last) <= limit {
            best[1][last] = Some((steps[last].bits, usize::MAX));
        }
    }
    for stage in 2..=count {
        for last in 1..steps.len() {
            best[stage][last] = (0..last)
                .filter(|&cut| delay(steps, cut + 1, last) <= limit)
                .filter_map(|cut| best[stage - 1][cut].map(|(bits, _): (u32, usize)| (bits, cut)))
                .min()
                .map(|(bits, cut)| (bits + steps[last].bits, cut));
        }
    }
    let (mut mask, mut cut) = (0, steps.len() - 1);
    for stage in (1..=count).rev() {
        mask |= 1 << cut;
        let (_, before) = best[stage][cut].expect("a mask with so many registers exists");
        cut = before;
    }
    mask
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::machine::DeviceFamily;

    fn device() -> &'static Device {
        DeviceFamily::default().device()
    }

    fn formats() -> impl Iterator<Item = NumberFormat> {
        let widths = [(2, 1), (4, 3), (5, 10), (8, 7), (8, 17), (8, 23), (11, 52)];
        widths.into_iter().flat_map(|(exponent, mantissa)| {
            [true, false].map(|subnormals| NumberFormat {
                exponent,
                mantissa,
                subnormals,
            })
        })
    }

    #[test]
    fn every_number_of_stages_is_reached() {
        for (core, format) in OperatorCore::ALL
            .into_iter()
            .flat_map(|core| formats().map(move |format| (core, format)))
        {
            let steps = core.steps(format, device());
            assert!(steps.len() <= 64, "{core:?} {format:?}");
            for stages in 1..steps.len() as u32 + 3 {
                let cuts = cuts(core, format, stages, device());
                assert_eq!(cuts.stages(), stages, "{core:?} {format:?}");
                assert_ne!(cuts.mask >> (steps.len() - 1) & 1, 0);
            }
            assert_eq!(cuts(core, format, 0, device()), Cuts { mask: 0, extra: 0 });
        }
    }

    #[test]
    fn more_stages_are_never_slower() {
        for core in OperatorCore::ALL {
            let steps = core.steps(NumberFormat::BINARY32, device());
            let delays: Vec<u32> = (1..=steps.len())
                .map(|count| slowest(&steps, count))
                .collect();
            assert!(delays.is_sorted_by(|a, b| a >= b), "{delays:?}");
        }
    }

    #[test]
    fn a_mask_is_the_best_of_all() {
        let steps = behind_memory(OperatorCore::Multiply, NumberFormat::BINARY32, device());
        let count = 4;
        let cost = |mask: u64| {
            let (mut worst, mut bits, mut first) = (0, 0, 0);
            for last in (0..steps.len()).filter(|cut| mask >> cut & 1 == 1) {
                worst = worst.max(delay(&steps, first, last));
                bits += steps[last].bits;
                first = last + 1;
            }
            (worst, bits)
        };
        let end = 1 << (steps.len() - 1);
        let best = (end..2 * end)
            .filter(|mask: &u64| mask.count_ones() == count)
            .map(cost)
            .min();
        let chosen = cuts(
            OperatorCore::Multiply,
            NumberFormat::BINARY32,
            count,
            device(),
        );
        assert_eq!(Some(cost(chosen.mask)), best);
    }

    #[test]
    fn files_hold_the_module_of_their_name() {
        assert!(SOURCES.is_sorted_by_key(|(name, _)| name));
        for (name, text) in SOURCES {
            let module = name.trim_end_matches(".v");
            assert!(text.contains(&format!("\nmodule {module} ")));
            assert!(text.ends_with("endmodule\n"), "{module}");
        }
    }
}
