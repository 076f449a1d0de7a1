//! The reader of URDF: elements of links and joints, rotors of transmissions.

mod elements;

pub(super) use elements::read;
