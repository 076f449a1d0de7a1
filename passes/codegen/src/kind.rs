//! The files Robotran writes: what each function is called and given.
//!
//! Signatures are those of the current generator (MBsysTran 8.1), whose C
//! MBsysC compiles. They are data here, so that every writer of files that
//! take the place of Robotran's agrees on them.

use robovec_ir::Function;

/// A kind of file of equations.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct EquationKind {
    /// Its name in file names, `dirdyna`.
    pub name: &'static str,
    /// Robotran's number of the function; 0 where it has none.
    pub number: u32,
    /// Its title: the name in Robotran's header, in our words.
    pub title: &'static str,
    /// The arrays it fills, in the order of the signature, with the number of
    /// indices of each.
    pub outputs: &'static [(&'static str, usize)],
}

/// All kinds.
pub const KINDS: [EquationKind; 15] = [
    kind(
        "dirdyna",
        1,
        "Direct Dynamics (mass matrix and non-linear forces)",
        &[("M", 2), ("c", 1)],
    ),
    kind("invdyna", 2, "Inverse Dynamics", &[("Qq", 1)]),
    kind("sensor", 6, "Sensors Kinematics", &[]),
    kind("gensensor", 6, "Sensors Kinematics of all frames", &[]),
    kind(
        "link",
        7,
        "Link Forces (1D)",
        &[("frc", 2), ("trq", 2), ("Flink", 1), ("Z", 1), ("Zd", 1)],
    ),
    kind("link3D", 27, "Link Forces (3D)", &[("frc", 2), ("trq", 2)]),
    kind(
        "cons_hJ",
        8,
        "Constraints and Constraints Jacobian (h, J)",
        &[("h", 1), ("Jac", 2)],
    ),
    kind(
        "cons_jdqd",
        18,
        "Constraints Quadratic Terms",
        &[("Jdqd", 1)],
    ),
    kind(
        "extforces",
        19,
        "External Forces",
        &[("frc", 2), ("trq", 2)],
    ),
    kind("accelred", 10, "Direct Dynamics (explicit)", &[]),
    kind("invdynared", 11, "Inverse Dynamics (reduced)", &[]),
    kind("dirdyna_odn", 0, "Direct Dynamics (order N)", &[]),
    kind(
        "loop_positions",
        0,
        "Positions of Dependent Joints (one round of Newton's method)",
        &[("h", 1)],
    ),
    kind("loop_velocities", 0, "Velocities of Dependent Joints", &[]),
    kind(
        "accelerations",
        0,
        "Accelerations of Closed Loops under Given Forces",
        &[],
    ),
];

const fn kind(
    name: &'static str,
    number: u32,
    title: &'static str,
    outputs: &'static [(&'static str, usize)],
) -> EquationKind {
    EquationKind {
        name,
        number,
        title,
        outputs,
    }
}

impl EquationKind {
    /// The kind of a name.
    pub fn find(name: &str) -> Option<EquationKind> {
        KINDS.into_iter().find(|kind| kind.name == name)
    }

    /// The kind of a function and, for sensors, its number: by what its
    /// metadata say of the file it came from, else by its name.
    pub fn of(function: &Function) -> Option<(EquationKind, Option<u32>)> {
        let name = function.name.strip_prefix("mbs_").unwrap_or(&function.name);
        let numbered = name
            .rsplit_once('_')
            .and_then(|(stem, digits)| Some((stem, digits.parse::<u32>().ok()?)));
        let by_name = match numbered {
            Some((stem, number))
                if EquationKind::find(stem).is_some_and(EquationKind::is_sensor) =>
            {
                EquationKind::find(stem).map(|kind| (kind, Some(number)))
            }
            _ => EquationKind::find(name).map(|kind| (kind, None)),
        };
        let by_file = function.metadata("kind").and_then(EquationKind::find);
        match (by_file, by_name) {
            // Python calls both kinds of sensors `sensor`.
            (Some(file), Some((named, number))) if file.is_sensor() && named.is_sensor() => {
                Some((file, number))
            }
            (_, Some(known)) => Some(known),
            (Some(file), None) if !file.is_sensor() => Some((file, None)),
            (_, None) => None,
        }
    }

    /// True for the files that hold one case per sensor.
    pub fn is_sensor(self) -> bool {
        matches!(self.name, "sensor" | "gensensor")
    }

    /// True when the function returns a status in C.
    pub fn has_status(self) -> bool {
        matches!(self.name, "accelred" | "invdynared")
    }

    /// True when the function adds to the forces and torques it is given.
    pub fn updates_forces(self) -> bool {
        self.outputs.first() == Some(&("frc", 2))
    }
}

/// A model's name as part of a file name: letters, digits, `-` and `_`;
/// `model` when nothing is left.
pub fn file_stem(model: &str) -> String {
    let word = |c: char| {
        if c.is_ascii_alphanumeric() || c == '-' {
            c
        } else {
            '_'
        }
    };
    let stem: String = model.trim().chars().map(word).collect();
    if stem.is_empty() {
        "model".to_owned()
    } else {
        stem
    }
}
