//! A model as peers read it: a tree of joints in plain text
//! (`benches/peers/peer.h` describes the format).

use robovec_model::Model;
use std::fmt::Write;

pub(super) fn text(model: &Model) -> String {
    let [x, y, z] = model.gravity;
    let mut text = format!(
        "robovec-tree 2\ngravity {x} {y} {z}\njoints {}\n",
        model.joints.len()
    );
    for (index, joint) in model.joints.iter().enumerate() {
        let body = &model.bodies[joint.body];
        // Mass and inertia belong to the last joint of a body.
        let last = body.joints.end == index + 1;
        let (mass, center, inertia) = if last {
            (body.mass, body.center, body.inertia)
        } else {
            (0.0, [0.0; 3], [0.0; 6])
        };
        let anchor = model.coordinates(joint.point);
        let parent = robovec_model::number(joint.parent);
        let sign = joint.mounting.sign();
        let _ = write!(text, "{parent} {} {sign}", joint.kind.name());
        let numbers = anchor
            .into_iter()
            .chain(joint.mounting.rotation().into_iter().flatten())
            .chain([mass])
            .chain(center)
            .chain(inertia);
        for number in numbers {
            // Writing to a string cannot fail.
            let _ = write!(text, " {number:e}");
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_model::family;

    #[test]
    fn every_joint_has_its_parent_before_it() {
        let model = family::random_tree(3, 12);
        let text = text(&model);
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("robovec-tree 2"));
        assert!(
            lines
                .next()
                .is_some_and(|line| line.starts_with("gravity "))
        );
        assert_eq!(lines.next(), Some("joints 12"));
        for (index, line) in lines.enumerate() {
            let words: Vec<&str> = line.split_whitespace().collect();
            assert_eq!(words.len(), 25, "{line}");
            let parent = words[0].parse::<usize>();
            assert!(parent.is_ok_and(|parent| parent <= index), "{line}");
            assert_eq!(words[1], model.joints[index].kind.name());
        }
    }
}
