//! `composite` on the equations of random trees of bodies: every mass matrix, and
//! all accelerations, are explained completely.

use robovec::explore::program::view;
use robovec::generate::{Formulation, GenerationRequest, generate};
use robovec::model::build::{BASE, ModelBuilder};
use robovec::model::family::random_tree;
use robovec::model::{Axis, JointKind, Model, Nature};
use robovec::robotran::FunctionKind;
use robovec_analysis::class::NumericClass;
use robovec_framework::check::check;
use robovec_framework::manager::{self, Config};
use robovec_ir::count::Counts;
use robovec_ir::states::States;
use robovec_ir::{Machine, Module};
use robovec_num::random::{Random, mix};
use robovec_passes::registry::REGISTRY;

/// A tree of some kind: bodies with full, diagonal and no inertia, with and
/// without a centre of mass, wheels, driven joints.
fn model(case: u64) -> Model {
    let joints = 3 + (mix(case) % 38) as usize;
    let mut model = random_tree(case, joints);
    let mut random = Random::new(mix(case ^ 0x0dd));
    let mut once_in = |count: u64| random.bits().is_multiple_of(count);
    let style = case % 8;
    for body in &mut model.bodies {
        if style == 1 && once_in(2) {
            // A point mass.
            body.inertia = [0.0; 6];
        }
        if style == 2 || style == 3 && once_in(2) {
            // A wheel: balanced, and symmetric about one of its axes.
            body.center = [0.0; 3];
            let [xx, _, _, _, _, zz] = body.inertia;
            body.inertia = if once_in(2) {
                [xx, 0.0, 0.0, zz, 0.0, zz]
            } else {
                [zz, 0.0, 0.0, xx, 0.0, zz]
            };
        }
        if style == 4 {
            let [_, xy, xz, _, yz, _] = &mut body.inertia;
            for number in body.center.iter_mut().chain([xy, xz, yz]) {
                if once_in(3) {
                    *number = 0.0;
                }
            }
        }
        if style == 5 && once_in(3) {
            body.point = None;
            model.joints[body.joints.start].point = None;
        }
    }
    if style == 6 {
        for point in &mut model.points {
            for number in &mut point.coordinates {
                if once_in(2) {
                    *number = 0.0;
                }
            }
        }
    }
    for joint in &mut model.joints {
        if style == 7 && once_in(4) {
            joint.nature = Nature::Driven;
            joint.has_velocity = false;
            joint.has_acceleration = false;
        }
    }
    model
}

/// Equations of a tree, and the remarks of `composite` on them.
fn rebuilt(request: &GenerationRequest, model: &Model, passes: &str) -> (Module, String) {
    let mut module = generate(model, request).expect("it has equations");
    let pipeline = REGISTRY.pipeline(passes).expect("passes");
    let machine = Machine::built_in("solver").expect("it ships");
    let mut out = Vec::new();
    let config = Config::new(&machine, &mut out);
    manager::run(&mut module, &pipeline, config).expect("it runs");
    (module, String::from_utf8(out).expect("remarks are text"))
}

/// Remark of `composite` on the equations of a tree; nothing when it explains
/// the whole matrix.
fn complaint(model: &Model, all_parameters: bool) -> Option<String> {
    let mut request = GenerationRequest::new(FunctionKind::Dirdyna);
    request.options.all_parameters = all_parameters;
    let (_, said) = rebuilt(&request, model, "atomise,composite");
    (!said.is_empty()).then_some(said)
}

/// Operations of accelerations before and after `composite`, and the fewest of
/// those that the model gives; nothing for a tree whose joints move no inertia.
/// The function stays the same.
fn accelerations(case: u64) -> Option<[usize; 3]> {
    let mut model = model(case);
    for joint in &mut model.joints {
        joint.nature = Nature::Independent;
    }
    generate(&model, &GenerationRequest::new(FunctionKind::Accelred)).ok()?;
    let clean = "zero-removal,cse,dce";
    let of = |formulation: Formulation, passes: &str| {
        let mut request = GenerationRequest::new(FunctionKind::Accelred);
        request.formulation = formulation;
        rebuilt(&request, &model, passes)
    };
    let (before, _) = of(Formulation::Recursive, &format!("atomise,{clean}"));
    let (after, said) = of(
        Formulation::Recursive,
        &format!("atomise,composite,{clean}"),
    );
    assert_eq!(said, "", "case {case}");
    let verdict = check(
        view(&before),
        view(&after),
        NumericClass::RealTrig,
        &States::new(case),
        2,
    );
    assert!(
        verdict.holds() && verdict.is_decided(),
        "case {case}: {verdict}"
    );
    let operations = |module: &Module| Counts::of(view(module).function).operations;
    let best = [Formulation::Articulated, Formulation::Composite]
        .map(|formulation| operations(&of(formulation, &format!("atomise,{clean}")).0));
    let [first, second] = best;
    Some([operations(&before), operations(&after), first.min(second)])
}

#[test]
fn accelerations_of_trees_are_found_again() {
    let cases = (0..200).filter_map(|case| Some((case, accelerations(case)?)));
    let cases: Vec<(u64, [usize; 3])> = cases.take(30).collect();
    assert_eq!(cases.len(), 30);
    for (case, [before, after, best]) in cases {
        let part = after as f64 / best as f64;
        assert!(
            part <= 1.3,
            "case {case}: {before} -> {after} operations, {best} from the model"
        );
    }
}

fn assert_explained(cases: impl Iterator<Item = u64>) {
    let said = |case: u64| {
        let said = complaint(&model(case), (case / 8).is_multiple_of(4))?;
        Some(format!("case {case}: {said}"))
    };
    let complaints: Vec<String> = cases.filter_map(said).collect();
    assert!(
        complaints.is_empty(),
        "{} of them:\n{}",
        complaints.len(),
        complaints.join("\n")
    );
}

#[test]
fn a_slide_and_a_hinge_along_one_axis_behind_a_free_base_are_explained() {
    let (slide, hinge) = (JointKind::Prismatic(Axis::Z), JointKind::Revolute(Axis::Z));
    for branch in [[slide, hinge], [hinge, slide]] {
        let mut builder = ModelBuilder::new("branch");
        let base = builder.body("Base", BASE.origin(), &JointKind::ALL);
        builder.mass(base, 3.0, [0.1, 0.2, 0.3], [0.4, 0.0, 0.0, 0.5, 0.0, 0.6]);
        let place = builder.point(base, "Branch", [0.3, 0.0, -0.2]);
        let arm = builder.body("Arm", place, &branch);
        builder.mass(arm, 1.0, [0.2, 0.0, 0.1], [0.1, 0.0, 0.0, 0.2, 0.0, 0.15]);
        assert_eq!(complaint(&builder.finish(), false), None);
    }
}

#[test]
fn trees_of_all_kinds_are_explained() {
    assert_explained(0..120);
}

#[test]
#[ignore = "half a minute"]
fn two_thousand_trees_are_explained() {
    assert_explained(0..2000);
}
