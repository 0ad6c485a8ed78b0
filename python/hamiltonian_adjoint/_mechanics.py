"""Mechanical quantities at a single state."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from . import _hamiltonian_adjoint as _core
from ._errors import InputError
from ._expression import Symbol, operand, write
from ._handles import Control, Coordinate, Design, Ground, Marker, Particle, Point, SpaceBody
from ._operating_point import Equilibrium, LinearModel
from ._solver import Motion, _checked
from ._system import Array, Inputs, System
from ._words import whole

_VALUES = {"q": "coordinates", "v": "coordinates", "v_dot": "coordinates", "u": "controls", "lambda": "equations"}


class MarkerState(NamedTuple):
    """Position (m) and motion of a marker in space, with components along the inertial axes; `axes[0]`, `axes[1]` and `axes[2]` are the directions of its axes."""

    position: Array
    axes: Array
    velocity: Array
    angular_velocity: Array
    acceleration: Array
    angular_acceleration: Array


class Mechanics:
    """The mechanics of a system at one state: constraints, energies, momenta, accelerations and reactions, positions of points, equilibria, linear models.

    The state consists of coordinates q, by default those of the scene, velocities v, by default zero, zero controls, the design of the scene and t = 0.
    Equations that an event closes are open. `at_start` and `at_node` are states of motions.
    """

    def __init__(self, system: System, q: ArrayLike | None = None, v: ArrayLike | None = None) -> None:
        q, v = system.initial if q is None else q, np.zeros(system.n) if v is None else v
        self.system = system
        self._core = _core.Mechanics(system, _numbers("q", q), _numbers("v", v))

    @classmethod
    def _of(cls, system: System, core: Any) -> Mechanics:
        made = cls.__new__(cls)
        made.system, made._core = system, core
        return made

    def __reduce__(self) -> Any:
        return _of_state, (self.system, self._core.state())

    @classmethod
    def at_start(cls, system: System, inputs: Inputs) -> Mechanics:
        """The mechanics at the start of a motion; a guess is assembled before."""
        return cls._of(system, _core.Mechanics.at_start(system, _checked(inputs, system)))

    @classmethod
    def at_node(cls, motion: Motion, node: int) -> Mechanics:
        """The mechanics at a node of a motion; node −1 is the last one that was computed."""
        i = whole("a node", node)
        i += motion.computed if i < 0 else 0
        if not 0 <= i < motion.computed:
            raise InputError(f"node {node} does not exist or was not computed; the motion has {motion.computed} nodes, counted from 0")
        return cls._of(motion.system, _core.Mechanics.at_node(motion._core, i))

    def with_controls(self, u: ArrayLike) -> Mechanics:
        """The same state with other controls."""
        return self._of(self.system, self._core.with_controls(_numbers("controls", u)))

    def with_design(self, design: ArrayLike) -> Mechanics:
        """The same state with other values of the design variables."""
        return self._of(self.system, self._core.with_design(_numbers("design", design)))

    def at_time(self, t: float) -> Mechanics:
        """The same state at another time, s."""
        return self._of(self.system, self._core.at_time(float(t)))

    @cached_property
    def q(self) -> Array:
        """Coordinates, m or rad."""
        return self._core.vector("q")

    @cached_property
    def v(self) -> Array:
        """Velocities, m/s or rad/s."""
        return self._core.vector("v")

    @cached_property
    def controls(self) -> Array:
        """Controls, by `system.controls`."""
        return self._core.vector("controls")

    @cached_property
    def phi(self) -> Array:
        """The constraints Φ(q, t), m or rad."""
        return self._core.vector("phi")

    @cached_property
    def phi_q(self) -> Array:
        """The matrix Φ_q (m × n)."""
        return self._core.matrix("phi_q")

    @cached_property
    def phi_dot(self) -> Array:
        """The rates dΦ/dt, m/s or rad/s."""
        return self._core.vector("phi_dot")

    @cached_property
    def mass(self) -> Array:
        """The mass matrix M = T_vv (n × n)."""
        return self._core.matrix("mass")

    @cached_property
    def momenta(self) -> Array:
        """Momenta T_v without impulses of constraints, N s or N m s."""
        return self._core.vector("momenta")

    @property
    def kinetic_energy(self) -> float:
        """T, J."""
        return self._core.energies()[0]

    @property
    def potential_energy(self) -> float:
        """V, J."""
        return self._core.energies()[1]

    @property
    def energy(self) -> float:
        """T + V, J."""
        return sum(self._core.energies())

    @cached_property
    def degrees_of_freedom(self) -> int:
        """The number of velocities that the constraints leave free: n − rank Φ_q."""
        return self._core.degrees_of_freedom()

    @cached_property
    def _accelerations(self) -> tuple[Array, Array]:
        return self._core.accelerations()

    def accelerations(self) -> tuple[Array, Array]:
        """The accelerations v̇ (m/s², rad/s²) and the reactions λ = dσ/dt (N, N m). For dependent constraints λ is not unique, but Φ_qᵀλ is."""
        return self._accelerations

    def equilibrium(self, *hold: Coordinate | str) -> Equilibrium:
        """The equilibrium near these coordinates, stable or not, with the controls, design variables and time of this state.

            𝓛_q + Q − Φ_qᵀ λ + holding = 0,      Φ(q, t) = 0      at v = 0

        The coordinates are a guess and need not satisfy the constraints; the velocities are ignored. The coordinates `hold` keep their values: hold one if
        no force acts on it and the equilibrium would not be unique, such as that of a cart on a rail, or to compute the force that holds it. Newton's
        method finds the equilibrium; if it does not converge, the result is that of `stable_equilibrium`.
        """
        return self._equilibrium(hold, False)

    def stable_equilibrium(self, *hold: Coordinate | str) -> Equilibrium:
        """The equilibrium in which a mechanism with strong friction comes to rest from these coordinates; otherwise as `equilibrium`.

        Every step follows the forces, so that for forces of a potential the equilibrium is a minimum of the potential energy.
        """
        return self._equilibrium(hold, True)

    def _equilibrium(self, hold: Iterable[Any], stable: bool) -> Equilibrium:
        core, attributes = self._core.equilibrium(self._coordinates(hold), stable)
        return Equilibrium._of(self._of(self.system, core), attributes)

    def linear_model(self, *chosen: Coordinate | str) -> LinearModel:
        """The linearised motion about this state, with its controls, design variables and time, in d = n − rank Φ_q independent coordinates ζ.

            z = (ζ, ω):    δż = a δz + b δu + by_design δb      (a: 2d × 2d, b: 2d × k), SI units

        The independent coordinates include those in `chosen`; the others are selected such that the dependent ones follow from them as accurately as
        possible. `at.equilibrium().state.linear_model()` is the model about an equilibrium.
        """
        return LinearModel._of(self.system, self._core.linear_model(self._coordinates(chosen)))

    def inverse_dynamics(self, accelerations: Mapping[Coordinate | str, float], controls: Iterable[Control | str]) -> Mechanics:
        """This state with the controls for which coordinates have given accelerations, m/s² or rad/s²: as many controls as coordinates.

            v̇_i(q, v, u, t; b) = a_i      for the coordinates i

        `at.inverse_dynamics({arm.phi: 0.0}, [torque])[torque]` is the control. Controls that are not chosen keep their values.
        """
        if not isinstance(accelerations, Mapping):
            raise TypeError(f"accelerations are given by their coordinates, such as {{arm.phi: 0.0}}, not as {accelerations!r}")
        given = self._coordinates(accelerations), _numbers("accelerations", list(accelerations.values()))
        return self._of(self.system, self._core.inverse_dynamics(given, self._controls(controls)))

    def relative_degree(self, coordinate: Coordinate | str, controls: Iterable[Control | str]) -> int | None:
        """The order of the lowest time derivative of a coordinate that one of the controls changes at once; `None` if they have no influence on it.

        It is 2 if a motor or its reaction acts on the body itself or on one that joints connect to it, 3 if a spring with a damper is between them, and 4
        with a spring alone. A servo constraint, which prescribes one coordinate and asks for one control, has the index r + 1; several at once may have
        a higher index.
        """
        return self._core.relative_degree(self._coordinates([coordinate])[0], self._controls(controls))

    def _controls(self, of: Iterable[Control | str]) -> list[str]:
        if isinstance(of, (Symbol, str)):
            raise TypeError("`controls` must be a list, such as [torque]")
        return self._names("control", "u", of)

    def _coordinates(self, of: Iterable[Any]) -> list[str]:
        return self._names("coordinate", "q", of)

    def _names(self, kind: str, list_: str, of: Iterable[Any]) -> list[str]:
        """The names of coordinates or controls, which are given by them or by handles."""
        names = getattr(self.system, f"{kind}s")

        def name(x: Any) -> str:
            if not isinstance(x, str) and not (isinstance(x, Symbol) and x.list == list_):
                raise TypeError(f"a {kind} or its name is expected, not {x!r}")
            return self.system._named(kind, names, x)

        return [name(x) for x in of]

    def position(self, point: Point | Particle) -> Array:
        """The position of a point in the plane, such as `arm.at(0.5, 0)`, in the inertial frame, m."""
        return self._core.point(*self._point(point))[0]

    def velocity(self, point: Point | Particle) -> Array:
        """The velocity of a point in the plane in the inertial frame, m/s."""
        return self._core.point(*self._point(point))[1]

    def marker(self, marker: Marker | SpaceBody | Ground) -> MarkerState:
        """Position and motion of a marker in space, with its accelerations for the present controls."""
        of: Any = Marker(marker, {}) if isinstance(marker, (SpaceBody, Ground)) else marker
        if not isinstance(of, Marker):
            raise TypeError(f"a marker such as arm.at(0, 0, 0.5) is expected, not {marker!r}")
        at, *axes = (self._formulas(of.entries[name]) if name in of.entries else None for name in ("at", "along", "toward", "turned"))
        return MarkerState(*self._core.marker(self._body(of.body), at, axes))

    def _body(self, of: Any) -> str | None:
        """The name of a body; the ground has none."""
        name: str | None = getattr(of, "name", None)
        if name is not None:
            self.system._check_scene(of)
        return name

    def _point(self, point: Any) -> tuple[str | None, Any]:
        of: Any = point.point() if isinstance(point, Particle) else point
        if not isinstance(of, Point):
            raise TypeError(f"a point such as arm.at(0.5, 0) is expected, not {point!r}")
        return self._body(of.body), self._formulas((of.x, of.y))

    def _formulas(self, numbers: Iterable[Any]) -> tuple[list[str], list[str]]:
        """Numbers and expressions of design variables as text."""
        designs = self.system.designs

        def name(symbol: Symbol) -> str:
            if not isinstance(symbol, Design):
                raise TypeError(f"`{symbol.label}` changes during the motion: points of bodies depend on design variables only")
            return f"x[{self.system._number(symbol, designs)}]"

        return write([operand(x) for x in numbers], name)

    def __getitem__(self, symbol: Symbol) -> float:
        """The value of a coordinate, a velocity `x.v`, an acceleration `x.a`, a control or a reaction `rope[0].lam`."""
        if not isinstance(symbol, Symbol) or symbol.list not in _VALUES:
            raise TypeError(f"a state has values of coordinates, `x.v`, `x.a`, controls and reactions `rope[0].lam`, not of {symbol!r}")
        names = getattr(self.system, _VALUES[symbol.list])
        number = self.system._number(symbol, names)
        v_dot, lam = (self._accelerations if symbol.list in ("v_dot", "lambda") else (None, None))
        of: Any = {"q": self.q, "v": self.v, "v_dot": v_dot, "u": self.controls, "lambda": lam}[symbol.list]
        return float(of[number])

    def __repr__(self) -> str:
        return f"<mechanics of {self.system!r}>"


def _of_state(system: System, state: Any) -> Mechanics:
    return Mechanics._of(system, _core.Mechanics.of_state(system, state))


def _numbers(what: str, x: ArrayLike) -> list[float]:
    of = np.asarray(x, dtype=np.float64)
    if of.ndim != 1:
        raise InputError(f"`{what}` must be a list of numbers, but its shape is {of.shape}")
    return of.tolist()
