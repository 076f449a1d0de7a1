//! A model as a user reads it: counts, the tree, the loops.

use super::{Anchor, Cut, CutKind, Joint, JointCoupling, Link, Model, Nature, number};
use std::fmt::Write;

/// The summary of a model, several lines of text.
///
/// In the tree, a body that hangs alone on another is right below it; only
/// branches step to the right, so that long chains stay readable.
pub fn summarise(model: &Model) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail, here and below.
    let _ = writeln!(text, "{}", counts(model));
    text.push_str(&tree(model));
    text.push_str(&placements(model));
    for (index, cut) in model.cuts.iter().enumerate() {
        let word = match cut.kind {
            CutKind::Coupling(_) => "coupling",
            CutKind::Ball | CutKind::Rod(_) | CutKind::Solid => "loop",
        };
        let _ = writeln!(text, "{word} {}: {}", index + 1, loop_line(model, cut));
    }
    for (kind, links) in [("link", &model.links), ("link3D", &model.links3d)] {
        for (index, link) in links.iter().enumerate() {
            let _ = writeln!(text, "{kind} {}: {}", index + 1, link_line(model, link));
        }
    }
    for (kind, list) in [("sensor", &model.sensors), ("force", &model.forces)] {
        for (index, sensor) in list.iter().enumerate() {
            let point = &model.points[sensor.point];
            let place = Anchor {
                body: point.body,
                point: Some(sensor.point),
            };
            let _ = writeln!(
                text,
                "{kind} {}: {} at {}",
                index + 1,
                sensor.name,
                anchor(model, place)
            );
        }
    }
    text
}

fn plural(count: usize, noun: &str) -> String {
    let mut text = format!("{count} {noun}");
    if count != 1 {
        match text.strip_suffix('y') {
            Some(stem) => text = format!("{stem}ies"),
            None => text.push('s'),
        }
    }
    text
}

fn counts(model: &Model) -> String {
    let of = |nature| {
        let joints = model.joints.iter();
        joints.filter(|joint| joint.nature == nature).count()
    };
    let mass: f64 = model.bodies.iter().map(|body| body.mass).sum();
    // The sum without the dust of its additions.
    let mass = format!("{mass:.9e}").parse::<f64>();
    let mass = mass.expect("the text of a number is one") + 0.0;
    let rows: usize = model.cuts.iter().map(Cut::rows).sum();
    let [x, y, z] = model.gravity;
    let base_points = model.points.iter().filter(|point| point.body.is_none());
    let mut text = format!(
        "{}: {} of {}, {mass} kg, gravity ({x}, {y}, {z}) m/s^2\n",
        model.name,
        plural(model.joints.len(), "joint"),
        plural(model.bodies.len(), "body"),
    );
    let _ = writeln!(
        text,
        "{} of freedom: {}, {} dependent, {} driven; {} with {} at most",
        plural(of(Nature::Independent), "degree"),
        plural(of(Nature::Independent), "independent joint"),
        of(Nature::Dependent),
        of(Nature::Driven),
        plural(model.cuts.len(), "loop"),
        plural(rows, "constraint"),
    );
    let _ = writeln!(
        text,
        "{} ({} on the base), {}, {}, {}, {}",
        plural(model.points.len(), "point"),
        base_points.count(),
        plural(model.links.len() + model.links3d.len(), "link"),
        plural(model.forces.len(), "external force"),
        plural(model.sensors.len(), "sensor"),
        plural(model.user_models.len(), "user model"),
    );
    text
}

fn tree(model: &Model) -> String {
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); model.bodies.len() + 1];
    for (index, body) in model.bodies.iter().enumerate() {
        children[number(body.parent)].push(index);
    }
    let mut text = String::from("base\n");
    let mut stack: Vec<(usize, String, String)> = Vec::new();
    push_children(&children[0], "", &mut stack);
    while let Some((body, head, below)) = stack.pop() {
        let _ = writeln!(text, "{head}{}", body_line(model, body));
        push_children(&children[body + 1], &below, &mut stack);
    }
    text + "\n"
}

/// Pushes the bodies attached to one onto the stack, with their prefixes.
fn push_children(children: &[usize], prefix: &str, stack: &mut Vec<(usize, String, String)>) {
    for (place, &child) in children.iter().enumerate().rev() {
        let (head, below) = match children.len() {
            1 => (String::new(), String::new()),
            count if place + 1 == count => ("└─ ".to_owned(), "   ".to_owned()),
            _ => ("├─ ".to_owned(), "│  ".to_owned()),
        };
        stack.push((child, prefix.to_owned() + &head, prefix.to_owned() + &below));
    }
}

fn body_line(model: &Model, index: usize) -> String {
    let body = &model.bodies[index];
    let first = body.joints.start + 1;
    let mut line = format!("{}: ", body.name);
    line += &if body.joints.len() == 1 {
        format!("joint {first} ")
    } else {
        format!("joints {first} to {} ", body.joints.end)
    };
    for joint in &model.joints[body.joints.clone()] {
        line += joint.kind.name();
        line += match joint.nature {
            Nature::Independent => "",
            Nature::Dependent => " (dependent)",
            Nature::Driven => " (driven)",
        };
        line += if joint.actuated { " (actuated) " } else { " " };
    }
    if let Some(point) = body.point {
        let _ = write!(line, "at {} ", point_name(model, point));
    }
    line.pop();
    if body.mass != 0.0 {
        let _ = write!(line, ", {} kg", body.mass);
    } else {
        line += ", no mass";
    }
    line
}

/// Properties of joints beyond those of `.mbs` files, a line for each: constant
/// turns before them, axes against which they move, limits, losses and rotors.
fn placements(model: &Model) -> String {
    let plain = |joint: &Joint| {
        joint.mounting.is_plain()
            && joint.limits.is_none()
            && !joint.law.are_there()
            && joint.armature == 0.0
    };
    if model.joints.iter().all(plain) {
        return String::new();
    }
    let mut text = String::new();
    for (index, joint) in model.joints.iter().enumerate() {
        let _ = write!(text, "joint {}: {}", index + 1, joint.name);
        for turn in &joint.mounting.turns {
            let axis = ["x", "y", "z"][turn.axis.index()];
            let _ = write!(text, ", turned by {} rad about {axis}", turn.angle);
        }
        if joint.mounting.reversed {
            text += ", against its axis";
        }
        if let Some([least, most]) = joint.limits {
            let unit = if joint.kind.is_revolute() { "rad" } else { "m" };
            let _ = write!(text, ", from {least} to {most} {unit}");
        }
        for (name, amount) in [
            ("damping", joint.law.damping),
            ("friction", joint.law.friction),
            ("stiffness", joint.law.stiffness),
            ("armature", joint.armature),
        ] {
            if amount != 0.0 {
                let _ = write!(text, ", {name} {amount}");
            }
        }
        text.push('\n');
    }
    let turns = model.joints.iter().flat_map(|joint| &joint.mounting.turns);
    let small: Vec<f64> = turns.map(|turn| turn.angle.abs()).collect();
    let small: Vec<f64> = small.into_iter().filter(|&angle| angle < NEARLY).collect();
    if let Some(most) = small.iter().copied().reduce(f64::max) {
        let _ = writeln!(
            text,
            "{} of these turns are at most {most:.1e} rad: angles of the file are nearly right \
             angles, and --right-angles makes them exact",
            small.len()
        );
    }
    text
}

/// Constant turns smaller than this were hardly meant, rad.
const NEARLY: f64 = 1e-4;

fn point_name(model: &Model, point: usize) -> String {
    format!("{} [{}]", model.points[point].name, point + 1)
}

fn anchor(model: &Model, anchor: Anchor) -> String {
    let body = model.body_name(anchor.body);
    match anchor.point {
        Some(point) => format!("{body}, {}", point_name(model, point)),
        None => format!("{body}, origin"),
    }
}

fn link_line(model: &Model, link: &Link) -> String {
    let [first, second] = link.ends.map(|end| anchor(model, end));
    format!("{} from {first} to {second}", link.name)
}

fn loop_line(model: &Model, cut: &Cut) -> String {
    let kind = match cut.kind {
        CutKind::Ball => "ball".to_owned(),
        CutKind::Rod(length) => format!("rod of {length} m"),
        CutKind::Solid => "solid".to_owned(),
        CutKind::Coupling(coupling) => return coupling_line(model, cut, &coupling),
    };
    let [first, second] = cut.ends.map(|end| anchor(model, end));
    format!(
        "{} ({kind}) between {first} and {second}, around {}",
        cut.name,
        plural(loop_joints(model, cut), "joint")
    )
}

/// `follower = 2 leader + 0.1`, by names of joints.
fn coupling_line(model: &Model, cut: &Cut, coupling: &JointCoupling) -> String {
    let name = |joint: usize| &model.joints[joint].name;
    let mut line = format!("{}: {} = ", cut.name, name(coupling.joint));
    if coupling.factor != 1.0 {
        line += &format!("{} ", coupling.factor);
    }
    line += name(coupling.leader);
    if coupling.offset != 0.0 {
        line += &format!(" + {}", coupling.offset);
    }
    line
}

/// Number of joints around a loop: on the path to exactly one end of the cut.
fn loop_joints(model: &Model, cut: &Cut) -> usize {
    let mut on_one_path = vec![false; model.joints.len()];
    for end in cut.ends {
        for joint in model.path(model.last_joint(end.body)) {
            on_one_path[joint] = !on_one_path[joint];
        }
    }
    on_one_path.iter().filter(|&&once| once).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::family::built_in;

    #[test]
    fn a_loop_is_drawn_with_its_branches() {
        let text = summarise(&built_in("quarter-car").expect("a family"));
        let shown = "\
base
Chassis: joint 1 T3, 320 kg
├─ Lower_wishbone: joint 2 R1 at Lower_pivot [1], 6 kg
│  Knuckle: joint 3 R1 (dependent) at Ball [4], 9 kg
│  Wheel: joint 5 R2 at Hub [7], 18 kg
└─ Upper_wishbone: joint 4 R1 (dependent) at Upper_pivot [2], 4 kg
";
        assert!(text.contains(shown), "{text}");
        assert!(text.contains("around 3 joints"), "{text}");
        assert!(
            text.starts_with("suspension: 5 joints of 5 bodies, 357 kg"),
            "{text}"
        );
    }
}
