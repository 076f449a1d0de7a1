// What a good programmer writes by hand: one loop out, one loop back.
//
// Everything is seen from the base frame and its origin, so that nothing is
// turned on the way back: velocities, accelerations and forces of the bodies
// are spatial vectors (angular part first), their inertias are mass, first
// moment and second moment about the origin. Column i of the mass matrix is
// the momentum that a unit velocity of joint i gives to all that it carries,
// seen along the joints before it; for those of an unbranched chain the
// compiler makes vectors of it, since their axes stand side by side.
//
// Featherstone, Rigid Body Dynamics Algorithms (2008), chapters 5 and 6.
#include "peer.h"
#include <cmath>

namespace {

// No power of two: arrays that are read side by side must not meet in the cache.
enum { MOST = PEER_MOST_JOINTS + 8 };
int parent[MOST], kind[MOST], joints;
bool chain;
double R[MOST][9], P[MOST][3];             // orientation (columns: axes) and origin
double S[6][MOST];                         // axes of the joints
double V[MOST][6], A[MOST][6], F[MOST][6]; // velocity, acceleration, force
double I[MOST][10];                        // m, m c, second moment xx xy xz yy yz zz
double *mass_matrix, c[MOST];

inline void inertia_times(const double *__restrict i, const double *__restrict v,
                          double *__restrict f)
{
    const double m = i[0], x = i[1], y = i[2], z = i[3];
    f[0] = i[4] * v[0] + i[5] * v[1] + i[6] * v[2] + y * v[5] - z * v[4];
    f[1] = i[5] * v[0] + i[7] * v[1] + i[8] * v[2] + z * v[3] - x * v[5];
    f[2] = i[6] * v[0] + i[8] * v[1] + i[9] * v[2] + x * v[4] - y * v[3];
    f[3] = m * v[3] + v[1] * z - v[2] * y;
    f[4] = m * v[4] + v[2] * x - v[0] * z;
    f[5] = m * v[5] + v[0] * y - v[1] * x;
}

template <bool turn, int a> void forward(int i, double q, double qd)
{
    static const double base_R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, base_P[3] = {0, 0, 0};
    static const double rest[6] = {0, 0, 0, 0, 0, 0};
    const double up[6] = {0, 0, 0, -peer_gravity[0], -peer_gravity[1], -peer_gravity[2]};
    const peer_joint &joint = peer_joint_list[i];
    const int h = parent[i];
    constexpr int b = (a + 1) % 3, d = (a + 2) % 3;
    const double *Rh = h < 0 ? base_R : R[h], *Ph = h < 0 ? base_P : P[h];
    const double *Vh = h < 0 ? rest : V[h], *Ah = h < 0 ? up : A[h];
    double *Ri = R[i], *Pi = P[i], s[6];
    const double *anchor = joint.anchor;
    for (int k = 0; k < 3; k++)
        Pi[k] = Ph[k] + Rh[3 * k] * anchor[0] + Rh[3 * k + 1] * anchor[1] + Rh[3 * k + 2] * anchor[2];
    const double e[3] = {Rh[a], Rh[3 + a], Rh[6 + a]};
    if constexpr (turn) {
        double sine, cosine;
        sincos(q, &sine, &cosine);
        for (int k = 0; k < 3; k++) {
            Ri[3 * k + a] = Rh[3 * k + a];
            Ri[3 * k + b] = cosine * Rh[3 * k + b] + sine * Rh[3 * k + d];
            Ri[3 * k + d] = cosine * Rh[3 * k + d] - sine * Rh[3 * k + b];
        }
        s[0] = e[0], s[1] = e[1], s[2] = e[2];
        s[3] = Pi[1] * e[2] - Pi[2] * e[1];
        s[4] = Pi[2] * e[0] - Pi[0] * e[2];
        s[5] = Pi[0] * e[1] - Pi[1] * e[0];
    } else {
        for (int k = 0; k < 9; k++) Ri[k] = Rh[k];
        for (int k = 0; k < 3; k++) Pi[k] += q * e[k], s[k] = 0.0, s[3 + k] = e[k];
    }
    double *v = V[i], *acc = A[i];
    for (int k = 0; k < 6; k++) S[k][i] = s[k], v[k] = Vh[k] + s[k] * qd;
    const double x = Vh[0], y = Vh[1], z = Vh[2], vx = Vh[3], vy = Vh[4], vz = Vh[5];
    acc[0] = Ah[0] + (y * s[2] - z * s[1]) * qd;
    acc[1] = Ah[1] + (z * s[0] - x * s[2]) * qd;
    acc[2] = Ah[2] + (x * s[1] - y * s[0]) * qd;
    acc[3] = Ah[3] + (y * s[5] - z * s[4] + vy * s[2] - vz * s[1]) * qd;
    acc[4] = Ah[4] + (z * s[3] - x * s[5] + vz * s[0] - vx * s[2]) * qd;
    acc[5] = Ah[5] + (x * s[4] - y * s[3] + vx * s[1] - vy * s[0]) * qd;
    double *in = I[i], *f = F[i];
    const double m = joint.mass;
    if (m == 0.0) {
        for (int k = 0; k < 10; k++) in[k] = 0.0;
        for (int k = 0; k < 6; k++) f[k] = 0.0;
        return;
    }
    double g[3], T[9];
    const double *l = joint.center, *J = joint.inertia;
    for (int k = 0; k < 3; k++) {
        const double *r = Ri + 3 * k;
        g[k] = Pi[k] + r[0] * l[0] + r[1] * l[1] + r[2] * l[2];
        T[3 * k] = r[0] * J[0] + r[1] * J[1] + r[2] * J[2];
        T[3 * k + 1] = r[0] * J[1] + r[1] * J[3] + r[2] * J[4];
        T[3 * k + 2] = r[0] * J[2] + r[1] * J[4] + r[2] * J[5];
    }
    const double px = m * g[0], py = m * g[1], pz = m * g[2];
    auto turned = [&](int row, int column) {
        const double *t = T + 3 * row, *r = Ri + 3 * column;
        return t[0] * r[0] + t[1] * r[1] + t[2] * r[2];
    };
    in[0] = m, in[1] = px, in[2] = py, in[3] = pz;
    in[4] = turned(0, 0) + py * g[1] + pz * g[2];
    in[5] = turned(0, 1) - px * g[1];
    in[6] = turned(0, 2) - px * g[2];
    in[7] = turned(1, 1) + px * g[0] + pz * g[2];
    in[8] = turned(1, 2) - py * g[2];
    in[9] = turned(2, 2) + px * g[0] + py * g[1];
    double p[6];
    inertia_times(in, v, p);
    inertia_times(in, acc, f);
    f[0] += v[1] * p[2] - v[2] * p[1] + v[4] * p[5] - v[5] * p[4];
    f[1] += v[2] * p[0] - v[0] * p[2] + v[5] * p[3] - v[3] * p[5];
    f[2] += v[0] * p[1] - v[1] * p[0] + v[3] * p[4] - v[4] * p[3];
    f[3] += v[1] * p[5] - v[2] * p[4];
    f[4] += v[2] * p[3] - v[0] * p[5];
    f[5] += v[0] * p[4] - v[1] * p[3];
}

void backward(int i)
{
    const int h = parent[i];
    const double s[6] = {S[0][i], S[1][i], S[2][i], S[3][i], S[4][i], S[5][i]};
    double u[6];
    inertia_times(I[i], s, u);
    const double *f = F[i];
    c[i] = s[0] * f[0] + s[1] * f[1] + s[2] * f[2] + s[3] * f[3] + s[4] * f[4] + s[5] * f[5];
    double *__restrict row = mass_matrix + i * joints;
    auto entry = [&](int j) {
        return S[0][j] * u[0] + S[1][j] * u[1] + S[2][j] * u[2] + S[3][j] * u[3] + S[4][j] * u[4] +
               S[5][j] * u[5];
    };
    if (chain) {
        for (int j = 0; j <= i; j++) row[j] = entry(j);
    } else {
        for (int j = i; j >= 0; j = parent[j]) row[j] = entry(j);
    }
    if (h < 0) return;
    for (int k = 0; k < 10; k++) I[h][k] += I[i][k];
    for (int k = 0; k < 6; k++) F[h][k] += f[k];
}

} // namespace

static void peer_evaluate(int s)
{
    const double *q = peer_q + (size_t)s * joints, *qd = peer_qd + (size_t)s * joints;
    for (int i = 0; i < joints; i++) {
        switch (kind[i]) {
        case 0: forward<false, 0>(i, q[i], qd[i]); break;
        case 1: forward<false, 1>(i, q[i], qd[i]); break;
        case 2: forward<false, 2>(i, q[i], qd[i]); break;
        case 3: forward<true, 0>(i, q[i], qd[i]); break;
        case 4: forward<true, 1>(i, q[i], qd[i]); break;
        default: forward<true, 2>(i, q[i], qd[i]);
        }
    }
    for (int i = joints - 1; i >= 0; i--) backward(i);
}

static void peer_result(double *M, double *out)
{
    for (int i = 0; i < joints; i++) {
        out[i] = c[i];
        for (int j = 0; j <= i; j++) M[i * joints + j] = M[j * joints + i] = mass_matrix[i * joints + j];
    }
}

int main(int count, char **words)
{
    peer_read(count, words);
    joints = peer_joints;
    mass_matrix = (double *)calloc((size_t)joints * joints, sizeof(double));
    chain = true;
    for (int i = 0; i < joints; i++) {
        parent[i] = peer_joint_list[i].parent;
        kind[i] = 3 * peer_joint_list[i].revolute + peer_joint_list[i].axis;
        chain = chain && parent[i] == i - 1;
    }
    return peer_main(count, words);
}
