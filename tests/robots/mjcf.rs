//! Robots in MJCF: the same equations as in URDF, loops, and rotors.

use super::account::{add, of_angles, product, scaled, unit};
use super::draw::{DrawnRobot, has_position};
use super::{compare_files, couplings};
use crate::reference::random::ModelDraw;
use crate::support::files::tree;
use crate::support::programs::{robovec, said};
use robovec::model::robot::{RobotBase, read_robot};
use robovec::model::{CutKind, JointLaw};
use robovec_num::random::Random;
use std::fmt::Write;
use std::fs;

/// Random choices of a body that have no counterpart in URDF: where it is
/// attached to its joint, and the position in which the file describes it.
struct BodyChoice {
    anchor: [f64; 3],
    start: f64,
}

fn numbers<const N: usize>(values: [f64; N]) -> String {
    values.map(|value| value.to_string()).join(" ")
}

/// The inertia of a link along the axes of its body: xx yy zz xy xz yz.
fn moments(robot: &DrawnRobot, link: usize) -> [f64; 6] {
    let [xx, xy, xz, yy, yz, zz] = robot.links[link].inertia;
    let turn = of_angles(robot.links[link].center.angles);
    let back = [0, 1, 2].map(|i| [0, 1, 2].map(|j| turn[j][i]));
    let own = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let m = product(&product(&turn, &own), &back);
    [m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2]]
}

/// The body of a joint with all that is attached to it.
fn body_text(robot: &DrawnRobot, choices: &[BodyChoice], number: usize, text: &mut String) {
    let (joint, link) = (&robot.joints[number], number + 1);
    let BodyChoice { anchor, start } = choices[number];
    let shift = match joint.parent {
        0 => [0.0; 3],
        parent => choices[parent - 1].anchor,
    };
    let place = add(joint.place.offset, shift);
    let axis = unit(joint.axis);
    let turned = match joint.kind {
        "prismatic" => format!("pos='{}'", numbers(scaled(axis, start))),
        "fixed" => String::new(),
        _ => format!("axisangle='{} {start}'", numbers(axis)),
    };
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "<frame pos='{}' euler='{}'><frame {turned}><body name='l{link}' pos='{}'>",
        numbers(place),
        numbers(joint.place.angles),
        numbers(scaled(anchor, -1.0))
    );
    if has_position(joint.kind) {
        let kind = if joint.kind == "prismatic" {
            "slide"
        } else {
            "hinge"
        };
        let _ = writeln!(
            text,
            "<joint name='j{number}' type='{kind}' axis='{}' pos='{}' ref='{start}'/>",
            numbers(joint.axis),
            numbers(anchor)
        );
    }
    if robot.links[link].mass != 0.0 {
        let _ = writeln!(
            text,
            "<inertial pos='{}' mass='{}' fullinertia='{}'/>",
            numbers(add(robot.links[link].center.offset, anchor)),
            robot.links[link].mass,
            numbers(moments(robot, link))
        );
    }
    for child in (0..robot.joints.len()).filter(|&child| robot.joints[child].parent == link) {
        body_text(robot, choices, child, text);
    }
    text.push_str("</body></frame></frame>\n");
}

/// A robot as an MJCF file.
fn mjcf(robot: &DrawnRobot, random: &mut Random) -> String {
    let choices: Vec<BodyChoice> = (robot.joints.iter())
        .map(|joint| BodyChoice {
            anchor: random.vector(0.5),
            start: match has_position(joint.kind) && random.chance(0.5) {
                true => random.signed(),
                false => 0.0,
            },
        })
        .collect();
    let mut text = String::from(
        "<mujoco model='drawn'><compiler angle='radian' eulerseq='XYZ'/><worldbody>\n",
    );
    for child in (0..robot.joints.len()).filter(|&child| robot.joints[child].parent == 0) {
        body_text(robot, &choices, child, &mut text);
    }
    text.push_str("</worldbody><equality>\n");
    for (number, joint) in robot.joints.iter().enumerate() {
        if let Some((leader, factor, offset)) = joint.mimic {
            let constant = offset + factor * choices[leader].start - choices[number].start;
            let _ = writeln!(
                text,
                "<joint joint1='j{number}' joint2='j{leader}' polycoef='{constant} {factor} 0 0 0'/>"
            );
        }
    }
    text + "</equality></mujoco>\n"
}

#[test]
fn random_robots_in_mjcf_are_those_of_urdf() {
    let (mut worst, mut followers) = (0.0f64, 0);
    for seed in 1..=80 {
        let mut random = Random::new(seed);
        let robot = DrawnRobot::of_one_axis(&mut random);
        let text = mjcf(&robot, &mut random);
        worst = worst.max(compare_files(
            seed,
            &robot,
            ("drawn.xml", &text),
            RobotBase::Fixed,
        ));
        followers += couplings(seed, &robot, ("drawn.xml", &text));
    }
    println!("worst of 80 robots: {worst:e}");
    assert!(followers > 20, "{followers}");
}

/// A file that must be read.
fn read(text: &str) -> robovec::model::Model {
    match read_robot("own.xml", text.as_bytes(), RobotBase::Fixed) {
        Ok(read) => read.model,
        Err(error) => panic!("{}\n{text}", error.report.render_plain()),
    }
}

/// Masses and moments of inertia by the formulas of solid bodies.
#[test]
fn bodies_are_weighed_by_their_geoms() {
    let pi = std::f64::consts::PI;
    let cases: [(&str, f64, [f64; 3]); 6] = [
        ("size='0.2'", 32.0 / 3.0 * pi, [0.016 * 32.0 / 3.0 * pi; 3]),
        (
            "type='box' size='0.1 0.2 0.3' mass='3'",
            3.0,
            [0.13, 0.1, 0.05],
        ),
        (
            "type='cylinder' size='0.1 0.3' mass='12'",
            12.0,
            [0.39, 0.39, 0.06],
        ),
        (
            "type='ellipsoid' size='0.1 0.2 0.3' mass='5'",
            5.0,
            [0.13, 0.1, 0.05],
        ),
        // A capsule without length is a sphere, one without radius a rod.
        ("type='capsule' size='0.5 1e-9' mass='10'", 10.0, [1.0; 3]),
        (
            "type='capsule' size='1e-9 0.5' mass='12'",
            12.0,
            [1.0, 1.0, 0.0],
        ),
    ];
    for (geom, mass, moments) in cases {
        let model = read(&format!(
            "<mujoco><worldbody><body name='b'><joint/><geom {geom}/><geom type='plane' \
             size='1 1 1'/></body></worldbody></mujoco>"
        ));
        let [xx, _, _, yy, _, zz] = model.bodies[0].inertia;
        let found = [model.bodies[0].mass, xx, yy, zz];
        let wanted = [mass, moments[0], moments[1], moments[2]];
        for (found, wanted) in found.iter().zip(wanted) {
            assert!(
                (found - wanted).abs() <= 1e-7 * mass,
                "{geom}: {found} {wanted}"
            );
        }
    }
}

#[test]
fn joints_have_their_defaults_limits_laws_and_motors() {
    let model = read(
        "<mujoco><default><joint damping='0.5' armature='0.1'/><default class='c'><joint \
         type='slide' range='-1 2'/></default></default><worldbody><body name='a' \
         childclass='c'><joint name='s'/><geom size='0.1'/><body name='b'><joint name='h' \
         type='hinge' range='-90 45' stiffness='3' springref='180' damping='0'/><geom \
         size='0.1'/></body></body></worldbody><actuator><position joint='h'/></actuator></mujoco>",
    );
    let [slide, hinge] = [&model.joints[0], &model.joints[1]];
    assert_eq!(slide.limits, Some([-1.0, 2.0]));
    assert_eq!((slide.law.damping, slide.armature), (0.5, 0.1));
    let pi = std::f64::consts::PI;
    assert_eq!(hinge.limits, Some([-pi / 2.0, pi / 4.0]));
    let law = JointLaw {
        stiffness: 3.0,
        neutral: pi,
        ..JointLaw::default()
    };
    assert_eq!(
        (hinge.law, hinge.actuated, slide.actuated),
        (law, true, false)
    );
}

/// Included files are read from the folder of the first one; messages name its
/// lines.
#[test]
fn files_include_others() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).expect("written");
    };
    fs::create_dir(folder.path().join("parts")).expect("a folder");
    write(
        "parts/geoms.xml",
        "<mujoco>\n<geom size='0.1'/>\n\n</mujoco>",
    );
    write(
        "arm.xml",
        "<mujoco model='arm'>\n<worldbody>\n<body name='a'>\n<joint name='j'/>\n<include \
         file='parts/geoms.xml'/>\n</body>\n<body childclass='none'/>\n</worldbody>\n</mujoco>",
    );
    let path = folder.path().join("arm.xml");
    let path = path.to_str().expect("a plain name");
    let output = robovec(&["model", path]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("arm.xml:7:"), "{message}");
    let text = fs::read_to_string(path).expect("it is there");
    fs::write(path, text.replace(" childclass='none'", "")).expect("written");
    let told = said(&robovec(&["model", path]));
    assert!(told.contains("4.18"), "{told}");
}

/// Forces that no law expresses are named, and the rest moves.
#[test]
fn forces_that_are_left_out_are_warnings() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("ball.xml");
    let text = "<mujoco><option viscosity='0.1'/><worldbody><body gravcomp='1'><joint type='ball' \
                damping='1'/><geom size='0.1' pos='0 0 -1'/></body></worldbody><tendon><spatial \
                stiffness='2'/></tendon></mujoco>";
    fs::write(&path, text).expect("written");
    let path = path.to_str().expect("a plain name");
    for arguments in [vec!["gen", path], vec!["sim", path, "--time", "0.1"]] {
        let output = robovec(&arguments);
        said(&output);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(message.matches("in no equation").count(), 4, "{message}");
    }
}

/// Names that the reader makes take no longer with the number of elements.
#[test]
fn thousands_of_elements_without_names_are_read() {
    let body = "<body><joint/><geom size='0.1'/></body>";
    let text = format!(
        "<mujoco><worldbody><body name='body2'><joint name='joint2'/><geom size='0.1'/></body>\
         {}</worldbody><equality>{}</equality></mujoco>",
        body.repeat(1500),
        "<connect body1='body2' body2='body3'/>".repeat(20_000)
    );
    let model = read(&text);
    let names: std::collections::BTreeSet<_> =
        model.joints.iter().map(|joint| &joint.name).collect();
    assert_eq!((names.len(), model.cuts.len()), (1501, 20_000));
    let names: std::collections::BTreeSet<_> = model.cuts.iter().map(|cut| &cut.name).collect();
    assert_eq!(names.len(), 20_000);
}

/// The mechanisms that ship close their loops, and their equations hold what
/// the file gives.
#[test]
fn mechanisms_with_loops_move() {
    for (name, joints, loops) in [
        ("four-bar.xml", 3, 1),
        ("leg.xml", 8, 2),
        ("biped.xml", 32, 4),
    ] {
        let path = format!("examples/robots/{name}");
        let bytes = fs::read(tree(&path)).expect("it ships");
        let model = read_robot(name, &bytes, RobotBase::Fixed)
            .expect("it is read")
            .model;
        assert_eq!((model.joints.len(), model.cuts.len()), (joints, loops));
        assert!(model.cuts.iter().all(|cut| cut.kind == CutKind::Ball));
        let output = robovec(&["sim", &path, "--time", "0.2", "--samples", "3"]);
        said(&output);
        let summary = String::from_utf8_lossy(&output.stderr);
        assert!(
            summary.contains("energy less work kept within"),
            "{summary}"
        );
    }
}
