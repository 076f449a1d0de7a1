// Direct dynamics of loop.cpp: mass matrix and forces, seen from the base.

number R[MOST][9], P[MOST][3];             // orientation (columns: axes) and origin
number S[6][MOST];                         // axes of the joints, from 0
number V[MOST][6], A[MOST][6], F[MOST][6]; // velocity, acceleration, force
number I[MOST][10];                        // m, m c, second moment xx xy xz yy yz zz
number *mass_matrix;

void start_direct()
{
    for (int k = 0; k < 3; k++) {
        R[0][4 * k] = zero + 1.0;
        A[0][3 + k] = zero - peer_gravity[k];
    }
}

inline void inertia_times(const number *__restrict i, const number *__restrict v,
                          number *__restrict f)
{
    const number m = i[0], x = i[1], y = i[2], z = i[3];
    f[0] = i[4] * v[0] + i[5] * v[1] + i[6] * v[2] + y * v[5] - z * v[4];
    f[1] = i[5] * v[0] + i[7] * v[1] + i[8] * v[2] + z * v[3] - x * v[5];
    f[2] = i[6] * v[0] + i[8] * v[1] + i[9] * v[2] + x * v[4] - y * v[3];
    f[3] = m * v[3] + v[1] * z - v[2] * y;
    f[4] = m * v[4] + v[2] * x - v[0] * z;
    f[5] = m * v[5] + v[0] * y - v[1] * x;
}

// Where a body is, and the axis of its joint.
template <class Kind> inline void placed(int i, number q, number *s)
{
    constexpr int a = Kind::a, b = Kind::b, d = Kind::d;
    const int h = parent[i] + 1;
    const number *Rh = R[h], *Ph = P[h];
    number turned[9];
    number *Ri = R[i + 1], *Pi = P[i + 1];
    const double *anchor = peer_joint_list[i].anchor;
    for (int k = 0; k < 3; k++)
        Pi[k] = Ph[k] + Rh[3 * k] * anchor[0] + Rh[3 * k + 1] * anchor[1] + Rh[3 * k + 2] * anchor[2];
    if (turned_at[i]) {
        for (int k = 0; k < 3; k++) turned_in(i, Rh + 3 * k, turned + 3 * k);
        Rh = turned;
    }
    const number e[3] = {Rh[a], Rh[3 + a], Rh[6 + a]};
    if constexpr (Kind::turns) {
        number sine, cosine;
        sine_and_cosine(q, sine, cosine);
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
        for (int k = 0; k < 3; k++) Pi[k] += q * e[k], s[k] = zero, s[3 + k] = e[k];
    }
}

// Its velocity, and its acceleration where no joint accelerates.
inline void moved(int i, const number *s, number qd)
{
    const number *Vh = V[parent[i] + 1], *Ah = A[parent[i] + 1];
    number *v = V[i + 1], *acc = A[i + 1];
    for (int k = 0; k < 6; k++) S[k][i] = s[k], v[k] = Vh[k] + s[k] * qd;
    const number x = Vh[0], y = Vh[1], z = Vh[2], vx = Vh[3], vy = Vh[4], vz = Vh[5];
    acc[0] = Ah[0] + (y * s[2] - z * s[1]) * qd;
    acc[1] = Ah[1] + (z * s[0] - x * s[2]) * qd;
    acc[2] = Ah[2] + (x * s[1] - y * s[0]) * qd;
    acc[3] = Ah[3] + (y * s[5] - z * s[4] + vy * s[2] - vz * s[1]) * qd;
    acc[4] = Ah[4] + (z * s[3] - x * s[5] + vz * s[0] - vx * s[2]) * qd;
    acc[5] = Ah[5] + (x * s[4] - y * s[3] + vx * s[1] - vy * s[0]) * qd;
}

// Its inertia, and the place of its centre of mass.
inline void weighed(int i, number *g)
{
    const peer_joint &joint = peer_joint_list[i];
    number *in = I[i + 1], T[9];
    const number *Ri = R[i + 1], *Pi = P[i + 1];
    const double m = joint.mass, *l = joint.center, *J = joint.inertia;
    for (int k = 0; k < 3; k++) {
        const number *r = Ri + 3 * k;
        g[k] = Pi[k] + r[0] * l[0] + r[1] * l[1] + r[2] * l[2];
        T[3 * k] = r[0] * J[0] + r[1] * J[1] + r[2] * J[2];
        T[3 * k + 1] = r[0] * J[1] + r[1] * J[3] + r[2] * J[4];
        T[3 * k + 2] = r[0] * J[2] + r[1] * J[4] + r[2] * J[5];
    }
    const number px = m * g[0], py = m * g[1], pz = m * g[2];
    auto turned = [&](int row, int column) { return dot(T + 3 * row, Ri + 3 * column); };
    in[0] = zero + m, in[1] = px, in[2] = py, in[3] = pz;
    in[4] = turned(0, 0) + py * g[1] + pz * g[2];
    in[5] = turned(0, 1) - px * g[1];
    in[6] = turned(0, 2) - px * g[2];
    in[7] = turned(1, 1) + px * g[0] + pz * g[2];
    in[8] = turned(1, 2) - py * g[2];
    in[9] = turned(2, 2) + px * g[0] + py * g[1];
}

// Force and torque on a body, in its frame and at its centre of mass.
inline void loaded(int i, const number *g, const double *loads)
{
    number force[3], torque[3], *f = F[i + 1];
    for (int k = 0; k < 3; k++) {
        const number *r = R[i + 1] + 3 * k;
        force[k] = zero, torque[k] = zero;
        for (int j = 0; j < 3; j++) {
            force[k] += r[j] * element(loads, 6 * i + j);
            torque[k] += r[j] * element(loads, 6 * i + 3 + j);
        }
    }
    add_cross(g, force, torque);
    for (int k = 0; k < 3; k++) f[k] -= torque[k], f[3 + k] -= force[k];
}

// Not put into the loop six times over, of which gcc makes slower code.
template <class Kind, bool has_loads>
__attribute__((noinline)) void forward(int i, number q, number qd, const double *loads)
{
    number s[6], g[3], p[6];
    placed<Kind>(i, q, s);
    moved(i, s, qd);
    number *in = I[i + 1], *f = F[i + 1];
    const number *v = V[i + 1];
    if (peer_joint_list[i].mass == 0.0 && !has_loads) {
        for (int k = 0; k < 10; k++) in[k] = zero;
        for (int k = 0; k < 6; k++) f[k] = zero;
        return;
    }
    weighed(i, g);
    inertia_times(in, v, p);
    inertia_times(in, A[i + 1], f);
    f[0] += v[1] * p[2] - v[2] * p[1] + v[4] * p[5] - v[5] * p[4];
    f[1] += v[2] * p[0] - v[0] * p[2] + v[5] * p[3] - v[3] * p[5];
    f[2] += v[0] * p[1] - v[1] * p[0] + v[3] * p[4] - v[4] * p[3];
    f[3] += v[1] * p[5] - v[2] * p[4];
    f[4] += v[2] * p[3] - v[0] * p[5];
    f[5] += v[0] * p[4] - v[1] * p[3];
    if (has_loads) loaded(i, g, loads);
}

void backward(int i)
{
    const int h = parent[i] + 1;
    const number s[6] = {S[0][i], S[1][i], S[2][i], S[3][i], S[4][i], S[5][i]};
    number u[6];
    inertia_times(I[i + 1], s, u);
    const number *f = F[i + 1];
    result[i] = dot(s, f) + dot(s + 3, f + 3);
    number *__restrict row = mass_matrix + i * joints;
    auto entry = [&](int j) {
        return S[0][j] * u[0] + S[1][j] * u[1] + S[2][j] * u[2] + S[3][j] * u[3] + S[4][j] * u[4] +
               S[5][j] * u[5];
    };
    if (chain) {
        for (int j = 0; j <= i; j++) row[j] = entry(j);
    } else {
        for (int j = i; j >= 0; j = parent[j]) row[j] = entry(j);
    }
    if (h == 0) return;
    for (int k = 0; k < 10; k++) I[h][k] += I[i + 1][k];
    for (int k = 0; k < 6; k++) F[h][k] += f[k];
}

template <bool has_loads> void direct(const double *q, const double *qd, const double *loads)
{
    for (int i = 0; i < joints; i++)
        with_kind(kind[i], [&](auto own) {
            forward<decltype(own), has_loads>(i, element(q, i), element(qd, i), loads);
        });
    for (int i = joints - 1; i >= 0; i--) backward(i);
}
