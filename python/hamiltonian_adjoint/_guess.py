"""Guesses of the states of a motion."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ._errors import InputError
from ._expression import Symbol
from ._optimum import Optimum
from ._solver import Motion
from ._system import Array, Inputs, _index

Guess = Literal["straight", "inputs"] | Motion | Optimum | Iterable[ArrayLike]

_NAMES = ("straight", "inputs")
_KNOWN = "a guess is 'straight', 'inputs', a motion, an optimum, or a pair (q, v) of arrays with a row for each coordinate and a column for each node"


def checked_guess(inputs: Inputs, guess: Guess | Any) -> str | tuple[Array, Array]:
    """A guess for `solve`: its name, coordinates and velocities at all nodes, or variables and multipliers of an optimum."""
    if isinstance(guess, str):
        if guess not in _NAMES:
            raise InputError(f"there is no guess '{guess}'; {_KNOWN}")
        return guess
    if isinstance(guess, Optimum):
        return guess.x, guess.multipliers
    if isinstance(guess, Motion):
        if guess.system is not inputs.system and guess.system.parts != inputs.system.parts:
            raise InputError("the guess is a motion of another system")
        guess = guess.q, guess.v
    try:
        q, v = guess
    except (TypeError, ValueError):
        raise TypeError(f"{_KNOWN}, not {type(guess).__name__}") from None
    shape = inputs.system.n, len(inputs.steps) + 1
    return _matrix("q", q, shape), _matrix("v", v, shape)


def _matrix(name: str, values: ArrayLike, shape: tuple[int, int]) -> Array:
    matrix = np.asarray(values, dtype=np.float64)
    if matrix.shape != shape:
        raise InputError(f"`{name}` of the guess has the shape {matrix.shape}; {shape} is expected, a row for each coordinate and a column for each node")
    return matrix


def of_segments(inputs: Inputs, of: Symbol | str, values: ArrayLike) -> tuple[bool, int, list[float]]:
    """A guess for a MultipleShooting: whether it is a velocity, the number of its coordinate, and its values at all nodes."""
    which, i = _index(inputs.system, of)
    if which not in ("q", "v"):
        raise TypeError(f"a guess has coordinates and velocities such as `x.v`, not {of!r}")
    nodes = len(inputs.steps) + 1
    values = np.asarray(values, dtype=np.float64)
    if values.shape not in ((), (nodes,)):
        raise InputError(f"the guess of {of!r} has the shape {values.shape}; a number or {nodes} values, one for each node, are expected")
    return which == "v", i, np.broadcast_to(values, nodes).tolist()
