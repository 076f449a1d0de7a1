//! Chains: generic ones, and those whose mass matrix is nearly singular.

use super::super::case::{CaseClass, StressCase};
use super::super::dynamics::DynamicsSubject;
use super::super::verdict::StressVerdict;
use super::models::{accelerations, planar, random, some, straight};
use robovec_model::family;

pub(super) fn cases() -> Vec<StressCase> {
    let mut cases = Vec::new();
    for joints in [7, 23, 50] {
        let model = family::serial(joints, 1);
        let states = some(&model);
        cases.push(StressCase {
            long: joints > 23,
            ..CaseClass::Base.case(
                format!("generic-{joints}"),
                format!("the frozen serial model of {joints} joints, random states"),
                "nothing: the base line",
                if joints < 50 {
                    StressVerdict::Fine
                } else {
                    StressVerdict::HardProblem
                },
                accelerations(model, states),
            )
        });
    }
    for joints in [4, 8, 16, 32, 64, 128] {
        let model = planar(joints);
        let states = vec![straight(&model)];
        cases.push(StressCase {
            long: joints > 16,
            ..CaseClass::Chain.case(
                format!("straight-{joints}"),
                format!("{joints} equal bodies on parallel hinges, stretched out"),
                "the smallest eigenvalue of M: accelerations lose what M still has",
                match joints {
                    ..16 => StressVerdict::Fine,
                    _ => StressVerdict::HardProblem,
                },
                accelerations(model, states),
            )
        });
    }
    let model = planar(128);
    let states = vec![random(&model, 5, 1.0)];
    cases.push(StressCase {
        long: true,
        ..CaseClass::Chain.case(
            "crooked-128",
            "the same 128 bodies in a random pose",
            "less: the pose matters thirty times",
            StressVerdict::HardProblem,
            accelerations(model, states),
        )
    });
    let model = planar(1000);
    let states = vec![straight(&model)];
    let dynamics = accelerations(model, states);
    cases.push(StressCase {
        long: true,
        ..CaseClass::Chain.case(
            "straight-1000",
            "1000 equal bodies on parallel hinges, by articulated bodies",
            "everything: no format of 32 bits holds such a mass matrix",
            StressVerdict::HardProblem,
            DynamicsSubject {
                articulated: true,
                ..dynamics
            },
        )
    });
    cases
}
