//! Examines a case: its error, its verdict and its remedy.

use super::case::{StressBench, StressCase};
use super::{Measured, ProgramTreatment, StressError, StressVerdict, verdict};
use robovec_ir::Format;
use robovec_num::{FixedFormat, NumberFormat};

/// A treatment that was tried.
#[derive(Clone, PartialEq, Debug)]
pub struct TreatmentTrial {
    /// Treatment.
    pub treatment: ProgramTreatment,
    /// The same in a few words.
    pub label: String,
    /// Result of it.
    pub measured: Measured,
    /// Operations times bits, relative to the untreated program.
    pub cost: f64,
}

/// Findings on a case.
#[derive(Clone, PartialEq, Debug)]
pub struct Findings {
    /// The program without treatment.
    pub untreated: ProgramTreatment,
    /// The error that verdicts are about.
    pub metric: &'static str,
    /// Relative change of the result with the data.
    pub condition: f64,
    /// The error of rounding the data once to binary32.
    pub floor: f64,
    /// The untreated program in binary32.
    pub short: Measured,
    /// The program in binary64 that cures are compared with, of true functions.
    pub long: Measured,
    /// The verdict on the untreated program in binary32.
    pub verdict: StressVerdict,
    /// All that was tried, in the order of trying.
    pub trials: Vec<TreatmentTrial>,
    /// The cheapest trial within ten times the error of binary64.
    pub cure: Option<usize>,
    /// The cheapest trial within ten times the rounding of binary32, if that is
    /// larger: for users who read results in binary32.
    pub short_cure: Option<usize>,
}

/// Maximum error that a cure may leave, relative to that of binary64.
const CLOSE: f64 = 10.0;

/// Factor by which the error of another program in the same format must be
/// smaller for the problem not to be the hard part. Rounding errors of two
/// programs differ by a bit or two by luck.
const BETTER: f64 = 8.0;

/// Error of a result with one digit: beyond it no result is better.
const ONE_DIGIT: f64 = 0.1;

/// The shortest mantissa tried: others err by ten binary32 roundings.
const NARROWEST: u32 = 18;

/// Maximum error in the widest format for shorter ones to be tried.
const HOPELESS: f64 = 100.0;

/// The programs that get a format for every value.
const MOST_MIXED: usize = 24;

/// The maximum number of bits of fixed point.
const MOST_FIXED: u32 = 53;

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
pub fn judge(case: &StressCase) -> Result<Findings, StressError> {
    let bench = case.subject.prepare()?;
    let (findings, _) = judged(case, bench.as_ref())?;
    Ok(findings)
}

/// Measures a case and tries cures.
pub fn examine(case: &StressCase) -> Result<Findings, StressError> {
    let bench = case.subject.prepare()?;
    let (mut findings, mut attempts) = judged(case, bench.as_ref())?;
    // A result may happen to be exact; nobody can ask for that.
    let exact = Format::BINARY64.unit_roundoff();
    let close = CLOSE * findings.long.error.max(exact);
    let readable = close.max(CLOSE * Format::BINARY32.unit_roundoff());
    let programs = case.subject.programs();
    for treatment in programs.iter().cloned().chain(case.subject.candidates()) {
        attempts.allowed(treatment)?;
    }
    attempts.attempt(case.subject.standard())?;
    if case.subject.rounds() {
        let exponent = if findings.short.outside > 0.0 {
            NumberFormat::BINARY64.exponent
        } else {
            NumberFormat::BINARY32.exponent
        };
        for goal in [readable, close] {
            if case.subject.is_small() {
                attempts.exhaust(exponent, goal)?;
                if case.subject.mixes() {
                    attempts.mix(goal)?;
                }
                continue;
            }
            // The program as it is, and the one with the least operations.
            for program in [Some(findings.untreated.clone()), attempts.shortest()] {
                let Some(program) = program else { continue };
                attempts.narrowest(&program, exponent, goal)?;
            }
        }
    }
    findings.trials = attempts.trials;
    findings.cure = cheapest(&findings.trials, close);
    findings.short_cure = cheapest(&findings.trials, readable);
    Ok(findings)
}

/// Attempts so far.
struct Attempts<'a> {
    bench: &'a dyn StressBench,
    untreated: ProgramTreatment,
    /// Of the untreated program.
    cost: f64,
    trials: Vec<TreatmentTrial>,
}

impl Attempts<'_> {
    /// Tries a treatment, unless that was done: its index among the trials.
    fn attempt(&mut self, treatment: ProgramTreatment) -> Result<usize, StressError> {
        let mut trials = self.trials.iter();
        if let Some(known) = trials.position(|trial| trial.treatment == treatment) {
            return Ok(known);
        }
        let measured = self.bench.measure(&treatment)?;
        self.trials.push(TreatmentTrial {
            label: treatment.label(&self.untreated),
            cost: measured.cost / self.cost,
            treatment,
            measured,
        });
        Ok(self.trials.len() - 1)
    }

    /// As [`Attempts::attempt`]; a program that a pass refuses is no remedy.
    fn allowed(&mut self, treatment: ProgramTreatment) -> Result<(), StressError> {
        match self.attempt(treatment) {
            Ok(_) | Err(StressError::Passes(_)) => Ok(()),
            Err(error) => Err(error),
        }
    }

    /// True when a program in the untreated format has a much smaller error.
    fn is_bettered(&self, error: f64) -> bool {
        let programs = self.trials.iter().filter(|trial| {
            trial.treatment.is_another_program(&self.untreated) && trial.measured.consistent
        });
        let mut errors = programs.map(|trial| trial.measured.error);
        errors.any(|other| other * BETTER < error && other <= ONE_DIGIT)
    }

    /// The untreated program and the others in its format with their costs, the
    /// shortest first: its result makes most trials of the others unnecessary.
    fn programs(&self) -> Vec<ProgramTreatment> {
        let untreated = &self.untreated;
        let is_program = |trial: &&TreatmentTrial| {
            trial.treatment == *untreated || trial.treatment.is_another_program(untreated)
        };
        let programs = self.trials.iter().filter(is_program);
        let mut programs: Vec<(f64, ProgramTreatment)> = programs
            .map(|trial| (trial.cost, trial.treatment.clone()))
            .collect();
        programs.push((1.0, untreated.clone()));
        programs.sort_by(|a, b| a.0.total_cmp(&b.0));
        programs.into_iter().map(|(_, program)| program).collect()
    }

    /// Tries every program with every mantissa from the narrowest on, and in
    /// fixed point with every number of bits after the point, until its error
    /// is small enough or it costs more than the cheapest known remedy.
    fn exhaust(&mut self, exponent: u32, goal: f64) -> Result<(), StressError> {
        for program in self.programs() {
            let mantissas = NARROWEST..=Format::WIDEST.mantissa;
            let floats = mantissas.map(|mantissa| float_format(exponent, mantissa));
            self.widen(&program, floats, goal)?;
            if let Some(largest) = self.bench.largest(&program) {
                self.widen(&program, fixed_formats(largest), goal)?;
            }
        }
        Ok(())
    }

    /// Tries a program in successive formats until its error is small enough or
    /// it costs more than a known remedy; skipped when the widest is far off.
    fn widen(
        &mut self,
        program: &ProgramTreatment,
        formats: impl Iterator<Item = Format> + Clone,
        goal: f64,
    ) -> Result<(), StressError> {
        let within = |format: Format| program.with(|it| it.format = format);
        if let Some(widest) = formats.clone().last() {
            let tried = self.attempt(within(widest))?;
            let error = self.trials[tried].measured.error;
            if error.is_nan() || error > HOPELESS * goal {
                return Ok(());
            }
        }
        for format in formats {
            let tried = self.attempt(within(format))?;
            // A trial that is good enough ends this, since it is known itself.
            let known = cheapest(&self.trials, goal).map(|best| self.trials[best].cost);
            if known.is_some_and(|known| known <= self.trials[tried].cost) {
                break;
            }
        }
        Ok(())
    }

    /// Tries the shortest programs with a format for every value. The pass aims
    /// at less than the error of the whole array at random states; a smaller
    /// limit is requested when that is not sufficient here.
    fn mix(&mut self, goal: f64) -> Result<(), StressError> {
        for program in self.programs().into_iter().take(MOST_MIXED) {
            for part in [1.0, 0.03] {
                // What is not a value (inputs, a state) stays in binary64.
                self.allowed(program.with(|it| {
                    (it.mixed, it.format) = (Some(goal * part), Format::BINARY64);
                }))?;
            }
        }
        Ok(())
    }

    /// The cheapest program in the same format, unless it is the untreated one.
    fn shortest(&self) -> Option<ProgramTreatment> {
        let others = self.trials.iter().filter(|trial| {
            trial.treatment.is_another_program(&self.untreated) && trial.cost < 1.0
        });
        let shortest = others.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        Some(shortest.treatment.clone())
    }

    /// Looks for the shortest mantissa between those of binary32 and binary64
    /// whose error is small enough, by bisection: the error falls with every
    /// bit, except for luck.
    fn narrowest(
        &mut self,
        program: &ProgramTreatment,
        exponent: u32,
        goal: f64,
    ) -> Result<(), StressError> {
        let (mut short, mut enough) = (24, Format::WIDEST.mantissa);
        while short < enough {
            let mantissa = (short + enough) / 2;
            let format = float_format(exponent, mantissa);
            let tried = self.attempt(program.with(|it| it.format = format))?;
            if self.trials[tried].measured.error <= goal {
                enough = mantissa;
            } else {
                short = mantissa + 1;
            }
        }
        Ok(())
    }
}

fn float_format(exponent: u32, mantissa: u32) -> Format {
    Format::Float(NumberFormat {
        exponent,
        mantissa,
        subnormals: true,
    })
}

/// Formats of fixed point that hold a number, from few bits on.
fn fixed_formats(largest: f64) -> impl Iterator<Item = Format> + Clone {
    let holds = |integer: &u32| largest < 2f64.powi(*integer as i32);
    let integer = (0..MOST_FIXED).find(holds).unwrap_or(MOST_FIXED);
    let first = (NARROWEST + 1).saturating_sub(integer).max(1);
    (first..=MOST_FIXED - integer)
        .map(move |fraction| Format::Fixed(FixedFormat { integer, fraction }))
}

/// The cheapest trial of a small enough error, the first of equal ones.
fn cheapest(trials: &[TreatmentTrial], error: f64) -> Option<usize> {
    let good = |trial: &TreatmentTrial| trial.measured.consistent && trial.measured.error <= error;
    let good = trials.iter().enumerate().filter(|(_, trial)| good(trial));
    let order =
        |a: &(usize, &TreatmentTrial), b: &(usize, &TreatmentTrial)| a.1.cost.total_cmp(&b.1.cost);
    good.min_by(order).map(|(index, _)| index)
}

/// The findings without remedies, with the trials for the verdict.
fn judged<'a>(
    case: &StressCase,
    bench: &'a dyn StressBench,
) -> Result<(Findings, Attempts<'a>), StressError> {
    let untreated = case.subject.untreated();
    let format = untreated.format;
    let in_format = |format: Format| bench.measure(&untreated.with(|it| it.format = format));
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
    let mut attempts = Attempts {
        bench,
        untreated: untreated.clone(),
        cost: short.cost,
        trials: Vec::new(),
    };
    let mut found = verdict(format, &short, floor, wide);
    if found == StressVerdict::HardProblem {
        for program in case.subject.programs() {
            attempts.allowed(program)?;
        }
        if attempts.is_bettered(short.error) {
            found = StressVerdict::BadCode;
        }
    }
    let findings = Findings {
        untreated,
        metric: case.subject.metric(),
        condition: bench.condition(),
        floor,
        verdict: found,
        short,
        long,
        trials: Vec::new(),
        cure: None,
        short_cure: None,
    };
    Ok((findings, attempts))
}
