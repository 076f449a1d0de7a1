//! Delays of the cells of a Cyclone V.
//!
//! **Source.** The `specify` blocks and comments of yosys' cell library,
//! `techlibs/intel_alm/common/{alm,dff,dsp,mem}_sim.v` (yosys 0.70, macro
//! `cyclonev`), all in picoseconds. A test compares this table with the files
//! of an installed yosys. The delay of a net from cell to cell is not
//! published: the analysis runs with a lower and an upper estimate.

use super::netlist::readable;

/// Representation of a cell's delays.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum DelayModel {
    /// Outputs follow inputs: pairs of an input and its delay to all outputs.
    Logic(&'static [(&'static str, u32)]),
    /// One bit of a carry chain.
    Carry,
    /// Outputs change after the clock: ports, delay, set-up times of inputs.
    Clocked {
        /// The ports that change.
        outputs: &'static [&'static str],
        /// Clock to output.
        delay: u32,
        /// Inputs and their set-up times.
        setup: &'static [(&'static str, u32)],
    },
    /// Written at the clock, read without it: outputs follow the read address.
    LookUpMemory,
    /// Not part of any timing path.
    Ignored,
}

/// From the inputs of a carry chain to its sum.
pub(super) const CARRY_SUM: [(&str, u32); 6] = [
    ("A", 1342),
    ("B", 1323),
    ("C", 927),
    ("D0", 887),
    ("D1", 785),
    ("CI", 368),
];

/// From the inputs of a carry chain to its carry output.
pub(super) const CARRY_OUT: [(&str, u32); 6] = [
    ("A", 1082),
    ("B", 1062),
    ("C", 813),
    ("D0", 866),
    ("D1", 1198),
    ("CI", 36),
];

/// From the bits of the read address of a memory in logic to its output.
pub(super) const LOOK_UP_READ: [u32; 5] = [487, 475, 382, 284, 96];

/// Set-up times of a memory in logic.
pub(super) const LOOK_UP_SETUP: [(&str, u32); 3] = [("A1ADDR", 86), ("A1DATA", 86), ("A1EN", 86)];

/// Clock to output of a register, which a register outside reads.
pub(super) const REGISTER: u32 = 731;

/// The module of a memory with two ports that both read and write.
pub(super) const TRUE_DUAL_PORT: &str = "true_dual_port_memory";

/// The delays of a primitive; none for an unknown one.
pub(super) fn model(kind: &str) -> Option<DelayModel> {
    Some(match readable(kind) {
        "MISTRAL_ALUT6" => DelayModel::Logic(&[
            ("A", 605),
            ("B", 583),
            ("C", 510),
            ("D", 512),
            ("E", 400),
            ("F", 97),
        ]),
        "MISTRAL_ALUT5" => {
            DelayModel::Logic(&[("A", 583), ("B", 510), ("C", 512), ("D", 400), ("E", 97)])
        }
        "MISTRAL_ALUT4" => DelayModel::Logic(&[("A", 510), ("B", 512), ("C", 400), ("D", 97)]),
        "MISTRAL_ALUT3" => DelayModel::Logic(&[("A", 510), ("B", 400), ("C", 97)]),
        "MISTRAL_ALUT2" => DelayModel::Logic(&[("A", 400), ("B", 97)]),
        "MISTRAL_NOT" => DelayModel::Logic(&[("A", 97)]),
        "MISTRAL_MUL27X27" => DelayModel::Logic(&[("A", 3732), ("B", 3928)]),
        "MISTRAL_MUL18X18" => DelayModel::Logic(&[("A", 3180), ("B", 3982)]),
        "MISTRAL_MUL9X9" => DelayModel::Logic(&[("A", 2818), ("B", 3051)]),
        "MISTRAL_ALUT_ARITH" => DelayModel::Carry,
        "MISTRAL_FF" => DelayModel::Clocked {
            outputs: &["Q"],
            delay: REGISTER,
            setup: &[
                ("DATAIN", 0),
                ("ENA", 0),
                ("SCLR", 0),
                ("SLOAD", 0),
                ("SDATA", 0),
            ],
        },
        "MISTRAL_M10K" => DelayModel::Clocked {
            outputs: &["B1DATA"],
            delay: 1004,
            setup: &[
                ("A1ADDR", 125),
                ("A1DATA", 97),
                ("A1EN", 140),
                ("B1ADDR", 125),
                ("B1EN", 161),
            ],
        },
        // Closed, since yosys has no cell for it: a block memory all the same.
        TRUE_DUAL_PORT => DelayModel::Clocked {
            outputs: &["a_word", "b_word"],
            delay: 1004,
            setup: &[
                ("a_address", 125),
                ("b_address", 125),
                ("a_data", 97),
                ("b_data", 97),
                ("a_write", 140),
                ("b_write", 140),
            ],
        },
        "MISTRAL_MLAB" => DelayModel::LookUpMemory,
        "MISTRAL_CLKBUF" | "MISTRAL_IB" | "MISTRAL_OB" | "MISTRAL_IO" => DelayModel::Ignored,
        _ => return None,
    })
}
