//! Hardware: memory images, Verilog and Quartus projects, and their costs.
//!
//! [`images`] turns a placed function into the memory images of
//! the machine: one instruction word per element and cycle, one data image
//! per memory, and a manifest that shows where every input goes and every
//! output is found (`docs/images.md` is the contract with simulator and
//! hardware), [`rtl`] the machine itself, [`quartus`] a project for a board;
//! [`hardware`] holds the formulas of resources and clock.
//!
//! Image generation makes no choices: it transcribes the placement, and refuses
//! only what the words cannot express (more writes than ports, two buffer words
//! through one read port, an event after the end). The simulator, which reads
//! the images alone, tests whether the program is *right*.

/// Files of a folder of `hdl/`: name and text of each.
macro_rules! hdl {
    ($folder:literal, $($name:literal),* $(,)?) => {
        [$((
            $name,
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/hdl/", $folder, "/", $name)),
        )),*]
    };
}

mod binding;
mod error;
pub mod hardware;
mod hex;
mod images;
mod layout;
pub mod manifest;
mod mif;
mod ports;
pub mod quartus;
pub mod rtl;
mod shape;
mod traffic;
mod words;

pub use error::ImageError;
pub use images::{Artifacts, FileContent, foreign_format, images, write_images};
