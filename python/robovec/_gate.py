"""The gate for what callers pass: numbers and arrays as robovec can take them.

What it refuses raises ``Error``; nothing is rounded, cut or written over
without a word.
"""

from __future__ import annotations

import operator
from typing import Any

import numpy as np

from ._robovec import Error


def numbers(name: str, value: Any) -> np.ndarray:
    """The array of an input, in 64-bit floats that lose nothing of it."""
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise Error(f"'{name}' has masked elements; fill them first: .filled(number)")
    try:
        array = np.asarray(value)
    except (TypeError, ValueError) as error:
        raise Error(f"'{name}' is no array of numbers: {error}") from error
    if array.dtype.kind not in "buif":
        raise Error(f"'{name}' holds {array.dtype}, not real numbers")
    with np.errstate(all="ignore"):
        found = array.astype(np.float64, copy=False)
        small = array.dtype.itemsize < 8 or array.dtype == np.float64
        same = small or np.array_equal(
            found.astype(array.dtype), array, equal_nan=array.dtype.kind == "f"
        )
    if not same:
        raise Error(f"'{name}' holds numbers of {array.dtype} that 64-bit floats do not hold")
    return found


def whole(name: str, value: Any) -> int:
    """A whole number from 0 on; its upper limit is that of its use."""
    try:
        number = operator.index(value)
    except TypeError as error:
        raise Error(f"{name} is no whole number: {value!r}") from error
    if not 0 <= number < 2**32:
        raise Error(f"{name} is not from 0 to 2^32 - 1: {number}")
    return number


def room(name: str, value: Any, shape: tuple[int, ...], dtype: np.dtype) -> np.ndarray:
    """An array of ``out``, which results may be written into."""
    if not isinstance(value, np.ndarray) or value.shape != shape or value.dtype != dtype:
        raise Error(f"'{name}' of out is not of results({shape[0]})")
    if not value.flags.writeable:
        raise Error(f"'{name}' of out is read-only")
    return value
