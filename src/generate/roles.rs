//! The roles of joints and constraint rows in accelerations, decided in
//! numbers at the closed initial state of the model.

use super::{GenerateError, GenerationRequest, generate};
use crate::kinematics::linear::eliminate;
use crate::kinematics::{CompiledFunction, LoopClosure, LoopConstraints, MotionState, StateError};
use crate::model::{Model, Nature};
use crate::robotran::FunctionKind;
use robovec_ir::{Format, Module};

/// The roles of joints and rows.
pub(super) struct JointRoles {
    pub(super) independent: Vec<usize>,
    /// Dependent joints in the order of their pivots.
    pub(super) dependent: Vec<usize>,
    /// The row of each dependent joint.
    pub(super) rows: Vec<usize>,
}

impl JointRoles {
    /// Decides the roles at the closed initial state.
    pub(super) fn new(model: &Model) -> Result<JointRoles, GenerateError> {
        let free = |joint: &usize| model.joints[*joint].nature != Nature::Driven;
        if model.cuts.is_empty() {
            return Ok(JointRoles {
                independent: (0..model.joints.len()).filter(free).collect(),
                dependent: Vec::new(),
                rows: Vec::new(),
            });
        }
        let failed = |error: StateError| GenerateError::Loops(error.to_string());
        let constraints = &constraints(model)?;
        let mut state = at_rest(model);
        let loops = LoopClosure { model, constraints };
        let roles = loops.start(&mut state).map_err(failed)?;
        let jacobian = constraints.evaluate(&state).1;
        let square = jacobian.select(&roles.rows, &roles.dependent);
        let pivots = eliminate(square, &vec![1.0; roles.dependent.len()], 0.0);
        Ok(JointRoles {
            independent: roles.independent,
            dependent: pivots
                .iter()
                .map(|pivot| roles.dependent[pivot.column])
                .collect(),
            rows: pivots.iter().map(|pivot| roles.rows[pivot.row]).collect(),
        })
    }
}

/// The initial state, in which driven joints rest.
fn at_rest(model: &Model) -> MotionState {
    let mut state = MotionState::initial(model);
    for (index, joint) in model.joints.iter().enumerate() {
        if joint.nature == Nature::Driven {
            (state.qd[index], state.qdd[index]) = (0.0, 0.0);
        }
    }
    state
}

/// The constraints of a model with cuts, in binary64.
fn constraints(model: &Model) -> Result<LoopConstraints, GenerateError> {
    let kind = FunctionKind::ConsHJ;
    let Module {
        tables,
        mut functions,
    } = generate(model, &GenerationRequest::new(kind))?;
    let function = functions.pop().expect("the generator gives a function");
    let format = Format::BINARY64;
    let position = CompiledFunction::new(model, kind.name(), &tables, function, format)
        .map_err(|error| GenerateError::Loops(error.to_string()))?;
    let row_cuts = cuts_of_rows(model)?;
    Ok(LoopConstraints::new(model, format, position, row_cuts))
}

/// The independent joints, from 0, ascending: those whose accelerations the
/// others follow from.
///
/// # Errors
///
/// See [`generate`].
pub fn independent_joints(model: &Model) -> Result<Vec<usize>, GenerateError> {
    Ok(JointRoles::new(model)?.independent)
}

/// The cut, from 0, of each row of the constraints. The equations leave out
/// rows that no joint changes; how many a cut keeps is seen when it stands
/// alone.
///
/// # Errors
///
/// See [`generate`].
pub fn cuts_of_rows(model: &Model) -> Result<Vec<usize>, GenerateError> {
    let mut alone = model.clone();
    let mut cuts = Vec::new();
    for (index, cut) in model.cuts.iter().enumerate() {
        alone.cuts = vec![cut.clone()];
        let request = GenerationRequest::new(FunctionKind::ConsHJ);
        let module = generate(&alone, &request)?;
        let rows = module.functions.iter().flat_map(|function| {
            let arrays = function.outputs().iter();
            arrays.filter(|array| module.tables.symbols.text(array.name) == "h")
        });
        let count = rows.map(|array| array.shape.len()).sum();
        cuts.extend(std::iter::repeat_n(index, count));
    }
    Ok(cuts)
}
