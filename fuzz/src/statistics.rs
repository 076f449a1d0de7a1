//! Record of a fuzz target so far.
//!
//! A broken generator makes only invalid programs, and a target that tests
//! nothing finds nothing: only this test detects both.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

/// Outcome of one input.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Run {
    /// Operations of the program.
    pub operations: u64,
    /// Passes that ran.
    pub passes: u64,
    /// Number of rewrites requested.
    pub rewrites: u64,
    /// Faults that were planted.
    pub planted: u64,
    /// Planted faults that were caught.
    pub caught: u64,
}

/// Sums over all inputs of a target.
#[derive(Default, Debug)]
pub struct Statistics {
    name: &'static str,
    inputs: AtomicU64,
    invalid: AtomicU64,
    operations: AtomicU64,
    passes: AtomicU64,
    rewrites: AtomicU64,
    planted: AtomicU64,
    caught: AtomicU64,
}

impl Statistics {
    /// No inputs yet.
    pub const fn new(name: &'static str) -> Statistics {
        Statistics {
            name,
            inputs: AtomicU64::new(0),
            invalid: AtomicU64::new(0),
            operations: AtomicU64::new(0),
            passes: AtomicU64::new(0),
            rewrites: AtomicU64::new(0),
            planted: AtomicU64::new(0),
            caught: AtomicU64::new(0),
        }
    }

    /// Adds the result of an input; bytes that do not make a program are
    /// invalid. Reports the progress of the target on the standard error, after
    /// 1024 inputs, 2048, and so on.
    pub fn record(&self, result: &arbitrary::Result<Run>) {
        let add = |counter: &AtomicU64, number| counter.fetch_add(number, Ordering::Relaxed);
        let before = add(&self.inputs, 1);
        match result {
            Err(_) => {
                add(&self.invalid, 1);
            }
            Ok(run) => {
                add(&self.operations, run.operations);
                add(&self.passes, run.passes);
                add(&self.rewrites, run.rewrites);
                add(&self.planted, run.planted);
                add(&self.caught, run.caught);
            }
        }
        let count = before + 1;
        if count >= 1024 && count.is_power_of_two() {
            eprintln!("{self}");
        }
    }

    /// Inputs that made a program.
    pub fn valid(&self) -> u64 {
        self.inputs.load(Ordering::Relaxed) - self.invalid.load(Ordering::Relaxed)
    }

    /// Number of rewrites requested by passes.
    pub fn rewrites(&self) -> u64 {
        self.rewrites.load(Ordering::Relaxed)
    }

    /// Faults planted, and those of them that were caught.
    pub fn faults(&self) -> (u64, u64) {
        (
            self.planted.load(Ordering::Relaxed),
            self.caught.load(Ordering::Relaxed),
        )
    }
}

impl fmt::Display for Statistics {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let load = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let (planted, caught) = self.faults();
        write!(
            formatter,
            "{}: {} inputs, {} invalid, {} operations, {} passes, {} rewrites",
            self.name,
            load(&self.inputs),
            load(&self.invalid),
            load(&self.operations),
            load(&self.passes),
            load(&self.rewrites),
        )?;
        if planted > 0 {
            write!(formatter, ", {caught} of {planted} planted faults caught")?;
        }
        Ok(())
    }
}
