//! A function of a model, evaluated in a state.

use super::linear::DenseMatrix;
use super::{InputSources, MotionState, StateError};
use robovec_ir::evaluate::{evaluate, evaluate_mixed};
use robovec_ir::{Format, Function, Shape, Tables, View};
use robovec_model::Model;
use robovec_num::arithmetic::{Arithmetic, Binary32, Binary64};
use robovec_num::dual::{Dual, Duals};
use robovec_num::soft_float::FormatArithmetic;
use robovec_num::trigonometry::host::TrigonometricUnit;

/// A function of a model, ready to be evaluated.
pub struct CompiledFunction {
    format: Format,
    function: Function,
    inputs: InputSources,
    outputs: Vec<(String, usize, Shape)>,
    /// Unit of its sines and cosines, where one is given.
    unit: Option<TrigonometricUnit>,
}

/// The outputs of one evaluation.
pub struct EvaluatedOutputs<'a> {
    compiled: &'a CompiledFunction,
    flat: Vec<f64>,
}

impl CompiledFunction {
    /// Finds the inputs of a function in its model. The function is evaluated
    /// in the numbers of `format`; errors call it `name`.
    ///
    /// # Errors
    ///
    /// [`StateError::Element`].
    pub fn new(
        model: &Model,
        name: &str,
        tables: &Tables,
        function: Function,
        format: Format,
    ) -> Result<CompiledFunction, StateError> {
        let view = View {
            tables,
            function: &function,
        };
        let inputs = InputSources::new(model, view).map_err(|element| StateError::Element {
            function: name.to_owned(),
            element,
        })?;
        let outputs = function.outputs().iter().map(|array| {
            let name = tables.symbols.text(array.name).to_owned();
            (name, array.offset as usize, array.shape)
        });
        let outputs = outputs.collect();
        let unit = function.trigonometry_unit();
        Ok(CompiledFunction {
            format,
            outputs,
            unit: unit.map(|unit| unit.expect("the verifier accepts only names of units")),
            function,
            inputs,
        })
    }

    /// The outputs in a state.
    pub fn evaluate(&self, state: &MotionState) -> EvaluatedOutputs<'_> {
        let inputs = self.inputs.gather(state);
        let numbers = match (self.format, &self.unit) {
            // What says itself how its values are computed is asked.
            (format, _) if self.function.formats.is_some() => {
                evaluate_mixed(&self.function, format, &inputs)
            }
            (format, Some(unit)) => {
                self.numbers(&unit.within(FormatArithmetic::new(format)), &inputs)
            }
            (Format::BINARY32, None) => self.numbers(&Binary32, &inputs),
            (Format::BINARY64, None) => self.numbers(&Binary64, &inputs),
            (format, None) => self.numbers(&FormatArithmetic::new(format), &inputs),
        };
        self.outputs_of(numbers)
    }

    /// Derivatives of the outputs along a direction, in binary64.
    pub fn evaluate_along(
        &self,
        state: &MotionState,
        direction: &MotionState,
    ) -> EvaluatedOutputs<'_> {
        let values = self.inputs.gather(state);
        let slopes = self.inputs.gather_along(direction);
        let inputs = values.into_iter().zip(slopes);
        let inputs: Vec<Dual<f64>> = inputs.map(|(value, slope)| Dual { value, slope }).collect();
        let outputs = evaluate(&self.function, &Duals(Binary64), &inputs);
        let slopes = outputs.into_iter().map(|output| output.slope);
        self.outputs_of(slopes.map(Option::unwrap_or_default).collect())
    }

    /// The numbers of the assignments as outputs.
    fn outputs_of(&self, numbers: Vec<f64>) -> EvaluatedOutputs<'_> {
        assert_eq!(
            numbers.len(),
            self.function.assignments.len(),
            "one number per output"
        );
        let mut flat = vec![0.0; self.function.output_len()];
        for (assignment, number) in self.function.assignments.iter().zip(numbers) {
            flat[assignment.output.index()] = number;
        }
        EvaluatedOutputs {
            compiled: self,
            flat,
        }
    }

    /// The places, from 0, of the elements that the function sets in an array
    /// with one number for each joint or row, in the order of the assignments.
    pub fn assigned(&self, name: &str) -> Vec<usize> {
        let found = self.outputs.iter().find(|array| array.0 == name);
        let places = found.into_iter().flat_map(|&(_, first, shape)| {
            let assignments = self.function.assignments.iter();
            let places = assignments.filter_map(move |one| one.output.index().checked_sub(first));
            places.filter(move |&place| place < shape.len())
        });
        places.collect()
    }

    /// The outputs in binary64, computed in an arithmetic.
    fn numbers<A>(&self, arithmetic: &A, inputs: &[f64]) -> Vec<f64>
    where
        A: Arithmetic<Number: Into<f64>>,
    {
        let literals: Vec<A::Number> = inputs
            .iter()
            .map(|&number| arithmetic.literal(number))
            .collect();
        let outputs = evaluate(&self.function, arithmetic, &literals);
        outputs.into_iter().map(Into::into).collect()
    }
}

impl EvaluatedOutputs<'_> {
    /// An array; empty where the function lacks it, as its elements are zero.
    fn array(&self, name: &str) -> (Shape, &[f64]) {
        let found = self.compiled.outputs.iter().find(|array| array.0 == name);
        match found {
            Some(&(_, offset, shape)) => (shape, &self.flat[offset..offset + shape.len()]),
            None => (Shape::Vector(0), &[]),
        }
    }

    /// The first numbers of an array; those it does not have are zero.
    pub fn vector(&self, name: &str, length: usize) -> Vec<f64> {
        let mut vector = self.array(name).1.to_vec();
        vector.resize(length, 0.0);
        vector
    }

    /// The upper left corner of an array; entries it does not have are zero.
    pub fn matrix(&self, name: &str, rows: usize, columns: usize) -> DenseMatrix {
        let mut matrix = DenseMatrix::zeros(rows, columns);
        let (shape, entries) = self.array(name);
        if let Shape::Matrix(_, stride) = shape {
            for (place, &entry) in entries.iter().enumerate() {
                let (row, column) = (place / stride as usize, place % stride as usize);
                if row < rows && column < columns {
                    matrix[(row, column)] = entry;
                }
            }
        }
        matrix
    }

    /// Takes over the entries of an array of one number for each joint that
    /// the function sets; false when it has no such array.
    pub fn take_joints(&self, name: &str, numbers: &mut [f64]) -> bool {
        let mut outputs = self.compiled.outputs.iter();
        let Some(&(_, first, shape)) = outputs.find(|array| array.0 == name) else {
            return false;
        };
        for assignment in &self.compiled.function.assignments {
            let place = assignment.output.index();
            let joint = place.checked_sub(first);
            if let Some(joint) = joint.filter(|&joint| joint < shape.len().min(numbers.len())) {
                numbers[joint] = self.flat[place];
            }
        }
        true
    }

    /// Takes over the entries of a matrix that the function sets.
    pub fn take_entries(&self, name: &str, matrix: &mut DenseMatrix) {
        let mut outputs = self.compiled.outputs.iter();
        let Some(&(_, first, Shape::Matrix(_, columns))) = outputs.find(|array| array.0 == name)
        else {
            return;
        };
        for assignment in &self.compiled.function.assignments {
            let place = assignment.output.index();
            if let Some(offset) = place.checked_sub(first) {
                let (row, column) = (offset / columns as usize, offset % columns as usize);
                if row < matrix.rows() && column < matrix.columns() {
                    matrix[(row, column)] = self.flat[place];
                }
            }
        }
    }

    /// Takes over the columns of `frc` and `trq` that the function sets.
    pub fn take_loads(&self, state: &mut MotionState) {
        let arrays = [("frc", &mut state.frc), ("trq", &mut state.trq)];
        for (name, columns) in arrays {
            let Some(array) = self.compiled.outputs.iter().find(|array| array.0 == name) else {
                continue;
            };
            for assignment in &self.compiled.function.assignments {
                let place = assignment.output.index();
                let Some(offset) = place.checked_sub(array.1) else {
                    continue;
                };
                if offset < array.2.len() {
                    let ([component, joint], _) = array.2.indices(offset as u32);
                    columns[joint as usize - 1][component as usize - 1] = self.flat[place];
                }
            }
        }
    }
}
