//! Poses: `pos`, and a rotation in one of five forms.

use super::{ClassIndex, MjcfReader};
use crate::robot::attributes::{numbers, place_of};
use crate::rotation::{FramePose, Rotation3, add, scaled, unit, upright};
use roxmltree::Node;

/// The attributes of rotations, with the number of their numbers.
const ROTATIONS: [(&str, usize); 5] = [
    ("quat", 4),
    ("axisangle", 4),
    ("xyaxes", 6),
    ("zaxis", 3),
    ("euler", 3),
];

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

impl<'a> MjcfReader<'a, '_> {
    /// The pose of an element in the frame around it.
    pub(super) fn pose(&mut self, node: Node<'a, 'a>, around: ClassIndex) -> FramePose {
        let class = self.defaults.class(node, "class", around, self.messages);
        FramePose {
            rotation: self.rotation(node, class),
            origin: self.vector(node, class, "pos", [0.0; 3]),
        }
    }

    /// Numbers of an attribute, or of its default.
    pub(super) fn numbers(
        &mut self,
        node: Node<'a, 'a>,
        class: ClassIndex,
        attribute: &str,
    ) -> Option<Vec<f64>> {
        let holder = self.defaults.holder(node, class, attribute)?;
        let owner = format!("the `{}`", node.tag_name().name());
        numbers(holder, attribute, &owner, self.messages)
    }

    /// The first number of an attribute, or of its default.
    pub(super) fn number(
        &mut self,
        node: Node<'a, 'a>,
        class: ClassIndex,
        attribute: &str,
    ) -> Option<f64> {
        self.numbers(node, class, attribute)?.first().copied()
    }

    /// Three numbers of an attribute, or of its default.
    pub(super) fn vector(
        &mut self,
        node: Node<'a, 'a>,
        class: ClassIndex,
        attribute: &str,
        otherwise: [f64; 3],
    ) -> [f64; 3] {
        let Some(values) = self.numbers(node, class, attribute) else {
            return otherwise;
        };
        values[..].try_into().unwrap_or_else(|_| {
            self.miscounted(node, attribute, values.len(), 3);
            otherwise
        })
    }

    /// Reports an attribute with a wrong number of numbers.
    pub(super) fn miscounted(
        &mut self,
        node: Node<'_, '_>,
        attribute: &str,
        found: usize,
        wanted: usize,
    ) {
        self.messages.error(
            place_of(node, attribute),
            &format!("'{attribute}' holds {found} numbers, and {wanted} are wanted"),
            "this attribute",
            "write the numbers with blanks between them",
        );
    }

    fn rotation(&mut self, node: Node<'a, 'a>, class: ClassIndex) -> Rotation3 {
        // A form in the element goes before another one in its class.
        let given = ROTATIONS.iter().find(|(name, _)| node.has_attribute(*name));
        let form = given.or_else(|| {
            let mut forms = ROTATIONS.iter();
            forms.find(|(name, _)| self.defaults.holder(node, class, name).is_some())
        });
        let Some(&(name, count)) = form else {
            return Rotation3::IDENTITY;
        };
        let Some(values) = self.numbers(node, class, name) else {
            return Rotation3::IDENTITY;
        };
        if values.len() != count {
            self.miscounted(node, name, values.len(), count);
            return Rotation3::IDENTITY;
        }
        self.rotation_of(name, &values).unwrap_or_else(|| {
            self.messages.error(
                place_of(node, name),
                &format!("'{name}' has no direction"),
                "its length is zero",
                "write a direction of any other length",
            );
            Rotation3::IDENTITY
        })
    }

    /// The rotation of numbers in a form; `None` without a direction.
    fn rotation_of(&self, form: &str, values: &[f64]) -> Option<Rotation3> {
        let vector = |from: usize| [values[from], values[from + 1], values[from + 2]];
        let settings = &self.settings;
        Some(match form {
            "quat" => {
                let quaternion = [values[0], values[1], values[2], values[3]];
                if quaternion == [0.0; 4] {
                    return None;
                }
                Rotation3::from_quaternion(quaternion)
            }
            "axisangle" => Rotation3::about_direction(unit(vector(0))?, settings.angle(values[3])),
            "xyaxes" => {
                let x = unit(vector(0))?;
                let y = vector(3);
                let y = unit(add(y, scaled(x, -dot(x, y))))?;
                let z = [1, 2, 0].map(|k: usize| x[k] * y[(k + 1) % 3] - x[(k + 1) % 3] * y[k]);
                Rotation3([0, 1, 2].map(|k| [x[k], y[k], z[k]]))
            }
            "zaxis" => upright(unit(vector(0))?),
            _ => {
                let mut rotation = Rotation3::IDENTITY;
                for (letter, angle) in settings.sequence.iter().zip(values) {
                    let axis = match letter.to_ascii_lowercase() {
                        'x' => crate::Axis::X,
                        'y' => crate::Axis::Y,
                        _ => crate::Axis::Z,
                    };
                    let turn = Rotation3::about(axis, settings.angle(*angle));
                    rotation = match letter.is_ascii_lowercase() {
                        true => rotation.then(&turn),
                        false => turn.then(&rotation),
                    };
                }
                rotation
            }
        })
    }
}
