"""Exceptions and warnings."""

from __future__ import annotations

import re
import warnings
from typing import Any


class Error(Exception):
    """Base class of all errors of the library. The message states what failed, where, by how much, and what to do."""


class SceneError(Error, ValueError):
    """A scene is wrong: a part, a formula, a name."""


class FileError(Error, ValueError):
    """A file is malformed or cannot be written."""


class InputError(Error, ValueError):
    """Inputs or settings have a wrong size or value."""


class MotionError(Error, ArithmeticError):
    """A motion, its gradient, or a quantity of a state such as an equilibrium cannot be computed."""


class OptimiseError(Error, ValueError):
    """An optimisation problem is not supported."""


class MotionWarning(UserWarning):
    """Base class of all warnings about a motion, its gradient or an optimisation; each kind has a class of its own, e.g. `GridPhase`."""

    def __reduce__(self) -> Any:
        # Classes of kinds are made when they are needed.
        return _warning, (type(self).__name__, self.args)


_KINDS: dict[str, type[MotionWarning]] = {}


def warning_class(kind: str) -> type[MotionWarning]:
    """The class of warnings of a kind."""
    if kind not in _KINDS:
        _KINDS[kind] = type(kind, (MotionWarning,), {"__module__": __name__, "__doc__": f"A warning of the kind {kind}."})
    return _KINDS[kind]


def _warning(kind: str, arguments: tuple[Any, ...]) -> MotionWarning:
    return warning_class(kind)(*arguments)


def warn(found: list[tuple[str, str]], stacklevel: int = 3) -> None:
    """Issues each warning once."""
    for kind, message in dict.fromkeys(found):
        warnings.warn(message, warning_class(kind), stacklevel=stacklevel)


# What messages of the library say, and what to write in Python instead.
_IN_PYTHON = {
    "correct q0, ": "correct `inputs.q`, ",
    "correct v0, ": "correct `inputs.v`, ",
    "`Start::assembled`": "`inputs.assemble()`",
    "`Start::hold`": "`inputs.assemble(coordinate)`",
    "`Mechanics::at_start` of a start assembled from a guess (`Start::Assembled`)": "`ha.Mechanics.at_start(system, inputs.assemble())`",
    "use a `Start` with": "use a start with",
    ", without costs on du/dt, and not in the paper's equations": ", without costs on rates of controls",
    "give points with `at`": "give points as `x`",
    "`Gradient::frozen`": "`gradient.frozen`",
    "`Grid::stages`": "`inputs.stages`",
    "`Grid::through`": "`steps_through`",
    "`Inertia::unchecked`": "`unchecked=True`",
    "`Interval::FREE`": "`None`",
    "`Scene::open_at`": "`scene.open_at_event`",
    "`Scene::close_at`": "`scene.close_at_event`",
    "`Scheme::TRAPEZOIDAL`": "the scheme 'trapezoidal rule'",
    "`Solver::inputs`": "`motion.inputs`",
    "`Spatial::cut`": "`scene.cut`",
    "`Sum::Node`": "`sum=node(i)`",
    "`Sum::Node(N)`": "`sum=node(N)`",
    "`Sum::Event`": "`sum=at_event(i)`",
    "`Sum::Terminal`": "`sum='terminal'`",
    "`check::Input::all` lists all inputs": "`system.controls`, `system.designs` and `system.coordinates` list all inputs",
    "`check::hessian`": "`check_gradient`",
    "`constrain`": "`constraints`",
    "call `minimise` for it": "list it in `costs`",
    "`lbfgs`": "'L-BFGS'",
    "`interior_point`": "'interior point'",
    "`augmented_lagrangian`": "'augmented Lagrangian'",
    "`levenberg_marquardt`": "'Levenberg-Marquardt'",
}
# The same for members of classes; of a class that is not listed the name of the member remains.
_MEMBERS = {"Inputs": "`inputs.{}`", "Solver": "`solver.{}`", "Scene": "`scene.{}`", "Settings": "`{}` of the settings"}


def in_python(message: str) -> str:
    """A message of the library with the names that its items have in Python."""
    for name, here in _IN_PYTHON.items():
        message = message.replace(name, here)
    return re.sub(r"`(\w+(?:::\w+)*)::(\w+)`", lambda of: _MEMBERS.get(of[1], "`{}`").format(of[2]), message)
