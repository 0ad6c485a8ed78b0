"""Writes `hamiltonian_adjoint/_parts.py`: a method for each kind of ready-made parts that the library lists."""

from __future__ import annotations

import pathlib
import runpy
import textwrap

from hamiltonian_adjoint import _hamiltonian_adjoint as core

FILE = pathlib.Path(__file__).parent.parent / "hamiltonian_adjoint" / "_parts.py"
# The descriptions of the kinds, and the kinds whose methods return a Joint.
TEXTS, JOINTS = map(runpy.run_path(str(pathlib.Path(__file__).with_name("part_texts.py"))).get, ("TEXTS", "JOINTS"))

HEAD = '''"""Ready-made parts of a scene. Written by `tools/parts.py`; a test asserts that it is up to date."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from ._functions_of_time import Motion1D
from ._handles import (
    Control,
    Coordinate,
    Equation,
    Event,
    Frame,
    Ground,
    Joint,
    Marker,
    Number,
    Output,
    Particle,
    Point,
    SpaceBody,
    Vector,
)


class Parts:
    """Methods that add ready-made parts. Those of joints and constraints return their equations and coordinates."""

    def _ready(self, kind: str, name: str | Event, given: dict[str, Any]) -> Any:
        raise NotImplementedError
'''


def method_name(kind: str) -> str:
    """The name of the method that adds a part of a kind."""
    return kind.lower().replace(" and ", " ").replace(" ", "_").replace("-", "_")


# Kinds that `Scene` has methods of its own for.
OTHERS = {"body", "particle", "coordinates", "initial value", "control", "design variable", "gravity", "effort", "time", "end state", "reading", "reading time", "reading deviation"}
OTHERS |= {"kinetic energy", "potential energy", "force", "constraint", "cost", "term", "event", "output"}
# The types of entries by their content.
TYPES = {
    "a point of a body in the plane, of a particle or of the ground": "Point | Particle",
    "a body in the plane, a particle or the ground": "Frame",
    "a marker of a body in space or of the ground": "Marker | SpaceBody | Ground",
    "a body in space": "SpaceBody",
    "a number or formula": "Number",
    "the name of a control": "Control",
    "the name of a function of time": "Motion1D",
    "the name of a coordinate": "Coordinate",
    "the name of a coordinate, or a list of coordinates with factors": "Coordinate | Mapping[Coordinate, Number]",
    "the name of a constraint equation": "Equation",
    "names of constraint equations": "Iterable[Equation]",
    "the name of a rule of summation, or the number of a node or an event": "str | dict[str, int]",
    "0, 1, 2 …": "int",
    "true or false": "bool",
    "the name of a quantity of a marker": "str",
}
THREE = "tuple[Output, Output, Output]"
RETURNS = {"body in space": "SpaceBody", "planar body": "SpaceBody", "contact": "Event", "reaction event": "Event", "event time": "Output"}
RETURNS |= {"event impulse": "Output", "outputs of a marker": THREE, "rotation error": THREE, **dict.fromkeys(JOINTS, "Joint")}


def description(title: str) -> str:
    """The documentation of a method, without its quotes."""
    sentence, more = TEXTS[title]
    if not sentence.startswith(("Draws ", "Lets ", "Makes ")):
        sentence = f"Adds {sentence[0].lower()}{sentence[1:]}"
    indent = " " * 8
    first, *rest = textwrap.wrap(sentence, 148, subsequent_indent=indent)
    lines = textwrap.wrap(more, 150, initial_indent=indent, subsequent_indent=indent)
    return "\n".join([first, *rest, *(["", *lines, indent] if lines else [indent] if rest else [])])


def method(kind: tuple[str, list[tuple[str, str, bool]]]) -> str:
    title, all_entries = kind
    # An event that parts belong to comes first, in place of a name.
    of_event = any(name == "name" for name, *_ in all_entries)
    entries = [of for of in all_entries if of[0] not in ("parameters", "name")]
    # What a part acts on comes before its numbers, and what may be missing last.
    entries.sort(key=lambda of: (of[2], "list of coordinates" not in of[1]))
    arguments = [
        f"{name}: {TYPES.get(content, 'Vector')}" + (" | None = None" if is_optional else "") for name, content, is_optional in entries
    ]
    first = "event: Event" if of_event else "name: str"
    given = ", ".join(f'"{name}": {name}' for name, *_ in entries)
    result, all_arguments = RETURNS.get(title, "None"), [first, *arguments]
    head = f"def {method_name(title)}(self, {', '.join(all_arguments)}) -> {result}:"
    if len(head) > 150:
        lines = "".join(f"        {of},\n" for of in ["self", *all_arguments])
        head = f"def {method_name(title)}(\n{lines}    ) -> {result}:"
    add = "self._ready" if result == "None" else "return self._ready"
    return f'''
    {head}
        """{description(title)}"""
        {add}("{title}", {"event" if of_event else "name"}, {{{given}}})
'''


def text() -> str:
    return HEAD + "".join(method(kind) for kind in core.kinds() if kind[0] not in OTHERS)


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8")
