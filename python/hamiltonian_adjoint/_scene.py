"""Scenes: mechanisms as lists of parts, which are written as JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from . import _hamiltonian_adjoint as _core
from ._entries import KINDS, Entries, Parameter, finite
from ._errors import SceneError
from ._expression import Expression
from ._find import found, names_in
from ._formula import WrittenFormula
from ._grid import lengths_of_steps
from ._handles import Body, Control, Coordinate, Design, Event, Group, Joint, Output, Particle, SpaceBody, end_state_names
from ._identify import checked_readings
from ._names import suggestion
from ._parts import Parts
from ._robot import Robot
from ._sums import checked_sum, node
from ._words import counted

if TYPE_CHECKING:
    from ._system import System

Formula = Any


class Scene(Parts):
    """A mechanism under construction.

    Names of parts come first, as in `scene.body("rod", mass=1.0, inertia=0.1, place=(0, 0, 0))`. Every number of a part may be an expression of design
    variables.
    """

    def __init__(self) -> None:
        self._core = _core.Scene()
        # The first element with some text, which elements with the same text are like.
        self._like: dict[tuple[Any, ...], str] = {}

    # Files

    @classmethod
    def from_json(cls, text: str) -> Scene:
        """Reads a scene as `to_json` writes it."""
        _core.Scene.check_json(text)
        scene = cls()
        scene.__setstate__({"parts": [json.dumps(part) for part in json.loads(text.removeprefix("\ufeff"))["parts"]]})
        return scene

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Scene:
        """Reads a scene from a file."""
        with open(path, encoding="utf-8") as file:
            return cls.from_json(file.read())

    def to_json(self) -> str:
        """The scene as JSON, with all formulas."""
        return self._core.to_json()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the scene to a file."""
        text = self.to_json()
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)

    def __getstate__(self) -> dict[str, Any]:
        return {"parts": self._core.parts}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__()  # type: ignore[misc]
        for part in state["parts"]:
            self._core.add(part)

    def copy(self) -> Scene:
        """A scene with the same parts; handles belong to one of the two only."""
        scene = Scene()
        scene.__setstate__(self.__getstate__())
        return scene

    def __repr__(self) -> str:
        parts = self._core.parts
        return f"<scene of {counted(len(parts), 'part')}>"

    def compile(self) -> System:
        """Checks the scene and returns the System to be simulated, on which later changes of the scene have no effect."""
        from ._system import System

        return System._from(self)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            known = [] if name.startswith("_") else [of for of in dir(type(self)) if not of.startswith("_")]
            raise AttributeError(f"a scene has no attribute {name!r}{suggestion(name, known)}")

    # Parts

    def _name(self, name: Any) -> None:
        if not isinstance(name, str):
            raise TypeError(f"the first argument is the name of the part, a string, not {name!r}")

    def _add(self, kind: str, name: str, **fields: Any) -> None:
        self._name(name)
        self._core.add(json.dumps({"kind": kind, "name": name, **fields}, ensure_ascii=False))

    @property
    def _entries(self) -> Entries:
        return Entries(self)

    def coordinates(self, group: str, names: Iterable[str], start: Iterable[float] | None = None) -> Group:
        """Adds coordinates that belong together, m or rad, and their initial values; each is an attribute of the group."""
        names = names.split() if isinstance(names, str) else list(names)
        start = [0.0] * len(names) if start is None else [finite(f"group `{group}`: an initial value", x) for x in start]
        if len(start) != len(names):
            raise SceneError(f"group `{group}`: {counted(len(start), 'initial value')} for {counted(len(names), 'coordinate')}")
        self._add("coordinates", group, coordinates=names)
        made = [Coordinate("q", f"{group}.{name}", self) for name in names]
        for coordinate, value in zip(made, start):
            if value:
                self.place(coordinate, value)
        return Group(group, made)

    def place(self, coordinate: Coordinate | str, value: float) -> None:
        """Sets the initial value of a coordinate, m or rad."""
        name = coordinate if isinstance(coordinate, str) else self._entries.own(coordinate).name
        self._add("initial value", name, value=finite(f"the initial value of `{name}`", value))

    def initial(self, coordinate: Coordinate | str) -> float:
        """The initial value of a coordinate, m or rad."""
        name = coordinate if isinstance(coordinate, str) else coordinate.name
        value = self._core.initial(name)
        if value is None:
            raise SceneError(f"no coordinate `{name}`{suggestion(name, names_in(self, 'coordinate'))}")
        return value

    def control(self, name: str) -> Control:
        """Adds a control."""
        self._add("control", name)
        return Control("u", name, self)

    def design(self, name: str, value: float) -> Design:
        """Adds a design variable with its value; use it in place of a number."""
        self._name(name)
        if "`" in name:
            raise SceneError(f"design variable {name!r}: its name must not contain a backtick, which encloses names in formulas")
        self._add("design variable", name, value=finite(f"the value of design variable `{name}`", value))
        return Design("b", name, self)

    def gravity(self, x: Parameter, y: Parameter, z: Parameter = 0.0) -> None:
        """Sets the acceleration of gravity, m/s²; the default is zero."""
        self._add("gravity", "gravity", **self._entries.parameters("gravity", x=x, y=y, z=z))

    def body(self, name: str, mass: Parameter, inertia: Parameter, place: Iterable[float] = (0.0, 0.0, 0.0)) -> Body:
        """Adds a rigid body with its mass (kg), moment of inertia about its centre (kg m²) and initial position x, y, φ."""
        self._add("body", name, **self._entries.parameters(f"body `{name}`", mass=mass, inertia=inertia), place=self._entries.start(name, place, 3))
        return Body(name, self)

    def particle(self, name: str, mass: Parameter, place: Iterable[float] = (0.0, 0.0)) -> Particle:
        """Adds a particle with its mass (kg) and initial position x, y."""
        self._add("particle", name, **self._entries.parameters(f"particle `{name}`", mass=mass), place=self._entries.start(name, place, 2))
        return Particle(name, self)

    def _ready(self, kind: str, name: str | Event, given: dict[str, Any]) -> Any:
        """Adds a ready-made part of a kind."""
        fields = self._entries.ready(kind, name.name if isinstance(name, Event) else name, given)
        of_event = any(entry == "name" for entry, *_ in KINDS[kind])
        title = self._entries.handle("event", name, Event, "an event of the scene") if of_event else str(name)
        self._add(kind, title, **fields)
        made: dict[str, Callable[[str, Scene], Any]] = {
            "body in space": SpaceBody,
            "planar body": SpaceBody,
            "contact": Event,
            "reaction event": Event,
            "event time": Output,
            "event impulse": Output,
            "outputs of a marker": self._three_outputs,
            "rotation error": self._three_outputs,
        }
        return made.get(kind, Joint.of)(title, self)

    @staticmethod
    def _three_outputs(name: str, scene: Scene) -> tuple[Output, Output, Output]:
        """The outputs of a vector."""
        return Output(f"{name} x", scene), Output(f"{name} y", scene), Output(f"{name} z", scene)

    # Formulas

    def _formula(self, kind: str, name: str, formula: Formula, lists: Mapping[str, Iterable[Any]], **fields: Any) -> None:
        """Adds a part with a formula, whose lists begin with these."""
        self._name(name)
        written = WrittenFormula(self._entries, kind, name, formula, **lists)
        if kind in ("kinetic energy", "potential energy", "force", "constraint") and written.key in self._like:
            fields["like"] = self._like[written.key]
        self._add(kind, name, **fields, **written.fields)
        self._like.setdefault(written.key, name)

    def kinetic_energy(self, name: str, formula: Formula, q: Iterable[Coordinate] = (), b: Iterable[Parameter] = ()) -> None:
        """Adds a kinetic energy T(q, v; b), J."""
        self._formula("kinetic energy", name, formula, {"q": q, "b": b})

    def potential_energy(self, name: str, formula: Formula, q: Iterable[Coordinate] = (), b: Iterable[Parameter] = ()) -> None:
        """Adds a potential energy V(q, t; b), J."""
        self._formula("potential energy", name, formula, {"q": q, "b": b})

    def force(
        self,
        name: str,
        formula: Mapping[Coordinate, Any] | Formula,
        q: Iterable[Coordinate] = (),
        u: Iterable[Control] = (),
        b: Iterable[Parameter] = (),
    ) -> None:
        """Adds a generalized force Q(q, v, u, t; b), N or N m.

        Give a formula for each coordinate that the force acts on, `{x: -0.1 * x.v}`, or a list of formulas, or a function, with these coordinates as `q`.
        """
        q = list(q)
        if isinstance(formula, Mapping):
            if q:
                raise TypeError(f"force `{name}`: its coordinates are the keys of the formulas, so that `q` is not needed")
            for x in formula:
                if not isinstance(x, Coordinate):
                    raise TypeError(f"force `{name}`: the keys of its formulas must be coordinates, not {x!r}")
            q, formula = list(formula), list(formula.values())
        if not q:
            raise TypeError(f"force `{name}`: state the coordinates that it acts on, as {{x: formula, y: formula}} or by q=[x, y] in the order of the formulas")
        self._formula("force", name, formula, {"q": q, "u": u, "b": b})

    def constraint(self, name: str, formula: Formula, q: Iterable[Coordinate] = (), b: Iterable[Parameter] = ()) -> Joint:
        """Adds constraints Φ(q, t; b) = 0, m or rad, and returns their equations."""
        self._formula("constraint", name, formula, {"q": q, "b": b})
        return Joint.of(name, self)

    def cost(self, name: str, formula: Formula, sum: str | dict[str, int], **lists: Any) -> None:
        """Adds a cost to J, with its sum over the nodes: 'integral', 'terminal', 'trapezoidal', 'rectangle', 'plain', 'all nodes', node(i)."""
        self._formula("cost", name, formula, lists, sum=checked_sum(sum))

    def output(self, name: str, formula: Formula = None, sum: str | dict[str, int] | None = None, **lists: Any) -> Output:
        """Adds an output, and its first term if a formula is given."""
        if formula is not None and sum is None:
            raise TypeError(f"output `{name}`: the sum of its formula is missing, for example sum='terminal'")
        self._add("output", name)
        made = Output(name, self)
        if formula is not None:
            self.term(made, name, formula, sum, **lists)
        return made

    def outputs_at(self, name: str, formula: Formula, nodes: Iterable[int], **lists: Any) -> list[Output]:
        """Adds an output for a formula at each of these nodes, for example `range(101)`, called `name at node 0` and so on.

        With these outputs, limits along the motion are constraints of an optimum: `constraints=dict.fromkeys(outputs, (least, most))`.
        """
        if not isinstance(nodes, Iterable):
            raise TypeError(f"`nodes` must be a list of nodes, such as range(51), not {nodes!r}")
        given = {of: list(entries) for of, entries in lists.items()}
        return [self.output(f"{name} at node {at}", formula, sum=node(at), **given) for at in nodes]

    def term(self, output: Output | str, name: str, formula: Formula, sum: str | dict[str, int] | None, **lists: Any) -> None:
        """Adds a term to an output."""
        of = output if isinstance(output, str) else self._entries.own(output).name
        self._formula("term", name, formula, lists, sum=checked_sum(sum), output=of)

    def event(self, name: str, formula: Formula, **lists: Any) -> Event:
        """Adds an event: the zero of a function of the state."""
        self._formula("event", name, formula, lists)
        return Event(name, self)

    def effort(self, name: str, control: Control, weight: Parameter) -> None:
        """Adds the effort w ∫ u² dt of a control to J."""
        self._add("effort", name, control=self._entries.own(control).name, **self._entries.parameters(f"effort `{name}`", weight=weight))

    def time(self, name: str, weight: Parameter) -> None:
        """Adds the cost w T of the duration."""
        self._add("time", name, **self._entries.parameters(f"time `{name}`", weight=weight))

    def end_state(self, coordinate: Coordinate) -> tuple[Output, Output]:
        """Adds a coordinate and its velocity at the end as outputs; optimisers leave them free unless they are constrained."""
        name = self._entries.own(coordinate).name
        self._add("end state", name)
        position, rate = end_state_names(name)
        return Output(position, self), Output(rate, self)

    def reading(self, name: str, coordinate: Coordinate, node: int, value: float, weight: float) -> None:
        """Adds the output w (q − value) of a coordinate at a node, for fits to measurements."""
        self._add("reading", name, coordinate=self._entries.own(coordinate).name, node=int(node), value=float(value), weight=float(weight))

    def reading_time(self, name: str, node: int, time: float) -> None:
        """Records the time of a reading at a node, s. Fits reject inputs whose node is at another time."""
        self._add("reading time", name, node=int(node), time=float(time))

    def reading_deviation(self, name: str, deviation: float) -> None:
        """States that an output is the difference of a quantity and a reading, divided by the known standard deviation of the reading, so that fits test χ²."""
        self._add("reading deviation", name, deviation=float(deviation))

    def readings(
        self,
        name: str,
        quantity: Expression,
        times: ArrayLike,
        values: ArrayLike,
        *,
        deviation: ArrayLike,
        steps: int | ArrayLike,
        dt: float | None = None,
        t0: float = 0.0,
    ) -> list[Output]:
        """Adds an output (quantity − value) / deviation for each reading of a quantity, a coordinate or a formula such as `x.v` or `rope[0].lam`.

        `deviation` is the standard deviation of the random error, in the unit of the quantity, or one for each reading. A fit by 'Levenberg-Marquardt' gives
        two kinds of errors of what it determines. If the deviations are known, as from the data sheet of a sensor, `absolute_errors` are right; if only
        their ratios are known, or all are 1, `standard_errors`, which the scatter of the readings about the fit determines. Both are
        about equal if `chi_squared` is about `degrees_of_freedom`. If it is improbable for a correct model, a fit warns, unless a deviation is 1,
        which says that it is not known.

        `steps`, `dt` and `t0` are the grid of the motion, whose nodes must include the
        times of the readings, s (`steps_through`); inputs with nodes at other times are rejected. The output of reading i is called `name.i`.
        """
        t, x, s = checked_readings(name, times, values, deviation)
        nodes = _core.nodes_of_readings(name, t.tolist(), lengths_of_steps(steps, dt).tolist(), float(t0))
        outputs = [Output(f"{name}.{i}", self) for i in range(len(t))]
        for output, at, time, value, weight in zip(outputs, nodes, t.tolist(), x.tolist(), (1.0 / s).tolist()):
            if isinstance(quantity, Coordinate):
                self.reading(output.name, quantity, at, value, weight)
            else:
                self.output(output.name, lambda of: (quantity - of.b[0]) * of.b[1], sum=node(at), b=[value, weight])
                if weight != 1.0:
                    self.reading_deviation(output.name, 1.0 / weight)
            self.reading_time(output.name, at, time)
        return outputs

    # Robots

    def robot(
        self,
        urdf: str | os.PathLike[str],
        *,
        floating: bool = False,
        locked: Mapping[str, float] | None = None,
        prefix: str = "",
        damping: bool = False,
        ignore_mimic: bool = False,
        accept_impossible_inertias: bool = False,
    ) -> Robot:
        """Adds the links and joints of a URDF file, given by its path or as text, as bodies and joints in space.

        The base is fixed at the origin unless it is `floating`. `locked` joints keep a value, rad or m. `prefix` begins the names of all parts, for several
        robots in one scene. With `damping` the joints have that of the file. Limits, friction and efforts have no effect on the motion.
        """
        text = os.fspath(urdf)
        if "<" not in text:
            with open(text, encoding="utf-8-sig") as file:
                text = file.read()
        numbers = [(name, float(value)) for name, value in (locked or {}).items()]
        parts, attributes = _core.robot(text, floating, numbers, prefix, damping, ignore_mimic, accept_impossible_inertias)
        added = json.loads(parts)["parts"]
        for name in (part["name"] for part in added):
            if {"body in space", "joint"} & set(self._core.kinds_of(name)):
                raise SceneError(f"the scene has a body or joint `{name}` already; begin the names of this robot otherwise, for example by prefix='left '")
        self._core.extend([json.dumps(part) for part in added])
        return Robot(self, prefix, attributes)

    # Names

    def find(self, name: str, kind: str | None = None) -> Any:
        """The handle of what has this name; `kind` chooses between a coordinate, control, design variable, body, output, event, constraint, joint."""
        return found(self, name, kind)

    def __getitem__(self, name: str) -> Any:
        return self.find(name)


def cart_pendulum(links: int = 3) -> Scene:
    """The paper's example: a cart with links that hang from it, a force on the cart, and the cost of swinging them up."""
    return Scene.from_json(_core.cart_pendulum(links))
