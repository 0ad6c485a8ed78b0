"""Solvers and motions."""

from __future__ import annotations

import html
import os
from collections.abc import Iterable
from functools import cached_property, partial
from typing import Any, Literal, overload

import numpy as np

from . import _hamiltonian_adjoint as _core
from ._errors import Error, InputError, warn
from ._expression import Expression
from ._progress import Bar
from ._system import Array, Gradient, Inputs, System
from ._tables import to_pandas, to_xarray
from ._values import row, values
from ._words import counted

# Height of a page in a notebook, pixels.
_HEIGHT = 640


class Motion:
    """A motion: arrays with one column for each node."""

    def __init__(self, system: System, core: Any) -> None:
        self.system = system
        self._core = core

    @cached_property
    def times(self) -> Array:
        """The times of the nodes, s."""
        return self._core.times

    @cached_property
    def q(self) -> Array:
        """Coordinates, m or rad."""
        return self._core.matrix("q")

    @cached_property
    def v(self) -> Array:
        """Velocities, m/s or rad/s."""
        return self._core.matrix("v")

    @cached_property
    def p(self) -> Array:
        """Augmented momenta p*, N s or N m s."""
        return self._core.matrix("p")

    @cached_property
    def p_dot(self) -> Array:
        """Rates of the augmented momenta, N or N m."""
        return self._core.matrix("p_dot")

    @cached_property
    def sigma(self) -> Array:
        """Multipliers (impulses), N s or N m s."""
        return self._core.matrix("sigma")

    @cached_property
    def _accelerations(self) -> tuple[Array, Array]:
        return self._core.accelerations()

    @property
    def a(self) -> Array:
        """Accelerations, m/s² or rad/s², of these coordinates, velocities and controls."""
        return self._accelerations[0]

    @property
    def lam(self) -> Array:
        """Reactions λ = dσ/dt, N or N m, with these accelerations; for dependent constraints they are not unique."""
        return self._accelerations[1]

    @cached_property
    def controls(self) -> Array:
        """Controls."""
        return self._core.matrix("controls")

    @cached_property
    def phi(self) -> Array:
        """The constraints Φ, m or rad."""
        return self._core.constraints(False)

    @cached_property
    def phi_dot(self) -> Array:
        """The rates dΦ/dt, m/s or rad/s."""
        return self._core.constraints(True)

    @cached_property
    def inputs(self) -> Inputs:
        """The inputs on the grid that was used."""
        return Inputs._of(self.system, self._core.inputs())

    @property
    def computed(self) -> int:
        """The number of computed nodes."""
        return self._core.computed

    @property
    def inserted(self) -> list[int]:
        """The numbers of the nodes that halved steps inserted."""
        return self._core.inserted

    def __getitem__(self, quantity: Expression | str) -> Array:
        """The values of a quantity at all nodes: a coordinate, `x.v`, `x.a`, a control, `hinge[0].lam`, or a formula of such symbols, such as `m * x.v**2`."""
        return values(self, quantity) if isinstance(quantity, Expression) else row(self, quantity).values

    def plot(self, *quantities: Any, ax: Any = None, **style: Any) -> Any:
        """Draws quantities over time by matplotlib: `plot(arm.phi, arm.phi.v)`, `plot("cart.x")`, `plot(arm)`; by default coordinates, velocities, controls.

        Quantities of one kind and unit share axes. Returns the axes, or an array of axes if there are several, which another motion can be drawn into as
        `ax`. `style` are keywords of `Axes.plot`.
        """
        from ._plots import plot_motion

        return plot_motion(self, quantities, ax, style)

    def to_csv(self) -> str:
        """The motion as CSV, with units."""
        return self._core.to_csv()

    def to_pandas(self) -> Any:
        """A pandas.DataFrame with a row for each node, indexed by time, and the columns of `to_csv`.

        At steps of length zero, such as those after events, several rows have one time.
        """
        return to_pandas(self)

    def to_xarray(self) -> Any:
        """An xarray.Dataset of q, v, p, p_dot, sigma and u with named coordinates, equations and controls, over time.

        At steps of length zero, such as those after events, several nodes have one time; for `sel` keep one of them, by `drop_duplicates("time", keep="last")`.
        """
        return to_xarray(self)

    def html(self, title: str = "Motion") -> str:
        """A page that plays the motion."""
        return self._core.picture(title)

    def svg(self, time: float, title: str = "Motion") -> str:
        """The picture at a time, s."""
        return self._core.picture(title, time)

    def write_html(self, path: str | os.PathLike[str], title: str = "Motion") -> None:
        """Writes a page that plays the motion."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.html(title))

    def _repr_html_(self) -> str:
        # A page that is not as high has no blank below it.
        fit = f"this.style.height = Math.min({_HEIGHT}, this.contentDocument.body.scrollHeight) + 'px'"
        return f'<iframe srcdoc="{html.escape(self.html())}" onload="{fit}" style="width: 100%; height: {_HEIGHT}px; border: 0"></iframe>'

    def __reduce__(self) -> Any:
        return _motion_from_json, (self.system, *self._core.to_json())

    def __repr__(self) -> str:
        end = self.times[-1] if self.computed else np.nan
        return f"<motion: {counted(self.computed, 'node')} to t = {end:g} s, {counted(self.system.n, 'coordinate')}>"


def _motion_from_json(system: System, motion: str, inputs: str) -> Motion:
    return Motion(system, _core.Motion.from_json(system, motion, inputs))


def _checked(inputs: Inputs, system: System) -> Inputs:
    if not isinstance(inputs, Inputs):
        raise TypeError(f"inputs such as system.at_rest(100, 0.01) are expected, not {inputs!r}")
    if inputs.system is not system and inputs.system.parts != system.parts:
        raise InputError("the inputs belong to another system")
    return inputs


def _with_bar(progress: bool, settings: dict[str, Any]) -> dict[str, Any]:
    return {**settings, "progress": Bar()} if progress else settings


class Solver:
    """A solver of one system for many inputs. A thread needs a solver of its own. A pickle has the system and the settings, but no motion.

    Settings are keywords: `scheme` ('trapezoidal rule', 'TR-BDF2', 'ESDIRK3', 'ESDIRK4', 'ESDIRK5'), `tolerance`, `max_iterations`,
    `position_tolerance`, `velocity_tolerance`, `max_halvings`, `drift_bound`, `rebase_every`. With `progress=True`, calls that take more than a second show
    a progress bar by tqdm.
    """

    def __init__(self, system: System, *, progress: bool = False, **settings: Any) -> None:
        if not isinstance(system, System):
            raise TypeError(f"a system such as scene.compile() is expected, not {system!r}")
        self.system = system
        self._keywords = {"progress": progress, **settings}
        self._core = _core.Solver(system, **_with_bar(progress, settings))

    def __reduce__(self) -> Any:
        return partial(type(self), self.system, **self._keywords), ()

    def simulate(self, inputs: Inputs) -> Motion:
        """Computes a motion."""
        motion = Motion(self.system, self._core.simulate(self.system, _checked(inputs, self.system)))
        warn(self._core.warnings())
        return motion

    @property
    def motion(self) -> Motion:
        """The last motion; after an error, up to the failed step."""
        return Motion(self.system, self._core.motion(self.system))

    def _gradient(self, attributes: dict[str, Any]) -> Gradient:
        made = Gradient(self.system, attributes)
        if made.warnings:
            warn(made.warnings, stacklevel=4)
        return made

    def gradient(self, inputs: Inputs | None = None) -> Gradient:
        """J and its derivatives, for these inputs or for the last motion."""
        if inputs is None:
            return self._gradient(self._core.gradient())
        return self._gradient(self._core.solve(self.system, _checked(inputs, self.system)))

    def weighted_gradient(self, cost: float, outputs: Iterable[float]) -> Gradient:
        """The gradient of w₀ J + Σ w_k r_k over the outputs r, for the last motion."""
        return self._gradient(self._core.weighted_gradient(cost, list(outputs)))

    def jacobian(self) -> list[Gradient]:
        """The gradients of all outputs of the last motion."""
        return [Gradient(self.system, of) for of in self._core.jacobian()]

    def hessian_product(self, direction: Inputs) -> Gradient:
        """The product of the Hessian of J with a direction, after `gradient`."""
        return Gradient(self.system, self._core.hessian_product(self.system, _checked(direction, self.system)))

    def cost(self) -> float:
        """J of the last motion."""
        return self._core.cost()

    def outputs(self) -> Array:
        """The values of all outputs of the last motion."""
        return self._core.outputs()

    def adapt(self, inputs: Inputs, tolerance: float) -> Inputs:
        """The same inputs on an adaptive grid, on which the estimated error of every step is below the tolerance."""
        return self._prepared(inputs, "adapt", tolerance)

    def assemble(self, inputs: Inputs) -> Inputs:
        """The same inputs with the start that is assembled from a guess."""
        return self._prepared(inputs, "assemble", 0.0)

    def find_phases(self, inputs: Inputs, least: int) -> Inputs:
        """The same inputs with all events of the motion, and at least this many steps between them."""
        return self._prepared(inputs, "find phases", least)

    def _prepared(self, inputs: Inputs, way: str, number: float) -> Inputs:
        return Inputs._of(self.system, self._core.prepared(self.system, _checked(inputs, self.system), way, number))

    def report(self) -> str:
        """The work of the last motion and of the last backward sweep."""
        motion, gradient = self._core.report()
        return f"motion:\n{motion}\ngradient:\n{gradient}"

    def __repr__(self) -> str:
        return f"<solver of {self.system!r}>"


class LongSolver:
    """A solver of motions that do not fit into memory: it stores at most `bytes` of a motion. Settings and `progress` are those of a `Solver`."""

    def __init__(self, system: System, bytes: int, *, progress: bool = False, **settings: Any) -> None:
        self.system = system
        self._keywords = {"progress": progress, **settings}
        self._bytes = bytes
        self._core = _core.LongSolver(system, bytes, **_with_bar(progress, settings))

    def __reduce__(self) -> Any:
        return partial(type(self), self.system, self._bytes, **self._keywords), ()

    def gradient(self, inputs: Inputs) -> Gradient:
        """J and its derivatives."""
        made = Gradient(self.system, self._core.solve(self.system, _checked(inputs, self.system)))
        warn(made.warnings)
        return made

    def jacobian(self, inputs: Inputs) -> list[Gradient]:
        """The gradients of all outputs."""
        return [Gradient(self.system, of) for of in self._core.jacobian(self.system, _checked(inputs, self.system))]

    def __repr__(self) -> str:
        return f"<long solver of {self.system!r}>"


def simulate(system: System, inputs: Inputs, **settings: Any) -> Motion:
    """Computes one motion."""
    solver = Solver(system, **settings)
    motion = Motion(system, solver._core.simulate(system, _checked(inputs, system)))
    warn(solver._core.warnings())
    return motion


def gradient(system: System, inputs: Inputs, **settings: Any) -> Gradient:
    """J and its derivatives with respect to all inputs."""
    made = Gradient(system, Solver(system, **settings)._core.solve(system, _checked(inputs, system)))
    warn(made.warnings)
    return made


@overload
def gradients(system: System, inputs: Iterable[Inputs], *, errors: Literal["raise"] = ..., progress: bool = ..., **settings: Any) -> list[Gradient]: ...
@overload
def gradients(system: System, inputs: Iterable[Inputs], *, errors: Literal["return"], progress: bool = ..., **settings: Any) -> list[Gradient | Error]: ...
def gradients(system: System, inputs: Iterable[Inputs], *, errors: str = "raise", progress: bool = False, **settings: Any) -> Any:
    """J and its derivatives for each of many inputs, on all cores. A motion that fails raises its error, or is replaced by it if errors='return'."""
    if errors not in ("raise", "return"):
        raise TypeError(f"errors must be 'raise' or 'return', not {errors!r}")
    done = _core.gradients(system, [_checked(one, system) for one in inputs], **_with_bar(progress, settings))
    failed = [of for of in done if isinstance(of, Exception)]
    if failed and errors == "raise":
        raise failed[0]
    made = [of if isinstance(of, Exception) else Gradient(system, of) for of in done]
    warn([found for of in made if isinstance(of, Gradient) for found in of.warnings])
    return made
