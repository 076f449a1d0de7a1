"""Compiled functions: C that robovec wrote, as a library that Python calls.

C counts elements from 1. An array of states has room for an element 0 that
nobody reads; ``Compiled.arrays`` gives NumPy views on such arrays, which are
passed without being copied.
"""

from __future__ import annotations

import ctypes
import os
import pathlib
import shutil
import subprocess
import tempfile
from typing import TYPE_CHECKING, Any, Sequence

import numpy as np

from . import _gate, _robovec
from ._robovec import Error

if TYPE_CHECKING:
    from . import Program


def library_of(
    files: Sequence[tuple[str, str]],
    place: pathlib.Path,
    name: str,
    compiler: str,
    flags: Sequence[str],
) -> pathlib.Path:
    """Writes C files into a folder and compiles them into a library of a name."""
    _robovec.write_files(str(place), list(files))
    sources = [str(place / file) for file, _ in files if file.endswith(".c")]
    library = place / f"{name}.so"
    command = [compiler, *flags, "-shared", "-fPIC", "-o", str(library), *sources, "-lm"]
    try:
        done = subprocess.run(command, capture_output=True, text=True)
    except OSError as error:
        raise Error(f"cannot start the compiler '{compiler}': {error}") from error
    if done.returncode != 0:
        raise Error(f"{' '.join(command)}\n{done.stderr}")
    return library


def compile_files(
    program: Program,
    files: Sequence[tuple[str, str]],
    number: str,
    compiler: str,
    flags: Sequence[str],
    folder: str | os.PathLike[str] | None,
) -> Compiled:
    """Writes C files, compiles them into a library and loads it."""
    kept = folder is not None
    place = pathlib.Path(tempfile.mkdtemp(prefix="robovec-") if folder is None else folder)
    try:
        library = library_of(files, place, program.name, compiler, flags)
        try:
            loaded = ctypes.CDLL(str(library))
        except OSError as error:
            raise Error(f"cannot load what '{compiler}' made: {error}") from error
        return Compiled(program, loaded, number, place if kept else None)
    finally:
        # The library stays in memory when its file is gone.
        if not kept:
            shutil.rmtree(place, ignore_errors=True)


class Compiled:
    """A compiled function for many states."""

    def __init__(
        self, program: Program, library: ctypes.CDLL, number: str, folder: pathlib.Path | None
    ) -> None:
        self._program = program
        self._number = np.dtype(np.float64 if number == "double" else np.float32)
        self._function = getattr(library, f"{program.name}_states")
        self._function.restype = ctypes.c_int
        self.folder = folder
        """Where the C files and the library are; ``None`` when they were removed."""

    def arrays(self, states: int) -> dict[str, np.ndarray]:
        """Zeros for every input of so many states, as the function reads them:
        what is filled in is passed without being copied.

            >>> room = compiled.arrays(1000)
            >>> room["q"][...] = 0.1
        """
        shapes = self._program.inputs.items()
        return {name: self._room(shape, states) for name, shape in shapes}

    def _room(self, shape: tuple[int, ...], states: int) -> np.ndarray:
        states = _gate.whole("states", states)
        padded = np.zeros((states, *(extent + 1 for extent in shape)), self._number)
        return padded[(slice(None), *(slice(1, None) for _ in shape))]

    def _whole(self, array: np.ndarray, shape: tuple[int, ...]) -> np.ndarray | None:
        """The array with its elements 0 behind a view, when it is one of ours."""
        base = array.base if shape else array
        if base is None or not isinstance(base, np.ndarray) or base.dtype != self._number:
            return None
        padded = (len(array), *(extent + 1 for extent in shape))
        first = base[(slice(None), *(slice(1, None) for _ in shape))] if base.shape == padded else None
        same = (
            first is not None
            and first.strides == array.strides
            and first.ctypes.data == array.ctypes.data
        )
        return base if same and base.flags.c_contiguous else None

    def results(self, states: int) -> dict[str, np.ndarray]:
        """Zeros for every output of so many states, for ``out``.

            >>> compiled(**room, out=compiled.results(1000))
        """
        shapes = self._program.outputs.items()
        return {name: self._room(shape, states) for name, shape in shapes}

    def __call__(
        self, *, out: dict[str, np.ndarray] | None = None, **arrays: Any
    ) -> dict[str, np.ndarray]:
        """Outputs at one state, or at many that stand along a first axis; as the
        program itself, compiled. States are shared among the cores. ``out`` takes
        the results, as ``results`` made it; fresh arrays cost the time that the
        system takes to give their memory."""
        program = self._program
        own = {name: array for name, array in arrays.items() if isinstance(array, np.ndarray)}
        given, states = program._states(arrays)
        count = 1 if states is None else states
        passed: list[np.ndarray] = []
        for (name, shape), array in zip(program.inputs.items(), given):
            ours = own.get(name)
            whole: np.ndarray | None = None
            if ours is not None and ours.ndim == len(shape) + 1 and len(ours) == count:
                whole = self._whole(ours, shape)
            if whole is None:
                room = self._room(shape, count)
                room[...] = array
                whole = self._whole(room, shape)
            assert whole is not None, "room is one of ours"
            passed.append(whole)
        results = self.results(count) if out is None else out
        for name, shape in program.outputs.items():
            room = _gate.room(name, results.get(name), (count, *shape), self._number)
            whole = self._whole(room, shape)
            if whole is None:
                raise Error(f"'{name}' of out is not of results({count})")
            if any(np.may_share_memory(whole, other) for other in passed):
                raise Error(f"'{name}' of out shares its memory with another array")
            passed.append(whole)
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in passed]
        if self._function(ctypes.c_long(count), *pointers) != 0:
            raise MemoryError("there is no memory for a copied batch")
        return results if states is not None else {name: array[0] for name, array in results.items()}
