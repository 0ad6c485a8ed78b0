"""Robots from URDF files."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from ._errors import SceneError
from ._handles import Control, Coordinate, Joint, SpaceBody, listed
from ._names import suggestion

if TYPE_CHECKING:
    from ._scene import Scene


class JointData(NamedTuple):
    """Limits of a joint in its file, which have no effect on the motion, its damping and its friction; None if the file has no such number."""

    lower: float | None
    upper: float | None
    velocity: float | None
    effort: float | None
    damping: float
    friction: float


class Links(dict[str, SpaceBody]):
    """The bodies of a robot by the names of its links."""

    def __missing__(self, name: str) -> SpaceBody:
        raise KeyError(f"the robot has no link `{name}`{suggestion(name, self)}")


class Robot:
    """The parts of a scene that belong to a robot, by their names in the URDF file: `robot["shoulder"].angle`.

    `joints` are the joints that move, in the order of their coordinates, `links` the bodies, whose frames are those of the links, and `base` is the joint
    of a floating base. `data` contains numbers of the joints that are not used, `locked` the values of joints that do not move, and `followers` the
    joints that mimic others, with the other joint, the factor and the offset.
    """

    def __init__(self, scene: Scene, prefix: str, attributes: dict[str, Any]) -> None:
        self.scene, self._prefix = scene, prefix
        self.joints = {name: Joint.of(prefix + name, scene) for name in attributes["joints"]}
        self.links = Links((name, SpaceBody(prefix + name, scene)) for name in attributes["links"])
        self.base = Joint.of(f"{prefix}base", scene) if attributes["is_floating"] else None
        self.data = {name: JointData(*(limit or (None,) * 4), *rest) for name, (_, limit, *rest) in attributes["joints"].items()}
        self.locked: dict[str, float] = dict(attributes["locked"])
        self.followers: dict[str, tuple[str, float, float]] = dict(attributes["followers"])
        self._counts = {name: count for name, (count, *_) in attributes["joints"].items()}

    @property
    def coordinates(self) -> list[Coordinate]:
        """The coordinates of all joints with one coordinate, rad or m."""
        return [self._only(joint) for name, joint in self.joints.items() if self._counts[name] == 1]

    @staticmethod
    def _only(joint: Joint) -> Coordinate:
        return joint.angle if hasattr(joint, "angle") else joint.offset

    def drive(self) -> list[Control]:
        """Adds a control for every joint with one coordinate, its torque, N m, or its force, N, in the order of `coordinates`; it has the name of the joint."""
        names = [coordinate.name.rpartition(".")[0] for coordinate in self.coordinates]
        if taken := [name for name in names if "control" in self.scene._core.kinds_of(name)]:
            raise SceneError(f"the scene has a control `{taken[0]}` already; `drive` is called once for each robot")
        made = []
        for coordinate in self.coordinates:
            name = coordinate.name.rpartition(".")[0]
            made.append(self.scene.control(name))
            self.scene.motor(f"drive of {name}", coordinate, made[-1])
        return made

    def __getitem__(self, name: str) -> Joint:
        if name not in self.joints:
            raise KeyError(f"the robot has no moving joint `{name}`; its joints are {listed(self.joints)}{suggestion(name, self.joints, 0)}")
        return self.joints[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.joints)

    def __len__(self) -> int:
        return len(self.joints)

    def __repr__(self) -> str:
        return f"<robot: {len(self.links)} links; joints {listed(self.joints)}>"
