//! Tables 1.1 to 1.3: operators of the Cyclone V, and which share a clock.

use super::super::couples::{ADDERS, MEMORY_CAP_MHZ, MULTIPLIERS, couples};
use super::super::table::{Cell, Table};

pub(super) fn tables() -> Vec<Table> {
    let columns = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
    let adders = Table {
        name: "table-1.1".to_owned(),
        title: "Table 1.1: adders and subtractors of the Cyclone V".to_owned(),
        caption: "As the thesis gives them; data, not results.".to_owned(),
        columns: columns(&["stages", "clock (MHz)", "look-up tables"]),
        rows: ADDERS
            .iter()
            .map(|operator| {
                [operator.stages, operator.mhz, operator.luts]
                    .map(Cell::count)
                    .to_vec()
            })
            .collect(),
    };
    let multipliers = Table {
        name: "table-1.2".to_owned(),
        title: "Table 1.2: multipliers of the Cyclone V".to_owned(),
        caption: "As the thesis gives them; data, not results.".to_owned(),
        columns: columns(&[
            "stages",
            "clock (MHz)",
            "look-up tables",
            "multiplier blocks",
        ]),
        rows: MULTIPLIERS
            .iter()
            .map(|operator| {
                let numbers = [
                    operator.stages,
                    operator.mhz,
                    operator.luts,
                    operator.multipliers,
                ];
                numbers.map(Cell::count).to_vec()
            })
            .collect(),
    };
    let capped = format!("clock under the {MEMORY_CAP_MHZ} MHz cap (MHz)");
    let pairs = Table {
        name: "table-1.3".to_owned(),
        title: "Table 1.3: adders and multipliers on one clock".to_owned(),
        caption: "Computed from Tables 1.1 and 1.2 as the slower of the two operators; all 15 \
            couples of the thesis come out as printed. The time of an operation counts two \
            cycles of transfer."
            .to_owned(),
        columns: columns(&[
            "adder stages",
            "multiplier stages",
            "clock (MHz)",
            &capped,
            "addition (ns)",
            "multiplication (ns)",
        ]),
        rows: couples()
            .iter()
            .map(|couple| {
                let [add, multi] = couple.stages();
                let time = |stages: u32| 1e3 * f64::from(stages + 2) / f64::from(couple.mhz());
                vec![
                    Cell::count(add),
                    Cell::count(multi),
                    Cell::count(couple.mhz()),
                    Cell::count(couple.mhz().min(MEMORY_CAP_MHZ)),
                    Cell::number(time(add), 1),
                    Cell::number(time(multi), 1),
                ]
            })
            .collect(),
    };
    vec![adders, multipliers, pairs]
}
