//! Equilibria and small motions of the example models under their laws, against
//! the reference: its residual at the equilibrium, and differences of it in
//! double-double around it, with loops closed by a separate Newton method.

use crate::reference::dynamics::{inverse_dynamics, mass_matrix};
use crate::reference::forces::{add_external, add_links, link_lengths};
use crate::reference::kinematics::{anchor, frames, point};
use crate::reference::loops::constraints;
use crate::reference::spatial::zeros;
use crate::reference::{Real, State, Tree};
use robovec::kinematics::linear::{DenseMatrix, eliminate};
use robovec::model::mbs::read_mbs;
use robovec::model::{Anchor, Model};
use robovec::motion::{EquationSetting, Laws, MultibodySystem, SmallMotions, modes};
use robovec_num::double_double::Double;
use std::path::Path;

/// The step of differences; its square is the error they leave.
const STEP: f64 = 1e-9;

fn number(value: f64) -> Double {
    Double::from(value)
}

/// Solves a system by elimination with partial pivoting.
fn solve(mut rows: Vec<Vec<Double>>, mut right: Vec<Double>) -> Vec<Double> {
    let n = right.len();
    for k in 0..n {
        let pivot = (k..n)
            .max_by(|&a, &b| {
                rows[a][k]
                    .value()
                    .abs()
                    .total_cmp(&rows[b][k].value().abs())
            })
            .expect("rows are left");
        rows.swap(k, pivot);
        right.swap(k, pivot);
        for row in k + 1..n {
            let factor = rows[row][k] / rows[k][k];
            let above = rows[k].clone();
            for (entry, known) in rows[row].iter_mut().zip(above).skip(k) {
                *entry = *entry - factor * known;
            }
            right[row] = right[row] - factor * right[k];
        }
    }
    for k in (0..n).rev() {
        let known = (k + 1..n).fold(right[k], |sum, j| sum - rows[k][j] * right[j]);
        right[k] = known / rows[k][k];
    }
    right
}

/// A model under laws, with its joints divided as in the system.
struct Standing<'m> {
    model: &'m Model,
    laws: Laws,
    independent: Vec<usize>,
    dependent: Vec<usize>,
    rows: Vec<usize>,
}

impl Standing<'_> {
    /// The columns of joints in the rows that count.
    fn columns(&self, jacobian: &[Vec<Double>], joints: &[usize]) -> Vec<Vec<Double>> {
        let row = |&row: &usize| joints.iter().map(|&joint| jacobian[row][joint]).collect();
        self.rows.iter().map(row).collect()
    }

    /// Chooses rows that determine the dependent joints.
    fn choose_rows(&mut self, state: &State<Double>) {
        let jacobian = constraints(self.model, state).jacobian;
        let mut matrix = DenseMatrix::zeros(jacobian.len(), self.dependent.len());
        for (row, entries) in jacobian.iter().enumerate() {
            for (column, &joint) in self.dependent.iter().enumerate() {
                matrix[(row, column)] = entries[joint].value();
            }
        }
        let pivots = eliminate(matrix, &vec![1.0; self.dependent.len()], 1e-9);
        assert_eq!(pivots.len(), self.dependent.len());
        self.rows = pivots.iter().map(|pivot| pivot.row).collect();
    }

    /// Closes the loops, in positions and velocities.
    fn close(&self, state: &mut State<Double>) {
        for _ in 0..8 {
            let rows = constraints(self.model, state);
            let left = self.rows.iter().map(|&row| rows.residual[row]).collect();
            let step = solve(self.columns(&rows.jacobian, &self.dependent), left);
            for (&joint, step) in self.dependent.iter().zip(step) {
                state.q[joint] = state.q[joint] - step;
            }
        }
        let rows = constraints(self.model, state);
        let moved = self.rows.iter().map(|&row| {
            let each = self.independent.iter();
            each.fold(Double::zero(), |sum, &joint| {
                sum - rows.jacobian[row][joint] * state.qd[joint]
            })
        });
        let rates = solve(
            self.columns(&rows.jacobian, &self.dependent),
            moved.collect(),
        );
        for (&joint, rate) in self.dependent.iter().zip(rates) {
            state.qd[joint] = rate;
        }
    }

    /// The motion of all joints for each of the independent ones.
    fn transform(&self, state: &State<Double>) -> Vec<Vec<Double>> {
        let rows = constraints(self.model, state);
        let column = |&independent: &usize| {
            let mut moved = vec![Double::zero(); state.q.len()];
            moved[independent] = number(1.0);
            let right = self
                .rows
                .iter()
                .map(|&row| -rows.jacobian[row][independent]);
            let rates = solve(
                self.columns(&rows.jacobian, &self.dependent),
                right.collect(),
            );
            for (&joint, rate) in self.dependent.iter().zip(rates) {
                moved[joint] = rate;
            }
            moved
        };
        self.independent.iter().map(column).collect()
    }

    /// The forces of the laws on bodies and joints.
    fn loaded(&self, state: &State<Double>) -> (State<Double>, Vec<Double>) {
        let strengths: Vec<Double> = link_lengths(self.model, state)
            .into_iter()
            .zip(&self.laws.links)
            .map(|((length, rate), law)| {
                let neutral = number(law.neutral.expect("laws are settled"));
                number(law.force)
                    + number(law.damping) * rate
                    + number(law.stiffness) * (length - neutral)
            })
            .collect();
        let loaded = add_links(self.model, state, &strengths);
        let tree = Tree::new(self.model);
        let frames = frames(&tree, state, zeros());
        let external: Vec<[Double; 9]> = self
            .model
            .forces
            .iter()
            .zip(&self.laws.forces)
            .map(|(force, law)| {
                let at = &self.model.points[force.point];
                let place = Anchor {
                    body: at.body,
                    point: Some(force.point),
                };
                let (joint, place) = anchor(self.model, &place);
                let moved = point(&tree, &frames, joint, place);
                let held = law.place.expect("laws are settled");
                let mut numbers = [Double::zero(); 9];
                for k in 0..3 {
                    numbers[k] = number(law.force[k])
                        - number(law.damping[k]) * moved.velocity[k]
                        - number(law.stiffness[k]) * (moved.position[k] - number(held[k]));
                    numbers[3 + k] = number(law.torque[k]);
                    numbers[6 + k] = number(at.coordinates[k]);
                }
                numbers
            })
            .collect();
        let loaded = add_external(self.model, &loaded, &external);
        let of_joints = self.laws.joints.iter().enumerate().map(|(joint, law)| {
            let neutral = number(law.neutral.expect("laws are settled"));
            number(law.force)
                - number(law.damping) * state.qd[joint]
                - number(law.stiffness) * (state.q[joint] - neutral)
        });
        (loaded, of_joints.collect())
    }

    /// Residual of the equations, for each independent joint, without
    /// accelerations of these.
    fn residual(&self, state: &State<Double>) -> Vec<Double> {
        let mut closed = state.clone();
        self.close(&mut closed);
        let rows = constraints(self.model, &closed);
        let right = self.rows.iter().map(|&row| -rows.quadratic[row]);
        let rates = solve(
            self.columns(&rows.jacobian, &self.dependent),
            right.collect(),
        );
        let (mut loaded, of_joints) = self.loaded(&closed);
        for (&joint, rate) in self.dependent.iter().zip(rates) {
            loaded.qdd[joint] = rate;
        }
        let needed = inverse_dynamics(&Tree::new(self.model), &loaded);
        let project = |column: Vec<Double>| {
            let each = column.into_iter().zip(&needed).zip(&of_joints);
            each.fold(Double::zero(), |sum, ((part, &needed), &given)| {
                sum + part * (needed - given)
            })
        };
        self.transform(&closed).into_iter().map(project).collect()
    }
}

/// Compares a matrix with the reference's, relative to its largest entry.
fn compare(what: &str, found: impl Fn(usize, usize) -> f64, expected: &[Vec<Double>]) {
    let all = expected.iter().flatten();
    let most = all.fold(0.0f64, |most, x| most.max(x.value().abs()));
    for (row, entries) in expected.iter().enumerate() {
        for (column, entry) in entries.iter().enumerate() {
            let error = (*entry - number(found(row, column))).value().abs();
            assert!(
                error <= 1e-12 * most,
                "{what}[{row},{column}]: {} is not {} (up to {most})",
                found(row, column),
                entry.value()
            );
        }
    }
}

fn check_motions(standing: &Standing<'_>, state: &State<Double>, motions: &SmallMotions) {
    let count = standing.independent.len();
    let mut stiffness = vec![vec![Double::zero(); count]; count];
    let mut damping = stiffness.clone();
    for (column, &joint) in standing.independent.iter().enumerate() {
        for (by_velocity, matrix) in [(false, &mut stiffness), (true, &mut damping)] {
            let left = |step: f64| {
                let mut moved = state.clone();
                let numbers = if by_velocity {
                    &mut moved.qd
                } else {
                    &mut moved.q
                };
                numbers[joint] = numbers[joint] + number(step);
                standing.residual(&moved)
            };
            let pairs = left(STEP).into_iter().zip(left(-STEP));
            for (row, (after, before)) in pairs.enumerate() {
                matrix[row][column] = (after - before) / number(2.0 * STEP);
            }
        }
    }
    compare(
        "K",
        |row, column| motions.stiffness[(row, column)],
        &stiffness,
    );
    compare("D", |row, column| motions.damping[(row, column)], &damping);
    let transform = standing.transform(state);
    let masses = mass_matrix(&Tree::new(standing.model), state);
    let product = |one: &[Double], other: &[Double]| {
        let rows = masses.iter().zip(one);
        rows.fold(Double::zero(), |sum, (row, &part)| {
            let each = row.iter().zip(other);
            sum + part * each.fold(Double::zero(), |sum, (&mass, &part)| sum + mass * part)
        })
    };
    let mass: Vec<Vec<Double>> = transform
        .iter()
        .map(|one| transform.iter().map(|other| product(one, other)).collect())
        .collect();
    compare("M", |row, column| motions.mass[(row, column)], &mass);
    check_modes(motions, [&mass, &damping, &stiffness]);
}

/// Every eigenvalue makes the reference's polynomial singular, within the
/// reported error: its residual with its shape is zero.
fn check_modes(motions: &SmallMotions, [mass, damping, stiffness]: [&[Vec<Double>]; 3]) {
    let found = modes(motions).expect("bodies have mass");
    let pairs = |mode: &robovec::motion::Mode| 1 + usize::from(mode.eigenvalue.im > 0.0);
    let count: usize = found.iter().map(pairs).sum();
    assert_eq!(count, 2 * motions.joints.len());
    for mode in &found {
        let Some(error) = mode.error else { continue };
        let s = mode.eigenvalue;
        assert!(error <= 1e-9 * s.norm(), "{s}: {error:e}");
        for row in 0..mass.len() {
            let mut left = s * 0.0;
            let mut size = 0.0;
            for (column, &joint) in motions.joints.iter().enumerate() {
                let entry = |matrix: &[Vec<Double>]| matrix[row][column].value();
                let term = s * s * entry(mass) + s * entry(damping) + entry(stiffness);
                left += term * mode.shape[joint];
                let sizes = [
                    s.norm_sqr() * entry(mass),
                    s.norm() * entry(damping),
                    entry(stiffness),
                ];
                size += sizes.iter().map(|size| size.abs()).sum::<f64>();
            }
            assert!(
                left.norm() <= 1e-11 * size,
                "{s}, row {row}: {left} of {size:e}"
            );
        }
    }
}

#[test]
fn equilibria_and_small_motions_are_those_of_the_reference() {
    for name in ["quarter-car", "bogie", "car", "leg"] {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
        let bytes = std::fs::read(root.join(format!("models/{name}.mbs"))).expect("an example");
        let model = read_mbs(name, &bytes).expect("an example").model;
        let text = std::fs::read_to_string(root.join(format!("laws/{name}.toml")));
        let laws = Laws::parse(&model, &text.expect("an example"));
        let laws = laws.expect("an example").at_rest();
        let setting = EquationSetting::default();
        let (mut system, initial) =
            MultibodySystem::new(&model, laws, &setting).expect("it starts");
        let found = system.equilibrium(&initial).expect("it stands");
        let partition = system.partition();
        let mut standing = Standing {
            model: &model,
            laws: system.settled_laws(),
            independent: partition.independent.clone(),
            dependent: partition.dependent.clone(),
            rows: Vec::new(),
        };
        let joints = model.joints.len();
        let mut state = State {
            q: found.state.q.clone(),
            qd: vec![0.0; joints],
            qdd: vec![0.0; joints],
            frc: vec![[0.0; 3]; joints],
            trq: vec![[0.0; 3]; joints],
        }
        .convert(Double::from);
        standing.choose_rows(&state);
        standing.close(&mut state);
        // The equilibrium of the reference lies within the errors told.
        let left = standing.residual(&state);
        let stiffness = |row: usize| {
            let columns = 0..found.errors.len();
            let each = columns.filter_map(|column| {
                let error = found.errors[column]?;
                Some((found.motions.stiffness[(row, column)] * error).abs())
            });
            each.sum::<f64>()
        };
        for (row, left) in left.iter().enumerate() {
            let allowed = stiffness(row) + 1e-9 * found.motions.rounding[row];
            assert!(
                left.value().abs() <= allowed || found.errors[row].is_none(),
                "{name}, {row}: {} of {allowed:e}",
                left.value()
            );
        }
        check_motions(&standing, &state, &found.motions);
    }
}
