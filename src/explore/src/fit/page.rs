//! A search as a page.

use super::answer;
use super::confirm::Confirmation;
use super::text::{candidates_table, details, figure};
use super::{FitOutcome, FitTask};
use crate::exploration::scene_subtitle;
use robovec_present::json::json_script;
use robovec_present::page::{self, PointsPage};

/// The page of a search.
pub fn page(
    task: &FitTask<'_>,
    outcome: &FitOutcome,
    confirmation: Option<&Confirmation>,
) -> String {
    let lines = answer::lines(task, outcome, confirmation);
    let page = PointsPage {
        title: format!("Scene {}", task.scene.name),
        subtitle: scene_subtitle(task.scene, task.machine),
        figures: page::card(&answer::headline(task, outcome), &lines)
            + &page::figure(&figure(task, outcome)),
        points: "All candidates",
        tables: page::table(&candidates_table(outcome), "fit.csv")
            + &page::lines("Excluded, and the front", &details(outcome)),
        method: &page::fill(
            include_str!("method.html"),
            &[("device", &task.machine.device.device().name)],
        ),
        data: json_script(&outcome.candidates),
    };
    page.to_html()
}
