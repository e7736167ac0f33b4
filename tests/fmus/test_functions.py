"""Functions and algorithms give the values of their closed forms, or are refused with file, line and remedy."""

import re

import pytest

from railgrip.base.errors import InputError
from railgrip.fmus.native import lower
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.system import explicit

X = 2.0
SIMPLE = "input Real u; output Real y;"

# Declarations of the function, its statements, the call → the value at x = 2.
SUPPORTED = {
    "while that counts": (f"{SIMPLE} protected Integer i;",
        "i := 0; y := u; while i < 3 loop y := y/2; i := i + 1; end while;",
                          "f(x)", X / 8),
    "for with a step": (SIMPLE, "y := 0; for i in 5:-2:1 loop y := 10*y + i; end for;", "f(x)", 531),
    "for over two ranges": (SIMPLE, "y := 0; for i in 1:2, j in 1:3 loop y := 10*y + i*j; end for;", "f(x)", 123246),
    "for over nothing": (SIMPLE, "y := u; for i in 3:1 loop y := 0; end for;", "f(x)", X),
    "default argument": ("input Real u; input Real a = 3*u; output Real y;", "y := u + 10*a;", "f(x)", 62),
    "named argument": ("input Real u; input Real a = 3; output Real y;", "y := u + 10*a;", "f(a = 4, u = x)", 42),
    "first of two outputs": ("input Real u; output Real y; output Real z;", "y := u; z := 2*u;", "f(x) + 1", 3),
    "sizes from an input": (
        "input Real v[:]; output Real y; protected Real w[size(v, 1)];",
        "y := 0; for i in 1:size(v, 1) loop w[i] := v[i]^2; y := y + w[i]; end for;", "f({x, 2, 3})", 17,
    ),
    "slices": ("input Real v[:]; output Real y; protected Real w[2, 3];",
               "w := zeros(2, 3); w[1, :] := v; w[:, {3, 1}] := {{7, 8}, {5, 6}}; y := w[1, 1] + 10*w[1, 3] + "
               "100*w[2, 1];",
               "f({x, 2, 3})", 8 + 70 + 600),
    "index at run time": ("input Real u; input Real v[:]; output Real y;", "y := v[integer(u)];", "f(x, {1, 5, 7})", 5),
    "assigned at an index at run time": (
        "input Real u; output Real y; protected Real A[2, 3];",
        "A := zeros(2, 3); A[integer(u), 3] := 4; A[2, integer(u)] := 5; y := A[2, 3] + 10*A[2, 2] + 100*A[1, 3];",
            "f(x)", 54,
    ),
    "early return": (SIMPLE, "y := 1; if u > 1 then y := 2; return; end if; y := 3;", "f(x)", 2),
    "elseif": (SIMPLE, "y := u; if u > 3 then y := 4; elseif u > 1 then y := 5; else y := 6; end if;", "f(x)", 5),
    "protected value": ("input Real u; output Real y; protected Real z = sqrt(u);", "y := z^2;", "f(x)", X),
    "assigned in a loop only": (SIMPLE, "for i in 1:3 loop y := i*u; end for;", "f(x)", 3 * X),
    "local assigned in a loop only": (
        "input Real u; output Real y; protected Real z;",
        "y := 0; for i in 1:3 loop z := i*u; y := y + z; end for;", "f(x)", 6 * X,
    ),
    "equality of Reals": (SIMPLE, "if u == 2 then y := 1; else y := 0; end if;", "f(x)", 1),
    "vectorised call": (SIMPLE, "y := 10*u;", "sum(f({x, 1}))", 30),
}  # fmt: skip


@pytest.mark.parametrize("form", SUPPORTED)
def test_a_function_has_the_value_of_its_closed_form(tmp_path, form):
    declarations, statements, call, expected = SUPPORTED[form]
    file = tmp_path / "P.mo"
    file.write_text(text_of(declarations, statements, call))
    model = lower("P.M", file)
    assert model.output(0, model.initial([]), [], []).full().item() == pytest.approx(expected, rel=1e-14)


def text_of(declarations, statements, call):
    return (
        f"package P\nfunction f\n {declarations}\nalgorithm\n {statements}\nend f;\nmodel M\n Real "
        f"x(start={X},fixed=true);\n"
        f" output Real y;\nequation\n der(x) = -x;\n y = {call};\nend M;\nend P;\n"
    )


# Statements of f → the line and the words of the refusal.
REFUSED = {
    "while": (
        "y := u; while abs(y) > 1 loop y := y/2; end while;",
        "while",
        "a while loop whose number of repetitions",
    ),
    "break": ("y := 0; for i in 1:5 loop if i > 3 then break; end if; y := y + i; end for;", "break", "break"),
    "return": (
        "y := 0; for i in 1:5 loop y := y + i; if i > 3 then return; end if; end for;",
        "return",
        "return inside a loop",
    ),
    "array iterator": ("y := 0; for v in {1.0, 3.0, u} loop y := y + v; end for;", "for v", "write `for i in 1:size"),
    "Real range": ("y := 0; for i in 0.5:1:2.5 loop y := y + i; end for;", "for i", "must be Integer numbers"),
    "recursion": ("y := if u < 1 then 1 else u*f(u - 1);", "f(u - 1)", "the recursive function P.f"),
    "assert": ('y := u; assert(u > 0, "negative");', "assert", "an assert inside function f"),
    "assert in a loop": (
        'y := u; for i in 1:2 loop y := y + 1; if y > 2 then assert(u > 0, "negative"); end if; end for;',
        "assert",
        "an assert inside function f",
    ),
    "assert alone in loops": (
        'y := u; for i in 1:2 loop for j in 1:2 loop assert(u > i, "low"); end for; end for;',
        "assert",
        "an assert inside function f",
    ),
    "not assigned": ("if u > 3 then y := 1; end if;", "function f", "not assigned in every case"),
    "sizes": ("y := u + {1, 2};", "{1, 2}", "sizes of the arrays do not fit"),
    "square root": ("y := sqrt(-1);", "sqrt", r"sqrt\(-1\): the argument must not be negative"),
    "division": ("y := u/0;", "u/0", "the divisor must not be zero"),
}


@pytest.mark.parametrize("form", REFUSED)
def test_an_unsupported_function_is_refused_with_line_and_remedy(tmp_path, form):
    statements, line, words = REFUSED[form]
    file = tmp_path / "P.mo"
    file.write_text(text_of(SIMPLE, statements, "f(x)"))
    with pytest.raises(InputError, match=words) as refusal:
        explicit(read("P.M", file))
    message = str(refusal.value)
    assert "semantic owner" not in message
    number = int(re.match(r"P\.mo:(\d+): ", message)[1])
    assert line in file.read_text().splitlines()[number - 1]


def test_newtons_iteration_until_it_converges_is_refused_at_its_loop(tmp_path):
    """The form that users write first; the front end names neither file nor line."""
    file = tmp_path / "P.mo"
    file.write_text(
        "package P\nfunction root\n input Real u;\n output Real y;\nprotected\n Real step = 1;\nalgorithm\n y := u;\n"
        " while abs(step) > 1e-9 loop\n  step := (y^2 - u)/(2*y);\n  y := y - step;\n end while;\nend root;\n"
        "model M\n Real s(start=1,fixed=true);\n output Real y = root(s + 1);\nequation\n der(s) = -s;\nend "
        "M;\nend P;\n"
    )
    with pytest.raises(InputError, match=r"P\.mo:9: P\.M: a while loop .* write a for loop with a fixed range"):
        read("P.M", file)


def test_an_algorithm_that_is_not_supported_is_refused_at_its_line_not_at_that_of_a_function(tmp_path):
    file = tmp_path / "P.mo"
    file.write_text(
        "package P\nfunction f\n input Real u;\n output Real y;\nalgorithm\n y := u;\nend f;\nmodel M\n"
        " output Real y(start=2);\nalgorithm\n if time > 1 then\n  y := f(time);\n end if;\nend M;\nend P;\n"
    )
    with pytest.raises(InputError) as refusal:
        read("P.M", file)
    assert str(refusal.value).startswith("P.mo:10: P.M: this algorithm section")
    assert "P.mo:5" not in str(refusal.value)
