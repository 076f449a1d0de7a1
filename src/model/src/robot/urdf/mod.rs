//! The reader of URDF: elements of links and joints, rotors of transmissions.

mod elements;
mod inertial;
mod rotors;

pub(super) use elements::read;
