"""Formulas of parts with the lists that they read."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ._entries import Entries, Parameter
from ._errors import SceneError
from ._expression import Expression, Symbol, operand, t, write
from ._handles import Control, Coordinate, Equation
from ._words import counted

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


class WrittenFormula:
    """A formula of a part as text, with the lists that it reads. It is given as an expression, a list of them, or a function that returns such."""

    def __init__(
        self,
        entries: Entries,
        kind: str,
        name: str,
        given: Any,
        q: Iterable[Coordinate] = (),
        sigma: Iterable[Equation] = (),
        u: Iterable[Control] = (),
        b: Iterable[Parameter] = (),
    ) -> None:
        self._own, self._kind, self._part = entries.own, kind, f"{kind} `{name}`"
        q, sigma, u, self._constants = list(q), list(sigma), list(u), [entries.parameter(x) for x in b]
        self._lists: dict[str, list[Any]] = {of: [self._own(x).name for x in handles] for of, handles in (("q", q), ("sigma", sigma), ("u", u))}
        self._lists["b"] = list(range(len(self._constants)))
        results, is_one = self._results(given, q, sigma, u)
        if kind == "force" and len(results) != len(q):
            counts = f"{counted(len(results), 'formula')} for {counted(len(q), 'coordinate')}"
            raise SceneError(f"{self._part}: {counts}; give one for each coordinate that the force acts on, {{x: formula, y: formula}}")
        self._parts, self._texts = write(results, self._place)
        if kind == "force":
            # No force acts on coordinates that are only read.
            self._texts += ["0"] * (len(self._lists["q"]) - len(q))
        self._is_one = is_one and len(self._texts) == 1

    def _results(self, given: Any, q: list[Coordinate], sigma: list[Equation], u: list[Control]) -> tuple[list[Any], bool]:
        """The operands of the formula, and whether it is a single one."""
        if callable(given):
            try:
                given = given(At(q, sigma, u, [Symbol("b", i) for i in range(len(self._constants))]))
            except IndexError as error:
                lengths = ", ".join(f"`{of}` has {len(names)}" for of, names in self._lists.items())
                raise SceneError(f"the formula of {self._part}: {error}; of the lists that the formula is called with, {lengths}") from error
        if isinstance(given, str):
            raise TypeError(f"the formula of {self._part} is text, '{given}'; write it with handles, such as 0.5 * x.v**2 for a coordinate x")
        is_one = isinstance(given, Expression) or not isinstance(given, Iterable) or getattr(given, "ndim", 1) == 0
        try:
            return [operand(x) for x in ([given] if is_one else given)], is_one
        except TypeError as error:
            raise TypeError(f"the formula of {self._part}: {error}") from None

    def _place(self, symbol: Symbol) -> str:
        """A symbol as an entry of a list, to which it is added if it is new."""
        self._own(symbol)
        if symbol.list not in _ALLOWED[self._kind]:
            allowed = ", ".join(_WORDS[of] for of in _ALLOWED[self._kind])
            raise SceneError(f"{self._part} reads `{symbol.label}`, but such a formula may read {allowed} only")
        if symbol.list == "t":
            return "t"
        known = self._lists[_FIELDS[symbol.list]]
        if symbol.key not in known:
            known.append(symbol.key)
        return f"{symbol.list}[{known.index(symbol.key)}]"

    @property
    def key(self) -> tuple[Any, ...]:
        """Formulas with equal keys differ in the names in their lists only."""
        return self._kind, *self._parts, "=", *self._texts, *(len(names) for names in self._lists.values())

    @property
    def fields(self) -> dict[str, Any]:
        """The entries of the part."""
        count = len(self._constants)
        # Constants come first, then design variables by their names.
        lists = {**self._lists, "b": self._constants + [f"`{key}`" for key in self._lists["b"][count:]]}
        fields: dict[str, Any] = {of: names for of, names in lists.items() if names}
        if self._parts:
            fields["parts"] = self._parts
        return {**fields, "formula": self._texts[0] if self._is_one else self._texts}
