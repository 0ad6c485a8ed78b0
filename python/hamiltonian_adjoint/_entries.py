"""Entries of the parts of a scene: numbers, points, axes and names, as they are written in JSON."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _hamiltonian_adjoint as _core
from ._errors import SceneError
from ._expression import Expression, Symbol, operand, write
from ._functions_of_time import Motion1D
from ._handles import GROUND, Control, Coordinate, Design, Equation, Event, Frame, Marker, Particle, Point, SpaceBody
from ._sums import checked_sum

if TYPE_CHECKING:
    from ._scene import Scene

Parameter = Any

# The entries of the kinds of parts.
KINDS = dict(_core.kinds())


def finite(what: str, value: Any) -> float:
    """A number that may not be a formula."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{what} must be a number, not {value!r}") from None
    if not math.isfinite(number):
        raise SceneError(f"{what} is {number}; it must be finite")
    return number


class Entries:
    """Writes the entries of parts of a scene."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene

    def own(self, symbol: Any) -> Any:
        """The handle, if it belongs to the scene."""
        if symbol.scene is not None and symbol.scene is not self._scene:
            raise SceneError(f"`{symbol.name}` belongs to another scene; use handles of the scene that the part is added to")
        return symbol

    def parameter(self, x: Parameter) -> float | str:
        """A number, or an expression of design variables as text."""
        x = operand(x)
        if not isinstance(x, Expression):
            return x

        def name(symbol: Symbol) -> str:
            if not isinstance(self.own(symbol), Design):
                raise SceneError(f"`{symbol.label}` changes during the motion: a number of a ready-made part may depend on design variables only")
            return f"`{symbol.name}`"

        parts, results = write([x], name)
        return "; ".join(parts + results)

    def _located(self, part: str, entry: str, make: Callable[[], Any]) -> Any:
        """An entry of a part; errors start with the names of both."""
        try:
            return make()
        except ValueError as error:
            raise SceneError(f"{part}, `{entry}`: {error}") from None

    def parameters(self, part: str, **entries: Parameter) -> dict[str, float | str]:
        """Numbers of a part."""
        return {entry: self._located(part, entry, lambda: self.parameter(value)) for entry, value in entries.items()}

    def start(self, name: str, place: Iterable[float], count: int) -> list[float]:
        """The initial position of a body in the plane."""
        numbers = [finite(f"body `{name}`: a number of `place`", x) for x in place]
        if len(numbers) != count:
            raise SceneError(f"body `{name}`: `place` has {len(numbers)} numbers, but the body has {count} coordinates: {'x, y, φ' if count == 3 else 'x, y'}")
        return numbers

    def _place(self, what: str, at: Any) -> dict[str, Any]:
        """A point of the plane."""
        at = at.point() if isinstance(at, Particle) else at
        if not isinstance(at, Point):
            raise TypeError(f"`{what}` must be a point, such as rod.at(0.5, 0) or GROUND.at(0, 0), not {at!r}")
        return {**self._body(at.body), "at": self._vector((at.x, at.y))}

    def _frame(self, what: str, at: Any) -> dict[str, Any]:
        """A body in the plane."""
        if not isinstance(at, Frame):
            raise TypeError(f"`{what}` must be a body or GROUND, not {at!r}")
        return self._body(at)

    def _marker(self, what: str, at: Any) -> dict[str, Any]:
        """A marker in space."""
        at = Marker(at, {}) if isinstance(at, SpaceBody) or at is GROUND else at
        if not isinstance(at, Marker):
            raise TypeError(f"`{what}` must be a marker, such as arm.at(0, 0, 0.5) or GROUND.at(0, 0, 1).along((1, 0, 0)), not {at!r}")
        return {**self._body(at.body), **{name: self._vector(of) for name, of in at.entries.items()}}

    def _body(self, of: Any) -> dict[str, Any]:
        """The body of a point or marker; the ground has no name."""
        return {} if of is GROUND else {"body": self.own(of).name}

    def _vector(self, of: Iterable[Parameter]) -> list[float | str]:
        return [self.parameter(x) for x in of]

    def handle(self, what: str, of: Any, kind: type, example: str) -> str:
        """The name of a handle."""
        if not isinstance(of, kind):
            raise TypeError(f"`{what}` must be {example}, not {of!r}")
        return self.own(of).name

    @staticmethod
    def _list(what: str, of: Any) -> list[Any]:
        """Several equations."""
        if not isinstance(of, Iterable):
            raise TypeError(f"`{what}` must be a list of equations, such as [joint[0]], or a joint with all its equations, not {of!r}")
        return list(of)

    def _axis(self, what: str, of: Any) -> Any:
        """A coordinate, or coordinates with factors."""
        if not isinstance(of, Mapping):
            return self.handle(what, of, Coordinate, "a coordinate, or coordinates with factors {x: 1, y: -2}")
        name = "a coordinate"
        return [{"coordinate": self.handle(what, x, Coordinate, name), "factor": self.parameter(factor)} for x, factor in of.items()]

    def _entry(self, what: str, content: str, value: Any) -> Any:
        """An entry of a ready-made part, by the description of its content."""
        one, _, sort = content.partition(" ")
        if one.isdigit():
            if np.size(value) != int(one):
                raise TypeError(f"`{what}` must have {content}, not {value!r}")
            return [float(x) for x in value] if sort == "numbers" else self._vector(value)
        equation = "an equation, such as joint[0]"
        convert: dict[str, Callable[[], Any]] = {
            "a point of a body in the plane, of a particle or of the ground": lambda: self._place(what, value),
            "a body in the plane, a particle or the ground": lambda: self._frame(what, value),
            "a marker of a body in space or of the ground": lambda: self._marker(what, value),
            "a body in space": lambda: self._body(self.own(value)),
            "a number or formula": lambda: self.parameter(value),
            "the name of a control": lambda: self.handle(what, value, Control, "a control, such as scene.control('force')"),
            "the name of a coordinate": lambda: self.handle(what, value, Coordinate, "a coordinate"),
            "the name of a coordinate, or a list of coordinates with factors": lambda: self._axis(what, value),
            "the name of a constraint equation": lambda: self.handle(what, value, Equation, equation),
            "names of constraint equations": lambda: [self.handle(what, of, Equation, equation) for of in self._list(what, value)],
            "the name of a rule of summation, or the number of a node or an event": lambda: checked_sum(value),
            "0, 1, 2 …": lambda: int(value),
            "a number": lambda: float(value),
            "true or false": lambda: bool(value),
            "the name of a quantity of a marker": lambda: value,
        }
        return convert[content]()

    def ready(self, kind: str, name: str, given: dict[str, Any]) -> dict[str, Any]:
        """The entries of a ready-made part of a kind."""
        fields: dict[str, Any] = {}
        for entry, content, _ in KINDS[kind]:
            if entry == "motion":
                motion = given["motion"]
                if not isinstance(motion, Motion1D):
                    raise TypeError(f"`motion` must be constant(…), constant_speed(…) or harmonic(…), not {motion!r}")
                fields |= {"motion": motion.kind, "parameters": self._vector(motion.parameters)}
            elif given.get(entry) is not None:
                value = given[entry]
                fields[entry] = self._located(f"{kind} `{name}`", entry, lambda: self._entry(entry, content, value))
        return fields
