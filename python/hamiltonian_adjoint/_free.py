"""Quantities that an optimiser may change."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ._errors import InputError
from ._expression import Symbol

_KINDS = {"u": "control", "b": "design", "q": "coordinate", "v": "rate"}


@dataclass(frozen=True)
class Free:
    """A quantity that an optimiser may change."""

    kind: str
    name: str
    count: int = 0
    within: tuple[float, float] = (-math.inf, math.inf)
    scale: float = 1.0
    logarithm: bool = False


def free(
    quantity: Symbol | str,
    *,
    linear: int = 0,
    pieces: int = 0,
    spline: int = 0,
    within: tuple[float, float] = (-math.inf, math.inf),
    scale: float = 1.0,
    logarithm: bool = False,
) -> Free:
    """A control, a design variable, an initial coordinate or an initial velocity `x.v` that an optimiser may change, or 'duration'.

    A control is free at all nodes, or at a number of knots between which it is `linear`, in a number of `pieces`, or as a `spline` with a number of
    coefficients. `scale` is the value of the quantity when the variable is 1; with `logarithm` the variable is the logarithm of the quantity.
    """
    forms = {"linear": linear, "pieces": pieces, "spline": spline}
    given = [form for form, count in forms.items() if count]
    if quantity == "duration" if isinstance(quantity, str) else False:
        kind, name = "duration", "duration"
    elif isinstance(quantity, Symbol) and quantity.list in _KINDS:
        kind, name = _KINDS[quantity.list], quantity.name
    else:
        raise TypeError(f"a control, a design variable, a coordinate, a velocity or 'duration' can be free, not {quantity!r}")
    if len(given) > 1 or given and kind != "control":
        raise TypeError("only a control can be linear, in pieces or a spline, and only one of them")
    made = Free(given[0] if given else kind, name, forms[given[0]] if given else 0)
    return replace(made, within=interval(within), scale=float(scale), logarithm=bool(logarithm))


def step_length(step: int, *, within: tuple[float, float] = (-math.inf, math.inf), scale: float = 1.0) -> Free:
    """The length of a step, counted from 1, as a free quantity."""
    return Free("step", f"length of step {step}", int(step), interval(within), float(scale))


def interval(within: Any) -> tuple[float, float]:
    """Bounds; a single number is an equality, and None leaves a side open."""
    if within is None:
        return -math.inf, math.inf
    if np.ndim(within) == 0:
        return float(within), float(within)
    try:
        least, most = within
    except (TypeError, ValueError):
        raise InputError(f"bounds are a pair (least, most), not {within!r}") from None
    return -math.inf if least is None else float(least), math.inf if most is None else float(most)


def stated(free: Iterable[Symbol | Free | str], bounds: Mapping[Symbol | str, Any] | None) -> list[Free]:
    """The free quantities with their bounds."""
    if isinstance(free, (Symbol, Free, str)):
        raise TypeError("`free` must be a list, such as [force]")
    quantities = [_free(of) for of in free]
    for key, within in (bounds or {}).items():
        wanted = _free(key)
        places = [i for i, of in enumerate(quantities) if of.name == wanted.name and _subject(of) == _subject(wanted)]
        if not places:
            raise InputError(f"`bounds` has {wanted.kind} `{wanted.name}`, which is not free")
        quantities[places[0]] = replace(quantities[places[0]], within=interval(within))
    return quantities


def _free(of: Any) -> Free:
    return of if isinstance(of, Free) else free(of)


def _subject(of: Free) -> str:
    return "control" if of.kind in ("linear", "pieces", "spline") else of.kind
