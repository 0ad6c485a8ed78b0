"""Readings: measured values that a motion is fitted to."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import ArrayLike

from . import _hamiltonian_adjoint as _core
from ._errors import InputError
from ._grid import Array
from ._handles import listed


class Table:
    """Measured values over time, from CSV; cells may be empty. The first column contains the times, s, and names may contain units, as in `x [m]`."""

    names: list[str]
    times: Array

    def __init__(self, csv: str) -> None:
        self.times, columns = _core.table(csv)
        self.names = [name for name, *_ in columns]
        self._columns = {name: (times, values) for name, times, values in columns}

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Table:
        """Reads a table from a file."""
        with open(path, encoding="utf-8-sig") as file:
            return cls(file.read())

    def __getitem__(self, name: str) -> tuple[Array, Array]:
        """The times and the values of a column without its empty cells; its name may be given without the unit."""
        found = [name] if name in self._columns else [of for of in self.names if of.split("[")[0].strip() == name]
        if len(found) != 1:
            raise KeyError(f"the table has {'more than one' if found else 'no'} column `{name}`; its columns are {listed(self.names)}")
        return self._columns[found[0]]

    def __repr__(self) -> str:
        return f"<table of {len(self.times)} rows: {listed(self.names)}>"


def checked_readings(name: str, times: ArrayLike, values: ArrayLike, deviation: ArrayLike) -> tuple[Array, Array, Array]:
    """Times, values and standard deviations of readings, as arrays of one length."""
    t, x = np.asarray(times, dtype=np.float64), np.asarray(values, dtype=np.float64)
    if t.ndim != 1 or t.shape != x.shape or not t.size:
        raise InputError(f"readings `{name}`: times and values are two lists of one length, but their shapes are {t.shape} and {x.shape}")
    try:
        s = np.broadcast_to(np.asarray(deviation, dtype=np.float64), t.shape)
    except ValueError:
        raise InputError(f"readings `{name}`: the deviation has the shape {np.shape(deviation)}; it must be a number, or one for each of {t.size} readings") from None
    unknown = np.flatnonzero(~np.isfinite(t) | ~np.isfinite(x))
    if unknown.size:
        i = unknown[0]
        raise InputError(
            f"readings `{name}`: reading {i} is {x[i]} at t = {t[i]} s ({unknown.size} of {t.size} are not finite); leave such readings out: "
            "`keep = np.isfinite(values)`, then `times[keep], values[keep]`"
        )
    wrong = np.flatnonzero(~((s > 0) & np.isfinite(s)))
    if wrong.size:
        raise InputError(f"readings `{name}`: the deviation of reading {wrong[0]} is {s[wrong[0]]}; a standard deviation must be positive and finite")
    return t, x, s
