"""Linear models and equilibria at a state."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._handles import listed
from ._system import Array, System
from ._words import counted

if TYPE_CHECKING:
    from ._mechanics import Mechanics

# Real parts below this fraction of an eigenvalue, and values below this fraction of the largest one, are shown as zero.
_ROUNDING = 1e-12


@dataclass(frozen=True, eq=False, repr=False)
class LinearModel:
    """The motion near a state, linear in the changes of independent coordinates ζ, their rates ω, controls and design variables.

        z = (ζ, ω):    δż = a δz + b δu + by_design δb,      δq = q_z δz,      δv = v_z δz

    Units are SI and derivatives are exact. With d = n − rank Φ_q,

    - `coordinates`: the names of the d independent coordinates ζ;
    - `states`: the names of z, such as `arm.φ` and `arm.φ.v`: all ζ, then all ω in the same order;
    - `controls`, `designs`: the names of the columns of `b` and of `by_design`;
    - `a` = ∂ż/∂z (2d × 2d), `b` = ∂ż/∂u (2d × k), `by_design` = ∂ż/∂b for constant z (2d × number of design variables);
    - `q_z` = ∂q/∂z and `v_z` = ∂v/∂z (n × 2d), with a row for each of `system.coordinates`;
    - `eigenvalues` of `a` (2d, complex), 1/s, those with the largest real parts first: a mode e^(st) grows if s has a positive real part.

    About a state that is not an equilibrium, or with constraints and forces that depend on time, the matrices belong to the time of the state, and δz is
    the distance from the motion through it.
    """

    coordinates: tuple[str, ...]
    states: tuple[str, ...]
    controls: tuple[str, ...]
    designs: tuple[str, ...]
    a: Array
    b: Array
    by_design: Array
    q_z: Array
    v_z: Array
    eigenvalues: NDArray[np.complex128]

    @classmethod
    def _of(cls, system: System, attributes: dict[str, Any]) -> LinearModel:
        names = tuple(attributes.pop("names"))
        states = (*names, *(f"{name}.v" for name in names))
        return cls(names, states, tuple(system.controls), tuple(system.designs), **_read_only(attributes))

    def __repr__(self) -> str:
        numbers = {"state": len(self.states), "control": len(self.controls), "design variable": len(self.designs)}
        counts = ", ".join(counted(number, noun) for noun, number in numbers.items())
        lines = [f"states: {listed(self.states)}"] if self.states else []
        return "\n  ".join([f"<linear model: {counts}>", *lines, _eigenvalues(self.eigenvalues)])


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivity:
    """The derivatives of an equilibrium with respect to controls or design variables, one column for each, in SI units.

        q_p, λ_p, holding_p      for p = u or p = b

    - `names`: the names of the columns;
    - `coordinates`, `equations`: the names of the rows of `q` and `holding`, and of the rows of `lam`;
    - `q`: of the coordinates (n × number of columns);
    - `lam`: of the reactions λ (m × number of columns); for dependent constraints they are not unique, but those of Φ_qᵀλ are;
    - `holding`: of the forces that hold the held coordinates (n × number of columns).
    """

    names: tuple[str, ...]
    coordinates: tuple[str, ...]
    equations: tuple[str, ...]
    q: Array
    lam: Array
    holding: Array

    @classmethod
    def _of(cls, system: System, names: list[str], attributes: dict[str, Any]) -> Sensitivity:
        return cls(tuple(names), tuple(system.coordinates), tuple(system.equations), **_read_only(attributes))

    def __repr__(self) -> str:
        shapes = ", ".join(f"{of} {' × '.join(map(str, getattr(self, of).shape))}" for of in ("q", "lam", "holding"))
        return f"<derivatives of an equilibrium with respect to {listed(self.names) or 'nothing'}: {shapes}>"


@dataclass(frozen=True, eq=False, repr=False)
class Equilibrium:
    """A configuration at rest in which all forces balance, with its derivatives and the stability of small motions, in SI units.

        𝓛_q + Q − Φ_qᵀ λ + holding = 0,      Φ(q, t) = 0      at v = 0

    - `state`: the state, with q in equilibrium and v = 0; `equilibrium.state[x]` is the value of a coordinate;
    - `lam`: the reactions λ (m), N or N m, by `system.equations`; for dependent constraints λ is not unique, but Φ_qᵀλ is;
    - `holding`: the forces that hold the held coordinates (n), N or N m, by `system.coordinates`; zero for all others;
    - `eigenvalues` of the linearised motion in which the held coordinates rest (complex), 1/s, those with the largest real parts first;
    - `is_stable`: True if no small motion grows; a free oscillation without damping counts as stable;
    - `by_controls`, `by_design`: the derivatives of q, λ and the holding forces with respect to controls and design variables.
    """

    state: Mechanics
    lam: Array
    holding: Array
    eigenvalues: NDArray[np.complex128]
    is_stable: bool
    by_controls: Sensitivity
    by_design: Sensitivity

    @classmethod
    def _of(cls, state: Mechanics, attributes: dict[str, Any]) -> Equilibrium:
        system = state.system
        by_controls = Sensitivity._of(system, system.controls, attributes.pop("by_controls"))
        by_design = Sensitivity._of(system, system.designs, attributes.pop("by_design"))
        return cls(state, by_controls=by_controls, by_design=by_design, **_read_only(attributes))

    def __repr__(self) -> str:
        names = self.state.system.coordinates
        lines = [f"<{'stable' if self.is_stable else 'unstable'} equilibrium>", f"q: {_values(names, self.state.q)}"]
        held = np.flatnonzero(self.holding)
        if held.size:
            lines.append(f"held by forces on {_values([names[i] for i in held], self.holding[held])}")
        return "\n  ".join([*lines, _eigenvalues(self.eigenvalues)])


def _read_only(attributes: dict[str, Any]) -> dict[str, Any]:
    """The attributes, with arrays that cannot be changed."""
    for value in attributes.values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    return attributes


def _values(names: list[str], values: Array) -> str:
    small = _ROUNDING * np.abs(values).max(initial=0.0)
    return listed(f"{name} = {value if abs(value) > small else 0.0:.6g}" for name, value in zip(names, values))


def _eigenvalues(values: NDArray[np.complex128]) -> str:
    """Eigenvalues in a line of text; conjugate ones as a pair."""

    def shown() -> Iterator[str]:
        for s in values[values.imag >= 0.0]:
            real = "0" if abs(s.real) <= _ROUNDING * abs(s) else f"{s.real:.4g}"
            yield f"{real} ± {s.imag:.4g}i" if s.imag > 0.0 else real

    return f"eigenvalues: {listed(shown())} 1/s" if values.size else "no motion is free"
