"""Two optimal control problems in IPOPT: an arm that reaches (forward dynamics,
Runge-Kutta steps) and a quadrotor that flies to a point.

    python python/benches/optimal_control.py

The dynamics are CasADi's SX function (its virtual machine), the C that CasADi
generates of it with all derivatives that IPOPT needs, and robovec's externals.
Columns: the whole solution, iterations, calls of dynamics (constraints, their
Jacobian, the Hessian of the Lagrangian), and the largest difference of the
objective from the first row over all iterations.
"""

import subprocess
import tempfile
import time

import casadi as ca
import numpy as np
import robovec
from casadi_functions import FLAGS, ROOT, inverse_dynamics, quadrotor

ARM = ROOT / "examples/robots/arm.urdf"
OPTIONS = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": 0, "ipopt.tol": 1e-9}


def forward_dynamics():
    """Accelerations of the arm from CasADi's recursion and its solve."""
    force = inverse_dynamics(ARM)
    n = force.size1_in(0)
    q, qd, tau = (ca.SX.sym(name, n) for name in ("q", "qd", "Qq"))
    mass = ca.jacobian(force(q, qd, tau), tau)
    rate = ca.solve(mass, tau - force(q, qd, ca.SX(n, 1)))
    return ca.Function("accelred", [q, qd, tau], [rate], ["q", "qd", "Qq"], ["qdd"])


def generated(function):
    """The function and its derivatives as CasADi's own compiled C."""
    folder = tempfile.mkdtemp()
    generator = ca.CodeGenerator("own.c")
    adjoint = function.reverse(1)
    for part in (function, function.jacobian(), function.forward(1), adjoint, adjoint.jacobian(), adjoint.forward(1)):
        generator.add(part)
    generator.generate(f"{folder}/")
    library = f"{folder}/own.so"
    subprocess.check_call(["gcc", *FLAGS, "-shared", "-fPIC", "-o", library, f"{folder}/own.c", "-lm"])
    return ca.external(function.name(), library)


def reach(dynamics, intervals=15, h=0.05):
    """Reach a pose in 0.75 s with few torques; shooting over every interval."""
    n = dynamics.size1_in(0)
    x, u = ca.MX.sym("x", 2 * n), ca.MX.sym("u", n)
    rates = lambda x: ca.vertcat(x[n:], dynamics(x[:n], x[n:], u))
    k1 = rates(x)
    k2 = rates(x + h / 2 * k1)
    k3 = rates(x + h / 2 * k2)
    k4 = rates(x + h * k3)
    step = ca.Function("step", [x, u], [x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)])
    start = np.concatenate([np.linspace(0.3, -0.3, n), np.zeros(n)])
    goal = np.linspace(-0.5, 0.6, n)
    cost = lambda x, u: ca.sumsqr(x[:n] - goal) + 1e-2 * ca.sumsqr(x[n:]) + 1e-4 * ca.sumsqr(u)
    return problem(step, cost, start, n, intervals, np.zeros(n))


def fly(step, intervals=40):
    """Fly to a point in 2 s."""
    start = np.zeros(13)
    start[3] = 1
    goal = np.array([1.0, -0.5, 0.8])
    hover = np.full(4, 9.81 * 1.1 / 4)
    cost = lambda x, u: ca.sumsqr(x[:3] - goal) + 0.1 * ca.sumsqr(x[7:]) + 0.01 * ca.sumsqr(u - hover)
    return problem(step, cost, start, 4, intervals, hover)


def problem(step, cost, start, controls, intervals, guess):
    size = len(start)
    xs, us = ca.MX.sym("X", size, intervals + 1), ca.MX.sym("U", controls, intervals)
    gaps, total = [xs[:, 0] - start], 0
    for k in range(intervals):
        gaps.append(xs[:, k + 1] - step(xs[:, k], us[:, k]))
        total += cost(xs[:, k + 1], us[:, k])
    nlp = {"x": ca.veccat(xs, us), "f": total, "g": ca.veccat(*gaps)}
    return ca.nlpsol("solver", "ipopt", nlp, OPTIONS), np.concatenate([np.tile(start, intervals + 1), np.tile(guess, intervals)])


def main():
    print(f"{'problem':10}{'dynamics':16}{'whole ms':>10}{'rounds':>8}{'calls ms':>10}{'differs':>10}")
    for name, own, build, model in (
        ("reach", forward_dynamics(), reach, lambda: robovec.casadi(ARM, "accelred")),
        ("fly", quadrotor(), fly, None),
    ):
        rivals = {"CasADi, VM": own, "CasADi, C": generated(own), "accelerate": robovec.accelerate(own)}
        if model:
            rivals["casadi"] = model()
        first = None
        for rival, dynamics in rivals.items():
            solver, guess = build(dynamics)
            solver(x0=guess, lbg=0, ubg=0)
            begin = time.perf_counter()
            solver(x0=guess, lbg=0, ubg=0)
            whole = (time.perf_counter() - begin) * 1e3
            found = solver.stats()
            calls = sum(found[f"t_wall_nlp_{kind}"] for kind in ("g", "jac_g", "hess_l")) * 1e3
            costs = np.array(found["iterations"]["obj"])
            first = costs if first is None else first
            differs = np.max(np.abs(costs - first) / np.maximum(1, np.abs(first))) if len(costs) == len(first) else np.nan
            print(f"{name:10}{rival:16}{whole:10.1f}{found['iter_count']:8}{calls:10.1f}{differs:10.1e}", flush=True)


if __name__ == "__main__":
    main()
