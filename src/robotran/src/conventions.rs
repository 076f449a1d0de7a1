//! Extents and order of Robotran's models and arrays.
//!
//! Reader, writer and generator share these tables: arrays are the same.

use robovec_num::limits::NumberLimit;

/// The largest number of joints of a model. The largest public models have
/// about a hundred, and the equations of a chain grow with the square.
pub const JOINT_LIMIT: usize = 2000;

/// Joints of a model.
pub const JOINTS: NumberLimit = NumberLimit::whole(
    0,
    JOINT_LIMIT as u64,
    "a mass matrix has as many rows and columns",
);

/// The inputs in the order in which Robotran's structure lists them.
pub const INPUT_ORDER: [&str; 11] = [
    "q", "qd", "qdd", "dpt", "l", "m", "In", "g", "frc", "trq", "lrod",
];

/// The fields of Robotran's structure of a sensor, in its order.
pub(crate) const SENSOR_FIELDS: [&str; 7] = [
    "sens.P", "sens.R", "sens.V", "sens.OM", "sens.A", "sens.OMP", "sens.J",
];

/// Rows and columns of an array as far as they follow from the number of
/// joints, 0 where they do not; `None` for an array of no known extent.
pub fn known_extent(name: &str, joints: u32) -> Option<(u32, u32)> {
    Some(match name {
        "q" | "qd" | "qdd" | "Qq" | "Qa" | "c" | "m" => (joints, 0),
        "l" | "frc" | "trq" => (3, joints),
        "In" => (9, joints),
        "M" | "Minv" | "Qq_q" | "Qq_qd" | "qdd_q" | "qdd_qd" | "qdd_Qq" => (joints, joints),
        "Y" => (joints, 10 * joints),
        "Jac" => (0, joints),
        "dpt" => (3, 0),
        "g" | "sens.P" | "sens.V" | "sens.OM" | "sens.A" | "sens.OMP" => (3, 0),
        "sens.R" => (3, 3),
        "sens.J" | "jacobian" | "jacobian_rate" => (6, joints),
        _ => return None,
    })
}

/// The same, zeros for an array of no known extent.
pub fn least_extent(name: &str, joints: u32) -> (u32, u32) {
    known_extent(name, joints).unwrap_or((0, 0))
}
