//! Tasks where there is a model: the functions that others offer as well.

use super::contestant::ContestantFamily;
use super::functions::OutputKey;
use robovec_dynamics::generate::Formulation;
use robovec_model::{Model, Nature};
use robovec_robotran::FunctionKind;

/// A function of a model that peers know.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum BenchTask {
    /// Mass matrix and forces.
    #[default]
    Dirdyna,
    /// Forces of joints, of accelerations.
    Invdyna,
    /// Accelerations, of forces of joints.
    Accelred,
    /// Derivatives of the forces of joints by positions and velocities.
    InvdynaD,
    /// Derivatives of accelerations by positions, velocities and forces.
    DirdynaD,
}

impl BenchTask {
    /// All tasks.
    pub const ALL: [BenchTask; 5] = [
        BenchTask::Dirdyna,
        BenchTask::Invdyna,
        BenchTask::Accelred,
        BenchTask::InvdynaD,
        BenchTask::DirdynaD,
    ];

    /// The function that Robotran and the generator call so.
    pub fn kind(self) -> FunctionKind {
        match self {
            BenchTask::Dirdyna => FunctionKind::Dirdyna,
            BenchTask::Invdyna => FunctionKind::Invdyna,
            BenchTask::Accelred => FunctionKind::Accelred,
            BenchTask::InvdynaD => FunctionKind::InvdynaD,
            BenchTask::DirdynaD => FunctionKind::DirdynaD,
        }
    }

    /// The name on the command line, in files, and for peers.
    pub fn name(self) -> &'static str {
        self.kind().name()
    }

    /// True for derivatives, which not all peers offer.
    pub fn is_derivative(self) -> bool {
        matches!(self, BenchTask::InvdynaD | BenchTask::DirdynaD)
    }

    /// Title where robots are concerned.
    pub fn title(self) -> &'static str {
        match self {
            BenchTask::Dirdyna => "M and c",
            BenchTask::Invdyna => "inverse dynamics",
            BenchTask::Accelred => "forward dynamics",
            BenchTask::InvdynaD => "derivatives of inverse dynamics",
            BenchTask::DirdynaD => "derivatives of forward dynamics",
        }
    }

    /// The task of a function with this name, if it is one.
    pub fn with_name(name: &str) -> Option<BenchTask> {
        BenchTask::ALL.into_iter().find(|task| task.name() == name)
    }

    /// The formulations that can have the fewest operations. Those that
    /// combine paths by networks buy short paths with operations, and of
    /// formulations that give the same equations one is enough.
    pub fn formulations(self) -> &'static [Formulation] {
        match self {
            BenchTask::Dirdyna => &[Formulation::Composite, Formulation::CompositeBase],
            BenchTask::Invdyna => &[Formulation::Recursive, Formulation::Composite],
            BenchTask::Accelred => &[
                Formulation::Recursive,
                Formulation::Composite,
                Formulation::CompositeBase,
                Formulation::Articulated,
            ],
            // There is one kind, by composites.
            BenchTask::InvdynaD | BenchTask::DirdynaD => &[Formulation::Composite],
        }
    }

    /// The input array that peers need besides positions and velocities.
    pub(super) fn given(self) -> Option<&'static str> {
        match self {
            BenchTask::Dirdyna => None,
            BenchTask::Invdyna | BenchTask::InvdynaD => Some("qdd"),
            BenchTask::Accelred | BenchTask::DirdynaD => Some("Qq"),
        }
    }

    /// Outputs that peers write for a state: full matrices, then the vector.
    pub(super) fn outputs(self, joints: u32) -> Vec<OutputKey> {
        let vector = |array: &str| -> Vec<OutputKey> {
            let key = |row| OutputKey {
                array: array.to_owned(),
                indices: [row, 0],
            };
            (1..=joints).map(key).collect()
        };
        let matrices = |arrays: &[&str]| -> Vec<OutputKey> {
            let matrix = |array: &&str| {
                let array = (*array).to_owned();
                (1..=joints).flat_map(move |row| {
                    let array = array.clone();
                    (1..=joints).map(move |column| OutputKey {
                        array: array.clone(),
                        indices: [row, column],
                    })
                })
            };
            arrays.iter().flat_map(matrix).collect()
        };
        match self {
            BenchTask::Dirdyna => [matrices(&["M"]), vector("c")].concat(),
            BenchTask::Invdyna => vector("Qq"),
            BenchTask::Accelred => vector("qdd"),
            BenchTask::InvdynaD => matrices(&["Qq_q", "Qq_qd"]),
            BenchTask::DirdynaD => matrices(&["qdd_q", "qdd_qd", "qdd_Qq"]),
        }
    }

    /// The largest difference that is rounding; a wrong result is off by far
    /// more. Other formulas round otherwise, and accelerations are solutions
    /// of linear equations, whose condition multiplies every rounding.
    pub fn tolerance(self, family: ContestantFamily) -> f64 {
        let formulas = match family {
            ContestantFamily::Peer => 1e-9,
            ContestantFamily::Robotran | ContestantFamily::Equations | ContestantFamily::Model => {
                1e-12
            }
        };
        match self {
            BenchTask::Dirdyna | BenchTask::Invdyna | BenchTask::InvdynaD => formulas,
            BenchTask::Accelred | BenchTask::DirdynaD => 1e3 * formulas,
        }
    }

    /// Reason why peers, which know trees of free joints, differ for a model.
    pub(super) fn unknown_to_peers(self, model: &Model) -> Option<&'static str> {
        let is_driven = |nature: Nature| nature == Nature::Driven;
        match self {
            BenchTask::Dirdyna | BenchTask::Invdyna | BenchTask::InvdynaD => None,
            BenchTask::Accelred if !model.cuts.is_empty() => {
                Some("the model has loops, which it does not close here")
            }
            BenchTask::Accelred | BenchTask::DirdynaD
                if model.joints.iter().any(|joint| is_driven(joint.nature)) =>
            {
                Some("the model has driven joints, whose forces are unknown")
            }
            BenchTask::Accelred | BenchTask::DirdynaD => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_model::family;

    #[test]
    fn tasks_are_functions_of_robotrans() {
        for task in BenchTask::ALL {
            assert_eq!(BenchTask::with_name(task.name()), Some(task));
            assert_eq!(FunctionKind::from_name(task.name()), Some(task.kind()));
        }
        assert_eq!(BenchTask::with_name("cons_hJ"), None);
        assert_eq!(BenchTask::with_name("dirdyna_1"), None);
    }

    #[test]
    fn formulations_of_a_task_give_its_function() {
        for task in BenchTask::ALL {
            let mut formulations = task.formulations().iter();
            assert!(formulations.all(|formulation| formulation.gives(task.kind())));
        }
    }

    #[test]
    fn peers_write_a_full_matrix_and_vectors() {
        let names = |task: BenchTask| -> Vec<String> {
            task.outputs(2).iter().map(ToString::to_string).collect()
        };
        let direct = ["M[1,1]", "M[1,2]", "M[2,1]", "M[2,2]", "c[1]", "c[2]"];
        assert_eq!(names(BenchTask::Dirdyna), direct);
        assert_eq!(names(BenchTask::Invdyna), ["Qq[1]", "Qq[2]"]);
        assert_eq!(names(BenchTask::Accelred), ["qdd[1]", "qdd[2]"]);
    }

    #[test]
    fn only_accelerations_ask_for_free_joints() {
        let mut model = family::random_tree(3, 4);
        for task in BenchTask::ALL {
            assert_eq!(task.unknown_to_peers(&model), None);
        }
        model.joints[1].nature = Nature::Driven;
        assert!(BenchTask::Accelred.unknown_to_peers(&model).is_some());
        assert_eq!(BenchTask::Invdyna.unknown_to_peers(&model), None);
    }
}
