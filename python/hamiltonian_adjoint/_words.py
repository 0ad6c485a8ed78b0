"""Words of messages."""

from __future__ import annotations

import operator
from typing import Any


def counted(number: int, noun: str) -> str:
    """A number with its noun: "1 step", "2 steps"."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def whole(what: str, number: Any) -> int:
    """A whole number; raises a TypeError for anything else."""
    try:
        return operator.index(number)
    except TypeError:
        raise TypeError(f"{what} must be a whole number, not {number!r}") from None
