"""How long a batch takes from Python beside the same call from C: the price of
the interpreter, of shapes that are checked and of results that are new arrays.

    python python/benches/batch.py

Columns: the call from C with buffers that are there; from Python with new
results, with results given by ``out=``, and with inputs that are copied. Times
are the least of several calls, in nanoseconds per state.
"""

import ctypes
import pathlib
import time

import numpy as np
import robovec

ROOT = pathlib.Path(__file__).resolve().parents[2]
STATES = 100_000


def least(call, times=9):
    best = float("inf")
    for _ in range(times):
        start = time.perf_counter()
        call()
        best = min(best, time.perf_counter() - start)
    return best


def main():
    start = time.perf_counter()
    robot = ROOT / "examples/robots/arm.urdf"
    arm = robovec.load(robot, "invdyna_d", numbers=True, forces=False)
    joints = arm.inputs["q"][0]
    arm(q=np.zeros(joints), qd=np.zeros(joints), qdd=np.zeros(joints))
    print(f"first call after importing: {time.perf_counter() - start:.3f} s")
    print(f"{'function':34}{'C':>10}{'new':>10}{'out=':>10}{'copied':>10}")
    for path, function in [
        ("robots/arm.urdf", "invdyna_d"),
        ("models/bogie.mbs", "invdyna"),
        ("models/serial-23.mbs", "accelred"),
    ]:
        program = robovec.load(ROOT / "examples" / path, function, numbers=True, forces=False)
        compiled = program.compile(passes="$cpu")
        draw = np.random.default_rng(1)
        room = compiled.arrays(STATES)
        for name, array in room.items():
            array[...] = draw.uniform(-1, 1, array.shape)
        plain = {name: np.ascontiguousarray(array) for name, array in room.items()}
        # What C pays: one call with buffers that are there.
        bases = [array.base if array.ndim > 1 else array for array in room.values()]
        results = compiled.results(STATES)
        bases += [array.base if array.ndim > 1 else array for array in results.values()]
        pointers = [ctypes.c_void_p(base.ctypes.data) for base in bases]
        direct = least(lambda: compiled._function(ctypes.c_long(STATES), *pointers))
        python = least(lambda: compiled(**room))
        reused = least(lambda: compiled(out=results, **room))
        copied = least(lambda: compiled(**plain))
        shown = [1e9 * seconds / STATES for seconds in [direct, python, reused, copied]]
        print(f"{path + ' ' + function:34}" + "".join(f"{one:10.1f}" for one in shown))


if __name__ == "__main__":
    main()
