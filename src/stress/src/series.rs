//! Inverse dynamics with series instead of sine and cosine.

use super::case::{Measured, StressBench, StressSubject};
use super::dynamics::{DynamicsSubject, Metric, componentwise, normwise, worst};
use super::numbers::{Evaluation, Wide, Work, WorkingPrecision};
use super::program::{ModelProgram, ProgramRecipe};
use super::units::Units;
use super::{ProgramTreatment, StressError};
use robovec_dynamics::kinematics::MotionState;
use robovec_ir::Format;
use robovec_ir::cost::OperationWork;
use robovec_model::Model;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::Double;
use robovec_robotran::FunctionKind;

/// An arithmetic whose sine and cosine are Taylor polynomials.
struct SeriesArithmetic<'a, A> {
    inner: &'a A,
    /// The highest power.
    order: u32,
}

impl<A: Arithmetic> SeriesArithmetic<'_, A> {
    /// `1 - x²/((first)(first+1)) (1 - x²/((first+2)(first+3)) (…))` with all
    /// powers up to the order of the sine (`first` 2) or cosine (1).
    fn series(&self, square: A::Number, first: u32) -> A::Number {
        let a = self.inner;
        let one = a.literal(1.0);
        let mut sum = one;
        // The power of the term k of the sine is 2k + 1, of the cosine 2k.
        let terms = (self.order + 1 - first) / 2;
        for term in (0..terms).rev() {
            let k = f64::from(first + 2 * term);
            let factor = a.literal(1.0 / (k * (k + 1.0)));
            sum = a.sub(one, a.mul(a.mul(square, factor), sum));
        }
        sum
    }
}

impl<A: Arithmetic> Arithmetic for SeriesArithmetic<'_, A> {
    type Number = A::Number;

    fn literal(&self, number: f64) -> A::Number {
        self.inner.literal(number)
    }
    fn neg(&self, a: A::Number) -> A::Number {
        self.inner.neg(a)
    }
    fn add(&self, a: A::Number, b: A::Number) -> A::Number {
        self.inner.add(a, b)
    }
    fn sub(&self, a: A::Number, b: A::Number) -> A::Number {
        self.inner.sub(a, b)
    }
    fn mul(&self, a: A::Number, b: A::Number) -> A::Number {
        self.inner.mul(a, b)
    }
    fn div(&self, a: A::Number, b: A::Number) -> A::Number {
        self.inner.div(a, b)
    }
    fn sin(&self, a: A::Number) -> A::Number {
        let square = self.inner.mul(a, a);
        self.inner.mul(a, self.series(square, 2))
    }
    fn cos(&self, a: A::Number) -> A::Number {
        self.series(self.inner.mul(a, a), 1)
    }
    fn sqrt(&self, a: A::Number) -> A::Number {
        self.inner.sqrt(a)
    }
    fn fma(&self, a: A::Number, b: A::Number, c: A::Number) -> A::Number {
        self.inner.fma(a, b, c)
    }
}

struct WithSeries<'a> {
    evaluation: Evaluation<'a>,
    order: u32,
}

impl Work for WithSeries<'_> {
    type Result = Vec<Double>;

    fn run<A: Arithmetic<Number: Wide>>(self, inner: &A) -> Vec<Double> {
        let order = self.order;
        self.evaluation.run(&SeriesArithmetic { inner, order })
    }
}

/// Operations of a true sine or cosine: range reduction and a polynomial.
const TRUE_FUNCTION: OperationWork = OperationWork::new(12.0, 12.0);

/// Operations of a sine and a cosine by series of an order.
fn operations(order: Option<u32>) -> OperationWork {
    match order {
        None => TRUE_FUNCTION * 2.0,
        // Two products and a sum for each further term, the square, and the
        // product with x.
        Some(order) => {
            let terms = f64::from(order - 1);
            let ends = if order > 1 { 2.0 } else { 0.0 };
            OperationWork::new(2.0 * terms + ends, terms)
        }
    }
}

/// A model with angles in a range.
pub(super) struct AnglesSubject {
    dynamics: DynamicsSubject,
}

impl AnglesSubject {
    pub(super) fn new(model: Model, states: Vec<MotionState>) -> AnglesSubject {
        AnglesSubject {
            dynamics: DynamicsSubject::new(model, states, Metric::Forces),
        }
    }
}

struct AnglesBench<'a> {
    dynamics: &'a DynamicsSubject,
    program: ModelProgram,
    exact: Vec<Vec<Double>>,
}

impl StressSubject for AnglesSubject {
    fn metric(&self) -> &'static str {
        "Qq, normwise"
    }

    fn untreated(&self) -> ProgramTreatment {
        ProgramTreatment::default().with(|it| it.series = Some(1))
    }

    fn standard(&self) -> ProgramTreatment {
        ProgramTreatment::in_format(Format::BINARY64)
    }

    /// Always false: no format brings back the truncation of the series.
    fn rounds(&self) -> bool {
        false
    }

    fn candidates(&self) -> Vec<ProgramTreatment> {
        let mut list = Vec::new();
        for format in [Format::BINARY32, Format::BINARY64] {
            let plain = ProgramTreatment::in_format(format);
            let orders = [3, 5, 7, 9, 11, 13, 15, 17];
            list.extend(orders.map(|order| plain.with(|it| it.series = Some(order))));
            list.push(plain);
        }
        list
    }

    fn prepare(&self) -> Result<Box<dyn StressBench + '_>, StressError> {
        let dynamics = &self.dynamics;
        let recipe = ProgramRecipe::default();
        let program = ModelProgram::new(&dynamics.model, FunctionKind::Invdyna, recipe)?;
        let forces = |state: &MotionState| {
            let inputs = program.inputs(state);
            let flat = program.evaluate(WorkingPrecision::Reference, Units::SI, &inputs);
            program.array("Qq", &flat, dynamics.model.joints.len())
        };
        let exact = dynamics.states.iter().map(forces).collect();
        Ok(Box::new(AnglesBench {
            dynamics,
            program,
            exact,
        }))
    }
}

impl AnglesBench<'_> {
    fn forces(&self, state: &MotionState, treatment: &ProgramTreatment) -> Vec<Double> {
        let inputs = self.program.inputs(state);
        let evaluation = Evaluation {
            function: &self.program.function,
            inputs: &inputs,
        };
        let numbers = WorkingPrecision::In(treatment.format);
        let flat = match treatment.series {
            None => numbers.work(evaluation),
            Some(order) => numbers.work(WithSeries { evaluation, order }),
        };
        let joints = self.dynamics.model.joints.len();
        self.program.array("Qq", &flat, joints)
    }
}

impl StressBench for AnglesBench<'_> {
    fn floor(&self, format: Format) -> f64 {
        let plain = ProgramTreatment::in_format(format);
        let states = self.dynamics.states.iter().zip(&self.exact);
        worst(states.map(|(state, exact)| normwise(&self.forces(state, &plain), exact)))
    }

    fn measure(&self, treatment: &ProgramTreatment) -> Result<Measured, StressError> {
        let (mut norm, mut component) = (0.0, 0.0);
        for (state, exact) in self.dynamics.states.iter().zip(&self.exact) {
            let found = self.forces(state, treatment);
            norm = worst([norm, normwise(&found, exact)].into_iter());
            component = worst([component, componentwise(&found, exact)].into_iter());
        }
        let angles = self.dynamics.model.joints.len() as f64;
        let all = self.program.work + operations(treatment.series) * angles;
        Ok(Measured {
            error: norm,
            others: vec![("componentwise", component)],
            outside: 0.0,
            consistent: true,
            cost: all.cost(treatment.format),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_num::arithmetic::Binary64;

    #[test]
    fn series_are_those_of_taylor() {
        let x: f64 = 0.5;
        let with = |order| SeriesArithmetic {
            inner: &Binary64,
            order,
        };
        let close = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-15, "{found}");
        close(with(1).sin(x), x);
        close(with(1).cos(x), 1.0);
        close(with(3).sin(x), x - x.powi(3) / 6.0);
        close(with(3).cos(x), 1.0 - x * x / 2.0);
        close(with(5).sin(x), x - x.powi(3) / 6.0 + x.powi(5) / 120.0);
        close(with(5).cos(x), 1.0 - x * x / 2.0 + x.powi(4) / 24.0);
        assert!((with(17).sin(x) - x.sin()).abs() < 1e-15);
    }
}
