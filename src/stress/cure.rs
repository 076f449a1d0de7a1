//! Examining a case: its error, its verdict and what cures it.

use super::case::{Bench, Case};
use super::{Measured, StressError, Treatment, Verdict, verdict};
use robovec_ir::Format;
use robovec_ir::machine::NumberFormat;

/// A treatment that was tried.
#[derive(Clone, PartialEq, Debug)]
pub struct Trial {
    /// What was done.
    pub treatment: Treatment,
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
    /// The error that verdicts are about.
    pub metric: &'static str,
    /// How much the result changes, relatively, with the data.
    pub condition: f64,
    /// The error of rounding the data once to binary32.
    pub floor: f64,
    /// The untreated program in binary32.
    pub short: Measured,
    /// The same in binary64.
    pub long: Measured,
    /// The verdict on the untreated program in binary32.
    pub verdict: Verdict,
    /// All that was tried, in the order of trying.
    pub trials: Vec<Trial>,
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
    pub fn cure(&self) -> Option<&Trial> {
        self.cure.map(|index| &self.trials[index])
    }

    /// The cure for results in binary32.
    pub fn short_cure(&self) -> Option<&Trial> {
        self.short_cure.map(|index| &self.trials[index])
    }
}

/// Measures the untreated program alone; no cures are tried.
///
/// # Errors
///
/// [`StressError`].
pub fn judge(case: &Case) -> Result<Findings, StressError> {
    let bench = case.subject.prepare()?;
    judged(case, bench.as_ref())
}

/// Measures a case and tries cures.
///
/// # Errors
///
/// [`StressError`].
pub fn examine(case: &Case) -> Result<Findings, StressError> {
    let bench = case.subject.prepare()?;
    let mut findings = judged(case, bench.as_ref())?;
    let untreated = case.subject.untreated();
    let wide = Treatment {
        format: Format::BINARY64,
        ..untreated.clone()
    };
    let mut treatments = case.subject.candidates();
    treatments.push(wide);
    for treatment in treatments {
        let measured = bench.measure(&treatment)?;
        findings.trials.push(Trial {
            label: treatment.label(&untreated),
            cost: measured.cost / findings.short.cost,
            treatment,
            measured,
        });
    }
    let close = CLOSE * findings.long.error;
    let readable = close.max(CLOSE * Format::BINARY32.unit_roundoff());
    findings.cure = cheapest(&findings.trials, close);
    findings.short_cure = cheapest(&findings.trials, readable);
    Ok(findings)
}

/// The cheapest trial with an error that is small enough; the first of those
/// that cost the same.
fn cheapest(trials: &[Trial], error: f64) -> Option<usize> {
    let good = |trial: &Trial| trial.measured.consistent && trial.measured.error <= error;
    let good = trials.iter().enumerate().filter(|(_, trial)| good(trial));
    let order = |a: &(usize, &Trial), b: &(usize, &Trial)| a.1.cost.total_cmp(&b.1.cost);
    good.min_by(order).map(|(index, _)| index)
}

fn judged(case: &Case, bench: &dyn Bench) -> Result<Findings, StressError> {
    let untreated = case.subject.untreated();
    let format = untreated.format;
    let in_format = |format: Format| {
        bench.measure(&Treatment {
            format,
            ..untreated.clone()
        })
    };
    let short = in_format(format)?;
    let long = in_format(Format::BINARY64)?;
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
