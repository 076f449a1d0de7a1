//! Kinds of files of equations, Robotran's and ours: the name and arguments of
//! each function.
//!
//! Robotran's signatures are those of the current generator (MBsysTran 8.1),
//! whose C MBsysC compiles; [`Generation`] has what differs before it. They are
//! data here, so that all writers of replacements agree on them.

use robovec_framework::differentiation;
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
    /// The array arguments, in the order of the signature, with the number of
    /// indices of each: the outputs, and for the parts of a whole step also the
    /// results of the user's constraints.
    pub outputs: &'static [(&'static str, usize)],
}

/// All kinds.
pub const KINDS: [EquationKind; 22] = [
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
        &[("h", 1), ("huserc", 1), ("Juserc", 2)],
    ),
    kind(
        "loop_velocities",
        0,
        "Velocities of Dependent Joints",
        &[("Juserc", 2)],
    ),
    kind(
        "accelerations",
        0,
        "Accelerations of Closed Loops under Given Forces",
        &[
            ("Lambda", 1),
            ("Growth", 1),
            ("Juserc", 2),
            ("jdqduserc", 1),
        ],
    ),
    kind(
        "actuator_forces",
        0,
        "Forces of Actuators for Given Accelerations",
        &[("Juserc", 2), ("jdqduserc", 1)],
    ),
    kind(
        "invdyna_d",
        0,
        "Derivatives of Inverse Dynamics by Positions and Velocities",
        &[("Qq_q", 2), ("Qq_qd", 2)],
    ),
    kind(
        "dirdyna_d",
        0,
        "Derivatives of Direct Dynamics by Positions, Velocities and Forces",
        &[("qdd_q", 2), ("qdd_qd", 2), ("qdd_Qq", 2)],
    ),
    kind(
        "accel_d",
        0,
        "Derivatives of Accelerations of Closed Loops by Positions, Velocities and Forces",
        &[("qdd_q", 2), ("qdd_qd", 2), ("qdd_Qq", 2)],
    ),
    kind(
        "linear",
        0,
        "Linear System near a State",
        &[("A", 2), ("B", 2)],
    ),
    kind("minv", 0, "Inverse of the Mass Matrix", &[("Minv", 2)]),
    kind(
        "regressor",
        0,
        "Forces of Inverse Dynamics by Inertias of Bodies",
        &[("Y", 2)],
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

/// The name of a function without the prefix of newer generators.
pub fn bare_name(name: &str) -> &str {
    name.strip_prefix("mbs_").unwrap_or(name)
}

/// The name of the model of a function.
pub fn model_name(function: &Function) -> &str {
    function.metadata("model").unwrap_or("model")
}

impl EquationKind {
    /// The kind of a name.
    pub fn find(name: &str) -> Option<EquationKind> {
        KINDS.into_iter().find(|kind| kind.name == name)
    }

    /// The kind of a function and, for sensors, its number: from the original
    /// file name in its metadata, else from its name. A function that was
    /// differentiated has other arrays and is of no kind.
    pub fn of(function: &Function) -> Option<(EquationKind, Option<u32>)> {
        if function.metadata(differentiation::KEY).is_some() {
            return None;
        }
        let name = bare_name(&function.name);
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

/// The generator whose C a project uses: names changed between them.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum Generation {
    /// MBsysTran 8.1, of 2015: `mbs_dirdyna(…, MbsData *s, …)`.
    #[default]
    Current,
    /// ROBOTRAN 6.6, of 2008: `dirdyna(…, MBSdataStruct *s, …)`.
    Old,
}

/// Name of a function's project structure in the metadata.
const STRUCTURE: &str = "structure";

impl Generation {
    /// The generation that a function's file was written for: the current one,
    /// unless its metadata have `structure "MBSdataStruct"`.
    pub fn of(function: &Function) -> Generation {
        match function.metadata(STRUCTURE) {
            Some(name) if name == Generation::Old.structure().name => Generation::Old,
            Some(_) | None => Generation::Current,
        }
    }

    /// Writes a function for this generation from now on.
    pub fn mark(self, function: &mut Function) {
        function.metadata.retain(|(key, _)| key != STRUCTURE);
        if self == Generation::Old {
            let name = self.structure().name.to_owned();
            function.metadata.push((STRUCTURE.to_owned(), name));
        }
    }

    /// The names of its projects.
    pub fn structure(self) -> ProjectStructure {
        match self {
            Generation::Current => ProjectStructure {
                name: "MbsData",
                sensor: "MbsSensor",
                header: "mbs_data.h",
                functions: "mbs_project_interface.h",
                prefix: "mbs_",
            },
            Generation::Old => ProjectStructure {
                name: "MBSdataStruct",
                sensor: "MBSsensorStruct",
                header: "MBSdataStructR7.h",
                functions: "MBSfunR7.h",
                prefix: "",
            },
        }
    }
}

/// The names in a project of MBsysC of the structures that functions use.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ProjectStructure {
    /// The structure with the data of the model.
    pub name: &'static str,
    /// The structure of a sensor.
    pub sensor: &'static str,
    /// The header that declares the data.
    pub header: &'static str,
    /// The header that declares the functions of equations and user.
    pub functions: &'static str,
    /// Prefix of the names of functions.
    pub prefix: &'static str,
}

impl ProjectStructure {
    /// The names of the project that a function was written for.
    pub fn of(function: &Function) -> ProjectStructure {
        Generation::of(function).structure()
    }
}

/// A model's name as part of a file name: letters, digits and `-`, `_` in place
/// of other characters; `model` for an empty name.
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
