"""Calls a function of JAX: `jax_main.py MODULE FUNCTION INPUTS`."""

import importlib
import sys

import jax
import numpy as np
from jax.test_util import check_grads

jax.config.update("jax_enable_x64", True)
sys.path.insert(0, ".")
function = getattr(importlib.import_module(sys.argv[1]), sys.argv[2])


def tuple_of(results):
    return results if isinstance(results, tuple) else (results,)


def near(found, expected):
    size = np.max(np.abs(expected), initial=1e-300)
    assert np.all(np.abs(found - expected) <= 1e-12 * size), (found, expected)


arrays = []
for line in open(sys.argv[3]):
    shape, numbers = line.split(";")
    numbers = np.array([float(word) for word in numbers.split()])
    arrays.append(numbers.reshape([int(word) for word in shape.split()]))
results = tuple_of(function(*arrays))
for result in results:
    assert result.dtype == np.float64
    for number in np.ravel(result):
        print(repr(float(number)))

many = [np.broadcast_to(array, (3,) + array.shape) for array in arrays]
compiled = tuple_of(jax.jit(function)(*arrays))
mapped = tuple_of(jax.vmap(function)(*many))
for one, fast, all_states in zip(results, compiled, mapped):
    near(fast, one)
    assert all_states.shape == (3,) + one.shape
    near(all_states, one)
check_grads(function, arrays, order=1, modes=["fwd", "rev"], rtol=1e-5, atol=1e-5)
