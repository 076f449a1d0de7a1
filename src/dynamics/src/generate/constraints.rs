//! Loops: the constraints `h`, their Jacobian `Jac` and velocity terms `Jdqd`.
//!
//! A loop is cut into two chains that start at the last joint both have in
//! common. A ball demands that their ends coincide (3 rows), a rod that their
//! ends keep a distance (1 row: `h = (P.P - lrod^2) / 2`), a solid that their
//! frames coincide (6 rows). For a solid's rotation `h` holds three entries of
//! the relative rotation matrix and the rows of `Jac` are the relative angular
//! velocity, as in Robotran. Rows that no joint changes (planar loops) are
//! left out, and the rest are numbered without gaps.

use super::Options;
use super::algebra::{Scalar, Sum};
use super::chain::{Chain, JacobianColumn};
use super::equations::{Equations, QuantityLabel};
use super::factor::{SparseRow, find_entry};
use super::parameters::{ModelParameters, ParameterSource};
use super::vector::{Matrix, Vector, ZERO, define_as, subtracted, sums};
use robovec_model::{Anchor, Cut, CutKind, JointCoupling};

#[derive(Clone)]
pub(super) struct ConstraintRow {
    pub(super) h: Scalar,
    /// Entries of the Jacobian by joint; joints that are missing are zero.
    pub(super) jacobian: Vec<(usize, Scalar)>,
    pub(super) jdqd: Scalar,
}

impl ConstraintRow {
    /// The entries of a row of `Jv`: places among the dependent joints, ascending.
    pub(super) fn dependent_entries(&self, dependent: &[usize]) -> SparseRow {
        let place = |joint: &usize| dependent.iter().position(|other| other == joint);
        let entries = self.jacobian.iter();
        let mut row: SparseRow = entries
            .filter_map(|(joint, value)| Some((place(joint)?, *value)))
            .collect();
        row.sort_unstable_by_key(|&(column, _)| column);
        row
    }
}

impl ConstraintRow {
    pub(super) fn entry(&self, joint: usize) -> Scalar {
        find_entry(&self.jacobian, joint)
    }
}

/// Part of the rows that is needed; the rest costs time to write and drop.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum ConstraintPart {
    /// `h` and `Jac`.
    Position,
    /// `Jdqd` as well.
    Acceleration,
}

/// Writes `h` and `Jac`.
pub(super) fn position(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) {
    let rows = rows(equations, parameters, options, ConstraintPart::Position);
    for (number, row) in rows.iter().enumerate() {
        equations.output("h", &[number + 1], row.h);
        for &(joint, entry) in &row.jacobian {
            equations.output("Jac", &[number + 1, joint + 1], entry);
        }
    }
}

/// Writes `Jdqd`.
pub(super) fn acceleration(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) {
    let rows = rows(equations, parameters, options, ConstraintPart::Acceleration);
    for (number, row) in rows.iter().enumerate() {
        equations.output("Jdqd", &[number + 1], row.jdqd);
    }
}

/// The rows that some joint changes.
pub(super) fn rows(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
    part: ConstraintPart,
) -> Vec<ConstraintRow> {
    let mut rows = Vec::new();
    for number in 0..parameters.model.cuts.len() {
        let mut writer = ConstraintWriter {
            equations,
            parameters,
            part,
            number,
        };
        rows.extend(writer.rows(options));
    }
    rows.retain(|row| !row.jacobian.is_empty());
    rows
}

/// The number of the rod, from 0, and its length.
fn rod_length(parameters: &ModelParameters<'_>, cut: usize) -> (usize, f64) {
    let cuts = &parameters.model.cuts;
    let before = cuts[..cut]
        .iter()
        .filter(|cut| matches!(cut.kind, CutKind::Rod(_)))
        .count();
    match cuts[cut].kind {
        CutKind::Rod(length) => (before, length),
        CutKind::Ball | CutKind::Solid | CutKind::Coupling(_) => (before, 0.0),
    }
}

/// Splits the paths to two places at the last joint they have in common.
pub(super) fn split(parameters: &ModelParameters<'_>, ends: &[Anchor; 2]) -> [Vec<usize>; 2] {
    let paths = ends.map(|end| {
        let last = parameters.model.last_joint(end.body);
        parameters.path(last)
    });
    let common = paths[0]
        .iter()
        .zip(&paths[1])
        .take_while(|(a, b)| a == b)
        .count();
    paths.map(|path| path[common..].to_vec())
}

/// The coordinates of a place in its body's frame.
pub(super) fn place(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
    anchor: &Anchor,
) -> Vector {
    let mut source = ParameterSource { options, equations };
    anchor
        .point
        .map_or(ZERO, |point| source.point(parameters.model, point))
}

/// Writer of the rows of one cut.
pub(super) struct ConstraintWriter<'e, 'p, 'm> {
    pub(super) equations: &'e mut Equations,
    pub(super) parameters: &'p ModelParameters<'m>,
    pub(super) part: ConstraintPart,
    /// The cut, from 0.
    pub(super) number: usize,
}

impl ConstraintWriter<'_, '_, '_> {
    /// The rows, those that no joint changes included.
    pub(super) fn rows(&mut self, options: &Options) -> Vec<ConstraintRow> {
        let cut = &self.parameters.model.cuts[self.number];
        let mut rows = Vec::new();
        if let CutKind::Coupling(coupling) = cut.kind {
            rows.push(self.coupling(&coupling));
            return rows;
        }
        let ends = self.ends(options);
        match cut.kind {
            CutKind::Ball => self.ball(cut, &ends, &mut rows),
            CutKind::Rod(_) => {
                let length = rod_length(self.parameters, self.number);
                self.rod(&ends, length, options, &mut rows);
            }
            CutKind::Solid => {
                self.ball(cut, &ends, &mut rows);
                self.rotation(cut, &ends, &mut rows);
            }
            CutKind::Coupling(_) => {}
        }
        rows
    }

    pub(super) fn ends(&mut self, options: &Options) -> [Chain; 2] {
        let cut = &self.parameters.model.cuts[self.number];
        let [first, second] = split(self.parameters, &cut.ends);
        let mut end = |side: usize, path: &[usize]| {
            let place = place(self.equations, self.parameters, options, &cut.ends[side]);
            let number = 2 * self.number + side + 1;
            Chain::new(
                self.equations,
                self.parameters,
                ("lp", number),
                path,
                &place,
            )
        };
        [end(0, &first), end(1, &second)]
    }

    fn label(&self, prefix: &'static str, row: usize) -> QuantityLabel {
        QuantityLabel::new(prefix, row + 1, self.number + 1)
    }

    /// `q_joint - factor q_leader - offset`.
    fn coupling(&mut self, coupling: &JointCoupling) -> ConstraintRow {
        let frames = self.parameters.frames;
        let [joint, leader] = [coupling.joint, coupling.leader].map(|joint| frames.place(joint));
        let (factor, offset) = (
            self.equations.number(coupling.factor),
            self.equations.number(coupling.offset),
        );
        // Symbols of reversed joints have their signs already.
        let [one, ratio] = [(joint, Scalar::ONE), (leader, -factor)]
            .map(|(joint, value)| value.negated_if(frames.is_reversed(joint)));
        let mut h = Sum::product(&[one, self.parameters.q[joint]]);
        h.add(&[ratio, self.parameters.q[leader]])
            .subtract(&[offset]);
        let mut jacobian = vec![(joint, one), (leader, ratio)];
        jacobian.retain(|(_, value)| !value.is_zero());
        jacobian.sort_unstable_by_key(|&(joint, _)| joint);
        ConstraintRow {
            h: self.equations.define(self.label("h", 0), h),
            jacobian,
            jdqd: Scalar::ZERO,
        }
    }

    /// From the second end to the first.
    pub(super) fn span(&mut self, prefix: &'static str, ends: &[Chain; 2]) -> Vector {
        let [one, other] = [0, 1].map(|side| ends[side].position_terms(self.equations));
        let label = |component| QuantityLabel::new(prefix, component, self.number + 1);
        define_as(self.equations, label, subtracted(one, &other))
    }

    fn difference(&mut self, prefix: &'static str, row: usize, a: Scalar, b: Scalar) -> Scalar {
        let sum = Sum::total(&[a, -b]);
        self.equations.define(self.label(prefix, row), sum)
    }

    /// The entries of a row of the Jacobian, one for each joint of either chain.
    pub(super) fn entries(
        jacobians: &[Vec<JacobianColumn>; 2],
        pick: impl Fn(&JacobianColumn) -> Scalar,
    ) -> Vec<(usize, Scalar)> {
        let mut entries = Vec::new();
        for (side, jacobian) in jacobians.iter().enumerate() {
            for column in jacobian {
                let entry = pick(column).negated_if(side == 1);
                if !entry.is_zero() {
                    entries.push((column.0, entry));
                }
            }
        }
        entries.sort_unstable_by_key(|&(joint, _)| joint);
        entries
    }

    fn ball(&mut self, cut: &Cut, ends: &[Chain; 2], rows: &mut Vec<ConstraintRow>) {
        let jacobians = [0, 1].map(|side| ends[side].jacobian(self.equations, self.parameters));
        let span = self.span("h", ends);
        let seconds = self.accelerations(ends);
        for k in (0..3).filter(|&k| !cut.ignore[k]) {
            let jdqd = self.difference("jdqd", k, seconds[0].0[k], seconds[1].0[k]);
            rows.push(ConstraintRow {
                h: span[k],
                jacobian: Self::entries(&jacobians, |column| column.1[k]),
                jdqd,
            });
        }
    }

    /// Linear and angular acceleration of both ends without joint accelerations.
    fn accelerations(&mut self, ends: &[Chain; 2]) -> [(Vector, Vector); 2] {
        if self.part == ConstraintPart::Position {
            return [(ZERO, ZERO); 2];
        }
        [0, 1].map(|side| {
            let motion = ends[side].motion(self.equations, self.parameters, &[]);
            (motion.acceleration, motion.angular_acceleration)
        })
    }

    fn rotation(&mut self, cut: &Cut, ends: &[Chain; 2], rows: &mut Vec<ConstraintRow>) {
        let mut axes = [ends[0].axes(), ends[1].axes()];
        if let Some(rotation) = cut.rotation {
            axes[1] = self.turned(&axes[1], &rotation);
        }
        let jacobians = [0, 1].map(|side| ends[side].jacobian(self.equations, self.parameters));
        let seconds = self.accelerations(ends);
        for (k, (r, s)) in [(2, 1), (0, 2), (1, 0)].into_iter().enumerate() {
            let mut sum = Sum::new();
            for (one, other) in axes[0].iter().zip(&axes[1]) {
                sum.add(&[one[r], other[s]]);
            }
            let h = self.equations.define(self.label("h", 3 + k), sum);
            let jdqd = self.difference("jdqd", 3 + k, seconds[0].1[k], seconds[1].1[k]);
            rows.push(ConstraintRow {
                h,
                jacobian: Self::entries(&jacobians, |column| column.2[k]),
                jdqd,
            });
        }
    }

    /// Axes after a constant rotation.
    fn turned(&mut self, axes: &Matrix, rotation: &[[f64; 3]; 3]) -> Matrix {
        let turned = rotation.iter().enumerate().map(|(k, row)| {
            let mut sums = sums();
            for (axis, &number) in axes.iter().zip(row) {
                let number = self.equations.number(number);
                for (sum, &component) in sums.iter_mut().zip(axis) {
                    sum.add(&[number, component]);
                }
            }
            let label =
                |component| QuantityLabel::new("XT", component, self.number + 1).column(k + 1);
            define_as(self.equations, label, sums)
        });
        let turned: Vec<Vector> = turned.collect();
        [turned[0], turned[1], turned[2]]
    }

    fn rod(
        &mut self,
        ends: &[Chain; 2],
        (rod, length): (usize, f64),
        options: &Options,
        rows: &mut Vec<ConstraintRow>,
    ) {
        let span = self.span("Plp", ends);
        let length = ParameterSource {
            options,
            equations: self.equations,
        }
        .parameter("lrod", &[rod + 1], length);
        let mut square = Sum::new();
        for component in span {
            square.add(&[component, component]);
        }
        square.subtract(&[length, length]);
        let half = self.equations.number(0.5);
        let group = self.equations.group(square);
        let mut h = Sum::new();
        h.add_term(group.and_then(|group| group.times(&[half])));
        let h = self.equations.define(self.label("h", 0), h);
        let jacobians = [0, 1].map(|side| ends[side].jacobian(self.equations, self.parameters));
        let mut jacobian = Vec::new();
        for (side, columns) in jacobians.iter().enumerate() {
            for (joint, linear, _) in columns {
                let mut entry = Sum::new();
                for (component, &value) in span.iter().zip(linear) {
                    entry.add(&[*component, value.negated_if(side == 1)]);
                }
                let label = self.label("Jac", 0).column(joint + 1);
                let entry = self.equations.define(label, entry);
                if !entry.is_zero() {
                    jacobian.push((*joint, entry));
                }
            }
        }
        jacobian.sort_unstable_by_key(|&(joint, _)| joint);
        rows.push(ConstraintRow {
            h,
            jacobian,
            jdqd: self.rod_acceleration(ends, &span),
        });
    }

    /// `P.(a_A - a_B) + |v_A - v_B|^2`.
    fn rod_acceleration(&mut self, ends: &[Chain; 2], span: &Vector) -> Scalar {
        if self.part == ConstraintPart::Position {
            return Scalar::ZERO;
        }
        let [a, b] = [0, 1].map(|side| ends[side].motion(self.equations, self.parameters, &[]));
        let mut sum = Sum::new();
        for k in 0..3 {
            let second = self.difference("Alp", k, a.acceleration[k], b.acceleration[k]);
            let velocity = self.difference("Vlp", k, a.velocity[k], b.velocity[k]);
            sum.add(&[span[k], second]);
            sum.add(&[velocity, velocity]);
        }
        self.equations.define(self.label("jdqd", 0), sum)
    }
}
