//! The `inertial` of a link.

use crate::robot::attributes::{children, place_in, read_pose, required, value_of};
use crate::robot::inertia::LinkInertial;
use crate::xml::{Messages, place};
use roxmltree::Node;

/// Reads an `inertial`.
pub(super) fn read_inertial(
    node: Node<'_, '_>,
    (title, right_angle): (&str, f64),
    messages: &mut Messages,
) -> LinkInertial {
    let [origin, mass, inertia] = children(node, ["origin", "mass", "inertia"], messages);
    let value = value_of(node, mass, ("mass", title), messages);
    if value < 0.0 {
        let at = place_in(node, mass, "value");
        messages.error(
            at,
            &format!("the mass of {title} is negative"),
            "this mass",
            "a mass is zero or positive, in kilograms",
        );
    }
    let entries = match inertia {
        Some(inertia) => {
            let owner = format!("the inertia of {title}");
            ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]
                .map(|entry| required(inertia, entry, &owner, messages))
        }
        None => {
            messages.error(
                place(node),
                &format!("{title} has no `inertia`"),
                "in this element",
                "add `<inertia ixx=\"…\" ixy=\"0\" ixz=\"0\" iyy=\"…\" iyz=\"0\" izz=\"…\"/>`",
            );
            [0.0; 6]
        }
    };
    LinkInertial {
        mass: value,
        origin: read_pose(origin, (title, right_angle), messages),
        inertia: entries,
        place: inertia.map_or(place(node), place),
    }
}
