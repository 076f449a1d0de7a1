"""robovec: a compiler for the equations of mechanical systems.

    >>> import robovec
    >>> arm = robovec.load("arm.urdf", function="invdyna_d", numbers=True)
    >>> fast = arm.run("$cpu")
    >>> fast(q={"elbow": 0.3}, qd={}, qdd={})["Qq_q"]

Arrays count from 0, as everywhere in NumPy: ``M[0, 0]`` is Robotran's
``M[1][1]``; ``index`` and ``labels`` translate names of joints. Units are those
of the model (SI). Elements that a function does not set are zero.
"""

from __future__ import annotations

import difflib
import html
import json
import os
import warnings
from typing import TYPE_CHECKING, Any, Mapping, Sequence

import numpy as np

from . import _casadi, _gate, _robovec
from ._compiled import Compiled, compile_files
from ._robovec import Error, __version__

if TYPE_CHECKING:
    import casadi as ca

__all__ = ["Compiled", "Error", "Program", "View", "accelerate", "casadi", "load", "parse", "__version__"]


def load(
    path: str | os.PathLike[str],
    function: str | None = None,
    *,
    formulation: str = "recursive",
    numbers: bool = False,
    forces: bool = True,
    model: str | os.PathLike[str] | None = None,
    jacobians: bool = False,
    floating: bool = False,
    quaternion: bool = False,
    right_angles: float = 0.0,
) -> Program:
    """Reads equations (Robotran's C, Matlab or Python, robovec's text) or makes
    a function of a model (``.mbs``, ``.urdf``, ``.xml``).

    ``function`` is one of a file that has several, or what is made of a model
    (``dirdyna`` without a word). ``formulation``, ``numbers`` (the model's
    numbers in place of symbols) and ``forces`` (external forces and torques)
    concern models, and so does ``jacobians``: the Jacobians of the outputs
    (``Qq_q`` of ``Qq``) as further outputs, where they have a recursion of their
    own. ``formulation="fewest"`` takes the one with the fewest operations.
    ``floating`` and ``right_angles`` concern robots: a base that moves freely, and
    the angle, in rad, within which a fixed rotation is taken as a right angle.
    ``quaternion`` describes a free base by a quaternion ``quat`` (x, y, z, w) and
    its motion along its own axes.
    ``model`` names the model that gives a file of equations its parameters.

    Raises ``Error`` with the place and the remedy when something is wrong, and
    warns of what is left out.

        >>> hand = robovec.load("arm.urdf", "frame_hand", numbers=True)
    """
    other = None if model is None else os.fspath(model)
    if not 0 <= right_angles <= 0.1:
        raise Error(f"right_angles is from 0 to 0.1 rad, not {right_angles!r}")
    options = dict(
        formulation=formulation,
        numbers=numbers,
        forces=forces,
        jacobians=jacobians,
        floating=floating,
        quaternion=quaternion,
        right_angles=float(right_angles),
    )
    inner = _robovec.Program.load(os.fspath(path), function, options, other)
    if inner.remarks:
        warnings.warn(inner.remarks.rstrip(), stacklevel=2)
    return Program(inner)


def parse(text: str, function: str | None = None) -> Program:
    """Reads robovec's own text, as ``str(program)`` writes it.

        >>> robovec.parse(str(arm)).name
        'invdyna_d'
    """
    return Program(_robovec.Program.parse(text, function))


def casadi(
    subject: Program | str | os.PathLike[str],
    function: str = "invdyna",
    *,
    name: str | None = None,
    derivatives: str = "second",
    passes: str = _casadi.QUICK_PASSES,
    formulation: str = "fewest",
    numbers: bool = True,
    forces: bool = False,
    floating: bool = False,
    quaternion: bool = False,
    right_angles: float = 1e-10,
    compiler: str = "cc",
    flags: Sequence[str] = _casadi.FLAGS,
    folder: str | os.PathLike[str] | None = None,
) -> ca.Function:
    """A function of a robot or model (or a program) as a CasADi function.

    It is compiled C with sparse Jacobians, adjoints and directions, and with
    ``derivatives="second"`` those of the adjoints, which CasADi finds by
    itself: in a Jacobian, a Hessian or an integrator. ``passes`` run before, each
    proved at four points.
    ``name`` is that of the CasADi function; ``folder`` keeps the C file and the
    library. The other options are those of ``load``.

        >>> tau = robovec.casadi("arm.urdf", "invdyna")
        >>> tau(q, qd, qdd), tau.jacobian()
    """
    program = subject
    if not isinstance(program, Program):
        program = load(
            program,
            function,
            formulation=formulation,
            numbers=numbers,
            forces=forces,
            jacobians=not quaternion,
            floating=floating,
            quaternion=quaternion,
            right_angles=right_angles,
        )
    program = program.run(passes, check=True) if passes else program
    program = program if name is None else Program(program._inner.renamed(name))
    return _casadi.external(program, derivatives, compiler, flags, folder)


def accelerate(
    function: ca.Function,
    *,
    passes: str = _casadi.PASSES,
    derivatives: str = "second",
    points: int = 4,
    compiler: str = "cc",
    flags: Sequence[str] = _casadi.FLAGS,
    folder: str | os.PathLike[str] | None = None,
) -> ca.Function:
    """A CasADi function, optimised, proved and compiled.

    Its scalar operations become a program, ``passes`` shorten it, each is
    proved at so many ``points``, and the compiled result is compared with the
    original at as many. It takes SX functions, and MX functions that can be
    expanded; other operations than + - * /, sin, cos, tan, sqrt and constant
    powers are refused by name.

        >>> fast = robovec.accelerate(f)
    """
    program = parse(_casadi.text_of(function, function.name()))
    if passes:
        program = program.run(passes, check=points)
    made = _casadi.external(program, derivatives, compiler, flags, folder)
    _casadi.compare(function, made, points)
    return made


class Program:
    """A function: it can be transformed, evaluated, written and compiled.

    Objects never change; ``run`` and ``differentiate`` give new ones.
    """

    def __init__(self, inner: _robovec.Program) -> None:
        self._inner = inner
        self.inputs: dict[str, tuple[int, ...]] = {
            name: tuple(shape) for name, shape in inner.inputs
        }
        self.outputs: dict[str, tuple[int, ...]] = {
            name: tuple(shape) for name, shape in inner.outputs
        }

    @property
    def name(self) -> str:
        """The name of the function, as ``invdyna``."""
        return self._inner.name

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints in the order of ``q``; none without a model.

            >>> robovec.load("arm.urdf").joints
            ('joint_1', 'joint_2', 'joint_3')
        """
        return tuple(self._inner.joints)

    @property
    def frames(self) -> tuple[str, ...]:
        """Names of the model's frames: ``load(path, "frame_NAME")`` gives the
        pose, motion and Jacobian of one."""
        return tuple(self._inner.frames)

    def labels(self, array: str) -> tuple[tuple[str, ...] | None, ...]:
        """Names along every axis of an array: of joints, or for ``m``, ``l``,
        ``In``, ``frc`` and ``trq`` of bodies; ``None`` for an axis without names.

            >>> arm.labels("jacobian")
            (None, ('joint_1', 'joint_2', 'joint_3'))
        """
        shape = {**self.inputs, **self.outputs}.get(array)
        if shape is None:
            known = ", ".join([*self.inputs, *self.outputs])
            raise Error(f"{self.name} has no array '{array}'; there are: {known}")
        named = self._inner.labels(array)
        return tuple(names and tuple(names[:extent]) for names, extent in zip(named, shape))

    def index(self, array: str, *names: str) -> Any:
        """The NumPy index of named joints or bodies: a number in a vector, else
        one index for each axis. An axis without a given name is taken whole.

            >>> M[arm.index("M", "shoulder", "elbow")], q[arm.index("q", "elbow")]
        """
        left = list(names)
        found = [
            slice(None) if known is None or not left else self._place(array, known, left.pop(0))
            for known in self.labels(array)
        ]
        if left or not names:
            raise Error(f"'{array}' of {self.name} takes fewer names, and at least one")
        return found[0] if len(found) == 1 else tuple(found)

    @staticmethod
    def _place(array: str, known: Sequence[str], name: str) -> int:
        if name and name in known:
            return known.index(name)
        near = difflib.get_close_matches(str(name), known, 1)
        advice = f"did you mean '{near[0]}'?" if near else f"there are: {', '.join(filter(None, known))}"
        raise Error(f"'{array}' has no element '{name}'; {advice}")

    @property
    def operations(self) -> int:
        """Operations: everything but sines, cosines and copies."""
        return self._inner.operations

    def __str__(self) -> str:
        return self._inner.text()

    def __repr__(self) -> str:
        return f"<robovec.Program {self.name}: {self.operations} operations>"

    def run(
        self, passes: str, *, machine: str = "thesis", check: int | bool = False
    ) -> Program:
        """The function after a pipeline, as ``$cpu`` or ``atomise,balance``.

        ``check`` compares it before and after every pass at so many points
        (``True``: 4) and raises ``Error`` when a pass changed the function.

            >>> fast = arm.run("$cpu", check=True)
        """
        points = 4 if check is True else _gate.whole("check", check) or None
        return Program(self._inner.run(passes, machine, points))

    def differentiate(
        self,
        of: str,
        by: str | Sequence[str],
        *,
        result: str = "jacobian",
        mode: str | None = None,
        values: bool = True,
    ) -> Program:
        """The function with its derivatives: ``Qq_q`` for ``of="Qq", by="q"``.

        ``result`` is ``jacobian``, ``direction`` (the Jacobian times an input
        ``q_direction``) or ``gradient`` (the transposed Jacobian times an input
        ``Qq_weight``); without ``values`` the outputs themselves are left out.

            >>> arm.differentiate("Qq", ["q", "qd"]).outputs
        """
        names = by if isinstance(by, str) else "+".join(by)
        options = f"of={of} by={names} result={result} values={str(values).lower()}"
        if mode is not None:
            options += f" mode={mode}"
        return self.run(f"atomise,differentiate{{{options}}},fold,cse,dce")

    def report(self, machine: str = "thesis") -> dict[str, Any]:
        """Operations, path, schedule, errors: the report of the command line.

            >>> arm.run("$shorten,place").report()["schedule"]["cycles"]
        """
        return json.loads(self._inner.report(machine))["functions"][0]

    def parameters(self) -> dict[str, np.ndarray]:
        """The arrays for which the model has numbers.

            >>> arm.parameters()["m"]
        """
        found = {name: self._parameter(name) for name in self.inputs}
        return {name: array for name, array in found.items() if array is not None}

    def _parameter(self, name: str) -> np.ndarray | None:
        numbers = self._inner.parameters(name)
        return None if numbers is None else np.array(numbers).reshape(self.inputs[name])

    def __call__(
        self,
        *,
        number: str = "f64",
        threads: int = 0,
        **arrays: Any,
    ) -> dict[str, np.ndarray]:
        """Outputs at one state, or at many that stand along a first axis.

        Arrays that are left out are the model's parameters; what the model
        does not know either is an error. An array without the first axis is
        the same for all states. A dictionary gives elements by the names of
        joints or bodies (``labels``); the others are the model's, or zero.
        ``number`` is what is computed with (``f32``,
        ``float(8,17)``, ``fixed(12,19)``, …) and ``threads`` how many threads
        share the states (0: as many as there are processors; 1024 at most). Results are those
        of ``robovec eval``, bit for bit, in 64-bit floats.

            >>> arm(q={"elbow": [0.1, 0.2]}, qd={}, qdd={})["Qq"].shape
            (2, 7)
        """
        given, states = self._states(arrays)
        count = 1 if states is None else states
        parts = [
            np.broadcast_to(array, (count, *shape)).reshape(count, -1)
            for (array, shape) in zip(given, self.inputs.values())
        ]
        flat = np.concatenate(parts, axis=1) if parts else np.zeros((count, 0))
        flat = np.ascontiguousarray(flat, dtype=np.float64)
        raw = self._inner.evaluate(flat.tobytes(), number, _gate.whole("threads", threads))
        numbers = np.frombuffer(raw).reshape(-1, self._width(self.outputs))
        if len(numbers) != count:
            numbers = np.broadcast_to(numbers, (count, numbers.shape[1]))
        found, start = {}, 0
        for name, shape in self.outputs.items():
            size = int(np.prod(shape, dtype=int))
            part = numbers[:, start : start + size].reshape(count, *shape).copy()
            found[name] = part if states is not None else part[0]
            start += size
        return found

    def compile(
        self,
        *,
        number: str = "double",
        passes: str = "",
        compiler: str = "cc",
        flags: Sequence[str] = ("-O3", "-march=native", "-fopenmp"),
        lanes: int = 8,
        folder: str | os.PathLike[str] | None = None,
    ) -> Compiled:
        """The function as C that computes many states at once, compiled and
        loaded; it is called like the program itself.

        ``passes`` run before, as ``$cpu``. ``folder`` keeps the C files and the
        library; without it they are removed with the object.

            >>> arm.compile(passes="$cpu")(q=many, qd=many, qdd=many)
        """
        if number not in ("double", "float"):
            raise Error(f"number is 'double' or 'float', not {number!r}")
        options = f"target=batch number={number} lanes={lanes} parameters=own"
        steps = [passes] if passes else []
        steps.append(f"codegen{{{options}}}")
        files = self._inner.files(",".join(steps), "thesis")
        return compile_files(self, files, number, compiler, flags, folder)

    def view(self, passes: str = "$shorten,place", *, machine: str = "thesis") -> View:
        """The page of ``robovec view`` for a notebook: the passes side by side,
        the origin of values, the longest path, the schedule and the errors.

            >>> arm.view("$cpu")
        """
        return View(self._inner.page(passes, machine))

    def plot_schedule(self, axes: Any = None) -> Any:
        """The schedule of a placed program: elements over cycles (matplotlib).

            >>> arm.run("$shorten,place").plot_schedule()
        """
        import matplotlib.pyplot as plt

        found = self._inner.schedule()
        if found is None:
            raise Error("there is no schedule: run a pipeline that ends in place")
        elements, operations, cycles = found
        axes = axes or plt.subplots(figsize=(10, 0.3 * len(elements) + 1))[1]
        rows = [element for _, element, _ in operations]
        starts = [cycle for _, _, cycle in operations]
        axes.barh(rows, width=1, left=starts, height=0.8)
        axes.set_yticks(range(len(elements)), elements)
        axes.set_xlabel(f"cycle of {cycles}")
        axes.set_title(f"{self.name}: {len(operations)} operations")
        return axes

    @staticmethod
    def _width(arrays: Mapping[str, tuple[int, ...]]) -> int:
        return sum(int(np.prod(shape, dtype=int)) for shape in arrays.values())

    def _by_names(self, name: str, others: np.ndarray, values: Mapping[str, Any]) -> np.ndarray:
        """An input whose elements are given by names, with or without states."""
        labels = self.labels(name)
        axis = next((axis for axis, names in enumerate(labels) if names), None)
        if axis is None:
            raise Error(f"the elements of '{name}' have no names: give an array")
        rest = others.shape[:axis] + others.shape[axis + 1 :]
        parts = {
            self._place(name, labels[axis], key): _gate.numbers(f"{name}[{key}]", value)
            for key, value in values.items()
        }
        states = {part.shape[: part.ndim - len(rest)] for part in parts.values()} - {()}
        is_wrong = any(part.shape[part.ndim - len(rest) :] != rest for part in parts.values())
        if is_wrong or len(states) > 1 or any(len(count) > 1 for count in states):
            raise Error(
                f"elements of '{name}' have the shape {rest}, or (states, …) before it, with the "
                "same number of states"
            )
        array = np.tile(others, (*(states.pop() if states else ()), *[1] * others.ndim))
        for place, part in parts.items():
            array[(..., place, *[slice(None)] * (len(labels) - 1 - axis))] = part
        return array

    def _states(self, arrays: Mapping[str, Any]) -> tuple[list[np.ndarray], int | None]:
        """The inputs in order, and how many states they are; ``None`` for a
        single one without a first axis."""
        for name in arrays:
            if name not in self.inputs:
                known = ", ".join(self.inputs)
                raise Error(f"{self.name} has no input '{name}'; there are: {known}")
        given: list[np.ndarray] = []
        states: int | None = None
        for name, shape in self.inputs.items():
            known = self._parameter(name)
            if isinstance(arrays.get(name), Mapping):
                array = self._by_names(name, np.zeros(shape) if known is None else known, arrays[name])
            elif name in arrays:
                array = _gate.numbers(name, arrays[name])
            elif known is None:
                raise Error(f"{self.name} needs the input '{name}' of shape {shape}")
            else:
                array = known
            if array.shape[1:] == shape and array.ndim == len(shape) + 1:
                if len(array) == 0:
                    raise Error(f"'{name}' has no states")
                if states is not None and states != len(array):
                    raise Error(f"'{name}' has {len(array)} states, others have {states}")
                states = len(array)
            elif array.shape != shape:
                wanted = f"{shape}, or (states, …) before it"
                raise Error(f"'{name}' has the shape {array.shape} instead of {wanted}")
            given.append(array)
        return given, states


class View:
    """A page that notebooks show in a frame; ``page`` is its HTML.

        >>> pathlib.Path("arm.html").write_text(arm.view().page)
    """

    def __init__(self, page: str) -> None:
        self.page = page

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{html.escape(self.page)}" title="robovec view" '
            'sandbox="allow-scripts" style="width: 100%; height: 45em; border: 0"></iframe>'
        )
