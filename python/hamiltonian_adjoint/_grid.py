"""Grids: the lengths of steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _hamiltonian_adjoint as _core
from ._errors import InputError

Array = NDArray[np.float64]


def lengths_of_steps(steps: int | ArrayLike, dt: float | None) -> Array:
    """The lengths of steps, s, that are given as a number of steps and their length, or one by one."""
    is_count = isinstance(steps, (int, np.integer)) and not isinstance(steps, bool)
    if is_count != (dt is not None):
        raise TypeError("the grid is a number of steps and their length, `at_rest(100, 0.01)`, or an array of lengths")
    if is_count and int(steps) < 0:  # type: ignore[arg-type]
        raise InputError(f"{steps!r} steps: the number of steps must not be negative")
    if dt is not None and not (np.isfinite(dt) and dt):
        raise InputError(f"the length of the steps is {dt} s; it must be finite, and negative only for a motion backward in time")
    return np.full(int(steps), float(dt)) if is_count else np.array(steps, dtype=np.float64)  # type: ignore[arg-type]


def graded_steps(steps: int, duration: float) -> Array:
    """The lengths, s, of steps over a duration that are short at both ends: t_i = T x³ (10 − 15 x + 6 x²) with x = i/N.

    Use them for the steps within a contact whose force is not smooth where it begins and ends; schemes then keep their order.

    >>> graded_steps(4, 1.0).round(3)
    array([0.104, 0.396, 0.396, 0.104])
    """
    if steps < 1:
        raise InputError(f"{steps!r} steps: the number of steps must be positive")
    x = np.arange(steps + 1) / steps
    return np.diff(duration * x * x * x * (10.0 - 15.0 * x + 6.0 * x * x))


def steps_through(times: ArrayLike, longest: float) -> Array:
    """The lengths of steps, s, with nodes at the given times and equal steps between them, none longer than `longest`; the first node is at `times[0]`.

    >>> steps_through([0.0, 0.2, 0.25], 0.1)
    array([0.1 , 0.1 , 0.05])
    """
    at = np.ravel(np.asarray(times, dtype=np.float64))
    if (back := np.flatnonzero(np.diff(at) < 0)).size:
        i = back[0] + 1
        raise InputError(f"time {i} of `steps_through`, {at[i]:g} s, is before time {i - 1}, {at[i - 1]:g} s; sort the times, as by numpy.unique")
    return _core.steps_through(at.tolist(), float(longest))
