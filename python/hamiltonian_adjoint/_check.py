"""Checks of gradients and of Jacobians derived by hand."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _hamiltonian_adjoint as _core
from ._expression import Symbol, operand, write
from ._handles import Output
from ._solver import _checked
from ._system import Inputs, System


class Report:
    """The result of a check: `passed`, the `verdict` in a word, and a `text` that locates and explains mistakes."""

    def __init__(self, passed: bool, verdict: str, text: str) -> None:
        self.passed, self.verdict, self.text = passed, verdict, text

    def assert_passed(self) -> None:
        """Raises an AssertionError with the text unless everything is right."""
        if not self.passed:
            raise AssertionError(f"\n{self.text}")

    def __bool__(self) -> bool:
        return self.passed

    def __repr__(self) -> str:
        return self.text


def check_gradient(
    system: System,
    inputs: Inputs,
    *,
    output: Output | str | None = None,
    complete: bool = False,
    tolerance: float = 1e-9,
    directions: int = 1,
    seed: int = 1,
    **settings: Any,
) -> Report:
    """Compares the gradient of J, or of an output, by the adjoint with direct differentiation, complex step and differences.

    The comparison is along random directions of the inputs; `complete` compares every single input, too.
    """
    checked = _checked(inputs, system)
    name = None if output is None else system._named("output", system.outputs, output)
    return Report(*_core.check_gradient(system, checked, name, complete, tolerance, directions, seed, **settings))


def check(
    function: Callable[[Any], Any],
    jacobian: Callable[[np.ndarray], ArrayLike],
    x: ArrayLike,
    *,
    names: Iterable[str] | None = None,
    outputs: Iterable[str] | None = None,
    random_points: int = 12,
    magnitudes: ArrayLike | None = None,
    seed: int = 1,
) -> Report:
    """Checks a Jacobian that was derived by hand, and names the likely mistake.

    `function(x)` returns a list of formulas of the array x, as for costs and forces; `jacobian(x)` returns a matrix with one row for each of them. They
    are compared at the point x (or at several points, one in each row), and at random points of the given magnitudes.
    """
    points = np.atleast_2d(np.asarray(x, dtype=np.float64))
    n = points.shape[1]
    symbols = np.empty(n, dtype=object)
    symbols[:] = [Symbol("x", i) for i in range(n)]
    results = [operand(y) for y in np.atleast_1d(np.asarray(function(symbols), dtype=object))]
    texts = write(results, lambda symbol: f"x[{symbol.key}]")

    def hand(point: np.ndarray) -> np.ndarray:
        return np.atleast_2d(np.asarray(jacobian(point), dtype=np.float64))

    given = [f"x[{i}]" for i in range(n)] if names is None else list(names)
    rows = [f"f[{i}]" for i in range(len(results))] if outputs is None else list(outputs)
    sizes = np.ones(n) if magnitudes is None else np.asarray(magnitudes, dtype=np.float64)
    return Report(*_core.check_function(texts, (given, rows), hand, points.tolist(), (random_points, seed), sizes.tolist()))
