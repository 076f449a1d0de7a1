//! The files Robotran writes: what each function is called and given.
//!
//! Signatures are those of the current generator (MBsysTran 8.1), whose C
//! MBsysC compiles, with the Matlab ones of generator 6.6, the only one that
//! writes Matlab. Where Robotran has no such file in a language (`accelred`
//! in Matlab and Python) the signature is the natural counterpart.

use crate::robotran::Language;

/// What a file of equations is for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Kind {
    /// Its name in file names, `dirdyna`.
    pub(super) name: &'static str,
    /// Robotran's number of the function; 0 where it has none.
    pub(super) number: u32,
    /// What Robotran's header calls it, in our words.
    pub(super) title: &'static str,
    /// The arrays it fills, in the order of the signature, with the number of
    /// indices of each.
    pub(super) outputs: &'static [(&'static str, usize)],
}

/// All kinds.
pub(super) const KINDS: [Kind; 12] = [
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
];

const fn kind(
    name: &'static str,
    number: u32,
    title: &'static str,
    outputs: &'static [(&'static str, usize)],
) -> Kind {
    Kind {
        name,
        number,
        title,
        outputs,
    }
}

impl Kind {
    /// The kind of a name.
    pub(super) fn find(name: &str) -> Option<Kind> {
        KINDS.into_iter().find(|kind| kind.name == name)
    }

    /// True for the files that hold one case per sensor.
    pub(super) fn is_sensor(self) -> bool {
        matches!(self.name, "sensor" | "gensensor")
    }

    /// True when the function returns a status in C.
    pub(super) fn has_status(self) -> bool {
        matches!(self.name, "accelred" | "invdynared")
    }

    /// True when the function adds to the forces and torques it is given.
    pub(super) fn updates_forces(self) -> bool {
        self.outputs.first() == Some(&("frc", 2))
    }

    /// What the function is called in a language.
    pub(super) fn function_name(self, language: Language) -> String {
        match (language, self.name) {
            (Language::C, name) => format!("mbs_{name}"),
            // MBsysPy finds a `sensor` in both modules.
            (Language::Python, "gensensor") => "sensor".to_owned(),
            (Language::Matlab | Language::Python, name) => name.to_owned(),
        }
    }
}
