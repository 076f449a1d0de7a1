//! The symbols of a model: names of its parameters and state in equations.
//!
//! A parameter of zero is a structural zero: it never appears, unless all
//! symbols are requested. A joint whose velocity has no symbol is at rest.

use super::algebra::{Scalar, Sum, given};
use super::equations::{Equations, QuantityLabel};
use super::frames::ModelFrames;
use super::free_base;
use super::grouping::grouped;
use super::vector::{
    AxisRotation, Inertia, Matrix, SumVector, Vector, ZERO, add_vector, define_as, sums,
};
use super::{GenerationRequest, Options, ParameterBinding};
use robovec_model::Model;
use robovec_robotran::FunctionKind;

/// Everything the recursions read, by joint index.
pub(super) struct ModelParameters<'m> {
    pub(super) frames: &'m ModelFrames<'m>,
    /// The model whose joints are frames.
    pub(super) model: &'m Model,
    /// Gravity, m/s^2.
    pub(super) gravity: Vector,
    /// Attachment of each joint, in its parent's frame.
    pub(super) attachments: Vec<Vector>,
    /// Centre of mass in the body's frame, zero for fictitious bodies.
    pub(super) centers: Vec<Vector>,
    /// Mass, zero for fictitious bodies.
    pub(super) masses: Vec<Scalar>,
    /// Moments of inertia about the centre of mass.
    pub(super) inertias: Vec<Matrix>,
    pub(super) q: Vec<Scalar>,
    pub(super) qd: Vec<Scalar>,
    /// Accelerations of joints whose `qdd` is zero, of a free base; else none.
    pub(super) resting: Vec<Scalar>,
    /// External force on each body at its centre of mass, in its frame.
    pub(super) forces: Vec<Vector>,
    /// External torque on each body, in its frame.
    pub(super) torques: Vec<Vector>,
    pub(super) turns: Vec<AxisRotation>,
    /// Inertias that joints move, in place of masses, centres and inertias.
    pub(super) grouped: Option<Vec<OriginInertia>>,
}

/// Inertia that a joint moves, about the origin of its frame.
#[derive(Clone, Copy)]
pub(super) struct OriginInertia {
    /// Mass, first moment and moments of inertia.
    pub(super) inertia: Inertia,
    /// `tr J - 2 J` of the moments: twice the second moments of mass.
    pub(super) second: Matrix,
}

/// The parameters of a function, moved from body to body where they may be.
pub(super) fn of<'m>(
    frames: &'m ModelFrames<'m>,
    request: &GenerationRequest,
    equations: &mut Equations,
) -> ModelParameters<'m> {
    let (function, options) = (request.function, &request.options);
    let moves = function.is_derived() && function != FunctionKind::Regressor;
    if moves && options.parameters == ParameterBinding::Numbers {
        ModelParameters::grouped(frames, options, equations)
    } else {
        ModelParameters::new(frames, options, equations)
    }
}

impl<'m> ModelParameters<'m> {
    /// Names the symbols of a model and writes its sines and cosines.
    pub(super) fn new(
        frames: &'m ModelFrames<'m>,
        options: &Options,
        equations: &mut Equations,
    ) -> Self {
        let model: &Model = &frames.model;
        let joints = 0..model.joints.len();
        equations.numbers_of_joints = frames.joint_numbers();
        if options.quaternion {
            equations.numbers_of_joints.exchange(model.joints.len());
        }
        let mut source = ParameterSource { options, equations };
        let mut gravity = [0, 1, 2].map(|i| source.parameter("g", &[i + 1], model.gravity[i]));
        // Symbols are numbered as they are named: one array after the other.
        let masses = joints.clone().map(|i| source.mass(model, i)).collect();
        let centers = joints.clone().map(|i| source.center(model, i)).collect();
        let inertias = joints.clone().map(|i| source.inertia(model, i)).collect();
        let attachments = joints
            .clone()
            .map(|i| match model.joints[i].point {
                None => ZERO,
                Some(point) => source.point(model, point),
            })
            .collect();
        let mut loads = |name: &str| -> Vec<Vector> {
            let each = joints.clone();
            each.map(|i| source.load(model, name, i)).collect()
        };
        let (forces, torques) = (loads("frc"), loads("trq"));
        let q: Vec<Scalar> = joints
            .clone()
            .map(|i| match options.quaternion && i < 6 {
                true => Scalar::ZERO,
                false => equations.input("q", &[i + 1]),
            })
            .collect();
        let qd: Vec<Scalar> = joints
            .clone()
            .map(|i| {
                if model.joints[i].has_velocity {
                    equations.input("qd", &[i + 1])
                } else {
                    Scalar::ZERO
                }
            })
            .collect();
        let mut resting = Vec::new();
        if options.quaternion {
            gravity = free_base::gravity(equations, &gravity);
            resting = free_base::resting(equations, &qd);
        }
        let small = |frame: usize| {
            let joint = frames.joint(frame);
            joint.is_some_and(|joint| options.small_angles.contains(&joint))
        };
        let turns = joints
            .map(|i| match frames.constant(equations, i) {
                Some(constant) => constant,
                None => turn(model, equations, i, (q[i], small(i))),
            })
            .collect();
        ModelParameters {
            frames,
            model,
            gravity,
            attachments,
            centers,
            masses,
            inertias,
            q,
            qd,
            resting,
            forces,
            torques,
            turns,
            grouped: None,
        }
    }

    /// The same with inertias as numbers (see [`super::grouping`]).
    pub(super) fn grouped(
        frames: &'m ModelFrames<'m>,
        options: &Options,
        equations: &mut Equations,
    ) -> Self {
        let mut parameters = ModelParameters::new(frames, options, equations);
        // A free base moves along all axes at once, and not joint after joint.
        let inertias = grouped(frames, parameters.resting.len());
        let scalars = inertias.iter().map(|own| {
            let moments = own.moments;
            let trace: f64 = (0..3).map(|axis| moments[axis][axis]).sum();
            let second = |row: usize, column: usize| {
                let diagonal = if row == column { trace } else { 0.0 };
                diagonal - 2.0 * moments[row][column]
            };
            let axes = [0, 1, 2];
            OriginInertia {
                inertia: Inertia {
                    mass: equations.number(own.mass),
                    first: own.first.map(|number| equations.number(number)),
                    moments: moments.map(|row| row.map(|number| equations.number(number))),
                },
                second: axes.map(|r| axes.map(|c| equations.number(second(r, c)))),
            }
        });
        parameters.grouped = Some(scalars.collect());
        parameters
    }

    /// The number of joints, constant rotations included.
    pub(super) fn joints(&self) -> usize {
        self.model.joints.len()
    }

    pub(super) fn parent(&self, joint: usize) -> Option<usize> {
        self.model.joints[joint].parent
    }

    /// The number of the axis of a joint, 0 to 2.
    pub(super) fn axis(&self, joint: usize) -> usize {
        self.model.joints[joint].kind.axis().index()
    }

    /// True for a rotation.
    pub(super) fn is_revolute(&self, joint: usize) -> bool {
        self.model.joints[joint].kind.is_revolute()
    }

    /// From the parent's origin to the joint's, in the parent's frame.
    pub(super) fn offset(&self, joint: usize) -> SumVector {
        let mut offset = sums();
        add_vector(&mut offset, &self.attachments[joint]);
        if !self.is_revolute(joint) {
            offset[self.axis(joint)].add(&[self.q[joint]]);
        }
        offset
    }

    pub(super) fn named_offset(&self, equations: &mut Equations, joint: usize) -> Vector {
        let label = |component| QuantityLabel::new("Dz", 0, 10 * (joint + 1) + component);
        define_as(equations, label, self.offset(joint))
    }

    pub(super) fn named_offsets(&self, equations: &mut Equations) -> Vec<Vector> {
        (0..self.joints())
            .map(|joint| self.named_offset(equations, joint))
            .collect()
    }

    /// The acceleration of a joint: an input, or zero for one at rest.
    pub(super) fn acceleration(&self, equations: &mut Equations, joint: usize) -> Scalar {
        if !self.model.joints[joint].has_acceleration {
            return Scalar::ZERO;
        }
        let own = equations.input("qdd", &[joint + 1]);
        self.with_resting(equations, joint, own)
    }

    /// The acceleration of a joint whose `qdd` is given.
    pub(super) fn with_resting(
        &self,
        equations: &mut Equations,
        joint: usize,
        own: Scalar,
    ) -> Scalar {
        let sum = Sum::total(&[own, given(&self.resting, joint)]);
        equations.define(QuantityLabel::new("QA", 0, joint + 1), sum)
    }

    /// The inertia of the rotor that a joint turns.
    pub(super) fn armature(&self, equations: &mut Equations, joint: usize) -> Scalar {
        equations.number(self.model.joints[joint].armature)
    }

    /// The joints of the direct children of every joint.
    pub(super) fn children(&self) -> Vec<Vec<usize>> {
        let mut children = vec![Vec::new(); self.joints()];
        for joint in 0..self.joints() {
            if let Some(parent) = self.parent(joint) {
                children[parent].push(joint);
            }
        }
        children
    }

    /// A joint and all joints between it and the base, from the base on.
    pub(super) fn path(&self, joint: Option<usize>) -> Vec<usize> {
        let mut path: Vec<usize> = self.model.path(joint).collect();
        path.reverse();
        path
    }
}

/// Properties that a joint moves.
struct Properties {
    mass: f64,
    center: [f64; 3],
    inertia: [f64; 9],
}

impl Properties {
    /// Those of the body of a joint; zeros or none of a fictitious one.
    fn of(model: &Model, joint: usize, all: bool) -> Option<Properties> {
        match model.body_of(joint) {
            Some(body) => Some(Properties {
                mass: body.mass,
                center: body.center,
                inertia: body.inertia_matrix(),
            }),
            None => all.then_some(Properties {
                mass: 0.0,
                center: [0.0; 3],
                inertia: [0.0; 9],
            }),
        }
    }
}

/// Makes symbols or numbers of parameters.
pub(super) struct ParameterSource<'a> {
    pub(super) options: &'a Options,
    pub(super) equations: &'a mut Equations,
}

impl ParameterSource<'_> {
    /// A parameter of the model: a structural zero, a symbol or a number.
    pub(super) fn parameter(&mut self, array: &str, indices: &[usize], value: f64) -> Scalar {
        match self.options.parameters {
            ParameterBinding::Symbols if value == 0.0 && !self.options.all_parameters => {
                Scalar::ZERO
            }
            ParameterBinding::Symbols => self.equations.input(array, indices),
            ParameterBinding::Numbers => self.equations.number(value),
        }
    }

    /// The coordinates of a point in its body's frame.
    pub(super) fn point(&mut self, model: &Model, point: usize) -> Vector {
        [0, 1, 2].map(|k| {
            let value = model.points[point].coordinates[k];
            self.parameter("dpt", &[k + 1, point + 1], value)
        })
    }

    /// Properties that a joint moves; `None` for a fictitious body's.
    fn moved(&self, model: &Model, joint: usize) -> Option<Properties> {
        Properties::of(model, joint, self.options.all_parameters)
    }

    fn mass(&mut self, model: &Model, joint: usize) -> Scalar {
        self.moved(model, joint).map_or(Scalar::ZERO, |body| {
            self.parameter("m", &[joint + 1], body.mass)
        })
    }

    /// Its centre in the body's frame.
    fn center(&mut self, model: &Model, joint: usize) -> Vector {
        self.moved(model, joint).map_or(ZERO, |body| {
            [0, 1, 2].map(|k| self.parameter("l", &[k + 1, joint + 1], body.center[k]))
        })
    }

    /// Its moments of inertia about the centre.
    fn inertia(&mut self, model: &Model, joint: usize) -> Matrix {
        let Some(body) = self.moved(model, joint) else {
            return [ZERO; 3];
        };
        [0, 1, 2].map(|row| {
            // The matrix is symmetric: one symbol for each pair.
            [0, 1, 2].map(|column| {
                let entry = 3 * row.min(column) + row.max(column);
                self.parameter("In", &[entry + 1, joint + 1], body.inertia[entry])
            })
        })
    }

    /// The external force or torque, by its array's name, on a joint's body.
    fn load(&mut self, model: &Model, name: &str, joint: usize) -> Vector {
        if self.options.external_forces && self.moved(model, joint).is_some() {
            [1, 2, 3].map(|k| self.equations.input(name, &[k, joint + 1]))
        } else {
            ZERO
        }
    }
}

/// The rotation of a joint by its position; sine and cosine of large angles.
fn turn(
    model: &Model,
    equations: &mut Equations,
    joint: usize,
    (position, small): (Scalar, bool),
) -> AxisRotation {
    let kind = model.joints[joint].kind;
    if !kind.is_revolute() {
        return AxisRotation::NONE;
    }
    if position.is_zero() {
        return AxisRotation {
            axis: kind.axis().index(),
            cos: Scalar::ONE,
            sin: Scalar::ZERO,
        };
    }
    if small {
        return AxisRotation {
            axis: kind.axis().index(),
            cos: Scalar::ONE,
            sin: position,
        };
    }
    AxisRotation {
        axis: kind.axis().index(),
        cos: equations.cos(QuantityLabel::new("C", 0, joint + 1), position),
        sin: equations.sin(QuantityLabel::new("S", 0, joint + 1), position),
    }
}
