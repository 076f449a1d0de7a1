"""Model predictive control in acados: the arm of optimal_control.py reaches a
pose, with dynamics as CasADi's generated C and as robovec's external functions.

    pip install comma-deps-acados --no-deps --target FOLDER
    python python/benches/acados_reach.py FOLDER

acados takes 12 Gauss-Newton steps (SQP_RTI, HPIPM) over 15 intervals of 50 ms,
with one Runge-Kutta step each. Columns: the mean of a step, of its integrator
and of the calls of dynamics in it, in ms of acados's clock (least of 25 runs);
the last step of the states and torques; and their largest difference from the
first row over all steps.
"""

import ctypes
import os
import pathlib
import sys
import tempfile

import casadi as ca
import numpy as np
import robovec
from casadi_functions import ROOT
from optimal_control import forward_dynamics

ARM = ROOT / "examples/robots/arm.urdf"
INTERVALS, STEP, ROUNDS, REPEATS = 15, 0.05, 12, 25
FLAGS = "-O3 -march=native"


def solver(name, symbol, rate, library=None):
    """The solver of acados for one expression of the accelerations."""
    from acados_template import AcadosModel, AcadosOcp, AcadosOcpSolver

    x, u = symbol("x", 14), symbol("u", 7)
    model = AcadosModel()
    model.name, model.x, model.u = name, x, u
    model.xdot, model.f_expl_expr = symbol("xdot", 14), ca.vertcat(x[7:], rate(x[:7], x[7:], u))
    ocp = AcadosOcp()
    ocp.model = model
    ocp.dims.N = INTERVALS
    ocp.cost.cost_type = ocp.cost.cost_type_e = "LINEAR_LS"
    goal = np.concatenate([np.linspace(-0.5, 0.6, 7), np.zeros(7)])
    weights = np.concatenate([np.ones(7), np.full(7, 1e-2), np.full(7, 1e-4)])
    # acados multiplies the costs of intervals by their length.
    ocp.cost.W, ocp.cost.W_e = 2 / STEP * np.diag(weights), 2 * np.diag(weights[:14])
    ocp.cost.Vx, ocp.cost.Vx_e = np.eye(21, 14), np.eye(14)
    ocp.cost.Vu = np.eye(21, 7, -14)
    ocp.cost.yref, ocp.cost.yref_e = np.concatenate([goal, np.zeros(7)]), goal
    ocp.constraints.x0 = START
    options = ocp.solver_options
    options.tf = INTERVALS * STEP
    options.integrator_type, options.sim_method_num_stages, options.sim_method_num_steps = "ERK", 4, 1
    options.nlp_solver_type, options.hessian_approx = "SQP_RTI", "GAUSS_NEWTON"
    options.qp_solver, options.tol = "PARTIAL_CONDENSING_HPIPM", 1e-8
    options.ext_fun_compile_flags = FLAGS
    if library:
        options.model_external_shared_lib_dir = str(library.parent)
        options.model_external_shared_lib_name = library.stem.removeprefix("lib")
    ocp.code_export_directory = f"c_{name}"
    return AcadosOcpSolver(ocp, json_file=f"{name}.json", verbose=False)


START = np.concatenate([np.linspace(0.3, -0.3, 7), np.zeros(7)])


def solved(ocp):
    """States and torques after every step from the same guess, and the mean times
    of a step."""
    ocp.reset()
    for k in range(INTERVALS + 1):
        ocp.set(k, "x", START)
        if k < INTERVALS:
            ocp.set(k, "u", np.zeros(7))
    iterates, times = [], np.zeros(3)
    for _ in range(ROUNDS):
        if ocp.solve() != 0:
            raise SystemExit("acados fails")
        states = [ocp.get(k, "x") for k in range(INTERVALS + 1)]
        iterates.append(np.concatenate(states + [ocp.get(k, "u") for k in range(INTERVALS)]))
        times += [1e3 * ocp.get_stats(f"time_{part}").item() / ROUNDS for part in ("tot", "sim", "sim_ad")]
    return np.array(iterates), times


def main():
    folder = pathlib.Path(tempfile.mkdtemp())
    os.chdir(folder)
    # The name by which acados's library finds robovec's.
    flags = [*FLAGS.split(), "-Wl,-soname,libaccelred.so"]
    outside = robovec.casadi(ARM, "accelred", folder=folder / "robovec", derivatives="first", flags=flags)
    library = folder / "robovec" / "libaccelred.so"
    library.symlink_to(folder / "robovec" / "accelred.so")
    ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)
    own = forward_dynamics()
    rivals = {
        "CasADi, C": solver("own", ca.SX.sym, own),
        "casadi": solver("outside", ca.MX.sym, outside, library),
    }
    print(f"{'dynamics':16}{'step':>8}{'integrator':>12}{'calls':>9}{'last step':>11}{'differs':>9}")
    first = None
    for name, ocp in rivals.items():
        runs = [solved(ocp) for _ in range(REPEATS)]
        whole, integrator, calls = np.min([times for _, times in runs], axis=0)
        iterates = runs[0][0]
        first = iterates if first is None else first
        last, differs = np.abs(iterates[-1] - iterates[-2]).max(), np.abs(iterates - first).max()
        print(f"{name:16}{whole:8.3f}{integrator:12.3f}{calls:9.3f}{last:11.1e}{differs:9.1e}", flush=True)


if __name__ == "__main__":
    acados = pathlib.Path(sys.argv[1]).resolve() / "acados"
    os.environ["ACADOS_SOURCE_DIR"] = str(acados / "install")
    os.environ["ACADOS_PYTHON_INTERFACE_PATH"] = str(acados / "acados_template")
    sys.path.append(str(acados))
    # Libraries of the wheel do not find each other.
    for file in ("libblasfeo.so", "libhpipm.so", "libqpOASES_e.so", "libacados.so"):
        ctypes.CDLL(str(acados / "install" / "lib" / file), ctypes.RTLD_GLOBAL)
    main()
