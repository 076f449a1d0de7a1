//! Tendons: of fixed ones the equality of two joints, forces of others are
//! left out.

use super::{MjcfReader, children};
use crate::robot::attributes::{number, place_of};
use crate::xml::place;
use robovec_ir::diagnostic::clip;
use roxmltree::Node;

impl<'a> MjcfReader<'a, '_> {
    /// Names the tendons whose forces are in no equation.
    pub(super) fn tendons(&mut self, root: Node<'a, 'a>) {
        let tendons = children(root, "tendon").flat_map(|section| section.children());
        for tendon in tendons.filter(Node::is_element) {
            for attribute in ["stiffness", "damping", "frictionloss", "armature"] {
                let value = number(tendon, attribute, "the tendon", self.messages);
                if value.is_some_and(|value| value != 0.0) {
                    self.messages.leave_out(
                        place_of(tendon, attribute),
                        "the forces of a tendon are in no equation",
                        "passed over",
                        "add them to the forces of the joints",
                    );
                    break;
                }
            }
        }
    }

    /// An equality of a fixed tendon over two joints: one follows the other.
    pub(super) fn tendon_equality(&mut self, node: Node<'a, 'a>) {
        let name = node.attribute("tendon1").map(str::trim).unwrap_or_default();
        let root = node.document().root_element();
        let mut tendons = children(root, "tendon").flat_map(|section| section.children());
        let found = tendons.find(|tendon| tendon.attribute("name").map(str::trim) == Some(name));
        let joints: Vec<Node<'a, 'a>> = match found {
            Some(tendon) if tendon.tag_name().name() == "fixed" => {
                children(tendon, "joint").collect()
            }
            _ => Vec::new(),
        };
        let is_simple = !node.has_attribute("tendon2");
        let (&[one, other], true) = (joints.as_slice(), is_simple) else {
            self.messages.error(
                place(node),
                &format!("the equality of tendon '{}' is not supported", clip(name)),
                "only that of one fixed tendon over two joints is",
                "write it as an equality of joints, or remove it",
            );
            return;
        };
        let ends = [one, other].map(|end| {
            let name = end.attribute("joint").map(str::trim).unwrap_or_default();
            let coefficient = number(end, "coef", "the tendon", self.messages).unwrap_or(0.0);
            (self.named_joint(end, "joint", name), coefficient)
        });
        let [(Some(follower), own), (Some(leader), others)] = ends else {
            return;
        };
        if own == 0.0 {
            self.messages.error(
                place_of(one, "coef"),
                "the first joint of a tendon of an equality has no coefficient",
                "it could not follow the second one",
                "write a coefficient other than zero",
            );
            return;
        }
        // own (q - start) + others (p - before) is the constant of the polynomial.
        if let Some([constant, _]) = self.polynomial(node) {
            self.follow(node, (follower, leader), [constant / own, -others / own]);
        }
    }
}
