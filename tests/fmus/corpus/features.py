"""Expressions of the language, each with the same in Python.

`u` is a Real, which each context replaces by a name. Section numbers are those of the Modelica Language Specification,
3.6.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Formula = Callable[[float], float]


@dataclass(frozen=True, slots=True)
class Feature:
    """An expression of one Real.

    Attributes:
        text: Modelica, with `u` for the Real.
        formula: The same in Python.
        domain: Name of the signal in `contexts.SIGNALS` whose values the Real has.
        smooth: Whether it is differentiable.
    """

    text: str
    formula: Formula
    domain: str = "wave"
    smooth: bool = True


def _steps(text: str, formula: Formula, domain: str = "wave") -> Feature:
    return Feature(text, formula, domain, smooth=False)


def _of(condition: str, test: Callable[[float], bool]) -> Feature:
    """A Boolean as 2 or -1."""
    return _steps(f"(if {condition} then 2 else -1)", lambda x: 2.0 if test(x) else -1.0)


def _rem(a: float, b: float) -> float:
    return a - math.trunc(a / b) * b


def _mod(a: float, b: float) -> float:
    return a - math.floor(a / b) * b


A = np.array([[1.0, 2.0], [3.0, 4.0]])
B = np.array([[0.5, -1.0, 2.0], [1.0, 3.0, -2.0]])

FEATURES = {
    # 3.4, 10.6: arithmetic operators, their precedence and association
    "plus": Feature("u + 2", lambda x: x + 2),
    "unary minus": Feature("-u + 1", lambda x: -x + 1),
    "unary plus": Feature("+u", lambda x: x),
    "minus is left associative": Feature("10 - u - 3", lambda x: 10 - x - 3),
    "division is left associative": Feature("8/u/2", lambda x: 8 / x / 2, "positive"),
    "division before minus": Feature("1 - u/4*2", lambda x: 1 - x / 4 * 2),
    "unary minus and power": Feature("-u^2", lambda x: -(x**2)),
    "unary minus of a product": Feature("-u*3 - 2*(-u)", lambda x: -x),
    "power of a negative base": Feature("(-u)^3", lambda x: -(x**3)),
    "power with a Real exponent": Feature("u^1.7", lambda x: x**1.7, "positive"),
    "power with a negative exponent": Feature("u^(-2)", lambda x: x**-2, "positive"),
    "power with an exponent of zero": Feature("u^0 + u", lambda x: 1 + x),
    "power of five": Feature("u^5", lambda x: x**5),
    "exponent that varies": Feature("2^u", lambda x: 2**x),
    "power in brackets": Feature("(2^u)^2", lambda x: 4**x),
    "elementwise power of scalars": Feature("u.^2", lambda x: x**2),
    "Integer division gives a Real": Feature("u + 3/2", lambda x: x + 1.5),
    "numbers with exponents": Feature("1e-1*u + 2.5E+1 - .5", lambda x: 0.1 * x + 24.5),
    # 3.7.1: numeric functions
    "abs": _steps("abs(u)", abs),
    "sign": _steps("sign(u)", lambda x: float(np.sign(x))),
    "sqrt": Feature("sqrt(u)", math.sqrt, "positive"),
    "integer of an enumeration": Feature("u + Integer(Shared.Gear.high)", lambda x: x + 3),
    # 3.7.2: functions that trigger events
    "div": _steps("div(u, 0.5)", lambda x: math.trunc(x / 0.5)),
    "div by a negative number": _steps("div(u, -0.7)", lambda x: math.trunc(x / -0.7)),
    "mod": _steps("mod(u, 0.7)", lambda x: _mod(x, 0.7)),
    "mod by a negative number": _steps("mod(u, -0.7)", lambda x: _mod(x, -0.7)),
    "rem": _steps("rem(u, 0.7)", lambda x: _rem(x, 0.7)),
    "rem by a negative number": _steps("rem(u, -0.7)", lambda x: _rem(x, -0.7)),
    "floor": _steps("floor(u)", math.floor),
    "ceil": _steps("ceil(u)", math.ceil),
    "integer": _steps("integer(2*u)", lambda x: math.floor(2 * x)),
    "floor of a floor": _steps("floor(floor(3*u)/2)", lambda x: math.floor(math.floor(3 * x) / 2)),
    # 3.7.3: elementary functions
    "sin": Feature("sin(3*u)", lambda x: math.sin(3 * x)),
    "cos": Feature("cos(u)", math.cos),
    "tan": Feature("tan(u)", math.tan, "unit"),
    "asin": Feature("asin(u)", math.asin, "unit"),
    "acos": Feature("acos(u)", math.acos, "unit"),
    "atan": Feature("atan(u)", math.atan),
    "atan2": Feature("atan2(u, -1)", lambda x: math.atan2(x, -1), "positive"),
    "atan2 in all quadrants": Feature("atan2(sin(2*u), 1.2 + cos(2*u))",
                                      lambda x: math.atan2(math.sin(2 * x), 1.2 + math.cos(2 * x))),
    "sinh": Feature("sinh(u)", math.sinh),
    "cosh": Feature("cosh(u)", math.cosh),
    "tanh": Feature("tanh(u)", math.tanh),
    "exp": Feature("exp(-u)", lambda x: math.exp(-x)),
    "log": Feature("log(u)", math.log, "positive"),
    "log10": Feature("log10(u)", math.log10, "positive"),
    # 3.7.4: derivative and special operators
    "semiLinear": _steps("semiLinear(u, 2, 3)", lambda x: 2 * x if x >= 0 else 3 * x),
    "homotopy": Feature("homotopy(u^2, u)", lambda x: x * x),
    "smooth": _steps("smooth(0, if u > 0 then u else 0)", lambda x: max(x, 0)),
    "smooth of first order": _steps("smooth(1, if u > 0 then u^2 else -u^2)", lambda x: x * abs(x)),
    # 3.7.5: noEvent
    "noEvent": _steps("noEvent(if u > 0.5 then u else 0.5)", lambda x: max(x, 0.5)),
    "noEvent guards a domain": _steps("noEvent(if u > 0 then sqrt(u) else 0)", lambda x: math.sqrt(max(x, 0))),
    "noEvent of abs": _steps("noEvent(abs(u))", abs),
    # 10.3.4: reductions of two scalars
    "min of two": _steps("min(u, 1)", lambda x: min(x, 1)),
    "max of two": _steps("max(0.5, u)", lambda x: max(x, 0.5)),
    # 3.3, 3.6.5: if expressions
    "if expression": _steps("(if u > 1 then 3 else u)", lambda x: 3 if x > 1 else x),
    "elseif": _steps("(if u > 1.5 then 3 elseif u > 0 then 2*u elseif u > -0.5 then 1 else u)",
                     lambda x: 3 if x > 1.5 else 2 * x if x > 0 else 1 if x > -0.5 else x),
    "nested if expressions": _steps("(if u > 0 then if u > 1 then 1 else u else if u < -0.5 then -0.5 else 0)",
                                    lambda x: min(x, 1) if x > 0 else -0.5 if x < -0.5 else 0),
    "if expression in a sum": _steps("1 + (if u > 0 then 1 else 2)*3", lambda x: 4 if x > 0 else 7),
    "else takes the whole rest": _steps("(if u > 0 then 1 else 2*3 + 1)", lambda x: 1 if x > 0 else 7),
    # 3.5, 3.6: relations and logical operators
    "less": _of("u < 0.6", lambda x: x < 0.6),
    "less or equal": _of("u <= 0.6", lambda x: x <= 0.6),
    "greater": _of("u > 0.6", lambda x: x > 0.6),
    "greater or equal": _of("u >= 0.6", lambda x: x >= 0.6),
    "not": _of("not u > 0.6", lambda x: not x > 0.6),
    "and before or": _of("u > 2 or u < 1 and u > 0", lambda x: x > 2 or (x < 1 and x > 0)),
    "not before and": _of("not u > 1 and u > 0", lambda x: (not x > 1) and x > 0),
    "brackets of or": _of("(u > 2 or u < 1) and u > 0", lambda x: (x > 2 or x < 1) and x > 0),
    "sum in a relation": _of("u + 1 > 2*u - 0.5", lambda x: x < 1.5),
    "equality of Booleans": _of("(u > 0) == (u > 1)", lambda x: (x > 0) == (x > 1)),
    "inequality of Booleans": _of("(u > 0) <> (u > 1)", lambda x: (x > 0) != (x > 1)),
    "equality of Integers": _of("integer(u) == 1", lambda x: math.floor(x) == 1),
    "relation of enumerations": _of("(if u > 0 then Shared.Gear.high else Shared.Gear.low) > Shared.Gear.middle",
                                    lambda x: x > 0),
    "equality of enumerations": _of("(if u > 0 then Shared.Gear.high else Shared.Gear.low) == Shared.Gear.low",
                                    lambda x: x <= 0),
    "order of Booleans": _of("(u > 0) > (u > 1)", lambda x: 0 < x <= 1),
    # 10.1 to 10.6: arrays
    "sum of a vector": Feature("sum({u, 2*u, 3})", lambda x: 3 * x + 3),
    "product of a vector": Feature("product({u, 2*u, 3})", lambda x: 6 * x * x),
    "min of a vector": _steps("min({u, 1 - u, 0.8})", lambda x: min(x, 1 - x, 0.8)),
    "max of a vector": _steps("max({u, 1 - u, 0.8})", lambda x: max(x, 1 - x, 0.8)),
    "min of a matrix": _steps("min([u, 1; 2, 0.3])", lambda x: min(x, 0.3)),
    "scalar product": Feature("{u, 2}*{3, u}", lambda x: 5 * x),
    "matrix times vector": Feature("sum([1, 2; 3, 4]*{u, u^2})", lambda x: float(np.sum(A @ [x, x * x]))),
    "vector times matrix": Feature("({u, u^2}*[1, 2; 3, 4])*{1, -1}",
                                   lambda x: float(np.array([x, x * x]) @ A @ [1, -1])),
    "matrix times matrix": Feature("sum(([1, 2; 3, 4]*[0.5, -1, 2; 1, 3, -2])*{u, 1, u})",
                                   lambda x: float(np.sum(A @ B @ [x, 1, x]))),
    "elementwise product": Feature("sum({u, 2} .* {3, u})", lambda x: 5 * x),
    "elementwise division": Feature("sum({u, 2} ./ {2, u})", lambda x: x / 2 + 2 / x, "positive"),
    "elementwise power": Feature("sum({u, 2} .^ {2, 3})", lambda x: x * x + 8),
    "elementwise sum with a scalar": Feature("sum({u, 2} .+ u)", lambda x: 3 * x + 2),
    "elementwise difference with a scalar": Feature("product(u .- {1, 2})", lambda x: (x - 1) * (x - 2)),
    "scalar times vector": Feature("sum(u*{1, 2} + {1, 2}*u)", lambda x: 6 * x),
    "vector over scalar": Feature("sum({u, 2}/2)", lambda x: (x + 2) / 2),
    "negative vector": Feature("sum(-{u, 2})", lambda x: -x - 2),
    "power of a matrix": Feature("sum([u, 1; 0, 2]^3)",
                                 lambda x: float(np.sum(np.linalg.matrix_power(np.array([[x, 1], [0, 2]]), 3)))),
    "function of a vector": Feature("sum(sin({u, 2*u}))", lambda x: math.sin(x) + math.sin(2 * x)),
    "transpose": Feature("sum(transpose([1, 2; 3, 4])*{u, 1})", lambda x: float(np.sum(A.T @ [x, 1]))),
    "identity": Feature("sum(identity(2)*{u, 1})", lambda x: x + 1),
    "diagonal": Feature("sum(diagonal({u, 3})*{2, 1})", lambda x: 2 * x + 3),
    "zeros, ones and fill": Feature("sum(zeros(2) + ones(2)*u + fill(3*u, 2))", lambda x: 8 * x),
    "fill of a matrix": Feature("sum(fill(u, 2, 3))", lambda x: 6 * x),
    "linspace": Feature("linspace(0, u, 5)*{0, 1, 0, 0, 1}", lambda x: 1.25 * x),
    "cross": Feature("cross({u, 1, 2}, {3, u, 1})*{1, 10, 100}",
                     lambda x: float(np.cross([x, 1, 2], [3, x, 1]) @ [1, 10, 100])),
    "skew": Feature("sum(skew({u, 1, 2})*{1, 2, 4})",
                    lambda x: float(np.sum(np.cross([x, 1, 2], [1, 2, 4])))),
    "outerProduct": Feature("sum(outerProduct({u, 1}, {2, 3})*{1, 10})", lambda x: 32 * (x + 1)),
    "symmetric": Feature("sum(symmetric([u, 2; 5, 3])*{1, 10})", lambda x: x + 20 + 2 + 30),
    "scalar of an array": Feature("scalar({{u}})", lambda x: x),
    "vector of a matrix": Feature("sum(vector([u; 2])*2)", lambda x: 2 * x + 4),
    "matrix of a vector": Feature("sum(matrix({u, 2}))", lambda x: x + 2),
    "cat": Feature("cat(1, {u}, {2, 3})*{1, 10, 100}", lambda x: x + 320),
    "brackets join rows and columns": Feature("sum([{u, 1}, {2, 3}; 4, 5]*{1, 10})",
                                              lambda x: x + 1 + 4 + 10 * (2 + 3 + 5)),
    "size": Feature("u*size([1, 2, 3; 4, 5, 6], 2)", lambda x: 3 * x),
    "sizes of a matrix": Feature("size([u, 2, 3; 4, 5, 6])*{1, 10} + u", lambda x: 32 + x),
    "ndims": Feature("u*ndims([1, 2; 3, 4])", lambda x: 2 * x),
    "range": Feature("u*sum(1:4)", lambda x: 10 * x),
    "range with a step": Feature("u*sum(1:2:6)", lambda x: 9 * x),
    "range downwards": Feature("u*((5:-2:1)*{1, 10, 100})", lambda x: 135 * x),
    "range of Reals": Feature("u*sum(0.5:0.5:1.5)", lambda x: 3 * x),
    "empty range": Feature("u + sum(2:1)", lambda x: x),
    "sum over an iterator": Feature("sum(i*u for i in 1:3)", lambda x: 6 * x),
    "product over an iterator": Feature("product(u + i for i in 1:3)", lambda x: (x + 1) * (x + 2) * (x + 3)),
    "max over an iterator": _steps("max(i - u for i in {1, 5, 2})", lambda x: 5 - x),
    "sum over two iterators": Feature("sum(i*u + j for i in 1:2, j in 1:3)", lambda x: 9 * x + 12),
    "array over an iterator": Feature("sum({i*u for i in 1:3})", lambda x: 6 * x),
    "array over an iterator with a step": Feature("{i*u for i in 5:-2:1}*{1, 10, 100}", lambda x: 135 * x),
    "array over two iterators": Feature("sum({u*i + 10*j for i in 1:2, j in 1:3}*{1, 100})",
                                        lambda x: sum((x * i + 10 * j) * w for i, w in ((1, 1), (2, 100))
                                                      for j in (1, 2, 3))),
    # 12: functions
    "function": Feature("Shared.double(u)", lambda x: 2 * x),
    "function with defaults": Feature("Shared.scaled(u)", lambda x: 3 * x + 1),
    "function with a named argument": Feature("Shared.scaled(u, d=2)", lambda x: 3 * x + 2),
    "function with named arguments in another order": Feature("Shared.scaled(d=2, k=4, x=u)", lambda x: 4 * x + 2),
    "function of a function": Feature("Shared.double(Shared.scaled(u, 2))", lambda x: 4 * x + 2),
    "first result of several": Feature("Shared.polar(u)", lambda x: math.hypot(x, 1)),
    "function of an array": Feature("Shared.total({u, 2, u})", lambda x: 4 * x + 4),
    "function that returns an array": Feature("sum(Shared.powers(u, 3))", lambda x: x + x**2 + x**3),
    "function with if": _steps("Shared.clip(u)", lambda x: min(max(x, -0.5), 1)),
    "function with an early return": _steps("Shared.early(u)", lambda x: 5 if x > 1 else x),
    "function with while": Feature("Shared.halvings(u)", lambda x: x / 8),
    "function with break": Feature("Shared.until(u)", lambda x: 4 * x),
    "recursive function": Feature("u*Shared.factorial(4)", lambda x: 24 * x),
    "function that extends": Feature("Shared.square(u)", lambda x: x * x),
    "function with modifiers": Feature("Shared.twice(u)", lambda x: 2 * x),
    "function applied to elements": Feature("sum(Shared.double({u, 1}))", lambda x: 2 * x + 2),
    "function of a record": Feature("Shared.norm(Shared.Pair(u, 1))", lambda x: math.hypot(x, 1)),
    "record with named fields": Feature("Shared.norm(Shared.Pair(b=2, a=u))", lambda x: math.hypot(x, 2)),
    "function returns a record": Feature("Shared.norm(Shared.pair(u))", lambda x: math.hypot(x, x + 1)),
    # 5.3: names
    "constant of a package": Feature("u + Shared.c", lambda x: x + 1.5),
    "global name": Feature("u + .Corpus.Shared.c", lambda x: x + 1.5),
}  # fmt: skip
