"""Handles of the parts of a scene, which are symbols in formulas."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, overload

from ._expression import Expression, Symbol
from ._names import suggestion
from ._words import counted

if TYPE_CHECKING:
    from ._scene import Scene

# The coordinates of joints in space.
OF_JOINTS = ("angle", "first angle", "second angle", "offset", "x", "y", "z", "e0", "e1", "e2", "e3")

Number = float | Expression
Vector = Sequence[Number]


# Of longer lists, only the beginning is shown.
_MOST_SHOWN = 20


def listed(names: Iterable[str]) -> str:
    """Names in a line of text."""
    names = list(names)
    more = len(names) - _MOST_SHOWN
    return ", ".join(names) if more <= 0 else f"{', '.join(names[:_MOST_SHOWN])} and {more} more"


class Coordinate(Symbol):
    """A coordinate q, m or rad."""

    __slots__ = ()
    _QUANTITIES = "; `.v` is the velocity of a coordinate, `.a` its acceleration, `.p` its momentum and `.p_dot` the rate of its momentum"

    @property
    def v(self) -> Symbol:
        """Its velocity."""
        return Symbol("v", self.key, self.scene)

    @property
    def a(self) -> Symbol:
        """Its acceleration (costs, outputs and events)."""
        return Symbol("v_dot", self.key, self.scene)

    @property
    def p(self) -> Symbol:
        """Its augmented momentum p* (costs, outputs and events)."""
        return Symbol("p_star", self.key, self.scene)

    @property
    def p_dot(self) -> Symbol:
        """The rate of its augmented momentum (costs, outputs and events)."""
        return Symbol("p_star_dot", self.key, self.scene)


class Control(Symbol):
    """A control u."""

    __slots__ = ()
    _QUANTITIES = "; `.rate` is the rate of a control"

    @property
    def rate(self) -> Symbol:
        """Its rate within the step (costs and outputs)."""
        return Symbol("u_dot", self.key, self.scene)


class Design(Symbol):
    """A design variable b."""

    __slots__ = ()


class Equation:
    """An equation of a constraint or joint."""

    __slots__ = ("name", "scene")

    def __init__(self, name: str, scene: Scene) -> None:
        self.name, self.scene = name, scene

    @property
    def sigma(self) -> Symbol:
        """Its multiplier σ (impulse, N s or N m s)."""
        return Symbol("sigma", self.name, self.scene)

    @property
    def lam(self) -> Symbol:
        """Its reaction λ = dσ/dt (N or N m)."""
        return Symbol("lambda", self.name, self.scene)

    def __repr__(self) -> str:
        return f"<equation {self.name}>"


class Joint(tuple):  # type: ignore[type-arg]
    """The equations of a part; the coordinates that it has added, such as the angle of a hinge in space, are attributes."""

    name: str
    scene: Scene

    @classmethod
    def of(cls, name: str, scene: Scene) -> Joint:
        count = scene._core.equations(name)
        made = cls(Equation(name if count == 1 else f"{name}.{j}", scene) for j in range(count))
        made.name, made.scene = name, scene
        return made

    def __getattr__(self, attribute: str) -> Coordinate:
        coordinate = f"{self.__dict__.get('name')}.{attribute}"
        if "scene" in self.__dict__ and "coordinate" in self.scene._core.kinds_of(coordinate):
            return Coordinate("q", coordinate, self.scene)
        raise AttributeError(f"there is no coordinate `{coordinate}`{suggestion(coordinate, self._coordinates())}")

    def _coordinates(self) -> list[str]:
        """The names of the coordinates of a joint in space."""
        scene, name = self.__dict__.get("scene"), self.__dict__.get("name")
        if scene is None:
            return []
        return [f"{name}.{of}" for of in OF_JOINTS if "coordinate" in scene._core.kinds_of(f"{name}.{of}")]

    def __reduce__(self) -> Any:
        return Joint.of, (self.name, self.scene)

    def __repr__(self) -> str:
        return f"<{self.name} with {counted(len(self), 'equation')}>"


class Named:
    """An output or an event of a scene."""

    __slots__ = ("name", "scene")

    def __init__(self, name: str, scene: Scene) -> None:
        self.name, self.scene = name, scene

    def __repr__(self) -> str:
        return f"<{type(self).__name__.lower()} {self.name}>"


class Output(Named):
    """A scalar result of a motion, in addition to J."""

    __slots__ = ()


def end_state_names(coordinate: str) -> tuple[str, str]:
    """The names of the outputs of an end state."""
    return f"value of {coordinate} at the end", f"rate of {coordinate} at the end"


class Event(Named):
    """A function of the state whose zero is an event."""

    __slots__ = ()


class Group:
    """Coordinates that belong together; each is an attribute with its name, if this is a Python name."""

    def __init__(self, name: str, coordinates: list[Coordinate]) -> None:
        self.name = name
        self.coordinates = tuple(coordinates)

    def __getattr__(self, name: str) -> Coordinate:
        for coordinate in self.__dict__.get("coordinates", ()):
            if coordinate.key == f"{self.__dict__['name']}.{name}":
                return coordinate
        known = listed(coordinate.name for coordinate in self.__dict__.get("coordinates", ()))
        raise AttributeError(f"there is no coordinate {name!r} here; the coordinates are {known}")

    def __iter__(self) -> Iterator[Coordinate]:
        return iter(self.coordinates)

    def __len__(self) -> int:
        return len(self.coordinates)

    def __getitem__(self, i: int) -> Coordinate:
        return self.coordinates[i]

    def __repr__(self) -> str:
        return f"<{type(self).__name__.lower()} {self.name}: {listed(coordinate.name for coordinate in self.coordinates)}>"


class Point:
    """A point of a body, (x, y) in the body's own frame, m."""

    __slots__ = ("body", "x", "y")

    def __init__(self, body: Frame, x: Any, y: Any) -> None:
        self.body, self.x, self.y = body, x, y

    def __repr__(self) -> str:
        return f"{self.body!r}.at({self.x!r}, {self.y!r})"


class Frame:
    """A body, a particle or the ground, to which parts in the plane can be attached."""

    def at(self, x: Number, y: Number) -> Point:
        """The point (x, y) in the body's own frame, m."""
        return Point(self, x, y)


class Marker:
    """A point of a body in space or of the ground with axes x, y and z, by default those of the body."""

    __slots__ = ("body", "entries")

    def __init__(self, body: SpaceBody | Ground, entries: dict[str, Vector]) -> None:
        self.body, self.entries = body, entries

    def along(self, z: Vector) -> Marker:
        """The marker with its z axis in this direction."""
        return Marker(self.body, {**self.entries, "along": z})

    def along_and_toward(self, z: Vector, x: Vector) -> Marker:
        """The marker with its z axis in one direction and its x axis toward another one."""
        return Marker(self.body, {**self.entries, "along": z, "toward": x})

    def turned(self, rotation: Vector) -> Marker:
        """The marker turned by roll, pitch and yaw, rad: about the axes x, y and z of the body, in this order."""
        return Marker(self.body, {**self.entries, "turned": rotation})

    def __repr__(self) -> str:
        return f"<marker of {self.body!r}: {self.entries}>"


class SpaceBody:
    """A body in space, which a joint carries; on its own it stands for the marker at its origin."""

    def __init__(self, name: str, scene: Scene) -> None:
        self.name, self.scene = name, scene

    def at(self, x: Number, y: Number, z: Number) -> Marker:
        """The marker at the point (x, y, z) in the body's own frame, m."""
        return Marker(self, {"at": (x, y, z)})

    def along(self, z: Vector) -> Marker:
        """The marker at the origin with its z axis in this direction."""
        return Marker(self, {}).along(z)

    def __repr__(self) -> str:
        return f"<body in space {self.name}>"


class Ground(Frame):
    """The inertial frame."""

    name = None
    scene = None

    @overload
    def at(self, x: Number, y: Number) -> Point: ...
    @overload
    def at(self, x: Number, y: Number, z: Number) -> Marker: ...
    def at(self, x: Number, y: Number, z: Number | None = None) -> Point | Marker:
        """The point (x, y) in the plane, or the marker at (x, y, z), m."""
        return Point(self, x, y) if z is None else Marker(self, {"at": (x, y, z)})

    def along(self, z: Vector) -> Marker:
        """The marker at the origin with its z axis in this direction."""
        return Marker(self, {}).along(z)

    def __repr__(self) -> str:
        return "GROUND"

    def __reduce__(self) -> str:
        return "GROUND"


GROUND = Ground()


class Body(Group, Frame):
    """A rigid body in the plane, with the coordinates x, y of its centre of mass and its angle phi."""

    def __init__(self, name: str, scene: Scene) -> None:
        super().__init__(name, [Coordinate("q", f"{name}.{of}", scene) for of in "xyφ"])
        self.scene = scene
        self.x, self.y, self.phi = self.coordinates


class Particle(Group, Frame):
    """A point mass in the plane, with the coordinates x, y."""

    def __init__(self, name: str, scene: Scene) -> None:
        super().__init__(name, [Coordinate("q", f"{name}.{of}", scene) for of in "xy"])
        self.scene = scene
        self.x, self.y = self.coordinates

    def point(self) -> Point:
        """The position of the particle."""
        return Point(self, 0.0, 0.0)
