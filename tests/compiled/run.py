"""Calls functions of equations at states that depend on names alone, and
prints every element that a call changed; what Python refuses is named."""
import math
import os
import struct
import sys
import types

MASK = (1 << 64) - 1


def number(state, name, i, j):
    x = (1469598103934665603 + state) & MASK
    for byte in name.encode():
        x = ((x ^ byte) * 1099511628211) & MASK
    x = (x + i * 0x9E3779B97F4A7C15 + j * 0xC2B2AE3D27D4EB4F) & MASK
    x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & MASK
    x ^= x >> 31
    return ((x >> 11) + 0.5) / (1 << 52) - 1.0


class Floats:
    """An array of floats, as numpy has them: a whole number becomes one."""

    def __init__(self, given=None, extents=None):
        self.given, self.extents, self.values = given, extents, {}

    def check(self, key):
        keys = key if isinstance(key, tuple) else (key,)
        if not all(type(index) is int and index >= 0 for index in keys):
            raise IndexError(key)
        if self.extents is not None:
            if len(keys) != len(self.extents) or any(k >= e for k, e in zip(keys, self.extents)):
                raise IndexError(key)

    def __getitem__(self, key):
        self.check(key)
        if key in self.values:
            return self.values[key]
        if self.given is None:
            return 0.0
        i, j = key if isinstance(key, tuple) else (key, 0)
        return number(*self.given, i, j)

    def __setitem__(self, key, value):
        self.check(key)
        self.values[key] = float(value)


def zeros(extents):
    return Floats(extents=extents if isinstance(extents, tuple) else (extents,))


numpy = types.ModuleType("numpy")
numpy.sin, numpy.cos, numpy.sqrt, numpy.zeros = math.sin, math.cos, math.sqrt, zeros
sys.modules["numpy"] = numpy
INPUTS = "q qd qdd m g lrod c Qq h Jdqd Flink Z Zd dpt l In frc trq M Jac".split()
CALLS = {
    "dirdyna": "M c s t", "invdyna": "Qq s t", "cons_hJ": "h Jac s", "cons_jdqd": "Jdqd s",
    "link": "frc trq Flink Z Zd s t", "extforces": "frc trq s t", "sensor": "sens s n",
    "gensensor": "sens s n", "accelred": "s t", "dirdyna_odn": "s t",
}


class Structure:
    pass


def run(state, call, path, function, case):
    s, sens = Structure(), Structure()
    arrays = {}
    for name in INPUTS:
        arrays[name] = Floats((state, name))
        setattr(s, name, arrays[name])
    for field in ("P", "R", "V", "OM", "A", "OMP", "J"):
        arrays["sens." + field] = Floats((state, "sens." + field))
        setattr(sens, field, arrays["sens." + field])
    s.tsim = number(state, "tsim", 0, 0)
    lines = []

    def element(name, i, j, value):
        bits = struct.unpack("<Q", struct.pack("<d", value))[0]
        lines.append("%s %d %d %016x" % (name, i, j, bits))

    def link(z, zd, data, time, k):
        element("call%d.0" % k, 0, 0, float(z))
        element("call%d.1" % k, 0, 0, float(zd))
        return number(state, "Force", k, 0)

    def force(*given):
        k = given[-1]
        for place, values in enumerate(given[:6]):
            for key, value in values.values.items():
                i, j = key if isinstance(key, tuple) else (key, 0)
                element("call%d.%d" % (k, place), i, j, value)
        return Floats((state, "SWr%d" % k))

    s.user_LinkForces, s.user_ExtForces = link, force
    known = dict(arrays, s=s, t=s.tsim, sens=sens, n=case)
    names = {}
    with open(path, encoding="utf-8") as file:
        exec(compile(file.read(), path, "exec"), names)
    names[function](*[known[word] for word in CALLS[function].split()])
    for name, array in arrays.items():
        if getattr(s, name, array) is not array:
            raise ValueError("the structure has another array")
        for key, value in array.values.items():
            i, j = key if isinstance(key, tuple) else (key, 0)
            element(name, i, j, value)
    return lines


for line in sys.stdin:
    state, call, path, function, case = line.split()
    silent = open(os.devnull, "w")
    kept, sys.stdout = sys.stdout, silent
    try:
        lines = run(int(state), int(call), path, function, int(case))
    except Exception as error:
        lines = ["refused %s" % type(error).__name__]
    finally:
        sys.stdout = kept
        silent.close()
    print("call", state, call)
    print("\n".join(lines))
