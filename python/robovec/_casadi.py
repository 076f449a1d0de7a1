"""Functions for CasADi: compiled C with exact derivatives, and CasADi's own
functions made faster."""

from __future__ import annotations

import atexit
import os
import pathlib
import re
import shutil
import tempfile
from typing import TYPE_CHECKING, Any, Callable, Sequence

import numpy as np

from ._compiled import library_of
from ._robovec import Error

if TYPE_CHECKING:
    import casadi as ca

    from . import Program

FLAGS = ("-O3", "-march=native")

PASSES = "atomise,fold,optimise{for=operations}"
# Models come short, and with Jacobians they are long: a second of search.
QUICK_PASSES = "atomise,fold,optimise{for=operations budget=300000}"


def external(
    program: Program,
    derivatives: str,
    compiler: str,
    flags: Sequence[str],
    folder: str | os.PathLike[str] | None,
) -> ca.Function:
    """Compiles a program with its derivatives, and loads it as a CasADi function."""
    import casadi as ca

    if derivatives not in ("none", "first", "second"):
        raise Error(f"derivatives is 'none', 'first' or 'second', not {derivatives!r}")
    step = f"codegen{{target=casadi derivatives={derivatives} superwords=auto}}"
    files = program._inner.files(step, "thesis")
    place = pathlib.Path(tempfile.mkdtemp(prefix="robovec-") if folder is None else folder)
    if folder is None:
        # Code that CasADi generates may load the library again until the end.
        atexit.register(shutil.rmtree, place, ignore_errors=True)
    library = library_of(files, place, program.name, compiler, flags)
    made = ca.external(program.name, str(library))
    if derivatives == "none":
        return made
    # A Jacobian costs some three directions: CasADi takes it for more of them.
    penalty = 3 / max(1, min(made.nnz_in(), made.nnz_out()))
    return ca.external(program.name, str(library), {"jac_penalty": penalty})


def text_of(function: ca.Function, name: str) -> str:
    """The equations of a CasADi function as robovec's text."""
    import casadi as ca

    if function.class_name() != "SXFunction":
        try:
            function = function.expand()
        except Exception as error:
            raise Error(f"{name} cannot be expanded into scalar operations: {error}") from error
    names = _names(function)
    inputs = names[: function.n_in()]
    outputs = names[function.n_in() :]
    lines = ["// robovec 1", "", f"function {name} equations {{"]
    for kind, own, size in (("in", inputs, function.size_in), ("out", outputs, function.size_out)):
        lines += [f"  {kind} {array}[{_extents(size(i))}]" for i, array in enumerate(own)]
    given = [_elements(function.sparsity_in(i), array) for i, array in enumerate(inputs)]
    made = [_elements(function.sparsity_out(i), array) for i, array in enumerate(outputs)]
    work: list[str] = [""] * function.sz_w()
    constants: dict[int, float] = {}
    results = []
    steps = _steps(ca)
    for k in range(function.n_instructions()):
        step = function.instruction_id(k)
        to, read = function.instruction_output(k), function.instruction_input(k)
        if step == ca.OP_OUTPUT:
            results.append(f"  {made[to[0]][to[1]]} = {work[read[0]]}")
            continue
        if step == ca.OP_INPUT:
            work[to[0]] = given[read[0]][read[1]]
            constants.pop(to[0], None)
            continue
        if step == ca.OP_CONST:
            number = function.instruction_constant(k)
            if not np.isfinite(number):
                raise Error(f"{name} contains the constant {number}")
            work[to[0]] = repr(number) if number >= 0 else f"({number!r})"
            constants[to[0]] = number
            continue
        operands = [work[place] for place in read]
        if step in (ca.OP_POW, ca.OP_CONSTPOW):
            expression = _power(operands[0], constants.get(read[1]))
        else:
            expression = steps[step](*operands) if step in steps else None
        if expression is None:
            raise Error(
                f"{name} uses {_step_name(ca, step)}; robovec has + - * /, sin, cos, tan, sqrt "
                "and constant powers"
            )
        lines.append(f"  %v{k} = {expression}")
        work[to[0]] = f"%v{k}"
        constants.pop(to[0], None)
    # An output without nonzeros has one all the same in the text.
    for sparsity, array in zip((function.sparsity_out(i) for i in range(len(outputs))), outputs):
        if sparsity.nnz() == 0:
            first = "1" if sparsity.size2() == 1 else "1,1"
            results.append(f"  {array}[{first}] = 0.0")
    return "\n".join([*lines, *results, "}", ""])


def _steps(ca: Any) -> dict[int, Callable[..., str]]:
    """The expression of every operation of CasADi that robovec has."""
    return {
        ca.OP_ASSIGN: lambda x: x,
        ca.OP_ADD: lambda x, y: f"{x} + {y}",
        ca.OP_SUB: lambda x, y: f"{x} - {y}",
        ca.OP_MUL: lambda x, y: f"{x}*{y}",
        ca.OP_DIV: lambda x, y: f"{x}/{y}",
        ca.OP_NEG: lambda x: f"-{x}",
        ca.OP_SQ: lambda x: f"{x}*{x}",
        ca.OP_TWICE: lambda x: f"2.0*{x}",
        ca.OP_INV: lambda x: f"1.0/{x}",
        ca.OP_SIN: lambda x: f"sin({x})",
        ca.OP_COS: lambda x: f"cos({x})",
        ca.OP_TAN: lambda x: f"sin({x})/cos({x})",
        ca.OP_SQRT: lambda x: f"sqrt({x})",
        ca.OP_HYPOT: lambda x, y: f"sqrt({x}*{x} + {y}*{y})",
    }


def _power(base: str, exponent: float | None) -> str | None:
    """A power by a small whole or half number, as products and a root."""
    if exponent is None or 2 * exponent != int(2 * exponent) or abs(exponent) > 64:
        return None
    whole, half = divmod(int(2 * abs(exponent)), 2)
    factors = [base] * whole + [f"sqrt({base})"] * half
    product = "*".join(factors) if factors else "1.0"
    return product if exponent >= 0 else f"1.0/({product})"


def _step_name(ca: Any, step: int) -> str:
    names = (name for name in dir(ca) if name.startswith("OP_") and getattr(ca, name) == step)
    return next(names, f"operation {step}")


def _names(function: ca.Function) -> list[str]:
    """Names of all inputs and outputs, each once, that robovec's text takes."""
    wanted = [function.name_in(i) for i in range(function.n_in())]
    wanted += [function.name_out(i) for i in range(function.n_out())]
    taken: list[str] = []
    for name in wanted:
        word = re.sub(r"\W", "_", name)
        word = word if word[:1].isalpha() else f"v{word}"
        number = 1
        while (free := word if number == 1 else f"{word}_{number}") in taken:
            number += 1
        taken.append(free)
    return taken


def _extents(size: tuple[int, int]) -> str:
    rows, columns = size
    return f"1..{rows}" if columns == 1 else f"1..{rows},1..{columns}"


def _elements(sparsity: ca.Sparsity, array: str) -> list[str]:
    """The elements of an array in the order of CasADi's nonzeros."""
    rows, columns = sparsity.get_triplet()
    if sparsity.size2() == 1:
        return [f"{array}[{row + 1}]" for row in rows]
    return [f"{array}[{row + 1},{column + 1}]" for row, column in zip(rows, columns)]


def compare(function: ca.Function, made: ca.Function, points: int) -> None:
    """Raises an error where a compiled function differs from the original at
    random points, by more than 1e-9 of its largest element."""
    draw = np.random.default_rng(1)
    for _ in range(points):
        given = [draw.uniform(-1, 1, function.size_in(i)) for i in range(function.n_in())]
        for name, wanted, found in zip(function.name_out(), function.call(given), made.call(given)):
            wanted, found = np.array(wanted, float), np.array(found, float)
            scale = np.abs(wanted[np.isfinite(wanted)]).max(initial=1.0)
            differs = np.isfinite(wanted) & ~(np.abs(found - wanted) <= 1e-9 * scale)
            if differs.any():
                raise Error(f"the compiled '{name}' of {function.name()} differs from CasADi's")
