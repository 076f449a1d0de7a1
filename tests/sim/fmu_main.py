"""Validates and runs FMUs with FMPy: `fmu_main.py FMU TABLE`.

TABLE is what `robovec sim` wrote for the same model. Prints the largest
differences from it, relative to 1 plus the number: of co-simulation, of model
exchange with CVODE, and of directional derivatives from central differences.
"""

import csv
import ctypes
import random
import shutil
import sys

from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

path, table = sys.argv[1:]
assert validate_fmu(path) == [], validate_fmu(path)
names, *rows = csv.reader(open(table))
rows = [dict(zip(names, map(float, row))) for row in rows]
end = rows[-1]["time"]
description = read_model_description(path)


def plain(name):
    """The name of a joint, which is quoted when it is no identifier."""
    return name.replace("'", "")


outputs = [unknown.variable.name for unknown in description.outputs]
moving = [name for name in outputs if plain(name) in names]
assert moving


def difference(kind):
    run = simulate_fmu(
        path, stop_time=end, output_interval=end / (len(rows) - 1), relative_tolerance=1e-10,
        fmi_type=kind, output=moving,
    )
    worst = 0.0
    for row in rows:
        found = min(run, key=lambda sample: abs(sample["time"] - row["time"]))
        for name in moving:
            expected = row[plain(name)]
            worst = max(worst, abs(found[name] - expected) / (1 + abs(expected)))
    return worst


def derivatives():
    """Compares directional derivatives with central differences, restores states,
    and resets."""
    folder = extract(path)
    fmu = instantiate_fmu(folder, description, "ModelExchange")
    fmu.enterInitializationMode()
    # Where closing the loops starts can be set, and closing corrects it.
    for guess in [v for v in description.modelVariables if v.initial == "approx"]:
        fmu.setFloat64([guess.valueReference], [float(guess.start) + 1e-3])
    fmu.exitInitializationMode()
    fmu.enterContinuousTimeMode()
    slopes = [unknown.variable for unknown in description.derivatives]
    states = [slope.derivative.valueReference for slope in slopes]
    inputs = [v.valueReference for v in description.modelVariables if v.causality == "input"]
    unknowns = sorted({v.valueReference for v in slopes} | {u.variable.valueReference for u in description.outputs})
    draw = random.Random(7)
    start = list(fmu.getFloat64(states + inputs))

    def values(numbers):
        count = len(states)
        fmu.setContinuousStates((ctypes.c_double * count)(*numbers[:count]), count)
        if inputs:
            fmu.setFloat64(inputs, numbers[count:])
        return list(fmu.getFloat64(unknowns))

    before = values(start)
    kept = fmu.getFMUState()
    saved = fmu.serializeFMUState(kept)
    worst = 0.0
    for _ in range(3):
        seed = [draw.uniform(-1, 1) for _ in start]
        step = 1e-6
        ends = [values([x + s * step * d for x, d in zip(start, seed)]) for s in (1, -1)]
        expected = [(right - left) / (2 * step) for right, left in zip(*ends)]
        values(start)
        found = fmu.getDirectionalDerivative(unknowns, states + inputs, seed)
        size = 1 + max(map(abs, expected))
        worst = max([worst] + [abs(a - b) / size for a, b in zip(found, expected)])
    # The derivative of a place along the motion is the velocity, where no law
    # drives a joint.
    names = [v.name for v in description.modelVariables]
    places = [v for v in description.modelVariables if v.name.startswith("place.")]
    if places and not any(name.startswith("law.driven.") for name in names):
        rates = [f"velocity{v.name[5:]}" for v in places]
        numbers = {v.name: v.valueReference for v in description.modelVariables}
        motion = list(fmu.getFloat64([v.valueReference for v in slopes]))
        along = fmu.getDirectionalDerivative([v.valueReference for v in places], states, motion)
        for found, rate in zip(along, fmu.getFloat64([numbers[name] for name in rates])):
            assert abs(found - rate) < 1e-9 * (1 + abs(rate)), (found, rate)
    fmu.setFMUState(fmu.deserializeFMUState(saved))
    assert list(fmu.getFloat64(unknowns)) == before
    parameters = [v for v in description.modelVariables if v.name.startswith("g.")]
    if parameters:
        fmu.setFloat64([parameters[0].valueReference], [0.0])
        assert list(fmu.getFloat64(unknowns)) != before
    fmu.reset()
    assert [fmu.getFloat64([v])[0] for v in states] == start[: len(states)]
    fmu.terminate()
    fmu.freeInstance()
    shutil.rmtree(folder)
    return worst


print(difference("CoSimulation"), difference("ModelExchange"), derivatives())
