"""The built-in compiler refuses Modelica that other compilers would read differently; sections of specification 3.6."""

import re

import casadi as ca
import pytest
import rumoca

from railgrip.base.errors import InputError, TranslationError
from railgrip.fmus.native import lower
from railgrip.fmus.native.dae import FRONT, read
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


MIXED = "  type E1 = enumeration(low, high);\n  type F1 = enumeration(high, low);\n"
CONNECTORS = """  connector Flange
    Real s;
    flow Real f;
  end Flange;
  model Wall
    Flange c;
  equation
    c.s = 0;
  end Wall;
"""

LENIENT = {
    "a function with the name of a built-in one": (
        "  function sin\n    input Real u;\n    output Real y;\n  algorithm\n    y := 2*u;\n  end sin;\n"
        + model("Real y = sin(0.5);"),
        r"P\.sin has the name of a built-in one",
    ),
    "an import with the name of a built-in function": (
        "  function double\n    input Real u;\n    output Real y;\n  algorithm\n    y := 2*u;\n  end double;\n"
        + model("import exp = P.double; Real y = exp(0.5);"),
        "the import exp has the name of a built-in function",
    ),
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
    "two modifiers with dotted names": (
        using("N n;", "(n.k=1, n.l=2)"), r"the modifier of 'n\.k' would be lost .*n\(k = \.\.\.\)"
    ),
    "a final modifier with a dotted name": (model("A a(final q.start=1);"), r"write nested brackets: q\(start = "),
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

ILLEGAL = {
    # 4: classes, prefixes, types
    "a component with the name of a type": (model("Real Integer = 3;"), r"name Integer of a predefined type"),
    "inner in a record": (
        "  record Q\n    inner Real a = 1;\n  end Q;\n" + model("Q q;"), r"a of the record Q is inner or outer"
    ),
    "an input that is a model": (
        "  model Y\n    input A a;\n  end Y;\n" + model("Y y;"), r"a is input and of the model P\.A"
    ),
    "a literal that is an attribute": (
        "  type E1 = enumeration(low, start);\n" + model("parameter E1 e = E1.low;"), r"has a literal start"
    ),
    "a literal twice": (
        "  type E1 = enumeration(low, low);\n" + model("parameter E1 e = E1.low;"), r"has low twice"
    ),
    "another enumeration": (MIXED + model("parameter F1 f = E1.low;"), r"f is of the enumeration P\.F1, but its value"),
    "another enumeration in a modifier": (
        MIXED + "  model Y\n    parameter F1 f = F1.low;\n  end Y;\n" + model("Y y(f=E1.low);"),
        r"'f' is of the enumeration P\.F1",
    ),
    "another enumeration compared": (
        MIXED + model("parameter F1 f = F1.low;\n    Boolean b = f == E1.low;"), r"a comparison has values of"
    ),
    "another enumeration in an if expression": (
        MIXED + model("parameter Boolean b = true;\n    parameter F1 f = if b then F1.low else E1.low;"),
        r"an if expression has values of",
    ),
    "another enumeration in a vector": (
        MIXED + model("parameter F1 f[2] = {F1.low, E1.low};"), r"an array has values of"
    ),
    "another enumeration as an argument": (
        MIXED + "  function g\n    input F1 f;\n    output Real y = Integer(f);\n  algorithm\n  end g;\n"
        + model("Real z = g(E1.low);"), r"argument f is of the enumeration P\.F1",
    ),
    "a constant without a value": (model("constant Real g;\n    Real z = g;"), r"constant g has no value"),
    "a constant with a start value only": (
        model("constant Real g(start=3);\n    Real z = g;"), r"constant g has no value"
    ),
    "an Integer from a function of time": (
        "  function g\n    input Real u;\n    output Integer y = integer(u);\n  algorithm\n  end g;\n"
        + model("Integer z = g(time);"), r"z changes at events only",
    ),
    "a Boolean without events": (model("Boolean z = noEvent(time > 1);"), r"z changes at events only"),
    "time in a record": ("  record Q\n    Real a = time;\n  end Q;\n" + model("Q q;"), r"the record Q uses time"),
    # 4.4.5: conditional components
    "a conditional component in an equation": (
        model("parameter Boolean on = true;\n    Real c = 4 if on;\n    Real z = c;"), r"the conditional component c"
    ),
    # 5: scoping
    "a protected parameter": (model("A a;\n    Real z = a.hidden;"), r"hidden"),
    "a protected class": (
        "  model Y\n  protected\n    model K\n      parameter Real k = 1;\n    end K;\n  end Y;\n" + model("Y.K k;"),
        r"Y\.K uses K, which is protected in P\.Y",
    ),
    "an element of a protected base": (
        "  model Y\n  protected\n    extends A;\n  end Y;\n" + model("Y a;\n    Real z = a.q;"), r"which is protected"
    ),
    "a protected element, redeclared": (
        "  model Y\n    extends N(redeclare E pra);\n  end Y;\n" + model("Y n;\n    Real z = n.pra.q;"),
        r"pra, which is protected",
    ),
    "a modified outer variable": (
        "  model Y\n    outer parameter Real p;\n    Real z = p;\n  end Y;\n"
        + model("inner parameter Real p = 1;\n    Y y(p=2);"), r"'p' is modified, which is outer in P\.Y",
    ),
    "a function of an array of components": (
        "  model Y\n    function g\n      input Real u;\n      output Real y = u;\n    algorithm\n    end g;\n"
        "  end Y;\n"
        + model("Y y[2];\n    Real z = y.g(1);"), r"y\.g is a class in an array of components",
    ),
    # 7: inheritance, modification, redeclaration
    "a model as the base of a block": ("  block X\n    extends A;\n  end X;\n", r"the block X extends the model A"),
    "an array as a base": (
        "  model A2 = A[2];\n  model X\n    extends A2;\n    Real z = 1;\n  end X;\n", r"an array of a class"
    ),
    "a local class and an inherited one": (
        "  model Y\n    model K\n      parameter Real k = 1;\n    end K;\n  end Y;\n  model X\n    model K\n"
        "      parameter Real k = 2;\n    end K;\n    extends Y;\n    K c;\n  end X;\n",
        r"the class K is declared, and another in the base class P\.Y",
    ),
    "two bases that differ": (
        "  model Y\n    parameter Real q = 4;\n  end Y;\n  model X\n    extends A;\n    extends Y;\n  end X;\n",
        r"X inherits q twice",
    ),
    "a base by two ways, modified once": (
        "  model Y\n    extends A;\n  end Y;\n  model X\n    extends Y(q=1);\n    extends A;\n  end X;\n",
        r"X inherits q twice",
    ),
    "a final component redeclared": (
        using("final replaceable parameter Real m = 2;", "(redeclare parameter Real m)"),
        r"'m' is redeclared, but is final"
    ),
    "a final element redeclared": (
        "  model Y\n    final replaceable parameter Real m = 2;\n  end Y;\n"
        "  model X\n    extends Y;\n    redeclare parameter Real m = 3;\n  end X;\n",
        r"m is redeclared, but is final in P\.Y",
    ),
    "a protected element made public": (
        "  model X\n    extends N;\n    redeclare A pra;\n  end X;\n", r"pra is redeclared as public, but is protected"
    ),
    "a type of other dimensions": (
        "  type V3 = Real[3];\n  type V23 = Real[2, 3];\n"
        + model("replaceable V3 v[2] = {{1, 2, 3}, {4, 5, 6}} constrainedby V23;"), r"number of dimensions",
    ),
    "a class that is no subtype of its constraint": (
        "  model Y\n    replaceable model K = Other constrainedby Law;\n    K k;\n  end Y;\n" + model("Y y;"),
        r"K is of .*, which lacks r of P\.Law",
    ),
    # 9: connections
    "arrays of connectors of different sizes": (
        CONNECTORS + "  model Two\n    Flange c[2];\n  equation\n    c.f = {-1, -2};\n  end Two;\n"
        "  model Three\n    Flange c[3];\n  equation\n    c.s = {1, 2, 3};\n  end Three;\n"
        "  model X\n    Two a;\n    Three b;\n  equation\n    connect(b.c, a.c);\n  end X;\n",
        r"connect has 3 elements of b\.c and 2 of a\.c",
    ),
    "a connector inside of two components": (
        CONNECTORS + "  model Y\n    Wall w;\n    Wall v;\n  end Y;\n"
        "  model X\n    Y y;\n  equation\n    connect(y.w.c, y.v.c);\n  end X;\n",
        r"connect uses y\.w\.c, a connector inside of two components",
    ),
    "two sources of a signal": (
        "  connector In = input Real;\n  connector Out = output Real;\n  block Source\n    Out y;\n  end Source;\n"
        "  model Y\n    In u;\n    Source a;\n  equation\n    connect(u, a.y);\n  end Y;\n" + model("Y y(u=1);"),
        r"connect joins two sources of a signal, a\.y and u",
    ),
}  # fmt: skip

UNSUPPORTED = {
    "the value of a redeclaration": (
        using("replaceable parameter Real m = 2;", "(redeclare parameter Real m = 3)"),
        r"value of the redeclaration of 'm'"
    ),
    "the value of a redeclaration with modifiers": (
        using("replaceable parameter Real m = 2;", "(redeclare parameter Real m(min=0) = 3)"),
        r"value of the redeclaration of 'm'",
    ),
    "the value of a redeclaration in a base": (
        "  model Y\n    replaceable Real m = 2;\n  end Y;\n" + extending("(redeclare Real m = 3)", "Y"),
        r"value of the redeclaration of 'm'",
    ),
    "a replacement without redeclare": (
        using("replaceable parameter Real m = 2;", "(replaceable parameter Real m = 3)"), r"'m' is replaced without"
    ),
    "the modifiers of a class": ("  model X\n    extends N(M(q=1));\n  end X;\n", r"modifiers of the class 'M'"),
    "a constraining clause of the class itself": (
        "  model X\n    replaceable A a constrainedby Law(r=7);\n  end X;\n", r"modifiers of its constraining clause, r"
    ),
    "a short class that shadows": (
        "  constant Real q = 7;\n  model S = A(r=q);\n" + model("S s;"),
        r"reads q in the modifiers of the short class S"
    ),
    "a global type": (
        "  model X\n    package P\n      model A\n        Real z = 1;\n      end A;\n    end P;\n"
        "    .P.A a;\n  end X;\n",
        r"reads \.P\.A, the type of a, as the local P",
    ),
    "a global constant": (
        "  constant Real g = 1;\n  model X\n    package P\n      constant Real g = 2;\n    end P;\n"
        "    Real z = .P.g;\n  end X;\n", r"reads \.P\.g as the local P"
    ),
    "an import of the name of an inherited element": (
        "  package Q\n    constant Real q = 9;\n  end Q;\n  model X\n    extends A;\n    import P.Q.q;\n"
        "    Real z = q;\n  end X;\n", r"X imports q and inherits an element q"
    ),
    "an import of all names, of which one is inherited": (
        "  package Q\n    constant Real q = 9;\n  end Q;\n  model X\n    extends A;\n    import P.Q.*;\n"
        "    Real z = q;\n  end X;\n", r"X imports q and inherits an element q"
    ),
    "an import of the name of an inherited class": (
        "  package Q\n    model K\n      Real v = 3;\n    end K;\n  end Q;\n  model Y\n    model K\n      Real v = 9;\n"
        "    end K;\n  end Y;\n  model X\n    extends Y;\n    import P.Q.K;\n    K k;\n  end X;\n",
        r"X imports K and inherits an element K",
    ),
    "an outer Real": (
        "  model Y\n    outer Real g;\n    Real z = g;\n  end Y;\n" + model("inner Real g = time;\n    Y y;"),
        r"the outer Real variable g .*`inner World world`",
    ),
    "inner and outer": (
        "  model Y\n    inner outer A g;\n    Real z = g.q;\n  end Y;\n" + model("inner A g;\n    Y y;"),
        r"g is inner and outer",
    ),
    "a short class of an array": ("  model A2 = A[2];\n" + model("A2 a;"), r"the class P\.A2 of a is an array"),
    "an assertion in a for equation of an if equation": (
        '  model X\n    Real x[2] = {1, 2}*time;\n  equation\n    if time > 0.5 then\n      for i in 1:2 loop\n'
        '        assert(x[i] < 2, "x");\n      end for;\n    end if;\n  end X;\n',
        r"drops an assertion in an if equation",
    ),
    "model extends": (
        "  model X\n    extends N;\n    redeclare model extends M\n      Real w = 1;\n    end M;\n  end X;\n",
        r"`model extends M` is not supported",
    ),
    "model extends without redeclare": (
        "  model X\n    extends N;\n    model extends M\n      Real w = 1;\n    end M;\n  end X;\n",
        r"`model extends M` is not supported",
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


@pytest.mark.parametrize("form", [*LENIENT, *ILLEGAL, *UNSUPPORTED])
def test_invalid_modelica_is_refused_with_file_and_line(tmp_path, form):
    text, sentence = (LENIENT | ILLEGAL | UNSUPPORTED)[form]
    with pytest.raises(InputError, match=rf"P\.mo:\d+: .*{sentence}"):
        read("P.X", file_of(tmp_path, text), complete=True)


@pytest.mark.parametrize("form", STRICT)
def test_classes_refused_by_the_front_end_are_still_refused(tmp_path, form):
    """The front end alone refuses them; the compiler then names file and line, if not in its words."""
    text, sentence = STRICT[form]
    file = file_of(tmp_path, text)
    with pytest.raises((rumoca.RumocaError, RuntimeError), match=sentence):
        rumoca.Session(roots=[]).loads(file.read_text(), model="P.X").codegen(str(FRONT))
    with pytest.raises(InputError, match=r"P\.mo:\d+"):
        read("P.X", file)


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


@pytest.mark.parametrize(
    ("types", "start"),
    [
        ('type Length = Real(start=2, unit="m"); type Distance = Length(min=0);', 2),
        ('type Length = Real(start=2, unit="m"); type Distance = Length(start=3);', 3),
        ('type Length = Real(start=2); type Middle = Length(start=3); type Distance = Middle(unit="m");', 3),
    ],
)
def test_a_type_may_modify_attributes_of_another_type(tmp_path, types, start):
    """Section 4.6: the attributes are those of the built-in type, the last modification counts."""
    text = f"{types} model X Distance x(fixed=true); equation der(x) = 1; end X;"
    system = explicit(read("P.X", file_of(tmp_path, text)))
    assert float(column([s.start for s in system.variables.states])) == start
    with pytest.raises(TranslationError, match=r"'unt' is not an attribute of (Distance|Middle)"):
        read("P.X", file_of(tmp_path, text.replace("Length(", "Length(unt=1, ").replace("Real(unt=1, ", "Real(")))


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
