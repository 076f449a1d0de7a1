//! Common parts of explorations of functions: the function with formulations,
//! shares of the work, and results as text, table, figure, data and page.

use crate::ExplorationProgress;
use crate::optimise::found::{FoundProgram, found};
use crate::optimise::start::starts;
use crate::program::{ExplorationError, view};
use crate::share::SharedWork;
use robovec_dynamics::generate::Formulation;
use robovec_error::yardstick::Yardstick;
use robovec_error::yardstick::account::random_states;
use robovec_fpga::hardware;
use robovec_framework::scene::Scene;
use robovec_ir::count::Counts;
use robovec_ir::states::States;
use robovec_ir::{Machine, Module};
use robovec_present::json::{json_script, json_text};
use robovec_present::page::{self, PointsPage};
use robovec_present::text::{headed, labelled};
use robovec_present::{DataTable, Figure, plot};
use serde::Serialize;

/// The scene and the machine, under the title of a page.
pub(crate) fn scene_subtitle(scene: &Scene, machine: &Machine) -> String {
    let description = match scene.description.trim_end_matches('.') {
        "" => String::new(),
        description => format!("{description}. "),
    };
    let (name, about) = (&machine.name, &machine.description);
    let clock = hardware::clock(machine).text();
    let version = env!("CARGO_PKG_VERSION");
    format!("{description}Machine {name}: {about}, {clock}. Computed by robovec {version}.")
}

/// A function to be explored.
#[derive(Clone, Debug)]
pub struct ExploredFunction {
    /// The model or file.
    pub name: String,
    /// The function as it came, alone in its module.
    pub module: Module,
    /// The same in other formulations.
    pub others: Vec<(Formulation, Module)>,
    /// Origin of the states that errors are measured at.
    pub states: States,
    /// Number of states.
    pub count: u32,
}

impl ExploredFunction {
    pub(crate) fn operations(&self) -> usize {
        Counts::of(view(&self.module).function).operations
    }

    /// The exact results at the states.
    pub(crate) fn yardstick(&self) -> Yardstick {
        Yardstick::new(view(&self.module), &self.states, self.count)
    }

    /// The states in words.
    pub(crate) fn drawn(&self) -> String {
        let has_ranges = !self.states.ranges().is_empty();
        random_states(self.count as usize, self.states.seed(), has_ranges)
    }

    /// Programs that `robovec optimise` finds for numbers of elements.
    pub(crate) fn searched(
        &self,
        machine: &Machine,
        elements: &[[u32; 2]],
        work: SharedWork<'_>,
        progress: ExplorationProgress<'_>,
    ) -> Result<Vec<FoundProgram>, ExplorationError> {
        let starts = starts(self.module.clone(), self.others.iter().cloned());
        found(&starts, machine, elements, work, progress)
    }
}

/// Results for a function.
#[derive(Clone, PartialEq, Debug)]
pub enum Explored<R> {
    /// A share of the work: its pieces, in words, and the number stored before.
    Share(String, usize),
    /// All results.
    Whole(R),
}

/// Results of an exploration of a function, with their presentation.
pub trait Exploration: Serialize + Sized {
    /// Head of the table of all points.
    const POINTS: &'static str;
    /// Explanation of the numbers, as HTML.
    const METHOD: &'static str;

    /// The model or file.
    fn name(&self) -> &str;

    /// The answer in one line.
    fn headline(&self) -> String;

    /// Lines after the headline, with their labels.
    fn lines(&self) -> Vec<(&'static str, String)>;

    /// The points that matter most, for the terminal.
    fn short_table(&self) -> String;

    /// All findings, for detailed output.
    fn details(&self) -> String;

    /// The results for the terminal: the answer, then a table.
    fn text(&self, is_verbose: bool) -> String {
        let head = headed(self.name(), &self.headline());
        let mut text = head + &labelled(&self.lines());
        text += &format!("\n{}\n", self.short_table());
        if is_verbose {
            text += &format!("\n{}", self.details());
        }
        text
    }

    /// All points of all functions.
    fn table(all: &[Self]) -> DataTable;

    /// The points as a figure.
    fn figure(all: &[Self]) -> Figure;

    /// Sentences about the machines, and the names of their devices.
    fn machines(all: &[Self]) -> [String; 2];

    /// The figure, as HTML, with the other first parts of the page.
    fn opening(all: &[Self], figure: String) -> String;
}

/// A card for every function, with its name where there are several.
fn cards<E: Exploration>(all: &[E]) -> String {
    let card = |one: &E| {
        let headline = match all {
            [_] => one.headline(),
            _ => format!("{}: {}", one.name(), one.headline()),
        };
        page::card(&headline, &one.lines())
    };
    all.iter().map(card).collect()
}

/// The files of an exploration, by name.
pub fn files<E: Exploration>(all: &[E]) -> Vec<(String, String)> {
    let (table, figure) = (E::table(all), E::figure(all));
    let names: Vec<&str> = all.iter().map(E::name).collect();
    let [machines, devices] = E::machines(all);
    let page = PointsPage {
        title: table.title.clone(),
        subtitle: format!(
            "{}. {machines} Computed by robovec {}.",
            names.join(", "),
            env!("CARGO_PKG_VERSION")
        ),
        figures: cards(all) + &E::opening(all, page::figure(&figure)),
        points: E::POINTS,
        tables: page::table(&table, "explore.csv"),
        method: &page::fill(E::METHOD, &[("devices", &devices)]),
        data: json_script(all),
    };
    let files = [
        ("explore.csv", table.to_csv()),
        ("explore.json", json_text(all)),
        ("explore.svg", plot::draw(&figure)),
        ("explore.html", page.to_html()),
    ];
    files.map(|(name, text)| (name.to_owned(), text)).to_vec()
}
