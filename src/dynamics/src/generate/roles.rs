//! The roles of joints and constraint rows in accelerations, decided in
//! numbers at the closed initial state of the model.

use super::frames::ModelFrames;
use super::{GenerateError, GenerationRequest, Options, generate};
use crate::kinematics::linear::{DenseMatrix, eliminate};
use crate::kinematics::{
    CompiledFunction, LoopClosure, LoopConstraints, MotionState, Partition, StateError,
};
use robovec_ir::{Format, Module};
use robovec_model::{Model, Nature};
use robovec_robotran::FunctionKind;

pub(super) struct JointRoles {
    /// Joints that neither the loops determine nor the user drives, ascending.
    pub(super) free: Vec<usize>,
    /// Those of them that constraints of the user determine, ascending.
    pub(super) bound: Vec<usize>,
    /// Joints that the loops determine, in the order of their pivots.
    pub(super) dependent: Vec<usize>,
    /// The row of each dependent joint.
    pub(super) rows: Vec<usize>,
}

impl JointRoles {
    /// Decides the roles at the closed initial state.
    pub(super) fn new(model: &Model, options: &Options) -> Result<JointRoles, GenerateError> {
        let mut roles = JointRoles::of_loops(model)?;
        if options.user_constraints > 0 {
            let named = |joint: &usize| model.joints[*joint].nature == Nature::Dependent;
            roles.bound = roles.free.iter().copied().filter(named).collect();
            if roles.bound.len() != options.user_constraints {
                return Err(GenerateError::UserConstraints {
                    rows: options.user_constraints,
                    left: roles.bound.len(),
                    of_loops: roles.dependent.len(),
                });
            }
        }
        debug_assert!(
            roles.free.is_sorted() && roles.bound.is_sorted(),
            "joints ascend"
        );
        assert_eq!(
            roles.dependent.len(),
            roles.rows.len(),
            "a dependent joint has a row"
        );
        Ok(roles)
    }

    /// The roles, with frames instead of joints.
    pub(super) fn framed(mut self, frames: &ModelFrames<'_>) -> JointRoles {
        for joint in [&mut self.free, &mut self.bound, &mut self.dependent]
            .into_iter()
            .flatten()
        {
            *joint = frames.place(*joint);
        }
        self
    }

    /// Joints that no constraint determines, ascending.
    fn independent(&self) -> Vec<usize> {
        let moves = |joint: &usize| !self.bound.contains(joint);
        self.free.iter().copied().filter(moves).collect()
    }

    /// True for joints that constraints determine.
    pub(super) fn follows(&self, joint: usize) -> bool {
        self.dependent.contains(&joint) || self.bound.contains(&joint)
    }

    pub(super) fn open(model: &Model) -> JointRoles {
        let free = |joint: &usize| model.joints[*joint].nature != Nature::Driven;
        JointRoles {
            free: (0..model.joints.len()).filter(free).collect(),
            bound: Vec::new(),
            dependent: Vec::new(),
            rows: Vec::new(),
        }
    }

    /// The roles without constraints of the user.
    pub(super) fn of_loops(model: &Model) -> Result<JointRoles, GenerateError> {
        if model.cuts.is_empty() {
            return Ok(JointRoles::open(model));
        }
        let (roles, jacobian) = closed_loops(model)?;
        let square = jacobian.select(&roles.rows, &roles.dependent);
        let pivots = eliminate(square, &vec![1.0; roles.dependent.len()], 0.0);
        Ok(JointRoles {
            free: roles.independent,
            bound: Vec::new(),
            dependent: pivots
                .iter()
                .map(|pivot| roles.dependent[pivot.column])
                .collect(),
            rows: pivots.iter().map(|pivot| roles.rows[pivot.row]).collect(),
        })
    }
}

/// Joints on which forces act in inverse dynamics.
pub(super) struct ReactionRoles {
    /// Joints with an actuator, ascending.
    pub(super) actuated: Vec<usize>,
    /// Joints whose forces give the loops' multipliers, in the order of pivots.
    pub(super) of_loops: Vec<usize>,
    pub(super) rows: Vec<usize>,
    /// Those available for the multipliers of the user's constraints.
    pub(super) of_user: Vec<usize>,
}

impl ReactionRoles {
    /// Decides the points of forces, at the closed initial state, by frames.
    pub(super) fn new(
        frames: &ModelFrames<'_>,
        roles: &JointRoles,
    ) -> Result<ReactionRoles, GenerateError> {
        let model = &frames.model;
        let independent = roles.independent();
        let is_free = |joint: &usize| model.joints[*joint].nature != Nature::Driven;
        let all = (0..model.joints.len()).filter(is_free);
        let named: Vec<usize> = all
            .clone()
            .filter(|&joint| model.joints[joint].actuated)
            .collect();
        let actuated = if named.is_empty() {
            independent.clone()
        } else {
            named
        };
        if actuated.len() != independent.len() {
            return Err(GenerateError::Actuators {
                free: independent.len(),
                actuated: actuated.len(),
            });
        }
        let others: Vec<usize> = all.filter(|joint| !actuated.contains(joint)).collect();
        let (mut of_loops, mut rows) = (Vec::new(), Vec::new());
        if !roles.rows.is_empty() {
            let jacobian = closed_loops(frames.source)?.1;
            let columns: Vec<usize> = others
                .iter()
                .filter_map(|&other| frames.joint(other))
                .collect();
            let square = jacobian.select(&roles.rows, &columns);
            for pivot in eliminate(square, &vec![1.0; others.len()], 1e-8) {
                of_loops.push(others[pivot.column]);
                rows.push(roles.rows[pivot.row]);
            }
        }
        if rows.len() < roles.rows.len() {
            return Err(GenerateError::Unactuated);
        }
        let left = |joint: &usize| !of_loops.contains(joint);
        Ok(ReactionRoles {
            of_user: others.iter().copied().filter(left).collect(),
            actuated,
            of_loops,
            rows,
        })
    }
}

/// Roles of joints at the closed initial state, and the loops' Jacobian there.
fn closed_loops(model: &Model) -> Result<(Partition, DenseMatrix), GenerateError> {
    let failed = |error: StateError| GenerateError::Loops(error.to_string());
    let constraints = &constraints(model)?;
    let mut state = at_rest(model);
    let loops = LoopClosure { model, constraints };
    let roles = loops.start(&mut state).map_err(failed)?;
    Ok((roles, constraints.evaluate(&state).1))
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

/// The constraints of a model, in binary64; without cuts it has none.
pub fn constraints(model: &Model) -> Result<LoopConstraints, GenerateError> {
    if model.cuts.is_empty() {
        return Ok(LoopConstraints::none(model, Format::BINARY64));
    }
    let format = Format::BINARY64;
    let position = compiled(model, &GenerationRequest::new(FunctionKind::ConsHJ))?;
    let row_cuts = cuts_of_rows(model)?;
    Ok(LoopConstraints::new(model, format, position, row_cuts))
}

/// A function of a model, to be evaluated in binary64.
pub(super) fn compiled(
    model: &Model,
    request: &GenerationRequest,
) -> Result<CompiledFunction, GenerateError> {
    let Module {
        tables,
        mut functions,
    } = generate(model, request)?;
    let function = functions.pop().expect("the generator gives a function");
    let name = request.function.name();
    CompiledFunction::new(model, name, &tables, function, Format::BINARY64)
        .map_err(|error| GenerateError::Loops(error.to_string()))
}

/// Independent joints, from 0, ascending, from which all others follow.
pub fn independent_joints(model: &Model, options: &Options) -> Result<Vec<usize>, GenerateError> {
    Ok(JointRoles::new(model, options)?.independent())
}

/// The rows of the constraints, from 0, that repeat others.
pub fn redundant_rows(model: &Model) -> Result<Vec<usize>, GenerateError> {
    let kept = JointRoles::of_loops(model)?.rows;
    let rows = 0..cuts_of_rows(model)?.len();
    Ok(rows.filter(|row| !kept.contains(row)).collect())
}

/// The cut, from 0, of each row of the constraints. Equations leave out rows
/// that no joint changes; what a cut keeps is known when it is alone.
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
