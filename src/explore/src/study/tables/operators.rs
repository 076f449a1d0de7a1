//! Tables 1.1 to 1.3: operators of the Cyclone V, and which share a clock.

use crate::operators::{ADDERS, MEMORY_CAP_MHZ, MULTIPLIERS, couples};
use robovec_present::{DataCell, DataTable};

pub(super) fn tables() -> Vec<DataTable> {
    let adders = DataTable::new(
        "table-1.1",
        "Table 1.1: adders and subtractors of the Cyclone V",
        "As the thesis gives them; data, not results.",
        "stages | clock (MHz) | look-up tables",
        ADDERS.iter().map(|operator| {
            [operator.stages, operator.mhz, operator.luts]
                .map(DataCell::count)
                .to_vec()
        }),
    );
    let multipliers = DataTable::new(
        "table-1.2",
        "Table 1.2: multipliers of the Cyclone V",
        "As the thesis gives them; data, not results.",
        "stages | clock (MHz) | look-up tables | multiplier blocks",
        MULTIPLIERS.iter().map(|operator| {
            let numbers = [
                operator.stages,
                operator.mhz,
                operator.luts,
                operator.multipliers,
            ];
            numbers.map(DataCell::count).to_vec()
        }),
    );
    let pairs = DataTable::new(
        "table-1.3",
        "Table 1.3: adders and multipliers on one clock",
        "Computed from Tables 1.1 and 1.2 as the slower of the two operators; all 15 \
            couples of the thesis come out as printed. The time of an operation counts two \
            cycles of transfer.",
        &format!(
            "adder stages | multiplier stages | clock (MHz) | clock under the {MEMORY_CAP_MHZ} MHz \
             cap (MHz) | addition (ns) | multiplication (ns)"
        ),
        couples().iter().map(|couple| {
            let [add, multi] = couple.stages();
            let time = |stages: u32| 1e3 * f64::from(stages + 2) / f64::from(couple.mhz());
            vec![
                DataCell::count(add),
                DataCell::count(multi),
                DataCell::count(couple.mhz()),
                DataCell::count(couple.mhz().min(MEMORY_CAP_MHZ)),
                DataCell::number(time(add), 1),
                DataCell::number(time(multi), 1),
            ]
        }),
    );
    vec![adders, multipliers, pairs]
}
