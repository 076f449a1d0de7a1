//! Registry: the passes and presets that a pipeline can name.
//!
//! The framework accesses passes by their entries only; the list of entries is
//! above all of them, in one place.

use super::PassInfo;

/// A named pipeline, written `$name` in another.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// Name, without the `$`.
    pub name: &'static str,
    /// One line for users.
    pub summary: &'static str,
    /// The pipeline it represents.
    pub pipeline: &'static str,
}

/// All passes and presets of a program.
#[derive(Debug)]
pub struct Registry {
    /// The passes, in their usual order.
    pub passes: &'static [PassInfo],
    /// The presets.
    pub presets: &'static [Preset],
}

impl Registry {
    /// The registry without passes, of the empty pipeline.
    pub const EMPTY: &'static Registry = &Registry {
        passes: &[],
        presets: &[],
    };

    /// The pass of a name.
    pub fn find(&self, name: &str) -> Option<&'static PassInfo> {
        self.passes.iter().find(|info| info.name == name)
    }

    /// The preset of a name.
    pub fn preset(&self, name: &str) -> Option<&'static Preset> {
        self.presets.iter().find(|preset| preset.name == name)
    }
}
