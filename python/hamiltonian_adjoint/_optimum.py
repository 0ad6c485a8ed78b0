"""Results of optimisation."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from ._system import Array, Inputs, System
from ._words import counted


# The largest number of outputs and of parameters that an optimum lists.
_OUTPUTS = 5
_PARAMETERS = 10
# The largest number of attempts that an optimum lists.
_ATTEMPTS = 10
# Outputs are off if they violate their limits by more.
_OFF = 1e-9
_LIMIT = "the iteration limit was reached"
# By the reason why the method stopped.
_WHAT_TO_DO = {
    _LIMIT: "allow more `iterations`",
    "a constraint has no multiplier, because its gradient vanishes or depends on those of others": "state the limits in another form, for example φ = π/2 instead of (φ − π/2)² = 0",
    "stopped by a callback": "continue from x: `minimise(start=found.x)` of a `Problem`",
}
_AFTER_SOLVE = "try several `starts`, another `guess`, {more}a longer duration, or wider bounds"
_UNSTABLE = "segments met, but rounding errors grow along their motion until no controls make one motion of it: a shorter motion may be computed as one"


class Iterate(NamedTuple):
    """An iterate of a method: J (or half the sum of squares), the largest violation of a constraint, the largest component of the gradient, the largest
    change of a variable, and the number of simulations so far.
    """

    value: float
    violation: float
    stationarity: float
    step: float
    evaluations: int


class Attempt(NamedTuple):
    """What `solve` tried: a number of segments or one motion, the reason why it stopped, J and the largest violation of a constraint at its end, the number
    of iterations, and whether segments met whose controls violate the constraints as a single motion, because that is unstable.
    """

    what: str
    reason: str
    value: float
    violation: float
    iterations: int
    unstable: bool


class OptimumDerivative(NamedTuple):
    """The derivatives of an optimum by one quantity of its problem: dx/dp of the variables, and dJ/dp."""

    x: Array
    value: float


class Optimum:
    """The result of `solve` and `minimise`, converged or not: the best point and how it was found.

    - `converged`: True if the gradient is small or the target was reached, and the constraints hold;
    - `reason`: why the method stopped; `message`: the reason, counts, and numbers;
    - `inputs`: the best inputs; `trials`: those of each motion of `Trials`, the first of which are `inputs`;
    - `scheme`: the scheme of the motion of `inputs`; `solve` with an accuracy may have changed it;
    - `x`, `names`: values and names of the variables;
    - `value`: J, for Levenberg-Marquardt half the sum of squares of the outputs;
    - `constraints`: the values of the outputs at x, not their violations; `limits`: name, lower and upper bound of each;
    - `violation`: the largest violation of a constraint; `multipliers`: w of the Lagrangian J + wᵀ constraints;
    - `iterations`, `evaluations`, `gradients`, `products`: the numbers of iterations, simulations, gradients and products of the Hessian;
    - `history`: the start and all iterates; `first_failure`: the error of the first point that could not be computed;
    - `warnings`: kinds and messages of warnings about the motion of `inputs`;
    - `attempts`: what `solve` or `identify` tried, in this order; empty for other methods.

    Only 'Levenberg-Marquardt' and `identify` have other values than None in

    - `chi_squared`, `degrees_of_freedom`: the sum of squares of the residuals, and their number minus that of the variables;
    - `standard_errors`, `covariance` of the variables: the residuals themselves determine the scatter of the readings, χ²/degrees of freedom;
    - `absolute_errors`: standard errors for deviations of the readings that are known, √diag((AᵀA)⁻¹ + δ δᵀ) with the `jacobian` A and the
      `grid_shifts` δ; `standard_errors` have s² (AᵀA)⁻¹ instead, with s² = χ²/degrees of freedom;
    - `grid_shifts`: estimated changes of the variables if steps became infinitely short, included in both kinds of errors;
    - `undetermined`: the variables that the readings do not determine, because they have no effect, or only a combination of them has one; `jacobian`: the derivatives of the residuals by the variables.
    """

    x: Array
    names: list[str]
    value: float
    inputs: Inputs
    scheme: str
    trials: list[Inputs]
    constraints: Array
    limits: list[tuple[str, float, float]]
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
    attempts: list[Attempt]
    standard_errors: Array | None
    absolute_errors: Array | None
    covariance: Array | None
    chi_squared: float | None
    degrees_of_freedom: int | None
    grid_shifts: Array | None
    undetermined: list[str] | None
    jacobian: Array | None
    # The attempts as a table.
    _table: str = ""

    def __init__(self, systems: list[System], attributes: dict[str, Any], scales: dict[str, tuple[float, bool]]) -> None:
        self.__dict__.update(attributes)
        # Scales of scalar quantities, and whether the variable is the logarithm.
        self._scales = scales
        self.trials = [Inputs._of(system, inputs) for system, inputs in zip(systems, attributes["inputs"])]
        self.inputs = self.trials[0]
        self.history = [Iterate(*of) for of in attributes["history"]]
        self.attempts = [Attempt(*of) for of in attributes.get("attempts", ())]

    def plot(self, ax: Any = None) -> Any:
        """Draws value, violation and stationarity of all iterates by matplotlib. Returns an array of two axes."""
        from ._plots import plot_history

        return plot_history(self.history, ax)

    def __repr__(self) -> str:
        lines = self._off() if self.chi_squared is None else self._parameters()
        message = self.message.replace(", after ", ",\n  after ", 1).replace("): ", "):\n  ", 1)
        warnings = [f"warning: {message}" for _, message in dict.fromkeys(self.warnings)]
        return "\n  ".join([f"<optimum: {message}>", *lines, *self._tried(), *warnings])

    def _off(self) -> Iterator[str]:
        """The outputs that violate their limits, the worst first."""
        if self.converged:
            return
        ends = [(limit, value, min(max(value, limit[1]), limit[2])) for limit, value in zip(self.limits, self.constraints)]
        off = sorted((of for of in ends if abs(of[1] - of[2]) > _OFF), key=lambda of: -abs(of[1] - of[2]))
        for (name, least, most), value, end in off[:_OUTPUTS]:
            side = "" if least == most else "at least " if value < least else "at most "
            yield f"{name} is {value:.6g} instead of {side}{end:.6g}, off by {abs(value - end):.2g}"
        if len(off) > _OUTPUTS:
            yield f"… and {counted(len(off) - _OUTPUTS, 'other output')}"
        # Nothing helps if no state satisfies the constraints.
        if off and all(kind != "NoState" for kind, _ in self.warnings):
            if not self.names:
                yield "nothing is free: list in `free` what may change"
                return
            what_to_do = _WHAT_TO_DO.get(self.reason, "try another start, a longer duration, or wider bounds")
            is_limited = any(attempt.reason == _LIMIT for attempt in self.attempts) and "unlikely to help" not in self.message
            more = "more `iterations`, " if is_limited else ""
            yield _AFTER_SOLVE.format(more=more) if self.attempts and "callback" not in self.reason else what_to_do
            if any(attempt.unstable for attempt in self.attempts):
                yield _UNSTABLE

    def _tried(self) -> list[str]:
        """The table of attempts."""
        # The lines after the attempts name outputs, which are listed above.
        lines, left = self._table.splitlines()[: 1 + len(self.attempts)], len(self.attempts) - _ATTEMPTS
        return lines if left <= 0 else [*lines[: 1 + _ATTEMPTS], f"… and {counted(left, 'other attempt')}"]

    def _parameters(self) -> Iterator[str]:
        """The quantities that are fitted, not their scaled variables, with standard errors."""
        errors = [None] * len(self.x) if self.standard_errors is None else self.standard_errors
        for name, x, error in list(zip(self.names, self.x, errors))[:_PARAMETERS]:
            scale, is_log = self._scales.get(name, (1.0, False))
            slope = scale * np.exp(x) if is_log else scale
            value = slope if is_log else scale * x
            yield f"{name} = {value:.6g}" if error is None else f"{name} = {_with_error(value, slope * error)}"
        if len(self.x) > _PARAMETERS:
            yield f"… and {counted(len(self.x) - _PARAMETERS, 'other variable')}"
        if self.undetermined:
            yield f"without standard errors, because the readings do not determine {', '.join(self.undetermined[:_PARAMETERS])}"
        if not self.converged:
            yield "no minimum was reached, so that these errors mean little: try another start, bounds, or shorter steps"


def _with_error(value: float, error: float) -> str:
    """A value with as many decimals as its error, which has two digits."""
    decimals = 1 - math.floor(math.log10(error)) if 0.0 < error < math.inf else -1
    return f"{value:.{decimals}f} ± {error:.{decimals}f}" if 0 <= decimals <= 9 else f"{value:.6g} ± {error:.2g}"


def lowest(found: Iterable[Optimum], violation: float = 1e-9) -> Optimum | None:
    """The optimum with the lowest value among those whose violation is at most `violation`; the first of equal ones."""
    good = [of for of in found if np.isfinite(of.value) and of.violation <= violation]
    return min(good, key=lambda of: of.value, default=None)
