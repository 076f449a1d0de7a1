//! Programs placed on the designs of a space, a share of them at a time; the
//! result of a design is stored, so that several workers on one folder divide
//! the work, and an interrupted one loses nothing.
//!
//! **Invariant.** A kept placement is found again only by the same programs, on
//! the same machine, by the same build of robovec.

use super::design::{DesignSpace, MachineDesign};
use super::{SweptProgram, thesis};
use crate::placing::verified;
use crate::program::{ExplorationError, transformed_by};
use crate::share::SharedWork;
use crate::store::PointKey;
use rayon::prelude::*;
use robovec_ir::{Machine, Module};
use robovec_schedule::{PlaceOptions, schedule_bound};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The shortest schedule of the programs on a design.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub(super) struct DesignPlacement {
    /// Index of the program, from 0.
    pub program: usize,
    /// Length of the schedule of all instances, cycles.
    pub cycles: u32,
    /// No schedule of the same operations is shorter.
    pub lower_bound: u32,
    /// The maximum number of words of one operand memory of an element.
    pub words: u32,
}

/// A design and its result: a placement, or why there is none.
type PlacedDesign = (MachineDesign, Result<DesignPlacement, String>);

/// Places programs on the designs of a share, in the order of the space, or
/// finds those kept. The second result is the number found.
pub(super) fn place(
    programs: &[SweptProgram],
    space: &DesignSpace,
    work: SharedWork<'_>,
) -> Result<(Vec<PlacedDesign>, usize), ExplorationError> {
    let key = work.key("sweep");
    // All programs for every number of instances, with the key of their texts.
    let mut many: BTreeMap<u32, (Vec<Module>, Option<PointKey>)> = BTreeMap::new();
    for &count in &space.instances {
        let interleaved = programs.iter().map(|program| interleaved(program, count));
        let modules = interleaved.collect::<Result<Vec<Module>, ExplorationError>>()?;
        let key = key.map(|key| modules.iter().fold(key, PointKey::with_module));
        many.insert(count, (modules, key));
    }
    let designs = space.designs().into_iter().enumerate();
    let designs = designs.filter(|&(number, _)| work.share.holds(number));
    let designs: Vec<MachineDesign> = designs.map(|(_, design)| design).collect();
    let place = |design: &MachineDesign| {
        let (modules, key) = &many[&design.instances];
        let machine = design.machine();
        let key = key.map(|key| key.with_machine(&machine));
        work.point(key, || shortest(modules, &machine))
    };
    let placed: Result<Vec<_>, std::io::Error> = designs.par_iter().map(place).collect();
    let placed = placed.map_err(|error| ExplorationError::NotKept(error.to_string()))?;
    let found = placed.iter().filter(|(_, is_found)| *is_found).count();
    let results = placed.into_iter().map(|(result, _)| result);
    Ok((designs.into_iter().zip(results).collect(), found))
}

/// Interleaves this number of instances of a program into one.
fn interleaved(program: &SweptProgram, count: u32) -> Result<Module, ExplorationError> {
    if count == 1 {
        return Ok(program.module.clone());
    }
    let passes = format!("interleave{{instances={count}}}");
    transformed_by(&program.module, &passes, &thesis(), None)
}

/// Places programs on a machine that may be shorter than a known schedule.
fn shortest(programs: &[Module], machine: &Machine) -> Result<DesignPlacement, String> {
    let bounds = programs.iter().enumerate().map(|(index, program)| {
        let bound = schedule_bound(&program.functions[0], machine);
        (bound.unwrap_or(u32::MAX), index)
    });
    let mut order: Vec<(u32, usize)> = bounds.collect();
    order.sort_unstable();
    let mut best: Option<DesignPlacement> = None;
    let mut failure = None;
    for (bound, program) in order {
        if best.is_some_and(|best| bound >= best.cycles) {
            break;
        }
        match verified(&programs[program], machine, PlaceOptions::default()) {
            Ok(placed) if best.is_none_or(|best| placed.summary.cycles < best.cycles) => {
                best = Some(DesignPlacement {
                    program,
                    cycles: placed.summary.cycles,
                    lower_bound: placed.summary.lower_bound,
                    words: placed.most_words(machine),
                });
            }
            Ok(_) => {}
            Err(reason) => {
                failure.get_or_insert(reason);
            }
        }
    }
    best.ok_or_else(|| failure.expect("what cannot be placed has a reason"))
}
