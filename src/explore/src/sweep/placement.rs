//! Programs placed on the designs of a space, a share of them at a time; what
//! came of a design is kept, so that several workers on one folder do the work
//! of one, and one that was stopped loses nothing.
//!
//! **Invariant.** A kept placement is found again only by the same programs, on
//! the same machine, by the same build of robovec.

use super::design::{DesignSpace, MachineDesign};
use super::{SweepError, SweptProgram, interleaved};
use crate::placing::verified;
use crate::share::SharedWork;
use crate::store::PointKey;
use rayon::prelude::*;
use robovec_ir::{Machine, Module};
use robovec_schedule::{PlaceOptions, schedule_bound};
use serde::{Deserialize, Serialize};

/// The shortest schedule of the programs on a design.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct DesignPlacement {
    /// Index of the program, from 0.
    pub program: usize,
    /// Length of the schedule of all instances, cycles.
    pub cycles: u32,
    /// No schedule of the same operations is shorter.
    pub lower_bound: u32,
    /// The most words of one operand memory of an element.
    pub words: u32,
}

/// A design and what came of it: a placement, or why there is none.
pub type PlacedDesign = (MachineDesign, Result<DesignPlacement, String>);

/// Work of a worker.
#[derive(Clone, PartialEq, Debug)]
pub struct PlacedShare {
    /// The designs of the share, in the order of the space.
    pub designs: Vec<PlacedDesign>,
    /// Number of them found in the store.
    pub found: usize,
}

/// Places programs on the designs of a share; those that are kept are found, and
/// the others kept.
///
/// # Errors
///
/// Fails when interleaving fails, or a placement cannot be kept.
pub fn place_share(
    programs: &[SweptProgram],
    space: &DesignSpace,
    work: SharedWork<'_>,
) -> Result<PlacedShare, SweepError> {
    let candidates = Candidates::new(programs, space, work.key("sweep"))?;
    let designs = space.designs().into_iter().enumerate();
    let designs = designs.filter(|&(number, _)| work.share.holds(number));
    let designs: Vec<MachineDesign> = designs.map(|(_, design)| design).collect();
    let place = |design: &MachineDesign| {
        let (modules, programs) = candidates.of(design);
        let machine = design.machine();
        let key = programs.map(|programs| programs.with_machine(&machine));
        work.point(key, || shortest(modules, &machine))
    };
    let placed: Result<Vec<_>, std::io::Error> = designs.par_iter().map(place).collect();
    let placed = placed.map_err(SweepError::NotKept)?;
    let found = placed.iter().filter(|(_, is_found)| *is_found).count();
    let results = placed.into_iter().map(|(result, _)| result);
    Ok(PlacedShare {
        designs: designs.into_iter().zip(results).collect(),
        found,
    })
}

/// All programs for every number of instances of a space, with the keys of
/// their texts.
struct Candidates<'a> {
    space: &'a DesignSpace,
    many: Vec<(Vec<Module>, Option<PointKey>)>,
}

impl Candidates<'_> {
    fn new<'a>(
        programs: &[SweptProgram],
        space: &'a DesignSpace,
        key: Option<PointKey>,
    ) -> Result<Candidates<'a>, SweepError> {
        let many = interleaved(programs, space)?.into_iter();
        let keyed = many.map(|modules| {
            let with = |key: PointKey, module: &Module| key.with_module(module);
            let key = key.map(|key| modules.iter().fold(key, with));
            (modules, key)
        });
        Ok(Candidates {
            space,
            many: keyed.collect(),
        })
    }

    fn of(&self, design: &MachineDesign) -> (&[Module], Option<PointKey>) {
        let mut instances = self.space.instances.iter();
        let place = instances.position(|&count| count == design.instances);
        let (modules, key) = &self.many[place.expect("a design has instances of the space")];
        (modules, *key)
    }
}

/// Places the programs on a machine, but for those whose bound is no shorter
/// than a schedule that is known.
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
