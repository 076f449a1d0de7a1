//! An independent account of multibody dynamics, for tests only.
//!
//! It follows the six-dimensional (spatial) vectors of rigid-body mechanics:
//! velocities and forces as Plücker coordinates, transforms and inertias as 6 x
//! 6 matrices, the mass matrix as the sum of `Jᵀ I J` over the bodies. It
//! shares no formula with the recursions of generated equations, and is generic
//! over the number, so that in double-double its own rounding does not limit a
//! comparison. `self_tests.rs` shows it right from first principles: velocities
//! are derivatives of positions, and the equations of motion are Lagrange's, by
//! differences of energies.
//!
//! Angular parts come before linear ones. Frames, points and signs follow
//! [`robovec::model`]; indices count from 0.

pub(crate) mod dynamics;
pub(crate) mod forces;
pub(crate) mod kinematics;
pub(crate) mod loops;
pub(crate) mod number;
pub(crate) mod random;
#[cfg(test)]
mod self_tests;
pub(crate) mod spatial;
pub(crate) mod tree;

pub(crate) use number::Real;
pub(crate) use tree::{State, Tree};
