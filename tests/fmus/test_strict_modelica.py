"""The built-in compiler refuses Modelica that other compilers would read differently; sections of specification 3.6."""

import re
from typing import Any

import casadi as ca
import pytest
import rumoca
from corpus.case import FOLDER, paragraphs

from railgrip.base.errors import InputError, TranslationError
from railgrip.fmus.native import lower
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.library import LIBRARY
from railgrip.fmus.native.system import column, explicit
from railgrip.fmus.native.variables import vector

BASE = (FOLDER / "Strict.mo").read_text()
"""Begin of a package P."""

CASES = [(*comment.split(": ", 1), text) for comment, text in paragraphs("strict.mo")]
"""Group, name and expectation, and text of a class X of the package with what else it needs.

Invalid classes that the front end accepts are `lenient`, `illegal` or, if a value cannot be computed, `undefined`;
others are refused by the `front end`, valid ones are `unsupported` or `right`. Their expectation is the message, as a
regular expression, or values of parameters.
"""


def cases(*groups: str) -> list[Any]:
    """Return (expectation, text) of the cases of groups, whose names are the identifiers."""
    named = [(*about.split("; ", 1), text) for group, about, text in CASES if group in groups]
    return [pytest.param(expectation, text, id=name) for name, expectation, text in named]


def file_of(tmp_path, text):
    file = tmp_path / "P.mo"
    file.write_text(f"{BASE}{text}\nend P;\n")
    return file


@pytest.mark.parametrize(("sentence", "text"), cases("lenient", "illegal", "unsupported"))
def test_invalid_modelica_is_refused_with_file_and_line(tmp_path, sentence, text):
    with pytest.raises(InputError, match=rf"P\.mo:\d+: .*{sentence}"):
        read("P.X", file_of(tmp_path, text), complete=True)


@pytest.mark.parametrize(("sentence", "text"), cases("front end"))
def test_classes_refused_by_the_front_end_are_still_refused(tmp_path, sentence, text):
    """The front end alone refuses them; the compiler then names file and line, if not in its words."""
    file = file_of(tmp_path, text)
    with pytest.raises((rumoca.RumocaError, RuntimeError), match=sentence):
        rumoca.Session(roots=[]).loads(file.read_text(), model="P.X")
    with pytest.raises(InputError, match=r"P\.mo:\d+"):
        read("P.X", file)


@pytest.mark.parametrize(("sentence", "text"), cases("undefined"))
def test_values_that_are_not_finite_numbers_at_build_time_are_refused(tmp_path, sentence, text):
    dae = read("P.X", file_of(tmp_path, text), complete=True)
    with pytest.raises(TranslationError, match=rf"P\.mo:\d+: P\.X: .*{sentence}"):
        explicit(dae)


def test_bounds_and_starts_are_computed_from_defaults_of_parameters(tmp_path):
    text = """model X
      parameter Real p = 2; parameter Integer n = 3; parameter Real q = 2*n;
      function f input Real u; output Real y; algorithm y := 0; for i in 1:3 loop y := y + i*u; end for; end f;
      Real x[2](max = {p^2, sum(1:n)}, each min = -p, each nominal = f(p)) = {time, 1};
      Real z(start = p*q, fixed = true);
    equation
      der(z) = -z;
    end X;"""
    system = explicit(read("P.X", file_of(tmp_path, text)))
    assert [z.start for z in system.states] == [12]  # the Integer n is compiled in, so that q is a number
    scalars = {s.name: s for s in system.algebraics}
    assert scalars["x[1]"].bounds == {"minimum": -2, "maximum": 4, "nominal": 12}
    assert scalars["x[2]"].bounds == {"minimum": -2, "maximum": 6, "nominal": 12}


@pytest.mark.parametrize(("values", "text"), cases("right"))
def test_accepted_classes_have_the_values_defined_by_the_language(tmp_path, values, text):
    expected = {name: float(value) for name, value in (part.split(" = ") for part in values.split("; "))}
    found = parameters(explicit(read("P.X", file_of(tmp_path, text), complete=True)))
    assert {name: found[name] for name in expected} == expected


def parameters(system) -> dict[str, float]:
    """Return the values of all parameters of a class."""
    v = system.variables
    starts = [float(p.start) for p in v.free]
    dependent = ca.Function("f", [vector(v.free)], [column(v.dependent_values)])(starts) if v.dependent else ca.DM()
    names = [p.name for p in [*v.free, *v.dependent]]
    return dict(zip(names, [*starts, *dependent.full().ravel()], strict=True))


def test_every_finding_names_its_line(tmp_path):
    file = file_of(
        tmp_path, "  model X\n    Lost n(redeclare B a);\n    A b(\n      q=1,\n      hidden=2);\n  end X;\n"
    )
    lines = file.read_text().splitlines()
    with pytest.raises(InputError) as refusal:
        read("P.X", file)
    named = [int(number) for number in re.findall(r"P\.mo:(\d+): ", str(refusal.value))]
    assert sorted(lines[n - 1].strip() for n in named) == [
        "hidden=2);",
        "replaceable A a(r=k) constrainedby Law;",
    ]


TWO_FUNCTIONS = """package P
  package A
    function f input Real x; output Real y; algorithm y := abs(x); end f;
    function g input Real x; output Real y; algorithm y := f(x); end g;
    model M output Real y = CALL(time - 3); end M;
  end A;
  package B
    function f input Real x; output Real y; algorithm y := 5*x; end f;
    function h = f;
    model M import P.A.g; output Real y = IMPORTED(time - 3); end M;
  end B;
  model X A.M a; B.M b; output Real y = a.y + b.y; end X;
end P;
"""


def test_two_functions_of_one_name_are_not_confused(written):
    """5.3: a name means the function that is found from the class outwards; rumoca 0.10 takes one for both."""
    with pytest.raises(TranslationError, match=r"P\.mo:\d+: f is P\..\.f, but the built-in compiler takes P\..\.f"):
        read("P.X", written(TWO_FUNCTIONS.replace("CALL", "f").replace("IMPORTED", "f"), "P.mo"))


@pytest.mark.parametrize(
    ("call", "imported", "value"),
    [("A.f", "B.f", -8), ("g", "g", 4), ("f", "P.B.f", -8), ("g", "f", -8), ("f", "h", -8)],
)
def test_two_functions_of_one_name_are_called_by_different_names(written, call, imported, value):
    """At 1 s: |1 - 3| and 5*(1 - 3), or twice the first."""
    model = lower("P.X", written(TWO_FUNCTIONS.replace("CALL", call).replace("IMPORTED", imported)))
    assert model.output(1.0, [], [], []).full().item() == value


def test_no_replaceable_component_has_modifiers_outside_its_constraining_clause():
    """OpenModelica dropped modifiers of the declaration, so that every axle in its FMUs had a radius of 0.38 m."""
    form = re.compile(r"^ *replaceable\s+(?!block\b|model\b|function\b)[^;\"]*\)\s*constrainedby", re.MULTILINE)
    assert form.search("  replaceable A a[n](\n    r=r)\n    constrainedby B;")
    libraries = LIBRARY.parent
    assert [str(file) for file in libraries.rglob("*.mo") if form.search(file.read_text())] == []


@pytest.mark.parametrize("name", ["Examples.BrakedWheelset", "Validation.PredictedParts", "Validation.LockedWheel"])
def test_classes_without_a_recipe_are_also_translated(name):
    """Their contact is not redeclared; rumoca then omits the bindings of a constraining clause."""
    assert read(f"RailBraking.{name}").variables
