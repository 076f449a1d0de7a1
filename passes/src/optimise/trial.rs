//! Variants made and measured.

use super::variants::{self, FUSED, VARIANTS, Variant};
use robovec_analysis::class::NumericClass;
use robovec_analysis::critical_path::critical_path;
use robovec_framework::manager::apply;
use robovec_framework::pass::{Context, NestedReport, PassError, Registry};
use robovec_framework::pipeline::Pipeline;
use robovec_framework::trail::Notes;
use robovec_ir::count::Counts;
use robovec_ir::{Function, Level, Machine, Operation};
use robovec_schedule::{PlaceError, schedule_bound};

/// A variant with its figures.
pub(super) struct VariantTrial {
    /// Its name.
    pub(super) name: String,
    /// The function it is; empty when it was not made.
    pub(super) function: Function,
    /// The rules its passes noted.
    pub(super) notes: Notes,
    /// Operations.
    pub(super) operations: usize,
    /// The longest path, in cycles.
    pub(super) path: u32,
    /// No schedule is shorter; the reason when there is none at all.
    pub(super) bound: Result<u32, PlaceError>,
    /// The schedule, where one was made.
    pub(super) cycles: Option<u32>,
    /// The reason why it was not made or not placed.
    pub(super) remark: &'static str,
    /// No schedule is shorter for want of elements alone.
    shared: u32,
}

impl VariantTrial {
    /// False for a variant that is only a row in the table.
    pub(super) fn is_made(&self) -> bool {
        self.operations > 0 || !self.function.assignments.is_empty()
    }

    fn new(name: String, function: Function, notes: Notes, machine: &Machine) -> VariantTrial {
        let bound = schedule_bound(&function, machine);
        VariantTrial {
            name,
            operations: Counts::of(&function).operations,
            path: critical_path(&function, machine).asap_cycle,
            shared: shared(&function, machine),
            bound,
            cycles: None,
            remark: "",
            function,
            notes,
        }
    }

    fn not_made(name: String, remark: &'static str) -> VariantTrial {
        VariantTrial {
            name,
            function: Function::new("", Level::Atomic),
            notes: Notes::unwanted(),
            operations: 0,
            path: 0,
            bound: Ok(u32::MAX),
            cycles: None,
            remark,
            shared: u32::MAX,
        }
    }
}

/// The operations of the scarcest kind over its elements.
fn shared(function: &Function, machine: &Machine) -> u32 {
    let mut operations = [0_u32; Operation::ALL.len()];
    for node in function.nodes() {
        operations[node.operation as usize] += 1;
    }
    let of_kind = machine.elements.iter().map(|element| {
        let performed = Operation::ALL
            .into_iter()
            .filter(|&known| element.performs(known));
        let count: u32 = performed.map(|known| operations[known as usize]).sum();
        count.div_ceil(element.count)
    });
    of_kind.max().unwrap_or(0)
}

/// The function and settings that variants are made from.
struct Workshop<'a> {
    machine: &'a Machine,
    /// The function at the level atomic.
    start: Function,
    budget: usize,
    trials: Vec<VariantTrial>,
}

/// Makes the variants whose passes are of a class or a stricter one, within
/// the budget; the first is always made.
///
/// # Errors
///
/// When a pass gives up on the function.
pub(super) fn make(
    function: &Function,
    machine: &Machine,
    (budget, class): (u32, NumericClass),
    context: &mut Context<'_>,
) -> Result<Vec<VariantTrial>, PassError> {
    let mut start = function.clone();
    if start.level == Level::Equations {
        let atomise = fixed(context.registry, "atomise")?;
        apply(
            &atomise,
            &mut start,
            &mut context.nested(machine, &mut NestedReport::default()),
        )?;
    }
    let mut workshop = Workshop {
        machine,
        start,
        budget: budget as usize,
        trials: Vec::new(),
    };
    let mut fused = Vec::new();
    if machine.kind_of(Operation::Fma).is_some() {
        for (name, pipeline) in FUSED {
            fused.push((name, fixed(context.registry, pipeline)?));
        }
    }
    for variant in VARIANTS {
        let Some(pipeline) = variant.pipeline(context.registry) else {
            continue;
        };
        if variants::class(&pipeline) > class {
            continue;
        }
        workshop.variant(variant, &pipeline, context)?;
        for (name, pipeline) in &fused {
            workshop.fuse(variant, name, pipeline, context)?;
        }
    }
    Ok(workshop.trials)
}

/// A pipeline that does not depend on the function.
fn fixed(registry: &'static Registry, text: &str) -> Result<Pipeline, PassError> {
    registry
        .pipeline(text)
        .map_err(|error| PassError::new(format!("{text}: {error}")))
}

impl Workshop<'_> {
    fn find(&self, name: &str) -> Option<&VariantTrial> {
        self.trials
            .iter()
            .find(|trial| trial.name == name && trial.is_made())
    }

    fn variant(
        &mut self,
        variant: &Variant,
        pipeline: &Pipeline,
        context: &mut Context<'_>,
    ) -> Result<(), PassError> {
        let (function, notes) = match variant.from.map(|from| self.find(from)) {
            None => (&self.start, None),
            Some(Some(trial)) => (&trial.function, Some(&trial.notes)),
            // What it would start from was not made.
            Some(None) => return Ok(()),
        };
        let (function, notes) = (function.clone(), notes.cloned());
        let name = variant.name.to_owned();
        if !self.has_elements(variant) {
            self.trials
                .push(VariantTrial::not_made(name, "too many operations"));
            return Ok(());
        }
        let work = function.nodes().len().saturating_mul(variant.weight);
        self.try_out((name, work), function, notes, pipeline, context)
    }

    /// The same with products and sums in one.
    fn fuse(
        &mut self,
        variant: &Variant,
        how: &str,
        pipeline: &Pipeline,
        context: &mut Context<'_>,
    ) -> Result<(), PassError> {
        let Some(plain) = self.find(variant.name) else {
            return Ok(());
        };
        let (function, notes) = (plain.function.clone(), plain.notes.clone());
        let name = format!("{}, {how}", variant.name);
        let work = function.nodes().len();
        self.try_out((name, work), function, Some(notes), pipeline, context)
    }

    fn try_out(
        &mut self,
        (name, work): (String, usize),
        mut function: Function,
        notes: Option<Notes>,
        pipeline: &Pipeline,
        context: &mut Context<'_>,
    ) -> Result<(), PassError> {
        if work > self.budget && !self.trials.is_empty() {
            self.trials
                .push(VariantTrial::not_made(name, "beyond the budget"));
            return Ok(());
        }
        self.budget = self.budget.saturating_sub(work);
        let mut report = NestedReport {
            notes: notes.unwrap_or_default(),
            ..NestedReport::default()
        };
        apply(
            pipeline,
            &mut function,
            &mut context.nested(self.machine, &mut report),
        )?;
        let trial = VariantTrial::new(name, function, report.notes, self.machine);
        self.trials.push(trial);
        Ok(())
    }

    /// False when the variant with fewer operations already has too many for
    /// the elements there are.
    fn has_elements(&self, variant: &Variant) -> bool {
        let Some(before) = variant.beyond else {
            return true;
        };
        let bounds = self
            .trials
            .iter()
            .filter_map(|trial| trial.bound.as_ref().ok());
        let least = bounds.min().copied().unwrap_or(u32::MAX);
        let before = self.trials.iter().find(|trial| trial.name == before);
        before.is_none_or(|before| before.shared < least)
    }
}
