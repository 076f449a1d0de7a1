//! Rows of loops as they change: first and second derivatives of their Jacobian
//! `J` by time, and of the forces `J^T lambda` by positions.
//!
//! A turn of the bodies beyond joint i about its axis `s_i` turns the columns of
//! the joints beyond it, so that for the force `F` of a ball
//!
//! ```text
//! d(F.J_j)/dq_i = F.(s_i x J_j) = (F x s_i).J_j        i before j, or i = j
//! ```
//!
//! which is symmetric. For the torque of a solid only joints before j count. A
//! rod's force is `lambda P`, which changes with its span `P` as well.

use super::Options;
use super::algebra::{Scalar, Sum, dot};
use super::chain::{Chain, JacobianColumn};
use super::constraints::{ConstraintPart, ConstraintWriter};
use super::derivative::JointEntry;
use super::equations::{Equations, QuantityLabel};
use super::parameters::ModelParameters;
use super::vector::{Vector, ZERO, add_cross, define_as, sums};
use robovec_model::CutKind;

/// A row, by joint; joints that are missing are zero.
pub(super) type JointRow = Vec<(usize, Scalar)>;

/// Changes of all rows that some joint changes, in their order.
#[derive(Default)]
pub(super) struct LoopRates {
    /// The derivative of `J` by time.
    pub(super) first: Vec<JointRow>,
    /// Its second derivative.
    pub(super) second: Vec<JointRow>,
    /// Derivatives of `J^T lambda` by positions; entries of a place add up.
    pub(super) stiffness: Vec<JointEntry>,
}

impl LoopRates {
    /// Writes changes for all accelerations and for a multiplier of each row.
    pub(super) fn new(
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        options: &Options,
        accelerations: &[Scalar],
        multiplier: impl Fn(usize) -> Scalar,
    ) -> LoopRates {
        let mut found = LoopRates::default();
        for (number, cut) in parameters.model.cuts.iter().enumerate() {
            let mut writer = ConstraintWriter {
                equations,
                parameters,
                part: ConstraintPart::Position,
                number,
            };
            let rows = writer.rows(options);
            let components: Vec<usize> = match cut.kind {
                CutKind::Rod(_) | CutKind::Coupling(_) => vec![0],
                CutKind::Ball => (0..3).filter(|&k| !cut.ignore[k]).collect(),
                CutKind::Solid => (0..6).filter(|&k| k > 2 || !cut.ignore[k]).collect(),
            };
            assert_eq!(rows.len(), components.len(), "one component per row");
            let kept = components.into_iter().zip(&rows);
            let kept = kept.filter(|(_, row)| !row.jacobian.is_empty());
            let kept: Vec<(usize, Scalar)> = (found.first.len()..)
                .zip(kept)
                .map(|(row, (component, _))| (component, multiplier(row)))
                .collect();
            if let CutKind::Coupling(_) = cut.kind {
                found.first.extend(kept.iter().map(|_| JointRow::new()));
                found.second.extend(kept.iter().map(|_| JointRow::new()));
                continue;
            }
            let ends = writer.ends(options);
            let mut change = CutRates {
                columns: [0, 1].map(|side| ends[side].jacobian(writer.equations, parameters)),
                first: [0, 1].map(|side| ends[side].jacobian_rate(writer.equations, parameters)),
                second: [0, 1].map(|side| {
                    ends[side].jacobian_second_rate(writer.equations, parameters, accelerations)
                }),
                writer,
                ends,
                found: &mut found,
            };
            match cut.kind {
                CutKind::Rod(_) => change.rod(&kept, accelerations),
                _ => change.ends(&kept),
            }
        }
        found
    }
}

/// Writer of the changes of one cut.
struct CutRates<'e, 'p, 'm> {
    writer: ConstraintWriter<'e, 'p, 'm>,
    ends: [Chain; 2],
    columns: [Vec<JacobianColumn>; 2],
    first: [Vec<JacobianColumn>; 2],
    second: [Vec<JacobianColumn>; 2],
    found: &'e mut LoopRates,
}

impl CutRates<'_, '_, '_> {
    /// Rows of a ball or a solid: components from 0, with multipliers.
    fn ends(&mut self, rows: &[(usize, Scalar)]) {
        let mut forces = [ZERO; 2];
        for &(component, multiplier) in rows {
            let (kind, axis) = (component / 3, component % 3);
            forces[kind][axis] = multiplier;
            let pick = |column: &JacobianColumn| [column.1, column.2][kind][axis];
            self.found
                .first
                .push(ConstraintWriter::entries(&self.first, pick));
            self.found
                .second
                .push(ConstraintWriter::entries(&self.second, pick));
        }
        self.turned(&forces);
    }

    /// The row of a rod: `J = P.(J_A - J_B)`.
    fn rod(&mut self, rows: &[(usize, Scalar)], accelerations: &[Scalar]) {
        let &[(_, multiplier)] = rows else { return };
        let parameters = self.writer.parameters;
        let two = self.writer.equations.number(2.0);
        let span = self.writer.span("Plp", &self.ends);
        let [one, other] = [0, 1]
            .map(|side| self.ends[side].motion(self.writer.equations, parameters, accelerations));
        let mut define = |prefix, sum: &dyn Fn(usize) -> Sum| -> Vector {
            let label = |component| QuantityLabel::new(prefix, component, self.writer.number + 1);
            define_as(self.writer.equations, label, [0, 1, 2].map(sum))
        };
        let difference = |a: &Vector, b: &Vector, k: usize| Sum::total(&[a[k], -b[k]]);
        let rate = define("Vlp", &|k| difference(&one.velocity, &other.velocity, k));
        let second = define("Alp", &|k| {
            difference(&one.acceleration, &other.acceleration, k)
        });
        let force = define("Flp", &|k| Sum::product(&[span[k], multiplier]));
        let doubled = define("Wlp", &|k| Sum::product(&[two, rate[k]]));
        let (mut first_row, mut second_row) = (JointRow::new(), JointRow::new());
        for side in 0..2 {
            for place in 0..self.columns[side].len() {
                let joint = self.columns[side][place].0;
                let [column, first, next] =
                    [&self.columns, &self.first, &self.second].map(|all| all[side][place].1);
                let mut sum = dot(&rate, &column);
                sum.add_sum(&dot(&span, &first));
                let value = self.named("JR", side, (joint, 0), sum);
                first_row.push((joint, value.negated_if(side == 1)));
                let mut sum = dot(&second, &column);
                sum.add_sum(&dot(&doubled, &first));
                sum.add_sum(&dot(&span, &next));
                let value = self.named("JS", side, (joint, 0), sum);
                second_row.push((joint, value.negated_if(side == 1)));
            }
        }
        self.found.first.push(first_row);
        self.found.second.push(second_row);
        self.turned(&[force, ZERO]);
        self.stretched(multiplier);
    }

    /// Forces on joints as bodies beyond others turn, for a wrench on one end.
    fn turned(&mut self, [force, torque]: &[Vector; 2]) {
        for side in 0..2 {
            for place in 0..self.columns[side].len() {
                let (joint, _, axis) = self.columns[side][place];
                if !self.writer.parameters.is_revolute(joint) {
                    continue;
                }
                let [lever, twist] = [("LF", force), ("LT", torque)].map(|(prefix, load)| {
                    let mut cross = sums();
                    add_cross(&mut cross, load, &axis, side == 1);
                    self.ends[side].define(self.writer.equations, prefix, joint + 1, 0, cross)
                });
                for beyond in place..self.columns[side].len() {
                    let (other, linear, turning) = self.columns[side][beyond];
                    let both = dot(&lever, &linear);
                    let both = self.named("LJ", side, (joint, other + 1), both);
                    self.keep(other, joint, both);
                    if other != joint {
                        self.keep(joint, other, both);
                        let sum = dot(&twist, &turning);
                        let value = self.named("LS", side, (joint, other + 1), sum);
                        self.keep(other, joint, value);
                    }
                }
            }
        }
    }

    /// The forces on joints as the span of a rod changes.
    fn stretched(&mut self, multiplier: Scalar) {
        let all: Vec<(usize, usize, Vector)> = (0..2)
            .flat_map(|side| {
                let columns = self.columns[side].iter();
                columns.map(move |&(joint, linear, _)| {
                    let signed = linear.map(|value| value.negated_if(side == 1));
                    (side, joint, signed)
                })
            })
            .collect();
        for &(side, joint, linear) in &all {
            let scaled = linear.map(|value| Sum::product(&[multiplier, value]));
            let scaled = self.ends[side].define(self.writer.equations, "LP", joint + 1, 0, scaled);
            for &(_, other, column) in &all {
                let sum = dot(&scaled, &column);
                let value = self.named("LQ", side, (joint, other + 1), sum);
                self.keep(joint, other, value);
            }
        }
    }

    fn named(
        &mut self,
        prefix: &'static str,
        side: usize,
        (joint, column): (usize, usize),
        sum: Sum,
    ) -> Scalar {
        let label = self.ends[side].label(prefix, 0, joint + 1).column(column);
        self.writer.equations.define(label, sum)
    }

    fn keep(&mut self, row: usize, column: usize, value: Scalar) {
        if !value.is_zero() {
            self.found.stiffness.push((row, column, value));
        }
    }
}
