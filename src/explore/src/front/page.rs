//! Fronts as a page.

use super::Front;
use super::text::{figure, points_table, verdicts_table};
use robovec_fpga::hardware;
use robovec_ir::Machine;
use robovec_present::json::json_script;
use robovec_present::page::{self, PointsPage};
use robovec_present::text::distinct;

/// The page of some fronts.
pub fn page(fronts: &[Front]) -> String {
    let mut machines: Vec<&Machine> = Vec::new();
    for front in fronts {
        if !machines.contains(&&front.machine) {
            machines.push(&front.machine);
        }
    }
    let devices = distinct(
        machines
            .iter()
            .map(|machine| machine.device.device().name.as_str()),
    );
    let machines = machines.iter().map(|machine| {
        let clock = hardware::clock(machine).text();
        format!(
            "Machine {}: {}, {clock}.",
            machine.name, machine.description
        )
    });
    let machines: Vec<String> = machines.collect();
    let names: Vec<&str> = fronts.iter().map(|front| front.name.as_str()).collect();
    let verdicts = page::folding_table(&verdicts_table(fronts), "", true);
    let page = PointsPage {
        title: "Speed against error".to_owned(),
        subtitle: format!(
            "{}. {} Computed by robovec {}.",
            names.join(", "),
            machines.join(" "),
            env!("CARGO_PKG_VERSION")
        ),
        figures: verdicts + &page::figure(&figure(fronts)),
        points: "All points",
        tables: page::table(&points_table(fronts), "explore.csv"),
        method: &page::fill(METHOD, &[("devices", &devices)]),
        data: json_script(fronts),
    };
    page.to_html()
}

/// Explanation of the numbers.
const METHOD: &str = "<p>Every point is a program: a way to write the equations, a pipeline of \
passes, a treatment of sines and cosines, a number format. It is placed on the machine; the \
schedule's length is its time. It is then run at random states, and its results are compared with \
those of the equations as they came, in double-double arithmetic with true sines and cosines. The \
error is therefore that of everything together.</p>\
<p><b>Relative</b>: over the element itself; elements that vanish are left out. <b>Normwise</b>: \
the largest error of an array over its largest element. <b>Front</b>: no other point is nowhere \
worse and somewhere better in cycles, in the median of the relative errors, in the worst \
normwise error and in the <b>share of the device</b>: the largest of the shares of look-up tables, \
memory blocks and multiplier blocks of the device ({{devices}}), estimated by formulas.</p>\
<p>Inputs are numbers of binary32, so that formats of at least its width start from the same \
state. Sines and cosines that are not written as series are prepared before the run, as in the \
thesis, and cost no cycles.</p>";
