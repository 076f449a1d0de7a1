//! Sums whose terms cancel.

use super::super::case::{CaseClass, StressCase};
use super::super::draw::Draw;
use super::super::dynamics::{DynamicsSubject, Metric};
use super::super::equations::EquationsSubject;
use super::super::verdict::StressVerdict;
use super::models::{HINGE, sphere};
use robovec_dynamics::kinematics::MotionState;
use robovec_model::build::{BASE, ModelBuilder};
use robovec_model::{Axis, JointKind, Model};
use robovec_num::double_double::Double;

pub(super) fn cases() -> Vec<StressCase> {
    let mut cases = Vec::new();
    for (power, expected) in [
        (2, StressVerdict::Fine),
        (4, StressVerdict::BadCode),
        (6, StressVerdict::BadCode),
        (8, StressVerdict::BadCode),
        (10, StressVerdict::BadCode),
    ] {
        cases.push(CaseClass::Cancellation.case(
            format!("dot-1e{power}"),
            format!("scalar products of 32 pairs with the condition 1e{power}"),
            "the sum: what is left of it is smaller than the roundings of its terms",
            expected,
            products(10f64.powi(power)),
        ));
    }
    cases.push(CaseClass::Cancellation.case(
        "alternating",
        "small terms, each between +1e7 and -1e7",
        "the small terms, in this order; in another they survive",
        StressVerdict::BadCode,
        alternating(),
    ));
    cases.push(CaseClass::Cancellation.case(
        "ties",
        "1 and a thousand halves of its last place, less 1",
        "every addition is a tie and rounds back to 1; summed first they are exact",
        StressVerdict::BadCode,
        ties(),
    ));
    for (power, expected) in [
        (1, StressVerdict::Fine),
        (2, StressVerdict::BadCode),
        (3, StressVerdict::BadCode),
    ] {
        let residual = 10f64.powi(-power);
        let model = counterweight(residual);
        let mut state = MotionState::initial(&model);
        state.q[0] = 0.3;
        cases.push(CaseClass::Cancellation.case(
            format!("counterweight-1e-{power}"),
            format!("a balanced beam with 1e-{power} N m left of 1e3"),
            "the torque element by element; in the norm nothing shows",
            expected,
            DynamicsSubject::new(model, vec![state], Metric::Forces),
        ));
    }
    cases
}

/// Pairs of a scalar product.
const PAIRS: usize = 32;

/// Scalar products with a condition (Ogita, Rump and Oishi, "Accurate sum and
/// dot product", 2005, Algorithm 6.1): the first half of the products has
/// sizes up to the root of the condition, each of the second half brings the
/// sum down to a size that shrinks to one.
fn products(condition: f64) -> EquationsSubject {
    let terms: Vec<String> = (1..=PAIRS).map(|i| format!("x[{i}]*y[{i}]")).collect();
    let sum = terms.join(" + ");
    let text = format!(
        "function dot equations {{\n  in x[1..{PAIRS}]\n  in y[1..{PAIRS}]\n  out s\n  s = {sum}\n}}\n"
    );
    let inputs = (1..=5).map(|seed| pairs(condition, seed)).collect();
    EquationsSubject::new(text, inputs)
}

fn pairs(condition: f64, seed: u64) -> Vec<f64> {
    let mut draw = Draw::new(seed);
    // Half of the bits of the condition, spread over x and y.
    let half = 0.5 * condition.log2();
    let (mut x, mut y) = (Vec::new(), Vec::new());
    let mut sum = Double::from(0.0);
    for index in 0..PAIRS {
        let exponent = if index == 0 {
            half.round()
        } else if index < PAIRS / 2 {
            (draw.between(0.0, 1.0) * half).round()
        } else {
            // From the largest size down to one.
            let done = (index - PAIRS / 2) as f64 / (PAIRS / 2 - 1) as f64;
            (half * (1.0 - done)).round()
        };
        let size = 2f64.powi(exponent as i32);
        let left = draw.between(0.5, 1.0) * size;
        let right = if index < PAIRS / 2 {
            draw.within(1.0) * size
        } else {
            let wanted = draw.within(1.0) * size;
            f64::from(((wanted - sum.high) / left) as f32)
        };
        sum = sum + Double::from(left) * Double::from(right);
        x.push(left);
        y.push(right);
    }
    x.extend(y);
    x
}

/// `a1 + M - M + a2 + M - M + …`: in the order written every small term meets
/// a large one.
fn alternating() -> EquationsSubject {
    const TERMS: usize = 16;
    let terms: Vec<String> = (1..=TERMS).map(|i| format!("a[{i}] + m - n")).collect();
    let text = format!(
        "function alternating equations {{\n  in a[1..{TERMS}]\n  in m\n  in n\n  out s\n  s = {}\n}}\n",
        terms.join(" + ")
    );
    let mut draw = Draw::new(4);
    let mut inputs: Vec<f64> = (0..TERMS).map(|_| draw.between(0.01, 1.0)).collect();
    inputs.extend([1e7, 1e7]);
    EquationsSubject::new(text, vec![inputs])
}

/// `1 + t + t + … - 1` with the tie `t = 2^-24`.
fn ties() -> EquationsSubject {
    const TERMS: usize = 1024;
    let terms: Vec<String> = (1..=TERMS).map(|i| format!("t[{i}]")).collect();
    let text = format!(
        "function ties equations {{\n  in t[1..{TERMS}]\n  in one\n  out s\n  s = one + {} - one\n}}\n",
        terms.join(" + ")
    );
    let mut inputs = vec![2f64.powi(-24); TERMS];
    inputs.push(1.0);
    EquationsSubject::new(text, vec![inputs])
}

/// A beam with 100 kg on either side, a metre from its hinge but for what
/// leaves a torque (N m).
fn counterweight(residual: f64) -> Model {
    let mut builder = ModelBuilder::new("counterweight");
    let beam = builder.body("Beam", BASE.origin(), &HINGE);
    builder.mass(beam, 10.0, [0.0, 0.0, 0.0], sphere(3.0));
    let weight = 100.0 * 9.81;
    let upright = [JointKind::Revolute(Axis::Z)];
    for (name, place) in [("Left", -1.0), ("Right", 1.0 + residual / weight)] {
        let point = builder.point(beam, name, [place, 0.0, 0.0]);
        let body = builder.body(name, point, &upright);
        builder.mass(body, 100.0, [0.0; 3], sphere(1.0));
    }
    builder.finish()
}
