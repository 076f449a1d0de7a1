"""CasADi: composite rigid bodies and Newton-Euler in body frames as one
function of q and qd, written as C by CasADi's own code generator.

Usage: casadi_functions.py MODEL C_FILE   (peer.h tells the model's format)
"""

import sys

import casadi as ca


def read(name):
    words = iter(open(name).read().split())
    expect = lambda word: next(words) == word or sys.exit(f"{name}: no '{word}'")
    expect("robovec-tree"), expect("1"), expect("gravity")
    gravity = [float(next(words)) for _ in range(3)]
    expect("joints")
    joints = []
    for _ in range(int(next(words))):
        parent, kind = int(next(words)) - 1, next(words)
        numbers = [float(next(words)) for _ in range(13)]
        joints.append((parent, kind[0] == "R", int(kind[1]) - 1, numbers))
    return gravity, joints


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def plus(a, b):
    return [x + y for x, y in zip(a, b)]


def times(s, a):
    return [s * x for x in a]


def symmetric(i, v):
    return [
        i[0] * v[0] + i[1] * v[1] + i[2] * v[2],
        i[1] * v[0] + i[3] * v[1] + i[4] * v[2],
        i[2] * v[0] + i[4] * v[1] + i[5] * v[2],
    ]


def unit(axis):
    return [ca.SX(1.0) if k == axis else ca.SX(0.0) for k in range(3)]


class Turn:
    """A rotation about an axis, or none: a vector of the parent in the child's
    frame, and back."""

    def __init__(self, revolute, axis, q):
        self.b, self.d = (axis + 1) % 3, (axis + 2) % 3
        self.cosine, self.sine = (ca.cos(q), ca.sin(q)) if revolute else (None, None)

    def down(self, v):
        if self.cosine is None:
            return list(v)
        w, b, d = list(v), self.b, self.d
        w[b] = self.cosine * v[b] + self.sine * v[d]
        w[d] = self.cosine * v[d] - self.sine * v[b]
        return w

    def up(self, v):
        if self.cosine is None:
            return list(v)
        w, b, d = list(v), self.b, self.d
        w[b] = self.cosine * v[b] - self.sine * v[d]
        w[d] = self.cosine * v[d] + self.sine * v[b]
        return w

    def up_symmetric(self, i):
        if self.cosine is None:
            return list(i)
        rows = [[i[0], i[1], i[2]], [i[1], i[3], i[4]], [i[2], i[4], i[5]]]
        rows = [self.up(row) for row in rows]
        columns = [self.up([rows[r][c] for r in range(3)]) for c in range(3)]
        return [columns[0][0], columns[1][0], columns[2][0], columns[1][1], columns[2][1], columns[2][2]]


def function(gravity, joints):
    n = len(joints)
    q, qd = ca.SX.sym("q", n), ca.SX.sym("qd", n)
    zero = [ca.SX(0.0)] * 3
    turn, arm, om, omp, acc = [], [], [], [], []
    mass, first, inertia, force, moment = [], [], [], [], []
    for k, (h, revolute, axis, x) in enumerate(joints):
        t, e = Turn(revolute, axis, q[k]), unit(axis)
        d = [ca.SX(v) for v in x[0:3]]
        if not revolute:
            d[axis] = d[axis] + q[k]
        oh, oph = (om[h], omp[h]) if h >= 0 else (zero, zero)
        ah = acc[h] if h >= 0 else [ca.SX(-g) for g in gravity]
        a = plus(ah, plus(cross(oph, d), cross(oh, cross(oh, d))))
        o, op = t.down(oh), t.down(oph)
        if revolute:
            op = plus(op, times(qd[k], cross(o, e)))
            o = plus(o, times(qd[k], e))
            a = t.down(a)
        else:
            a = plus(t.down(a), times(2 * qd[k], cross(o, e)))
        m, l, i = x[3], x[4:7], x[7:13]
        mc = times(m, [ca.SX(v) for v in l])
        ll = [l[1] ** 2 + l[2] ** 2, -l[0] * l[1], -l[0] * l[2], l[0] ** 2 + l[2] ** 2, -l[1] * l[2], l[0] ** 2 + l[1] ** 2]
        j = [ca.SX(v + m * w) for v, w in zip(i, ll)]
        f = plus(times(m, a), plus(cross(op, mc), cross(o, cross(o, mc))))
        tau = plus(plus(symmetric(j, op), cross(o, symmetric(j, o))), cross(mc, a))
        for items, item in zip((turn, arm, om, omp, acc, mass, first, inertia, force, moment),
                               (t, d, o, op, a, ca.SX(m), mc, j, f, tau)):
            items.append(item)
    M, c = ca.SX(n, n), ca.SX(n, 1)
    for k in reversed(range(n)):
        h, revolute, axis, _ = joints[k]
        c[k] = moment[k][axis] if revolute else force[k][axis]
        e = unit(axis)
        if revolute:
            f, tau = cross(e, first[k]), symmetric(inertia[k], e)
        else:
            f, tau = times(mass[k], e), cross(first[k], e)
        i = k
        while True:
            _, turns, a, _ = joints[i]
            M[k, i] = M[i, k] = tau[a] if turns else f[a]
            if joints[i][0] < 0:
                break
            f, tau = turn[i].up(f), turn[i].up(tau)
            tau = plus(tau, cross(arm[i], f))
            i = joints[i][0]
        if h < 0:
            continue
        f, tau = turn[k].up(force[k]), turn[k].up(moment[k])
        force[h] = plus(force[h], f)
        moment[h] = plus(moment[h], plus(tau, cross(arm[k], f)))
        d, m, mc = arm[k], mass[k], turn[k].up(first[k])
        j = turn[k].up_symmetric(inertia[k])
        total = plus(mc, times(m, d))
        # Moved by d: J + 2 (d.mc) 1 - d mc' - mc d' + m ((d.d) 1 - d d').
        s = plus(mc, times(0.5 * m, d))
        dot = 2 * (d[0] * s[0] + d[1] * s[1] + d[2] * s[2])
        pair = lambda r, w: -(d[r] * s[w] + s[r] * d[w])
        moved = [j[0] + dot + pair(0, 0), j[1] + pair(0, 1), j[2] + pair(0, 2),
                 j[3] + dot + pair(1, 1), j[4] + pair(1, 2), j[5] + dot + pair(2, 2)]
        mass[h], first[h], inertia[h] = mass[h] + m, plus(first[h], total), plus(inertia[h], moved)
    return ca.Function("dynamics", [q, qd], [ca.densify(M), c], ["q", "qd"], ["M", "c"])


gravity, joints = read(sys.argv[1])
f = function(gravity, joints)
f.generate(sys.argv[2], {"with_header": False})
