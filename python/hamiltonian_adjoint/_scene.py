"""Scenes: mechanisms as lists of parts, which are written as JSON."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from . import _hamiltonian_adjoint as _core
from ._errors import SceneError
from ._expression import Expression, Symbol, operand, t, write
from ._grid import lengths_of_steps
from ._handles import (
    GROUND,
    OF_JOINTS,
    Body,
    Control,
    Coordinate,
    Design,
    Equation,
    Event,
    Frame,
    Group,
    Joint,
    Marker,
    Motion1D,
    Output,
    Particle,
    Point,
    SpaceBody,
    end_state_names,
)
from ._identify import checked_readings
from ._names import suggestion
from ._parts import Parts
from ._robot import Robot
from ._words import counted

if TYPE_CHECKING:
    from ._system import System

# The lists of a scene file that the lists of formulas number.
_FIELDS = {"q": "q", "v": "q", "v_dot": "q", "p_star": "q", "p_star_dot": "q", "sigma": "sigma", "lambda": "sigma", "u": "u", "u_dot": "u", "b": "b"}
_OF_FUNCTIONS = tuple(_FIELDS) + ("t",)
# The lists that a formula of each kind may read.
_ALLOWED = {
    "kinetic energy": ("q", "v", "b"),
    "potential energy": ("q", "b", "t"),
    "force": ("q", "v", "u", "b", "t"),
    "constraint": ("q", "b", "t"),
    "cost": _OF_FUNCTIONS,
    "term": _OF_FUNCTIONS,
    "event": _OF_FUNCTIONS,
}
_WORDS = {
    "q": "coordinates",
    "v": "velocities",
    "v_dot": "accelerations",
    "p_star": "momenta",
    "p_star_dot": "rates of momenta",
    "sigma": "multipliers",
    "lambda": "reactions",
    "u": "controls",
    "u_dot": "rates of controls",
    "b": "design variables",
    "t": "the time",
}
_SUMS = ("plain", "all nodes", "rectangle", "trapezoidal", "integral", "terminal")

Formula = Any
Parameter = Any


class At:
    """What a formula that is given as a function is evaluated with: lists of expressions, and the time t."""

    def __init__(self, q: list[Coordinate], sigma: list[Equation], u: list[Control], b: list[Symbol]) -> None:
        self.q, self.u, self.b, self.t = q, u, b, t
        self.v = [x.v for x in q]
        self.a = [x.a for x in q]
        self.p = [x.p for x in q]
        self.p_dot = [x.p_dot for x in q]
        self.sigma = [x.sigma for x in sigma]
        self.lam = [x.lam for x in sigma]
        self.rate = [x.rate for x in u]


def constant(value: Parameter) -> Motion1D:
    """The function with a constant value."""
    return Motion1D("constant", value)


def constant_speed(start: Parameter, speed: Parameter) -> Motion1D:
    """The function start + speed t."""
    return Motion1D("constant speed", start, speed)


def harmonic(mean: Parameter, amplitude: Parameter, frequency: Parameter, phase: Parameter = 0.0) -> Motion1D:
    """The function mean + amplitude sin(frequency t + phase), with the frequency in rad/s."""
    return Motion1D("harmonic", mean, amplitude, frequency, phase)


def node(i: int) -> dict[str, int]:
    """The sum of a cost that counts at a single node."""
    return {"node": i}


def at_event(i: int) -> dict[str, int]:
    """The sum of a cost that counts at an event of the inputs, counted from 0."""
    return {"event": i}


def after_event(i: int) -> dict[str, int]:
    """The sum of a cost that counts just after an event of the inputs, counted from 0."""
    return {"after event": i}


# The entries of the kinds of parts.
_KINDS = dict(_core.kinds())


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

    @staticmethod
    def _finite(what: str, value: Any) -> float:
        """A number that may not be a formula."""
        try:
            number = float(value)
        except (TypeError, ValueError):
            raise TypeError(f"{what} must be a number, not {value!r}") from None
        if not math.isfinite(number):
            raise SceneError(f"{what} is {number}; it must be finite")
        return number

    def _own(self, symbol: Any) -> Any:
        if symbol.scene is not None and symbol.scene is not self:
            raise SceneError(f"`{symbol.name}` belongs to another scene; use handles of the scene that the part is added to")
        return symbol

    def _parameter(self, x: Parameter) -> float | str:
        """A number, or an expression of design variables as text."""
        x = operand(x)
        if not isinstance(x, Expression):
            return x

        def name(symbol: Symbol) -> str:
            if not isinstance(self._own(symbol), Design):
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

    def _parameters(self, part: str, **entries: Parameter) -> dict[str, float | str]:
        return {entry: self._located(part, entry, lambda: self._parameter(value)) for entry, value in entries.items()}

    def coordinates(self, group: str, names: Iterable[str], start: Iterable[float] | None = None) -> Group:
        """Adds coordinates that belong together, m or rad, and their initial values; each is an attribute of the group."""
        names = names.split() if isinstance(names, str) else list(names)
        start = [0.0] * len(names) if start is None else [self._finite(f"group `{group}`: an initial value", x) for x in start]
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
        name = coordinate if isinstance(coordinate, str) else self._own(coordinate).name
        self._add("initial value", name, value=self._finite(f"the initial value of `{name}`", value))

    def initial(self, coordinate: Coordinate | str) -> float:
        """The initial value of a coordinate, m or rad."""
        name = coordinate if isinstance(coordinate, str) else coordinate.name
        value = self._core.initial(name)
        if value is None:
            raise SceneError(f"no coordinate `{name}`{suggestion(name, self._names('coordinate'))}")
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
        self._add("design variable", name, value=self._finite(f"the value of design variable `{name}`", value))
        return Design("b", name, self)

    def gravity(self, x: Parameter, y: Parameter, z: Parameter = 0.0) -> None:
        """Sets the acceleration of gravity, m/s²; the default is zero."""
        self._add("gravity", "gravity", **self._parameters("gravity", x=x, y=y, z=z))

    def body(self, name: str, mass: Parameter, inertia: Parameter, place: Iterable[float] = (0.0, 0.0, 0.0)) -> Body:
        """Adds a rigid body with its mass (kg), moment of inertia about its centre (kg m²) and initial position x, y, φ."""
        self._add("body", name, **self._parameters(f"body `{name}`", mass=mass, inertia=inertia), place=self._start(name, place, 3))
        return Body(name, self)

    def particle(self, name: str, mass: Parameter, place: Iterable[float] = (0.0, 0.0)) -> Particle:
        """Adds a particle with its mass (kg) and initial position x, y."""
        self._add("particle", name, **self._parameters(f"particle `{name}`", mass=mass), place=self._start(name, place, 2))
        return Particle(name, self)

    def _start(self, name: str, place: Iterable[float], count: int) -> list[float]:
        """The initial position of a body in the plane."""
        numbers = [self._finite(f"body `{name}`: a number of `place`", x) for x in place]
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
        return {} if of is GROUND else {"body": self._own(of).name}

    def _vector(self, of: Iterable[Parameter]) -> list[float | str]:
        return [self._parameter(x) for x in of]

    def _handle(self, what: str, of: Any, kind: type, example: str) -> str:
        """The name of a handle."""
        if not isinstance(of, kind):
            raise TypeError(f"`{what}` must be {example}, not {of!r}")
        return self._own(of).name

    def _axis(self, what: str, of: Any) -> Any:
        """A coordinate, or coordinates with factors."""
        if not isinstance(of, Mapping):
            return self._handle(what, of, Coordinate, "a coordinate, or coordinates with factors {x: 1, y: -2}")
        name = "a coordinate"
        return [{"coordinate": self._handle(what, x, Coordinate, name), "factor": self._parameter(factor)} for x, factor in of.items()]

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
            "a body in space": lambda: self._body(self._own(value)),
            "a number or formula": lambda: self._parameter(value),
            "the name of a control": lambda: self._handle(what, value, Control, "a control, such as scene.control('force')"),
            "the name of a coordinate": lambda: self._handle(what, value, Coordinate, "a coordinate"),
            "the name of a coordinate, or a list of coordinates with factors": lambda: self._axis(what, value),
            "the name of a constraint equation": lambda: self._handle(what, value, Equation, equation),
            "names of constraint equations": lambda: [self._handle(what, of, Equation, equation) for of in value],
            "the name of a rule of summation, or the number of a node or an event": lambda: self._sum(value),
            "0, 1, 2 …": lambda: int(value),
            "a number": lambda: float(value),
            "true or false": lambda: bool(value),
            "the name of a quantity of a marker": lambda: value,
        }
        return convert[content]()

    def _ready(self, kind: str, name: str | Event, given: dict[str, Any]) -> Any:
        """Adds a ready-made part of a kind."""
        fields: dict[str, Any] = {}
        part = f"{kind} `{name.name if isinstance(name, Event) else name}`"
        for entry, content, _ in _KINDS[kind]:
            if entry == "motion":
                motion = given["motion"]
                if not isinstance(motion, Motion1D):
                    raise TypeError(f"`motion` must be constant(…), constant_speed(…) or harmonic(…), not {motion!r}")
                fields |= {"motion": motion.kind, "parameters": self._vector(motion.parameters)}
            elif given.get(entry) is not None:
                value = given[entry]
                fields[entry] = self._located(part, entry, lambda: self._entry(entry, content, value))
        of_event = any(entry == "name" for entry, *_ in _KINDS[kind])
        title = self._handle("event", name, Event, "an event of the scene") if of_event else str(name)
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

    def _joint(self, name: str) -> Joint:
        return Joint.of(name, self)

    # Formulas

    def _formula(
        self,
        kind: str,
        name: str,
        formula: Formula,
        q: Iterable[Coordinate] = (),
        sigma: Iterable[Equation] = (),
        u: Iterable[Control] = (),
        b: Iterable[Parameter] = (),
        **fields: Any,
    ) -> None:
        """Adds a part with a formula: an expression, a list of them, or a function that returns such."""
        self._name(name)
        q, sigma, u, b = list(q), list(sigma), list(u), [self._parameter(x) for x in b]
        lists: dict[str, list[Any]] = {"q": [self._own(x).name for x in q], "sigma": [], "u": [self._own(x).name for x in u], "b": list(range(len(b)))}
        lists["sigma"] = [self._own(x).name for x in sigma]
        if callable(formula):
            try:
                formula = formula(At(q, sigma, u, [Symbol("b", i) for i in range(len(b))]))
            except IndexError as error:
                lengths = ", ".join(f"`{of}` has {len(names)}" for of, names in lists.items())
                raise SceneError(f"the formula of {kind} `{name}`: {error}; of the lists that the formula is called with, {lengths}") from error
        is_one = isinstance(formula, Expression) or not isinstance(formula, Iterable) or getattr(formula, "ndim", 1) == 0
        try:
            results = [operand(formula)] if is_one else [operand(x) for x in formula]
        except TypeError as error:
            raise TypeError(f"the formula of {kind} `{name}`: {error}") from None
        if kind == "force" and len(results) != len(q):
            given = f"{counted(len(results), 'formula')} for {counted(len(q), 'coordinate')}"
            raise SceneError(f"force `{name}`: {given}; give one for each coordinate that the force acts on, {{x: formula, y: formula}}")

        def place(symbol: Symbol) -> str:
            self._own(symbol)
            if symbol.list not in _ALLOWED[kind]:
                allowed = ", ".join(_WORDS[of] for of in _ALLOWED[kind])
                raise SceneError(f"{kind} `{name}` reads `{symbol.label}`, but such a formula may read {allowed} only")
            if symbol.list == "t":
                return "t"
            known = lists[_FIELDS[symbol.list]]
            if symbol.key not in known:
                known.append(symbol.key)
            return f"{symbol.list}[{known.index(symbol.key)}]"

        parts, texts = write(results, place)
        if kind == "force":
            # No force acts on coordinates that are only read.
            texts += ["0"] * (len(lists["q"]) - len(q))
            is_one = is_one and len(texts) == 1
        # Constants come first, then design variables by their names.
        lists["b"] = b + [f"`{key}`" for key in lists["b"][len(b) :]]
        fields |= {of: names for of, names in lists.items() if names}
        if parts:
            fields["parts"] = parts
        fields["formula"] = texts[0] if is_one else texts
        key = (kind, *parts, "=", *texts, *(len(names) for names in lists.values()))
        if kind in ("kinetic energy", "potential energy", "force", "constraint"):
            fields |= {"like": self._like[key]} if key in self._like else {}
        self._add(kind, name, **fields)
        self._like.setdefault(key, name)

    def kinetic_energy(self, name: str, formula: Formula, q: Iterable[Coordinate] = (), b: Iterable[Parameter] = ()) -> None:
        """Adds a kinetic energy T(q, v; b), J."""
        self._formula("kinetic energy", name, formula, q=q, b=b)

    def potential_energy(self, name: str, formula: Formula, q: Iterable[Coordinate] = (), b: Iterable[Parameter] = ()) -> None:
        """Adds a potential energy V(q, t; b), J."""
        self._formula("potential energy", name, formula, q=q, b=b)

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
        self._formula("force", name, formula, q=q, u=u, b=b)

    def constraint(self, name: str, formula: Formula, q: Iterable[Coordinate] = (), b: Iterable[Parameter] = ()) -> Joint:
        """Adds constraints Φ(q, t; b) = 0, m or rad, and returns their equations."""
        self._formula("constraint", name, formula, q=q, b=b)
        return self._joint(name)

    def cost(self, name: str, formula: Formula, sum: str | dict[str, int], **lists: Any) -> None:
        """Adds a cost to J, with its sum over the nodes: 'integral', 'terminal', 'trapezoidal', 'rectangle', 'plain', 'all nodes', node(i)."""
        self._formula("cost", name, formula, sum=self._sum(sum), **lists)

    def output(self, name: str, formula: Formula = None, sum: str | dict[str, int] | None = None, **lists: Any) -> Output:
        """Adds an output, and its first term if a formula is given."""
        if formula is not None and sum is None:
            raise TypeError(f"output `{name}`: the sum of its formula is missing, for example sum='terminal'")
        self._add("output", name)
        made = Output(name, self)
        if formula is not None:
            self.term(made, name, formula, sum, **lists)
        return made

    def term(self, output: Output | str, name: str, formula: Formula, sum: str | dict[str, int] | None, **lists: Any) -> None:
        """Adds a term to an output."""
        of = output if isinstance(output, str) else self._own(output).name
        self._formula("term", name, formula, sum=self._sum(sum), output=of, **lists)

    def event(self, name: str, formula: Formula, **lists: Any) -> Event:
        """Adds an event: the zero of a function of the state."""
        self._formula("event", name, formula, **lists)
        return Event(name, self)

    def _sum(self, sum: Any) -> Any:
        if isinstance(sum, str) and sum not in _SUMS:
            raise SceneError(f"'{sum}' is not one of the sums {', '.join(_SUMS)}, node(i), at_event(i), after_event(i)")
        return sum

    def effort(self, name: str, control: Control, weight: Parameter) -> None:
        """Adds the cost ½ w ∫ u² dt of a control."""
        self._add("effort", name, control=self._own(control).name, **self._parameters(f"effort `{name}`", weight=weight))

    def time(self, name: str, weight: Parameter) -> None:
        """Adds the cost w T of the duration."""
        self._add("time", name, **self._parameters(f"time `{name}`", weight=weight))

    def end_state(self, coordinate: Coordinate) -> tuple[Output, Output]:
        """Adds a coordinate and its velocity at the end as outputs; optimisers leave them free unless they are constrained."""
        name = self._own(coordinate).name
        self._add("end state", name)
        position, rate = end_state_names(name)
        return Output(position, self), Output(rate, self)

    def reading(self, name: str, coordinate: Coordinate, node: int, value: float, weight: float) -> None:
        """Adds the output w (q − value) of a coordinate at a node, for fits to measurements."""
        self._add("reading", name, coordinate=self._own(coordinate).name, node=int(node), value=float(value), weight=float(weight))

    def reading_time(self, name: str, node: int, time: float) -> None:
        """Records the time of a reading at a node, s. Fits reject inputs whose node is at another time."""
        self._add("reading time", name, node=int(node), time=float(time))

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

        `deviation` is the standard deviation, or one for each reading. `steps`, `dt` and `t0` are the grid of the motion, whose nodes must include the
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
        kinds = [of for of in self._core.kinds_of(name) if kind in (None, of)]
        # A body in the plane has coordinates, too, and a control may have the name of its joint.
        kinds = [of for of in kinds if of != "joint"] or kinds
        if len(kinds) != 1:
            if kinds:
                raise KeyError(f"`{name}` is the name of {' and of '.join(_one(of) for of in kinds)}: choose by scene.find({name!r}, {kinds[0]!r})")
            raise KeyError(f"the scene has no {kind or 'part with the name'} `{name}`{suggestion(name, self._names(kind))}")
        if kinds[0] == "body":
            is_body = "coordinate" in self._core.kinds_of(f"{name}.φ")
            return Body(name, self) if is_body else Particle(name, self)
        if kinds[0] == "body in space":
            return SpaceBody(name, self)
        if kinds[0] in ("constraint", "joint"):
            return self._joint(name)
        makers: dict[str, Callable[[], Any]] = {
            "coordinate": lambda: Coordinate("q", name, self),
            "control": lambda: Control("u", name, self),
            "design variable": lambda: Design("b", name, self),
            "output": lambda: Output(name, self),
            "event": lambda: Event(name, self),
        }
        return makers[kinds[0]]()

    def __getitem__(self, name: str) -> Any:
        return self.find(name)

    def _names(self, kind: str | None = None) -> list[str]:
        """The names that `find` knows."""
        parts = [json.loads(part) for part in self._core.parts]
        names = [part["name"] for part in parts]
        names += [f"{part['name']}.{of}" for part in parts for of in (*part.get("coordinates", ()), "φ", *OF_JOINTS)]
        names += [f"{part['name']} {of}" for part in parts for of in "xyz"]
        return [name for name in dict.fromkeys(names) if (kind in self._core.kinds_of(name) if kind else self._core.kinds_of(name))]


def _one(kind: str) -> str:
    """A kind with its article."""
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"


def cart_pendulum(links: int = 3) -> Scene:
    """The paper's example: a cart with links that hang from it, a force on the cart, and the cost of swinging them up."""
    return Scene.from_json(_core.cart_pendulum(links))
