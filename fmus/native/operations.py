"""CasADi's scalar operations in C."""

from functools import cache

import casadi as ca

_OF_ONE = (
    "sqrt", "exp", "expm1", "log", "log1p", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh",
    "asinh", "acosh", "atanh", "erf", "fabs", "floor", "ceil",
)  # fmt: skip
_OF_TWO = ("atan2", "hypot", "copysign", "fmod", "remainder", "fmin", "fmax")

IN_C = {
    "OP_ASSIGN": "x",
    "OP_LIFT": "x",
    "OP_ADD": "x + y",
    "OP_SUB": "x - y",
    "OP_MUL": "x * y",
    "OP_DIV": "x / y",
    "OP_NEG": "-x",
    "OP_INV": "1 / x",
    "OP_SQ": "x * x",
    "OP_TWICE": "2 * x",
    "OP_POW": "pow(x, y)",
    "OP_CONSTPOW": "pow(x, y)",
    "OP_SIGN": "x > 0 ? 1 : x < 0 ? -1 : x",
    "OP_LT": "x < y",
    "OP_LE": "x <= y",
    "OP_EQ": "x == y",
    "OP_NE": "x != y",
    "OP_NOT": "!x",
    "OP_AND": "x && y",
    "OP_OR": "x || y",
    "OP_IF_ELSE_ZERO": "x ? y : 0",
    **{f"OP_{name.upper()}": f"{name}(x)" for name in _OF_ONE},
    **{f"OP_{name.upper()}": f"{name}(x, y)" for name in _OF_TWO},
}
"""Name of an operation → C expression of its value; x and y are the operands."""


@cache
def operation_names() -> dict[int, str]:
    """Return the names of all operations by CasADi's numbers."""
    return {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}
