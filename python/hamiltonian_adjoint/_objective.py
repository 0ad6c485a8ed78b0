"""J and the outputs as functions of an array, for optimisers and libraries of automatic differentiation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._expression import Symbol
from ._solver import Solver
from ._system import Array, Gradient, Inputs, System, _index


class Objective:
    """J and the outputs as functions of the array x of the values of the free inputs: controls at all nodes, design variables, coordinates or velocities.

    `scipy.optimize.minimize(objective, objective.x, jac=True)`, or
    `scipy.optimize.least_squares(objective.outputs, objective.x, objective.jacobian)`.
    """

    def __init__(self, system: System, inputs: Inputs, free: Sequence[Symbol | str], **settings: Any) -> None:
        self.system = system
        self._inputs = inputs.copy()
        self._places = [_index(system, symbol) for symbol in free]
        self._solver = Solver(system, **settings)
        self._last: bytes | None = None
        self.x: Array = self._flat(self._inputs)

    def _flat(self, of: Inputs | Gradient) -> Array:
        return np.concatenate([np.ravel(getattr(of, name)[i]) for name, i in self._places] or [np.zeros(0)])

    def inputs(self, x: ArrayLike) -> Inputs:
        """The inputs with these values."""
        x = np.asarray(x, dtype=np.float64)
        if x.shape != self.x.shape:
            raise ValueError(f"x has the shape {x.shape}, but the free inputs have {self.x.shape}")
        made, first = self._inputs.copy(), 0
        for name, i in self._places:
            count = np.size(getattr(made, name)[i])
            getattr(made, name)[i] = x[first : first + count] if name == "controls" else x[first]
            first += count
        return made

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

    def for_jax(self) -> Any:
        """J as a function of a JAX array, with its derivative, also under `jax.jit`."""
        import jax

        if not jax.config.jax_enable_x64:
            raise TypeError('gradients need doubles: call `jax.config.update("jax_enable_x64", True)` first')
        both = (jax.ShapeDtypeStruct((), np.float64), jax.ShapeDtypeStruct(self.x.shape, np.float64))

        def computed(x: Any) -> tuple[Any, Any]:
            value, slope = self(x)
            return np.float64(value), slope

        def forward(x: Any) -> Any:
            return jax.pure_callback(computed, both, x, vmap_method="sequential")

        function: Any = jax.custom_vjp(lambda x: forward(x)[0])
        function.defvjp(forward, lambda slope, factor: (factor * slope,))
        return function

    def for_torch(self) -> Any:
        """J as a function of a PyTorch tensor of doubles, with its derivative."""
        import torch

        def forward(context: Any, x: Any) -> Any:
            value, slope = self(x.detach().cpu().numpy())
            context.save_for_backward(torch.as_tensor(slope, dtype=x.dtype, device=x.device))
            return x.new_tensor(value)

        def backward(context: Any, factor: Any) -> Any:
            return factor * context.saved_tensors[0]

        functions = {"forward": staticmethod(forward), "backward": staticmethod(backward)}
        made: Any = type("Function", (torch.autograd.Function,), functions)
        return made.apply
