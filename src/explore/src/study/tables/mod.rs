//! The tables of a study, each named by its number in the thesis.

mod cases;
mod errors;
mod formulations;
mod knees;
mod operators;
mod orders;
mod points;
mod ranks;
mod reasons;
pub(crate) mod resources;
pub(in crate::study) mod whole_step;

use super::results::Results;
use robovec_present::DataTable;

/// All tables for which the study has points.
pub fn all(results: &Results) -> Vec<DataTable> {
    let mut tables = operators::tables();
    tables.extend(resources::table(results));
    tables.extend(ranks::table(results));
    tables.extend(orders::table(results));
    tables.extend(cases::table(results));
    tables.extend(knees::table(results));
    tables.extend(formulations::table(results));
    tables.extend(whole_step::table(results));
    tables.extend(errors::table(results));
    tables.extend(knees::splits(results));
    tables.extend(knees::couples_table(results));
    tables.push(points::programs(results));
    tables.push(points::points(results));
    tables
}
