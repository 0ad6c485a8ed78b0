"""Systems, inputs and gradients."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from functools import cached_property
from typing import Any
from weakref import WeakSet

import numpy as np
from numpy.typing import ArrayLike

from . import _hamiltonian_adjoint as _core
from ._errors import InputError, SceneError
from ._expression import Symbol
from ._grid import Array as Array
from ._grid import lengths_of_steps
from ._handles import Coordinate, Event
from ._names import suggestion
from ._scene import Scene
from ._words import counted

# The kinds of what formulas, inputs and motions name by their lists.
_INPUTS = ("control", "coordinate", "design variable")
_EQUATIONS = ("constraint", "joint")
# The kinds of parts that add to J.
_COSTS = {"cost", "effort", "time"}
_NOTHING_ASKED = "the scene has neither a cost nor an output, so that J and its gradient are zero; add a cost (`scene.cost`) and compile the scene again"


class System(_core.System):
    """A compiled mechanism: n coordinates, m constraint equations, k controls. It is immutable and can be shared between threads.

    Parts and initial values that are added to the scene later have no effect; compile the scene again.
    """

    _source: Scene | None = None

    @classmethod
    def _from(cls, scene: Scene) -> System:
        """The compiled scene."""
        made = cls(scene._core)
        made._source = scene
        return made

    def __reduce__(self) -> Any:
        return _compiled, (self.parts,)

    @property
    def scene(self) -> Scene:
        """A scene with the same parts."""
        scene = Scene()
        scene.__setstate__({"parts": self.parts})
        return scene

    def at_rest(self, steps: int | ArrayLike, dt: float | None = None) -> Inputs:
        """Inputs at rest at the positions of the scene, with zero controls: a number of steps of `dt` seconds, or the lengths of all steps.

        With negative lengths the motion goes backward in time.
        """
        return Inputs(self, steps, dt)

    @cached_property
    def _has_result(self) -> bool:
        return bool(self.outputs) or any(kind in _COSTS for kind, _ in self._kinds_and_names)

    @cached_property
    def _kinds_and_names(self) -> list[tuple[str, str]]:
        return _kinds_and_names(self.parts)

    @cached_property
    def _alike(self) -> WeakSet[Scene]:
        """Other scenes that begin with parts of the same kinds and names: they are read once, not for each key."""
        return WeakSet()

    def _check_scene(self, handle: Any) -> None:
        """Raises a SceneError if a handle belongs to a scene whose parts have other kinds or names than those of the system."""
        scene, own = handle.scene, self._kinds_and_names
        if scene is None or self._source is None or scene is self._source or scene in self._alike:
            return
        other = _kinds_and_names(scene._core.parts)
        # Scenes grow at their ends.
        if len(other) >= len(own) and other[: len(own)] == own:
            self._alike.add(scene)
        elif any(a != b for a, b in zip(own, other)):
            raise SceneError(f"`{getattr(handle, 'label', handle.name)}` belongs to another scene; use handles of the scene that was compiled")

    def _number(self, symbol: Symbol, names: list[str]) -> int:
        """The number of a handle among names of the system."""
        self._check_scene(symbol)
        if symbol.key not in names:
            is_equation = symbol.list in ("sigma", "lambda")
            # The equation `hinge.1` belongs to the part `hinge`.
            parts = (symbol.name, symbol.name.rpartition(".")[0]) if is_equation else (symbol.name,)
            later = [self._later(part, symbol.scene, _EQUATIONS if is_equation else _INPUTS) for part in parts]
            raise KeyError(f"the system has no `{symbol.label}`{next(filter(None, later), '')}")
        return names.index(symbol.key)

    def _named(self, kind: str, names: list[str], of: Any) -> str:
        """The name of an output, an event or a coordinate, which is given by it or by its handle."""
        name: Any = of if isinstance(of, str) else getattr(of, "name", None)
        if not isinstance(name, str):
            raise TypeError(f"{of!r} is no {kind} and no name of one")
        if not isinstance(of, str):
            self._check_scene(of)
        if name not in names:
            raise InputError(f"the system has no {kind} `{name}`{self._later(name, getattr(of, 'scene', None), (kind,)) or suggestion(name, names)}")
        return name

    def _later(self, name: str, scene: Scene | None, kinds: Iterable[str] = _INPUTS) -> str:
        """The end of a message about a name that the system does not have: whether the scene has something of these kinds with this name since."""
        scene = self._source and (scene or self._source)
        is_known = scene is not None and not set(kinds).isdisjoint(scene._core.kinds_of(name))
        return ": it was added to the scene after this system was compiled; compile the scene again" if is_known else ""

    def __repr__(self) -> str:
        numbers = {"coordinate": self.n, "constraint equation": self.m, "control": self.k, "design variable": len(self.designs)}
        return f"<system of {', '.join(counted(number, noun) for noun, number in numbers.items())}>"


def _kinds_and_names(parts: list[str]) -> list[tuple[str, str]]:
    return [(part["kind"], part["name"]) for part in map(json.loads, parts)]


def _compiled(parts: list[str]) -> System:
    scene = Scene()
    scene.__setstate__({"parts": parts})
    return System(scene._core)


def _index(system: Any, symbol: Any) -> tuple[str, int]:
    """The list and the number of a control, a design variable, a coordinate or a velocity."""
    kinds = {"u": ("controls", system.controls), "b": ("design", system.designs), "q": ("q", system.coordinates), "v": ("v", system.coordinates)}
    if isinstance(symbol, str):
        found = [(of, names.index(symbol)) for of, names in kinds.values() if of != "v" and symbol in names]
        if len(found) != 1:
            known = [name for of, names in kinds.values() if of != "v" for name in names]
            unknown = f"no input has the name `{symbol}`{system._later(symbol, None) or suggestion(symbol, known)}"
            raise KeyError(f"more than one input has the name `{symbol}`; use the handle" if found else unknown)
        return found[0]
    if not isinstance(symbol, Symbol) or symbol.list not in kinds:
        raise TypeError(f"inputs are chosen by a control, a design variable, a coordinate or a velocity such as `x.v`, not by {symbol!r}")
    of, names = kinds[symbol.list]
    return of, system._number(symbol, names)


class _ByName:
    """Arrays that are chosen by handles: `inputs[force]`, `gradient[mass]`."""

    system: System

    def __getitem__(self, symbol: Symbol | str) -> Any:
        of, i = _index(self.system, symbol)
        return getattr(self, of)[i]


class Inputs(_ByName):
    """The inputs of a motion, as arrays that can be changed: `inputs.controls[:] = 10.0`, `inputs[force] = 10.0`, `inputs[x.v] = 0.3`.

    `controls` has one row for each control and one column for each node; `design`, `q` and `v` have one entry for each design variable and coordinate;
    `steps` contains the lengths of the steps, s. `start` is 'velocity' (q and v are given), 'momentum' (v contains p*) or 'assembled' (q and v are
    guesses, and the names in `held` are kept).
    """

    _SHAPES = {"q": "n", "v": "n", "design": "designs"}

    t0: float
    stages: int
    start: str
    q: Array
    v: Array
    controls: Array
    design: Array
    steps: Array
    held: tuple[list[str], list[str]]
    events: list[tuple[str, int]]
    controls_in_time: list[str]
    open: list[int] | None

    def __init__(self, system: System, steps: int | ArrayLike, dt: float | None = None) -> None:
        if not isinstance(system, _core.System):
            raise TypeError(f"inputs belong to a system, such as scene.compile(), not to {system!r}")
        self.system = system
        self.steps = lengths_of_steps(steps, dt)
        self.t0, self.stages, self.start = 0.0, 1, "velocity"
        self.q, self.v, self.design = system.initial, np.zeros(system.n), system.design
        self.held, self.events, self.controls_in_time, self.open = ([], []), [], [], None
        self.controls = np.zeros((system.k, len(self.steps) + 1))

    @classmethod
    def _of(cls, system: System, attributes: dict[str, Any]) -> Inputs:
        made = cls.__new__(cls)
        made.__dict__.update(system=system, **attributes)
        return made

    def __setattr__(self, name: str, value: Any) -> None:
        if name in ("q", "v", "design", "controls", "steps"):
            value = np.array(value, dtype=np.float64)
            expected = self._expected(name)
            if expected is not None and value.shape != expected:
                raise InputError(f"`{name}` has the shape {value.shape}, but this system and grid need {expected}")
            if value.ndim != (2 if name == "controls" else 1):
                raise InputError(f"`{name}` must be {'a matrix' if name == 'controls' else 'a list of numbers'}")
        elif name not in Inputs.__annotations__ and name != "system":
            raise AttributeError(f"inputs have no attribute {name!r}; they have {', '.join(Inputs.__annotations__)}")
        self.__dict__[name] = value

    def _expected(self, name: str) -> tuple[int, ...] | None:
        if name in ("q", "v"):
            return (self.system.n,)
        if name == "design":
            return (len(self.system.designs),)
        return (self.system.k, len(self.steps) + 1) if name == "controls" else None

    def __setitem__(self, symbol: Symbol | str, value: ArrayLike) -> None:
        of, i = _index(self.system, symbol)
        label = symbol.label if isinstance(symbol, Symbol) else symbol
        try:
            numbers = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            raise TypeError(f"`{label}` must be set to numbers, not to {value!r}") from None
        row = getattr(self, of)
        if numbers.shape not in ((), row.shape[1:]):
            expected = f"a number, or one for each of the {row.shape[1]} nodes" if of == "controls" else "a number"
            raise InputError(f"`{label}` must be set to {expected}, not to an array of the shape {numbers.shape}")
        row[i] = numbers

    @property
    def times(self) -> Array:
        """The times of the nodes, s."""
        return self.t0 + np.concatenate([[0.0], np.cumsum(self.steps)])

    def assemble(self, *hold: Coordinate) -> Inputs:
        """Treats q and v as guesses for a start that satisfies the constraints; these coordinates and their velocities are kept."""
        self.start = "assembled"
        names = [self.system._named("coordinate", self.system.coordinates, x) for x in hold]
        self.held = (names, list(names))
        return self

    def at(self, event: Event | str, node: int) -> None:
        """Lets an event determine a node."""
        self.events = [*self.events, (self.system._named("event", self.system.events, event), int(node))]

    def copy(self) -> Inputs:
        """Inputs with the same values."""
        copied = {name: value.copy() if isinstance(value, np.ndarray) else value for name, value in self.__dict__.items() if name != "system"}
        return Inputs._of(self.system, copied)

    def no_change(self) -> Inputs:
        """A direction with zeros, for `Solver.hessian_product`."""
        made = self.copy()
        made.t0 = 0.0
        for name in ("q", "v", "design", "controls", "steps"):
            getattr(made, name)[...] = 0.0
        return made

    def to_json(self) -> str:
        """The inputs as JSON, by name and to the last bit."""
        return self.system.inputs_to_json(self)

    @classmethod
    def from_json(cls, system: System, text: str) -> Inputs:
        """Reads inputs as `to_json` writes them."""
        return cls._of(system, system.inputs_from_json(text))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the inputs to a file."""
        text = self.to_json()
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)

    @classmethod
    def load(cls, system: System, path: str | os.PathLike[str]) -> Inputs:
        """Reads inputs from a file."""
        with open(path, encoding="utf-8") as file:
            return cls.from_json(system, file.read())

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Inputs):
            return NotImplemented
        of, to = self.__dict__, other.__dict__
        return all(np.array_equal(of[name], to[name]) for name in of if name not in ("system", "held")) and self.held == other.held

    __hash__ = None  # type: ignore[assignment]

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)

    def __repr__(self) -> str:
        return f"<inputs: {counted(len(self.steps), 'step')} to t = {self.times[-1]:g} s, {counted(self.system.k, 'control')}, start '{self.start}'>"


class Gradient(_ByName):
    """J and its derivatives with respect to all inputs, in arrays of the shapes of the inputs: `gradient[force]`, `gradient[mass]`."""

    value: float
    controls: Array
    design: Array
    q: Array
    v: Array
    steps: Array
    frozen: Gradient | None
    warnings: list[tuple[str, str]]

    def __init__(self, system: System, attributes: dict[str, Any]) -> None:
        self.__dict__.update(attributes, system=system)
        if attributes["frozen"] is not None:
            self.frozen = Gradient(system, attributes["frozen"])
        if self.value == 0.0 and not system._has_result:
            self.warnings = [*self.warnings, ("NothingAsked", _NOTHING_ASKED)]

    def __repr__(self) -> str:
        sizes = ", ".join(f"|dJ/d{name}| ≤ {np.abs(of).max():.3g}" for name, of in self._parts().items() if of.size)
        return f"<gradient: J = {self.value:.10g}, {sizes}>"

    def _parts(self) -> dict[str, Array]:
        return {"u": self.controls, "b": self.design, "q₀": self.q, "v₀": self.v, "Δt": self.steps}

