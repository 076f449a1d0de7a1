"""CasADi: a task of peer.h in body frames as one function of q, qd, what is
given and loads, written as C by CasADi's own code generator: composite rigid
bodies and Newton-Euler, Newton-Euler alone, articulated bodies, or the
derivatives of the last two.

Usage: casadi_functions.py TASK loads|free MODEL C_FILE
(peer.h tells tasks and the model's format)
"""

import sys

import casadi as ca


def read(name):
    words = iter(open(name).read().split())
    expect = lambda word: next(words) == word or sys.exit(f"{name}: no '{word}'")
    expect("robovec-tree"), expect("2"), expect("gravity")
    gravity = [float(next(words)) for _ in range(3)]
    expect("joints")
    joints = []
    for _ in range(int(next(words))):
        parent, kind = int(next(words)) - 1, next(words)
        # The sign of the joint is seen where states come in and results go out.
        next(words)
        d, turn, own = ([float(next(words)) for _ in range(count)] for count in (3, 9, 10))
        axis = int(kind[1]) - 1
        joints.append((parent, kind[0] == "R", axis, d + own, rows_of(turn)))
    return gravity, joints


def rows_of(turn):
    """The rows of a constant rotation; none where nothing is turned."""
    rows = [turn[0:3], turn[3:6], turn[6:9]]
    return None if rows == [[1, 0, 0], [0, 1, 0], [0, 0, 1]] else rows


def combined(rows, v):
    """A matrix of numbers times a vector; zeros are no terms."""
    return [sum((x * y for x, y in zip(row, v) if x), ca.SX(0.0)) for row in rows]


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
    """A constant rotation, or none, and then one about an axis, or none: a
    vector of the parent in the child's frame, and back."""

    def __init__(self, revolute, axis, q, rows):
        self.b, self.d = (axis + 1) % 3, (axis + 2) % 3
        self.cosine, self.sine = (ca.cos(q), ca.sin(q)) if revolute else (None, None)
        self.rows, self.columns = rows, rows and [list(column) for column in zip(*rows)]

    def down(self, v):
        v = combined(self.columns, v) if self.rows else v
        if self.cosine is None:
            return list(v)
        w, b, d = list(v), self.b, self.d
        w[b] = self.cosine * v[b] + self.sine * v[d]
        w[d] = self.cosine * v[d] - self.sine * v[b]
        return w

    def up(self, v):
        w, b, d = list(v), self.b, self.d
        if self.cosine is not None:
            w[b] = self.cosine * v[b] - self.sine * v[d]
            w[d] = self.cosine * v[d] + self.sine * v[b]
        return combined(self.rows, w) if self.rows else w

    def up_symmetric(self, i):
        if self.cosine is None and not self.rows:
            return list(i)
        rows = [[i[0], i[1], i[2]], [i[1], i[3], i[4]], [i[2], i[4], i[5]]]
        rows = [self.up(row) for row in rows]
        columns = [self.up([rows[r][c] for r in range(3)]) for c in range(3)]
        return [columns[0][0], columns[1][0], columns[2][0], columns[1][1], columns[2][1], columns[2][2]]


def entry(i, r, c):
    """An element of a symmetric matrix xx xy xz yy yz zz."""
    r, c = min(r, c), max(r, c)
    return i[c if r == 0 else r + c + 1]


class Tree:
    """Joints, their motion, and the bodies they carry."""

    def __init__(self, gravity, joints, with_loads):
        self.joints, n = joints, len(joints)
        self.q, self.qd, self.given = (ca.SX.sym(name, n) for name in ("q", "qd", "given"))
        self.loads = ca.SX.sym("loads", 6 * n if with_loads else 0)
        self.zero = [ca.SX(0.0)] * 3
        self.base = [ca.SX(-g) for g in gravity]
        self.turn, self.arm, self.om, self.omp, self.acc = [], [], [], [], []
        self.mass, self.first, self.inertia, self.load = [], [], [], []
        for k, (h, revolute, axis, x, rows) in enumerate(joints):
            self.turn.append(Turn(revolute, axis, self.q[k], rows))
            d = [ca.SX(v) for v in x[0:3]]
            if not revolute:
                slide = times(self.q[k], unit(axis))
                d = plus(d, combined(rows, slide) if rows else slide)
            self.arm.append(d)
            m, l, i = x[3], x[4:7], x[7:13]
            ll = [l[1] ** 2 + l[2] ** 2, -l[0] * l[1], -l[0] * l[2], l[0] ** 2 + l[2] ** 2, -l[1] * l[2], l[0] ** 2 + l[1] ** 2]
            self.mass.append(ca.SX(m))
            self.first.append([ca.SX(m * v) for v in l])
            self.inertia.append([ca.SX(v + m * w) for v, w in zip(i, ll)])
            own = [self.loads[6 * k + j] for j in range(6)] if with_loads else self.zero * 2
            self.load.append((own[0:3], plus(own[3:6], cross([ca.SX(v) for v in l], own[0:3]))))

    def velocity(self, k):
        """Enters the angular velocity, and tells what velocities add to the
        accelerations of a joint's frame."""
        h, revolute, axis, *_ = self.joints[k]
        e, qd, turn = unit(axis), self.qd[k], self.turn[k]
        before = self.om[h] if h >= 0 else self.zero
        o = turn.down(before)
        pull = turn.down(cross(before, cross(before, self.arm[k])))
        self.om.append(plus(o, times(qd, e)) if revolute else o)
        if revolute:
            return times(qd, cross(o, e)), pull
        return self.zero, plus(pull, times(2 * qd, cross(o, e)))

    def accelerate(self, k, rate, pull):
        """Enters the accelerations of a joint's frame, but for its own."""
        h, turn = self.joints[k][0], self.turn[k]
        before, ah = (self.omp[h], self.acc[h]) if h >= 0 else (self.zero, self.base)
        self.omp.append(plus(turn.down(before), rate))
        self.acc.append(plus(turn.down(plus(ah, cross(before, self.arm[k]))), pull))

    def add(self, k, own):
        """Adds a joint's own acceleration."""
        _, revolute, axis, *_ = self.joints[k]
        vector = self.omp[k] if revolute else self.acc[k]
        vector[axis] = vector[axis] + own

    def needed(self, k):
        """Force and moment that move a body as it moves."""
        f, tau = self.bias(k)
        a, op, mc = self.acc[k], self.omp[k], self.first[k]
        f = plus(f, plus(times(self.mass[k], a), cross(op, mc)))
        return f, plus(tau, plus(symmetric(self.inertia[k], op), cross(mc, a)))

    def bias(self, k):
        """What of them velocities and loads take."""
        o, (push, twist) = self.om[k], self.load[k]
        f = plus(cross(o, cross(o, self.first[k])), times(-1, push))
        return f, plus(cross(o, symmetric(self.inertia[k], o)), times(-1, twist))

    def up(self, k, f, tau):
        """Force and moment of a joint in the frame before it."""
        f, tau = self.turn[k].up(f), self.turn[k].up(tau)
        return f, plus(tau, cross(self.arm[k], f))


def newton_euler(tree, accelerations):
    """The forces of the joints; without accelerations, those of velocities."""
    force = []
    for k in range(len(tree.joints)):
        tree.accelerate(k, *tree.velocity(k))
        if accelerations:
            tree.add(k, tree.given[k])
        force.append(tree.needed(k))
    result = ca.SX(len(tree.joints), 1)
    for k, (h, revolute, axis, *_) in reversed(list(enumerate(tree.joints))):
        f, tau = force[k]
        result[k] = tau[axis] if revolute else f[axis]
        if h >= 0:
            force[h] = tuple(map(plus, force[h], tree.up(k, f, tau)))
    return result


def mass_matrix(tree):
    """Composite rigid bodies."""
    n = len(tree.joints)
    M = ca.SX(n, n)
    mass, first, inertia = list(tree.mass), list(tree.first), list(tree.inertia)
    for k, (h, revolute, axis, *_) in reversed(list(enumerate(tree.joints))):
        e = unit(axis)
        if revolute:
            f, tau = cross(e, first[k]), symmetric(inertia[k], e)
        else:
            f, tau = times(mass[k], e), cross(first[k], e)
        i = k
        while True:
            before, turns, a, *_ = tree.joints[i]
            M[k, i] = M[i, k] = tau[a] if turns else f[a]
            if before < 0:
                break
            f, tau = tree.up(i, f, tau)
            i = before
        if h < 0:
            continue
        d, m, mc = tree.arm[k], mass[k], tree.turn[k].up(first[k])
        j = tree.turn[k].up_symmetric(inertia[k])
        total = plus(mc, times(m, d))
        # Moved by d: J + 2 (d.mc) 1 - d mc' - mc d' + m ((d.d) 1 - d d').
        s = plus(mc, times(0.5 * m, d))
        dot = 2 * (d[0] * s[0] + d[1] * s[1] + d[2] * s[2])
        pair = lambda r, w: -(d[r] * s[w] + s[r] * d[w])
        moved = [j[0] + dot + pair(0, 0), j[1] + pair(0, 1), j[2] + pair(0, 2),
                 j[3] + dot + pair(1, 1), j[4] + pair(1, 2), j[5] + dot + pair(2, 2)]
        mass[h], first[h], inertia[h] = mass[h] + m, plus(first[h], total), plus(inertia[h], moved)
    return ca.densify(M)


def skew(v):
    """The matrix of v x, row by row."""
    return [[ca.SX(0.0), -v[2], v[1]], [v[2], ca.SX(0.0), -v[0]], [-v[1], v[0], ca.SX(0.0)]]


def handed_up(tree, k, A, B, C):
    """The matrices of what joint k carries, in the frame before it."""
    turn, d = tree.turn[k], tree.arm[k]
    A, C = turn.up_symmetric(A), turn.up_symmetric(C)
    rows = [turn.up(row) for row in B]
    columns = [turn.up([rows[r][c] for r in range(3)]) for c in range(3)]
    B = [[columns[c][r] for c in range(3)] for r in range(3)]
    columns = [cross(d, [entry(C, r, c) for r in range(3)]) for c in range(3)]
    moved = [[B[r][c] + columns[c][r] for c in range(3)] for r in range(3)]
    left, right = [cross(d, row) for row in B], [cross(d, row) for row in moved]
    A = [entry(A, r, c) + left[c][r] + right[r][c] for r in range(3) for c in range(r, 3)]
    return A, moved, C


def articulated(tree):
    """Accelerations of the joints (Featherstone 2008, table 7.1). A body's
    moment is A omp + B acc, its force B' omp + C acc."""
    n = len(tree.joints)
    velocity, force, body = [], [], []
    for k in range(n):
        velocity.append(tree.velocity(k))
        force.append(tree.bias(k))
        m, o = tree.mass[k], ca.SX(0.0)
        body.append((tree.inertia[k], skew(tree.first[k]), [m, o, o, m, o, m]))
    column, driving = [None] * n, [None] * n
    for k, (h, revolute, a, *_) in reversed(list(enumerate(tree.joints))):
        (A, B, C), (f, tau) = body[k], force[k]
        if revolute:
            u = [entry(A, r, a) for r in range(3)] + B[a]
        else:
            u = [B[r][a] for r in range(3)] + [entry(C, r, a) for r in range(3)]
        inverse = 1 / (u[a] if revolute else u[3 + a])
        drive = tree.given[k] - (tau[a] if revolute else f[a])
        column[k], driving[k] = (u, inverse), drive
        if h < 0:
            continue
        v = times(inverse, u)
        gone = lambda r, c: a in ((r, c) if revolute else ())
        gone_too = lambda r, c: a in (() if revolute else (r, c))
        o = ca.SX(0.0)
        upper = [(r, c) for r in range(3) for c in range(r, 3)]
        A = [o if gone(r, c) else entry(A, r, c) - u[r] * v[c] for r, c in upper]
        C = [o if gone_too(r, c) else entry(C, r, c) - u[3 + r] * v[3 + c] for r, c in upper]
        B = [[o if gone(r, r) or gone_too(c, c) else B[r][c] - u[r] * v[3 + c] for c in range(3)] for r in range(3)]
        rate, pull = velocity[k]
        turned = [[B[r][c] for r in range(3)] for c in range(3)]
        row = lambda m, w: [m[r][0] * w[0] + m[r][1] * w[1] + m[r][2] * w[2] for r in range(3)]
        tau = plus(plus(tau, times(drive, v[0:3])), plus(symmetric(A, rate), row(B, pull)))
        f = plus(plus(f, times(drive, v[3:6])), plus(row(turned, rate), symmetric(C, pull)))
        (tau if revolute else f)[a] = tree.given[k]
        force[h] = tuple(map(plus, force[h], tree.up(k, f, tau)))
        A, B, C = handed_up(tree, k, A, B, C)
        body[h] = (plus(body[h][0], A), list(map(plus, body[h][1], B)), plus(body[h][2], C))
    result = ca.SX(n, 1)
    for k in range(n):
        tree.accelerate(k, *velocity[k])
        u, inverse = column[k]
        against = sum(x * y for x, y in zip(u, tree.omp[k] + tree.acc[k]))
        result[k] = (driving[k] - against) * inverse
        tree.add(k, result[k])
    return result


task, with_loads = sys.argv[1], sys.argv[2] == "loads"
tree = Tree(*read(sys.argv[3]), with_loads)
if task == "dirdyna":
    results = [mass_matrix(tree), newton_euler(tree, False)]
elif task == "invdyna":
    results = [newton_euler(tree, True)]
elif task == "invdyna_d":
    forces = newton_euler(tree, True)
    results = [ca.densify(ca.jacobian(forces, by)) for by in (tree.q, tree.qd)]
elif task == "dirdyna_d":
    found = articulated(tree)
    results = [ca.densify(ca.jacobian(found, by)) for by in (tree.q, tree.qd, tree.given)]
else:
    results = [articulated(tree)]
f = ca.Function("dynamics", [tree.q, tree.qd, tree.given, tree.loads], results, {"cse": task.endswith("_d")})
f.generate(sys.argv[4], {"with_header": False})
