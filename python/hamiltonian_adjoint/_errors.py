"""Exceptions and warnings."""

from __future__ import annotations

import warnings


class Error(Exception):
    """Base class of all errors of the library. The message states what failed, where, by how much, and what to do."""


class SceneError(Error, ValueError):
    """A scene is wrong: a part, a formula, a name."""


class FileError(Error, ValueError):
    """A file is malformed or cannot be written."""


class InputError(Error, ValueError):
    """Inputs or settings have a wrong size or value."""


class MotionError(Error, ArithmeticError):
    """A motion or its gradient cannot be computed."""


class OptimiseError(Error, ValueError):
    """An optimisation problem is not supported."""


class MotionWarning(UserWarning):
    """Base class of all warnings about a motion, its gradient or an optimisation; each kind has a class of its own, e.g. `GridPhase`."""


_KINDS: dict[str, type[MotionWarning]] = {}


def warning_class(kind: str) -> type[MotionWarning]:
    """The class of warnings of a kind."""
    if kind not in _KINDS:
        _KINDS[kind] = type(kind, (MotionWarning,), {"__module__": __name__, "__doc__": f"The warning `Warning::{kind}` of the library."})
    return _KINDS[kind]


def warn(found: list[tuple[str, str]], stacklevel: int = 3) -> None:
    """Issues each warning once."""
    for kind, message in dict.fromkeys(found):
        warnings.warn(message, warning_class(kind), stacklevel=stacklevel)
