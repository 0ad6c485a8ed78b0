"""Figures of motions and of optimisations."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ._errors import InputError
from ._expression import Expression, Symbol
from ._handles import Equation
from ._tables import csv_header
from ._values import row

if TYPE_CHECKING:
    from ._optimum import Iterate
    from ._solver import Motion
    from ._system import Array, System

# A legend with more lines hides more than it explains.
_MOST_IN_LEGEND = 16
# A column of a legend with more lines is higher than the axes beside it.
_MOST_IN_COLUMN = 8
# Colours of matplotlib are repeated after ten lines.
_STYLES = ("-", "--", ":")
_COLOURS = 10
_KINDS = {
    "q": "coordinates",
    "v": "velocities",
    "v_dot": "accelerations",
    "p_star": "augmented momenta",
    "p_star_dot": "rates of momenta",
    "u": "controls",
    "sigma": "multipliers",
    "lambda": "reactions",
    "formula": "formulas",
}
# Of the names of columns, which may contain brackets, too.
_UNIT = re.compile(r" \[(m|rad|m/s|rad/s|N|N m|N s|N m s)\]$")
_RATES = {"N s": "N", "N m s": "N m", "m/s": "m/s²", "rad/s": "rad/s²"}


class Line(NamedTuple):
    """A quantity over time; quantities of one kind and unit share axes."""

    kind: str
    unit: str
    name: str
    values: Array


def plot_motion(motion: Motion, symbols: Sequence[Any], ax: Any, style: dict[str, Any]) -> Any:
    """Draws quantities over time, those of each kind and unit in axes of their own. Returns the axes, or an array if there are several."""
    panels: dict[tuple[str, str], list[Line]] = {}
    units = _units(motion)
    for line in _lines(motion, symbols or _default(motion.system), units):
        panels.setdefault((line.kind, line.unit), []).append(line)
    axes = _axes(ax, len(panels))
    are_shared = len(axes) < len(panels)
    for place, lines in zip(np.repeat(axes, len(panels)) if are_shared else axes, panels.values()):
        for line in lines:
            name = f"{line.name} [{line.unit}]" if are_shared and line.unit else line.name
            place.plot(motion.times, line.values, **{"label": _text(name), **_dashes(place, style), **style})
        place.set_ylabel("" if are_shared else _what(lines))
        _explain(place)
    axes[-1].set_xlabel("time [s]")
    if ax is None:
        axes[0].figure.align_ylabels(axes)
    return ax if ax is not None else axes[0] if len(axes) == 1 else axes


def plot_history(history: Sequence[Iterate], ax: Any) -> Any:
    """Draws value, violation and stationarity of the iterates. Returns an array of two axes."""
    value = np.array([at.value for at in history])
    if ax is None:
        import matplotlib.pyplot as plt

        ax = plt.subplots(2, sharex=True, figsize=(8.0, 4.0), layout="constrained")[1]
    elif np.size(ax) != 2:
        raise InputError(f"{np.size(ax)} axes were given; the history of an optimisation needs two")
    above, below = np.ravel(ax)
    above.plot(value, ".-")
    above.set_ylabel("value")
    if value.min() > 0.0 and value.max() > 100.0 * value.min():
        above.set_yscale("log")
    for name in ("violation", "stationarity"):
        of = np.array([getattr(at, name) for at in history])
        # A logarithm has no place for zero.
        if np.any(of > 0.0):
            below.plot(np.where(of > 0.0, of, np.nan), ".-", label=name)
    below.set_yscale("log")
    below.set_xlabel("iteration")
    below.xaxis.get_major_locator().set_params(integer=True)
    if below.lines:
        below.legend()
    return ax


def _default(system: System) -> list[Symbol]:
    """Coordinates, velocities and controls."""
    names = {"q": system.coordinates, "v": system.coordinates, "u": system.controls}
    return [Symbol(kind, name) for kind, all in names.items() for name in all]


def _lines(motion: Motion, symbols: Iterable[Any], units: dict[str, list[str]]) -> Iterator[Line]:
    for symbol in symbols:
        if isinstance(symbol, Equation):
            symbol = symbol.sigma
        if isinstance(symbol, (Symbol, str)):
            kind, i, values = row(motion, symbol)
            yield Line(kind, units[kind][i], symbol if isinstance(symbol, str) else symbol.label, values)
        elif isinstance(symbol, Expression):
            yield Line("formula", "", repr(symbol), motion[symbol])
        elif isinstance(symbol, Iterable):
            yield from _lines(motion, symbol, units)
        else:
            raise TypeError(f"a motion is drawn by coordinates, velocities, controls, multipliers, their names or formulas, not by {symbol!r}")


def _units(motion: Motion) -> dict[str, list[str]]:
    """Units of all quantities by their kind; a unit is empty if it is not known."""
    n, m = motion.system.n, motion.system.m
    found = [_UNIT.search(name) for name in csv_header(motion)[1:]]
    units = iter([of[1] if of else "" for of in found])
    counts = {"q": n, "v": n, "p_star": n, "sigma": m, "u": motion.system.k}
    of_kind = {kind: [next(units) for _ in range(count)] for kind, count in counts.items()}
    rates = {"v": "v_dot", "p_star": "p_star_dot", "sigma": "lambda"}
    return {**of_kind, **{rate: [_RATES.get(unit, "") for unit in of_kind[kind]] for kind, rate in rates.items()}}


def _axes(ax: Any, count: int) -> Any:
    """An array of axes: those that are given, or those of a new figure."""
    if ax is None:
        import matplotlib.pyplot as plt

        height = 1.0 + 1.7 * max(count, 1)
        return np.ravel(plt.subplots(max(count, 1), sharex=True, figsize=(8.0, height), layout="constrained")[1])
    axes = np.ravel(ax)
    if len(axes) not in (1, count):
        raise InputError(f"{len(axes)} axes were given, but these quantities need {count}, one for each kind and unit, or one for all of them")
    return axes


def _text(name: str) -> str:
    """A name as matplotlib shows it: `$` begins formulas, and legends leave out labels that begin with `_`."""
    return (" " if name.startswith("_") else "") + name.replace("$", r"\$")


def _dashes(place: Any, style: dict[str, Any]) -> dict[str, str]:
    """Dashes of a line whose colour other lines have already."""
    repeats = len(place.lines) // _COLOURS
    return {"linestyle": _STYLES[repeats % len(_STYLES)]} if repeats and not {"linestyle", "ls"} & set(style) else {}


def _what(lines: list[Line]) -> str:
    """What lines of one kind and unit are."""
    kind, unit, name, _ = lines[0]
    what = _text(name) if len(lines) == 1 else _KINDS[kind]
    return f"{what} [{unit}]" if unit else what


def _explain(place: Any) -> None:
    """Names the lines if there are several, beside the axes if the figure makes room for it."""
    count = len(place.lines)
    if 1 < count <= _MOST_IN_LEGEND:
        beside = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5), "frameon": False, "ncols": -(-count // _MOST_IN_COLUMN)}
        place.legend(fontsize="small", **(beside if place.figure.get_layout_engine() else {}))
