//! Vectors and matrices of scalars in joint frames, and rotations between them.
//!
//! The frame of a joint and of its parent differ by one rotation about one
//! axis. With `(a, b, c)` cyclic and `a` the axis, a vector `v` of the parent's
//! frame has in the joint's frame the components `v_a`, `C v_b + S v_c` and
//! `C v_c - S v_b` (thesis, equation 2.1).

use super::algebra::{Scalar, Sum};
use super::equations::{Equations, QuantityLabel};

pub(super) type Vector = [Scalar; 3];
/// A matrix, row by row.
pub(super) type Matrix = [Vector; 3];
/// A vector that is not named yet.
pub(super) type SumVector = [Sum; 3];

pub(super) const ZERO: Vector = [Scalar::ZERO; 3];

/// The inertia of a set of bodies about the origin of a frame and in its axes.
#[derive(Clone, Copy)]
pub(super) struct Inertia {
    pub(super) mass: Scalar,
    /// First moment: mass times centre of mass.
    pub(super) first: Vector,
    /// Moments of inertia, a symmetric matrix.
    pub(super) moments: Matrix,
}

/// The axes after an axis, in cyclic order.
pub(super) fn cyclic(axis: usize) -> (usize, usize) {
    ((axis + 1) % 3, (axis + 2) % 3)
}

pub(super) fn unit(axis: usize) -> Vector {
    let mut vector = ZERO;
    vector[axis] = Scalar::ONE;
    vector
}

/// A rotation about one axis; without a rotation, cosine one and sine zero.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct AxisRotation {
    pub(super) axis: usize,
    pub(super) cos: Scalar,
    pub(super) sin: Scalar,
}

impl AxisRotation {
    pub(super) const NONE: AxisRotation = AxisRotation {
        axis: 0,
        cos: Scalar::ONE,
        sin: Scalar::ZERO,
    };

    /// A vector of the parent's frame in the joint's frame.
    pub(super) fn down(&self, vector: &Vector) -> SumVector {
        self.turn(vector, self.sin)
    }

    /// A vector of the joint's frame in the parent's frame.
    pub(super) fn up(&self, vector: &Vector) -> SumVector {
        self.turn(vector, -self.sin)
    }

    fn turn(&self, vector: &Vector, sin: Scalar) -> SumVector {
        let (b, c) = cyclic(self.axis);
        let mut turned = [Sum::new(), Sum::new(), Sum::new()];
        turned[self.axis].add(&[vector[self.axis]]);
        turned[b].add(&[vector[b], self.cos]).add(&[vector[c], sin]);
        turned[c]
            .subtract(&[vector[b], sin])
            .add(&[vector[c], self.cos]);
        turned
    }
}

pub(super) fn define(
    equations: &mut Equations,
    prefix: &'static str,
    joint: usize,
    column: usize,
    vector: SumVector,
) -> Vector {
    let label = |component| QuantityLabel::new(prefix, component, joint + 1).column(column);
    define_as(equations, label, vector)
}

/// Names the components of a vector, which count from 1.
pub(super) fn define_as(
    equations: &mut Equations,
    label: impl Fn(usize) -> QuantityLabel,
    vector: SumVector,
) -> Vector {
    let mut component = 0;
    vector.map(|sum| {
        component += 1;
        equations.define(label(component), sum)
    })
}

/// `a x b`, each product added to a component, multiplied by a sign.
pub(super) fn add_cross(sum: &mut SumVector, a: &Vector, b: &Vector, negative: bool) {
    for axis in 0..3 {
        let (next, last) = cyclic(axis);
        let one = a[next].negated_if(negative);
        let other = a[last].negated_if(negative);
        sum[axis].add(&[one, b[last]]).subtract(&[other, b[next]]);
    }
}

/// `a x b`, where `b` is not named: its terms are multiplied out.
pub(super) fn add_cross_of_sums(sum: &mut SumVector, a: &Vector, b: &SumVector) {
    for axis in 0..3 {
        let (next, last) = cyclic(axis);
        sum[axis]
            .add_scaled(&[a[next]], &b[last])
            .add_scaled(&[-a[last]], &b[next]);
    }
}

/// `matrix * vector`, each product added to a component.
pub(super) fn add_matrix_product(sum: &mut SumVector, matrix: &Matrix, vector: &Vector) {
    for (component, row) in sum.iter_mut().zip(matrix) {
        for (entry, element) in row.iter().zip(vector) {
            component.add(&[*entry, *element]);
        }
    }
}

pub(super) fn add_vector(sum: &mut SumVector, vector: &Vector) {
    for (component, &value) in sum.iter_mut().zip(vector) {
        component.add(&[value]);
    }
}

pub(super) fn add_sums(sum: &mut SumVector, other: &SumVector) {
    for (component, more) in sum.iter_mut().zip(other) {
        component.add_sum(more);
    }
}

/// The difference of two vectors that are not named yet.
pub(super) fn subtracted(mut one: SumVector, other: &SumVector) -> SumVector {
    for (component, terms) in one.iter_mut().zip(other) {
        component.add_scaled(&[-Scalar::ONE], terms);
    }
    one
}

pub(super) fn sums() -> SumVector {
    [Sum::new(), Sum::new(), Sum::new()]
}

pub(super) fn sums_of(vector: &Vector) -> SumVector {
    vector.map(Sum::of)
}
