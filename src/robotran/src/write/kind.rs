//! The files Robotran writes, in all its languages.
//!
//! The C ones are [`robovec_cgen::kind`]'s; the Matlab ones are
//! those of generator 6.6, the only one that writes Matlab. Where Robotran has
//! no such file in a language (`accelred` in Matlab and Python) the signature
//! is the natural counterpart.

use crate::Language;
pub(super) use robovec_cgen::kind::EquationKind;

/// Name of the function of a kind in Matlab or Python; in C the names of a
/// project have a prefix.
pub(super) fn function_name(kind: EquationKind, language: Language) -> String {
    match (language, kind.name) {
        // MBsysPy finds a `sensor` in both modules.
        (Language::Python, "gensensor") => "sensor".to_owned(),
        (_, name) => name.to_owned(),
    }
}
