//! Tables 1.1 to 1.3: operators of the Cyclone V, and which share a clock.

use super::super::captions;
use crate::operators::{ADDERS, MEMORY_CAP_MHZ, MULTIPLIERS, couples};
use robovec_present::{DataCell, DataTable};

pub(super) fn tables() -> Vec<DataTable> {
    let adders = captions::table(
        "table-1.1",
        &[],
        ADDERS.iter().map(|operator| {
            [operator.stages, operator.mhz, operator.luts]
                .map(DataCell::count)
                .to_vec()
        }),
    );
    let multipliers = captions::table(
        "table-1.2",
        &[],
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
    let pairs = captions::table(
        "table-1.3",
        &[],
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
