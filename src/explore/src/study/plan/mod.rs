//! Subjects of a study: models, pipelines, machines, numbers of elements.
//!
//! A plan is read from TOML and resolved here once and for all: afterwards
//! every name is an index, every pipeline is parsed, every machine is read, and
//! placements are a sorted list without repetitions. All is checked first.

mod file;
mod resolve;
mod sweeps;

use robovec_fpga::hardware::{self, MachineClock};
use robovec_framework::pipeline::Pipeline;
use robovec_ir::Machine;
use robovec_num::limits::NumberLimit;
use robovec_schedule::PlaceOptions;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

pub use resolve::resolve;

/// The plan that redoes the thesis.
pub const THESIS: &str = include_str!("thesis.toml");

/// The machine of sweeps that name none.
pub const DEFAULT_MACHINE: &str = "thesis";

/// The maximum number of adders or multipliers of a placement.
pub const MAX_ELEMENTS: u32 = 1024;

/// Adders or multipliers of a placement.
pub const ELEMENTS: NumberLimit = NumberLimit::whole(
    1,
    MAX_ELEMENTS as u64,
    "a program is placed for every number of elements",
);

/// The limits of the numbers of a plan: name, limit, and default.
pub const FIELDS: &[(&str, NumberLimit, &str)] = &[
    ("sweep.elements", ELEMENTS, ""),
    ("sweep.grid", ELEMENTS, ""),
];

/// A resolved plan. Indices point into its lists.
#[derive(Clone, Debug)]
pub struct StudyPlan {
    /// Its name.
    pub name: String,
    /// One line for users.
    pub description: String,
    /// The model the verdict is about.
    pub headline: usize,
    /// The models.
    pub models: Vec<StudySubject>,
    /// The pipelines.
    pub pipelines: Vec<NamedPipeline>,
    /// The machines.
    pub machines: Vec<NamedMachine>,
    /// True for a search of the smallest equal numbers at the longest chain.
    pub exact_knees: bool,
    /// The placements, sorted, each once.
    pub requests: Vec<PlacementRequest>,
}

/// A model of a study: the source of its program.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct StudySubject {
    /// Its name in results.
    pub name: String,
    /// A file of equations, a model file, or the name of a built-in model.
    pub source: String,
    /// Folder of the plan, where files are looked for first, if there is one.
    #[serde(skip)]
    pub folder: Option<PathBuf>,
    /// The function studied; by default the only one, or `dirdyna`.
    pub function: Option<String>,
    /// The system of the thesis' Table 3.1 that it represents.
    pub printed: Option<String>,
    /// True if only sweeps that name it include it.
    #[serde(skip)]
    pub by_name: bool,
    /// Style of equations generated from a model.
    pub style: GenerationStyle,
}

/// Style of equations generated from a model; see
/// [`robovec_dynamics::generate::Options`].
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct GenerationStyle {
    /// The recursion.
    pub formulation: String,
    /// True if the loads of children come before a body's own terms.
    pub child_first: bool,
    /// Products are multiplied out as Robotran prints them.
    pub expanded: bool,
    /// Sums keep a leading minus.
    pub leading_signs: bool,
    /// External forces and torques are included.
    pub forces: bool,
    /// No identity of sines and cosines is assumed.
    pub any_angles: bool,
    /// Parameters that are zero in the model are kept.
    pub all_parameters: bool,
}

/// Rows of Table 3.1 a pipeline is compared with.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Printed {
    /// The systems as written by Robotran.
    Original,
    /// The "modified" systems, changed by hand.
    Modified,
}

/// A pipeline of a study.
#[derive(Clone, Debug)]
pub struct NamedPipeline {
    /// Its name in results.
    pub name: String,
    /// The pipeline.
    pub pipeline: Pipeline,
    /// The rows of the thesis for comparison.
    pub printed: Option<Printed>,
}

/// A machine of a study.
#[derive(Clone, PartialEq, Debug)]
pub struct NamedMachine {
    /// Its name in results.
    pub name: String,
    /// The machine.
    pub machine: Machine,
    /// Stages of adders and multipliers, for the couples of Table 1.3.
    pub couple: Option<[u32; 2]>,
}

impl NamedMachine {
    /// Clock used in the study: the machine's published one, else the estimate.
    pub fn clock(&self) -> MachineClock {
        hardware::published_clock(&self.machine)
    }
}

/// One placement.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct PlacementRequest {
    /// Index of the model.
    pub model: usize,
    /// Index of the pipeline.
    pub pipeline: usize,
    /// Index of the machine.
    pub machine: usize,
    /// Adders.
    pub n_add: u32,
    /// Multipliers.
    pub n_multi: u32,
    /// Order of placement, and choice among free elements.
    pub options: PlaceOptions,
}

impl PlacementRequest {
    /// True for the order and the choice of ordinary figures.
    pub fn is_usual(&self) -> bool {
        self.options == PlaceOptions::default()
    }
}

/// Choices of the command line instead of the plan's own.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Selection<'a> {
    /// The folder of the plan's file, `None` for a built-in plan.
    pub folder: Option<&'a Path>,
    /// Models of the plan or sources; none for the plan's, here and below.
    pub models: &'a [String],
    /// Pipelines of the plan, or pipelines as text.
    pub pipelines: &'a [String],
    /// Machines.
    pub machines: &'a [String],
    /// Elements of each kind.
    pub elements: &'a [u32],
}
