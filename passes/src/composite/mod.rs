//! The mass matrix, or accelerations, from composite bodies.
//!
//! `model` reads the inputs of the system, `tree`, with `axes` and `points`,
//! finds the joints from the values of the function at the states of `probe`
//! (`solved` for accelerations), `bodies`, `matrix`, `forces` and `solve` have
//! the mechanics over any ring, `quotients` compares accelerations, and
//! `write` makes the new equations as values of the network of `factor`, so
//! that zero, equal or opposite values are never computed.

mod axes;
mod bodies;
mod forces;
mod matrix;
mod model;
mod points;
mod probe;
mod quotients;
mod solve;
mod solved;
mod tree;
mod write;

use crate::factor;
use model::ModelInputs;
use robovec_analysis::critical_path::Weights;
use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_ir::Function;

declare_pass! {
    /// Computes a mass matrix and its forces from composite bodies.
    ///
    /// Robotran finds the mass matrix column by column: for every pair of a
    /// joint and a joint before it a force and a torque, passed on from body to
    /// body. The same matrix follows from one inertia for each joint, that of
    /// all bodies beyond it, with a third to a half of the operations for real
    /// models and a quarter for long chains (Featherstone, Rigid Body Dynamics
    /// Algorithms, 2008, section 6.2).
    ///
    /// The pass reads no model. It needs Robotran's arrays (`M` among the
    /// outputs; `q`, `m`, `l`, `In` and `dpt` among the inputs) and finds the
    /// tree of joints from the values of the function at states that isolate
    /// one property each: with the mass of one body only, the joints that move
    /// it; with all frames aligned, the axes; with one attachment point at a
    /// time, the joints after it. Every element of `M` whose new equations have
    /// the value of the old ones, at random points of two prime fields and in
    /// numbers, is replaced; and so are the forces `c` with the same values,
    /// where that takes fewer operations. All other values of the function are
    /// kept, and so are elements that do not follow from a tree, and a matrix
    /// that would not become cheaper.
    ///
    /// A function of accelerations (`qdd` of all joints among the outputs, `Qq`
    /// among the inputs) rests on a mass matrix: the inverse of the
    /// derivatives of `qdd` by `Qq`. Its tree is found in the same way, with
    /// usual masses added where a body alone would leave the matrix singular,
    /// and the accelerations are computed by articulated bodies (the same book,
    /// section 7.3) or by factors of the matrix that follow the tree (section
    /// 6.5), whichever takes fewer operations. Driven joints and loops are not
    /// recognised there.
    ///
    /// The masses are the same in all frames only if sin^2 + cos^2 = 1.
    /// Robotran itself uses this when it adds masses.
    pub struct Composite("composite") {}
    takes: [Atomic],
    gives: Gives::Same,
    class: RealTrig,
    destroys: [Timed, ZeroFree],
}

impl Pass for Composite {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let weights = Weights::cycles(context.machine);
        let mut network = factor::read::read(function, context.tables, true);
        let Some(model) = ModelInputs::find(function, &network, context.tables) else {
            let remark = "there is no mass matrix, and no acceleration of every joint for its \
                          force, over Robotran's inputs";
            context.remark(remark.to_owned());
            return Ok(());
        };
        let places = match tree::find(function, &model) {
            Ok(places) => places,
            Err(remark) => {
                context.remark(remark.to_owned());
                return Ok(());
            }
        };
        let before = network.cost;
        let rebuilt = write::rebuild(&mut network, &model, &places, function, context.tables);
        let unexplained = rebuilt.unexplained;
        let outputs = match &model.solved {
            Some(solved) => &solved.places,
            None => &model.elements,
        };
        let explained = outputs.iter().flatten().count() - unexplained.len();
        context
            .remarks
            .extend(remark(&model, &unexplained, explained));
        let saved = before - network.cost;
        context.statistics.extend([
            ("elements of a tree of bodies", explained as u64),
            ("forces of a tree of bodies", rebuilt.forces as u64),
            ("operations saved", saved.max(0) as u64),
        ]);
        if saved > 0 {
            *function =
                factor::write::write(function, network, &weights, context.tables, context.notes);
        }
        Ok(())
    }
}

/// Remark on outputs that no tree of bodies explains.
fn remark(model: &ModelInputs, unexplained: &[usize], explained: usize) -> Option<String> {
    let (&first, count) = (unexplained.first()?, model.len());
    let (whole, elements, element) = match model.solved {
        Some(_) => (
            "the accelerations are not those",
            "accelerations",
            format!("qdd[{}]", first + 1),
        ),
        None => (
            "the mass matrix is not that",
            "elements of the mass matrix",
            format!("M[{},{}]", first / count + 1, first % count + 1),
        ),
    };
    Some(match explained {
        0 => format!("{whole} of a tree of bodies"),
        _ => format!(
            "{} of {} {elements}, {element} the first, are not those of a tree of bodies and stay \
             as they are",
            unexplained.len(),
            explained + unexplained.len(),
        ),
    })
}
