"""Motions as tables with names, for pandas and xarray."""

from __future__ import annotations

import csv
import io
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ._solver import Motion


def csv_header(motion: Motion) -> list[str]:
    """The names of the columns of the CSV, with units."""
    return next(csv.reader(io.StringIO(motion._core.csv_header(), newline="")))


def to_pandas(motion: Motion) -> Any:
    """A table with a row for each node and the columns of the CSV."""
    import pandas

    time, *names = csv_header(motion)
    columns = np.vstack([motion.q, motion.v, motion.p, motion.sigma, motion.controls])
    return pandas.DataFrame(columns.T, index=pandas.Index(motion.times, name=time), columns=names)


def to_xarray(motion: Motion) -> Any:
    """A data set with an array for each quantity."""
    import xarray

    of_coordinates = {"q": motion.q, "v": motion.v, "p": motion.p, "p_dot": motion.p_dot}
    arrays: dict[str, Any] = {name: (("coordinate", "time"), values) for name, values in of_coordinates.items()}
    arrays |= {"sigma": (("equation", "time"), motion.sigma), "u": (("control", "time"), motion.controls)}
    system = motion.system
    labels = {"coordinate": system.coordinates, "equation": system.equations, "control": system.controls, "time": motion.times}
    return xarray.Dataset(arrays, coords=labels)
