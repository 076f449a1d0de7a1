//! Programs with the formats and sizes they are tried in.

use super::challenge::Challenge;
use super::format::{FormatErrors, FormatQuestion, MeasuredFormat, WIDEST};
use super::{
    CostMeasure, FitCandidate, FitError, FitOutcome, FitProgram, FitSources, FitTask, MOTION_STEPS,
    SinePlace, SineTreatment, bound, mixture, series, size, units, variants,
};
use crate::ExplorationProgress;
use crate::device::MachineFigures;
use crate::program::view;
use robovec_analysis::critical_path::critical_path;
use robovec_error::yardstick::Yardstick;
use robovec_ir::Format;
use robovec_ir::cost::function_cost;
use robovec_ir::count::Counts;
use robovec_num::{FixedFormat, NumberFormat};
use robovec_schedule::PlaceError;

/// Number of states of the validation relative to those of the search.
pub(super) const VALIDATION_FACTOR: u32 = 4;

/// Number of the cheapest programs tried with sums that round less.
const ACCURATE: usize = 2;
/// Number of those tried in fixed point.
const FIXED: usize = 4;
/// Number of those tried with a format for every value.
const MIXED: usize = 2;
/// Number of those tried with units for sines and cosines.
const UNITS: usize = 1;

/// Bits that another program may do without over time.
const SPARED: u32 = 2;

/// Programs with their formats and sizes, and the states they are measured at.
pub(super) struct FitSearch<'t, 'a> {
    task: &'t FitTask<'a>,
    search: Yardstick,
    validation: Yardstick,
    pub(super) programs: Vec<FitProgram>,
    sizes: Vec<Vec<size::SizedMachine>>,
    /// For every program its formats with the errors at the validation.
    formats: Vec<Vec<MeasuredFormat>>,
    /// Clocks and resources that were requested before.
    figures: size::KnownFigures,
    /// Choices that failed their challenge.
    pub(super) broken: u32,
    /// Choices that erred too much over time.
    pub(super) drifted: u32,
    /// Steps of motions that may still be taken.
    pub(super) steps_left: u64,
    /// Candidates that could not be tried, with the reasons.
    pub(super) untried: Vec<String>,
}

impl<'t, 'a> FitSearch<'t, 'a> {
    pub(super) fn new(
        task: &'t FitTask<'a>,
        progress: ExplorationProgress<'_>,
    ) -> Result<FitSearch<'t, 'a>, FitError> {
        let search = yardstick(task, task.states, task.seed);
        let validation = yardstick(
            task,
            task.states * VALIDATION_FACTOR,
            task.seed.wrapping_add(1),
        );
        let mut made = variants::programs(task, &search, progress)?;
        series::write(task, &search, &mut made, progress)?;
        let mut all = FitSearch {
            task,
            search,
            validation,
            programs: Vec::new(),
            sizes: Vec::new(),
            formats: Vec::new(),
            figures: size::KnownFigures::default(),
            broken: 0,
            drifted: 0,
            steps_left: MOTION_STEPS,
            untried: Vec::new(),
        };
        let mut refused: Option<PlaceError> = None;
        for program in made {
            let (name, treatment) = (&program.name, program.treatment);
            progress(&format!("{name}, {treatment}: formats and elements"));
            match size::sizes(task, &program) {
                Err(error) => refused = Some(error),
                Ok(placed) => {
                    let formats = all.question(&program).floating()?;
                    all.add(program, placed, formats);
                }
            }
        }
        if let (true, Some(error)) = (all.programs.is_empty(), refused) {
            return Err(FitError::Placement(error));
        }
        all.accurate(progress)?;
        all.fixed(progress)?;
        all.mixed(progress)?;
        all.units(progress)?;
        Ok(all)
    }

    fn add(
        &mut self,
        program: FitProgram,
        sizes: Vec<size::SizedMachine>,
        formats: Vec<MeasuredFormat>,
    ) {
        self.programs.push(program);
        self.sizes.push(sizes);
        self.formats.push(formats);
    }

    fn question<'q>(&'q self, program: &'q FitProgram) -> FormatQuestion<'q> {
        FormatQuestion {
            task: self.task,
            program,
            search: &self.search,
            validation: &self.validation,
        }
    }

    /// The programs that meet the tolerances with the fewest cells of
    /// arithmetic in a floating format, with that format, the cheapest first.
    fn leading(&self, count: usize) -> Vec<(usize, Format)> {
        let mut leading: Vec<(f64, usize, Format)> = Vec::new();
        for (index, program) in self.programs.iter().enumerate() {
            let is_base = program.excluded.is_none() && program.mixture.is_none();
            let function = &program.module.functions[0];
            let good = self.formats[index].iter().filter(|(format, errors)| {
                matches!(format, Format::Float(_)) && errors.used() <= 1.0
            });
            let costs = good.map(|(format, _)| (function_cost(function, *format), *format));
            let cheapest = costs.min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((cost, format)) = cheapest.filter(|_| is_base) {
                leading.push((cost, index, format));
            }
        }
        leading.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let leading = leading.into_iter().take(count);
        leading.map(|(_, index, format)| (index, format)).collect()
    }

    /// Adds the leading programs with sums that round less.
    fn accurate(&mut self, progress: ExplorationProgress<'_>) -> Result<(), FitError> {
        for (index, _) in self.leading(ACCURATE) {
            let program = &self.programs[index];
            progress(&format!("{}: sums that round less", program.name));
            let Some(accurate) = variants::accurate(self.task, program) else {
                continue;
            };
            // Longer ones need not fit into the memories.
            if let Ok(placed) = size::sizes(self.task, &accurate) {
                let formats = self.question(&accurate).floating()?;
                self.add(accurate, placed, formats);
            }
        }
        Ok(())
    }

    /// Tests whether single evaluations are judged, and not only runs.
    fn judges(&self) -> bool {
        let mut needs = self.task.scene.outputs.iter();
        self.task.cost == CostMeasure::Cells || needs.any(|need| need.tolerance.is_some())
    }

    /// Notes that a program could not be tried.
    fn leave(&mut self, index: usize, why: &str) {
        let FitProgram {
            name, treatment, ..
        } = &self.programs[index];
        self.untried.push(format!("{name}, {treatment}, {why}"));
    }

    /// Measures the leading programs in fixed point.
    fn fixed(&mut self, progress: ExplorationProgress<'_>) -> Result<(), FitError> {
        if !self.judges() {
            return Ok(());
        }
        for (index, _) in self.leading(FIXED) {
            let program = &self.programs[index];
            progress(&format!("{}: fixed point", program.name));
            match self.question(program).fixed()? {
                Ok(found) => self.formats[index].push(found),
                Err(reason) => self.leave(index, &format!("in fixed point: {reason}")),
            }
        }
        Ok(())
    }

    /// Gives each value of the leading programs its own format.
    fn mixed(&mut self, progress: ExplorationProgress<'_>) -> Result<(), FitError> {
        if !self.judges() {
            return Ok(());
        }
        for (index, format) in self.leading(MIXED) {
            let program = &self.programs[index];
            progress(&format!("{}: a format for every value", program.name));
            let question = self.question(program);
            match mixture::mixture(&question, (index, format), None)? {
                Some((mixed, found)) => self.add(mixed, self.sizes[index].clone(), vec![found]),
                None => {
                    let why = format!("with formats for its values: none around {format} holds");
                    self.leave(index, &why);
                }
            }
        }
        Ok(())
    }

    /// Leaves the sines and cosines of the leading programs to units.
    fn units(&mut self, progress: ExplorationProgress<'_>) -> Result<(), FitError> {
        if self.task.trigonometry != SinePlace::Unit {
            return Ok(());
        }
        for (index, format) in self.leading(UNITS) {
            let program = &self.programs[index];
            if !program.has_sines() {
                continue;
            }
            progress(&format!("{}: units for sines and cosines", program.name));
            let found = units::units(&self.question(program), format, self.task.sampled())?;
            for (unit, measured) in found {
                self.add(unit, self.sizes[index].clone(), vec![measured]);
            }
        }
        Ok(())
    }

    /// Every program in its formats on its machines.
    pub(super) fn candidates(&mut self) -> Vec<FitCandidate> {
        let task = self.task;
        let mut candidates = Vec::new();
        for (index, program) in self.programs.iter().enumerate() {
            let path = critical_path(&program.module.functions[0], task.machine).asap_cycle;
            for size in &self.sizes[index] {
                for (format, errors) in &self.formats[index] {
                    let figures = self.figures.of(task.machine, size, *format);
                    let subject = (index, program, path);
                    candidates.push(candidate(task, subject, (*format, errors), size, figures));
                }
            }
        }
        candidates
    }

    pub(super) fn format_of(&self, candidate: &FitCandidate) -> Format {
        let formats = self.formats[candidate.program].iter();
        let mut named = formats.filter(|(format, _)| format.to_string() == candidate.format);
        named.next().expect("a candidate has one of the formats").0
    }

    /// Adds states at which a program failed, and widens its format.
    pub(super) fn learn(&mut self, failed: usize, states: Vec<Vec<f64>>) -> Result<(), FitError> {
        let news = Yardstick::at(view(self.task.general), states.clone());
        self.search.extend(view(self.task.general), states.clone());
        self.validation.extend(view(self.task.general), states);
        for (index, program) in self.programs.iter().enumerate() {
            for (format, errors) in &mut self.formats[index] {
                let more = FormatErrors::at(self.task, program, *format, &news)?;
                errors.shares.extend(more.shares);
            }
        }
        if self.programs[failed].mixture.is_some() {
            return self.mix_again(failed);
        }
        let is_fixed = |(format, _): &MeasuredFormat| matches!(format, Format::Fixed(_));
        let has_fixed = self.formats[failed].iter().any(is_fixed);
        let question = self.question(&self.programs[failed]);
        let mut formats = question.floating()?;
        if has_fixed {
            formats.extend(question.fixed()?.ok());
        }
        self.formats[failed] = formats;
        Ok(())
    }

    /// Formats for the values of a program again, with more digits, if any.
    fn mix_again(&mut self, failed: usize) -> Result<(), FitError> {
        let Some(old) = self.programs[failed].mixture.clone() else {
            return Ok(());
        };
        let question = self.question(&self.programs[old.base]);
        let found = mixture::mixture(&question, (old.base, old.around), Some(&old))?;
        self.formats[failed].clear();
        if let Some((program, format)) = found {
            self.programs[failed] = program;
            self.formats[failed].push(format);
        }
        Ok(())
    }

    /// Refuses a format of a program for its error over time, a multiple of the
    /// allowed one: as many more bits as that takes are tried next. Other
    /// programs err as their formats do, and need nearly as many.
    pub(super) fn widen(
        &mut self,
        program: usize,
        refused: Format,
        times: f64,
    ) -> Result<(), FitError> {
        if self.programs[program].mixture.is_some() {
            return self.mix_again(program);
        }
        let more = if times.is_finite() {
            (times.log2().floor() as u32).max(1)
        } else {
            1
        };
        let least = bits(refused) + more;
        for index in 0..self.programs.len() {
            if index == program {
                self.at_least(index, refused, least)?;
            } else if self.programs[index].mixture.is_none() && floats(refused) {
                self.at_least(index, refused, least.saturating_sub(SPARED))?;
            }
        }
        Ok(())
    }

    /// Excludes formats of a kind with fewer than `least` bits, and adds one.
    fn at_least(&mut self, program: usize, kind: Format, least: u32) -> Result<(), FitError> {
        let mut narrow = None;
        for (format, errors) in &mut self.formats[program] {
            if floats(*format) == floats(kind) && bits(*format) < least {
                errors.shares.push(f64::INFINITY);
                narrow = Some(*format);
            }
        }
        let wider = match narrow {
            None => return Ok(()),
            Some(Format::Float(float)) => Format::Float(NumberFormat {
                mantissa: least,
                ..float
            }),
            Some(Format::Fixed(fixed)) => Format::Fixed(FixedFormat {
                fraction: least,
                ..fixed
            }),
        };
        let known = |(format, _): &MeasuredFormat| *format == wider;
        if wider.significand() <= WIDEST + 1 && !self.formats[program].iter().any(known) {
            let errors = self.question(&self.programs[program]).validated(wider)?;
            self.formats[program].push((wider, errors));
        }
        Ok(())
    }

    pub(super) fn outcome(
        mut self,
        mut candidates: Vec<FitCandidate>,
        held: Option<(usize, Challenge)>,
    ) -> Result<FitOutcome, FitError> {
        let (chosen, challenge) = held.unzip();
        let mut bound = None;
        let mut sources = None;
        if let Some(chosen) = chosen {
            let candidate = &candidates[chosen];
            let (index, elements) = (candidate.program, candidate.elements);
            let format = self.format_of(candidate);
            let program = &self.programs[index];
            bound = bound::bound(self.task, program, format);
            if let Some(challenge) = &challenge {
                sources = FitSources::at(self.task, program, format, &challenge.worst)?;
            }
            candidates.extend(self.units_instead((index, format), elements)?);
        }
        Ok(FitOutcome {
            bound,
            sources,
            motion: None,
            programs: self.programs,
            candidates,
            chosen,
            challenge,
            broken: self.broken,
            drifted: self.drifted,
            untried: self.untried,
        })
    }

    /// Units for the sines and cosines of a choice, which err more than a host.
    fn units_instead(
        &mut self,
        (index, format): (usize, Format),
        elements: [u32; 2],
    ) -> Result<Vec<FitCandidate>, FitError> {
        let program = &self.programs[index];
        let by_host = self.task.trigonometry == SinePlace::Host && program.has_sines();
        if !by_host || program.mixture.is_some() || !self.judges() {
            return Ok(Vec::new());
        }
        let mut candidates = Vec::new();
        for (mut unit, measured) in units::units(&self.question(program), format, 1.0)? {
            unit.excluded = Some("the host's library costs the machine just as little".to_owned());
            let mut sizes = self.sizes[index].iter();
            let Some(size) = sizes.find(|size| size.elements == elements).cloned() else {
                continue;
            };
            let path = critical_path(&unit.module.functions[0], self.task.machine).asap_cycle;
            let made = (self.programs.len(), &unit, path);
            let figures = self.figures.of(self.task.machine, &size, format);
            let measure = (format, &measured.1);
            candidates.push(candidate(self.task, made, measure, &size, figures));
            self.add(unit, vec![size], vec![measured]);
        }
        Ok(candidates)
    }
}

/// True for a format with exponents.
fn floats(format: Format) -> bool {
    matches!(format, Format::Float(_))
}

/// Number of bits after the leading one, or after the point.
fn bits(format: Format) -> u32 {
    match format {
        Format::Float(float) => float.mantissa,
        Format::Fixed(fixed) => fixed.fraction,
    }
}

/// Exact results at random states of the scene, to measure errors against.
fn yardstick(task: &FitTask<'_>, states: u32, seed: u64) -> Yardstick {
    let source = task.scene.states(seed);
    Yardstick::new(view(task.general), &source, states)
}

/// Reason why a program in a format cannot be chosen; empty when it can.
fn remark(task: &FitTask<'_>, program: &FitProgram, format: Format) -> String {
    if let Some(excluded) = &program.excluded {
        return excluded.clone();
    }
    if task.trigonometry == SinePlace::Unit
        && program.treatment == SineTreatment::True
        && program.has_sines()
    {
        return "no unit computes sines without an error".to_owned();
    }
    match task.cost {
        CostMeasure::Cells => String::new(),
        CostMeasure::Device if program.mixture.is_some() => {
            format!("all elements compute in one format, for this program in {format}")
        }
        CostMeasure::Device if !floats(format) && floats(task.machine.number) => {
            "there are no Verilog cores for fixed point".to_owned()
        }
        CostMeasure::Device => String::new(),
    }
}

/// Cost and error of a program in a format on a machine it is placed on.
fn candidate(
    task: &FitTask<'_>,
    (index, program, path): (usize, &FitProgram, u32),
    (format, measured): (Format, &FormatErrors),
    size: &size::SizedMachine,
    figures: MachineFigures,
) -> FitCandidate {
    let function = &program.module.functions[0];
    let MachineFigures {
        clock,
        microseconds,
        resources,
        share,
    } = figures;
    let (used, errors) = (measured.used(), &measured.errors);
    let in_time = task
        .scene
        .deadline
        .is_none_or(|deadline| microseconds <= deadline);
    let remark = remark(task, program, format);
    FitCandidate {
        program: index,
        format: format.to_string(),
        elements: size.elements,
        operations: Counts::of(function).operations,
        path,
        cycles: size.cycles,
        clock,
        microseconds,
        relative: errors.relative,
        normwise: errors.normwise,
        used,
        resources,
        share,
        cells: function_cost(function, format),
        meets: remark.is_empty()
            && in_time
            && used <= task.accepted()
            // A scene without tolerances would let infinite results pass.
            && errors.normwise.worst.is_finite()
            && share <= 1.0,
        remark,
    }
}
