"""J and the outputs as functions of an array, for optimisers and libraries of automatic differentiation."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _bridges
from . import _hamiltonian_adjoint as _core
from ._expression import Symbol
from ._free import Free, stated
from ._solver import Solver, _checked
from ._system import Array, Gradient, Inputs, System, _index
from ._words import counted


class Objective:
    """J and the outputs as functions of the array x of the values of the free quantities, which are those of `minimise`; `names` are those of x.

    `scipy.optimize.minimize(objective, objective.x, jac=True, hessp=objective.hessian_product)`, or
    `scipy.optimize.least_squares(objective.outputs, objective.x, objective.jacobian)`. Keywords are settings of a Solver.
    """

    def __init__(self, system: System, inputs: Inputs, free: Iterable[Symbol | Free | str], **settings: Any) -> None:
        self.system = system
        self._inputs = _checked(inputs, system).copy()
        self._free = stated([_named(system, of) for of in free], None)
        self._variables = _core.Variables(system, self._inputs, [of._core for of in self._free])
        self._solver = Solver(system, **settings)
        self._last: bytes | None = None
        # The gradient of J, if the solver's last backward sweep computed it at this point.
        self._swept: Gradient | None = None
        self.x: Array = self._variables.of(self._inputs)
        self.names = self._variables.names

    def __reduce__(self) -> Any:
        return partial(Objective, self.system, self._inputs, self._free, **self._solver._keywords), ()

    def __repr__(self) -> str:
        return f"<objective of {counted(len(self.x), 'variable')}>"

    def _point(self, x: ArrayLike) -> Array:
        point = np.asarray(x, dtype=np.float64)
        if point.shape != self.x.shape:
            raise ValueError(f"x has the shape {point.shape}, but the free inputs have {self.x.shape}")
        return point

    def inputs(self, x: ArrayLike) -> Inputs:
        """The inputs with these values."""
        return Inputs._of(self.system, self._variables.apply(self._point(x), self._inputs))

    def _slope(self, x: ArrayLike, of: Gradient) -> Array:
        """The derivatives by x from those by the inputs."""
        return self._variables.pull_back(self._point(x), of)

    def _simulate(self, x: ArrayLike) -> None:
        # Optimisers ask for values and derivatives at the same point.
        key = np.asarray(x, dtype=np.float64).tobytes()
        if key != self._last:
            self._last = self._swept = None
            self._solver.simulate(self.inputs(x))
            self._last = key

    def _gradient(self, x: ArrayLike) -> Gradient:
        """J and its derivatives by the inputs; products of the Hessian then belong to J."""
        self._simulate(x)
        if self._swept is None:
            self._swept = self._solver.gradient()
        return self._swept

    def __call__(self, x: ArrayLike) -> tuple[float, Array]:
        """J and its gradient by x."""
        gradient = self._gradient(x)
        return gradient.value, self._slope(x, gradient)

    def value(self, x: ArrayLike) -> float:
        """J."""
        self._simulate(x)
        return self._solver.cost()

    def outputs(self, x: ArrayLike) -> Array:
        """The values of all outputs."""
        self._simulate(x)
        return self._solver.outputs()

    def jacobian(self, x: ArrayLike) -> Array:
        """The derivatives of all outputs by x, one row for each."""
        self._simulate(x)
        self._swept = None
        rows = [self._slope(x, row) for row in self._solver.jacobian()]
        return np.array(rows).reshape(len(rows), len(self.x))

    def hessian_product(self, x: ArrayLike, direction: ArrayLike) -> Array:
        """The product of the Hessian of J with a direction, for example as `hessp` of SciPy."""
        slope = self._slope(x, self._gradient(x))
        return self._hessian_column(self._point(x), slope, self._point(direction))

    def hessian(self, x: ArrayLike, cost: float = 1.0, outputs: ArrayLike | None = None) -> Array:
        """The Hessian of w₀ J + Σ w_k r_k with these weights of J and of the outputs r, by default of J. It costs one product for each entry of x."""
        slope = self.pull_back(x, cost, np.zeros(len(self.system.outputs)) if outputs is None else outputs)
        columns = [self._hessian_column(self._point(x), slope, unit) for unit in np.eye(len(self.x))]
        return np.array(columns).reshape(len(self.x), len(self.x))

    def _hessian_column(self, x: Array, slope: Array, direction: Array) -> Array:
        change = Inputs._of(self.system, self._variables.push_forward(x, direction, self._inputs.no_change()))
        return self._variables.product(x, slope, direction, self._solver.hessian_product(change))

    def pull_back(self, x: ArrayLike, cost: float, outputs: ArrayLike) -> Array:
        """The gradient of w₀ J + Σ w_k r_k over the outputs r by x, in one backward sweep."""
        self._simulate(x)
        self._swept = None
        return self._slope(x, self._solver.weighted_gradient(cost, np.asarray(outputs, dtype=np.float64)))

    def for_jax(self) -> Any:
        """J as a function of a JAX array, with its derivative, also under `jax.jit`."""
        return _bridges.jax_function(self)

    def for_torch(self) -> Any:
        """J as a function of a PyTorch tensor of doubles, with its derivative."""
        return _bridges.torch_function(self)

    def for_ipopt(self) -> Any:
        """A `problem_obj` for `cyipopt.Problem`: J, the outputs as constraints, and their first and second derivatives."""
        return _bridges.IpoptProblem(self)

    def for_casadi(self, name: str = "motion") -> Any:
        """A CasADi function x ↦ (J, outputs) with its derivatives, for `casadi.nlpsol`. It must stay alive as long as CasADi uses it.

        If a motion fails, all values are NaN, for which `nlpsol` shortens its step; `objective(x)` raises the error. The option
        `show_eval_warnings=False` of `nlpsol` omits its warnings.
        """
        return _bridges.casadi_function(self, name)


_LISTS = {"controls": "u", "design": "b", "q": "q"}


def _named(system: System, of: Any) -> Any:
    """The symbol of an input that is given by its name."""
    if not isinstance(of, str) or of == "duration":
        return of
    kind, _ = _index(system, of)
    return Symbol(_LISTS[kind], of)
