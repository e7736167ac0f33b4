"""Operators and built-in functions on arrays give numpy's values in an FMU, or are refused with file and line.

The rules for shapes below are those of the Modelica Language Specification 3.6, chapter 10, written independently of
the compiler. Operands are a parameter and a variable of each shape.
"""

import re
from itertools import product
from math import prod

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sampling import sample

from railgrip.base.errors import InputError
from railgrip.fmus.native import lower
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.system import explicit

RNG = np.random.default_rng(45)
SHAPES = {"s": (), "v": (3,), "w": (2,), "A": (2, 2), "B": (2, 3), "C": (3, 2), "E": (0,), "F": (2, 0), "G": (0, 2)}
# Two decimals, so that Modelica and numpy read the same numbers; positive, so that every power exists.
VALUES = {name: np.round(RNG.uniform(0.5, 2.5, shape), 2) for name, shape in SHAPES.items()}
SHIFT = 0.25
"""Value of the state, which the variables contain and the parameters do not."""


def dimensions(shape):
    return f"[{', '.join(map(str, shape))}]" if shape else ""


def literal(value):
    return f"{{{', '.join(map(literal, value))}}}" if np.ndim(value) else repr(float(value))


def declarations(text):
    """Return declarations and equations of the operands that occur in a text."""
    lines = [f"Real x(start={SHIFT}, fixed=true);"]
    equations = ["der(x) = -x;"]
    for name, shape in SHAPES.items():
        if not re.search(rf"\bp?{name}\b", text):
            continue
        size = dimensions(shape)
        value = literal(VALUES[name]) if prod(shape) else f"fill(1.0, {', '.join(map(str, shape))})"
        lines += [f"parameter Real p{name}{size} = {value};", f"Real {name}{size};"]
        if prod(shape):
            ranges = ", ".join(f"i{k} in 1:{n}" for k, n in enumerate(shape))
            place = f"[{', '.join(f'i{k}' for k in range(len(shape)))}]" if shape else ""
            equation = f"{name}{place} = p{name}{place} + x;"
            equations.append(f"for {ranges} loop {equation} end for;" if shape else equation)
    return lines, equations


def operand(name, moving):
    return (name, VALUES[name] + SHIFT) if moving else (f"p{name}", VALUES[name])


def values_of(tmp_path, expressions):
    """Return the values of expressions of known shapes, all in one class."""
    lines, equations = declarations(" ".join(text for text, _ in expressions))
    for k, (text, shape) in enumerate(expressions):
        lines.append(f"output Real y{k}{dimensions(shape)};")
        equations.append(f"y{k} = {text};")
    file = tmp_path / "M.mo"
    file.write_text("model M\n" + "\n".join(lines) + "\nequation\n" + "\n".join(equations) + "\nend M;\n")
    model = lower("M", file)
    free = [p.start for p in model.parameters]
    result = dict(
        zip(
            [v.name for v in model.outputs],
            model.output(0.0, model.initial(free), [], free).full().ravel(),
            strict=True,
        )
    )
    found = []
    for k, (_, shape) in enumerate(expressions):
        places = [f"y{k}[{','.join(str(i + 1) for i in place)}]" if shape else f"y{k}" for place in np.ndindex(shape)]
        found.append(np.reshape([result[place] for place in places], shape))
    return found


def check(tmp_path, expressions):
    """Compare expressions, as (text, numpy's value), within the rounding errors of a few operations."""
    found = values_of(tmp_path, [(text, np.shape(value)) for text, value in expressions])
    for (text, expected), value in zip(expressions, found, strict=True):
        np.testing.assert_allclose(value, expected, rtol=1e-13, err_msg=text)


def refusal(tmp_path, text, shape):
    """Return the message for an expression that is not legal, and require its file and line."""
    lines, equations = declarations(text)
    file = tmp_path / "M.mo"
    head = ["model M", *lines, f"output Real y{dimensions(shape)};", "equation", *equations]
    file.write_text("\n".join([*head, f"y = {text};", "end M;", ""]))
    with pytest.raises(InputError) as error:
        explicit(read("M", file))
    message = str(error.value)
    assert f"M.mo:{len(head) + 1}" in message, message
    return message


def times(a, b):
    return a * b if not (np.ndim(a) and np.ndim(b)) else a @ b


OPERATORS = {
    "+": np.add, "-": np.subtract, "*": times, "/": np.divide, "^": np.power,
    ".+": np.add, ".-": np.subtract, ".*": np.multiply, "./": np.divide, ".^": np.power,
}  # fmt: skip


def is_legal(operator, a, b):
    if operator.startswith("."):
        return a == b or a == () or b == ()
    if operator in "+-":
        return a == b
    if operator == "*":
        return a == () or b == () or a[-1] == b[0]
    return b == () and (operator == "/" or a == ())


PAIRS = list(product(OPERATORS, SHAPES, SHAPES))


def test_binary_operators_of_all_shapes_equal_numpy(tmp_path):
    expressions = []
    for k, (operator, a, b) in enumerate(PAIRS):
        if is_legal(operator, SHAPES[a], SHAPES[b]):
            (left, x), (right, y) = operand(a, k % 2), operand(b, k // 2 % 2)
            expressions.append((f"{left} {operator} {right}", OPERATORS[operator](x, y)))
    assert len(expressions) > 150
    check(tmp_path, expressions)


@pytest.mark.parametrize("operator", OPERATORS)
def test_operands_whose_shapes_do_not_fit_are_refused(tmp_path, operator):
    """Where numpy would broadcast, the result has the shape that numpy gives it, so that only the operator is wrong."""
    wrong = []
    for other, a, b in PAIRS:
        if other != operator or is_legal(operator, SHAPES[a], SHAPES[b]):
            continue
        if operator == "^" and SHAPES[a] == (2, 2) and b == "s":
            continue  # a matrix to a power that is no whole number, below
        try:
            shape = np.broadcast_shapes(SHAPES[a], SHAPES[b])
        except ValueError:
            shape = SHAPES[a]
        if prod(shape):  # the front end drops an equation without elements, in which nothing can be wrong
            wrong.append((f"{a} {operator} {b}", shape))
    assert len(wrong) > 10
    for text, shape in sample(wrong, 5):
        refusal(tmp_path, text, shape)


FUNCTIONS = {
    **{f"A^{n}": lambda o, n=n: np.linalg.matrix_power(o["A"], n) for n in (0, 1, 2, 5)},
    "transpose(B)": lambda o: o["B"].T,
    "outerProduct(v, w)": lambda o: np.outer(o["v"], o["w"]),
    "skew(v)*pv": lambda o: np.cross(o["v"], VALUES["v"]),
    "vector({{s}, {ps}})": lambda o: np.array([o["s"], VALUES["s"]]),
    "vector(s)": lambda o: np.array([o["s"]]),
    "cat(1, v, w, E)": lambda o: np.concatenate([o["v"], o["w"]]),
    "cat(1, A, C)": lambda o: np.concatenate([o["A"], o["C"]]),
    "[v; w]": lambda o: np.concatenate([o["v"], o["w"]])[:, None],
    "size(F)": lambda o: np.array([2.0, 0.0]),
    "product(B)": lambda o: np.prod(o["B"]),
    "max(B)": lambda o: np.max(o["B"]),
    "sum(E)": lambda o: np.array(0.0),
    "product(F)": lambda o: np.array(1.0),
    "min(E)": lambda o: np.array(np.finfo(float).max),
    "max(E)": lambda o: np.array(np.finfo(float).min),
    "sum(v[i]*B[2, i] for i in 1:3)": lambda o: o["v"] @ o["B"][1],
    "sum(B[i, j]*C[j, i] for i in 1:2, j in 1:3)": lambda o: np.trace(o["B"] @ o["C"]),
    "max(i*v[i] for i in 1:3)": lambda o: np.max(o["v"] * [1, 2, 3]),
    "min(v[i] - i for i in 3:-1:2)": lambda o: np.min((o["v"] - [1, 2, 3])[1:]),
    "{B[i, j] for i, j}": lambda o: o["B"].T,
    "{i*s for i in {1, 4}}": lambda o: o["s"] * np.array([1.0, 4]),
    "{v[i]*v[4 - i] for i in 1:3}": lambda o: o["v"] * o["v"][::-1],
    "{{B[i, j] + 10*i for j in 1:3} for i in 1:2}": lambda o: o["B"] + np.array([[10.0], [20.0]]),
    "v[3:-2:1]": lambda o: o["v"][::-2],
    "B[2]": lambda o: o["B"][1],
    "B[{2, 1}, {3, 1}]": lambda o: o["B"][np.ix_([1, 0], [2, 0])],
    "B[1:2, 2:3]": lambda o: o["B"][:, 1:],
    "B[end, {1}]": lambda o: o["B"][1, [0]],
    "abs(-B)": lambda o: o["B"],
    "noEvent(if s > ps then v else pv)": lambda o: o["v"],
    "if size(v, 1) == 3 then v else pv": lambda o: o["v"],
    "div(-7, 2)": lambda o: np.array(-3.0),
    "rem(-7, 3)": lambda o: np.fmod(-7.0, 3),
}  # fmt: skip


def test_functions_and_subscripts_equal_numpy(tmp_path):
    variables = {name: value + SHIFT for name, value in VALUES.items()}
    check(tmp_path, [(text, np.asarray(value(variables))) for text, value in FUNCTIONS.items()])


# Expressions against a rule of chapter 10 or against a limit of the compiler → the shape of the left side.
REFUSED = {
    "cross(w, w)": (3,), "skew(w)": (3, 3), "transpose(v)": (3,), "diagonal(A)": (2, 2), "outerProduct(A, w)": (2, 2),
    "vector(A)": (4,), "linspace(0, s, 1)": (1,), "cat(1, A, B)": (4, 2), "cat(2, A, C)": (2, 4),
    "cat(3, A, A)": (2, 4),
    "[A; B]": (4, 2), "[A, C]": (2, 4), "{v, w}": (2, 3), "{v, s}": (2, 3), "size(B, 3)": (), "v[4]": (), "v[0]": (),
    "v[{1, 4}]": (2,), "v[2:4]": (3,), "B[3, 1]": (), "v[1, 1]": (), "v[1.5]": (), "fill(s, -1)": (1,),
    "v == v": (), "A^(-1)": (2, 2), "A^(s)": (2, 2),
    "if s > 1 then v else w": (3,), "symmetric(A)": (2, 2), "scalar({s})": (), "matrix(v)": (3, 1), "ndims(A)": (),
    "not s": (), "s and s": (), "1/0": (), "sqrt(-1)": (), "log(0)": (), "log10(-1)": (), "asin(1.5)": (),
        "acos(-2)": (),
    "atan2(0, 0)": (), "0^(-1)": (), "(-8)^(1/3)": (), "v ./ {1, 0, 2}": (3,), "tan(1.5707963267948966)": (),
    "mod(1, 0)": (), "sum({s/(i - 2) for i in 1:3})": (),
}  # fmt: skip


@pytest.mark.parametrize("text", REFUSED)
def test_an_expression_that_is_wrong_or_unsupported_is_refused(tmp_path, text):
    message = refusal(tmp_path, text, REFUSED[text])
    assert not re.search(r"semantic owner|casadi|Traceback|lambda", message), message


def expressions(shape, depth):
    """Return a strategy of (text, value) of a shape, from all operators."""
    names = [name for name, other in SHAPES.items() if other == shape]
    leaf = st.tuples(st.sampled_from(names), st.booleans()).map(lambda pick: operand(*pick))
    if not depth:
        return leaf
    below = {other: expressions(other, depth - 1) for other in [(), (2,), (3,), (2, 2), (2, 3), (3, 2)]}

    def joined(form, function, *shapes):
        return st.tuples(*(below[s] for s in shapes)).map(
            lambda parts: (form.format(*(text for text, _ in parts)), function(*(value for _, value in parts)))
        )

    options = [leaf, joined("(-{})", np.negative, shape), joined("({} ./ (0.5 .+ abs({})))", lambda a,
    b: a / (0.5 + abs(b)),
                                                                 shape, shape)]  # fmt: skip
    options += [joined(f"({{}} {op} {{}})", OPERATORS[op], shape, shape) for op in ("+", "-", ".*")]
    options += [joined(f"({{}} {op} {{}})", OPERATORS[op], (), shape) for op in (".+", ".-", "*")]
    options += [
        joined("noEvent(if {} > {} then {} else {})", lambda a, b, c, d: c if a > b else d, (), (), shape, shape)
    ]
    if shape == ():
        options += [
            joined(f"{name}({{}})", function, other)
            for name, function in (("sum", np.sum), ("max", np.max), ("min", np.min))
            for other in ((3,), (2, 3))
        ]
        options += [joined("({} * {})", times, (3,), (3,)), joined("({{{0}, {1}}} * {{0, 1}})", lambda a, b: b, (), ())]
    elif len(shape) == 1:
        n = shape[0]
        options += [joined("({} * {})", times, (n, k), (k,)) for k in (2, 3) if (n, k) in below]
        options += [joined("({} * {})", times, (k,), (k, n)) for k in (2, 3) if (k, n) in below]
        options += [joined("vector({{{{{}}}, {{{}}}}})", lambda a, b: np.array([a, b]), (), ())] if n == 2 else []
    else:
        n, m = shape
        options += [joined("transpose({})", np.transpose, (m, n))] if (m, n) in below else []
        options += [joined("({} * {})", times, (n, k), (k, m)) for k in (2, 3) if (n, k) in below and (k, m) in below]
        options += [joined("outerProduct({}, {})", np.outer, (n,), (m,))]
        options += [joined("[{}, {}]", lambda a, b: np.column_stack([a, b]), (n,), (n,))] if m == 2 else []
        options += [joined("({}^2)", lambda a: a @ a, (2, 2))] if n == m else []
    return st.one_of(options)


BATCH = st.tuples(*(expressions(shape, 2) for shape in [(), (2,), (3,), (2, 2), (2, 3), (3, 2)]))


@settings(deadline=None, max_examples=5)
@given(batch=BATCH)
def test_nested_expressions_equal_numpy(tmp_path_factory, batch):
    """Sums of products with cancellation: the tolerance is relative to the largest intermediate values, below 1e6."""
    found = values_of(tmp_path_factory.mktemp("nested"), [(text, np.shape(value)) for text, value in batch])
    for (text, expected), value in zip(batch, found, strict=True):
        np.testing.assert_allclose(value, expected, rtol=1e-9, atol=1e-9, err_msg=text)


def test_a_slice_in_three_dimensions_is_refused_with_what_to_write(written):
    """The front end counts an equation of such a slice as one, whatever its size."""
    file = written("model M\n  output Real v[1, 1, 2];\nequation\n  v[1:1, 1:1, 1:2] = {{{time, 1}}};\nend M;\n")
    with pytest.raises(InputError, match=r"slices in three dimensions such as .* write these as a for loop"):
        lower("M", file)
    file.write_text(
        file.read_text()
        .replace("v[1:1, 1:1, 1:2] =", "for i in 1:1 loop v[i, 1:1, 1:2] =")
        .replace("{{{time, 1}}};", "{{time, 1}}; end for;")
    )
    np.testing.assert_array_equal(lower("M", file).output(3.0, 0, 0, 0), [[3], [1]])
