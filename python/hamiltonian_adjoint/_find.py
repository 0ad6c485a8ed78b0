"""Handles of the parts of a scene by their names."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ._handles import OF_JOINTS, Body, Control, Coordinate, Design, Event, Joint, Output, Particle, SpaceBody
from ._names import suggestion

if TYPE_CHECKING:
    from ._scene import Scene


def found(scene: Scene, name: str, kind: str | None) -> Any:
    """The handle of what has this name and, if it is given, this kind."""
    kinds = [of for of in scene._core.kinds_of(name) if kind in (None, of)]
    # A body in the plane has coordinates, too, and a control may have the name of its joint.
    kinds = [of for of in kinds if of != "joint"] or kinds
    if not kinds:
        raise KeyError(f"the scene has no {kind or 'part with the name'} `{name}`{suggestion(name, names_in(scene, kind))}")
    if len(kinds) > 1:
        raise KeyError(f"`{name}` is the name of {' and of '.join(_one(of) for of in kinds)}: choose by scene.find({name!r}, {kinds[0]!r})")
    makers: dict[str, Callable[[], Any]] = {
        "coordinate": lambda: Coordinate("q", name, scene),
        "control": lambda: Control("u", name, scene),
        "design variable": lambda: Design("b", name, scene),
        "body": lambda: (Body if "coordinate" in scene._core.kinds_of(f"{name}.φ") else Particle)(name, scene),
        "body in space": lambda: SpaceBody(name, scene),
        "output": lambda: Output(name, scene),
        "event": lambda: Event(name, scene),
        "constraint": lambda: Joint.of(name, scene),
        "joint": lambda: Joint.of(name, scene),
    }
    return makers[kinds[0]]()


def names_in(scene: Scene, kind: str | None = None) -> list[str]:
    """The names of a scene, or those of a kind."""
    parts = [json.loads(part) for part in scene._core.parts]
    names = [part["name"] for part in parts]
    names += [f"{part['name']}.{of}" for part in parts for of in (*part.get("coordinates", ()), "φ", *OF_JOINTS)]
    names += [f"{part['name']} {of}" for part in parts for of in "xyz"]
    return [name for name in dict.fromkeys(names) if (kind in scene._core.kinds_of(name) if kind else scene._core.kinds_of(name))]


def _one(kind: str) -> str:
    """A kind with its article."""
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"
