//! Earliest and latest times (thesis 2.2).

use robovec_analysis::critical_path::{Weights, arrivals, longest, tails};
use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_ir::{Function, Timing};

declare_pass! {
    /// Attributes to every operation its ASAP and ALAP times and its mobility.
    ///
    /// `asap` and `alap` count operations (thesis 2.2.1), `asap_cycle` and
    /// `alap_cycle` cycles of the machine (2.2.2); all four are the times when the
    /// result is available, inputs being available at 0. An operation without
    /// users has the length of the longest path as its latest time. The
    /// `mobility` is `alap_cycle - asap_cycle` (2.3.1): the operations of
    /// mobility 0 are the critical path.
    pub struct AsapAlap("asap-alap") {}
    takes: [Atomic, Scheduled, Placed],
    gives: Gives::Same,
    class: Exact,
    sets: [Timed],
}

impl Pass for AsapAlap {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let unit = Weights::operations();
        let cycles = Weights::cycles(context.machine);
        let (asap, tail) = (arrivals(function, &unit), tails(function, &unit));
        let (asap_cycle, tail_cycle) = (arrivals(function, &cycles), tails(function, &cycles));
        let longest_path = longest(&asap);
        let longest_cycle = longest(&asap_cycle);
        let timing: Vec<Timing> = (0..function.nodes().len())
            .map(|index| Timing {
                asap: asap[index],
                alap: longest_path - tail[index],
                asap_cycle: asap_cycle[index],
                alap_cycle: longest_cycle - tail_cycle[index],
            })
            .collect();
        assert!(
            timing
                .iter()
                .all(|times| { times.asap <= times.alap && times.asap_cycle <= times.alap_cycle }),
            "the latest time is never before the earliest"
        );
        let critical = timing
            .iter()
            .filter(|timing| timing.mobility() == 0)
            .count();
        context.count("operations without mobility", critical as u64);
        function.timing = Some(timing);
        Ok(())
    }
}
