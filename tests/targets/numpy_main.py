"""Calls a function of NumPy: `numpy_main.py MODULE FUNCTION INPUTS`."""

import importlib
import sys

import numpy as np

sys.path.insert(0, ".")
function = getattr(importlib.import_module(sys.argv[1]), sys.argv[2])


def tuple_of(results):
    return results if isinstance(results, tuple) else (results,)


arrays = []
for line in open(sys.argv[3]):
    shape, numbers = line.split(";")
    numbers = np.array([float(word) for word in numbers.split()])
    arrays.append(numbers.reshape([int(word) for word in shape.split()]))
results = tuple_of(function(*arrays))
for result in results:
    for number in np.ravel(result):
        print(repr(float(number)))

# Further axes in front, of the first input only: the others are shared.
first = np.broadcast_to(arrays[0], (3, 2) + arrays[0].shape)
for one, many in zip(results, tuple_of(function(first, *arrays[1:]))):
    assert many.shape == (3, 2) + one.shape, many.shape
    size = np.max(np.abs(one), initial=1e-300)
    assert np.all(np.abs(many - one) <= 1e-13 * size)
