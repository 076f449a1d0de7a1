//! Results of programs, and the faults found in them.

use std::fmt;

/// Results of some programs.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Tally {
    /// Programs.
    pub programs: u64,
    /// Passes that ran.
    pub passes: u64,
    /// Passes that refused a program.
    pub refused: u64,
    /// Outputs that were compared and are the same.
    pub same: u64,
    /// Outputs that overlap in a stretch wide enough to hide a difference.
    pub vague: u64,
    /// Outputs that are no number before a pass, or not known to be.
    pub nothing: u64,
    /// Outputs that were compared bit by bit.
    pub bits: u64,
}

impl Tally {
    /// Adds another one.
    pub fn add(&mut self, other: &Tally) {
        self.programs += other.programs;
        self.passes += other.passes;
        self.refused += other.refused;
        self.same += other.same;
        self.vague += other.vague;
        self.nothing += other.nothing;
        self.bits += other.bits;
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "{} programs, {} passes and {} that refused; outputs over the reals: {} the same, \
             {} vague, {} no number before; bit by bit: {}",
            self.programs,
            self.passes,
            self.refused,
            self.same,
            self.vague,
            self.nothing,
            self.bits
        )
    }
}

/// A pass that broke the promise of its class, or was wrongly accused of it.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The pass with its options.
    pub pass: String,
    /// Fault in words.
    pub what: String,
    /// The program it was given.
    pub program: String,
    /// Program that it made.
    pub result: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Finding {
            pass,
            what,
            program,
            result,
        } = self;
        write!(formatter, "{pass}: {what}\non\n{program}gave\n{result}")
    }
}
