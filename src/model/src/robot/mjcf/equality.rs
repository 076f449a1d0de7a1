//! Loops: the section `equality`. Tendons that no loop names are left out.
//!
//! | element | becomes |
//! |---|---|
//! | `connect` | a cut in which two points coincide |
//! | `weld` | a cut in which two frames coincide |
//! | `joint` | a joint that follows another one, if the polynomial is linear |
//! | `tendon` | the same, for a fixed tendon over two joints |

use super::{MjcfReader, children};
use crate::robot::attributes::{number, numbers, place_of, triple};
use crate::robot::elements::{ClosureElement, MimicElement, joint_title};
use crate::rotation::{FramePose, Rotation3};
use crate::xml::{Messages, is_usable, place};
use robovec_ir::diagnostic::{clip, suggestion};
use roxmltree::Node;
use rustc_hash::FxHashMap;

pub(super) type LinkPoint = (usize, FramePose);

impl<'a> MjcfReader<'a, '_> {
    pub(super) fn equalities(&mut self, section: Node<'a, 'a>) {
        let elements = section.children().filter(Node::is_element);
        for node in elements {
            if node
                .attribute("active")
                .is_some_and(|text| text.trim() == "false")
            {
                continue;
            }
            match node.tag_name().name() {
                "connect" | "weld" => self.closure(node),
                "joint" => {
                    let names = ["joint1", "joint2"].map(|name| self.reference(node, name));
                    let polynomial = self.polynomial(node);
                    if let ([Some(follower), Some(leader)], Some(polynomial)) = (names, polynomial)
                    {
                        self.follow(node, (follower, leader), polynomial);
                    }
                }
                "tendon" => self.tendon_equality(node),
                other => self.messages.error(
                    place(node),
                    &format!("an equality of kind `{}` is not supported", clip(other)),
                    "connect, weld, joint and tendon are",
                    "remove it, or write `active=\"false\"`",
                ),
            }
        }
    }

    /// The joint that an attribute names, an index.
    fn reference(&mut self, node: Node<'a, 'a>, attribute: &str) -> Option<usize> {
        let Some(name) = node.attribute(attribute).map(str::trim) else {
            self.messages.error(
                place(node),
                &format!("an equality of joints has no '{attribute}'"),
                "in this element",
                "name both joints; one that does not move can be held: --hold",
            );
            return None;
        };
        self.named_joint(node, attribute, name)
    }

    /// The joint of a name, an index.
    pub(super) fn named_joint(
        &mut self,
        node: Node<'a, 'a>,
        attribute: &str,
        name: &str,
    ) -> Option<usize> {
        match self.joints.get(name) {
            Some(&joint) if self.robot.joints[joint].kind.has_axis() => Some(joint),
            Some(_) => {
                self.messages.error(
                    place_of(node, attribute),
                    &format!("{} has several axes", joint_title(name)),
                    "only a joint of one axis has a position",
                    "name a hinge or a slide",
                );
                None
            }
            None => {
                let help = advice(&self.joints, name, "joint");
                self.messages.error(
                    place_of(node, attribute),
                    &format!("{} is not there", joint_title(name)),
                    "there is no joint of this name",
                    &help,
                );
                None
            }
        }
    }

    /// Constant and slope of the polynomial of an equality.
    pub(super) fn polynomial(&mut self, node: Node<'a, 'a>) -> Option<[f64; 2]> {
        let given = numbers(node, "polycoef", "the equality", self.messages);
        let given = given.unwrap_or_else(|| vec![0.0, 1.0]);
        if given.iter().skip(2).any(|&x| x != 0.0) {
            self.messages.error(
                place_of(node, "polycoef"),
                "this equality of joints is not linear",
                "coefficients beyond the second one",
                "only `polycoef=\"a b 0 0 0\"` is supported",
            );
            return None;
        }
        Some([0, 1].map(|index| given.get(index).copied().unwrap_or(0.0)))
    }

    /// Lets a joint follow another one: constant and slope times its way.
    pub(super) fn follow(
        &mut self,
        node: Node<'a, 'a>,
        (follower, leader): (usize, usize),
        [constant, slope]: [f64; 2],
    ) {
        let [start, before] = [follower, leader].map(|joint| self.robot.joints[joint].initial[0]);
        let mimic = MimicElement {
            leader: self.robot.joints[leader].name.clone(),
            factor: slope,
            offset: constant + start - slope * before,
            place: place(node),
        };
        let follower = &mut self.robot.joints[follower];
        if follower.mimic.is_some() {
            self.messages.error(
                place(node),
                &format!("{} follows two joints", joint_title(&follower.name)),
                "the second equality of this joint",
                "exchange the joints of one of them, or remove it",
            );
        }
        follower.mimic = Some(mimic);
    }

    fn closure(&mut self, node: Node<'a, 'a>) {
        let is_solid = node.tag_name().name() == "weld";
        let kind = if is_solid { "weld" } else { "connect" };
        let ends = match node.has_attribute("site1") {
            true => ["site1", "site2"].map(|attribute| {
                let name = node.attribute(attribute).map_or("", str::trim);
                end(
                    &self.sites,
                    (node, attribute),
                    ("site", name),
                    self.messages,
                )
            }),
            false => self.ends_on_bodies(node, is_solid),
        };
        let [Some(first), Some(second)] = ends else {
            return;
        };
        let given = node.attribute("name").map(str::trim).unwrap_or_default();
        let mut name = given.to_owned();
        if !is_usable(given) || self.loops.contains(given) {
            let numbers = self.loops.len() + 1..;
            let mut names = numbers.map(|number| format!("{kind}{number}"));
            let free = names.find(|name| !self.loops.contains(name));
            name = free.expect("there are more numbers than loops");
        }
        self.loops.insert(name.clone());
        self.robot.closures.push(ClosureElement {
            name,
            is_solid,
            ends: [first, second],
        });
    }

    fn ends_on_bodies(&mut self, node: Node<'a, 'a>, is_solid: bool) -> [Option<LinkPoint>; 2] {
        // Without a second body the loop is closed on the world.
        let ends = [("body1", ""), ("body2", "world")].map(|(attribute, otherwise)| {
            let name = node.attribute(attribute).map_or(otherwise, str::trim);
            end(
                &self.bodies,
                (node, attribute),
                ("body", name),
                self.messages,
            )
        });
        let [Some(first), Some(second)] = ends else {
            return [None; 2];
        };
        let owner = "the equality";
        let anchor = FramePose::at(triple(node, "anchor", owner, [0.0; 3], self.messages));
        let apart = self.start[first].inverse().then(&self.start[second]);
        if !is_solid {
            // The anchor is on the first body; the second one has it at the start.
            let other = apart.inverse().then(&anchor);
            let ends = [(first, anchor), (second, FramePose::at(other.origin))];
            return ends.map(Some);
        }
        let relative = match numbers(node, "relpose", owner, self.messages).as_deref() {
            Some(&[x, y, z, a, b, c, d]) if [a, b, c, d] != [0.0; 4] => FramePose {
                rotation: Rotation3::from_quaternion([a, b, c, d]),
                origin: [x, y, z],
            },
            _ => apart,
        };
        [
            Some((first, relative.then(&anchor))),
            Some((second, anchor)),
        ]
    }
}

/// The element that an end of a loop names; `None`, with an error, for none.
fn end<T: Copy>(
    known: &FxHashMap<String, T>,
    (node, attribute): (Node<'_, '_>, &str),
    (noun, name): (&str, &str),
    messages: &mut Messages,
) -> Option<T> {
    let found = known.get(name).copied();
    if found.is_none() {
        messages.error(
            place_of(node, attribute),
            &format!("there is no {noun} '{}'", clip(name)),
            "one end of a loop",
            &advice(known, name, noun),
        );
    }
    found
}

/// Advice about a name that is not there.
fn advice<T>(known: &FxHashMap<String, T>, name: &str, noun: &str) -> String {
    let mut names: Vec<&str> = known.keys().map(String::as_str).collect();
    names.sort_unstable();
    suggestion(name, names).unwrap_or_else(|| format!("name a {noun} of the model"))
}

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
