"""Inverse dynamics and its derivatives for CasADi: robovec's externals beside
CasADi's own compiled C, for the same robots in one run.

    python python/benches/casadi_functions.py [ROBOT.urdf ...]

Three programs give each function: CasADi from a recursion over the links
(`ca.cse`, then `generate` and the C compiler), `robovec.casadi` from the robot,
and `robovec.accelerate` from CasADi's graph. Results are compared first, to
1e-9 of the largest element. Times are the least of several windows, in
nanoseconds per call, measured by the same C loop.
"""

import ctypes
import math
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml

import casadi as ca
import numpy as np
import robovec

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROBOTS = ["arm", "oblique", "quadruped"]
LONGEST = 20
FLAGS = ["-O3", "-march=native"]
LOOP = r"""
#include <time.h>
typedef int call(const double **, double **, long long *, double *, int);
double least(call *f, const double **arg, double **res, long long *iw, double *w, long n)
{
    double best = 1e300;
    for (int window = 0; window < 25; window++) {
        struct timespec a, b;
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &a);
        for (long k = 0; k < n; k++) f(arg, res, iw, w, 0);
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &b);
        double t = ((b.tv_sec - a.tv_sec) * 1e9 + (b.tv_nsec - a.tv_nsec)) / n;
        if (t < best) best = t;
    }
    return best;
}
"""


def numbers(text, default):
    return np.array([float(x) for x in text.split()]) if text else np.array(default, float)


def turned(rpy):
    """The rotation of roll, pitch and yaw."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in rpy)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def skew(v):
    return ca.vertcat(
        ca.horzcat(0, -v[2], v[1]), ca.horzcat(v[2], 0, -v[0]), ca.horzcat(-v[1], v[0], 0)
    )


def clean(array):
    """Zeros where roll, pitch and yaw leave 1e-12 of them, as CasADi's symbols."""
    array = np.where(np.abs(array) < 1e-12, 0, array)
    return ca.sparsify(ca.SX(array))


def inverse_dynamics(path):
    """Forces of joints by a recursion over the links of a URDF (Featherstone,
    Rigid Body Dynamics Algorithms, table 5.1), as an SX function."""
    robot = xml.parse(path).getroot()
    joints = {}
    for joint in robot.findall("joint"):
        joints.setdefault(joint.find("parent").get("link"), []).append(joint)
    links = {link.get("name"): link for link in robot.findall("link")}
    children = {joint.find("child").get("link") for joint in robot.findall("joint")}
    (base,) = [name for name in links if name not in children]
    q, qd, qdd, tau = [], [], [], []

    def force(link, w, dw, a):
        """Force and moment, about its origin, on a link and all beyond it."""
        f, n = ca.SX(3, 1), ca.SX(3, 1)
        inertial = links[link].find("inertial")
        if inertial is not None:
            origin = inertial.find("origin")
            com = numbers(None if origin is None else origin.get("xyz"), [0, 0, 0])
            turn = turned(numbers(None if origin is None else origin.get("rpy"), [0, 0, 0]))
            mass = float(inertial.find("mass").get("value"))
            i = {k: float(v) for k, v in inertial.find("inertia").attrib.items()}
            inertia = np.array(
                [[i["ixx"], i["ixy"], i["ixz"]], [i["ixy"], i["iyy"], i["iyz"]], [i["ixz"], i["iyz"], i["izz"]]]
            )
            c, inertia = clean(com), clean(turn @ inertia @ turn.T)
            f = mass * (a + ca.cross(dw, c) + ca.cross(w, ca.cross(w, c)))
            n = inertia @ dw + ca.cross(w, inertia @ w) + ca.cross(c, f)
        for joint in joints.get(link, []):
            origin = joint.find("origin")
            at = clean(numbers(None if origin is None else origin.get("xyz"), [0, 0, 0]))
            fixed = clean(turned(numbers(None if origin is None else origin.get("rpy"), [0, 0, 0])))
            kind = joint.get("type")
            relative, slide = fixed, ca.SX(3, 1)
            moves = kind in ("revolute", "continuous", "prismatic")
            if moves:
                axis = joint.find("axis")
                axis = numbers(None if axis is None else axis.get("xyz"), [1, 0, 0])
                axis = clean(axis / np.linalg.norm(axis))
                k = len(q)
                for name, symbols in (("q", q), ("qd", qd), ("qdd", qdd)):
                    symbols.append(ca.SX.sym(f"{name}{k}"))
                tau.append(None)
            elif kind != "fixed":
                raise SystemExit(f"{path}: a joint is {kind}")
            if moves and kind != "prismatic":
                k1 = skew(axis)
                relative = fixed @ (ca.SX.eye(3) + ca.sin(q[k]) * k1 + (1 - ca.cos(q[k])) * k1 @ k1)
                relative = ca.sparsify(ca.simplify(relative))
            to = relative.T
            w1, dw1 = to @ w, to @ dw
            lever = at + fixed @ (axis * q[k]) if kind == "prismatic" else at
            a1 = to @ (a + ca.cross(dw, lever) + ca.cross(w, ca.cross(w, lever)))
            if kind == "prismatic":
                a1 = a1 + axis * qdd[k] + 2 * ca.cross(w1, axis * qd[k])
            elif moves:
                dw1 = dw1 + axis * qdd[k] + ca.cross(w1, axis * qd[k])
                w1 = w1 + axis * qd[k]
            f1, n1 = force(joint.find("child").get("link"), w1, dw1, a1)
            if moves:
                tau[k] = ca.dot(axis, f1 if kind == "prismatic" else n1)
            f = f + relative @ f1
            n = n + relative @ n1 + ca.cross(lever, relative @ f1)
        return f, n

    zero = ca.SX(3, 1)
    force(base, zero, zero, ca.SX([0, 0, 9.81]))
    args = [ca.vertcat(*part) for part in (q, qd, qdd)]
    return ca.Function("invdyna", args, [ca.vertcat(*tau)], ["q", "qd", "qdd"], ["Qq"])


def quadrotor():
    """One step of a quadrotor (quaternion, 4 rotors) by Runge and Kutta's method."""
    x, u = ca.SX.sym("x", 13), ca.SX.sym("u", 4)

    def rates(x, u):
        q, v, w = x[3:7], x[7:10], x[10:13]
        r = ca.vertcat(
            ca.horzcat(1 - 2 * (q[2] ** 2 + q[3] ** 2), 2 * (q[1] * q[2] - q[0] * q[3]), 2 * (q[1] * q[3] + q[0] * q[2])),
            ca.horzcat(2 * (q[1] * q[2] + q[0] * q[3]), 1 - 2 * (q[1] ** 2 + q[3] ** 2), 2 * (q[2] * q[3] - q[0] * q[1])),
            ca.horzcat(2 * (q[1] * q[3] - q[0] * q[2]), 2 * (q[2] * q[3] + q[0] * q[1]), 1 - 2 * (q[1] ** 2 + q[2] ** 2)),
        )
        dq = ca.vertcat(-ca.dot(q[1:], w), q[0] * w + ca.cross(q[1:], w)) / 2
        inertia = np.array([0.01, 0.012, 0.02])
        moment = ca.vertcat(0.2 * (u[1] - u[3]), 0.2 * (u[2] - u[0]), 0.013 * (u[0] - u[1] + u[2] - u[3]))
        lift = ca.vertcat(0, 0, ca.sum1(u) / 1.1)
        return ca.vertcat(v, dq, ca.SX([0, 0, -9.81]) + r @ lift, (moment - ca.cross(w, inertia * w)) / inertia)

    h = 0.05
    k1 = rates(x, u)
    k2 = rates(x + h / 2 * k1, u)
    k3 = rates(x + h / 2 * k2, u)
    k4 = rates(x + h * k3, u)
    return ca.Function("quadrotor", [x, u], [x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)], ["x", "u"], ["next"])


def chain(masses=8):
    """Rates of a chain of masses between springs, one end held and one driven."""
    x, u = ca.SX.sym("x", 6 * masses + 3), ca.SX.sym("u", 3)
    place = [ca.SX(3, 1)] + [x[3 * i : 3 * i + 3] for i in range(masses + 1)]
    speed = [x[3 * (masses + 1 + i) : 3 * (masses + 2 + i)] for i in range(masses)]

    def force(a, b):
        return 0.1 / 0.03 * (1 - 0.033 / ca.sqrt(ca.sumsqr(b - a))) * (b - a)

    forces = [force(a, b) for a, b in zip(place, place[1:])]
    rates = [(b - a) / 0.03 + ca.SX([0, 0, -9.81]) for a, b in zip(forces, forces[1:])]
    return ca.Function("chain", [x, u], [ca.vertcat(*speed, u, *rates)], ["x", "u"], ["rate"])


def derived(function):
    """The function and its derivatives, as an application asks for them."""
    adjoint = function.reverse(1)
    return {
        "value": function,
        "Jacobian": function.jacobian(),
        "adjoint": adjoint,
        "Hessian-vector": adjoint.forward(1),
    }


def shortened(function, name):
    """CasADi's own function with common subexpressions shared."""
    function = function.expand()
    args = function.sx_in()
    return ca.Function(name, args, ca.cse(function.call(args)))


def compiled(functions, folder, name):
    """A library of CasADi's C."""
    generator = ca.CodeGenerator(f"{name}.c", {"with_header": False})
    for function in functions:
        generator.add(function)
    generator.generate(f"{folder}/")
    library = f"{folder}/{name}.so"
    subprocess.check_call(["gcc", *FLAGS, "-shared", "-fPIC", "-o", library, f"{folder}/{name}.c", "-lm"])
    return library


class Timed:
    """A function of a library, called with one set of arrays."""

    def __init__(self, library, name, given):
        self.external = ca.external(name, library)
        self.given = given
        self.library = ctypes.CDLL(library)
        self.function = getattr(self.library, name)

    def results(self):
        found = self.external.call(self.given)
        return [np.array(ca.densify(part), float) for part in found]

    def time(self, loop):
        f = self.external
        pointer = ctypes.POINTER(ctypes.c_double)

        def room(sparsity, values):
            part = np.array(ca.DM(sparsity, 0).nonzeros(), float)
            if values is not None:
                part = np.array(ca.project(ca.DM(values), sparsity).nonzeros(), float)
            return np.ascontiguousarray(part if len(part) else np.zeros(1))

        arg = [room(f.sparsity_in(i), self.given[i]) for i in range(f.n_in())]
        res = [room(f.sparsity_out(i), None) for i in range(f.n_out())]
        work = np.zeros(f.sz_w() + 1)
        whole = np.zeros(f.sz_iw() + 1, np.int64)
        pointers = lambda arrays, size: (pointer * (size + 1))(*[a.ctypes.data_as(pointer) for a in arrays])
        args = (
            ctypes.cast(self.function, ctypes.c_void_p),
            pointers(arg, f.sz_arg()),
            pointers(res, f.sz_res()),
            whole.ctypes.data_as(ctypes.c_void_p),
            work.ctypes.data_as(pointer),
        )
        loop.least(*args, ctypes.c_long(10))
        once = loop.least(*args, ctypes.c_long(10))
        return loop.least(*args, ctypes.c_long(max(10, int(3e6 / max(once, 1)))))


PREFIX = {"value": "", "Jacobian": "jac_", "adjoint": "adj1_", "Hessian-vector": "fwd1_adj1_"}


def rivals_of(subject, folder):
    """The libraries of one subject by rival, the name of the function, and the
    kinds of functions that they hold."""
    own = subject() if callable(subject) else inverse_dynamics(subject)
    name = own.name()
    # All second derivatives of a long robot are megabytes of C.
    order = "second" if own.size1_in(0) <= LONGEST or callable(subject) else "first"
    wanted = [kind for kind in PREFIX if order == "second" or kind != "Hessian-vector"]
    parts = derived(own)
    theirs = [shortened(parts[kind], PREFIX[kind] + name) for kind in wanted]
    pathlib.Path(folder).mkdir()
    rivals = {"CasADi": compiled(theirs, folder, "theirs")}
    robovec.accelerate(own, derivatives=order, folder=f"{folder}/graph")
    rivals["accelerate"] = f"{folder}/graph/{name}.so"
    if not callable(subject):
        robovec.casadi(subject, name, derivatives=order, folder=f"{folder}/model")
        rivals["casadi"] = f"{folder}/model/{name}.so"
    return rivals, name, wanted


def timed(rivals, function, loop, draw):
    """Nanoseconds of one function by rival, after the results were compared."""
    shape = ca.external(function, rivals["accelerate"])
    given = [ca.DM(draw.uniform(-1, 1, shape.size_in(i))) for i in range(shape.n_in())]
    for i, name in enumerate(shape.name_in()):
        if "out_" in name:
            given[i] = ca.DM(*shape.size_in(i))
    times, wanted = {}, None
    for rival, library in rivals.items():
        one = Timed(library, function, given)
        found = one.results()
        wanted = wanted or found
        for a, b in zip(wanted, found):
            size = np.abs(a).max(initial=1)
            assert np.abs(a - b).max(initial=0) <= 1e-9 * size, (function, rival)
        times[rival] = one.time(loop)
    return times


def main():
    folder = tempfile.mkdtemp()
    pathlib.Path(f"{folder}/loop.c").write_text(LOOP)
    subprocess.check_call(["gcc", "-O2", "-shared", "-fPIC", "-o", f"{folder}/loop.so", f"{folder}/loop.c"])
    loop = ctypes.CDLL(f"{folder}/loop.so")
    loop.least.restype = ctypes.c_double
    subjects = sys.argv[1:] or [ROOT / f"examples/robots/{name}.urdf" for name in ROBOTS]
    subjects += [] if sys.argv[1:] else [quadrotor, chain]
    print(f"{'subject':14}{'function':16}{'CasADi':>9}{'accelerate':>12}{'casadi':>9}   times")
    draw = np.random.default_rng(1)
    ratios = {"accelerate": [], "casadi": []}
    for number, subject in enumerate(subjects):
        rivals, name, wanted = rivals_of(subject, f"{folder}/{number}")
        title = name if callable(subject) else pathlib.Path(subject).stem[:13]
        for kind in wanted:
            times = timed(rivals, PREFIX[kind] + name, loop, draw)
            row = f"{title:14}{kind:16}{times['CasADi']:9.0f}{times['accelerate']:12.0f}"
            row += f"{times['casadi']:9.0f}  " if "casadi" in times else f"{'':11}"
            for rival in list(times)[1:]:
                ratios[rival].append(times["CasADi"] / times[rival])
                row += f" {ratios[rival][-1]:.2f}"
            print(row, flush=True)
    for rival, found in ratios.items():
        if found:
            mean = math.exp(np.mean(np.log(found)))
            print(f"{rival}: geometric mean {mean:.2f}, least {min(found):.2f}")


if __name__ == "__main__":
    main()
