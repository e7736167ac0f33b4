"""The built-in compiler refuses Modelica that other compilers would read differently; sections of specification 3.6."""

import re

import casadi as ca
import pytest

from railgrip.base.errors import InputError, TranslationError
from railgrip.fmus.native import lower
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.library import LIBRARY
from railgrip.fmus.native.system import column, explicit
from railgrip.fmus.native.variables import vector

BASE = """package P
  partial model Law
    parameter Real r = 1;
    output Real y;
  end Law;
  model A
    extends Law(r=2);
    parameter Real q = 3;
    parameter Real v[2] = {1, 2};
    final parameter Real f = 4;
  protected
    parameter Real hidden = 6;
  equation
    y = r + q + f + hidden + sum(v);
  end A;
  model B
    extends Law;
    parameter Real q = 5;
  equation
    y = r - q;
  end B;
  model E
    extends A;
    parameter Real extra = 1;
  end E;
  model Other
    output Real y;
  equation
    y = 1;
  end Other;
  record R
    parameter Real a = 1;
    parameter Real b = 2;
  end R;
  model N
    parameter Real k = 7;
    A n(q=8);
    replaceable A a(r=k);
    replaceable A plain constrainedby Law;
    replaceable A both(r=k) constrainedby Law(r=k);
    replaceable model M = A constrainedby Law;
    replaceable model MR = A(r=k);
    final A fa;
    replaceable constant Real c = 1;
    A arr[2];
    R whole = R(3, 4);
    M m;
    MR mr;
  protected
    A pa;
    replaceable A pra;
  end N;
  model Kept
    parameter Real k = 7;
    replaceable A a constrainedby Law(r=k);
  end Kept;
  model Lost
    parameter Real k = 7;
    replaceable A a(r=k) constrainedby Law;
  end Lost;
"""


def model(line: str) -> str:
    return f"  model X\n    {line}\n  end X;\n"


def extending(line: str, base: str = "A") -> str:
    return f"  model X\n    extends {base}{line};\n  end X;\n"


def using(line: str, modifiers: str = "") -> str:
    """Return a model Y with a line, and a model X with a component of Y that has modifiers."""
    return f"  model Y\n    {line}\n  end Y;\n" + model(f"Y y{modifiers};")


LENIENT = {
    "a modifier outside the constraining clause": (
        model("Lost n(redeclare B a);"), r"'r' is modified on the declaration"
    ),
    "a modifier that the clause has otherwise": (
        using("replaceable A a[2](each r=7) constrainedby Law(r=8);", "(redeclare B a)"),
        r"'r' is modified on the declaration",
    ),
    "a constraining clause that is not redeclared": (model("Kept n;"), r"modifiers of its constraining clause, r \("),
    "a constraining clause that is only modified": (model("Kept n(a(q=1));"), r"does not redeclare 'a' of P\.Kept"),
    "a constraining clause of a class": (
        "  model Y\n    replaceable model M = A constrainedby Law(r=3);\n    M m;\n  end Y;\n" + model("Y y;"),
        r"constraining clause of the class M are lost",
    ),
    "a redeclared class with modifiers": (model("N n(redeclare model MR = E);"), r"'MR' would lose the modifiers"),
    "modifiers of the new class": (model("N n(redeclare model M = B(q=2));"), r"that replaces 'M' are lost"),
    "the same in a base": (extending("(redeclare model M = B(q=2))", "N"), r"that replaces 'M' are lost"),
    "a redeclaration by an element": (
        "  model X\n    extends Kept;\n    redeclare B a;\n  end X;\n", r"redeclare it in the extends clause"
    ),
    "a redeclaration inside modifiers": (using("N n;", "(n(redeclare B plain))"), r"'plain' inside the modifiers"),
    "a redeclared class inside modifiers": (using("N n;", "(n(redeclare model M = B))"), r"'M' inside the modifiers"),
    "a redeclaration inside modifiers of a base": (
        "  model Y\n    N n;\n  end Y;\n" + extending("(n(redeclare B plain))", "Y"), r"'plain' inside the modifiers"
    ),
    "a final class": (
        "  model Y\n    final model F = A;\n    F f(q=2);\n  end Y;\n" + model("Y y;"), r"P\.Y\.F, which is final"
    ),
    "an unknown element of a component": (model("N n(n(zz=1));"), r"'zz' is modified, which P\.A does not have"),
    "an unknown element of a base": (extending("(zz=1)"), r"'zz' is modified, which P\.A does not have"),
    "an unknown attribute": (model("A a(q(zz=1));"), r"'zz' is not an attribute of q"),
    "an unknown element of the new type": (model("N n(redeclare B plain(v={1, 2}));"), r"'v' is modified, which P\.B"),
    "an unknown element of the constraint": (
        using("replaceable A a constrainedby Law(q=1);", "(redeclare A a)"),
        r"clause of a modifies 'q', which P\.Law does not have",
    ),
    "a protected element": (model("A a(hidden=1);"), r"'hidden' is modified, which is protected in P\.A"),
    "a protected component": (model("N n(pa(q=1));"), r"'pa' is modified, which is protected"),
    "a protected element redeclared": (model("N n(redeclare A pra);"), r"'pra' is modified, which is protected"),
    "no each on a component": (model("A a[2](q=1);"), r"'q' is given a scalar .* write `each`"),
    "no each below a component": (model("N n(arr(q=1));"), r"'q' is given a scalar .* write `each`"),
    "no each on an attribute": (model("Real x[2](start=1) = {1, 2};"), r"'start' is given a scalar .* write `each`"),
    "no each on a parameter's attribute": (model("A a(v(start=1));"), r"'start' is given a scalar .* write `each`"),
    "each of an array": (model("Real x[2](each start={1, 2}) = {1, 2};"), r"'start' is given a vector where 0"),
    "a modifier twice, by name and nested": (model("A a(q.start=1, q(start=2));"), r"'q\.start' is modified twice"),
    "a modifier twice on a base": (extending("(q=1, q=2)"), r"'q' is modified twice"),
    "a part of a record with a value": (model("N n(whole(a=9));"), r"a part of 'whole' is modified"),
    "an inherited element again": (
        "  model X\n    extends A;\n    parameter Real q = 1;\n  end X;\n",
        r"q is inherited from P\.A and declared again"
    ),
    "a redeclaration of what is not inherited": (model("redeclare A a;"), r"P\.X does not inherit it"),
    "a redeclaration by an element, not replaceable": (
        "  model X\n    extends N;\n    redeclare E n;\n  end X;\n", r"n is redeclared, but is not replaceable"
    ),
    "a redeclaration by an element, of no subtype": (
        "  model X\n    extends N;\n    redeclare Other plain;\n  end X;\n",
        r"plain is of P\.Other, which lacks r of P\.Law"
    ),
    "a modifier with a dotted name": (
        using("N n;", "(n.k=1)"), r"the modifier n\.k is lost in the built-in compiler; write n\(k=\.\.\.\)"
    ),
    "an attribute with a dotted name": (model("A a(q.start=1);"), r"write q\(start=\.\.\.\)"),
    "a dotted name inside modifiers": (
        using("N n;", "(n(q.start=1))"), r"write q\(start=\.\.\.\)"
    ),
    "constants of a package and its heir": (
        "  package K constant Real k = 4; end K;\n  package H extends K(k=5); end H;\n"
        + model("Real z = H.k + K.k;"), r"P\.H modifies constants of P\.K, which is used itself"
    ),
    "computed constants of two packages of one name": (
        "  package C\n    package K\n      constant Real p = 1;\n      constant Real q = -p;\n    end K;\n  end C;\n"
        "  package D\n    package K\n      constant Real p = 2;\n      constant Real q = +p;\n    end K;\n  end D;\n"
        + model("Real z = C.K.q + D.K.q;"), r"K\.q is a computed constant of 2 packages of the name K"
    ),
    "a second redeclaration": (
        using("extends N(redeclare A plain);", "(redeclare B plain)"),
        r"'plain' is redeclared, but is not replaceable",
    ),
    "a replaceable base": (extending("", "N.M"), r"P\.N\.M is replaceable and cannot be a base class"),
    "a type outside its constraint": (using("replaceable Other a constrainedby Law;"), r"which lacks r of P\.Law"),
    "a parameter without a value": (
        "  model Y\n    parameter Real p(start=2);\n    Real z = p;\n  end Y;\n" + model("Y y;"),
        r"parameter y\.p has no value",
    ),
}  # fmt: skip

STRICT = {
    "a component that is not replaceable": (model("N n(redeclare B n);"), "not replaceable"),
    "no subtype of the declared type": (model("N n(redeclare Other a);"), "not a subtype"),
    "no subtype of the constraint": (model("N n(redeclare Other plain);"), "not a subtype"),
    "a class that is no subtype": (model("N n(redeclare model M = Other);"), "not a subtype"),
    "a constant redeclared": (model("N n(redeclare constant Real c = 2);"), "constant elements cannot be redeclared"),
    "a final parameter": (model("A a(f=1);"), "declared final"),
    "a final component": (model("N n(fa(q=1));"), "declared final"),
    "a final element of a base": (extending("(f=9)"), "declared final"),
    "a modifier made final": (using("A a(final q=1);", "(a(q=2))"), "declared final"),
    "a base's modifier made final": (using("extends A(final q=1);", "(q=2)"), "declared final"),
    "an unknown element": (model("A a(zz=1);"), "unknown modifier `zz`"),
    "an unknown attribute of a variable": (model("Real x(zz=1) = 2;"), "unknown modifier `zz`"),
    "an unknown element redeclared": (model("N n(redeclare B zz);"), "unknown modifier `zz`"),
    "sizes that differ": (model("A a[2](q={1, 2, 3});"), "sizes must match"),
    "each on a scalar": (model("A a(each q=1);"), "non-array component"),
    "a modifier twice": (model("A a(q=1, q=1);"), "could not be compiled"),
    "a redeclaration twice": (model("N n(redeclare B plain, redeclare A plain);"), "could not be compiled"),
    "a record whole and in part": (model("N n(whole=R(1, 2), whole(a=3));"), "could not be compiled"),
    "a class without redeclare": (model("N n(M=B);"), "requires the `redeclare` keyword"),
    "a value of another type": (model("A a(q=true);"), "type mismatch"),
    "an element twice": (model("Real a = 1;\n    Real a = 2;"), "could not be compiled"),
    "no inner": ("  model Y\n    outer Real g;\n    Real z = g;\n  end Y;\n" + model("Y y;"), "requires inner"),
    "a modified outer": (
        "  model Y\n    outer A g(q=1);\n  end Y;\n" + model("inner A g;\n    Y y;"), "could not be compiled"
    ),
    "an inner of another type": (
        "  model Y\n    outer A g;\n    Real z = g.q;\n  end Y;\n" + model("inner B g;\n    Y y;"), "type mismatch"
    ),
    "a partial component": (model("Law i;"), "partial model"),
    "a parameter that varies": (model("Real x = time;\n    A a(q=x);"), "runtime coordinate"),
}  # fmt: skip

RIGHT = {
    "modifiers of a component": (model("N n(n(q=1), arr(each q=2), a(r=3));"), {"n.n.q": 1, "n.arr[1].q": 2}),
    "a vector over an array": (model("A a[2](q={1, 2});"), {"a[2].q": 2}),
    "each inside each": (model("N n[2](each arr(each q=1));"), {"n[2].arr[1].q": 1}),
    "a protected element of a base": (extending("(hidden=1)"), {"hidden": 1}),
    "a clause in a redeclaration": (model("Kept n(redeclare B a);"), {"n.a.r": 7, "n.a.q": 5}),
    "a clause in a base": (extending("(redeclare B a)", "Kept"), {"a.r": 7}),
    "a clause and a modifier of the redeclaration": (model("Kept n(redeclare B a(r=8));"), {"n.a.r": 8}),
    "modifiers on both": (model("N n(redeclare B both);"), {"n.both.r": 7}),
    "modifiers on both, not redeclared": (model("N n;"), {"n.both.r": 7}),
    "modifiers without a clause": (model("N n(redeclare E a);"), {"n.a.r": 7}),
    "a redeclared class": (model("N n(redeclare model M = B);"), {"n.m.q": 5}),
    "a parameter of the class itself without a value": (model("parameter Real p(start=2);\n    Real z = p;"), {"p": 2}),
    "constants of two heirs": (
        "  package K constant Real k; end K;\n  package H extends K(k=5); end H;\n  package I = K(k=6);\n"
        + model("parameter Real z = H.k + 10*I.k;\n    Real w = z;"),
        {"z": 65},
    ),
    "two redeclarations": (using("extends N(redeclare replaceable A plain);", "(redeclare B plain)"), {"y.plain.q": 5}),
}


def file_of(tmp_path, text):
    file = tmp_path / "P.mo"
    file.write_text(f"{BASE}{text}end P;\n")
    return file


@pytest.mark.parametrize("form", LENIENT)
def test_invalid_modelica_is_refused_with_file_and_line(tmp_path, form):
    text, sentence = LENIENT[form]
    with pytest.raises(InputError, match=rf"P\.mo:\d+: .*{sentence}"):
        read("P.X", file_of(tmp_path, text), complete=True)


@pytest.mark.parametrize("form", STRICT)
def test_classes_refused_by_the_front_end_are_still_refused(tmp_path, form):
    text, sentence = STRICT[form]
    with pytest.raises(InputError, match=sentence):
        read("P.X", file_of(tmp_path, text))


@pytest.mark.parametrize("form", RIGHT)
def test_accepted_classes_have_the_values_defined_by_the_language(tmp_path, form):
    text, expected = RIGHT[form]
    values = parameters(explicit(read("P.X", file_of(tmp_path, text), complete=True)))
    assert {name: values[name] for name in expected} == expected


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
    with pytest.raises(TranslationError) as refusal:
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


def test_two_functions_of_one_name_are_not_confused(tmp_path):
    """5.3: a name means the function that is found from the class outwards; rumoca 0.10 takes one for both."""
    file = tmp_path / "P.mo"
    file.write_text(TWO_FUNCTIONS.replace("CALL", "f").replace("IMPORTED", "f"))
    with pytest.raises(TranslationError, match=r"P\.mo:\d+: f is P\..\.f, but the built-in compiler takes P\..\.f"):
        read("P.X", file)


@pytest.mark.parametrize(
    ("call", "imported", "value"),
    [("A.f", "B.f", -8), ("g", "g", 4), ("f", "P.B.f", -8), ("g", "f", -8), ("f", "h", -8)],
)
def test_two_functions_of_one_name_are_called_by_different_names(tmp_path, call, imported, value):
    """At 1 s: |1 - 3| and 5*(1 - 3), or twice the first."""
    file = tmp_path / "P.mo"
    file.write_text(TWO_FUNCTIONS.replace("CALL", call).replace("IMPORTED", imported))
    model = lower("P.X", file)
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
