"""J and its gradient with estimates of the errors that the grid causes."""

from __future__ import annotations

from typing import Any, NamedTuple

from ._errors import warn
from ._solver import Solver, _checked
from ._system import Gradient, Inputs, System


class Derivative(NamedTuple):
    """A derivative of J by the variable with a name, and an estimated bound of its error."""

    of: str
    value: float
    uncertainty: float


class Estimate:
    """J and its gradient, with estimates of their differences from those of the continuous motion.

    `uncertainty` bounds the error of J, `gradient_uncertainty` the relative error of the gradient, and `derivatives` are those by design variables and
    initial values. `corrected` is the gradient with its estimated error added. `residual` is J of the continuous motion minus J by the residuals of the
    steps, and `largest` the interval of time with most of them and its share. What cannot be estimated is None, and `withdrawn` states why.
    """

    value: float
    gradient: Gradient
    uncertainty: float | None
    gradient_uncertainty: float | None
    derivatives: list[Derivative]
    corrected: Gradient | None
    residual: float | None
    largest: tuple[float, float, float] | None
    withdrawn: str | None
    text: str

    def __init__(self, system: System, attributes: dict[str, Any]) -> None:
        self.__dict__.update(attributes)
        self.gradient = Gradient(system, attributes["gradient"])
        self.derivatives = [Derivative(*of) for of in attributes["derivatives"]]
        if attributes["corrected"] is not None:
            self.corrected = Gradient(system, attributes["corrected"])

    def __repr__(self) -> str:
        return self.text


def estimate(system: System, inputs: Inputs, **settings: Any) -> Estimate:
    """J and its gradient with estimates of their errors, from the motions on every second and on every fourth node."""
    found = Estimate(system, Solver(system, **settings)._core.estimate(system, _checked(inputs, system)))
    warn(found.gradient.warnings)
    return found
