//! Properties of a module for which Robotran's files have no words.

/// Property for which Robotran's files have no words.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum RobotranWriteError {
    /// There is no function to write.
    #[error("there is no function to write")]
    Empty,
    /// The function is of no kind that Robotran writes.
    #[error(
        "the function '{function}' is not one that Robotran writes (dirdyna, invdyna, sensor_1, …)"
    )]
    Kind {
        /// The function.
        function: String,
    },
    /// The function is a piece of one with loops, which the file does not hold.
    #[error(
        "the function '{function}' is one part of a function with loops; the loops themselves are not in the module"
    )]
    Part {
        /// The function.
        function: String,
    },
    /// Two functions would go to the same place.
    #[error("the functions '{first}' and '{second}' would be written to the same place")]
    Twice {
        /// The one.
        first: String,
        /// The other.
        second: String,
    },
    /// An array cannot have its name in the language.
    #[error(
        "the array '{array}' of '{function}' has a name that is not possible in {language}: rename it"
    )]
    ArrayName {
        /// The function.
        function: String,
        /// The array.
        array: String,
        /// The language.
        language: &'static str,
    },
    /// A single number is given back other than to a user function.
    #[error(
        "the output '{output}' of '{function}' is a single number; Robotran's functions return arrays only"
    )]
    ScalarOutput {
        /// The function.
        function: String,
        /// The output.
        output: String,
    },
    /// A sensor function sets an output other than the sensor.
    #[error(
        "the output '{output}' of '{function}' is not a field of the sensor, and a sensor function returns only those"
    )]
    SensorOutput {
        /// The function.
        function: String,
        /// The output.
        output: String,
    },
    /// A call that is not one of a user function.
    #[error("'{function}' calls '{callee}' in a way that Robotran's files cannot express")]
    Call {
        /// The function.
        function: String,
        /// The function called.
        callee: String,
    },
    /// A call needs its own result, or that of a later one.
    #[error(
        "in '{function}' the arguments of '{callee}' depend on the result of this or of a later call"
    )]
    CallOrder {
        /// The function.
        function: String,
        /// The function called.
        callee: String,
    },
    /// A number that cannot be written.
    #[error("'{function}' holds a number that is not finite")]
    Number {
        /// The function.
        function: String,
    },
    /// A function in parts has no signature of Robotran's.
    #[error(transparent)]
    Signature(#[from] robovec_cgen::c::SignatureError),
    /// A case that is no sensor number.
    #[error("'{function}' has no sensor number: its name must end in _1, _2, …")]
    Case {
        /// The function.
        function: String,
    },
}
