//! The convention of programs for derivatives: which of their arrays holds
//! the derivative of which output by which input.
//!
//! The pass that makes such programs follows it, and so, on its own, does the
//! check. Arrays that were inputs keep their positions and new ones follow;
//! outputs that are kept come first. Elements of a matrix count row by row.
//!
//! | result | new inputs | new outputs |
//! |---|---|---|
//! | `jacobian` | | `F_x`, for every output `F` and input `x`: a row for each element of `F`, a column for each element of `x` |
//! | `direction` | `x_direction` | `F_direction`: Jacobian times direction |
//! | `gradient` | `F_weight` | `x_gradient`: transposed Jacobian times weights |

use crate::option_words;
use crate::options::{OptionValue, joined_names};
use robovec_ir::{Array, Function, MAX_INPUT_ELEMENTS, MAX_OUTPUT_ELEMENTS, Shape, View};

/// The key of the metadata that shows which derivatives a function computes.
pub const KEY: &str = "derivative";

/// The requested derivative of a function.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Differentiation {
    /// The output arrays that are differentiated.
    pub of: ArrayChoice,
    /// The input arrays they are differentiated by.
    pub by: ArrayChoice,
    /// Part of the Jacobian that is computed.
    pub result: DerivativeResult,
    /// True if the outputs of the function stay outputs. Arguments of user
    /// functions always do.
    pub values: bool,
}

option_words! {
    /// Part of a Jacobian that is computed.
    pub enum DerivativeResult {
        /// All of its elements.
        Jacobian = "jacobian",
        /// Its product with a direction of the inputs.
        Direction = "direction",
        /// The product of the derivatives with weights of the outputs.
        Gradient = "gradient",
    }
}

/// Arrays as an option: joined by `+`, or `all`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum ArrayChoice {
    /// Every array.
    All,
    /// The arrays of these names.
    Named(Vec<String>),
}

impl OptionValue for ArrayChoice {
    fn type_name() -> String {
        "all | NAME+NAME+...".to_owned()
    }
    fn parse(text: &str) -> Result<ArrayChoice, String> {
        match text {
            "all" => Ok(ArrayChoice::All),
            text => joined_names(text).map(ArrayChoice::Named),
        }
    }
    fn print(&self) -> String {
        match self {
            ArrayChoice::All => "all".to_owned(),
            ArrayChoice::Named(names) => names.join("+"),
        }
    }
}

/// The reason why a function has no such derivative.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum DifferentiationError {
    /// An array was named that the function does not have.
    #[error("there is no {kind} array '{name}'")]
    NoArray {
        /// `input` or `output`.
        kind: &'static str,
        /// The name.
        name: String,
        /// The arrays that exist.
        known: Vec<String>,
    },
    /// There is no output to differentiate, or no input to differentiate by.
    #[error("the function has no {kind} elements")]
    Nothing {
        /// `input` or `output`.
        kind: &'static str,
    },
    /// An array of the derivative would have the name of another.
    #[error("the array '{0}' of the derivative has the name of another array")]
    Taken(String),
    /// The arrays have more elements than the limit for a function.
    #[error("the derivative has {needed} {kind} elements, and a function has at most {most}")]
    TooMany {
        /// `input` or `output`.
        kind: &'static str,
        /// The elements needed.
        needed: u64,
        /// The elements allowed.
        most: u64,
    },
}

impl DifferentiationError {
    /// Advice for the user.
    pub fn help(&self) -> String {
        match self {
            DifferentiationError::NoArray { kind, known, .. } => {
                if known.is_empty() {
                    format!("the function has no {kind} arrays")
                } else {
                    format!("the {kind} arrays are {}", known.join(", "))
                }
            }
            DifferentiationError::Nothing { .. } => {
                "a derivative needs an output and an input".to_owned()
            }
            DifferentiationError::Taken(_) => {
                "drop the outputs of the function with 'values=false', or choose other arrays with \
                 'of' and 'by'"
                    .to_owned()
            }
            DifferentiationError::TooMany { .. } => {
                "choose fewer arrays with 'of' and 'by'; 'result=direction' and 'result=gradient' \
                 have one element where a Jacobian has a row or a column"
                    .to_owned()
            }
        }
    }
}

/// The arrays of a derivative, and the places of its elements.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct DerivativeArrays {
    /// The arrays differentiated, in order of declaration.
    pub of: Vec<Array>,
    /// The arrays differentiated by, in order of declaration.
    pub by: Vec<Array>,
    /// The output arrays that stay.
    pub kept: Vec<Array>,
    /// The input arrays that follow those of the function.
    pub inputs: Vec<(String, Shape)>,
    /// The output arrays that follow those that stay.
    pub outputs: Vec<(String, Shape)>,
}

impl Differentiation {
    /// The arrays of this derivative of a function.
    ///
    /// # Errors
    ///
    /// See [`DifferentiationError`].
    pub fn arrays(&self, view: View<'_>) -> Result<DerivativeArrays, DifferentiationError> {
        let function = view.function;
        let of = chosen(view, &self.of, function.outputs(), "output")?;
        let by = chosen(view, &self.by, function.inputs(), "input")?;
        let text = |array: &Array| view.tables.symbols.text(array.name);
        let kept = function.outputs().iter().copied();
        let kept: Vec<Array> = kept
            .filter(|array| self.values || is_argument(function, text(array)))
            .collect();
        let named = |arrays: &[Array], ending: &str| -> Vec<(String, Shape)> {
            let name = |array: &Array| (format!("{}{ending}", text(array)), array.shape);
            arrays.iter().map(name).collect()
        };
        let (inputs, outputs) = match self.result {
            DerivativeResult::Jacobian => {
                let pairs = of.iter().flat_map(|of| by.iter().map(move |by| (of, by)));
                let outputs = pairs.map(|(of, by)| {
                    let name = format!("{}_{}", text(of), text(by));
                    (name, jacobian_shape(of.shape, by.shape))
                });
                (Vec::new(), outputs.collect())
            }
            DerivativeResult::Direction => (named(&by, "_direction"), named(&of, "_direction")),
            DerivativeResult::Gradient => (named(&of, "_weight"), named(&by, "_gradient")),
        };
        let arrays = DerivativeArrays {
            of,
            by,
            kept,
            inputs,
            outputs,
        };
        arrays.refuse_taken(view)?;
        arrays.refuse_many(function)?;
        Ok(arrays)
    }
}

/// True for an output array that a user function is called with.
fn is_argument(function: &Function, name: &str) -> bool {
    let boundaries = function.boundaries.iter();
    let mut arguments = boundaries.flat_map(|boundary| &boundary.arguments);
    arguments.any(|argument| argument == name)
}

/// The extent of the derivative of one array by another. A scalar takes no
/// dimension.
fn jacobian_shape(of: Shape, by: Shape) -> Shape {
    match (of, by) {
        (Shape::Scalar, by) => by,
        (of, Shape::Scalar) => of,
        (of, by) => Shape::Matrix(of.len() as u32, by.len() as u32),
    }
}

fn chosen(
    view: View<'_>,
    choice: &ArrayChoice,
    arrays: &[Array],
    kind: &'static str,
) -> Result<Vec<Array>, DifferentiationError> {
    let text = |array: &Array| view.tables.symbols.text(array.name);
    let wanted = |array: &&Array| match choice {
        ArrayChoice::All => true,
        ArrayChoice::Named(names) => names.iter().any(|name| name == text(array)),
    };
    if let ArrayChoice::Named(names) = choice
        && let Some(name) = names
            .iter()
            .find(|&name| !arrays.iter().any(|array| text(array) == name))
    {
        return Err(DifferentiationError::NoArray {
            kind,
            name: name.clone(),
            known: arrays.iter().map(|array| text(array).to_owned()).collect(),
        });
    }
    let found: Vec<Array> = arrays.iter().filter(wanted).copied().collect();
    if found.iter().all(|array| array.shape.is_empty()) {
        Err(DifferentiationError::Nothing { kind })
    } else {
        Ok(found)
    }
}

impl DerivativeArrays {
    fn refuse_taken(&self, view: View<'_>) -> Result<(), DifferentiationError> {
        let old = view.function.inputs().iter().chain(&self.kept);
        let old = old.map(|array| view.tables.symbols.text(array.name));
        let new = self.inputs.iter().chain(&self.outputs);
        let mut new: Vec<&str> = new.map(|(name, _)| name.as_str()).collect();
        new.sort_unstable();
        let twice = new.windows(2).find(|pair| pair[0] == pair[1]);
        let taken = twice.map(|pair| pair[0]).or_else(|| {
            let mut old = old;
            old.find(|name| new.binary_search(name).is_ok())
        });
        match taken {
            Some(name) => Err(DifferentiationError::Taken(name.to_owned())),
            None => Ok(()),
        }
    }

    fn refuse_many(&self, function: &Function) -> Result<(), DifferentiationError> {
        let sum = |arrays: &[(String, Shape)]| {
            let sizes = arrays.iter().map(|(_, shape)| shape.len() as u64);
            sizes.fold(0, u64::saturating_add)
        };
        let inputs = sum(&self.inputs).saturating_add(function.input_len() as u64);
        let outputs = sum(&self.outputs).saturating_add(self.kept_len() as u64);
        let sizes = [
            ("input", inputs, MAX_INPUT_ELEMENTS),
            ("output", outputs, MAX_OUTPUT_ELEMENTS),
        ];
        match sizes.into_iter().find(|(_, needed, most)| needed > most) {
            Some((kind, needed, most)) => Err(DifferentiationError::TooMany { kind, needed, most }),
            None => Ok(()),
        }
    }

    /// The number of elements of the output arrays that stay; those of the
    /// derivative follow.
    pub fn kept_len(&self) -> usize {
        self.kept.iter().map(|array| array.shape.len()).sum()
    }

    /// The output elements of the function that are differentiated, in order.
    pub fn rows(&self) -> Vec<u32> {
        elements(&self.of)
    }

    /// The input elements of the function that they are differentiated by,
    /// in order.
    pub fn columns(&self) -> Vec<u32> {
        elements(&self.by)
    }

    /// Place of the elements of a Jacobian among the outputs of the
    /// program: for every row, by its place in [`rows`](Self::rows), the places
    /// of the columns of [`columns`](Self::columns).
    pub fn jacobian(&self) -> impl Iterator<Item = impl Iterator<Item = u32> + '_> + '_ {
        let columns: usize = self.by.iter().map(|array| array.shape.len()).sum();
        let mut block = self.kept_len();
        let blocks = self.of.iter().map(move |of| {
            let first = block;
            block += of.shape.len() * columns;
            (first, of.shape.len())
        });
        blocks.flat_map(move |(first, rows)| {
            (0..rows).map(move |row| {
                let mut array = first;
                self.by.iter().flat_map(move |by| {
                    let width = by.shape.len();
                    let start = array + row * width;
                    array += rows * width;
                    (start..start + width).map(|place| place as u32)
                })
            })
        })
    }
}

fn elements(arrays: &[Array]) -> Vec<u32> {
    let ranges = arrays.iter().map(|array| {
        let first = array.offset;
        first..first + array.shape.len() as u32
    });
    ranges.flatten().collect()
}
