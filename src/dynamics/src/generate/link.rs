//! Links: forces along a line, by the user's law of length `Z` and rate `Zd`.
//!
//! The points are seen from the last joint both have in common. With `e` the
//! direction from the first to the second point, the force `F` of the law acts
//! as `+F e` on the first body and as `-F e` on the second.

use super::Options;
use super::algebra::{Scalar, Sum};
use super::chain::Chain;
use super::constraints::{place, split};
use super::equations::{Equations, QuantityLabel};
use super::forces::{Loads, into_frame};
use super::parameters::ModelParameters;
use super::vector::{Vector, define_as, subtracted, unit};
use robovec_ir::{Boundary, SourceSet};

pub(super) fn write(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) {
    let mut loads = Loads::new(parameters);
    for index in 0..parameters.model.links.len() {
        one(equations, parameters, options, index, &mut loads);
    }
    loads.write(equations);
}

fn one(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
    index: usize,
    loads: &mut Loads,
) {
    let (model, number) = (parameters.model, index + 1);
    let link = &model.links[index];
    let paths = split(parameters, &link.ends);
    let places = [0, 1].map(|side| place(equations, parameters, options, &link.ends[side]));
    let chains = [0, 1].map(|side| {
        let names = ("lnk", 2 * index + side + 1);
        Chain::new(equations, parameters, names, &paths[side], &places[side])
    });
    let [first, second] = [0, 1].map(|side| chains[side].position_terms(equations));
    let label = |component| QuantityLabel::new("Plnk", component, number);
    let span = define_as(equations, label, subtracted(second, &first));
    let (length, direction) = line(equations, number, &span);
    let velocities = [0, 1].map(|side| chains[side].motion(equations, parameters, &[]).velocity);
    let velocity = difference(equations, "Vlnk", number, &velocities[1], &velocities[0]);
    let mut rate = Sum::new();
    for (component, &value) in velocity.iter().zip(&direction) {
        rate.add(&[*component, value]);
    }
    let rate = equations.define(QuantityLabel::new("Zd", 0, number), rate);
    let length = equations.named(QuantityLabel::new("Z", 0, number), "Zv", length);
    let rate = equations.named(QuantityLabel::new("Zd", 0, number), "Zv", rate);
    let force = call(equations, number, length, rate);
    let pull: Vector = [0, 1, 2].map(|k| {
        let sum = Sum::product(&[force, direction[k]]);
        equations.define(QuantityLabel::new("flnk", k + 1, number), sum)
    });
    for (side, prefix) in [(0, "fPlnk"), (1, "fSlnk")] {
        // What acts on the base moves nothing.
        let Some(joint) = model.last_joint(link.ends[side].body) else {
            continue;
        };
        let name = |row| QuantityLabel::new(prefix, row, number);
        let pull = into_frame(equations, &chains[side].axes(), &pull, name);
        let lever = difference(
            equations,
            "Alnk",
            2 * index + side + 1,
            &places[side],
            &parameters.centers[joint],
        );
        loads.add_force(joint, &pull, &lever, side == 1);
    }
}

/// Length and direction of a span. Along one axis the length is the component
/// with its sign, as in Robotran: for a prismatic joint, its position.
fn line(equations: &mut Equations, number: usize, span: &Vector) -> (Scalar, Vector) {
    let mut present = (0..3).filter(|&k| !span[k].is_zero());
    if let (Some(only), None) = (present.next(), present.next()) {
        return (span[only], unit(only));
    }
    let mut square = Sum::new();
    for &component in span {
        square.add(&[component, component]);
    }
    let square = equations.define(QuantityLabel::new("PPlnk", 0, number), square);
    let length = equations.sqrt(QuantityLabel::new("Z", 0, number), square);
    let direction = [0, 1, 2]
        .map(|k| equations.quotient(QuantityLabel::new("e", k + 1, number), span[k], length));
    (length, direction)
}

fn difference(
    equations: &mut Equations,
    prefix: &'static str,
    number: usize,
    a: &Vector,
    b: &Vector,
) -> Vector {
    [0, 1, 2].map(|k| {
        let sum = Sum::total(&[a[k], -b[k]]);
        equations.define(QuantityLabel::new(prefix, k + 1, number), sum)
    })
}

/// The user's law: length and rate go out, a force comes back.
fn call(equations: &mut Equations, number: usize, length: Scalar, rate: Scalar) -> Scalar {
    let name = |prefix: &str| format!("{prefix}{number}");
    let result = name("Flink");
    let force = equations.input(&result, &[]);
    for (array, value) in [("Z", length), ("Zd", rate), ("Flink", force)] {
        equations.output(array, &[number], value);
    }
    equations.output(&name("Z"), &[], length);
    equations.output(&name("Zd"), &[], rate);
    equations.calls.push(Boundary {
        callee: "user_LinkForces".to_owned(),
        arguments: vec![
            name("Z"),
            name("Zd"),
            "s".to_owned(),
            "tsim".to_owned(),
            number.to_string(),
        ],
        result: Some(result),
        sources: SourceSet::EMPTY,
    });
    force
}
