//! Series in place of sine and cosine: order 1 is that of the thesis (1.2.2).

use super::super::case::{CaseClass, StressCase};
use super::super::draw::Draw;
use super::super::series::AnglesSubject;
use super::super::verdict::StressVerdict;
use super::models::random;
use robovec_model::family;

pub(super) fn cases() -> Vec<StressCase> {
    let mut cases = Vec::new();
    for (range, expected) in [
        (0.01, StressVerdict::BadCode),
        (0.1, StressVerdict::BadCode),
        (0.5, StressVerdict::BadCode),
        (1.0, StressVerdict::BadCode),
        (3.0, StressVerdict::BadCode),
    ] {
        let model = family::serial(7, 1);
        let states = (0..24).map(|seed| {
            let mut state = random(&model, seed, 1.0);
            let mut draw = Draw::new(seed);
            state.q.iter_mut().for_each(|q| *q = draw.within(range));
            state
        });
        let states = states.collect();
        cases.push(CaseClass::Series.case(
            format!("order-1-within-{range}"),
            format!("a chain of 7 with sin x = x, cos x = 1 and angles to {range}"),
            "the model: rounding is nothing beside what the series leaves out",
            expected,
            AnglesSubject::new(model, states),
        ));
    }
    cases
}
