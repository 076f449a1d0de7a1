//! Examining a case: its error, its verdict and what cures it.

use super::case::{StressBench, StressCase};
use super::{Measured, ProgramTreatment, StressError, StressVerdict, verdict};
use robovec_ir::Format;
use robovec_num::NumberFormat;

/// A treatment that was tried.
#[derive(Clone, PartialEq, Debug)]
pub struct TreatmentTrial {
    /// What was done.
    pub treatment: ProgramTreatment,
    /// The same in a few words.
    pub label: String,
    /// What came of it.
    pub measured: Measured,
    /// Operations times bits, relative to the untreated program.
    pub cost: f64,
}

/// What is known of a case.
#[derive(Clone, PartialEq, Debug)]
pub struct Findings {
    /// The program that nothing was done to.
    pub untreated: ProgramTreatment,
    /// The error that verdicts are about.
    pub metric: &'static str,
    /// How much the result changes, relatively, with the data.
    pub condition: f64,
    /// The error of rounding the data once to binary32.
    pub floor: f64,
    /// The untreated program in binary32.
    pub short: Measured,
    /// The program in binary64 that cures are compared with: the same, but
    /// with true functions.
    pub long: Measured,
    /// The verdict on the untreated program in binary32.
    pub verdict: StressVerdict,
    /// All that was tried, in the order of trying.
    pub trials: Vec<TreatmentTrial>,
    /// The cheapest trial within ten times the error of binary64.
    pub cure: Option<usize>,
    /// The cheapest trial within ten times the rounding of binary32, where
    /// that is more: what somebody needs who reads results in binary32.
    pub short_cure: Option<usize>,
}

/// How many times the error of binary64 a cure may leave.
const CLOSE: f64 = 10.0;

impl Findings {
    /// The cure.
    pub fn cure(&self) -> Option<&TreatmentTrial> {
        self.cure.map(|index| &self.trials[index])
    }

    /// The cure for results in binary32.
    pub fn short_cure(&self) -> Option<&TreatmentTrial> {
        self.short_cure.map(|index| &self.trials[index])
    }
}

/// Measures the untreated program alone; no cures are tried.
///
/// # Errors
///
/// [`StressError`].
pub fn judge(case: &StressCase) -> Result<Findings, StressError> {
    let bench = case.subject.prepare()?;
    judged(case, bench.as_ref())
}

/// Measures a case and tries cures.
///
/// # Errors
///
/// [`StressError`].
pub fn examine(case: &StressCase) -> Result<Findings, StressError> {
    let bench = case.subject.prepare()?;
    let mut findings = judged(case, bench.as_ref())?;
    let untreated = findings.untreated.clone();
    // A result may happen to be exact; nobody can ask for that.
    let exact = Format::BINARY64.unit_roundoff();
    let close = CLOSE * findings.long.error.max(exact);
    let readable = close.max(CLOSE * Format::BINARY32.unit_roundoff());
    let mut attempts = Attempts {
        bench: bench.as_ref(),
        untreated: &untreated,
        cost: findings.short.cost,
        trials: Vec::new(),
    };
    for treatment in case.subject.candidates() {
        match attempts.attempt(treatment) {
            // What a pass refuses is no cure; that is its right.
            Ok(_) | Err(StressError::Passes(_)) => {}
            Err(error) => return Err(error),
        }
    }
    attempts.attempt(case.subject.standard())?;
    if case.subject.rounds() {
        let exponent = if findings.short.outside > 0.0 {
            NumberFormat::BINARY64.exponent
        } else {
            NumberFormat::BINARY32.exponent
        };
        // The program as it is, and the one with the least operations.
        for program in [Some(untreated.clone()), attempts.shortest()] {
            let Some(program) = program else { continue };
            for goal in [readable, close] {
                attempts.narrowest(&program, exponent, goal)?;
            }
        }
    }
    findings.trials = attempts.trials;
    findings.cure = cheapest(&findings.trials, close);
    findings.short_cure = cheapest(&findings.trials, readable);
    Ok(findings)
}

/// What was tried so far.
struct Attempts<'a> {
    bench: &'a dyn StressBench,
    untreated: &'a ProgramTreatment,
    /// Of the untreated program.
    cost: f64,
    trials: Vec<TreatmentTrial>,
}

impl Attempts<'_> {
    /// Tries a treatment, unless that was done: its error.
    fn attempt(&mut self, treatment: ProgramTreatment) -> Result<f64, StressError> {
        let mut trials = self.trials.iter();
        if let Some(known) = trials.find(|trial| trial.treatment == treatment) {
            return Ok(known.measured.error);
        }
        let measured = self.bench.measure(&treatment)?;
        let error = measured.error;
        self.trials.push(TreatmentTrial {
            label: treatment.label(self.untreated),
            cost: measured.cost / self.cost,
            treatment,
            measured,
        });
        Ok(error)
    }

    /// The program of the least cost among those in the same format, when it
    /// is another than the untreated one.
    fn shortest(&self) -> Option<ProgramTreatment> {
        let others = self
            .trials
            .iter()
            .filter(|trial| trial.treatment.is_another_program(self.untreated) && trial.cost < 1.0);
        let shortest = others.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        Some(shortest.treatment.clone())
    }

    /// Looks for the shortest mantissa between those of binary32 and binary64
    /// whose error is small enough, by bisection: the error falls with every
    /// bit, but for luck.
    fn narrowest(
        &mut self,
        program: &ProgramTreatment,
        exponent: u32,
        goal: f64,
    ) -> Result<(), StressError> {
        let (mut short, mut enough) = (24, Format::WIDEST.mantissa);
        while short < enough {
            let mantissa = (short + enough) / 2;
            let format = NumberFormat {
                exponent,
                mantissa,
                subnormals: true,
            };
            let error = self.attempt(ProgramTreatment {
                format: Format::Float(format),
                ..program.clone()
            })?;
            if error <= goal {
                enough = mantissa;
            } else {
                short = mantissa + 1;
            }
        }
        Ok(())
    }
}

/// The cheapest trial with an error that is small enough; the first of those
/// that cost the same.
fn cheapest(trials: &[TreatmentTrial], error: f64) -> Option<usize> {
    let good = |trial: &TreatmentTrial| trial.measured.consistent && trial.measured.error <= error;
    let good = trials.iter().enumerate().filter(|(_, trial)| good(trial));
    let order =
        |a: &(usize, &TreatmentTrial), b: &(usize, &TreatmentTrial)| a.1.cost.total_cmp(&b.1.cost);
    good.min_by(order).map(|(index, _)| index)
}

fn judged(case: &StressCase, bench: &dyn StressBench) -> Result<Findings, StressError> {
    let untreated = case.subject.untreated();
    let format = untreated.format;
    let in_format = |format: Format| {
        bench.measure(&ProgramTreatment {
            format,
            ..untreated.clone()
        })
    };
    let short = in_format(format)?;
    let long = bench.measure(&case.subject.standard())?;
    let wide = match format {
        Format::Float(float) if short.outside > 0.0 => {
            let wide = NumberFormat {
                exponent: Format::WIDEST.exponent,
                ..float
            };
            Some(in_format(Format::Float(wide))?.error)
        }
        _ => None,
    };
    let floor = bench.floor(format);
    Ok(Findings {
        untreated: untreated.clone(),
        metric: case.subject.metric(),
        condition: bench.condition(),
        floor,
        verdict: verdict(format, &short, floor, wide),
        short,
        long,
        trials: Vec::new(),
        cure: None,
        short_cure: None,
    })
}
