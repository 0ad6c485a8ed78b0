"""Values of quantities and formulas at all nodes of a motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from . import _hamiltonian_adjoint as _core
from ._errors import InputError
from ._expression import Expression, Symbol, write
from ._names import suggestion

if TYPE_CHECKING:
    from ._solver import Motion
    from ._system import Array

# The attributes of a motion that contain the rows of the lists of formulas.
_ROWS = {"q": "q", "v": "v", "v_dot": "a", "p_star": "p", "p_star_dot": "p_dot", "u": "controls", "sigma": "sigma", "lambda": "lam"}


class Row(NamedTuple):
    """The values of a quantity at all nodes, with its list and its number in this list."""

    list: str
    number: int
    values: Array


def row(motion: Motion, symbol: Symbol | str) -> Row:
    """The row of a coordinate, a velocity, an acceleration, a control, a multiplier or a reaction."""
    system = motion.system
    if isinstance(symbol, str):
        kinds = [kind for kind, names in (("q", system.coordinates), ("u", system.controls)) if symbol in names]
        if len(kinds) != 1:
            unknown = f"no coordinate or control has the name `{symbol}`{system._later(symbol, None) or suggestion(symbol, [*system.coordinates, *system.controls])}"
            raise KeyError(f"a coordinate and a control have the name `{symbol}`; use the handle" if kinds else unknown)
        symbol = Symbol(kinds[0], symbol)
    elif not isinstance(symbol, Symbol) or symbol.list not in _ROWS:
        shown = symbol.label if isinstance(symbol, Symbol) else symbol
        raise KeyError(f"a motion has no values of `{shown}`; it has those of coordinates, `x.v`, `x.a`, controls, `hinge[0].lam` and formulas of them")
    names = {"u": system.controls, "sigma": system.equations, "lambda": system.equations}.get(symbol.list, system.coordinates)
    number = system._number(symbol, names)
    return Row(symbol.list, number, getattr(motion, _ROWS[symbol.list])[number])


def values(motion: Motion, formula: Expression) -> Array:
    """The values of a formula at all nodes, computed by the same programs as those of a scene."""
    if isinstance(formula, Symbol):
        return _of_symbol(motion, formula)
    read: dict[Symbol, str] = {}
    text = write([formula], lambda symbol: read.setdefault(symbol, f"x[{len(read)}]"))
    arguments = np.array([_of_symbol(motion, symbol) for symbol in read]).reshape(len(read), motion.computed)
    found: Array = _core.values(text, arguments)
    wrong = np.flatnonzero(~np.isfinite(found))
    if wrong.size:
        raise InputError(f"the formula {formula!r} is {found[wrong[0]]} at node {wrong[0]} (t = {motion.times[wrong[0]]:g} s)")
    return found


def _of_symbol(motion: Motion, symbol: Symbol) -> Array:
    if symbol.list == "t":
        return motion.times
    if symbol.list == "b":
        return np.full(motion.computed, motion.inputs[symbol])
    return row(motion, symbol).values
