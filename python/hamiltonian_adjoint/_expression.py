"""Expressions: formulas that operators and functions of numpy write."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from ._names import suggestion

_BRANCH = (
    "the value of an expression is not known while the formula is written, so that it cannot decide an `if`, `and`, `or`, `not` or a chain of comparisons; "
    "write `where(x < y, a, b)`, `maximum(x, y)` or `minimum(x, y)`"
)

_JUMPS = "`{}` of an expression has no formula, because its value jumps; use numpy.sin and numpy.cos of an angle that turns, or `where`"


def _number(x: Any) -> float:
    """A number as it can be written in a formula."""
    value = float(x)
    if not math.isfinite(value):
        raise ValueError(f"{value} cannot be part of a formula; numbers must be finite")
    return value


def _is_number(x: Any) -> bool:
    is_real = isinstance(x, (int, float, np.integer, np.floating)) and not isinstance(x, bool)
    return is_real or isinstance(x, np.ndarray) and x.ndim == 0 and x.dtype.kind in "iuf"


def _operand(x: Any) -> Expression | float | None:
    if isinstance(x, Expression):
        return x
    if _is_number(x):
        return _number(x)
    if isinstance(x, np.ndarray) and x.ndim == 0 and isinstance(x.item(), Expression):
        return x.item()
    return None


def operand(x: Any) -> Expression | float:
    """An expression or a number; raises a TypeError for anything else."""
    result = _operand(x)
    if result is None:
        raise TypeError(f"{x!r} is not part of a formula: an expression or a number is expected, not a {type(x).__name__}")
    return result


def _binary(template: str) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """The methods of an operator for both orders of its operands."""

    def method(self: Expression, other: Any) -> Any:
        other = _operand(other)
        return NotImplemented if other is None else Expression(template, (self, other))

    def reflected(self: Expression, other: Any) -> Any:
        other = _operand(other)
        return NotImplemented if other is None else Expression(template, (other, self))

    return method, reflected


def _unary(template: str, name: str) -> Callable[[Expression], Expression]:
    def method(self: Expression) -> Expression:
        return Expression(template, (self,))

    method.__name__ = name
    method.__doc__ = f"The function {name}."
    return method


def _without_formula(sign: str) -> Callable[..., Any]:
    def method(*operands: Any) -> Any:
        raise TypeError(_JUMPS.format(sign))

    return method


def _comparison(sign: str) -> Callable[[Expression, Any], Condition]:
    def method(self: Expression, other: Any) -> Condition:
        return Condition(sign, self, operand(other))

    return method


class Expression:
    """A number of a formula whose value is not known yet: operators and functions of numpy record what is computed with it."""

    __slots__ = ("_template", "_operands")

    def __init__(self, template: str, operands: tuple[Expression | float, ...]) -> None:
        self._template = template
        self._operands = operands

    __add__, __radd__ = _binary("{} + {}")
    __sub__, __rsub__ = _binary("{} - {}")
    __mul__, __rmul__ = _binary("{} * {}")
    __truediv__, __rtruediv__ = _binary("{} / {}")
    __lt__ = _comparison("<")
    __gt__ = _comparison(">")
    __le__ = _comparison("<=")
    __ge__ = _comparison(">=")
    __mod__ = __rmod__ = _without_formula("%")
    __floordiv__ = __rfloordiv__ = __divmod__ = __rdivmod__ = _without_formula("//")
    __round__ = _without_formula("round")
    __floor__ = __ceil__ = __trunc__ = _without_formula("floor")
    __neg__ = _unary("-{}", "negative")
    __abs__ = absolute = fabs = _unary("abs({})", "absolute")
    sqrt = _unary("sqrt({})", "sqrt")
    exp = _unary("exp({})", "exp")
    expm1 = _unary("expm1({})", "expm1")
    log = _unary("ln({})", "log")
    log1p = _unary("ln1p({})", "log1p")
    sin = _unary("sin({})", "sin")
    cos = _unary("cos({})", "cos")
    tan = _unary("tan({})", "tan")
    arcsin = _unary("asin({})", "arcsin")
    arccos = _unary("acos({})", "arccos")
    arctan = _unary("atan({})", "arctan")
    sinh = _unary("sinh({})", "sinh")
    cosh = _unary("cosh({})", "cosh")
    tanh = _unary("tanh({})", "tanh")

    def __pos__(self) -> Expression:
        return self

    def __pow__(self, n: Any, modulo: None = None) -> Expression:
        exponent = _operand(n)
        if exponent is None or modulo is not None:
            return NotImplemented
        if isinstance(exponent, Expression):
            return (exponent * self.log()).exp()
        if exponent.is_integer() and abs(exponent) < 2**31:
            return Expression("{} ^ " + str(int(exponent)), (self,))
        return Expression(f"pow({{}}, {exponent!r})", (self,))

    def __rpow__(self, base: Any) -> Expression:
        base = _operand(base)
        if base is None:
            return NotImplemented
        if not base > 0.0:
            raise ValueError(f"the base of {base} ** x must be positive")
        return (self * math.log(base)).exp()

    def arctan2(self, x: Any) -> Expression:
        """The angle of the point (x, self)."""
        return Expression("atan2({}, {})", (self, operand(x)))

    def hypot(self, other: Any) -> Expression:
        """The square root of the sum of both squares."""
        return (self**2 + operand(other) ** 2).sqrt()

    def maximum(self, other: Any) -> Expression:
        """The larger of both."""
        return Expression("max({}, {})", (self, operand(other)))

    def minimum(self, other: Any) -> Expression:
        """The smaller of both."""
        return Expression("min({}, {})", (self, operand(other)))

    def clip(self, least: Any, most: Any, out: None = None) -> Expression:
        """The nearest number between two bounds."""
        return self.maximum(least).minimum(most)

    def sign(self) -> Expression:
        """−1, 0 or 1."""
        return where(self < 0.0, -1.0, where(self > 0.0, 1.0, 0.0))

    def square(self) -> Expression:
        """The square."""
        return self**2

    def reciprocal(self) -> Expression:
        """1 divided by this number."""
        return 1.0 / self

    def conjugate(self) -> Expression:
        """The number itself, which is real."""
        return self

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if isinstance(self, Symbol) and isinstance(other, Symbol):
            return self.identity == other.identity
        if _operand(other) is not None:
            raise TypeError("`==` of an expression is not known while the formula is written; write `where(abs(x - y) < tolerance, a, b)`")
        return NotImplemented

    def __hash__(self) -> int:
        return id(self)

    def __bool__(self) -> bool:
        raise TypeError(_BRANCH)

    def __float__(self) -> float:
        raise TypeError(
            f"{self!r} has no value while the formula is written; use functions of numpy, such as numpy.sin(x), instead of math.sin(x) or float(x); "
            "values over time, as of numpy.interp, are those of a control: inputs[force] = numpy.interp(inputs.times, …)"
        )

    __int__ = __complex__ = __float__

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            known = [] if name.startswith("_") else [of for of in dir(type(self)) if not of.startswith("_")]
            quantities = getattr(type(self), "_QUANTITIES", "")
            raise AttributeError(f"{type(self).__name__.lower()}s have no attribute {name!r}{quantities or suggestion(name, known, 0)}")

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **keywords: Any) -> Any:
        if method != "__call__" or keywords:
            raise TypeError(f"numpy.{ufunc.__name__}.{method} of expressions is not supported; make an array of them: numpy.array([x, y])")
        if not any(isinstance(x, np.ndarray) and x.ndim for x in inputs):
            return _apply(ufunc, inputs)
        return _elementwise(lambda *of: _apply(ufunc, of), inputs)

    def __repr__(self) -> str:
        return _shown(self, 6)[0]


class Condition:
    """A comparison of two expressions, for `where`."""

    __slots__ = ("_sign", "_x", "_y")

    def __init__(self, sign: str, x: Expression | float, y: Expression | float) -> None:
        self._sign, self._x, self._y = sign, x, y

    def __bool__(self) -> bool:
        raise TypeError(_BRANCH)

    def __repr__(self) -> str:
        return f"{_shown(self._x, 5)[0]} {self._sign} {_shown(self._y, 5)[0]}"


_LABELS = {"v": ".v", "v_dot": ".a", "p_star": ".p", "p_star_dot": ".p_dot", "u_dot": ".rate", "sigma": ".sigma", "lambda": ".lam"}


class Symbol(Expression):
    """A name in formulas: an entry of one of the lists q, v, u, b … of a scene, or the time."""

    __slots__ = ("list", "key", "scene")

    def __init__(self, list: str, key: Any, scene: Any = None) -> None:
        super().__init__("", ())
        self.list, self.key, self.scene = list, key, scene

    @property
    def identity(self) -> tuple[str, Any, int]:
        return self.list, self.key, id(self.scene)

    @property
    def name(self) -> str:
        """The name in the scene."""
        return str(self.key)

    @property
    def label(self) -> str:
        """The name as it is shown in formulas: `cart.x.v` for the velocity of `cart.x`."""
        return self.name + _LABELS.get(self.list, "")

    def __hash__(self) -> int:
        return hash(self.identity)

    def __reduce__(self) -> Any:
        return type(self)._of, (self.list, self.key, self.scene)

    @classmethod
    def _of(cls, list: str, key: Any, scene: Any) -> Symbol:
        made = cls.__new__(cls)
        Symbol.__init__(made, list, key, scene)
        return made


t = Symbol("t", "t")


def _method(name: str) -> Callable[..., Any]:
    def call(x: Any, *more: Any) -> Any:
        if isinstance(x, Expression):
            return getattr(x, name)(*more)
        return getattr(np, name)(x)

    return call


def _pair(name: str) -> Callable[..., Any]:
    templates = {"maximum": "max({}, {})", "fmax": "max({}, {})", "minimum": "min({}, {})", "fmin": "min({}, {})", "arctan2": "atan2({}, {})"}

    def call(x: Any, y: Any) -> Any:
        x, y = operand(x), operand(y)
        if not isinstance(x, Expression) and not isinstance(y, Expression):
            return float(getattr(np, name)(x, y))
        return Expression(templates[name], (x, y)) if name in templates else (x**2 + y**2).sqrt()

    return call


_UFUNCS: dict[str, Callable[..., Any]] = {
    "add": operator.add,
    "subtract": operator.sub,
    "multiply": operator.mul,
    "divide": operator.truediv,
    "power": operator.pow,
    "float_power": operator.pow,
    "negative": operator.neg,
    "positive": operator.pos,
    "less": operator.lt,
    "less_equal": operator.le,
    "greater": operator.gt,
    "greater_equal": operator.ge,
    "equal": operator.eq,
    **{name: _pair(name) for name in ("maximum", "minimum", "fmax", "fmin", "arctan2", "hypot")},
    **{
        name: _method(name)
        for name in "absolute fabs sqrt exp expm1 log log1p sin cos tan arcsin arccos arctan sinh cosh tanh sign square reciprocal conjugate".split()
    },
}


def _apply(ufunc: np.ufunc, operands: Iterable[Any]) -> Any:
    """A function of numpy for expressions and numbers."""
    name = ufunc.__name__
    if name not in _UFUNCS:
        raise TypeError(f"numpy.{name} has no formula; known functions are {', '.join(sorted(_UFUNCS))}, and hamiltonian_adjoint.where")
    return _UFUNCS[name](*map(operand, operands))


def _elementwise(function: Callable[..., Any], operands: Iterable[Any]) -> Any:
    """Applies a function to arrays of expressions, element by element."""

    def boxed(x: Any) -> np.ndarray:
        if isinstance(x, np.ndarray):
            return x.astype(object)
        box = np.empty((), dtype=object)
        box[()] = x
        return box

    boxes = [boxed(x) for x in operands]
    return np.frompyfunc(function, len(boxes), 1)(*boxes)


def _of_arrays(function: Callable[..., Any], *operands: Any) -> Any:
    operands = tuple(np.array(x, dtype=object) if isinstance(x, (list, tuple)) else x for x in operands)
    if any(isinstance(x, np.ndarray) and x.ndim for x in operands):
        return _elementwise(function, operands)
    return function(*operands)


def where(condition: Any, a: Any, b: Any) -> Any:
    """a if the condition, such as `x < y`, holds, and b otherwise; also for arrays, element by element."""
    if any(isinstance(of, bool) for of in (condition if isinstance(condition, (list, tuple)) else [condition])):
        raise TypeError(
            "the condition of `where` is True or False already, as `x == y` of two quantities is, which compares names; "
            "write a comparison such as `x < y` or `abs(x - y) < tolerance`, or `a if condition else b`"
        )

    def one(condition: Any, a: Any, b: Any) -> Any:
        if isinstance(condition, (bool, np.bool_)):
            return operand(a if condition else b)
        if not isinstance(condition, Condition):
            raise TypeError(f"the first argument of `where` must be a comparison such as `x < y`, not {condition!r}")
        template = "if({} " + condition._sign + " {}, {}, {})"
        return Expression(template, (condition._x, condition._y, operand(a), operand(b)))

    return _of_arrays(one, condition, a, b)


def maximum(x: Any, y: Any) -> Any:
    """The larger of two expressions; also for arrays, element by element."""
    return _of_arrays(_pair("maximum"), x, y)


def minimum(x: Any, y: Any) -> Any:
    """The smaller of two expressions; also for arrays, element by element."""
    return _of_arrays(_pair("minimum"), x, y)


def _shown(x: Expression | float, depth: int) -> tuple[str, bool]:
    """The text of an expression to some depth, and whether an operator is outermost."""
    if not isinstance(x, Expression):
        return f"{x:g}", x < 0
    if isinstance(x, Symbol):
        return x.label, False
    if depth == 0:
        return "…", False
    template = x._template
    is_operator = "(" not in template
    parts = (_shown(part, depth - 1) for part in x._operands)
    return template.format(*(f"({text})" if is_operator and inner else text for text, inner in parts)), is_operator


def write(results: Iterable[Expression | float], name: Callable[[Symbol], str]) -> tuple[list[str], list[str]]:
    """Expressions as text: parts with one operation each, which may refer to earlier ones as `$1`, `$2` …, and the results."""
    results = list(results)
    parts: list[str] = []
    texts: dict[int, str] = {}

    def text(x: Expression | float) -> str:
        return texts[id(x)] if isinstance(x, Expression) else repr(x)

    # A stack instead of recursion, so that expressions may be deep.
    stack = [x for x in reversed(results) if isinstance(x, Expression)]
    while stack:
        x = stack[-1]
        if id(x) in texts:
            stack.pop()
        elif isinstance(x, Symbol):
            texts[id(x)] = name(x)
        elif missing := [part for part in x._operands if isinstance(part, Expression) and id(part) not in texts]:
            stack.extend(reversed(missing))
        else:
            parts.append(x._template.format(*map(text, x._operands)))
            texts[id(x)] = f"${len(parts)}"
    if len(results) == 1 and parts and text(results[0]) == f"${len(parts)}":
        return parts[:-1], [parts[-1]]
    return parts, [text(x) for x in results]
