//! Code generation: what leaves the compiler.
//!
//! [`images`] turns a placed function into the memory images of
//! the machine: one instruction word per element and cycle, one data image
//! per memory, and a manifest that says where every input goes and every
//! output is found (`docs/images.md` is the contract with simulator and
//! hardware). [`c`] writes a C99 function for a processor, [`batch`] one that
//! evaluates many states at once, [`rolled`] one with loops; [`emit`] and
//! [`sincos`] serve all of them.
//!
//! Image generation decides nothing: it transcribes the placement, and
//! refuses only what the words cannot express (more writes than ports, two
//! buffer words through one read port, an event after the end). Whether the
//! program is *right* is for the simulator to find out, which sees the images
//! alone.

pub mod batch;
mod binding;
pub mod c;
pub mod emit;
mod error;
pub mod fpcore;
pub mod hardware;
mod hex;
mod images;
pub mod kind;
mod layout;
pub mod manifest;
mod mif;
mod pass;
mod ports;
pub mod quartus;
pub mod rolled;
pub mod rtl;
mod shape;
pub mod sincos;
#[cfg(test)]
mod testing;
mod traffic;
mod words;

pub use error::ImageError;
pub use images::{Artifacts, images, write_images};
pub use pass::{Codegen, CodegenTarget};
