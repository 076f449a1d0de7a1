//! The tables of a study, each named by its number in the thesis.

mod operators;
mod orders;
mod points;

use super::results::Results;
use super::table::Table;

/// All tables for which the study has points.
pub fn all(results: &Results) -> Vec<Table> {
    let mut tables = operators::tables();
    tables.extend(orders::table(results));
    tables.push(points::programs(results));
    tables.push(points::points(results));
    tables
}
