// What a good programmer writes by hand: loops out over the joints and back.
//
// Direct dynamics sees everything from the base frame and its origin, so that
// nothing is turned on the way back: velocities, accelerations and forces of
// the bodies are spatial vectors (angular part first), their inertias are
// mass, first moment and second moment about the origin. Column i of the mass
// matrix is the momentum that a unit velocity of joint i gives to all that it
// carries, seen along the joints before it; for those of an unbranched chain
// the compiler makes vectors of it, since their axes stand side by side.
//
// Inverse dynamics and accelerations work in the frames of the bodies, where a
// joint's axis is a coordinate axis and a turn takes four products.
//
// With BENCH_LANES a number is a vector of so many states; nothing else is
// different.
//
// Featherstone, Rigid Body Dynamics Algorithms (2008), chapters 5 to 7.
#include "peer.h"
#include <cmath>

namespace {

#if BENCH_LANES == 1

typedef double number;

inline void sine_and_cosine(double x, double &sine, double &cosine)
{
    sincos(x, &sine, &cosine);
}

inline double lane_of(double x, int)
{
    return x;
}

#else

typedef double number __attribute__((vector_size(8 * BENCH_LANES)));
typedef long long bits __attribute__((vector_size(8 * BENCH_LANES)));

// Reduction by quarter turns in three parts and the polynomials of fdlibm, for
// angles below a million.
inline void sine_and_cosine(number x, number &sine, number &cosine)
{
    const double rounding = 6755399441055744.0; // 1.5 * 2^52
    const number shifted = x * 0.6366197723675814 + rounding;
    const bits quarter = (bits)shifted;
    const number k = shifted - rounding;
    number r = x - k * 1.57079632673412561417;
    r = r - k * 6.07710050630396597660e-11;
    r = r - k * 2.02226624879595063154e-21;
    const number z = r * r;
    number s = 2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 +
                                                 z * 1.58969099521155010221e-10);
    s = 8.33333333332248946124e-03 + z * (-1.98412698298579493134e-04 + z * s);
    s = r + r * z * (-1.66666666666666324348e-01 + z * s);
    number c = -2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 -
                                                  z * 1.13596475577881948265e-11);
    c = -1.38888888888741095749e-03 + z * (2.48015872894767294178e-05 + z * c);
    c = 1.0 - (0.5 * z - z * z * (4.16666666666666019037e-02 + z * c));
    const bits odd = (quarter & 1) != 0;
    const number a = odd ? c : s, b = odd ? s : c;
    sine = (number)((bits)a ^ ((quarter & 2) << 62));
    cosine = (number)((bits)b ^ (((quarter + 1) & 2) << 62));
}

inline double lane_of(number x, int lane)
{
    return x[lane];
}

#endif

// The element of an array of a group of states.
inline number element(const double *group, int i)
{
    number x;
    memcpy(&x, group + (size_t)i * BENCH_LANES, sizeof x);
    return x;
}

// No power of two: arrays that are read side by side must not meet in the cache.
// Bodies count from 1, the base is 0; joint i carries body i + 1.
enum { MOST = PEER_MOST_JOINTS + 8 };
int parent[MOST], kind[MOST], joints;
bool chain, unmoved[MOST], turned_at[MOST];
const number zero = {};
number result[MOST];

// What a joint does, known where the code is compiled: it turns about axis a,
// or slides along it.
template <bool turning, int axis> struct joint_kind {
    static constexpr bool turns = turning;
    static constexpr int a = axis, b = (axis + 1) % 3, d = (axis + 2) % 3;
};

template <class Step> inline void with_kind(int kind, Step step)
{
    switch (kind) {
    case 0: step(joint_kind<false, 0>()); break;
    case 1: step(joint_kind<false, 1>()); break;
    case 2: step(joint_kind<false, 2>()); break;
    case 3: step(joint_kind<true, 0>()); break;
    case 4: step(joint_kind<true, 1>()); break;
    default: step(joint_kind<true, 2>());
    }
}

template <class X, class Y> inline void add_cross(const X *x, const Y *y, number *z)
{
    z[0] += x[1] * y[2] - x[2] * y[1];
    z[1] += x[2] * y[0] - x[0] * y[2];
    z[2] += x[0] * y[1] - x[1] * y[0];
}

template <class X> inline number dot(const X *x, const number *y)
{
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}

// The constant rotation of a joint: from its frame to the one before, and back.
inline void turned_out(int i, const number *v, number *w)
{
    const double *T = peer_joint_list[i].turn;
    for (int k = 0; k < 3; k++) w[k] = T[3 * k] * v[0] + T[3 * k + 1] * v[1] + T[3 * k + 2] * v[2];
}

inline void turned_in(int i, const number *v, number *w)
{
    const double *T = peer_joint_list[i].turn;
    for (int k = 0; k < 3; k++) w[k] = T[k] * v[0] + T[3 + k] * v[1] + T[6 + k] * v[2];
}

inline void symmetric_times(const double *i, const number *v, number *w)
{
    w[0] = i[0] * v[0] + i[1] * v[1] + i[2] * v[2];
    w[1] = i[1] * v[0] + i[3] * v[1] + i[4] * v[2];
    w[2] = i[2] * v[0] + i[4] * v[1] + i[5] * v[2];
}

#include "loop_direct.h"
#include "loop_bodies.h"

} // namespace

template <bool has_loads> static void evaluate(int group)
{
    const size_t n = (size_t)joints;
    const double *q = peer_group(peer_q, group, n), *qd = peer_group(peer_qd, group, n);
    const double *given = peer_group(peer_given, group, peer_wanted == PEER_DIRDYNA ? 0 : n);
    const double *loads = has_loads ? peer_group(peer_loads, group, 6 * n) : nullptr;
    switch (peer_wanted) {
    case PEER_DIRDYNA: direct<has_loads>(q, qd, loads); break;
    case PEER_INVDYNA: inverse<has_loads>(q, qd, given, loads); break;
    case PEER_ACCELRED: accelerations<has_loads>(q, qd, given, loads);
    }
}

static void peer_evaluate(int group)
{
    peer_has_loads ? evaluate<true>(group) : evaluate<false>(group);
}

static void peer_result(int lane, double *out)
{
    const bool matrix = peer_wanted == PEER_DIRDYNA;
    double *vector = matrix ? out + joints * joints : out;
    for (int i = 0; i < joints; i++) {
        vector[i] = lane_of(result[i], lane);
        for (int j = 0; matrix && j <= i; j++)
            out[i * joints + j] = out[j * joints + i] = lane_of(mass_matrix[i * joints + j], lane);
    }
}

int main(int count, char **words)
{
    peer_read(count, words);
    joints = peer_joints;
    const size_t size = (size_t)joints * joints * sizeof(number);
    mass_matrix = (number *)aligned_alloc(sizeof(number), size);
    if (!mass_matrix) bench_fail("there is no memory for the mass matrix");
    memset(mass_matrix, 0, size);
    chain = true;
    for (int i = 0; i < joints; i++) {
        const peer_joint &joint = peer_joint_list[i];
        const double *d = joint.anchor;
        parent[i] = joint.parent;
        kind[i] = 3 * joint.revolute + joint.axis;
        turned_at[i] = joint.turned;
        unmoved[i] = joint.revolute && d[0] == 0.0 && d[1] == 0.0 && d[2] == 0.0;
        chain = chain && parent[i] == i - 1;
    }
    start_direct();
    start_bodies();
    return peer_main(count, words);
}
