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

    @property
    def _core(self) -> tuple[str, str, int, tuple[float, float], float, bool]:
        return self.kind, self.name, self.count, self.within, self.scale, self.logarithm


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
        hint = "; find a quantity by its name with `scene['…']`" if isinstance(quantity, str) else ""
        raise TypeError(f"a control, a design variable, a coordinate, a velocity or 'duration' can be free, not {quantity!r}{hint}")
    if len(given) > 1 or given and kind != "control":
        raise TypeError("only a control can be linear, in pieces or a spline, and only one of them")
    made = Free(given[0] if given else kind, name, forms[given[0]] if given else 0)
    return replace(made, within=pair(within, f"free {kind} `{name}`"), scale=float(scale), logarithm=bool(logarithm))


def step_length(step: int, *, within: tuple[float, float] = (-math.inf, math.inf), scale: float = 1.0) -> Free:
    """The length of a step, counted from 1, as a free quantity."""
    return Free("step", f"length of step {step}", int(step), pair(within, f"length of step {step}"), float(scale))


def interval(within: Any, of: str) -> tuple[float, float]:
    """The bounds of a constraint: a pair, in which None leaves a side open, a number for an equality, or None."""
    try:
        return (_number(within), _number(within)) if within is not None and np.ndim(within) == 0 else pair(within, of)
    except (TypeError, ValueError):
        raise InputError(f"{of}: a number, a pair (least, most) or None is expected, not {within!r}") from None


def pair(within: Any, of: str) -> tuple[float, float]:
    """The bounds of a free quantity: a pair, in which None leaves a side open, or None."""
    if within is None:
        return -math.inf, math.inf
    try:
        least, most = within
        return -math.inf if least is None else _number(least), math.inf if most is None else _number(most)
    except (TypeError, ValueError):
        hint = "; to keep the quantity at this value, set it in the inputs and do not list it as free" if np.ndim(within) == 0 else ""
        raise InputError(f"{of}: bounds are a pair (least, most), not {within!r}{hint}") from None


def mapping(given: Any, what: str, example: str) -> Mapping[Any, Any]:
    """What was given as a dictionary; nothing for None."""
    if given is not None and not isinstance(given, Mapping):
        raise TypeError(f"`{what}` must be a dictionary, such as {example}, not {given!r}")
    return given or {}


def _number(x: Any) -> float:
    """A number; text is none, although `float` reads it."""
    if isinstance(x, (str, bytes)):
        raise TypeError
    return float(x)


def stated(free: Iterable[Symbol | Free | str], bounds: Mapping[Symbol | str, Any] | None) -> list[Free]:
    """The free quantities with their bounds."""
    if isinstance(free, (Symbol, Free, str)):
        raise TypeError("`free` must be a list, such as [force]")
    quantities = [_free(of) for of in free]
    for key, within in mapping(bounds, "bounds", "{force: (-5, 5)}").items():
        wanted = _free(key)
        places = [i for i, of in enumerate(quantities) if of.name == wanted.name and _subject(of) == _subject(wanted)]
        if not places:
            name = f"`{wanted.name}`" if wanted.kind == wanted.name else f"{wanted.kind} `{wanted.name}`"
            raise InputError(f"`bounds` has a pair for {name}, which is not free: add it to the list of free quantities, or leave the pair out")
        quantities[places[0]] = replace(quantities[places[0]], within=pair(within, f"bounds of {wanted.kind} `{wanted.name}`"))
    return quantities


def _free(of: Any) -> Free:
    return of if isinstance(of, Free) else free(of)


def _subject(of: Free) -> str:
    return "control" if of.kind in ("linear", "pieces", "spline") else of.kind
