//! Tables of results of the thesis, as data.
//!
//! Cells that contradict the rest of their row or repeat another row are
//! marked as doubtful, with the reason, and shown as such wherever they
//! appear; they are never used as a reference.

use super::plan::Printed;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// The results the thesis prints.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Thesis {
    pub table_1_4: BTreeMap<String, PrintedPart>,
    pub table_2_2: Orders,
    /// Reasons why rows of unmodified systems differ from ours.
    pub why: BTreeMap<String, String>,
    /// Table 3.1, in its order.
    #[serde(rename = "system")]
    pub systems: Vec<PrintedSystem>,
}

/// A part of Table 1.4: look-up tables, blocks of memory and multiplier blocks of one.
#[derive(Clone, PartialEq, Default, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PrintedPart {
    pub(super) figures: [String; 3],
    #[serde(default)]
    pub(super) remark: String,
}

/// Table 2.2: cycles of the bogie.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Orders {
    pub elements: Vec<u32>,
    /// Cycles by the classical order.
    pub alap: Vec<u32>,
    /// Cycles with mobility first.
    pub mobility: Vec<u32>,
}

#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PrintedSystem {
    pub name: String,
    /// Degrees of freedom.
    pub dof: u32,
    pub topology: SystemTopology,
    /// The row of the system as Robotran wrote it.
    pub original: PrintedRow,
    /// The row "modified", if there is one.
    #[serde(default)]
    pub modified: Option<PrintedRow>,
}

robovec_num::named! {
    /// Connection of the bodies of a system.
    #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub(super) enum SystemTopology {
        Bogie = "bogie",
        /// One chain.
        Serial = "serial",
        /// Some chains.
        SemiSerial = "semi-serial",
        /// Many chains.
        Parallel = "parallel",
        /// The 70-dof system, which is none of the three.
        Mixed = "70-dof system",
    }
}

#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PrintedRow {
    pub operations: u32,
    /// The longest chain, in operations.
    pub asap: u32,
    /// The longest chain, in cycles.
    pub asap_cycle: u32,
    /// Operations per cycle of the longest chain, as printed.
    pub y: f64,
    /// Names of the cells that cannot be right.
    #[serde(default)]
    pub doubtful: Vec<String>,
    /// Reason why they cannot.
    #[serde(default)]
    pub remark: String,
}

impl PrintedRow {
    /// True when a cell is one to rely on.
    pub(super) fn is_sound(&self, cell: &str) -> bool {
        self.doubtful.iter().all(|doubtful| doubtful != cell)
    }
}

impl PrintedSystem {
    /// The row that a pipeline's result is compared with.
    pub(super) fn row(&self, printed: Printed) -> Option<&PrintedRow> {
        match printed {
            Printed::Original => Some(&self.original),
            Printed::Modified => self.modified.as_ref(),
        }
    }
}

pub(super) fn thesis() -> &'static Thesis {
    static THESIS: LazyLock<Thesis> = LazyLock::new(|| {
        // A test reads it, so it is well formed wherever the program runs.
        toml::from_str(include_str!("printed.toml")).expect("printed.toml is well formed")
    });
    &THESIS
}

pub(super) fn systems() -> impl Iterator<Item = &'static str> {
    thesis().systems.iter().map(|system| system.name.as_str())
}

pub(super) fn system(name: &str) -> Option<&'static PrintedSystem> {
    thesis().systems.iter().find(|system| system.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sound_numbers_y_follow_from_their_rows() {
        let rows = thesis().systems.iter().flat_map(|system| {
            let rows = [Some(&system.original), system.modified.as_ref()];
            rows.into_iter()
                .flatten()
                .map(move |row| (&system.name, row))
        });
        let mut count = 0;
        for (name, row) in rows {
            count += 1;
            let y = f64::from(row.operations) / f64::from(row.asap_cycle);
            let copied = !row.is_sound("asap_cycle");
            // The thesis rounds some and truncates others.
            assert_eq!(
                (y - row.y).abs() < 0.0101,
                row.is_sound("y") || copied,
                "{name}: {y}"
            );
            assert_eq!(row.remark.is_empty(), row.doubtful.is_empty(), "{name}");
        }
        assert_eq!(count, 24);
    }

    #[test]
    fn copied_cells_are_doubtful() {
        let copied = |name: &str| {
            !system(name)
                .expect("it is there")
                .original
                .is_sound("asap_cycle")
        };
        let names: Vec<&str> = systems().filter(|name| copied(name)).collect();
        assert_eq!(names, ["70-dof parallel", "100-dof serial"]);
    }
}
