"""Optimisation of motions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _hamiltonian_adjoint as _core
from ._errors import Error, InputError, OptimiseError, warn
from ._expression import Symbol
from ._free import Free, free, interval, mapping, stated
from ._guess import Guess, checked_guess, of_segments
from ._handles import Coordinate, Output
from ._names import suggestion
from ._optimum import Iterate, Optimum, OptimumDerivative, lowest
from ._progress import Bar, with_bar
from ._solver import _checked
from ._system import Array, Inputs, System
from ._words import counted, whole

METHODS = ("interior point", "L-BFGS", "augmented Lagrangian", "Levenberg-Marquardt", "stages")
SETTINGS = ("scheme", "tolerance", "max_iterations", "position_tolerance", "velocity_tolerance", "max_halvings", "drift_bound", "rebase_every")
OPTIONS = ("iterations", "target", "stationarity", "violation", "memory", "first_step")
_KNOWN = f"options of the methods are {', '.join(OPTIONS)}; settings of the solver, as settings={{…}}, are {', '.join(SETTINGS)}"

# Arguments of methods, not of problems.
_ARGUMENTS = {"method": "minimise", "start": "minimise", "guess": "solve", "starts": "solve", "accuracy": "solve", **dict.fromkeys(("callback", "progress", *OPTIONS), "minimise")}

# Names of the variables of scalar quantities.
_VARIABLES = {"design": "{}", "coordinate": "initial {}", "rate": "initial rate of {}", "duration": "{}", "step": "{}"}

Callback = Callable[[Iterate, np.ndarray], bool | None]


class _Stated:
    """The methods of all problems."""

    _motions: list[Problem]
    # The number of segments, names of states, guesses, and outputs in the cost.
    _shooting: tuple[int, list[str], list[tuple[bool, int, list[float]]], list[str]] | None = None
    # True if several motions have only their design variables in common.
    _shares_designs: bool = False

    @property
    def start(self) -> Array:
        """The variables x of the inputs."""
        return np.array(_core.start(self)[0])

    @property
    def names(self) -> list[str]:
        """The names of the variables."""
        return _core.start(self)[1]

    def solve(self, guess: Guess = "straight", *, starts: int = 1, accuracy: float | None = None, callback: Callback | None = None, progress: bool = False, **options: Any) -> Optimum:
        """Minimises J of a motion from a guess of its states; no guess of the controls is needed. The default way to an optimum.

        The motion is divided into segments that begin at the guess and meet in the course of the optimisation; then they are joined to a single motion.
        If segments do not lead to a minimum, one motion without segments and segments of other lengths are tried: see `attempts` of the optimum. `guess` is

        - 'straight': a straight line from the start to a state near it that satisfies the equality constraints on terminal outputs; loads whose places are
          not given hang there below what carries them;
        - a pair (q, v) of arrays with a row for each coordinate and a column for each node, or a Motion; independent coordinates are used, the others follow
          from the constraints;
        - an Optimum of a problem with slightly different targets, bounds, start or parameters, which leads to the new optimum in a few iterations;
        - 'inputs': the motion of the inputs, without segments.

        If `starts` is larger than 1, the other starts have random controls, durations and guesses, every second one near the best minimum so far. Each
        is tried in segments or as one motion. They run on all cores, and the lowest minimum is returned.

        With `accuracy`, the problem is solved again by ESDIRK4, and then with the steps halved that have the largest errors, until the estimated errors
        that the grid causes are at most this fraction of J, and of each constrained output or 1 m or rad, whichever is larger; `inputs` of the optimum
        have this grid, and `scheme` is its scheme.

        `callback(iterate, x)` may return True to stop. It receives the iterates of the first start, and the best point after each group of other starts. With
        `progress`, a bar by tqdm counts these calls. Options are those of `minimise`; `iterations` limits each attempt, which has at most 400 in segments.
        """
        found = self._solve(guess, (starts, accuracy), callback, progress, options)
        warn(found.warnings)
        return found

    def _solve(self, guess: Guess, search: tuple[int, float | None], callback: Callback | None, progress: bool, options: dict[str, Any]) -> Optimum:
        if self._shooting is not None:
            raise OptimiseError("`solve` divides the motion into segments itself: state it as a `Problem`, or call `minimise(method='stages')`")
        if len(self._motions) > 1:
            raise OptimiseError("`solve` is for a single motion: solve each `Problem` by itself, or call `minimise` for `Trials`")
        starts, accuracy = search
        if (count := whole("`starts`", starts)) < 1:
            raise InputError(f"`starts` is {count}; at least one start is expected")
        states, options = checked_guess(self._motions[0].inputs, guess), _options(options)
        with with_bar(callback, progress) as watched:
            return self._optimum(_core.solve(self, states, (count, None if accuracy is None else float(accuracy)), options, _called(watched)))

    def sensitivities(self, optimum: Optimum, by: Iterable[Output | Symbol | str | int], **options: Any) -> list[OptimumDerivative]:
        """The derivatives of an optimum of `solve` by quantities of the problem, one for each entry of `by`:

        - an output or its name: by the value that the output must have, or by both ends of its interval;
        - a free design variable, initial coordinate or initial velocity, 'duration', or the number of a variable x[i]: by both of its bounds. If they are equal,
          this is the derivative by the value of the quantity.

        The problem is solved again from the optimum, with the same settings. If a bound is active but its multiplier is zero, the optimum has a kink, and the
        derivative is between those on both sides. Raises an OptimiseError if the point is not a minimum at which derivatives exist.
        """
        if self._shooting is not None or len(self._motions) > 1:
            raise OptimiseError("`sensitivities` are those of a single motion: state it as a `Problem`")
        if not isinstance(optimum, Optimum):
            raise TypeError(f"an Optimum of `solve` is expected, not {optimum!r}")
        minimum = [float(x) for x in optimum.x], [float(w) for w in optimum.multipliers]
        return [OptimumDerivative(*of) for of in _core.sensitivities(self, minimum, [self._parameter(of) for of in by], _options(options))]

    def _parameter(self, by: Output | Symbol | str | int) -> str | int:
        """The name of an output or the number of a variable."""
        if isinstance(by, Symbol) or isinstance(by, str) and by == "duration":
            of = free(by)
            name = _VARIABLES.get(of.kind, "").format(of.name)
            known = [_VARIABLES[kind].format(own) for kind, own, *_ in self._motions[0]._free if kind in _VARIABLES]
            if name not in known:
                those = f"; those are {', '.join(known)}" if known else ""
                raise InputError(f"{of.kind} `{of.name}` is not a single free variable of this problem{those}")
            return self.names.index(name)
        return _output(self._motions[0].system, by) if isinstance(by, (Output, str)) else whole("the number of a variable", by)

    def minimise(
        self,
        method: str = "interior point",
        *,
        start: ArrayLike | None = None,
        callback: Callback | None = None,
        progress: bool = False,
        **options: Any,
    ) -> Optimum:
        """Minimises by a method from `start`, by default from the variables of the inputs.

        Methods are 'interior point' (exact products of the Hessian), 'L-BFGS' and 'augmented Lagrangian' (gradients alone), 'Levenberg-Marquardt'
        (minimises half the sum of squares of the outputs), and for a MultipleShooting 'stages' (segment by segment). `callback(iterate, x)` may return True to stop. With `progress`, a bar by tqdm counts the
        iterates. Options are

        - `iterations`: the largest number of iterations, 1000;
        - `stationarity`: tolerance of the gradient by variables that are not at a bound, relative to its terms at the point ('interior point') or to the start, 1e-7;
        - `violation`: tolerance of the violation of constraints, 1e-9;
        - `target`: a value at which the method stops, None;
        - `memory`: the number of pairs that L-BFGS stores, 30;
        - `first_step`: the length of the first step in the variable that changes most, None.
        """
        found = self._minimise(method, start, callback, progress, options)
        warn(found.warnings)
        return found

    def _minimise(self, method: str, start: ArrayLike | None, callback: Callback | None, progress: bool, options: dict[str, Any]) -> Optimum:
        x, options = None if start is None else _point(start), _options(options)
        with with_bar(callback, progress) as watched:
            return self._optimum(_core.minimise(self, self._method(method), x, options, _called(watched)))

    def identify(self, *, callback: Callback | None = None, progress: bool = False, **options: Any) -> Optimum:
        """Fits the free quantities to readings, from a guess that may be far away: minimises half the sum of squares of the outputs.

        First the motions are fitted as they are, by 'Levenberg-Marquardt'. If their residuals are larger than the deviations of the readings explain, or if
        these are not known, the motions are divided into segments whose initial states are fitted to the readings and joined step by step; then the
        motions are fitted again. This converges where motions get out of phase with the readings, or are unstable. `attempts` of the optimum list what was
        tried. Options are those of `minimise`, and apply to each fit; `callback(iterate, x)` may return True to stop.
        """
        if self._shooting is not None:
            raise OptimiseError("`identify` divides motions into segments itself: state them as a `Problem`, or several as `Trials`")
        options = _options(options)
        with with_bar(callback, progress) as watched:
            found = self._optimum(_core.identify(self, options, _called(watched)))
        warn(found.warnings)
        return found

    def multi_start(self, starts: Iterable[ArrayLike], method: str = "interior point", *, progress: bool = False, **options: Any) -> list[Optimum]:
        """Minimises from many starts on all cores, with the results in the order of the starts; `lowest` chooses the best."""
        points = [_point(start) for start in starts]
        found = [self._optimum(of) for of in _core.multi_start(self, points, self._method(method), _options(options), Bar() if progress else None)]
        # Local minima explain no readings; only the best one has to.
        least = lowest(found, violation=math.inf)
        warn([warning for of in found for warning in of.warnings if of is least or warning[0] != "Misfit"])
        return found

    def _method(self, method: str) -> str:
        if method not in METHODS:
            raise InputError(f"there is no method '{method}'; the methods are {', '.join(repr(of) for of in METHODS)}")
        if method == "stages" and self._shooting is None:
            raise InputError("the method 'stages' is for segments: state the problem as a MultipleShooting")
        return method

    def _optimum(self, attributes: dict[str, Any]) -> Optimum:
        scales: dict[str, tuple[float, bool]] = {}
        for trial, of in enumerate(self._motions):
            for kind, name, _, _, scale, is_log in of._free:
                if kind in _VARIABLES:
                    own = f" of trial {trial}" if self._shares_designs and kind != "design" else ""
                    scales.setdefault(_VARIABLES[kind].format(name) + own, (scale, is_log))
        attributes.setdefault("scheme", self._motions[0].settings.get("scheme", "trapezoidal rule"))
        return Optimum([of.system for of in self._motions], attributes, scales)

    def __repr__(self) -> str:
        try:
            return f"<{type(self).__name__} of {counted(len(self.start), 'variable')}>"
        except Error as error:
            return f"<{type(self).__name__} that cannot be solved: {error}>"


class Problem(_Stated):
    """The problem of minimising J over the free quantities, subject to bounds and to constraints on outputs, for several methods or starts.

    `bounds` are pairs (least, most) for quantities in `free`. Outputs must be zero; `constraints` sets another value or a pair, or None to leave an output
    free. `settings` are those of a Solver, such as {'scheme': 'ESDIRK4'}.
    """

    def __init__(
        self,
        system: System,
        inputs: Inputs,
        free: Iterable[Symbol | Free | str],
        *,
        bounds: Mapping[Symbol | str, Any] | None = None,
        constraints: Mapping[Output | str, Any] | None = None,
        settings: Mapping[str, Any] | None = None,
        **misplaced: Any,
    ) -> None:
        _refuse(misplaced)
        self.system, self.inputs, self.settings = system, _checked(inputs, system).copy(), _settings(settings)
        self._free = [of._core for of in stated(free, bounds)]
        given = mapping(constraints, "constraints", "{output: 0.5}")
        wanted = {_output(system, of): to for of, to in given.items()}
        self._constraints = [(name, *interval(to, f"constraint `{name}`")) for name, to in wanted.items()]
        self._motions = [self]

    def homotopy(
        self, set: Callable[[Inputs, float], None], *, callback: Callback | None = None, progress: bool = False, **options: Any
    ) -> Optimum:
        """Solves a sequence of problems by 'interior point', each from the previous solution, while s grows from 0 to 1: `set(inputs, s)` changes the inputs.

        If a problem is not solved, s grows by less. If s = 1 is not reached, the optimum has not converged and is that of the last s.
        """

        def changed(attributes: dict[str, Any], s: float) -> Inputs:
            inputs = Inputs._of(self.system, attributes)
            set(inputs, s)
            return inputs

        with with_bar(callback, progress) as watched:
            found = self._optimum(_core.homotopy(self, changed, _options(options), _called(watched)))
        warn(found.warnings)
        return found


class MultipleShooting(_Stated):
    """A problem whose motion is divided into segments, the initial states of which are variables: for ends that are too sensitive to the start.

    `states` lists one coordinate for each degree of freedom. `guess` contains values of coordinates and velocities `x.v` at all nodes, or numbers. Outputs
    in `costs` are added to J instead of being constraints. Other arguments are those of a `Problem`. `solve` of a `Problem` chooses segments itself.
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
        settings: Mapping[str, Any] | None = None,
        **misplaced: Any,
    ) -> None:
        self._motions = [Problem(system, inputs, free, bounds=bounds, constraints=constraints, settings=settings, **misplaced)]
        names = [system._named("coordinate", system.coordinates, of) for of in states]
        given = mapping(guess, "guess", "{angle: values}")
        guesses = [of_segments(inputs, of, values) for of, values in given.items()]
        self._shooting = (whole("`segments`", segments), names, guesses, [_output(system, of) for of in costs])


class Trials(_Stated):
    """Several problems, such as experiments with different starts or forces: the sum of their costs and all their outputs.

    Their variables are the same, unless `share` is 'designs': then free design variables of the same name are one variable, and all other free
    quantities, such as initial values, belong to their problem; this is for records of several experiments. `trials` of an optimum are the inputs of
    each motion.
    """

    def __init__(self, problems: Iterable[Problem], share: str = "all") -> None:
        if share not in ("all", "designs"):
            raise InputError(f"trials share 'all' variables or 'designs', not '{share}'")
        self._shares_designs = share == "designs"
        self._motions = list(problems)
        if not self._motions or not all(isinstance(of, Problem) for of in self._motions):
            raise TypeError("trials are a list of one or more instances of `Problem`")


def solve(
    system: System,
    inputs: Inputs,
    free: Iterable[Symbol | Free | str],
    *,
    bounds: Mapping[Symbol | str, Any] | None = None,
    constraints: Mapping[Output | str, Any] | None = None,
    settings: Mapping[str, Any] | None = None,
    guess: Guess = "straight",
    starts: int = 1,
    accuracy: float | None = None,
    callback: Callback | None = None,
    progress: bool = False,
    **options: Any,
) -> Optimum:
    """Minimises J over the free quantities, subject to bounds and to constraints on outputs, from a guess of the states, as `Problem(…).solve(guess, …)`.

    `settings` are those of a Solver, such as {'scheme': 'ESDIRK4'}; guesses and options are those of `Problem.solve`.
    """
    problem = Problem(system, inputs, free, bounds=bounds, constraints=constraints, settings=settings)
    found = problem._solve(guess, (starts, accuracy), callback, progress, options)
    warn(found.warnings)
    return found


def minimise(
    system: System,
    inputs: Inputs,
    free: Iterable[Symbol | Free | str],
    *,
    bounds: Mapping[Symbol | str, Any] | None = None,
    constraints: Mapping[Output | str, Any] | None = None,
    settings: Mapping[str, Any] | None = None,
    method: str = "interior point",
    callback: Callback | None = None,
    progress: bool = False,
    **options: Any,
) -> Optimum:
    """Minimises J over the free quantities by a method, subject to bounds and to constraints on outputs, as `Problem(…).minimise(method, …)`.

    `settings` are those of a Solver, such as {'scheme': 'ESDIRK4'}; options of the method, such as `iterations`, are those of `Problem.minimise`.
    """
    problem = Problem(system, inputs, free, bounds=bounds, constraints=constraints, settings=settings)
    found = problem._minimise(method, None, callback, progress, options)
    warn(found.warnings)
    return found


def _output(system: System, of: Output | str) -> str:
    return system._named("output", system.outputs, of)


def _refuse(misplaced: dict[str, Any]) -> None:
    """Raises a TypeError about keywords that a problem does not have."""
    for name in misplaced:
        if name in SETTINGS:
            raise TypeError(f"`{name}` is a setting of the solver: write settings={{'{name}': …}}; {_KNOWN}")
        if (of := _ARGUMENTS.get(name)) is not None:
            raise TypeError(f"`{name}` is an argument of `{of}`: write problem.{of}({name}=…); {_KNOWN}")
        raise TypeError(f"a problem has no argument `{name}`{suggestion(name, ('bounds', 'constraints', 'settings', 'guess', 'costs'))}")


def _options(options: dict[str, Any]) -> dict[str, Any]:
    """Options of a method; an unknown one may be a setting of the solver."""
    for name in options:
        if name not in OPTIONS:
            problem = f"`{name}` is a setting of the solver: write settings={{'{name}': …}}" if name in SETTINGS else f"there is no option `{name}`"
            problem = f"`{name}` is an argument of `{_ARGUMENTS[name]}`" if name in _ARGUMENTS else problem
            raise TypeError(f"{problem}; {_KNOWN}")
    return {**options, **{name: whole(f"`{name}`", options[name]) for name in ("iterations", "memory") if options.get(name) is not None}}


def _settings(settings: Mapping[str, Any] | None) -> dict[str, Any]:
    """Settings of the solver; an unknown one may be an option of the method."""
    for name in settings or {}:
        if name not in SETTINGS:
            problem = f"`{name}` is an option of the method, not a setting of the solver" if name in OPTIONS else f"there is no setting `{name}`"
            raise TypeError(f"{problem}; {_KNOWN}")
    return dict(settings or {})


def _point(x: ArrayLike) -> list[float]:
    return np.ravel(np.asarray(x, dtype=np.float64)).tolist()


def _called(callback: Callback | None) -> Any:
    return None if callback is None else lambda iterate, x: callback(Iterate(*iterate), x)
