//! Against other implementations: floats against `rustc_apfloat`, roots
//! against squares in binary128, fixed point against integers.

mod fixed;
mod floats;
mod lanes;
mod mixed;
mod operands;
mod reference;
