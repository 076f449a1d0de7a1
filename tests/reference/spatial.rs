//! Vectors, matrices and the operators of spatial algebra.

use super::Real;
use std::array::from_fn;

/// Three coordinates.
pub(crate) type Vector3<T> = [T; 3];
/// Three by three, row by row.
pub(crate) type Matrix3<T> = [[T; 3]; 3];
/// Plücker coordinates: angular part, then linear part.
pub(crate) type Vector6<T> = [T; 6];
/// Six by six, row by row.
pub(crate) type Matrix6<T> = [[T; 6]; 6];

/// `a + b`.
pub(crate) fn add<T: Real, const N: usize>(a: [T; N], b: [T; N]) -> [T; N] {
    from_fn(|i| a[i] + b[i])
}

/// `a - b`.
pub(crate) fn sub<T: Real, const N: usize>(a: [T; N], b: [T; N]) -> [T; N] {
    from_fn(|i| a[i] - b[i])
}

/// `factor * a`.
pub(crate) fn scale<T: Real, const N: usize>(factor: T, a: [T; N]) -> [T; N] {
    a.map(|x| factor * x)
}

/// The sum of products.
pub(crate) fn dot<T: Real, const N: usize>(a: [T; N], b: [T; N]) -> T {
    (0..N).fold(T::zero(), |sum, i| sum + a[i] * b[i])
}

/// Matrix times vector.
pub(crate) fn apply<T: Real, const R: usize, const C: usize>(m: &[[T; C]; R], v: [T; C]) -> [T; R] {
    from_fn(|i| dot(m[i], v))
}

/// Matrix times matrix.
pub(crate) fn product<T: Real, const R: usize, const K: usize, const C: usize>(
    a: &[[T; K]; R],
    b: &[[T; C]; K],
) -> [[T; C]; R] {
    from_fn(|i| from_fn(|j| (0..K).fold(T::zero(), |sum, k| sum + a[i][k] * b[k][j])))
}

/// Rows for columns.
pub(crate) fn transpose<T: Real, const R: usize, const C: usize>(m: &[[T; C]; R]) -> [[T; R]; C] {
    from_fn(|i| from_fn(|j| m[j][i]))
}

/// A zero vector.
pub(crate) fn zeros<T: Real, const N: usize>() -> [T; N] {
    [T::zero(); N]
}

/// The unit matrix.
pub(crate) fn identity<T: Real, const N: usize>() -> [[T; N]; N] {
    from_fn(|i| from_fn(|j| T::from(f64::from(u8::from(i == j)))))
}

/// The matrix of the cross product: `skew(a) b = a x b`.
pub(crate) fn skew<T: Real>([x, y, z]: Vector3<T>) -> Matrix3<T> {
    let o = T::zero();
    [[o, -z, y], [z, o, -x], [-y, x, o]]
}

/// `a x b`.
pub(crate) fn cross<T: Real>(a: Vector3<T>, b: Vector3<T>) -> Vector3<T> {
    apply(&skew(a), b)
}

/// The six coordinates of an angular and a linear part.
pub(crate) fn join<T: Real>(angular: Vector3<T>, linear: Vector3<T>) -> Vector6<T> {
    from_fn(|i| if i < 3 { angular[i] } else { linear[i - 3] })
}

/// The angular part.
pub(crate) fn angular<T: Real>(v: Vector6<T>) -> Vector3<T> {
    from_fn(|i| v[i])
}

/// The linear part.
pub(crate) fn linear<T: Real>(v: Vector6<T>) -> Vector3<T> {
    from_fn(|i| v[i + 3])
}

/// Four blocks.
fn blocks<T: Real>(b: [[Matrix3<T>; 2]; 2]) -> Matrix6<T> {
    from_fn(|i| from_fn(|j| b[i / 3][j / 3][i % 3][j % 3]))
}

/// The Plücker transform of motion vectors into a frame whose origin is at
/// `place` and whose axes are the rows of `rotation`, both in the old frame.
pub(crate) fn plucker<T: Real>(rotation: &Matrix3<T>, place: Vector3<T>) -> Matrix6<T> {
    let o = [zeros(); 3];
    let shifted = product(rotation, &skew(place)).map(|row| row.map(|x| -x));
    blocks([[*rotation, o], [shifted, *rotation]])
}

/// The spatial inertia about the origin of the frame of `center` and `inertia`
/// (about the centre).
pub(crate) fn spatial_inertia<T: Real>(
    mass: T,
    center: Vector3<T>,
    inertia: &Matrix3<T>,
) -> Matrix6<T> {
    let c = skew(center);
    let first = c.map(|row| scale(mass, row));
    let steiner = product(&first, &transpose(&c));
    blocks([
        [from_fn(|i| add(inertia[i], steiner[i])), first],
        [
            transpose(&first),
            identity::<T, 3>().map(|row| scale(mass, row)),
        ],
    ])
}

/// The derivative of a motion vector that is carried along with velocity `v`.
pub(crate) fn cross_motion<T: Real>(v: Vector6<T>, m: Vector6<T>) -> Vector6<T> {
    let (w, u) = (angular(v), linear(v));
    join(
        cross(w, angular(m)),
        add(cross(w, linear(m)), cross(u, angular(m))),
    )
}

/// The derivative of a force vector that is carried along with velocity `v`.
pub(crate) fn cross_force<T: Real>(v: Vector6<T>, f: Vector6<T>) -> Vector6<T> {
    let (w, u) = (angular(v), linear(v));
    join(
        add(cross(w, angular(f)), cross(u, linear(f))),
        cross(w, linear(f)),
    )
}
