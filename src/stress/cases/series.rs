//! Series in place of sine and cosine: order 1 is that of the thesis (1.2.2).

use super::super::case::{Case, Class};
use super::super::draw::Draw;
use super::super::series::Angles;
use super::super::verdict::Verdict;
use super::models::random;
use crate::model::family;

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (range, expected) in [
        (0.01, Verdict::BadCode),
        (0.1, Verdict::BadCode),
        (0.5, Verdict::BadCode),
        (1.0, Verdict::BadCode),
        (3.0, Verdict::BadCode),
    ] {
        let model = family::serial(7, 1);
        let states = (0..24).map(|seed| {
            let mut state = random(&model, seed, 1.0);
            let mut draw = Draw::new(seed);
            state.q.iter_mut().for_each(|q| *q = draw.within(range));
            state
        });
        let states = states.collect();
        cases.push(Case {
            name: format!("order-1-within-{range}"),
            class: Class::Series,
            construction: format!("a chain of 7 with sin x = x, cos x = 1 and angles to {range}"),
            breaks: "the model: rounding is nothing beside what the series leaves out",
            expected,
            long: false,
            subject: Box::new(Angles::new(model, states)),
        });
    }
    cases
}
