"""Results of optimisation."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from ._system import Array, Inputs, System


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
    # The inputs of each motion of `Trials`, the first of which are `inputs`.
    trials: list[Inputs]
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

    def __init__(self, systems: list[System], attributes: dict[str, Any]) -> None:
        self.__dict__.update(attributes)
        self.trials = [Inputs._of(system, inputs) for system, inputs in zip(systems, attributes["inputs"])]
        self.inputs = self.trials[0]
        self.history = [Iterate(*of) for of in attributes["history"]]

    def plot(self, ax: Any = None) -> Any:
        """Draws value, violation and stationarity of all iterates by matplotlib. Returns an array of two axes."""
        from ._plots import plot_history

        return plot_history(self.history, ax)

    def __repr__(self) -> str:
        return f"<optimum: {self.message}>"


def lowest(found: Iterable[Optimum], violation: float = 1e-9) -> Optimum | None:
    """The optimum with the lowest value among those whose violation is at most `violation`; the first of equal ones."""
    good = [of for of in found if np.isfinite(of.value) and of.violation <= violation]
    return min(good, key=lambda of: of.value, default=None)
