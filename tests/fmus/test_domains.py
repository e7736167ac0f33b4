"""An operation outside its domain, or an index out of bounds, is an error of the FMU that names its place.

Sections are those of the Modelica Language Specification 3.6: 3.7.1.2 (domains of the functions), 10.5.1 (subscripts),
3.3 (branches of if-expressions are evaluated only if their condition holds).
"""

import math
import re

import pytest
from corpus.case import paragraphs
from fmpy.fmi1 import FMICallException

RISING = "model M\n Real x(start=0,fixed=true);\n"

UNDEFINED = [(*comment.split(" | ", 3), text) for comment, text in paragraphs("domains.mo")]


@pytest.mark.parametrize(("last", "line", "words", "text"), [pytest.param(*c[1:], id=c[0]) for c in UNDEFINED])
def test_a_value_that_is_not_defined_ends_the_run_at_its_place(modelica, run, last, line, words, text):
    messages, time = end_of_run(modelica, run, text)
    (message,) = [m for m in messages if "domain error" in m]
    assert re.search(words, message)
    number = int(re.search(r"\.mo:(\d+)\)", message)[1])
    assert line in text.splitlines()[number - 1]
    assert time <= float(last) + 0.05  # not later than at the end of the communication step


def end_of_run(modelica, run, text, start=None):
    """Return the messages of a run that fails, and the last time at which it succeeded."""
    fmu = modelica(text)
    messages, time = [], 0.0
    with pytest.raises(FMICallException):  # noqa: PT012
        instance = run(fmu, start=start, messages=messages)
        for k in range(40):
            instance.steps(1, 0.05, first=k)
            time = 0.05 * (k + 1)
    return messages, time


@pytest.mark.parametrize(
    ("declarations", "equations", "start", "words"),
    [
        (" parameter Real p = 1;\n Real y;\n", " der(x) = 1;\n y = 2/p;\n", {"p": 0.0}, r"2/p: the divisor"),
        (" parameter Real p = 1;\n parameter Real q = sqrt(p);\n", " der(x) = q;\n", {"p": -1.0},
        r"sqrt\(p\): .* -1\."),
        (" parameter Real p = 1;\n Real z(start=log(p),fixed=true);\n", " der(x) = 1;\n der(z) = 1;\n", {"p": 0.0},
        r"log\(p\)"),
        (" parameter Real m = 1;\n Real z;\n", " der(x) = 1;\n m*z = x + 1;\n", {"m": 0.0},
        r"solved for z, whose coefficient"),
    ],
    ids=["parameter", "dependent parameter", "start value", "coefficient"],
)  # fmt: skip
def test_parameters_are_checked_at_initialisation(modelica, run, declarations, equations, start, words):
    messages, _ = end_of_run(modelica, run, f"{RISING}{declarations}equation\n{equations}end M;\n", start)
    assert any("domain error" in m and re.search(words, m) for m in messages)


FUNCTION = (
    "package P function f input Real u; output Real y; algorithm if u > 0 then y := sqrt(u); else y := -1; end if;"
    " end f;"
)

# Equations → value of y at 1 s, where x = time - 0.5: what is not evaluated need not be defined.
GUARDED = {
    "if": ("y = if x > 0 then sqrt(x) else 0;", math.sqrt(0.5)),
    "else": ("y = if x < 0 then 1 else sqrt(x);", math.sqrt(0.5)),
    "noEvent": ("y = noEvent(if x > 0 then log(x) else 7);", math.log(0.5)),
    "noEvent outside": ("y = if noEvent(x > 0) then 1/x else 7;", 2.0),
    "elseif": ("y = if x < -0.2 then 1 elseif x <= 0 then 2 else log10(x);", math.log10(0.5)),
    "nested": ("y = if x > 0 then (if sqrt(x) > 0.1 then log(x) else 5) else 7;", math.log(0.5)),
    "and": ("y = if x > 0 and log(x) > -9 then 3 else 4;", 3.0),
    "or": ("y = if x <= 0 or log(x) > 0 then 3 else 4;", 4.0),
    "maximum": ("y = sqrt(max(x, 0));", math.sqrt(0.5)),
    "function": ("y = P.f(x);", math.sqrt(0.5)),
    "when": ("when x > 0.25 then y = log(x); end when;", math.log(0.25)),
    "shared by branches": ("y = noEvent(if x > 0.3 then sqrt(x) elseif x > 0.2 then 2*sqrt(x) else 0);",
        math.sqrt(0.5)),
    "nested relation left behind": ("y = if x < 0 then (if sqrt(-x) > 0.2 then 1 else 2) else 3;", 3.0),
    "relation and logarithm left behind": ("y = if x < 0 and log(-x) < -1 then 3 else 4;", 4.0),
    "index": ("y = noEvent(if time < 2 then t[1 + integer(time + 0.5)] else t[3]);", 2.0),
}  # fmt: skip


def test_guarded_operations_need_not_be_defined(built, run, written):
    """Closed forms, all in one class; y at an event is that of the event's time, located within 1e-10 s."""
    declarations, equations = list[str](), list[str]()
    for k, (equation, _) in enumerate(GUARDED.values()):
        declarations.append(f"discrete Real y{k}(start=0,fixed=true);" if "when" in equation else f"Real y{k};")
        equations.append(re.sub(r"\by\b", f"y{k}", equation.replace("P.f", "f").replace("t[3]", "t[2]")))
    file = written(
        f"{FUNCTION}\nmodel M Real x(start=-0.5,fixed=true); parameter Real t[2] = {{1, 2}};\n"
        + "\n".join([*declarations, "equation", "der(x) = 1;", *equations, "end M;", "end P;", ""]),
    )
    instance = run(built(file, "P.M"))
    instance.steps(10, 0.1)
    found = dict(zip(GUARDED, instance.get(*(f"y{k}" for k in range(len(GUARDED)))), strict=True))
    assert found == pytest.approx({form: expected for form, (_, expected) in GUARDED.items()}, rel=1e-6)


def test_a_guarded_root_in_a_derivative_passes_its_boundary(modelica, run):
    """dx/dt = -1 - √(x + ½) until x = -½ at 2(s - ln(1 + s)), s = √½; then dx/dt = -1."""
    text = f"{RISING} equation der(x) = -1 - (if x > -0.5 then sqrt(x + 0.5) else 0); end M;"
    instance = run(modelica(text))
    instance.steps(10, 0.1)
    root = math.sqrt(0.5)
    touch = 2 * (root - math.log(1 + root))
    assert instance.get("x")[0] == pytest.approx(-0.5 - (1 - touch), abs=1e-5)  # ten times the relative tolerance


def test_an_overflow_is_an_error_when_it_is_read(modelica, run):
    instance = run(modelica(f"{RISING} Real y; equation der(x) = 1; y = exp(1000*(x + 0.5)); end M;"))
    instance.steps(5, 0.1)
    with pytest.raises(FMICallException):
        instance.get("y")
    assert any("is inf at time" in m for m in instance.messages)
    large = run(modelica(f"{RISING} Integer k(start=2000000000,fixed=true);\nequation der(x) = 1;\n"
                         " when sample(0.1, 0.1) then k = 2*pre(k); end when; end M;"))  # fmt: skip
    large.steps(5, 0.1)
    with pytest.raises(FMICallException):
        large.count("k")
    assert any("beyond 32 bits" in m for m in large.messages)
