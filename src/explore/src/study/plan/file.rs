//! A plan as it is written: TOML with places for messages.

use robovec_schedule::{ElementChoice, Priority};
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct PlanFile {
    pub(super) name: String,
    /// One line for users.
    #[serde(default)]
    pub(super) description: String,
    /// The model that the verdict at the top of the report is about.
    pub(super) headline: Option<Spanned<String>>,
    #[serde(default, rename = "exact-knees")]
    pub(super) exact_knees: bool,
    #[serde(default)]
    pub(super) generate: StyleEntry,
    #[serde(rename = "model")]
    pub(super) models: Vec<ModelEntry>,
    #[serde(rename = "pipeline")]
    pub(super) pipelines: Vec<PipelineEntry>,
    /// Sweeps: programs and their machines.
    #[serde(rename = "sweep")]
    pub(super) sweeps: Vec<SweepEntry>,
}

#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct ModelEntry {
    pub(super) name: Spanned<String>,
    /// A file of equations or of a model, or a built-in model; else the name.
    pub(super) source: Option<Spanned<String>>,
    /// The function studied, where there are several.
    pub(super) function: Option<String>,
    /// The system of the thesis that it represents.
    pub(super) printed: Option<Spanned<String>>,
    /// True if only sweeps that name the model include it.
    #[serde(default, rename = "by-name")]
    pub(super) by_name: bool,
    /// Style of this model's equations.
    #[serde(default)]
    pub(super) generate: StyleEntry,
}

/// Style of generated equations; an absent key is as usual.
#[derive(Deserialize, Clone, Default, Debug)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct StyleEntry {
    pub(super) formulation: Option<Spanned<String>>,
    pub(super) child_first: Option<bool>,
    pub(super) expanded: Option<bool>,
    pub(super) leading_signs: Option<bool>,
    pub(super) forces: Option<bool>,
    pub(super) any_angles: Option<bool>,
    pub(super) all_parameters: Option<bool>,
}

#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct PipelineEntry {
    pub(super) name: Spanned<String>,
    /// Its passes, without placement.
    pub(super) passes: Spanned<String>,
    /// Rows of the thesis for comparison.
    pub(super) printed: Option<super::Printed>,
}

/// Placements: every model through every pipeline on every machine with every
/// number of elements, in every order and with every choice.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct SweepEntry {
    /// Names of models; all by default.
    pub(super) models: Option<Vec<Spanned<String>>>,
    /// Names of pipelines; all by default.
    pub(super) pipelines: Option<Vec<Spanned<String>>>,
    /// Machines: names, files, `couples`.
    pub(super) machines: Option<Vec<Spanned<String>>>,
    /// Adders and multipliers: `n` for n of each, or `[a, m]`.
    #[serde(default)]
    pub(super) elements: Vec<Spanned<ElementsEntry>>,
    /// Every number of adders with every number of multipliers.
    pub(super) grid: Option<Spanned<Vec<u32>>>,
    /// Orders of placement.
    pub(super) priority: Option<Vec<Priority>>,
    /// Choices among free elements.
    pub(super) choice: Option<Vec<ElementChoice>>,
}

/// Adders and multipliers.
#[derive(Deserialize, Clone, Copy, Debug)]
#[serde(
    untagged,
    expecting = "expected a number of adders and as many multipliers, or [adders, multipliers]"
)]
pub(super) enum ElementsEntry {
    /// As many of each.
    Equal(u32),
    /// Adders, multipliers.
    Pair([u32; 2]),
}
