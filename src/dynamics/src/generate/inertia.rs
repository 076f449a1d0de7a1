//! Mass, first moment and moments of inertia of sets of bodies, and the forces
//! in joints: the quantities of composite-body recursions.
//!
//! Both are moved across a joint the same way: turned by its one rotation, then
//! referred to the parent's origin. Zeros of offsets and inertias cost nothing.

use super::algebra::{Scalar, Sum};
use super::bias::BiasMotion;
use super::equations::{Equations, QuantityLabel};
use super::hub::{Pose, Twist};
use super::parameters::ModelParameters;
use super::vector::{
    AxisRotation, Inertia, Matrix, SumVector, Vector, ZERO, add_cross, add_matrix_product,
    add_sums, add_vector, cyclic, define, sums, sums_of,
};

/// An inertia that is not named yet; of the moments only the upper triangle.
pub(super) struct SumInertia {
    pub(super) mass: Sum,
    pub(super) first: SumVector,
    pub(super) moments: [SumVector; 3],
}

/// A force and a torque about the origin of a frame.
#[derive(Clone, Copy)]
pub(super) struct Wrench {
    pub(super) force: Vector,
    pub(super) torque: Vector,
}

impl Wrench {
    pub(super) const ZERO: Wrench = Wrench {
        force: ZERO,
        torque: ZERO,
    };
}

/// A wrench that is not named yet.
pub(super) struct SumWrench {
    pub(super) force: SumVector,
    pub(super) torque: SumVector,
}

impl SumWrench {
    pub(super) fn new() -> SumWrench {
        SumWrench {
            force: sums(),
            torque: sums(),
        }
    }

    /// Adds another wrench about the same origin.
    pub(super) fn add(&mut self, other: &SumWrench) {
        add_sums(&mut self.force, &other.force);
        add_sums(&mut self.torque, &other.torque);
    }

    /// Adds a multiple of a wrench about the same origin.
    pub(super) fn add_scaled(&mut self, other: &Wrench, factor: Scalar) {
        for k in 0..3 {
            self.force[k].add(&[other.force[k], factor]);
            self.torque[k].add(&[other.torque[k], factor]);
        }
    }

    pub(super) fn define(
        self,
        equations: &mut Equations,
        (force, torque): (&'static str, &'static str),
        joint: usize,
        column: usize,
    ) -> Wrench {
        Wrench {
            force: define(equations, force, joint, column, self.force),
            torque: define(equations, torque, joint, column, self.torque),
        }
    }
}

impl SumInertia {
    pub(super) fn new() -> SumInertia {
        SumInertia {
            mass: Sum::new(),
            first: sums(),
            moments: [sums(), sums(), sums()],
        }
    }

    /// Adds the inertia of a joint's own body: `I + m (l.l E - l l)`.
    pub(super) fn add_own(
        &mut self,
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        joint: usize,
    ) {
        if let Some(grouped) = &parameters.grouped {
            self.add(&grouped[joint].inertia);
            return;
        }
        let mass = parameters.masses[joint];
        let (moments, center) = (&parameters.inertias[joint], &parameters.centers[joint]);
        self.add_body(equations, joint, mass, moments, center);
    }

    /// Adds the inertia of a child, referred to the origin of its parent.
    pub(super) fn add_child(
        &mut self,
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        child: usize,
        inertia: &Inertia,
        offset: &Vector,
    ) {
        let turn = &parameters.turns[child];
        self.mass.add(&[inertia.mass]);
        let turned = Inertia {
            first: define(equations, "HT", child, 0, turn.up(&inertia.first)),
            ..*inertia
        };
        let moments = turn_symmetric(equations, ["JD", "JW", "JV"], child, turn, &inertia.moments);
        for (row, turned) in self.moments.iter_mut().zip(moments) {
            add_sums(row, &turned);
        }
        self.refer(equations, ("HS", "SS"), child, &turned, offset);
    }

    /// Adds a first moment and its contribution to the inertia about an origin
    /// that lies `offset` before the inertia's own. With `k = h + m d` the
    /// moments change by `d.(h + k) E` minus `k d + d h`: no product of two
    /// lengths and a mass is written twice.
    fn refer(
        &mut self,
        equations: &mut Equations,
        (first, square): (&'static str, &'static str),
        joint: usize,
        inertia: &Inertia,
        offset: &Vector,
    ) {
        let mut moved = inertia.first.map(Sum::of);
        for (component, &length) in moved.iter_mut().zip(offset) {
            component.add(&[inertia.mass, length]);
        }
        let moved = define(equations, first, joint, 0, moved);
        add_vector(&mut self.first, &moved);
        for axis in 0..3 {
            let (next, last) = cyclic(axis);
            let both = Sum::total(&[inertia.first[axis], moved[axis]]);
            let group = equations.group(both);
            let mut product = Sum::new();
            product.add_term(group.and_then(|group| group.times(&[offset[axis]])));
            let label = QuantityLabel::new(square, axis + 1, joint + 1);
            let value = equations.define(label, product);
            self.moments[next][next].add(&[value]);
            self.moments[last][last].add(&[value]);
            let (row, column) = (next.min(last), next.max(last));
            self.moments[row][column]
                .subtract(&[moved[row], offset[column]])
                .subtract(&[inertia.first[column], offset[row]]);
        }
    }

    /// Adds the inertia of a body whose moments are known about its centre.
    pub(super) fn add_body(
        &mut self,
        equations: &mut Equations,
        joint: usize,
        mass: Scalar,
        moments: &Matrix,
        center: &Vector,
    ) {
        let own = Inertia {
            mass,
            first: ZERO,
            moments: *moments,
        };
        self.add(&own);
        self.refer(equations, ("ML", "SL"), joint, &own, center);
    }

    /// Adds an inertia about the same origin.
    pub(super) fn add(&mut self, other: &Inertia) {
        self.mass.add(&[other.mass]);
        add_vector(&mut self.first, &other.first);
        for row in 0..3 {
            for column in row..3 {
                self.moments[row][column].add(&[other.moments[row][column]]);
            }
        }
    }

    pub(super) fn define(
        self,
        equations: &mut Equations,
        [mass, first, moments]: [&'static str; 3],
        joint: usize,
        number: usize,
    ) -> Inertia {
        let label = moments;
        let mass = QuantityLabel::new(mass, 0, joint + 1).column(number);
        let mass = equations.define(mass, self.mass);
        let first = define(equations, first, joint, number, self.first);
        let mut moments = [ZERO; 3];
        for (row, sums) in self.moments.into_iter().enumerate() {
            for (column, sum) in sums.into_iter().enumerate().skip(row) {
                let label =
                    QuantityLabel::new(label, 3 * row + column + 1, joint + 1).column(number);
                moments[row][column] = equations.define(label, sum);
                moments[column][row] = moments[row][column];
            }
        }
        Inertia {
            mass,
            first,
            moments,
        }
    }
}

impl Inertia {
    /// Inertias of all bodies that joints carry, in joint frames and origins.
    pub(super) fn composites(
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        offsets: &[Vector],
    ) -> Vec<Inertia> {
        let children = parameters.children();
        let mut composites = vec![Inertia::NONE; parameters.joints()];
        for joint in (0..parameters.joints()).rev() {
            let mut sum = SumInertia::new();
            sum.add_own(equations, parameters, joint);
            for &child in &children[joint] {
                let (composite, offset) = (&composites[child], &offsets[child]);
                sum.add_child(equations, parameters, child, composite, offset);
            }
            composites[joint] = sum.define(equations, ["MC", "HC", "JC"], joint, 0);
        }
        composites
    }

    /// The inertia of an empty body.
    const NONE: Inertia = Inertia {
        mass: Scalar::ZERO,
        first: ZERO,
        moments: [ZERO; 3],
    };

    /// Wrench of a unit of twist: force `m v + z x h`, torque `J z + h x v`.
    pub(super) fn wrench(
        &self,
        equations: &mut Equations,
        names: (&'static str, &'static str),
        joint: usize,
        twist: &Twist,
    ) -> Wrench {
        let mut wrench = SumWrench::new();
        for (component, &velocity) in wrench.force.iter_mut().zip(&twist.linear) {
            component.add(&[self.mass, velocity]);
        }
        add_cross(&mut wrench.force, &twist.angular, &self.first, false);
        add_matrix_product(&mut wrench.torque, &self.moments, &twist.angular);
        add_cross(&mut wrench.torque, &self.first, &twist.linear, false);
        wrench.define(equations, names, joint, 0)
    }

    /// The wrench that a unit of acceleration of a joint takes, in its frame.
    pub(super) fn column(&self, axis: usize, revolute: bool) -> Wrench {
        let (b, c) = cyclic(axis);
        let mut wrench = Wrench::ZERO;
        if revolute {
            wrench.force[b] = -self.first[c];
            wrench.force[c] = self.first[b];
            wrench.torque = self.moments[axis];
        } else {
            wrench.force[axis] = self.mass;
            wrench.torque[b] = self.first[c];
            wrench.torque[c] = -self.first[b];
        }
        wrench
    }
}

impl Wrench {
    /// A wrench in the parent's frame and origin; the turned force has `name`.
    pub(super) fn to_parent(
        self,
        equations: &mut Equations,
        name: &'static str,
        (joint, column): (usize, usize),
        turn: &AxisRotation,
        offset: &Vector,
    ) -> SumWrench {
        let force = define(equations, name, joint, column, turn.up(&self.force));
        let mut torque = turn.up(&self.torque);
        add_cross(&mut torque, offset, &force, false);
        SumWrench {
            force: sums_of(&force),
            torque,
        }
    }

    /// The component along the axis of a joint.
    pub(super) fn along(&self, parameters: &ModelParameters<'_>, joint: usize) -> Scalar {
        let axis = parameters.axis(joint);
        if parameters.is_revolute(joint) {
            self.torque[axis]
        } else {
            self.force[axis]
        }
    }

    /// The wrench as sums of one term.
    pub(super) fn sums(&self) -> SumWrench {
        SumWrench {
            force: sums_of(&self.force),
            torque: sums_of(&self.torque),
        }
    }
}

/// A symmetric matrix of a joint's frame, turned into its parent's: its upper
/// triangle. In the plane of the rotation, with `t = J_bb - J_cc` and
/// `w = S t + 2 C J_bc`, the three entries become `J_bb - S w`, `J_cc + S w` and
/// `C w - J_bc`: ten operations, but only where `S^2 + C^2 = 1`.
pub(super) fn turn_symmetric(
    equations: &mut Equations,
    [difference, swing, part]: [&'static str; 3],
    joint: usize,
    turn: &AxisRotation,
    matrix: &Matrix,
) -> [SumVector; 3] {
    let a = turn.axis;
    let (b, c) = cyclic(a);
    let (cos, sin) = (turn.cos, turn.sin);
    let mut turned = [sums(), sums(), sums()];
    let mut entry = |row: usize, column: usize, terms: &[&[Scalar]]| {
        for term in terms {
            turned[row.min(column)][row.max(column)].add(term);
        }
    };
    let (bb, cc, bc) = (matrix[b][b], matrix[c][c], matrix[b][c]);
    entry(a, a, &[&[matrix[a][a]]]);
    entry(a, b, &[&[cos, matrix[a][b]], &[-sin, matrix[a][c]]]);
    entry(a, c, &[&[sin, matrix[a][b]], &[cos, matrix[a][c]]]);
    if sin.is_zero() {
        // No rotation, or half a turn.
        entry(b, b, &[&[bb]]);
        entry(c, c, &[&[cc]]);
        entry(b, c, &[&[bc]]);
        return turned;
    }
    if cos.is_zero() {
        // A quarter of a turn exchanges the two axes.
        entry(b, b, &[&[cc]]);
        entry(c, c, &[&[bb]]);
        entry(b, c, &[&[-bc]]);
        return turned;
    }
    let twice = twice_cos(equations, joint, turn);
    let sum = Sum::total(&[bb, -cc]);
    let difference = equations.define(QuantityLabel::new(difference, 0, joint + 1), sum);
    let mut sum = Sum::new();
    sum.add(&[sin, difference]).add(&[twice, bc]);
    let swing = equations.define(QuantityLabel::new(swing, 0, joint + 1), sum);
    let sum = Sum::product(&[sin, swing]);
    let part = equations.define(QuantityLabel::new(part, 0, joint + 1), sum);
    entry(b, b, &[&[bb], &[-part]]);
    entry(c, c, &[&[cc], &[part]]);
    entry(b, c, &[&[cos, swing], &[-bc]]);
    turned
}

/// A matrix of a joint's frame in its parent's axes. In the plane of the
/// rotation, with `w = S (H_bb - H_cc) + C (H_bc + H_cb)`, the entries become
/// `H_bb - S w`, `H_cc + S w`, `C w - H_cb` and `C w - H_bc`.
pub(super) fn turn_general(
    equations: &mut Equations,
    names: [&'static str; 5],
    joint: usize,
    turn: &AxisRotation,
    matrix: &Matrix,
) -> [SumVector; 3] {
    let a = turn.axis;
    let (b, c) = cyclic(a);
    let (cos, sin) = (turn.cos, turn.sin);
    let mut turned = matrix.map(|row| row.map(Sum::of));
    let row = turn.up(&matrix[a]);
    let column = turn.up(&matrix.map(|row| row[a]));
    for k in [b, c] {
        turned[a][k] = row[k].clone();
        turned[k][a] = column[k].clone();
    }
    if sin.is_zero() {
        // No rotation, or half a turn.
        return turned;
    }
    if cos.is_zero() {
        // A quarter of a turn exchanges the two axes.
        for (row, column) in [(b, c), (c, b)] {
            turned[row][row] = Sum::of(matrix[column][column]);
            turned[row][column] = Sum::of(-matrix[column][row]);
        }
        return turned;
    }
    let mut name =
        |which: usize, sum| equations.define(QuantityLabel::new(names[which], 0, joint + 1), sum);
    let difference = Sum::total(&[matrix[b][b], -matrix[c][c]]);
    let total = Sum::total(&[matrix[b][c], matrix[c][b]]);
    let (difference, total) = (name(0, difference), name(1, total));
    let mut swing = Sum::new();
    swing.add(&[sin, difference]).add(&[cos, total]);
    let swing = name(2, swing);
    let part = Sum::product(&[sin, swing]);
    let part = name(3, part);
    let cross = Sum::product(&[cos, swing]);
    let cross = name(4, cross);
    turned[b][b].subtract(&[part]);
    turned[c][c].add(&[part]);
    for (row, column) in [(b, c), (c, b)] {
        turned[row][column] = Sum::of(cross);
        turned[row][column].subtract(&[matrix[column][row]]);
    }
    turned
}

/// `2 C`.
fn twice_cos(equations: &mut Equations, joint: usize, turn: &AxisRotation) -> Scalar {
    let twice = Sum::total(&[turn.cos, turn.cos]);
    equations.define(QuantityLabel::new("CC", 0, joint + 1), twice)
}

/// Moments of inertia in the axes of the reference. Since the axes are
/// orthogonal, `R^T I R = I_11 E + R^T (I - I_11 E) R`, with an entry less.
pub(super) fn turned_moments(
    equations: &mut Equations,
    joint: usize,
    moments: &Matrix,
    pose: &Pose,
) -> Matrix {
    if pose.axes == Pose::HERE.axes {
        return *moments;
    }
    let first = moments[0][0];
    let mut rest = *moments;
    for axis in 0..3 {
        let sum = Sum::total(&[moments[axis][axis], -first]);
        rest[axis][axis] = equations.define(QuantityLabel::new("ID", axis + 1, joint + 1), sum);
    }
    let mut half = [ZERO; 3];
    for (row, entries) in rest.iter().enumerate() {
        half[row] = {
            let sum = pose.lever(entries);
            let mut component = 0;
            sum.map(|sum| {
                component += 1;
                let label = QuantityLabel::new("IR", 3 * row + component, joint + 1);
                equations.define(label, sum)
            })
        };
    }
    let mut turned = [ZERO; 3];
    for row in 0..3 {
        for column in row..3 {
            let mut sum = Sum::new();
            if row == column {
                sum.add(&[first]);
            }
            for (axis, half) in pose.axes.iter().zip(&half) {
                sum.add(&[axis[row], half[column]]);
            }
            let label = QuantityLabel::new("JB", 3 * row + column + 1, joint + 1);
            turned[row][column] = equations.define(label, sum);
            turned[column][row] = turned[row][column];
        }
    }
    turned
}

/// The torque that a body's own rotation takes, about its centre of mass.
pub(super) fn euler(
    equations: &mut Equations,
    joint: usize,
    moments: &Matrix,
    motion: &BiasMotion,
) -> SumVector {
    let mut torque = sums();
    for a in 0..3 {
        let (b, c) = cyclic(a);
        let (low, high) = (b.min(c), b.max(c));
        let product = Sum::product(&[motion.velocity[b], motion.velocity[c]]);
        let label = QuantityLabel::new("BS", 3 * low + high + 1, joint + 1);
        let product = equations.define(label, product);
        let squares = Sum::total(&[motion.squares[b], -motion.squares[c]]);
        let squares = equations.define(QuantityLabel::new("BD", a + 1, joint + 1), squares);
        let difference = Sum::total(&[moments[c][c], -moments[b][b]]);
        let difference = equations.define(QuantityLabel::new("JE", a + 1, joint + 1), difference);
        torque[a]
            .add(&[moments[a][a], motion.angular[a]])
            .add(&[difference, product])
            .add(&[moments[b][c], squares])
            .subtract(&[moments[a][b], motion.tilde[c][a]])
            .add(&[moments[a][c], motion.tilde[b][a]]);
    }
    torque
}
