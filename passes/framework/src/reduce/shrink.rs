//! Delta debugging: smaller and smaller programs that go wrong the same way.
//!
//! Edits are tried in chunks that are halved down to single values (Zeller and
//! Hildebrandt 2002), the coarsest kind first: outputs dropped, values made
//! inputs, operations replaced by an operand, single values kept with their
//! operands, numbers simplified. The steps are repeated until no smaller
//! program fails, or the work is used up.

use super::edit::{Edit, Fate};
use super::trial::{Case, PassProblem, TrialSetting};
use robovec_ir::{Function, Value, verify};

/// The effort spent.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct ReductionEffort {
    /// Programs tried.
    pub trials: u64,
    /// Values in all programs tried, times the passes run on them.
    pub work: u64,
    /// True if the work was used up before the smallest program was found.
    pub exhausted: bool,
}

/// Makes a case smaller while it shows the problem; at most `work` values are
/// run through passes, independent of the speed of the machine.
pub(super) fn shrink(
    case: &mut Case,
    problem: &PassProblem,
    setting: TrialSetting<'_>,
    work: u64,
) -> ReductionEffort {
    let mut shrinker = Shrinker {
        case,
        problem,
        setting,
        allowed: work,
        effort: ReductionEffort::default(),
    };
    let nothing = Edit::nothing(&shrinker.case.function);
    shrinker.attempt(&nothing);
    while !shrinker.effort.exhausted && shrinker.round() {}
    let mut scalars = Edit::nothing(&shrinker.case.function);
    scalars.scalars = true;
    shrinker.attempt(&scalars);
    shrinker.effort
}

struct Shrinker<'a> {
    case: &'a mut Case,
    problem: &'a PassProblem,
    setting: TrialSetting<'a>,
    allowed: u64,
    effort: ReductionEffort,
}

impl Shrinker<'_> {
    /// True when something became smaller.
    fn round(&mut self) -> bool {
        let size = self.size();
        self.outputs();
        self.values(Fate::Cut);
        self.values(Fate::Operand(0));
        self.values(Fate::Operand(1));
        self.values(Fate::Operand(2));
        self.roots();
        self.numbers();
        self.size() < size
    }

    /// The size that a round must lower.
    fn size(&self) -> (usize, usize, usize) {
        let function = &self.case.function;
        let simple = |number: &&f64| SIMPLE.contains(*number);
        let odd = function.constants().len() - function.constants().iter().filter(simple).count();
        (function.nodes().len(), function.assignments.len(), odd)
    }

    /// Applies an edit if the smaller case still shows the problem.
    fn attempt(&mut self, edit: &Edit) -> bool {
        let mut smaller = self.case.clone();
        smaller.function = edit.apply(&self.case.function, &mut smaller.tables);
        let work = (smaller.function.nodes().len() + 1) * smaller.steps.len();
        if self.effort.work + work as u64 > self.allowed {
            self.effort.exhausted = true;
            return false;
        }
        self.effort.trials += 1;
        self.effort.work += work as u64;
        let view = smaller.tables.view(&smaller.function);
        let shows =
            verify::verify(view).is_empty() && smaller.shows(self.problem, self.setting, None);
        if shows {
            *self.case = smaller;
        }
        shows
    }

    /// Drops outputs.
    fn outputs(&mut self) {
        self.chunks(
            |function| function.assignments.len(),
            |edit, place| edit.outputs[place] = false,
        );
    }

    /// Gives values another fate.
    fn values(&mut self, fate: Fate) {
        self.chunks(
            |function| function.nodes().len(),
            |edit, place| edit.fates[place] = fate,
        );
    }

    /// Keeps the operands of one value alone, in small functions: dropping
    /// users one by one does not lead there where two of them hide the problem.
    fn roots(&mut self) {
        let function = &self.case.function;
        let small = function.nodes().len() <= MAX_ROOTS && !function.assignments.is_empty();
        let values: Vec<Value> = function.values().map(|(value, _)| value).collect();
        if !small || values.len() < 2 {
            return;
        }
        for &root in &values[..values.len() - 1] {
            let mut edit = Edit::nothing(&self.case.function);
            edit.root = Some(root);
            edit.outputs[1..].fill(false);
            if self.effort.exhausted || self.attempt(&edit) {
                return;
            }
        }
    }

    /// Tries something on all places of a function, in chunks that get
    /// smaller.
    fn chunks(&mut self, count: fn(&Function) -> usize, change: impl Fn(&mut Edit, usize)) {
        let mut chunk = count(&self.case.function).div_ceil(2);
        while chunk > 0 && !self.effort.exhausted {
            let mut start = 0;
            while start < count(&self.case.function) && !self.effort.exhausted {
                let before = count(&self.case.function);
                let mut edit = Edit::nothing(&self.case.function);
                for place in start..before.min(start + chunk) {
                    change(&mut edit, place);
                }
                // When places have gone, others stand where these stood.
                let gone = self.attempt(&edit) && count(&self.case.function) < before;
                if !gone {
                    start += chunk;
                }
            }
            chunk /= 2;
        }
    }

    /// Writes 2 for numbers that are not simple.
    fn numbers(&mut self) {
        let numbers: Vec<f64> = self.case.function.constants().to_vec();
        for number in numbers {
            if !SIMPLE.contains(&number) {
                let mut edit = Edit::nothing(&self.case.function);
                edit.numbers.push((number, 2.0));
                self.attempt(&edit);
            }
        }
    }
}

/// Number of values that are tried as the only one that is needed.
const MAX_ROOTS: usize = 64;

const SIMPLE: [f64; 4] = [0.0, 1.0, -1.0, 2.0];
