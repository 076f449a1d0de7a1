//! Choice, value by value, among the results of several passes on a function.

use crate::choice::chooser::ChoiceMethod;
use crate::choice::import::import;
use crate::choice::search::{self, PathSearch};
use crate::optimise::VariantClass;
use robovec_analysis::class::NumericClass;
use robovec_analysis::critical_path::Weights;
use robovec_framework::fingerprint::Images;
use robovec_framework::manager::apply;
use robovec_framework::options::OptionValue;
use robovec_framework::pass::{Context, Gives, NestedReport, Pass, PassError, Registry};
use robovec_framework::pipeline::Pipeline;
use robovec_framework::{declare_pass, option_words};
use robovec_ir::{Function, Level};

/// Texts of pipelines that are run side by side.
#[derive(Clone, PartialEq, Debug)]
pub struct Moves(Vec<String>);

/// The moves that are made when none are named.
const USUAL: &str = "balance,cse,dce; factor{path=keep},balance,cse,dce; \
                     lookahead,balance,cse,dce; \
                     lookahead{grid=5 frontiers=80},balance,cse,dce; \
                     recurrence,balance,cse,dce";

/// The maximum number of moves: all their results are in memory together.
const MOST: usize = 64;

impl OptionValue for Moves {
    fn type_name() -> String {
        "\"pipeline; pipeline; ...\"".to_owned()
    }

    fn parse(text: &str) -> Result<Moves, String> {
        let moves: Vec<String> = text.split(';').map(|text| text.trim().to_owned()).collect();
        if moves.len() > MOST {
            Err(format!("there are more than {MOST} moves"))
        } else {
            Ok(Moves(moves))
        }
    }

    fn print(&self) -> String {
        self.0.join("; ")
    }
}

option_words! {
    /// Goal of the choice where moves meet.
    #[derive(Default)]
    pub enum MeetGoal {
        /// The shortest path that the operations allowed can buy.
        #[default]
        Path = "path",
        /// The fewest operations within the path allowed.
        Operations = "operations",
    }
}

declare_pass! {
    /// Runs passes side by side and chooses among all they made, value by value.
    ///
    /// `meet{moves="factor,cse,dce; lookahead,balance,cse,dce"}` runs both
    /// pipelines on the unchanged function. Neither result is used whole: the
    /// function and both results are read into one network, where values are
    /// identified by their residues at two points of a prime field, and each
    /// value can be computed in every form that occurs in one of them. One
    /// choice is then made from all (lossless synthesis; Chatterjee,
    /// Mishchenko, Brayton and others 2005): with `for=path` the shortest path
    /// that the operations allowed can buy, with `for=operations` the fewest
    /// operations within the path allowed. The result is never worse than the
    /// best of those that are read.
    ///
    /// Moves take and give the level atomic, and preserve values as real
    /// numbers. With `class=real-trig` they may rest on sin² + cos² = 1, as
    /// `composite` and `factor-trig` do, and values are known on the circle. A
    /// move that gives up is left out, with a remark.
    pub struct Meet("meet") {
        /// The pipelines, divided by `;`, in quotes.
        pub moves: Moves = Moves::parse(USUAL).expect("the usual moves are pipelines"),
        /// Goal of the choice.
        pub r#for: MeetGoal = MeetGoal::default(),
        /// Numeric class that moves may use.
        pub class: VariantClass = VariantClass::Real,
        /// Operations allowed, in percent of those the function has.
        pub growth: u32 = 100 => search::GROWTH,
        /// Operations allowed, as a number; 0 leaves it to `growth`.
        pub operations: u32 = 0 => search::OPERATIONS,
        /// Longest path, in cycles: nothing is spent on a shorter one. With
        /// `for=operations` the one allowed, 0 for any.
        pub path: u32 = 0 => search::PATH,
        /// Way in which forms are chosen; by curves up to 200,000 values
        /// considered.
        pub choice: ChoiceMethod = ChoiceMethod::default(),
        /// Rounds in which operations are saved again.
        pub rounds: u32 = 3 => search::ROUNDS,
    }
    takes: [Atomic],
    gives: Gives::Level(Level::Atomic),
    class: RealTrig,
    destroys: [Timed],
}

impl Pass for Meet {
    fn class(&self, _: NumericClass) -> NumericClass {
        self.class.numeric()
    }

    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let mut variants = vec![function.clone()];
        let moves = self.pipelines(context.registry)?;
        variants.extend(made(&moves, function, context));
        let weights = Weights::cycles(context.machine);
        let timing = weights.with_equal_sums();
        let circle = self.class == VariantClass::RealTrig;
        let functions: Vec<&Function> = variants.iter().collect();
        let images = Images::of(function, circle);
        let Some(mut import) = import(&functions, context, timing, images) else {
            return Ok(());
        };
        import.sort();
        context.statistics.extend(import.counts());
        let search = PathSearch {
            function,
            import: &import,
            timing,
            weights,
            shortest: self.path,
            rounds: self.rounds,
            method: self.choice,
        };
        let before = search.size(function);
        let allowed = search::allowed(self.operations, self.growth, before.1);
        // The function itself may be none of those allowed, and stays when no
        // other is.
        let is_allowed = |&(path, operations): &(u32, u64)| match self.r#for {
            MeetGoal::Path => operations <= allowed,
            MeetGoal::Operations => self.path == 0 || path <= self.path,
        };
        let key = |&(path, operations): &(u32, u64)| match self.r#for {
            MeetGoal::Path => (u64::from(path), operations),
            MeetGoal::Operations => (operations, u64::from(path)),
        };
        let sizes: Vec<(u32, u64)> = variants.iter().map(|made| search.size(made)).collect();
        let fit = (0..variants.len()).filter(|&at| is_allowed(&sizes[at]));
        let best = fit.min_by_key(|&at| key(&sizes[at])).unwrap_or(0);
        let chosen = match self.r#for {
            MeetGoal::Path => search.run(context.tables, sizes[best], allowed),
            MeetGoal::Operations => Some(search.cheapest(context.tables)),
        };
        let chosen = chosen.filter(|(_, size)| is_allowed(size) && key(size) < key(&sizes[best]));
        let size = chosen.as_ref().map_or(sizes[best], |(_, size)| *size);
        *function = match chosen {
            Some((chosen, _)) => chosen,
            None => variants.swap_remove(best),
        };
        context.statistics.extend([
            (
                "cycles taken off the longest path",
                u64::from(before.0.saturating_sub(size.0)),
            ),
            ("operations saved", before.1.saturating_sub(size.1)),
        ]);
        Ok(())
    }
}

impl Meet {
    /// The moves, read.
    fn pipelines(&self, registry: &'static Registry) -> Result<Vec<Pipeline>, PassError> {
        let allowed = self.class.numeric();
        let mut pipelines = Vec::with_capacity(self.moves.0.len());
        for text in &self.moves.0 {
            let pipeline = registry
                .pipeline(text)
                .map_err(|error| PassError::new(error.to_string()))?;
            for step in pipeline.passes() {
                if step.info.name == Meet::INFO.name {
                    return Err(PassError::new("a move cannot contain the pass 'meet'"));
                }
                let pass = (step.info.build)(&step.options)
                    .map_err(|error| PassError::new(format!("{step}: {error}")))?;
                let class = pass.class(step.info.class);
                if class > allowed {
                    let message = format!(
                        "'{step}' has the class {}, which is not allowed here",
                        class.name()
                    );
                    let error = PassError::new(message);
                    return Err(match class {
                        NumericClass::RealTrig => error.help("allow it with class=real-trig"),
                        _ => error,
                    });
                }
            }
            pipelines.push(pipeline);
        }
        Ok(pipelines)
    }
}

/// Functions that moves make of a function.
fn made(moves: &[Pipeline], function: &Function, context: &mut Context<'_>) -> Vec<Function> {
    let machine = context.machine;
    let mut variants = Vec::with_capacity(moves.len());
    for pipeline in moves {
        let mut made = function.clone();
        let mut report = NestedReport::default();
        let run = apply(
            pipeline,
            &mut made,
            &mut context.nested(machine, &mut report),
        );
        let reason = match run {
            Err(error) => error.message,
            Ok(()) if made.level != Level::Atomic => "its result is not atomic".to_owned(),
            Ok(()) => {
                variants.push(made);
                continue;
            }
        };
        let remark = format!("the move the move '{pipeline}' is left out: {reason}");
        context.remark(remark);
    }
    variants
}
