"""Sums of costs and outputs over the nodes of a motion."""

from __future__ import annotations

from typing import Any

from ._errors import SceneError
from ._words import whole

_SUMS = ("plain", "all nodes", "rectangle", "trapezoidal", "integral", "terminal")


def node(i: int) -> dict[str, int]:
    """The sum of a cost that counts at a single node."""
    return {"node": whole("a node", i)}


def at_event(i: int) -> dict[str, int]:
    """The sum of a cost that counts at an event of the inputs, counted from 0."""
    return {"event": whole("the number of an event", i)}


def after_event(i: int) -> dict[str, int]:
    """The sum of a cost that counts just after an event of the inputs, counted from 0."""
    return {"after event": whole("the number of an event", i)}


def checked_sum(sum: Any) -> Any:
    """The sum of a cost, if there is such a sum."""
    if isinstance(sum, str) and sum not in _SUMS:
        raise SceneError(f"'{sum}' is not one of the sums {', '.join(_SUMS)}, node(i), at_event(i), after_event(i)")
    return sum
