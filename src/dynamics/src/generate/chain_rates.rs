//! The first and the second derivative by time of the Jacobian of a chain.
//!
//! An axis `s` and a lever `l` turn with the frame that they are fixed to, whose
//! angular velocity is `w`, and a lever grows where its joint slides along `s`.
//! With `r` the arm from a joint to the end,
//!
//! ```text
//! s' = w x s               l' = w x l + s qd
//! s" = w' x s + w x s'      l" = w' x l + w x l' + s' qd + s qdd
//! J  = s x r    J' = s' x r + s x r'    J" = s" x r + 2 s' x r' + s x r"
//! ```

use super::algebra::{Scalar, Sum};
use super::chain::{Chain, ChainJoint, JacobianColumn};
use super::equations::Equations;
use super::parameters::ModelParameters;
use super::vector::{SumVector, Vector, ZERO, add_cross, add_sums, add_vector, sums, sums_of};

/// Derivatives by time of the parts of a Jacobian, by joint of a chain.
struct ChainRates {
    axes: Vec<Vector>,
    /// From the joint to the end.
    arms: Vec<Vector>,
    /// From the frame before to the joint.
    levers: Vec<Vector>,
    /// Angular velocities (accelerations in second derivatives) before the joint.
    turning: Vec<Vector>,
    /// That of the last frame.
    last: Vector,
    /// From the last joint to the end.
    end: Vector,
}

impl ChainRates {
    /// Those of a chain without joints on a frame at rest.
    fn at_rest() -> ChainRates {
        ChainRates {
            axes: Vec::new(),
            arms: Vec::new(),
            levers: Vec::new(),
            turning: Vec::new(),
            last: ZERO,
            end: ZERO,
        }
    }

    /// The derivatives of arms from those of levers and of the last lever.
    fn sum_arms(&mut self, chain: &Chain, equations: &mut Equations, prefix: &'static str) {
        self.arms = vec![ZERO; chain.steps.len()];
        let mut arm = self.end;
        for (place, step) in chain.steps.iter().enumerate().rev() {
            self.arms[place] = arm;
            let mut sum = sums_of(&self.levers[place]);
            add_vector(&mut sum, &arm);
            arm = chain.define(equations, prefix, step.joint + 1, 0, sum);
        }
    }
}

impl Chain {
    /// The derivative of [`Chain::jacobian`] by time.
    pub(super) fn jacobian_rate(
        &self,
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
    ) -> Vec<JacobianColumn> {
        let arms = self.arms(equations);
        let rates = self.rates(equations, parameters);
        self.columns(parameters, &rates.axes, |place| {
            let mut linear = sums();
            add_cross(&mut linear, &rates.axes[place], &arms[place], false);
            add_cross(
                &mut linear,
                &self.steps[place].axis,
                &rates.arms[place],
                false,
            );
            self.define(equations, "JD", self.steps[place].joint + 1, 0, linear)
        })
    }

    /// Second derivative of [`Chain::jacobian`] by time, for all accelerations.
    pub(super) fn jacobian_second_rate(
        &self,
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        accelerations: &[Scalar],
    ) -> Vec<JacobianColumn> {
        let arms = self.arms(equations);
        let rates = self.rates(equations, parameters);
        let seconds = self.second_rates(equations, parameters, &rates, accelerations);
        self.columns(parameters, &seconds.axes, |place| {
            let (joint, axis) = (self.steps[place].joint + 1, &self.steps[place].axis);
            let doubled = rates.axes[place].map(|value| Sum::total(&[value, value]));
            let doubled = self.define(equations, "AE", joint, 0, doubled);
            let mut linear = sums();
            add_cross(&mut linear, &seconds.axes[place], &arms[place], false);
            add_cross(&mut linear, &doubled, &rates.arms[place], false);
            add_cross(&mut linear, axis, &seconds.arms[place], false);
            self.define(equations, "JE", joint, 0, linear)
        })
    }

    /// Columns of the joints that move, from axes' and linear derivatives.
    fn columns(
        &self,
        parameters: &ModelParameters<'_>,
        axes: &[Vector],
        mut linear: impl FnMut(usize) -> Vector,
    ) -> Vec<JacobianColumn> {
        let places = (0..axes.len()).map(|place| (place, self.steps[place].joint));
        let moving = places.filter(|&(_, joint)| !parameters.frames.is_constant(joint));
        let column = |(place, joint)| {
            if parameters.is_revolute(joint) {
                (joint, linear(place), axes[place])
            } else {
                (joint, axes[place], ZERO)
            }
        };
        moving.map(column).collect()
    }

    fn rates(&self, equations: &mut Equations, parameters: &ModelParameters<'_>) -> ChainRates {
        let names = ["OM", "AD", "RD", "PD"];
        self.next_rates(equations, parameters, names, None, |equations, step| {
            let rate = parameters.qd[step.joint];
            let moved = step.axis.map(|component| Sum::product(&[component, rate]));
            sums_of(&self.define(equations, "OS", step.joint + 1, 0, moved))
        })
    }

    fn second_rates(
        &self,
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        rates: &ChainRates,
        accelerations: &[Scalar],
    ) -> ChainRates {
        let names = ["OP", "AS", "RE", "PE"];
        let mut turned = rates.axes.iter();
        self.next_rates(equations, parameters, names, Some(rates), |_, step| {
            let turned = turned.next().expect("an axis per joint");
            [0, 1, 2].map(|k| {
                let mut sum = Sum::product(&[turned[k], parameters.qd[step.joint]]);
                sum.add(&[step.axis[k], accelerations[step.joint]]);
                sum
            })
        })
    }

    /// The derivatives of axes, levers and arms of the first order, or of the
    /// second one from those of the first. `moved` gives the change of the turning
    /// or of the lever by the joint itself; names are those of turning, axes,
    /// levers and arms.
    fn next_rates(
        &self,
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        [turning, axes, levers, arms]: [&'static str; 4],
        before: Option<&ChainRates>,
        mut moved: impl FnMut(&mut Equations, &ChainJoint) -> SumVector,
    ) -> ChainRates {
        let mut rates = ChainRates::at_rest();
        for (place, step) in self.steps.iter().enumerate() {
            let joint = step.joint;
            let (mut axis, mut lever) = (sums(), sums());
            add_cross(&mut axis, &rates.last, &step.axis, false);
            add_cross(&mut lever, &rates.last, &step.lever, false);
            if let Some(before) = before {
                let turning = &before.turning[place];
                add_cross(&mut axis, turning, &before.axes[place], false);
                add_cross(&mut lever, turning, &before.levers[place], false);
            }
            let moved = moved(equations, step);
            rates.turning.push(rates.last);
            let axis = self.define(equations, axes, joint + 1, 0, axis);
            rates.axes.push(axis);
            if parameters.is_revolute(joint) {
                let mut last = sums_of(&rates.last);
                add_sums(&mut last, &moved);
                rates.last = self.define(equations, turning, joint + 1, 0, last);
            } else {
                add_sums(&mut lever, &moved);
            }
            let lever = self.define(equations, levers, joint + 1, 0, lever);
            rates.levers.push(lever);
        }
        let mut end = sums();
        add_cross(&mut end, &rates.last, &self.end, false);
        if let Some(before) = before {
            add_cross(&mut end, &before.last, &before.end, false);
        }
        rates.end = self.define(equations, arms, 0, 0, end);
        rates.sum_arms(self, equations, arms);
        rates
    }
}
