//! The functions that Robotran makes of a model.

robovec_num::named! {
    /// Robotran's functions of a model.
    #[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
    pub enum FunctionKind {
        /// `M` and `c` of `M qdd + c = Qq` (F1).
        Dirdyna = "dirdyna",
        /// `Qq` for given accelerations (F2).
        Invdyna = "invdyna",
        /// The constraints `h` of loops and their Jacobian `Jac` (F8).
        ConsHJ = "cons_hJ",
        /// Rest of the constraints' second derivative, `Jdqd` (F18).
        ConsJdqd = "cons_jdqd",
        /// Forces of links, added to `frc` and `trq` (F7).
        Link = "link",
        /// External forces, added to `frc` and `trq` (F19).
        Extforces = "extforces",
        /// Sensors, one function each (F6).
        Sensor = "sensor",
        /// Everything about the frame of every joint, one function each (F6).
        Gensensor = "gensensor",
        /// Accelerations `qdd` for given joint forces (F10).
        Accelred = "accelred",
        /// Forces of actuators for given accelerations (F11).
        Invdynared = "invdynared",
        /// One round of Newton's method for the positions of dependent joints,
        /// and the constraints `h` before it.
        LoopPositions = "loop_positions",
        /// The velocities of dependent joints.
        LoopVelocities = "loop_velocities",
        /// Derivatives of inverse dynamics by positions and velocities.
        InvdynaD = "invdyna_d",
        /// Derivatives of forward dynamics, by all its inputs, loops left open.
        DirdynaD = "dirdyna_d",
        /// Derivatives of accelerations by all their inputs, loops closed.
        AccelD = "accel_d",
        /// Matrices of the linear system near a state, loops closed.
        Linear = "linear",
        /// The inverse of the mass matrix.
        Minv = "minv",
        /// The forces of inverse dynamics for a unit of each inertia of a body.
        Regressor = "regressor",
        /// Pose, motion and Jacobian of every named frame, a function each.
        Frame = "frame",
    }
}

impl FunctionKind {
    /// True when the result contains the forces of links, or takes them as
    /// given: links absent from a model are absent from the result.
    pub fn depends_on_link_forces(self) -> bool {
        match self {
            FunctionKind::Dirdyna
            | FunctionKind::Invdyna
            | FunctionKind::Link
            | FunctionKind::Accelred
            | FunctionKind::Invdynared
            | FunctionKind::InvdynaD
            | FunctionKind::DirdynaD
            | FunctionKind::AccelD
            | FunctionKind::Linear => true,
            FunctionKind::ConsHJ
            | FunctionKind::ConsJdqd
            | FunctionKind::Extforces
            | FunctionKind::Sensor
            | FunctionKind::Gensensor
            | FunctionKind::LoopPositions
            | FunctionKind::LoopVelocities
            | FunctionKind::Minv
            | FunctionKind::Regressor
            | FunctionKind::Frame => false,
        }
    }

    /// True for parts of the whole step that Robotran has on request or never.
    pub fn is_part_of_step(self) -> bool {
        matches!(
            self,
            FunctionKind::Accelred
                | FunctionKind::Invdynared
                | FunctionKind::LoopPositions
                | FunctionKind::LoopVelocities
        )
    }

    /// True for a function that is generated only when it is requested by name.
    pub fn is_special(self) -> bool {
        self.is_part_of_step() || self.is_derived() || self == FunctionKind::Frame
    }

    /// True for functions that Robotran does not have, such as derivatives.
    pub fn is_derived(self) -> bool {
        matches!(
            self,
            FunctionKind::InvdynaD
                | FunctionKind::DirdynaD
                | FunctionKind::AccelD
                | FunctionKind::Linear
                | FunctionKind::Minv
                | FunctionKind::Regressor
        )
    }

    /// Robotran's number; for parts about loops that of `accelred`.
    pub fn number(self) -> &'static str {
        match self {
            FunctionKind::Dirdyna => "F1",
            FunctionKind::Invdyna => "F2",
            FunctionKind::ConsHJ => "F8",
            FunctionKind::ConsJdqd => "F18",
            FunctionKind::Link => "F7",
            FunctionKind::Extforces => "F19",
            FunctionKind::Sensor | FunctionKind::Gensensor | FunctionKind::Frame => "F6",
            FunctionKind::Accelred
            | FunctionKind::LoopPositions
            | FunctionKind::LoopVelocities
            | FunctionKind::AccelD
            | FunctionKind::Linear => "F10",
            FunctionKind::Invdynared => "F11",
            FunctionKind::InvdynaD | FunctionKind::Regressor => "F2",
            FunctionKind::DirdynaD | FunctionKind::Minv => "F1",
        }
    }

    /// The function with the result of this name: as
    /// [`FunctionKind::from_name`], and `sensor_3` is the third result of
    /// `sensor`, `frame_tool0` that of the frame `tool0`.
    pub fn with_name(name: &str) -> Option<FunctionKind> {
        FunctionKind::from_name(name).or_else(|| FunctionKind::from_name(name.split_once('_')?.0))
    }
}
