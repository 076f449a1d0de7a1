//! Inertias and forces of composite bodies, over any ring.
//!
//! Everything is in the axes of a joint's frame and about its origin. A unit
//! acceleration of joint j gives the frame the angular part `OM` and the
//! linear part `AM` (Robotran's names); the body, and the joints beyond it,
//! then need the force `FM` and the torque `CM` with
//!
//! ```text
//! FM = a*AM + b*OM        CM = b'*AM + d*OM
//! ```
//!
//! Over the reals with true sines `a` is the mass times the identity and `b` is
//! skew, but nothing here uses that: with free sines and cosines a rotation
//! does not keep lengths. Nor is `d` taken to be symmetric: Robotran leaves out
//! zero parameters of a model, and models exist that give the products of
//! inertia on one side of the diagonal only.

/// Numbers to compute with: those of probes while a tree is looked for, values
/// of a network when its equations are written.
pub(super) trait Ring {
    type Number: Copy;
    fn zero(&mut self) -> Self::Number;
    fn add(&mut self, a: Self::Number, b: Self::Number) -> Self::Number;
    fn sub(&mut self, a: Self::Number, b: Self::Number) -> Self::Number;
    fn mul(&mut self, a: Self::Number, b: Self::Number) -> Self::Number;
    /// True when two numbers are known to be equal.
    fn same(&self, a: Self::Number, b: Self::Number) -> bool;
}

pub(super) type RingVector<N> = [N; 3];
pub(super) type RingMatrix<N> = [[N; 3]; 3];

/// The kind of a joint: about or along an axis (0 to 2) of its frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum JointAxis {
    Revolute(usize),
    Prismatic(usize),
}

/// A body: mass, centre of mass, inertia about it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct RigidBody<N> {
    pub(super) mass: N,
    pub(super) centre: RingVector<N>,
    pub(super) inertia: RingMatrix<N>,
}

impl<N> RigidBody<N> {
    /// The body with each of its parameters replaced.
    pub(super) fn map<T>(self, mut number: impl FnMut(N) -> T) -> RigidBody<T> {
        RigidBody {
            mass: number(self.mass),
            centre: self.centre.map(&mut number),
            inertia: self.inertia.map(|row| row.map(&mut number)),
        }
    }
}

impl<N> RigidBody<Option<N>> {
    /// True when all its elements are zero.
    pub(super) fn is_absent(&self) -> bool {
        let parts = self.centre.iter().chain(self.inertia.iter().flatten());
        self.mass.is_none() && parts.into_iter().all(Option::is_none)
    }

    /// The body with the missing half of its inertia copied across the
    /// diagonal, if that is requested.
    pub(super) fn mirrored(self, symmetric: bool) -> RigidBody<Option<N>>
    where
        N: Copy,
    {
        let given = self.inertia;
        let entry = |r: usize, c: usize| given[r][c].or(given[c][r].filter(|_| symmetric));
        RigidBody {
            inertia: [0, 1, 2].map(|r| [0, 1, 2].map(|c| entry(r, c))),
            ..self
        }
    }
}

/// The position of a frame on its parent: offset in the parent's axes, the
/// joint's coordinate, and its cosine and sine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stand<N> {
    pub(super) joint: JointAxis,
    pub(super) offset: RingVector<N>,
    pub(super) coordinate: N,
    pub(super) cosine: N,
    pub(super) sine: N,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct CompositeInertia<N> {
    pub(super) a: RingMatrix<N>,
    pub(super) b: RingMatrix<N>,
    pub(super) d: RingMatrix<N>,
}

/// The wrench that a unit acceleration needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnitWrench<N> {
    pub(super) force: RingVector<N>,
    pub(super) torque: RingVector<N>,
}

pub(super) fn cross<R: Ring>(
    ring: &mut R,
    u: RingVector<R::Number>,
    v: RingVector<R::Number>,
) -> RingVector<R::Number> {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
        let (left, right) = (ring.mul(u[i], v[j]), ring.mul(u[j], v[i]));
        ring.sub(left, right)
    })
}

fn transpose<N: Copy>(m: RingMatrix<N>) -> RingMatrix<N> {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[j][i]))
}

impl<N: Copy> Stand<N> {
    /// A vector of the frame in the axes of its parent.
    pub(super) fn turn_back<R: Ring<Number = N>>(
        &self,
        ring: &mut R,
        v: RingVector<N>,
    ) -> RingVector<N> {
        let JointAxis::Revolute(axis) = self.joint else {
            return v;
        };
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut turned = v;
        let (cb, sc) = (ring.mul(self.cosine, v[b]), ring.mul(self.sine, v[c]));
        let (sb, cc) = (ring.mul(self.sine, v[b]), ring.mul(self.cosine, v[c]));
        turned[b] = ring.sub(cb, sc);
        turned[c] = ring.add(sb, cc);
        turned
    }

    /// A vector of the parent in the axes of the frame.
    pub(super) fn turn<R: Ring<Number = N>>(
        &self,
        ring: &mut R,
        v: RingVector<N>,
    ) -> RingVector<N> {
        let zero = ring.zero();
        let back = Stand {
            sine: ring.sub(zero, self.sine),
            ..*self
        };
        back.turn_back(ring, v)
    }

    /// The transpose of the rotation times a matrix times the rotation.
    fn turn_matrix<R: Ring<Number = N>>(&self, ring: &mut R, m: RingMatrix<N>) -> RingMatrix<N> {
        let columns = transpose(m).map(|column| self.turn_back(ring, column));
        transpose(columns).map(|row| self.turn_back(ring, row))
    }

    /// From the parent's origin to the frame's, in the parent's axes.
    pub(super) fn arm<R: Ring<Number = N>>(&self, ring: &mut R) -> RingVector<N> {
        let mut arm = self.offset;
        if let JointAxis::Prismatic(axis) = self.joint {
            arm[axis] = ring.add(arm[axis], self.coordinate);
        }
        arm
    }

    /// A wrench in the axes of the parent, still about the frame's origin.
    pub(super) fn turned<R: Ring<Number = N>>(
        &self,
        ring: &mut R,
        wrench: UnitWrench<N>,
    ) -> UnitWrench<N> {
        UnitWrench {
            force: self.turn_back(ring, wrench.force),
            torque: self.turn_back(ring, wrench.torque),
        }
    }

    /// A wrench on the frame as one on its parent.
    pub(super) fn wrench<R: Ring<Number = N>>(
        &self,
        ring: &mut R,
        wrench: UnitWrench<N>,
    ) -> UnitWrench<N> {
        let turned = self.turned(ring, wrench);
        let arm = self.arm(ring);
        let moment = cross(ring, arm, turned.force);
        let torque = [0, 1, 2].map(|i| ring.add(turned.torque[i], moment[i]));
        UnitWrench { torque, ..turned }
    }

    /// The inertia of the frame's composite body as part of the parent's.
    pub(super) fn inertia<R: Ring<Number = N>>(
        &self,
        ring: &mut R,
        inertia: &CompositeInertia<N>,
    ) -> CompositeInertia<N> {
        if inertia.is_rigid(ring) {
            return self.rigid_inertia(ring, inertia);
        }
        let a = self.turn_matrix(ring, inertia.a);
        let b = self.turn_matrix(ring, inertia.b);
        let d = self.turn_matrix(ring, inertia.d);
        self.shifted_inertia(ring, &CompositeInertia { a, b, d })
    }

    /// As [`Stand::inertia`] where `a` and `d` are symmetric over the reals.
    pub(super) fn symmetric_inertia<R: Ring<Number = N>>(
        &self,
        ring: &mut R,
        inertia: &CompositeInertia<N>,
    ) -> CompositeInertia<N> {
        let a = self.turn_symmetric(ring, &inertia.a);
        let b = self.turn_matrix(ring, inertia.b);
        let d = self.turn_symmetric(ring, &inertia.d);
        self.shifted_inertia(ring, &CompositeInertia { a, b, d })
    }

    /// An inertia in the axes of the parent, about the parent's origin.
    fn shifted_inertia<R: Ring<Number = N>>(
        &self,
        ring: &mut R,
        inertia: &CompositeInertia<N>,
    ) -> CompositeInertia<N> {
        let CompositeInertia { a, b, d } = *inertia;
        let arm = self.arm(ring);
        // AM of the frame is AM - arm~ OM of the parent, and the torque gets
        // arm x FM: with ~ the cross product's matrix,
        // b <- b - a arm~, d <- d - b' arm~ + arm~ (b - a arm~).
        let shifted = [0, 1, 2].map(|r| {
            let moment = cross(ring, a[r], arm);
            [0, 1, 2].map(|c| ring.sub(b[r][c], moment[c]))
        });
        let left = transpose(b).map(|column| cross(ring, column, arm));
        let right = transpose(shifted).map(|column| cross(ring, arm, column));
        let mut full = d;
        for r in 0..3 {
            for c in 0..3 {
                let moved = ring.sub(right[c][r], left[r][c]);
                full[r][c] = ring.add(d[r][c], moved);
            }
        }
        CompositeInertia {
            a,
            b: shifted,
            d: full,
        }
    }
}

impl<N: Copy> Stand<N> {
    /// As [`Stand::inertia`] for a body that is rigid over the reals, with
    /// true sines and cosines: with mass m, first moment h, symmetric moments
    /// J and the arm d, `h <- h + m d`, and J changes by `d.(h + k) E - k d - d h`,
    /// k the new first moment.
    fn rigid_inertia<R: Ring<Number = N>>(
        &self,
        ring: &mut R,
        inertia: &CompositeInertia<N>,
    ) -> CompositeInertia<N> {
        let first = self.turn_back(ring, inertia.first());
        let mut moments = self.turn_symmetric(ring, &inertia.d);
        let mass = inertia.a[0][0];
        let arm = self.arm(ring);
        let moved = [0, 1, 2].map(|i| {
            let product = ring.mul(mass, arm[i]);
            ring.add(first[i], product)
        });
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let both = ring.add(first[i], moved[i]);
            let square = ring.mul(arm[i], both);
            moments[j][j] = ring.add(moments[j][j], square);
            moments[k][k] = ring.add(moments[k][k], square);
            let (row, column) = (j.min(k), j.max(k));
            let one = ring.mul(moved[row], arm[column]);
            let other = ring.mul(first[column], arm[row]);
            let less = ring.sub(moments[row][column], one);
            moments[row][column] = ring.sub(less, other);
            moments[column][row] = moments[row][column];
        }
        CompositeInertia {
            b: skew(ring, moved),
            d: moments,
            ..*inertia
        }
    }

    /// The transpose of the rotation times a symmetric matrix times the
    /// rotation: in the plane of the rotation, with `t = J_bb - J_cc` and
    /// `w = S t + 2 C J_bc`, the entries become `J_bb - S w`, `J_cc + S w` and
    /// `C w - J_bc`, where `S^2 + C^2 = 1`.
    fn turn_symmetric<R: Ring<Number = N>>(
        &self,
        ring: &mut R,
        matrix: &RingMatrix<N>,
    ) -> RingMatrix<N> {
        let JointAxis::Revolute(axis) = self.joint else {
            return *matrix;
        };
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut turned = *matrix;
        let aside = self.turn_back(ring, matrix[axis]);
        for other in [b, c] {
            turned[axis][other] = aside[other];
            turned[other][axis] = aside[other];
        }
        let difference = ring.sub(matrix[b][b], matrix[c][c]);
        let twice = ring.add(self.cosine, self.cosine);
        let (one, other) = (
            ring.mul(self.sine, difference),
            ring.mul(twice, matrix[b][c]),
        );
        let swing = ring.add(one, other);
        let part = ring.mul(self.sine, swing);
        turned[b][b] = ring.sub(matrix[b][b], part);
        turned[c][c] = ring.add(matrix[c][c], part);
        let product = ring.mul(self.cosine, swing);
        turned[b][c] = ring.sub(product, matrix[b][c]);
        turned[c][b] = turned[b][c];
        turned
    }
}

/// Minus the matrix of the cross product with a first moment: the angular part
/// of a force, `OM x h`, for each component of OM.
fn skew<R: Ring>(ring: &mut R, h: RingVector<R::Number>) -> RingMatrix<R::Number> {
    let zero = ring.zero();
    let mut matrix = [[zero; 3]; 3];
    for (i, part) in h.into_iter().enumerate() {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        matrix[j][k] = part;
        matrix[k][j] = ring.sub(zero, part);
    }
    matrix
}

impl<N: Copy> CompositeInertia<N> {
    /// The first moment of a body that is rigid.
    pub(super) fn first(&self) -> RingVector<N> {
        [0, 1, 2].map(|i| self.b[(i + 1) % 3][(i + 2) % 3])
    }

    /// True when it is known to be a mass, a first moment and symmetric
    /// moments, and no more.
    fn is_rigid<R: Ring<Number = N>>(&self, ring: &mut R) -> bool {
        let zero = ring.zero();
        let skew = skew(ring, self.first());
        (0..3).all(|r| {
            (0..3).all(|c| {
                let mass = if r == c { self.a[0][0] } else { zero };
                ring.same(self.a[r][c], mass)
                    && ring.same(self.b[r][c], skew[r][c])
                    && ring.same(self.d[r][c], self.d[c][r])
            })
        })
    }

    /// The composite of no bodies.
    pub(super) fn none<R: Ring<Number = N>>(ring: &mut R) -> CompositeInertia<N> {
        let zero = [[ring.zero(); 3]; 3];
        CompositeInertia {
            a: zero,
            b: zero,
            d: zero,
        }
    }

    pub(super) fn of<R: Ring<Number = N>>(
        ring: &mut R,
        body: &RigidBody<N>,
    ) -> CompositeInertia<N> {
        let zero = ring.zero();
        let moment = body.centre.map(|part| ring.mul(body.mass, part));
        let mut a = [[zero; 3]; 3];
        // FM = m (AM + OM x l).
        let b = skew(ring, moment);
        let mut d = body.inertia;
        for (i, row) in a.iter_mut().enumerate() {
            row[i] = body.mass;
        }
        for r in 0..3 {
            for c in 0..3 {
                let product = ring.mul(moment[r], body.centre[c]);
                if r != c {
                    d[r][c] = ring.sub(d[r][c], product);
                    continue;
                }
                for other in (0..3).filter(|&other| other != r) {
                    let square = ring.mul(moment[other], body.centre[other]);
                    d[r][r] = ring.add(d[r][r], square);
                }
            }
        }
        CompositeInertia { a, b, d }
    }

    /// All its numbers.
    pub(super) fn parts(&self) -> impl Iterator<Item = N> {
        let matrices = [self.a, self.b, self.d];
        matrices.into_iter().flatten().flatten()
    }

    /// The sum of two.
    pub(super) fn plus<R: Ring<Number = N>>(
        &self,
        ring: &mut R,
        other: &CompositeInertia<N>,
    ) -> CompositeInertia<N> {
        let mut sum = |x: &RingMatrix<N>, y: &RingMatrix<N>| {
            [0, 1, 2].map(|r| [0, 1, 2].map(|c| ring.add(x[r][c], y[r][c])))
        };
        CompositeInertia {
            a: sum(&self.a, &other.a),
            b: sum(&self.b, &other.b),
            d: sum(&self.d, &other.d),
        }
    }

    /// Inertia that a free joint leaves, for the wrench of its unit acceleration
    /// and this wrench over its part along the joint. `a` and
    /// `d` are taken to be symmetric.
    pub(super) fn without<R: Ring<Number = N>>(
        &self,
        ring: &mut R,
        joint: JointAxis,
        unit: &UnitWrench<N>,
        share: &UnitWrench<N>,
    ) -> CompositeInertia<N> {
        let zero = ring.zero();
        let mut less = |whole: N, left: N, right: N| {
            let part = ring.mul(left, right);
            ring.sub(whole, part)
        };
        let mut free = *self;
        for r in 0..3 {
            for c in 0..3 {
                free.b[r][c] = less(self.b[r][c], share.force[r], unit.torque[c]);
            }
            for c in r..3 {
                free.a[r][c] = less(self.a[r][c], share.force[r], unit.force[c]);
                free.d[r][c] = less(self.d[r][c], share.torque[r], unit.torque[c]);
                (free.a[c][r], free.d[c][r]) = (free.a[r][c], free.d[r][c]);
            }
        }
        for other in 0..3 {
            match joint {
                JointAxis::Revolute(axis) => {
                    free.b[other][axis] = zero;
                    (free.d[axis][other], free.d[other][axis]) = (zero, zero);
                }
                JointAxis::Prismatic(axis) => {
                    free.b[axis][other] = zero;
                    (free.a[axis][other], free.a[other][axis]) = (zero, zero);
                }
            }
        }
        free
    }

    /// The row of the frame's own joint: the force component that does work in
    /// it, for any acceleration, and by symmetry the force for its own unit
    /// acceleration.
    pub(super) fn wrench(&self, joint: JointAxis) -> UnitWrench<N> {
        match joint {
            JointAxis::Revolute(axis) => UnitWrench {
                force: transpose(self.b)[axis],
                torque: self.d[axis],
            },
            JointAxis::Prismatic(axis) => UnitWrench {
                force: self.a[axis],
                torque: self.b[axis],
            },
        }
    }
}

impl<N: Copy> UnitWrench<N> {
    /// The components of the force, then of the torque.
    pub(super) fn parts(&self) -> impl Iterator<Item = N> {
        self.force.into_iter().chain(self.torque)
    }

    /// The wrench with each component replaced.
    pub(super) fn map(self, mut number: impl FnMut(N) -> N) -> UnitWrench<N> {
        UnitWrench {
            force: self.force.map(&mut number),
            torque: self.torque.map(&mut number),
        }
    }

    /// The wrench with another part along a joint.
    pub(super) fn with(mut self, joint: JointAxis, part: N) -> UnitWrench<N> {
        match joint {
            JointAxis::Revolute(axis) => self.torque[axis] = part,
            JointAxis::Prismatic(axis) => self.force[axis] = part,
        }
        self
    }

    /// The part that does work in a joint.
    pub(super) fn along(&self, joint: JointAxis) -> N {
        match joint {
            JointAxis::Revolute(axis) => self.torque[axis],
            JointAxis::Prismatic(axis) => self.force[axis],
        }
    }
}
