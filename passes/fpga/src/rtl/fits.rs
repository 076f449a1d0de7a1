//! Check that a program fits existing hardware.

use super::error::RtlError;
use super::hardware::{Crossbar, Hardware};
use super::legs;
use crate::traffic::Traffic;
use robovec_ir::View;
use robovec_ir::placement::{Bank, Element};
use std::fmt;

/// The demand of a program on one part of the hardware.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct HardwareDemand {
    /// The part.
    pub part: &'static str,
    /// The amount that the program uses.
    pub used: u64,
    /// The available amount.
    pub available: u64,
}

impl fmt::Display for HardwareDemand {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let HardwareDemand {
            part,
            used,
            available,
        } = self;
        write!(formatter, "{part}: {used} of {available}")
    }
}

/// The demands of a program on hardware, and why it does not fit.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct HardwareFit {
    /// Part by part.
    pub demands: Vec<HardwareDemand>,
    /// The reasons why the program does not fit, one sentence each; empty when
    /// it fits.
    pub reasons: Vec<String>,
}

/// Compares a placed function with hardware.
///
/// # Errors
///
/// Fails when the function has no images at all on the hardware's machine. A
/// program that has images but does not fit is no error: see
/// [`HardwareFit::reasons`].
pub fn fits(view: View<'_>, hardware: &Hardware) -> Result<HardwareFit, RtlError> {
    let traffic = Traffic::new(view, &hardware.machine)?;
    Ok(of_traffic(&traffic, hardware))
}

pub(super) fn of_traffic(traffic: &Traffic<'_>, hardware: &Hardware) -> HardwareFit {
    let mut fit = HardwareFit::default();
    let kinds = (traffic.schedule.kinds.iter()).filter(|kind| kind.count > 0);
    let used: Vec<(&str, u32)> = kinds.map(|kind| (kind.name.as_str(), kind.count)).collect();
    let built: Vec<(&str, u32)> = (hardware.elements.iter())
        .map(|group| (group.kind.as_str(), group.count))
        .collect();
    if used != built {
        fit.reasons.push(format!(
            "it is placed on {}, and the hardware has {}",
            elements(&used),
            elements(&built)
        ));
        return fit;
    }
    let usage = &traffic.usage;
    let (buffer_words, buffer_reads) = match &hardware.buffer {
        Some(buffer) => (buffer.words, buffer.read_ports),
        None => (0, 0),
    };
    for (part, used, available) in [
        (
            "cycles",
            traffic.schedule.cycles,
            hardware.instruction_words,
        ),
        ("words of an operand memory", usage.words, hardware.words),
        (
            "write ports of an operand memory",
            usage.write_ports,
            hardware.write_ports,
        ),
        ("words of a buffer", usage.buffer_words, buffer_words),
        ("read ports of a buffer", usage.buffer_reads, buffer_reads),
    ] {
        fit.demand(part, u64::from(used), u64::from(available));
    }
    // The codes of the crossbar's sources mean what they mean on the
    // hardware only when the buffers have no more ports than that.
    if let Crossbar::Pruned(legs) = &hardware.crossbar
        && fit.reasons.is_empty()
    {
        fit.crossbar(traffic, hardware, legs);
    }
    fit
}

/// Missing pairs that are named; of the others the number is reported.
const MAX_NAMED: usize = 5;

impl HardwareFit {
    fn demand(&mut self, part: &'static str, used: u64, available: u64) {
        if used > available {
            self.reasons.push(format!(
                "it needs {used} {part}, and the hardware has {available}"
            ));
        }
        self.demands.push(HardwareDemand {
            part,
            used,
            available,
        });
    }

    /// Every source must reach every port at which it is selected.
    fn crossbar(&mut self, traffic: &Traffic<'_>, hardware: &Hardware, legs: &[Vec<u32>]) {
        let sizes = hardware.sizes();
        let used = legs::used(traffic, &sizes);
        let mut missing = Vec::new();
        let mut pairs = 0;
        for (port, (used, built)) in (0u32..).zip(used.iter().zip(legs)) {
            pairs += used.len() as u64;
            let lacking = used
                .iter()
                .filter(|code| built.binary_search(code).is_err());
            missing.extend(lacking.map(|&code| (code, port)));
        }
        self.demands.push(HardwareDemand {
            part: "pairs of the crossbar",
            used: pairs,
            available: legs.iter().map(|codes| codes.len() as u64).sum(),
        });
        if missing.is_empty() {
            return;
        }
        let name = |&(code, port): &(u32, u32)| {
            let source = traffic.element_name(Element::new(code % sizes.elements));
            let through = if code < sizes.elements {
                ""
            } else {
                "'s buffer"
            };
            let (memory, port) = (port / sizes.write_ports, port % sizes.write_ports);
            let bank = match (sizes.memories, memory % sizes.memories) {
                (1, _) => Bank::Unified,
                (_, 0) => Bank::Left,
                (_, _) => Bank::Right,
            };
            let target = traffic.memory_name(Element::new(memory / sizes.memories), bank);
            format!("{source}{through} to port {port} of {target}")
        };
        let named: Vec<String> = missing.iter().take(MAX_NAMED).map(name).collect();
        let rest = match missing.len() - named.len() {
            0 => String::new(),
            count => format!(" and {count} more"),
        };
        self.reasons.push(format!(
            "its results travel {} ways that the pruned crossbar lacks: {}{rest}",
            missing.len(),
            named.join(", ")
        ));
    }
}

fn elements(groups: &[(&str, u32)]) -> String {
    let groups: Vec<String> = groups
        .iter()
        .map(|(kind, count)| format!("{count} {kind}"))
        .collect();
    groups.join(" + ")
}
