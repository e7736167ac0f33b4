"""Functions and algorithms give the values of their closed forms, or are refused with file, line and remedy."""

import pytest

from railgrip.base.errors import InputError
from railgrip.fmus.native import lower
from railgrip.fmus.native.dae import read

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
def test_a_function_has_the_value_of_its_closed_form(written, form):
    declarations, statements, call, expected = SUPPORTED[form]
    model = lower("P.M", written(text_of(declarations, statements, call)))
    assert model.output(0, model.initial([]), [], []).full().item() == pytest.approx(expected, rel=1e-14)


def text_of(declarations, statements, call):
    return (
        f"package P\nfunction f\n {declarations}\nalgorithm\n {statements}\nend f;\nmodel M\n Real "
        f"x(start={X},fixed=true);\n"
        f" output Real y;\nequation\n der(x) = -x;\n y = {call};\nend M;\nend P;\n"
    )


def test_an_algorithm_that_is_not_supported_is_refused_at_its_line_not_at_that_of_a_function(written):
    file = written(
        "package P\nfunction f\n input Real u;\n output Real y;\nalgorithm\n y := u;\nend f;\nmodel M\n"
        " output Real y(start=2);\nalgorithm\n if time > 1 then\n  y := f(time);\n end if;\nend M;\nend P;\n",
        "P.mo",
    )
    with pytest.raises(InputError) as refusal:
        read("P.M", file)
    assert str(refusal.value).startswith("P.mo:10: P.M: this algorithm section")
    assert "P.mo:5" not in str(refusal.value)
