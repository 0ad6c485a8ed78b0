"""Optimisation of motions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from . import _hamiltonian_adjoint as _core
from ._errors import InputError, warn
from ._expression import Symbol
from ._handles import Output
from ._solver import _checked
from ._system import Array, Inputs, System

METHODS = ("interior point", "L-BFGS", "augmented Lagrangian", "Levenberg-Marquardt")
_OPTIONS = ("iterations", "target", "stationarity", "violation", "memory", "first_step")
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
    return replace(made, within=_interval(within), scale=float(scale), logarithm=bool(logarithm))


def step_length(step: int, *, within: tuple[float, float] = (-math.inf, math.inf), scale: float = 1.0) -> Free:
    """The length of a step, counted from 1, as a free quantity."""
    return Free("step", f"length of step {step}", int(step), _interval(within), float(scale))


def _interval(within: Any) -> tuple[float, float]:
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


class Iterate(NamedTuple):
    """An iterate of a method."""

    value: float
    violation: float
    stationarity: float
    step: float
    evaluations: int


class Optimum:
    """The result of `minimise`, converged or not: the best point `x`, its `inputs`, and how it was found."""

    x: Array
    names: list[str]
    value: float
    inputs: Inputs
    constraints: Array
    violation: float
    multipliers: Array
    reason: str
    converged: bool
    message: str
    iterations: int
    evaluations: int
    gradients: int
    products: int
    history: list[Iterate]
    warnings: list[tuple[str, str]]
    first_failure: str | None
    # Of 'Levenberg-Marquardt' only.
    standard_errors: Array | None
    covariance: Array | None
    chi_squared: float | None
    degrees_of_freedom: int | None
    grid_shifts: Array | None
    undetermined: list[str] | None

    def __init__(self, system: System, attributes: dict[str, Any]) -> None:
        self.__dict__.update(attributes)
        self.inputs = Inputs._of(system, attributes["inputs"])
        self.history = [Iterate(*of) for of in attributes["history"]]

    def __repr__(self) -> str:
        return f"<optimum: {self.message}>"


def minimise(
    system: System,
    inputs: Inputs,
    free: Iterable[Symbol | Free | str],
    *,
    bounds: Mapping[Symbol | str, Any] | None = None,
    constraints: Mapping[Output | str, Any] | None = None,
    method: str = "interior point",
    callback: Callable[[Iterate, np.ndarray], bool | None] | None = None,
    **keywords: Any,
) -> Optimum:
    """Minimises J over the free quantities, subject to bounds and to constraints on outputs.

    `bounds` are pairs (least, most) for quantities in `free`. Outputs must be zero; `constraints` sets another value or a pair, or None to leave an output
    free. Methods are 'interior point' (exact products of the Hessian), 'L-BFGS' and 'augmented Lagrangian' (gradients alone), and 'Levenberg-Marquardt'
    (minimises the sum of squares of the outputs). `callback(iterate, x)` may return True to stop. Other keywords are the options `iterations`, `target`,
    `stationarity`, `violation`, `memory`, `first_step`, and settings of a Solver.
    """
    if method not in METHODS:
        raise InputError(f"there is no method '{method}'; the methods are {', '.join(repr(of) for of in METHODS)}")
    if isinstance(free, (Symbol, Free, str)):
        raise TypeError("`free` must be a list, such as [force]")
    quantities = [of if isinstance(of, Free) else _free(of) for of in free]
    for key, within in (bounds or {}).items():
        wanted = _free(key)
        places = [i for i, of in enumerate(quantities) if of.name == wanted.name and _subject(of) == _subject(wanted)]
        if not places:
            raise InputError(f"`bounds` has {wanted.kind} `{wanted.name}`, which is not free")
        quantities[places[0]] = replace(quantities[places[0]], within=_interval(within))
    asked = [(of if isinstance(of, str) else of.name, *_interval(to)) for of, to in (constraints or {}).items()]
    options = {name: keywords.pop(name) for name in _OPTIONS if name in keywords}
    given = [(of.kind, of.name, of.count, of.within, of.scale, of.logarithm) for of in quantities]

    def called(iterate: Any, x: np.ndarray) -> bool | None:
        return callback(Iterate(*iterate), x)  # type: ignore[misc]

    found = _core.minimise(system, _checked(inputs, system), given, asked, method, options, keywords, called if callback else None)
    warn(found["warnings"])
    return Optimum(system, found)


def _free(of: Any) -> Free:
    return of if isinstance(of, Free) else free(of)


def _subject(of: Free) -> str:
    return "control" if of.kind in ("linear", "pieces", "spline") else of.kind
