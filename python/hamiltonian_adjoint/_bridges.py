"""Objectives as functions of other libraries, which are imported when they are used."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._errors import MotionError

if TYPE_CHECKING:
    from ._objective import Objective
    from ._system import Array


def jax_function(objective: Objective) -> Any:
    """J as a function of a JAX array."""
    import jax

    if not jax.config.jax_enable_x64:
        raise TypeError('gradients need doubles: call `jax.config.update("jax_enable_x64", True)` first')
    both = (jax.ShapeDtypeStruct((), np.float64), jax.ShapeDtypeStruct(objective.x.shape, np.float64))

    def computed(x: Any) -> tuple[Any, Any]:
        value, slope = objective(x)
        return np.float64(value), slope

    def forward(x: Any) -> Any:
        return jax.pure_callback(computed, both, x, vmap_method="sequential")

    function: Any = jax.custom_vjp(lambda x: forward(x)[0])
    function.defvjp(forward, lambda slope, factor: (factor * slope,))
    return function


def torch_function(objective: Objective) -> Any:
    """J as a function of a PyTorch tensor."""
    import torch

    def forward(context: Any, x: Any) -> Any:
        value, slope = objective(x.detach().cpu().numpy())
        context.save_for_backward(torch.as_tensor(slope, dtype=x.dtype, device=x.device))
        return x.new_tensor(value)

    def backward(context: Any, factor: Any) -> Any:
        return factor * context.saved_tensors[0]

    functions = {"forward": staticmethod(forward), "backward": staticmethod(backward)}
    made: Any = type("Function", (torch.autograd.Function,), functions)
    return made.apply


class IpoptProblem:
    """J and the outputs with the names that cyipopt expects. IPOPT shortens its step if the motion fails."""

    def __init__(self, objective: Objective) -> None:
        import cyipopt

        self._of, self._failure = objective, cyipopt.CyIpoptEvaluationError

    def _evaluated(self, function: Any, *arguments: Any) -> Any:
        try:
            return function(*arguments)
        except MotionError as error:
            raise self._failure(str(error)) from error

    def objective(self, x: Array) -> float:
        """J."""
        return self._evaluated(self._of.value, x)

    def gradient(self, x: Array) -> Array:
        """The gradient of J."""
        return self._evaluated(self._of, x)[1]

    def constraints(self, x: Array) -> Array:
        """The outputs."""
        return self._evaluated(self._of.outputs, x)

    def jacobian(self, x: Array) -> Array:
        """The derivatives of the outputs."""
        return self._evaluated(self._of.jacobian, x)

    def hessian(self, x: Array, multipliers: Array, factor: float) -> Array:
        """The lower triangle of the Hessian of the Lagrangian, row by row."""
        all = self._evaluated(self._of.hessian, x, factor, multipliers)
        return all[np.tril_indices(len(all))]


def casadi_function(objective: Objective, name: str) -> Any:
    """A CasADi function x ↦ (J, outputs) with first and second derivatives. They are NaN if the motion fails."""
    import casadi

    n, m = len(objective.x), len(objective.system.outputs)
    dense, zero = casadi.Sparsity.dense, casadi.Sparsity

    class Callback(casadi.Callback):  # type: ignore[misc]
        """A CasADi function that calls `function` with arrays; `reverse` and `jacobian` make its derivatives."""

        def __init__(self, name: str, inputs: list[Any], outputs: list[Any], function: Any, reverse: Any = None, jacobian: Any = None) -> None:
            casadi.Callback.__init__(self)
            self.inputs, self.outputs, self.function, self.new_reverse, self.new_jacobian = inputs, outputs, function, reverse, jacobian
            # CasADi does not keep the derivatives alive.
            self.derivatives: list[Any] = []
            self.construct(name, {})

        def get_n_in(self) -> int:
            return len(self.inputs)

        def get_n_out(self) -> int:
            return len(self.outputs)

        def get_sparsity_in(self, i: int) -> Any:
            return self.inputs[i]

        def get_sparsity_out(self, i: int) -> Any:
            return self.outputs[i]

        def eval(self, arguments: Any) -> Any:
            try:
                results = self.function(*(of.full().ravel() for of in arguments))
            except MotionError:
                # Solvers of CasADi then shorten their step; for an exception they would print a traceback.
                results = [np.full(shape.shape, np.nan) for shape in self.outputs]
            return [casadi.DM(shape) if shape.nnz() == 0 else casadi.DM(of).reshape(shape.shape) for of, shape in zip(results, self.outputs)]

        def _kept(self, made: Any) -> Any:
            self.derivatives.append(made)
            return made

        def has_reverse(self, count: int) -> bool:
            return self.new_reverse is not None and count == 1

        def get_reverse(self, count: int, name: str, *_: Any) -> Any:
            return self._kept(self.new_reverse(name))

        def has_jacobian(self) -> bool:
            return self.new_jacobian is not None

        def get_jacobian(self, name: str, *_: Any) -> Any:
            return self._kept(self.new_jacobian(name))

    nominal, weighted = [dense(n, 1), dense(1, 1), dense(m, 1)], [dense(1, 1), dense(m, 1)]

    def values(x: Array) -> Any:
        return objective.value(x), objective.outputs(x)

    def jacobian(name: str) -> Any:
        def rows(x: Array, *_: Array) -> Any:
            return objective(x)[1], objective.jacobian(x)

        return Callback(name, nominal, [dense(1, n), dense(m, n)], rows)

    def reverse(name: str) -> Any:
        def pulled_back(x: Array, _value: Array, _outputs: Array, cost: Array, outputs: Array) -> Any:
            return (objective.pull_back(x, cost[0], outputs),)

        return Callback(name, nominal + weighted, [dense(n, 1)], pulled_back, jacobian=second)

    def second(name: str) -> Any:
        def blocks(x: Array, _value: Array, _outputs: Array, cost: Array, outputs: Array, _slope: Array) -> Any:
            return objective.hessian(x, cost[0], outputs), None, None, objective(x)[1], objective.jacobian(x).T

        return Callback(name, [*nominal, *weighted, dense(n, 1)], [dense(n, n), zero(n, 1), zero(n, m), dense(n, 1), dense(n, m)], blocks)

    return Callback(name, [dense(n, 1)], weighted, values, reverse, jacobian)
