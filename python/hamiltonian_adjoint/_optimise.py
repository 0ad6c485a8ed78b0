"""Optimisation of motions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from . import _hamiltonian_adjoint as _core
from ._errors import InputError, warn
from ._expression import Symbol
from ._free import Free, interval, stated
from ._handles import Coordinate, Output, end_state_names
from ._solver import _checked
from ._system import Array, Inputs, System, _index

METHODS = ("interior point", "L-BFGS", "augmented Lagrangian", "Levenberg-Marquardt")
_OPTIONS = ("iterations", "target", "stationarity", "violation", "memory", "first_step")

Callback = Callable[["Iterate", np.ndarray], bool | None]


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


class Problem:
    """The problem of minimising J over the free quantities, subject to bounds and to constraints on outputs, for several methods or starts.

    `bounds` are pairs (least, most) for quantities in `free`. Outputs must be zero; `constraints` sets another value or a pair, or None to leave an output
    free. Other keywords are settings of a Solver.
    """

    # The number of segments, names of states, guesses, and outputs in the cost.
    _shooting: tuple[int, list[tuple[str, str, str]], list[tuple[bool, int, list[float]]], list[str]] | None = None

    def __init__(
        self,
        system: System,
        inputs: Inputs,
        free: Iterable[Symbol | Free | str],
        *,
        bounds: Mapping[Symbol | str, Any] | None = None,
        constraints: Mapping[Output | str, Any] | None = None,
        **settings: Any,
    ) -> None:
        self.system, self.inputs, self.settings = system, _checked(inputs, system).copy(), settings
        self._free = [(of.kind, of.name, of.count, of.within, of.scale, of.logarithm) for of in stated(free, bounds)]
        self._constraints = [(_name(of), *interval(to)) for of, to in (constraints or {}).items()]

    @property
    def start(self) -> Array:
        """The variables x of the inputs."""
        return np.array(_core.start(self)[0])

    @property
    def names(self) -> list[str]:
        """The names of the variables."""
        return _core.start(self)[1]

    def minimise(self, method: str = "interior point", *, start: ArrayLike | None = None, callback: Callback | None = None, **options: Any) -> Optimum:
        """Minimises from `start`, by default from the variables of the inputs.

        Methods are 'interior point' (exact products of the Hessian), 'L-BFGS' and 'augmented Lagrangian' (gradients alone), and 'Levenberg-Marquardt'
        (minimises the sum of squares of the outputs). `callback(iterate, x)` may return True to stop. Options are `iterations`, `target`, `stationarity`,
        `violation`, `memory` and `first_step`.
        """
        found = self._minimise(method, start, callback, options)
        warn(found.warnings)
        return found

    def _minimise(self, method: str, start: ArrayLike | None, callback: Callback | None, options: dict[str, Any]) -> Optimum:
        x = None if start is None else _point(start)
        return Optimum(self.system, _core.minimise(self, _method(method), x, options, _called(callback)))

    def multi_start(self, starts: Iterable[ArrayLike], method: str = "interior point", **options: Any) -> list[Optimum]:
        """Minimises from many starts on all cores, with the results in the order of the starts; `lowest` chooses the best."""
        points = [_point(start) for start in starts]
        found = [Optimum(self.system, of) for of in _core.multi_start(self, points, _method(method), options)]
        warn([warning for of in found for warning in of.warnings])
        return found

    def homotopy(self, set: Callable[[Inputs, float], None], *, callback: Callback | None = None, **options: Any) -> Optimum:
        """Solves a sequence of problems by 'interior point', each from the previous solution, while s grows from 0 to 1: `set(inputs, s)` changes the inputs.

        If a problem is not solved, s grows by less. If s = 1 is not reached, the optimum has not converged and is that of the last s.
        """

        def changed(attributes: dict[str, Any], s: float) -> Inputs:
            inputs = Inputs._of(self.system, attributes)
            set(inputs, s)
            return inputs

        found = Optimum(self.system, _core.homotopy(self, changed, options, _called(callback)))
        warn(found.warnings)
        return found

    def __repr__(self) -> str:
        return f"<problem: {len(self.start)} variables, {self.inputs!r}>"


class MultipleShooting(Problem):
    """A problem whose motion is divided into segments, the initial states of which are variables: for ends that are too sensitive to the start.

    `states` lists one coordinate for each degree of freedom; `scene.end_state` must have been called for each of them. `guess` contains values of
    coordinates and velocities `x.v` at all nodes, or numbers. Outputs in `costs` are added to J instead of being constraints.
    """

    def __init__(
        self,
        system: System,
        inputs: Inputs,
        free: Iterable[Symbol | Free | str],
        states: Iterable[Coordinate | str],
        segments: int,
        *,
        guess: Mapping[Symbol | str, ArrayLike] | None = None,
        costs: Iterable[Output | str] = (),
        bounds: Mapping[Symbol | str, Any] | None = None,
        constraints: Mapping[Output | str, Any] | None = None,
        **settings: Any,
    ) -> None:
        super().__init__(system, inputs, free, bounds=bounds, constraints=constraints, **settings)
        names = [of if isinstance(of, str) else of.name for of in states]
        ends = [(name, *end_state_names(name)) for name in names]
        guesses = [self._guess(of, values) for of, values in (guess or {}).items()]
        self._shooting = (int(segments), ends, guesses, [_name(of) for of in costs])

    def _guess(self, of: Symbol | str, values: ArrayLike) -> tuple[bool, int, list[float]]:
        which, i = _index(self.system, of)
        if which not in ("q", "v"):
            raise TypeError(f"a guess has coordinates and velocities such as `x.v`, not {of!r}")
        nodes = len(self.inputs.steps) + 1
        values = np.asarray(values, dtype=np.float64)
        if values.shape not in ((), (nodes,)):
            raise InputError(f"the guess of {of!r} has the shape {values.shape}; a number or {nodes} values, one for each node, are expected")
        return which == "v", i, np.broadcast_to(values, nodes).tolist()

    def homotopy(self, set: Any, **options: Any) -> Optimum:
        """Not supported: use `inputs` of an optimum of a single motion, `Problem`."""
        raise TypeError("a homotopy changes the inputs of a single motion; use `Problem`, or solve the problem with fewer and fewer segments")


def minimise(
    system: System,
    inputs: Inputs,
    free: Iterable[Symbol | Free | str],
    *,
    bounds: Mapping[Symbol | str, Any] | None = None,
    constraints: Mapping[Output | str, Any] | None = None,
    method: str = "interior point",
    callback: Callback | None = None,
    **keywords: Any,
) -> Optimum:
    """Minimises J over the free quantities, subject to bounds and to constraints on outputs, as `Problem(…).minimise(method, …)`.

    Keywords are the options of `Problem.minimise` and settings of a Solver.
    """
    options = {name: keywords.pop(name) for name in _OPTIONS if name in keywords}
    problem = Problem(system, inputs, free, bounds=bounds, constraints=constraints, **keywords)
    found = problem._minimise(method, None, callback, options)
    warn(found.warnings)
    return found


def lowest(found: Iterable[Optimum], violation: float = 1e-9) -> Optimum | None:
    """The optimum with the lowest value among those whose violation is at most `violation`; the first of equal ones."""
    good = [of for of in found if np.isfinite(of.value) and of.violation <= violation]
    return min(good, key=lambda of: of.value, default=None)


def _name(of: Output | str) -> str:
    return of if isinstance(of, str) else of.name


def _method(method: str) -> str:
    if method not in METHODS:
        raise InputError(f"there is no method '{method}'; the methods are {', '.join(repr(of) for of in METHODS)}")
    return method


def _point(x: ArrayLike) -> list[float]:
    return np.ravel(np.asarray(x, dtype=np.float64)).tolist()


def _called(callback: Callback | None) -> Any:
    return None if callback is None else lambda iterate, x: callback(Iterate(*iterate), x)
