//! The table of all passes and of all presets: the single place where they
//! are listed.

use crate::{
    accurate, asap_alap, atomise, balance, cancellation, codegen, composite, cse, dce,
    differentiate, eqsat, factor, fma, fold, inline, interleave, lookahead, meet, mixed, optimise,
    recurrence, specialise, swap, trigonometry, zero_removal,
};
use robovec_framework::pass::{PassInfo, Preset, Registry};
use robovec_schedule::Place;

/// All passes and presets of robovec.
pub static REGISTRY: Registry = Registry {
    passes: PASSES,
    presets: PRESETS,
};

/// All passes, in their usual order.
const PASSES: &[PassInfo] = &[
    trigonometry::Trigonometry::INFO,
    atomise::Atomise::INFO,
    differentiate::Differentiate::INFO,
    specialise::Specialise::INFO,
    fold::Fold::INFO,
    zero_removal::ZeroRemoval::INFO,
    composite::Composite::INFO,
    factor::Factor::INFO,
    factor::FactorTrig::INFO,
    swap::Swap::INFO,
    balance::Balance::INFO,
    eqsat::Eqsat::INFO,
    cse::Cse::INFO,
    dce::Dce::INFO,
    fma::Fma::INFO,
    accurate::Accurate::INFO,
    cancellation::AccurateRoots::INFO,
    cancellation::AccurateTrig::INFO,
    inline::Inline::INFO,
    lookahead::Lookahead::INFO,
    recurrence::Recurrence::INFO,
    meet::Meet::INFO,
    mixed::Mixed::INFO,
    interleave::Interleave::INFO,
    asap_alap::AsapAlap::INFO,
    optimise::Optimise::INFO,
    Place::INFO,
    codegen::Codegen::INFO,
];

const PRESETS: &[Preset] = &[
    Preset {
        name: "shorten",
        summary: "the shortest path that reassociation reaches, without superfluous operations",
        pipeline: "atomise,zero-removal,balance,cse,dce,asap-alap",
    },
    Preset {
        name: "ahead",
        summary: "the shortest path that look-ahead reaches with no more operations than balanced",
        pipeline: "atomise,zero-removal,balance,cse,dce,lookahead,balance,cse,dce,asap-alap",
    },
    Preset {
        name: "cpu",
        summary: "the fewest operations, for a processor; codegen{target=c} may follow",
        pipeline: "atomise,fold,cse,composite,factor-trig{path=free},cse,dce",
    },
    Preset {
        name: "fpga",
        summary: "from equations to memory images for the machine's processing elements: the best \
                  schedule that a search of one effort finds",
        pipeline: "atomise,optimise,place,codegen",
    },
];
