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
use super::chain::{Chain, JacobianColumn};
use super::equations::Equations;
use super::parameters::ModelParameters;
use super::vector::{Vector, ZERO, add_cross, add_sums, add_vector, sums, sums_of};

/// Derivatives by time of the parts of a Jacobian, one of each kind for every
/// joint of a chain.
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
        }
    }

    /// The derivatives of arms from those of levers and of the last lever.
    fn sum_arms(
        &mut self,
        chain: &Chain,
        equations: &mut Equations,
        prefix: &'static str,
        end: Vector,
    ) {
        self.arms = vec![ZERO; chain.steps.len()];
        let mut arm = end;
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

    /// The second derivative of [`Chain::jacobian`] by time, for accelerations of
    /// all joints.
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

    /// Columns of the joints that move, from the derivatives of their axes and
    /// those of the linear part of revolute joints.
    fn columns(
        &self,
        parameters: &ModelParameters<'_>,
        axes: &[Vector],
        mut linear: impl FnMut(usize) -> Vector,
    ) -> Vec<JacobianColumn> {
        let places = (0..axes.len()).map(|place| (place, self.steps[place].joint));
        let moving = places.filter(|&(_, joint)| !parameters.frames.is_constant(joint));
        let column = |(place, joint)| match parameters.is_revolute(joint) {
            true => (joint, linear(place), axes[place]),
            false => (joint, axes[place], ZERO),
        };
        moving.map(column).collect()
    }

    fn rates(&self, equations: &mut Equations, parameters: &ModelParameters<'_>) -> ChainRates {
        let mut rates = ChainRates::at_rest();
        for step in &self.steps {
            let (joint, rate) = (step.joint, parameters.qd[step.joint]);
            let (mut axis, mut lever) = (sums(), sums());
            add_cross(&mut axis, &rates.last, &step.axis, false);
            add_cross(&mut lever, &rates.last, &step.lever, false);
            let moved = step.axis.map(|component| Sum::product(&[component, rate]));
            let moved = self.define(equations, "OS", joint + 1, 0, moved);
            rates.turning.push(rates.last);
            rates
                .axes
                .push(self.define(equations, "AD", joint + 1, 0, axis));
            if parameters.is_revolute(joint) {
                let mut last = sums_of(&rates.last);
                add_vector(&mut last, &moved);
                rates.last = self.define(equations, "OM", joint + 1, 0, last);
            } else {
                add_vector(&mut lever, &moved);
            }
            rates
                .levers
                .push(self.define(equations, "RD", joint + 1, 0, lever));
        }
        let mut end = sums();
        add_cross(&mut end, &rates.last, &self.end, false);
        let end = self.define(equations, "PD", 0, 0, end);
        rates.sum_arms(self, equations, "PD", end);
        rates
    }

    fn second_rates(
        &self,
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        rates: &ChainRates,
        accelerations: &[Scalar],
    ) -> ChainRates {
        let mut seconds = ChainRates::at_rest();
        for (place, step) in self.steps.iter().enumerate() {
            let joint = step.joint;
            let (before, turned) = (rates.turning[place], rates.axes[place]);
            let (mut axis, mut lever) = (sums(), sums());
            add_cross(&mut axis, &seconds.last, &step.axis, false);
            add_cross(&mut axis, &before, &turned, false);
            seconds.turning.push(seconds.last);
            seconds
                .axes
                .push(self.define(equations, "AS", joint + 1, 0, axis));
            let moved = [0, 1, 2].map(|k| {
                let mut sum = Sum::product(&[turned[k], parameters.qd[joint]]);
                sum.add(&[step.axis[k], accelerations[joint]]);
                sum
            });
            add_cross(&mut lever, &seconds.last, &step.lever, false);
            add_cross(&mut lever, &before, &rates.levers[place], false);
            if parameters.is_revolute(joint) {
                let mut last = sums_of(&seconds.last);
                add_sums(&mut last, &moved);
                seconds.last = self.define(equations, "OP", joint + 1, 0, last);
            } else {
                add_sums(&mut lever, &moved);
            }
            seconds
                .levers
                .push(self.define(equations, "RE", joint + 1, 0, lever));
        }
        let (mut rate, mut end) = (sums(), sums());
        add_cross(&mut rate, &rates.last, &self.end, false);
        let rate = self.define(equations, "PD", 0, 0, rate);
        add_cross(&mut end, &seconds.last, &self.end, false);
        add_cross(&mut end, &rates.last, &rate, false);
        let end = self.define(equations, "PE", 0, 0, end);
        seconds.sum_arms(self, equations, "PE", end);
        seconds
    }
}
