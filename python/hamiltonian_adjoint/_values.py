"""Values of quantities and formulas at all nodes of a motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from . import _hamiltonian_adjoint as _core
from ._errors import InputError
from ._expression import Expression, Symbol, write

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
            raise KeyError(f"{'a coordinate and a control have' if kinds else 'no coordinate or control has'} the name `{symbol}`; use the handle")
        kind, key = kinds[0], symbol
    elif isinstance(symbol, Symbol) and symbol.list in _ROWS:
        kind, key = symbol.list, symbol.key
    else:
        shown = symbol.label if isinstance(symbol, Symbol) else symbol
        raise KeyError(f"a motion has no values of `{shown}`; it has those of coordinates, `x.v`, `x.a`, controls, `hinge[0].lam` and formulas of them")
    names = {"u": system.controls, "sigma": system.equations, "lambda": system.equations}.get(kind, system.coordinates)
    if key not in names:
        raise KeyError(f"the system has no `{symbol.label if isinstance(symbol, Symbol) else symbol}`")
    number = names.index(key)
    return Row(kind, number, getattr(motion, _ROWS[kind])[number])


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
