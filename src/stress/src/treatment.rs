//! Treatments that make the error of a program smaller.

use robovec_dynamics::generate::Formulation;
use robovec_ir::Format;
use std::fmt;

/// The passes that shorten paths by regrouping sums and products.
pub(super) const BALANCED: &str = "atomise,zero-removal,balance,cse,dce";

/// Passes over the equations of every recursion: none, regrouping for short
/// paths and for common factors, and sums that round less.
pub(super) const PASSES: [&str; 7] = [
    "",
    BALANCED,
    "atomise,factor,cse,dce",
    "atomise,factor{path=free},cse,dce",
    "atomise,composite,cse,dce",
    "atomise,accurate",
    "atomise,accurate{growth=1000 slack=1000}",
];

/// Method that keeps the loops of a model closed in time.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum LoopStabilisation {
    /// No stabilisation: accelerations agree with loops, positions need not.
    #[default]
    None,
    /// Accelerations lead gaps back, with critical damping (Baumgarte 1972).
    Baumgarte,
    /// After every step the dependent joints are put back onto the loops.
    Projection,
}

impl LoopStabilisation {
    /// All of them.
    pub const ALL: [LoopStabilisation; 3] = [
        LoopStabilisation::None,
        LoopStabilisation::Baumgarte,
        LoopStabilisation::Projection,
    ];
}

/// Making and running of a program. The default is the untreated program: the
/// recursion that Robotran prints, in binary32.
#[derive(Clone, PartialEq, Debug)]
pub struct ProgramTreatment {
    /// The recursion the equations come from.
    pub formulation: Formulation,
    /// The passes that are run over them; none when empty.
    pub passes: &'static str,
    /// Independent joints of the loops; those of the model when empty.
    pub independent: Vec<String>,
    /// Another form of the equations, by name; the original one when empty.
    pub form: &'static str,
    /// Format of the computation.
    pub format: Format,
    /// Every value in the narrowest format for this error: the pass `mixed`.
    pub mixed: Option<f64>,
    /// Method that keeps loops closed.
    pub stabilisation: LoopStabilisation,
    /// Format of forces (`c`, `Qq`, residuals), if not that of masses.
    pub forces: Option<Format>,
    /// Steps of iterative refinement of accelerations: each solves again, with
    /// the same factor of `M`, for the residual of the inverse dynamics.
    pub refinements: u32,
    /// Compute in units that bring the model's numbers to the order of one.
    pub units: bool,
    /// Keep rounding errors of additions to integrator states (Kahan 1965).
    pub compensated: bool,
    /// Format of the integrator's state, if not that of the slopes.
    pub state: Option<Format>,
    /// The integrator's step, s.
    pub step: Option<f64>,
    /// Highest power of the angle in series for sines; else true functions.
    pub series: Option<u32>,
}

impl ProgramTreatment {
    pub(super) fn state_format(&self) -> Format {
        self.state.unwrap_or(self.format)
    }

    pub(super) fn force_format(&self) -> Format {
        self.forces.unwrap_or(self.format)
    }

    /// The integrator's step, s, where that of a case is usual.
    pub(super) fn step_or(&self, usual: f64) -> f64 {
        self.step.unwrap_or(usual)
    }
}

impl Default for ProgramTreatment {
    fn default() -> ProgramTreatment {
        ProgramTreatment {
            formulation: Formulation::default(),
            passes: "",
            independent: Vec::new(),
            form: "",
            format: Format::BINARY32,
            mixed: None,
            stabilisation: LoopStabilisation::None,
            forces: None,
            refinements: 0,
            units: false,
            compensated: false,
            state: None,
            step: None,
            series: None,
        }
    }
}

impl ProgramTreatment {
    #[must_use]
    pub(super) fn with(&self, change: impl FnOnce(&mut ProgramTreatment)) -> ProgramTreatment {
        let mut changed = self.clone();
        change(&mut changed);
        changed
    }

    /// The untreated program in a format.
    pub fn in_format(format: Format) -> ProgramTreatment {
        ProgramTreatment::default().with(|it| it.format = format)
    }

    /// The same in binary32: one program is shared by all formats.
    pub(super) fn in_binary32(&self) -> ProgramTreatment {
        self.with(|it| it.format = Format::BINARY32)
    }

    /// True when only the program differs from the untreated one.
    pub(super) fn is_another_program(&self, untreated: &ProgramTreatment) -> bool {
        let same = ProgramTreatment {
            formulation: untreated.formulation,
            passes: untreated.passes,
            independent: untreated.independent.clone(),
            form: untreated.form,
            stabilisation: untreated.stabilisation,
            ..self.clone()
        };
        same == *untreated && self != untreated
    }

    /// Difference of it from another, in a few words.
    pub fn label(&self, untreated: &ProgramTreatment) -> String {
        let mut words: Vec<String> = Vec::new();
        if self.formulation != untreated.formulation {
            words.push(self.formulation.name().to_owned());
        }
        if self.form != untreated.form {
            words.push(self.form.to_owned());
        }
        if self.passes != untreated.passes {
            words.push(match self.passes {
                BALANCED => "balanced".to_owned(),
                // Every list of passes begins there.
                passes => passes.trim_start_matches("atomise,").to_owned(),
            });
        }
        if self.independent != untreated.independent {
            words.push(format!("independent {}", self.independent.join(" ")));
        }
        match self.stabilisation {
            LoopStabilisation::None => {}
            LoopStabilisation::Baumgarte => words.push("stabilised".to_owned()),
            LoopStabilisation::Projection => words.push("projected".to_owned()),
        }
        if self.series != untreated.series {
            words.push(match self.series {
                None => "true sin, cos".to_owned(),
                Some(order) => format!("order {order}"),
            });
        }
        if self.step != untreated.step {
            words.push(match self.step {
                None => "another step".to_owned(),
                Some(step) => format!("dt {step:?} s"),
            });
        }
        if let Some(error) = self.mixed {
            words.push(format!("mixed within {error:.0e}"));
        } else if self.format != untreated.format {
            words.push(self.format.to_string());
        }
        if let Some(format) = self.forces {
            words.push(format!("forces {format}"));
        }
        match self.refinements {
            0 => {}
            1 => words.push("refined once".to_owned()),
            2 => words.push("refined twice".to_owned()),
            count => words.push(format!("refined {count} times")),
        }
        if let Some(format) = self.state {
            words.push(format!("state {format}"));
        }
        if self.compensated {
            words.push("compensated state".to_owned());
        }
        if self.units {
            words.push("other units".to_owned());
        }
        if words.is_empty() {
            words.push("as it is".to_owned());
        }
        words.join(", ")
    }
}

impl fmt::Display for ProgramTreatment {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.label(&ProgramTreatment::default()))
    }
}
