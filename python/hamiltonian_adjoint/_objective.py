"""J and the outputs as functions of an array, for optimisers and libraries of automatic differentiation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _bridges
from ._errors import InputError
from ._expression import Symbol
from ._free import Free
from ._solver import Solver
from ._system import Array, Gradient, Inputs, System, _index


class Objective:
    """J and the outputs as functions of the array x of the values of the free inputs: controls at all nodes, design variables, coordinates or velocities.

    `scipy.optimize.minimize(objective, objective.x, jac=True, hessp=objective.hessian_product)`, or
    `scipy.optimize.least_squares(objective.outputs, objective.x, objective.jacobian)`.
    """

    def __init__(self, system: System, inputs: Inputs, free: Sequence[Symbol | str], **settings: Any) -> None:
        self.system = system
        self._inputs = inputs.copy()
        self._places = [_place(system, symbol) for symbol in free]
        twice = next((of for i, of in enumerate(self._places) if of in self._places[:i]), None)
        if twice:
            raise InputError(f"`free` contains entry {twice[1]} of `{twice[0]}` twice")
        self._solver = Solver(system, **settings)
        self._last: bytes | None = None
        self.x: Array = self._flat(self._inputs)

    def _flat(self, of: Inputs | Gradient) -> Array:
        return np.concatenate([np.ravel(getattr(of, name)[i]) for name, i in self._places] or [np.zeros(0)])

    def inputs(self, x: ArrayLike) -> Inputs:
        """The inputs with these values."""
        return self._filled(self._inputs.copy(), x)

    def _filled(self, inputs: Inputs, x: ArrayLike) -> Inputs:
        """Writes x into inputs or into a direction."""
        x = np.asarray(x, dtype=np.float64)
        if x.shape != self.x.shape:
            raise ValueError(f"x has the shape {x.shape}, but the free inputs have {self.x.shape}")
        first = 0
        for name, i in self._places:
            count = np.size(getattr(inputs, name)[i])
            getattr(inputs, name)[i] = x[first : first + count] if name == "controls" else x[first]
            first += count
        return inputs

    def _simulate(self, x: ArrayLike) -> None:
        # Optimisers ask for values and derivatives at the same point.
        key = np.asarray(x, dtype=np.float64).tobytes()
        if key != self._last:
            self._last = None
            self._solver.simulate(self.inputs(x))
            self._last = key

    def __call__(self, x: ArrayLike) -> tuple[float, Array]:
        """J and its gradient by x."""
        self._simulate(x)
        gradient = self._solver.gradient()
        return gradient.value, self._flat(gradient)

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
        rows = [self._flat(row) for row in self._solver.jacobian()]
        return np.array(rows).reshape(len(rows), len(self.x))

    def hessian_product(self, x: ArrayLike, direction: ArrayLike) -> Array:
        """The product of the Hessian of J with a direction, for example as `hessp` of SciPy."""
        self._simulate(x)
        self._solver.gradient()
        return self._hessian_column(direction)

    def hessian(self, x: ArrayLike, cost: float = 1.0, outputs: ArrayLike | None = None) -> Array:
        """The Hessian of w₀ J + Σ w_k r_k with these weights of J and of the outputs r, by default of J. It costs one product for each entry of x."""
        self.pull_back(x, cost, np.zeros(len(self.system.outputs)) if outputs is None else outputs)
        columns = [self._hessian_column(unit) for unit in np.eye(len(self.x))]
        return np.array(columns).reshape(len(self.x), len(self.x))

    def _hessian_column(self, direction: ArrayLike) -> Array:
        return self._flat(self._solver.hessian_product(self._filled(self._inputs.no_change(), direction)))

    def pull_back(self, x: ArrayLike, cost: float, outputs: ArrayLike) -> Array:
        """The gradient of w₀ J + Σ w_k r_k over the outputs r by x, in one backward sweep."""
        self._simulate(x)
        return self._flat(self._solver.weighted_gradient(cost, np.asarray(outputs, dtype=np.float64)))

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


def _place(system: System, symbol: Any) -> tuple[str, int]:
    """The list and the number of a free input."""
    if isinstance(symbol, Free) or symbol == "duration":
        raise TypeError(f"an Objective has no variable {symbol!r}; give a control, design variable, coordinate or velocity, or state a `Problem`")
    return _index(system, symbol)
