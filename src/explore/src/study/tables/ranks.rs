//! Table 2.1: the preference of placement, and how often each rank occurs.

use super::super::captions;
use super::super::figures::ladder;
use super::super::results::Results;
use robovec_present::{DataCell, DataTable};

/// Status of the left and of the right operand, by rank (thesis, Table 2.1).
const RANKS: [[&str; 2]; 9] = [
    ["memory", "memory"],
    ["memory", "direct"],
    ["direct", "memory"],
    ["direct", "direct"],
    ["memory", "indirect"],
    ["indirect", "memory"],
    ["direct", "indirect"],
    ["indirect", "direct"],
    ["indirect", "indirect"],
];

pub(super) fn table(results: &Results) -> Option<DataTable> {
    let machine = results.main_machine()?;
    let pipeline = results.original();
    let placed = ladder(results, results.plan.headline, pipeline, machine);
    let mut counts = String::new();
    for placed in &placed {
        let (add, multi) = (placed.request.n_add, placed.request.n_multi);
        counts += &format!(" | {add}+{multi} (% of operations)");
    }
    let share = |counts: &[u32; 9], rank: usize| {
        let total: u32 = counts.iter().sum();
        DataCell::number(100.0 * f64::from(counts[rank]) / f64::from(total.max(1)), 1)
    };
    let rows = RANKS.iter().enumerate().map(|(rank, [left, right])| {
        let mut cells = vec![
            DataCell::count(rank + 1),
            DataCell::text(*left),
            DataCell::text(*right),
        ];
        cells.extend(placed.iter().map(|placed| share(&placed.point.ranks, rank)));
        cells
    });
    let words = [
        ("headline", captions::headline(results)),
        ("counts", &counts),
    ];
    (!placed.is_empty()).then(|| captions::table("table-2.1", &words, rows))
}
