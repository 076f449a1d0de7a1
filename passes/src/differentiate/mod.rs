//! Derivatives of a function, by elimination on its linearised graph.

mod eliminate;
mod graph;
mod job;
#[cfg(test)]
mod tests;
mod weights;

use job::DerivativeJob;
use robovec_framework::declare_pass;
use robovec_framework::differentiation::{
    ArrayChoice, DerivativeArrays, DerivativeResult, Differentiation, DifferentiationError, KEY,
};
use robovec_framework::option_words;
use robovec_framework::options::OptionValue;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::rewrite::without_dead;
use robovec_ir::{Array, Function, View};

declare_pass! {
    /// Writes the derivatives of outputs by inputs.
    ///
    /// `differentiate{of=Qq by=q+qd}` adds the Jacobian of the output `Qq` by
    /// the inputs `q` and `qd` as arrays `Qq_q` and `Qq_qd`: a row for each
    /// element of the output, a column for each of the input, the elements of
    /// a matrix row by row; a scalar takes no dimension. Elements that are
    /// always zero are not set, save the first of an array of zeros. With `result=direction` there is an input
    /// `q_direction` beside `q`, and the output `Qq_direction` is the Jacobian
    /// times all directions; with `result=gradient` there is an input
    /// `Qq_weight`, and the output `q_gradient` is the transposed Jacobian
    /// times all weights. Applied twice, with `values=false` the second time,
    /// it gives second derivatives: a gradient and then a direction are the
    /// product of a Hessian with a vector.
    ///
    /// Common values are shared with the function itself. In `mixed` mode the
    /// operations of every independent part of the function are counted in four
    /// orders (forward, reverse, fewest products first, fewest new edges
    /// first), and the part is written in the cheapest order.
    ///
    /// Results of user functions are inputs, and count as constant unless `by`
    /// names them. Where a root is zero there is no derivative; a remark names
    /// these roots. Run it before the passes for speed or accuracy, which also
    /// work on derivatives. The semantic check compares the result with dual
    /// numbers of the function.
    pub struct Differentiate("differentiate") {
        /// Output arrays that are differentiated.
        pub of: ArrayChoice = ArrayChoice::All,
        /// Input arrays that they are differentiated by.
        pub by: ArrayChoice = ArrayChoice::All,
        /// The order in which the chain rule is applied.
        pub mode: DerivativeMode = DerivativeMode::Mixed,
        /// Part of the Jacobian that is computed.
        pub result: DerivativeResult = DerivativeResult::Jacobian,
        /// Keeps the outputs of the function; arguments of user functions are always kept.
        pub values: bool = true,
    }
    takes: [Atomic],
    gives: Gives::Same,
    class: Real,
    destroys: [Timed, ZeroFree, Shared, Live],
}

option_words! {
    /// The order in which the chain rule is applied.
    pub enum DerivativeMode {
        /// The cheapest for every part.
        Mixed = "mixed",
        /// From the inputs to the outputs.
        Forward = "forward",
        /// From the outputs to the inputs.
        Reverse = "reverse",
    }
}

impl Pass for Differentiate {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        if function.formats.is_some() {
            let message = "values have their own formats, and those of derivatives are unknown";
            return Err(PassError::new(message).help("run 'differentiate' before 'mixed'"));
        }
        let view = context.tables.view(function);
        let arrays = self.wanted().arrays(view).map_err(refusal)?;
        let told = self.told(&arrays, view);
        let job = DerivativeJob::new(function, arrays, self.result, context.tables);
        let written = job.write(self.mode, context)?;
        for (name, rule) in written.rules {
            context.notes.note(name, rule);
        }
        let mut new = written.function;
        match new.metadata.iter_mut().find(|(key, _)| key == KEY) {
            Some((_, known)) => *known = format!("{told} of {known}"),
            None => new.metadata.push((KEY.to_owned(), told)),
        }
        *function = without_dead(new);
        Ok(())
    }

    fn differentiation(&self) -> Option<Differentiation> {
        Some(self.wanted())
    }
}

impl Differentiate {
    fn wanted(&self) -> Differentiation {
        Differentiation {
            of: self.of.clone(),
            by: self.by.clone(),
            result: self.result,
            values: self.values,
        }
    }

    /// The derivative in a few words, for the head of the program.
    fn told(&self, arrays: &DerivativeArrays, view: View<'_>) -> String {
        let names = |arrays: &[Array]| {
            let names = arrays.iter();
            let names = names.map(|array| view.tables.symbols.text(array.name));
            names.collect::<Vec<_>>().join("+")
        };
        let (of, by) = (names(&arrays.of), names(&arrays.by));
        format!("{} of {of} by {by}", self.result.print())
    }
}

fn refusal(error: DifferentiationError) -> PassError {
    PassError::new(error.to_string()).help(error.help())
}
