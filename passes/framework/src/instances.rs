//! The convention of programs that hold several instances of a function:
//! which of their arrays belongs to which instance.
//!
//! The pass that makes such programs follows it, and so, on its own, does the
//! check: array `A` of the original is `A_1` of the first instance, `A_2` of
//! the second, and `A` itself where it is shared by all.

use crate::options::{OptionValue, joined_names};

/// The maximum number of instances in one program.
pub const MAX_INSTANCES: u32 = 64;

/// The key of the metadata with the number of instances in a function.
pub const KEY: &str = "instances";

/// The number of instances a program holds, and the inputs they share.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Instances {
    /// Number of instances.
    pub count: u32,
    /// Names of the input arrays that all instances share.
    pub shared: InstanceNames,
}

impl Instances {
    /// The name of an array in an instance, counted from 1.
    pub fn array(&self, name: &str, instance: u32, is_input: bool) -> String {
        if is_input && self.shared.contains(name) {
            name.to_owned()
        } else {
            numbered(name, instance)
        }
    }
}

/// The number of instances a function holds, by its metadata; 1 when it does
/// not state.
pub fn count(function: &robovec_ir::Function) -> u32 {
    let text = function.metadata(KEY);
    text.and_then(|text| text.parse().ok()).unwrap_or(1)
}

/// A name with the number of an instance, counted from 1.
pub fn numbered(name: &str, instance: u32) -> String {
    assert!(instance > 0, "instances are counted from 1");
    format!("{name}_{instance}")
}

/// Names as an option: joined by `+`, or `none`.
#[derive(Clone, PartialEq, Eq, Default, Debug)]
pub struct InstanceNames(pub Vec<String>);

impl InstanceNames {
    /// True when it contains the name.
    pub fn contains(&self, name: &str) -> bool {
        self.0.iter().any(|known| known == name)
    }
}

impl OptionValue for InstanceNames {
    fn type_name() -> String {
        "none | NAME+NAME+...".to_owned()
    }
    fn parse(text: &str) -> Result<InstanceNames, String> {
        if text == "none" {
            return Ok(InstanceNames::default());
        }
        joined_names(text).map(InstanceNames)
    }
    fn print(&self) -> String {
        if self.0.is_empty() {
            "none".to_owned()
        } else {
            self.0.join("+")
        }
    }
}
