//! Tables 1.1 to 1.3: operators of the Cyclone V, and which share a clock.

use crate::captions;
use crate::operators::{ADDERS, Couple, MEMORY_CAP_MHZ, MULTIPLIERS, Operator, couples};
use robovec_present::{DataTable, columns};

pub(super) fn tables() -> Vec<DataTable> {
    let operators = columns! { Operator;
        "stages", [Hidden, All], |operator| operator.stages;
        "clock (MHz)", [Hidden, All], |operator| operator.mhz;
        "look-up tables", [Hidden, All], |operator| operator.luts;
    };
    let adders = captions::table("table-1.1", &[], &operators, &ADDERS);
    let blocks = columns! { Operator;
        "multiplier blocks", [Hidden, All], |operator| operator.multipliers;
    };
    let operators = operators.and(blocks);
    let multipliers = captions::table("table-1.2", &[], &operators, &MULTIPLIERS);
    let time = |couple: &Couple, kind: usize| {
        1e3 * f64::from(couple.stages()[kind] + 2) / f64::from(couple.mhz())
    };
    let capped = format!("clock under the {MEMORY_CAP_MHZ} MHz cap (MHz)");
    let pairs = columns! { Couple;
        "adder stages", [Hidden, All], |couple| couple.stages()[0];
        "multiplier stages", [Hidden, All], |couple| couple.stages()[1];
        "clock (MHz)", [Hidden, All], Couple::mhz;
        capped, [Hidden, All], |couple| couple.mhz().min(MEMORY_CAP_MHZ);
        "addition (ns)", [Hidden, Decimals(1)], move |couple| time(couple, 0);
        "multiplication (ns)", [Hidden, Decimals(1)], move |couple| time(couple, 1);
    };
    let couples = captions::table("table-1.3", &[], &pairs, &couples());
    vec![adders, multipliers, couples]
}
