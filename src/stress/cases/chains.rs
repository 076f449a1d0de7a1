//! Chains: generic ones, and those whose mass matrix is nearly singular.

use super::super::case::{Case, Class};
use super::super::dynamics::{Dynamics, Metric};
use super::super::verdict::Verdict;
use super::models::{planar, random, straight};
use crate::model::family;

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for joints in [7, 23, 50] {
        let model = family::serial(joints, 1);
        let states = (0..3).map(|seed| random(&model, seed, 1.0)).collect();
        cases.push(Case {
            name: format!("generic-{joints}"),
            class: Class::Base,
            construction: format!("the frozen serial model of {joints} joints, random states"),
            breaks: "nothing: the base line",
            expected: if joints < 50 {
                Verdict::Fine
            } else {
                Verdict::HardProblem
            },
            long: joints > 23,
            subject: Box::new(Dynamics::new(model, states, Metric::Accelerations)),
        });
    }
    for joints in [4, 8, 16, 32, 64, 128] {
        let model = planar(joints);
        let states = vec![straight(&model)];
        cases.push(Case {
            name: format!("straight-{joints}"),
            class: Class::Chain,
            construction: format!("{joints} equal bodies on parallel hinges, stretched out"),
            breaks: "the smallest eigenvalue of M: accelerations lose what M still has",
            expected: match joints {
                ..16 => Verdict::Fine,
                _ => Verdict::HardProblem,
            },
            long: joints > 16,
            subject: Box::new(Dynamics::new(model, states, Metric::Accelerations)),
        });
    }
    let model = planar(128);
    let states = vec![random(&model, 5, 1.0)];
    cases.push(Case {
        name: "crooked-128".to_owned(),
        class: Class::Chain,
        construction: "the same 128 bodies in a random pose".to_owned(),
        breaks: "less: the pose matters thirty times",
        expected: Verdict::HardProblem,
        long: true,
        subject: Box::new(Dynamics::new(model, states, Metric::Accelerations)),
    });
    let model = planar(1000);
    let states = vec![straight(&model)];
    let dynamics = Dynamics::new(model, states, Metric::Accelerations);
    cases.push(Case {
        name: "straight-1000".to_owned(),
        class: Class::Chain,
        construction: "1000 equal bodies on parallel hinges, by articulated bodies".to_owned(),
        breaks: "everything: no format of 32 bits holds such a mass matrix",
        expected: Verdict::HardProblem,
        long: true,
        subject: Box::new(Dynamics {
            articulated: true,
            ..dynamics
        }),
    });
    cases
}
