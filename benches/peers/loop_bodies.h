// Inverse dynamics and accelerations of loop.cpp, in the frames of the bodies.
//
// Accelerations are those of the origins of the frames, so that no linear
// velocity is needed: a' = a + alpha x d + omega x (omega x d).

number cosines[MOST], sines[MOST], arm[MOST][3]; // of the joints, from 0
number om[MOST][3], alpha[MOST][3], acc[MOST][3];
number force[MOST][3], moment[MOST][3];    // of the bodies, about their origins
number AA[MOST][6], BB[MOST][9], CC[MOST][6]; // moment = A alpha + B acc, force = B' alpha + C acc
number turned_rate[MOST][3], moved_rate[MOST][3]; // what velocities add to alpha and acc
number column[MOST][6], inverse_of[MOST], driving[MOST];
double about_origin[MOST][6];              // inertia about the origin, own frame

void start_bodies()
{
    for (int k = 0; k < 3; k++) acc[0][k] = zero - peer_gravity[k];
    for (int i = 0; i < joints; i++) {
        const peer_joint &joint = peer_joint_list[i];
        const double m = joint.mass, *l = joint.center, *J = joint.inertia;
        const double own[6] = {J[0] + m * (l[1] * l[1] + l[2] * l[2]), J[1] - m * l[0] * l[1],
                               J[2] - m * l[0] * l[2], J[3] + m * (l[0] * l[0] + l[2] * l[2]),
                               J[4] - m * l[1] * l[2], J[5] + m * (l[0] * l[0] + l[1] * l[1])};
        memcpy(about_origin[i], own, sizeof own);
    }
}

// A vector of the frame before a joint in the frame behind it, and back.
template <class Kind> inline void down(int i, const number *v, number *w)
{
    constexpr int a = Kind::a, b = Kind::b, d = Kind::d;
    number turned[3];
    if (turned_at[i]) {
        turned_in(i, v, turned);
        v = turned;
    }
    w[a] = v[a];
    if constexpr (Kind::turns) {
        w[b] = cosines[i] * v[b] + sines[i] * v[d];
        w[d] = cosines[i] * v[d] - sines[i] * v[b];
    } else {
        w[b] = v[b], w[d] = v[d];
    }
}

template <class Kind> inline void up(int i, const number *v, number *w)
{
    constexpr int a = Kind::a, b = Kind::b, d = Kind::d;
    w[a] = v[a];
    if constexpr (Kind::turns) {
        w[b] = cosines[i] * v[b] - sines[i] * v[d];
        w[d] = cosines[i] * v[d] + sines[i] * v[b];
    } else {
        w[b] = v[b], w[d] = v[d];
    }
    if (!turned_at[i]) return;
    const number own[3] = {w[0], w[1], w[2]};
    turned_out(i, own, w);
}

// Angle or slide, and the angular velocity behind the joint.
template <class Kind> inline void entered(int i, number q, number qd)
{
    const double *anchor = peer_joint_list[i].anchor;
    for (int k = 0; k < 3; k++) arm[i][k] = zero + anchor[k];
    if constexpr (Kind::turns)
        sine_and_cosine(q, sines[i], cosines[i]);
    else
        for (int k = 0; k < 3; k++)
            if (turned_at[i] || k == Kind::a)
                arm[i][k] += peer_joint_list[i].turn[3 * k + Kind::a] * q;
    down<Kind>(i, om[parent[i] + 1], om[i + 1]);
    if constexpr (Kind::turns) om[i + 1][Kind::a] += qd;
}

// What the joint's velocity adds: omega x axis, scaled.
template <class Kind> inline void add_turning(int i, number speed, number *to)
{
    to[Kind::b] += speed * om[i + 1][Kind::d];
    to[Kind::d] -= speed * om[i + 1][Kind::b];
}

template <class Kind, bool has_loads>
void newton_euler(int i, number qd, number qdd, const double *loads)
{
    constexpr int a = Kind::a;
    const int h = parent[i] + 1;
    number *o = om[i + 1], *al = alpha[i + 1], *ac = acc[i + 1], before[3];
    for (int k = 0; k < 3; k++) before[k] = acc[h][k];
    if (!unmoved[i]) {
        // The matrix alpha x + omega x omega x of the parent, in BB.
        for (int k = 0; k < 3; k++) before[k] += dot(BB[h] + 3 * k, arm[i]);
    }
    down<Kind>(i, alpha[h], al);
    down<Kind>(i, before, ac);
    add_turning<Kind>(i, Kind::turns ? qd : qd + qd, Kind::turns ? al : ac);
    (Kind::turns ? al : ac)[a] += qdd;
    const number xx = o[0] * o[0], yy = o[1] * o[1], zz = o[2] * o[2];
    const number xy = o[0] * o[1], xz = o[0] * o[2], yz = o[1] * o[2];
    const number rates[9] = {-yy - zz,   xy - al[2], xz + al[1], xy + al[2], -xx - zz,
                             yz - al[0], xz - al[1], yz + al[0], -xx - yy};
    for (int k = 0; k < 9; k++) BB[i + 1][k] = rates[k];
    const peer_joint &joint = peer_joint_list[i];
    number *f = force[i + 1], *n = moment[i + 1], spin[3];
    if (joint.mass == 0.0 && !has_loads) {
        for (int k = 0; k < 3; k++) f[k] = n[k] = zero;
        return;
    }
    const double *l = joint.center;
    symmetric_times(joint.inertia, al, n);
    symmetric_times(joint.inertia, o, spin);
    add_cross(o, spin, n);
    for (int k = 0; k < 3; k++) {
        f[k] = joint.mass * (ac[k] + dot(l, rates + 3 * k));
        if (has_loads) f[k] -= element(loads, 6 * i + k), n[k] -= element(loads, 6 * i + 3 + k);
    }
    add_cross(l, f, n);
}

// Force and moment of a body handed to its parent.
template <class Kind> inline void handed(int i, const number *f, const number *n)
{
    const int h = parent[i] + 1;
    number turned[3], moment_of[3];
    up<Kind>(i, f, turned);
    up<Kind>(i, n, moment_of);
    if (!unmoved[i]) add_cross(arm[i], turned, moment_of);
    for (int k = 0; k < 3; k++) force[h][k] += turned[k], moment[h][k] += moment_of[k];
}

template <bool has_loads>
void inverse(const double *q, const double *qd, const double *qdd, const double *loads)
{
    for (int i = 0; i < joints; i++)
        with_kind(kind[i], [&](auto own) {
            const number speed = element(qd, i);
            entered<decltype(own)>(i, element(q, i), speed);
            newton_euler<decltype(own), has_loads>(i, speed, element(qdd, i), loads);
        });
    for (int i = joints - 1; i >= 0; i--)
        with_kind(kind[i], [&](auto own) {
            const number *f = force[i + 1], *n = moment[i + 1];
            result[i] = own.turns ? n[own.a] : f[own.a];
            if (parent[i] >= 0) handed<decltype(own)>(i, f, n);
        });
}

// The place of an element of a symmetric matrix: xx xy xz yy yz zz.
constexpr int at(int row, int column)
{
    return row > column ? at(column, row) : row == 0 ? column : row + column + 1;
}

// Velocities, what they add to accelerations, and the inertia and the force of
// the body alone.
template <class Kind, bool has_loads>
void velocities(int i, number q, number qd, const double *loads)
{
    const int h = parent[i] + 1;
    entered<Kind>(i, q, qd);
    const number *o = om[i + 1];
    number sweep[3] = {zero, zero, zero}, pull[3] = {zero, zero, zero};
    if (!unmoved[i]) {
        add_cross(om[h], arm[i], sweep);
        add_cross(om[h], sweep, pull);
    }
    number *rate = turned_rate[i], *moved = moved_rate[i];
    for (int k = 0; k < 3; k++) rate[k] = zero;
    down<Kind>(i, pull, moved);
    add_turning<Kind>(i, Kind::turns ? qd : qd + qd, Kind::turns ? rate : moved);
    const peer_joint &joint = peer_joint_list[i];
    const double m = joint.mass, *l = joint.center, *J = about_origin[i];
    number *f = force[i + 1], *n = moment[i + 1];
    number *A = AA[i + 1], *B = BB[i + 1], *C = CC[i + 1];
    for (int k = 0; k < 3; k++) f[k] = n[k] = zero;
    for (int k = 0; k < 6; k++) A[k] = zero + J[k], C[k] = zero;
    for (int k = 0; k < 3; k++) B[4 * k] = zero, C[at(k, k)] = zero + m;
    B[1] = zero - m * l[2], B[2] = zero + m * l[1], B[5] = zero - m * l[0];
    B[3] = zero + m * l[2], B[6] = zero - m * l[1], B[7] = zero + m * l[0];
    if (m != 0.0) {
        const double first[3] = {m * l[0], m * l[1], m * l[2]};
        number spin[3], swing[3] = {zero, zero, zero};
        symmetric_times(J, o, spin);
        add_cross(o, spin, n);
        add_cross(first, o, swing);
        for (int k = 0; k < 3; k++) swing[k] = -swing[k];
        add_cross(o, swing, f);
    }
    if (!has_loads) return;
    number push[3];
    for (int k = 0; k < 3; k++) {
        push[k] = zero - element(loads, 6 * i + k);
        f[k] += push[k];
        n[k] -= element(loads, 6 * i + 3 + k);
    }
    add_cross(l, push, n);
}

// A matrix by a joint's constant rotation: T M T'.
inline void turn_out(int i, number *m)
{
    number half[9], column[3], turned[3];
    for (int r = 0; r < 3; r++) turned_out(i, m + 3 * r, half + 3 * r);
    for (int c = 0; c < 3; c++) {
        for (int r = 0; r < 3; r++) column[r] = half[3 * r + c];
        turned_out(i, column, turned);
        for (int r = 0; r < 3; r++) m[3 * r + c] = turned[r];
    }
}

// The matrices of a body turned into the frame before its joint; what the
// joint gives way to is zero in them.
template <class Kind> inline void turn_up(int i, number *A, number *B, number *C)
{
    constexpr int a = Kind::a, b = Kind::b, d = Kind::d;
    if constexpr (Kind::turns) {
        const number c = cosines[i], s = sines[i];
        auto block = [&](number &bb, number &bd, number &db, number &dd) {
            const number k = s * (bb - dd) + c * (bd + db), x = bd;
            bb -= s * k, dd += s * k, bd = c * k - db, db = c * k - x;
        };
        auto pair = [&](number &xb, number &xd) {
            const number x = xb;
            xb = c * x - s * xd, xd = s * x + c * xd;
        };
        number other = A[at(b, d)];
        block(A[at(b, b)], A[at(b, d)], other, A[at(d, d)]);
        block(B[4 * b], B[3 * b + d], B[3 * d + b], B[4 * d]);
        pair(B[3 * b + a], B[3 * d + a]);
        other = C[at(b, d)];
        block(C[at(b, b)], C[at(b, d)], other, C[at(d, d)]);
        pair(C[at(a, b)], C[at(a, d)]);
    }
    if (turned_at[i]) {
        number full[9];
        turn_out(i, B);
        number *const halves[2] = {A, C};
        for (number *half : halves) {
            for (int k = 0; k < 9; k++) full[k] = half[at(k / 3, k % 3)];
            turn_out(i, full);
            for (int k = 0; k < 9; k++) half[at(k / 3, k % 3)] = full[k];
        }
    }
}

// The articulated body of a joint, and what its parent feels of it.
template <class Kind> void articulated(int i, number given)
{
    constexpr int a = Kind::a;
    const int h = parent[i] + 1;
    number A[6], B[9], C[6], *u = column[i], f[3], n[3], rest[6];
    memcpy(A, AA[i + 1], sizeof A), memcpy(B, BB[i + 1], sizeof B), memcpy(C, CC[i + 1], sizeof C);
    for (int k = 0; k < 3; k++) {
        u[k] = Kind::turns ? A[at(k, a)] : B[3 * k + a];
        u[3 + k] = Kind::turns ? B[3 * a + k] : C[at(k, a)];
    }
    constexpr int own = Kind::turns ? a : 3 + a;
    const number inverse = 1.0 / u[own];
    inverse_of[i] = inverse;
    driving[i] = given - (Kind::turns ? moment[i + 1][a] : force[i + 1][a]);
    if (h == 0) return;
    for (int k = 0; k < 6; k++) rest[k] = u[k] * inverse;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            const bool gone = Kind::turns && r == a, gone_too = !Kind::turns && c == a;
            if (c >= r)
                A[at(r, c)] = gone || (Kind::turns && c == a) ? zero : A[at(r, c)] - u[r] * rest[c];
            B[3 * r + c] = gone || gone_too ? zero : B[3 * r + c] - u[r] * rest[3 + c];
            if (c >= r)
                C[at(r, c)] = gone_too || (!Kind::turns && r == a)
                                  ? zero
                                  : C[at(r, c)] - u[3 + r] * rest[3 + c];
        }
    const number *rate = turned_rate[i], *moved = moved_rate[i];
    for (int k = 0; k < 3; k++) {
        n[k] = moment[i + 1][k] + rest[k] * driving[i] + dot(B + 3 * k, moved);
        f[k] = force[i + 1][k] + rest[3 + k] * driving[i];
        for (int j = 0; j < 3; j++) {
            f[k] += C[at(k, j)] * moved[j];
            // A turn's own velocity adds nothing about its axis, a slide's to no turn.
            if (Kind::turns && j != a) n[k] += A[at(k, j)] * rate[j], f[k] += B[3 * j + k] * rate[j];
        }
    }
    (Kind::turns ? n : f)[a] = given;
    turn_up<Kind>(i, A, B, C);
    handed<Kind>(i, f, n);
    if (!unmoved[i]) {
        const number *e = arm[i];
        number before[9], D[9];
        for (int r = 0; r < 3; r++) {
            const int x = (r + 1) % 3, y = (r + 2) % 3;
            for (int c = 0; c < 3; c++) {
                before[3 * r + c] = B[3 * r + c];
                D[3 * r + c] = B[3 * r + c] + e[x] * C[at(y, c)] - e[y] * C[at(x, c)];
            }
        }
        for (int r = 0; r < 3; r++)
            for (int c = r; c < 3; c++) {
                const int x = (r + 1) % 3, y = (r + 2) % 3, v = (c + 1) % 3, w = (c + 2) % 3;
                A[at(r, c)] += e[x] * before[3 * c + y] - e[y] * before[3 * c + x] +
                               e[v] * D[3 * r + w] - e[w] * D[3 * r + v];
            }
        memcpy(B, D, sizeof D);
    }
    for (int k = 0; k < 6; k++) AA[h][k] += A[k], CC[h][k] += C[k];
    for (int k = 0; k < 9; k++) BB[h][k] += B[k];
}

template <class Kind> void accelerated(int i)
{
    const int h = parent[i] + 1;
    number *al = alpha[i + 1], *ac = acc[i + 1], before[3];
    for (int k = 0; k < 3; k++) before[k] = acc[h][k];
    if (!unmoved[i]) add_cross(alpha[h], arm[i], before);
    down<Kind>(i, alpha[h], al);
    down<Kind>(i, before, ac);
    for (int k = 0; k < 3; k++) al[k] += turned_rate[i][k], ac[k] += moved_rate[i][k];
    const number *u = column[i];
    result[i] = (driving[i] - dot(u, al) - dot(u + 3, ac)) * inverse_of[i];
    (Kind::turns ? al : ac)[Kind::a] += result[i];
}

template <bool has_loads>
void accelerations(const double *q, const double *qd, const double *given, const double *loads)
{
    for (int i = 0; i < joints; i++)
        with_kind(kind[i], [&](auto own) {
            velocities<decltype(own), has_loads>(i, element(q, i), element(qd, i), loads);
        });
    for (int i = joints - 1; i >= 0; i--)
        with_kind(kind[i], [&](auto own) { articulated<decltype(own)>(i, element(given, i)); });
    for (int i = 0; i < joints; i++)
        with_kind(kind[i], [&](auto own) { accelerated<decltype(own)>(i); });
}
