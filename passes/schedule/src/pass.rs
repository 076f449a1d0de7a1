//! Placement as a pass: its options, the machine with the requested numbers of
//! elements, and the messages for the user. The placing itself is [`place`].

use super::{ElementChoice, PlaceError, PlaceOptions, Priority, place};
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::{declare_pass, instances};
use robovec_ir::diagnostic::counted;
use robovec_ir::machine::fields;
use robovec_ir::{Function, Level, Machine, Value};

declare_pass! {
    /// Gives every operation a cycle and a processing element of the machine.
    ///
    /// List scheduling (thesis 2.2 and 2.3) under the rules of the machine: one
    /// issue per element and cycle, this number of writes per memory and cycle,
    /// this number of words read from a buffer per cycle, this number of words.
    /// Every transfer is explicit in the result: initial data in the memories
    /// that read them, results written directly in the cycle in which they
    /// appear or indirectly, through the buffer, in a later one, and a word for
    /// each output that stays to the end.
    ///
    /// The bound printed beside the length is proved: no schedule of this
    /// function on this machine is shorter.
    ///
    /// `priority` decides which operation goes first: `alap` and `mobility`
    /// are the thesis' orders (2.3.1), `fan-out` breaks the ties of `alap` by
    /// the number of readers, `best` tries more where that falls short of the
    /// bound.
    ///
    /// `choice` decides among the free elements: `first` takes the first one
    /// the operands can reach, `preferential` follows Table 2.1 of the thesis
    /// and keeps memories and buffers small and alike: an operation with time
    /// to spare waits for an element that needs no buffer, and where there
    /// are only one or two elements of a kind, results are not computed
    /// before the write ports they need are free.
    ///
    /// A machine without buffers is served too: operations get an element
    /// before their operands are computed, and write ports are kept for them
    /// there until a better element proves to have been free.
    ///
    /// On a machine with another interconnect than the crossbar words take
    /// time, and links that carry few of them; near elements are preferred. The
    /// bound does not include that.
    pub struct Place("place") {
        /// Adders; by default those of the machine file.
        pub n_add: Option<u32> = None => fields::count::LIMIT,
        /// Multipliers; by default those of the machine file.
        pub n_multi: Option<u32> = None => fields::count::LIMIT,
        /// Dividers, on machines that have them.
        pub n_div: Option<u32> = None => fields::count::LIMIT,
        /// Square-root extractors, on machines that have them.
        pub n_sqrt: Option<u32> = None => fields::count::LIMIT,
        /// Elements that multiply and add in one operation, on machines that
        /// have them.
        pub n_fma: Option<u32> = None => fields::count::LIMIT,
        /// Rank of the operations.
        pub priority: Priority = Priority::default(),
        /// Choice of the element.
        pub choice: ElementChoice = ElementChoice::default(),
    }
    takes: [Atomic, Scheduled, Placed],
    gives: Gives::Level(Level::Placed),
    class: Exact,
}

/// For each option that sets a number of elements: its name, the kind of
/// element ([`ElementDescription::kind`](robovec_ir::machine::ElementDescription))
/// and the number; `None` where the user gave none.
pub type ElementCounts = [(&'static str, &'static str, Option<u32>); 5];

/// The options `n_add`, `n_multi`, `n_div`, `n_sqrt` and `n_fma`, in this
/// order, with the kinds of elements they count.
pub fn element_counts(numbers: [Option<u32>; 5]) -> ElementCounts {
    let [add, multi, div, sqrt, fma] = numbers;
    [
        ("n_add", "add", add),
        ("n_multi", "multi", multi),
        ("n_div", "div", div),
        ("n_sqrt", "sqrt", sqrt),
        ("n_fma", "fma", fma),
    ]
}

/// The machine with the numbers of elements that options give; a kind whose
/// option is not given keeps the number of the machine file.
///
/// # Errors
///
/// Fails when a number is out of range, or the machine has no such kind.
pub fn with_counts(machine: &Machine, counts: ElementCounts) -> Result<Machine, PassError> {
    let mut machine = machine.clone();
    for (option, kind, count) in counts {
        let Some(count) = count else { continue };
        if let Err(reason) = fields::count::check(&count) {
            return Err(PassError::new(format!("{option}: {reason}")));
        }
        let mut elements = machine.elements.iter_mut();
        let Some(element) = elements.find(|element| element.kind == kind) else {
            return Err(PassError::new(format!(
                "{option} is given, but the machine '{}' has no elements of kind '{kind}'",
                machine.name
            )));
        };
        element.count = count;
    }
    Ok(machine)
}

impl Pass for Place {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let numbers = [
            self.n_add,
            self.n_multi,
            self.n_div,
            self.n_sqrt,
            self.n_fma,
        ];
        let machine = with_counts(context.machine, element_counts(numbers))?;
        let options = PlaceOptions {
            priority: self.priority,
            choice: self.choice,
        };
        let summary = place(function, &machine, options)
            .map_err(|error| explain(&error, function, context))?;
        let statistics = [
            ("cycles", summary.cycles),
            ("lower bound", summary.lower_bound),
            ("orders tried", summary.tries),
        ];
        for (name, number) in statistics {
            context.count(name, number.into());
        }
        let quality = match summary.cycles - summary.lower_bound {
            0 => "optimal".to_owned(),
            above => format!(
                "at most {above} above the optimum ({:.2} %)",
                // The bound of a function without operations is 0.
                100.0 * f64::from(above) / f64::from(summary.lower_bound.max(1))
            ),
        };
        // Of a function that computes several states at a time, what one costs.
        let per_instance = match instances::count(function) {
            1 => String::new(),
            count => format!(
                " ({:.1} for each of {count} instances)",
                f64::from(summary.cycles) / f64::from(count)
            ),
        };
        context.remark(format!(
            "{}{per_instance} on '{}', {quality}, by order '{}'",
            counted(summary.cycles, "cycle"),
            machine.name,
            summary.order
        ));
        Ok(())
    }
}

/// Turns the error of a placement into that of the pass: with the equations
/// concerned, if any, and the remedy.
pub fn explain(error: &PlaceError, function: &Function, context: &Context<'_>) -> PassError {
    let about = |value: &Value| {
        let node = function.node(*value);
        let name = node.name.display(&context.tables.symbols);
        PassError::new(format!("%{name}: {error}")).at(node.sources)
    };
    match error {
        PlaceError::NotAtomic { .. } => {
            PassError::new(error.to_string()).help("run 'atomise' before 'place'")
        }
        PlaceError::NotPerformed {
            value, operation, ..
        } => about(value).help(format!(
            "add '{operation}' to the operations of a kind in a machine file"
        )),
        PlaceError::ComputedAngle { value, .. } => about(value)
            .help("pass the angle as an input, and let the caller compute it".to_owned()),
        PlaceError::MemoryTooSmall { .. } => PassError::new(error.to_string()).help(
            "use more processing elements (n_add, n_multi), which distribute the words over more \
             memories, or a machine with larger memories",
        ),
        PlaceError::NoWritePorts { .. } | PlaceError::TooLong { .. } => {
            PassError::new(error.to_string())
        }
    }
}
