//! The tables of a study, each named by its number in the thesis, if any.

mod placements;
pub(super) mod processors;
mod programs;
mod reasons;
mod resources;

use super::results::Results;
use robovec_present::DataTable;

/// All tables for which the study has points.
pub(super) fn all(results: &Results) -> Vec<DataTable> {
    let mut tables = resources::tables();
    let more = [
        resources::table(results),
        placements::ranks(results),
        placements::orders(results),
        programs::cases(results),
        programs::knees(results),
        programs::formulations(results),
        placements::whole_step(results),
        programs::errors(results),
        placements::splits(results),
        placements::couples(results),
    ];
    tables.extend(more.into_iter().flatten());
    tables.push(programs::programs(results));
    tables.push(placements::points(results));
    tables
}
