//! Chains: generic ones, and those whose mass matrix is nearly singular.

use super::super::case::{CaseClass, StressCase};
use super::super::dynamics::{DynamicsSubject, Metric};
use super::super::verdict::StressVerdict;
use super::models::{planar, random, straight};
use crate::model::family;

pub(super) fn cases() -> Vec<StressCase> {
    let mut cases = Vec::new();
    for joints in [7, 23, 50] {
        let model = family::serial(joints, 1);
        let states = (0..3).map(|seed| random(&model, seed, 1.0)).collect();
        cases.push(StressCase {
            name: format!("generic-{joints}"),
            class: CaseClass::Base,
            construction: format!("the frozen serial model of {joints} joints, random states"),
            breaks: "nothing: the base line",
            expected: if joints < 50 {
                StressVerdict::Fine
            } else {
                StressVerdict::HardProblem
            },
            long: joints > 23,
            subject: Box::new(DynamicsSubject::new(model, states, Metric::Accelerations)),
        });
    }
    for joints in [4, 8, 16, 32, 64, 128] {
        let model = planar(joints);
        let states = vec![straight(&model)];
        cases.push(StressCase {
            name: format!("straight-{joints}"),
            class: CaseClass::Chain,
            construction: format!("{joints} equal bodies on parallel hinges, stretched out"),
            breaks: "the smallest eigenvalue of M: accelerations lose what M still has",
            expected: match joints {
                ..16 => StressVerdict::Fine,
                _ => StressVerdict::HardProblem,
            },
            long: joints > 16,
            subject: Box::new(DynamicsSubject::new(model, states, Metric::Accelerations)),
        });
    }
    let model = planar(128);
    let states = vec![random(&model, 5, 1.0)];
    cases.push(StressCase {
        name: "crooked-128".to_owned(),
        class: CaseClass::Chain,
        construction: "the same 128 bodies in a random pose".to_owned(),
        breaks: "less: the pose matters thirty times",
        expected: StressVerdict::HardProblem,
        long: true,
        subject: Box::new(DynamicsSubject::new(model, states, Metric::Accelerations)),
    });
    let model = planar(1000);
    let states = vec![straight(&model)];
    let dynamics = DynamicsSubject::new(model, states, Metric::Accelerations);
    cases.push(StressCase {
        name: "straight-1000".to_owned(),
        class: CaseClass::Chain,
        construction: "1000 equal bodies on parallel hinges, by articulated bodies".to_owned(),
        breaks: "everything: no format of 32 bits holds such a mass matrix",
        expected: StressVerdict::HardProblem,
        long: true,
        subject: Box::new(DynamicsSubject {
            articulated: true,
            ..dynamics
        }),
    });
    cases
}
