//! Promises of the class of a pass about values.

use crate::referee::Leniency;
use robovec_analysis::class::NumericClass;
use robovec_framework::instances::Instances;
use robovec_framework::pipeline::PassStep;

/// Promise of a step.
pub(super) struct Promise {
    pub(super) class: NumericClass,
    pub(super) instances: Option<Instances>,
    pub(super) leniency: Leniency,
    /// Range of inputs.
    pub(super) range: f64,
}

impl Promise {
    pub(super) fn of(step: &PassStep) -> Promise {
        let pass = (step.info.build)(&step.options).expect("its options are its own");
        let option = |name: &str| {
            let mut options = step.options.iter();
            let found = options.find(|(option, _)| option == name);
            found.and_then(|(_, value)| value.parse::<f64>().ok())
        };
        // Series say how far they are off for angles within their range.
        let series = step.info.name == "trigonometry";
        Promise {
            class: pass.class(step.info.class),
            instances: pass.instances(),
            leniency: Leniency {
                // They replace expressions of constants by their values.
                rounded_literals: match step.info.name {
                    "specialise" | "trigonometry" => true,
                    "fold" => (step.options.iter())
                        .any(|(option, value)| option == "inexact" && value == "true"),
                    _ => false,
                },
                circular: if series {
                    option("error").unwrap_or(0.0)
                } else {
                    0.0
                },
            },
            range: if series {
                option("range").unwrap_or(f64::INFINITY)
            } else {
                f64::INFINITY
            },
        }
    }
}
