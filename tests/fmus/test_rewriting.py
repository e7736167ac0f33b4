"""Forms that the front end does not read are rewritten with the same meaning, or refused (chapters 7, 8, 10 and 11)."""

import random

import casadi as ca
import pytest
from sampling import sample

from railgrip.base.errors import InputError
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.equations import model_of
from railgrip.fmus.native.rewriting import rewrite
from railgrip.fmus.native.system import explicit

T = 0.75
"""Time at which values are compared [s]; all of them are exact in binary."""

# Body of a model → the values of its outputs at T.
VALUES = {
    "a variable that is read first has its start value": (
        "output Real y; output Real z; algorithm y := z + 1; z := time; y := y + z;", [1.75, 0.75]
    ),
    "a loop downwards": ("output Real y; algorithm y := 0; for i in 3:-1:1 loop y := 10*y + i; end for;", [321]),
    "a loop over a list": ("output Real y; algorithm y := 0; for w in {1, 4, 2} loop y := 10*y + w; end for;", [142]),
    "a loop over Real numbers": ("output Real y; algorithm y := 0; for r in 0.5:0.5:2 loop y := y + r; end for;", [5]),
    "a loop without repetitions": ("output Real y; algorithm y := 1; for i in 2:1 loop y := 7; end for;", [1]),
    "nested loops over a range that depends on the outer one": (
        "output Real y; algorithm y := 0; for i in 1:3 loop for j in 1:i loop y := 10*y + j; end for; end for;",
        [112123],
    ),
    "elements of an array": (
        "output Real x[3]; algorithm for i in 1:3 loop x[4 - i] := i; end for; x[1] := x[1] + x[2];", [5, 2, 1]
    ),
    "an array as a whole": (
        "output Real x[2]; output Real s; algorithm x := {1, time}; s := sum(x) + x[2];",
        [1, 0.75, 2.5],
    ),
    "a loop to an Integer parameter": (
        'parameter Integer n = 3 "size"; output Real x[n]; algorithm x[1] := 1; for i in 2:n loop\n'
        "x[i] := x[i - 1] + time; end for;", [1, 1.75, 2.5]
    ),
    "an iterator with the name of a constant": (
        "constant Integer j = 3; output Real x[j]; algorithm for j in 1:j loop x[j] := 2*j; end for;", [2, 4, 6]
    ),
    "no branch": ("output Real y; algorithm y := 5; if noEvent(time > 1) then y := 1; end if; y := y + 1;", [6]),
    "a condition on a variable that its branch changes": (
        "output Real y; algorithm y := time; if noEvent(y > 0) then y := 0; elseif noEvent(y < 1) then y := 9; end if;",
        [0],
    ),
    "an iteration": (
        "output Real y; algorithm y := 4; for i in 1:6 loop "
        "y := y - (y*y - 2 - time)/(2*y) + 0*(y + y + y + y); end for;",
        [2.75**0.5],
    ),
    "several results": (
        "function f input Real u; output Real a; output Real b; algorithm a := u; b := 2*u; end f;\n"
        "output Real p; output Real q; output Real r; algorithm p := 3; r := p; (p, q) := f(r + time); r := p + q;",
        [3.75, 7.5, 11.25],
    ),
    "a for equation without a range": (
        "output Real x[3]; equation for i loop x[i] = i*time; end for;",
        [0.75, 1.5, 2.25],
    ),
    "a for equation with one of two ranges": (
        "output Real x[2, 2]; equation for i in 1:2, j loop x[i, j] = 10*i + j; end for;", [11, 21, 12, 22]
    ),
    "a reduction over a list": ("output Real y = max(abs(i - 4) for i in {3, 9, 4});", [5]),
    "a constructor over a list": ("output Real y[3] = {i^2 for i in {3, 7, 6}};", [9, 49, 36]),
    "a reduction in a loop": (
        "Real v[2] = {1, 2}*time; output Real x[2]; equation for k loop x[k] = k*sum(v[i] for i); end for;", [2.25, 4.5]
    ),
}  # fmt: skip


def write(folder, body):
    file = folder / "M.mo"
    file.write_text(f"model M\n{body}\nend M;\n")
    return file


def lower(class_name, file):
    """Return the functions of a class, translated in this process."""
    return model_of(explicit(read(class_name, file)))


@pytest.mark.parametrize("name", VALUES)
def test_the_values_are_those_of_the_language(tmp_path, name):
    body, values = VALUES[name]
    model = lower("M", write(tmp_path, body))
    found = model.output(T, [], [], [p.start for p in model.parameters]).full().ravel()
    assert sorted(found.tolist()) == pytest.approx(sorted(values), rel=1e-14)


def program(draw, depth, readable):
    """Return random statements as Modelica and Python lines; `x` is an array of two elements."""
    lines: list[str] = []
    for _ in range(draw.randint(2, 4 - depth)):
        kind = draw.choice(["assign", "assign", "if", "for"] if depth < 2 else ["assign"])
        if kind == "assign":
            target = draw.choice(["y", "z", "x[1]", "x[2]"])
            a, b = draw.choice(readable), draw.choice(readable)
            lines.append(f"{target} := {a}*({draw.randint(-2, 2)}) + {b} - {draw.randint(0, 3)};")
        elif kind == "if":
            first, second = (f"noEvent({draw.choice(readable)} > {draw.randint(-2, 2)})" for _ in range(2))
            lines += [f"if {first} then", *program(draw, depth + 1, readable)]
            lines += [f"elseif {second} then", *program(draw, depth + 1, readable)] * draw.randint(0, 1)
            lines += ["else", *program(draw, depth + 1, readable)] * draw.randint(0, 1)
            lines.append("end if;")
        else:
            name = f"i{depth}"
            lines += [f"for {name} in {draw.choice(['1:3', '2:-1:1', '{1, 4}'])} loop"]
            lines += [*program(draw, depth + 1, [*readable, name]), "end for;"]
    return lines


def run(lines, time):
    """Return y, z, x[1], x[2] after the statements, executed by Python."""
    ranges = {"1:3": [1, 2, 3], "2:-1:1": [2, 1], "{1, 4}": [1, 4]}
    code, indent = [], 0
    for line in lines:
        text = line.rstrip(";").replace(":=", "=").replace("noEvent", "")
        text = text.replace("x[1]", "x[0]").replace("x[2]", "x[1] ")
        indent -= text.startswith(("end ", "else"))
        if text.startswith("for "):
            name, _, range_ = text[4:].removesuffix(" loop").partition(" in ")
            text = f"for {name} in {ranges[range_]}:"
        elif text.startswith("else"):
            text = f"{text.replace('elseif', 'elif').removesuffix(' then')}:"
        elif text.startswith("if "):
            text = f"{text.removesuffix(' then')}:"
        if not text.startswith("end "):
            code.append("    " * indent + text)
        indent += text.endswith(":")
    state = {"y": 0.0, "z": 0.0, "x": [0.0, 0.0], "t": time}
    exec("\n".join(code), {}, state)
    return [state["y"], state["z"], *state["x"]]


@pytest.mark.parametrize("seed", [seed for seed in sample(range(500), 10) if seed not in (118, 252)])  # too long
def test_random_algorithms_have_the_values_of_their_execution(tmp_path, seed):
    draw = random.Random(seed)
    readable = ["y", "z", "x[1]", "x[2]", "t"]
    lines = [*program(draw, 0, readable), "y := y + 1;", "z := z - y;", "x[1] := x[1] + z;", "x[2] := 2*x[2];"]
    body = "output Real y; output Real z; output Real x[2]; Real t = time;\nalgorithm\n" + "\n".join(lines)
    file = write(tmp_path, body)
    model = lower("M", file)
    for time in (0.25, 2.0):
        value = dict(zip((v.name for v in model.outputs), model.output(time, [], [], []).full().ravel(), strict=True))
        found = [value[name] for name in ("y", "z", "x[1]", "x[2]")]
        # Sums of products of small whole numbers and quarters are exact.
        assert found == run(lines, time)


@pytest.mark.parametrize(
    ("body", "modifier"),
    [
        ("parameter Integer n = 2; algorithm y := 0; for i in 1:n loop y := y + i; end for;", "n = 3"),
        ("algorithm if time > 1 then y := 1; end if;", "y(start = 3)"),
    ],
)
def test_an_algorithm_with_a_value_that_another_class_sets_is_refused(written, body, modifier):
    file = written(f"package P model A output Real y; {body} end A; model M A a({modifier}); end M; end P;\n")
    with pytest.raises(InputError, match="algorithm section"):
        read("P.M", file)


def test_places_are_those_of_the_lines_that_were_written(tmp_path):
    body = (
        "Real y;\nequation\n  y = 1;  // a comment\n\n  if time > 0.5 then\n    assert(time < 1, \"late\");\n  else\n\n"
        "    assert(time > -1,\n      \"early\");\n  end if;\nalgorithm\n  for i in 1:2 loop\n"
        "    assert(i*time < 3, \"loop\");\n  end for;"
    )  # fmt: skip
    assertions = explicit(read("M", write(tmp_path, body))).assertions
    assert [(a.where, a.message[0]) for a in assertions] == [
        ("M.mo:7", "late"), ("M.mo:10", "early"), ("M.mo:15", "loop"), ("M.mo:15", "loop"),
    ]  # fmt: skip


def test_an_assertion_of_an_if_equation_holds_where_its_branch_is_not_active(tmp_path):
    body = (
        'Real y = time; equation if y > 2 then assert(y > 3, "a"); elseif y > 1 then assert(y < 1.5, "b"); else\n'
        'if y > 0 then assert(y < 0.5, "c"); end if; end if;'
    )
    system = explicit(read("M", write(tmp_path, body)))
    holds = ca.Function("holds", [system.time], [a.holds for a in system.assertions])
    for time, expected in ((-1.0, [1, 1, 1]), (0.25, [1, 1, 1]), (0.75, [1, 1, 0]), (1.25, [1, 1, 1]),
                           (1.75, [1, 0, 1]), (2.5, [0, 1, 1]), (3.5, [1, 1, 1])):  # fmt: skip
        assert [float(value) for value in holds(time)] == expected


@pytest.mark.parametrize(
    ("condition", "start", "later"),
    [("initial() or y < 0.5", 1, 0), ("not initial() or y < 0.5", 0, 1), ("initial()", 1, 0)],
)
def test_initial_is_true_in_an_assertion_at_the_start_only(tmp_path, condition, start, later):
    """The condition is evaluated for y = 1."""
    system = explicit(read("M", write(tmp_path, f'Real y = 1 + 0*time; equation assert({condition}, "a");')))
    (at_start,), (running,) = ([a.holds for a in system.checks(when)] for when in ("start", "running"))
    assert (float(at_start), float(running)) == (start, later)


def test_a_library_with_byte_order_marks_is_read(tmp_path):
    folder = tmp_path / "Lib"
    folder.mkdir()
    (folder / "package.mo").write_text("\ufeffpackage Lib\nend Lib;\n")
    (folder / "B.mo").write_text("\ufeffwithin Lib;\nmodel B\n  output Real y = 2*time;\nend B;\n")
    assert float(lower("Lib.B", folder).output(T, [], [], [])) == 1.5


def test_texts_that_the_front_end_reads_are_not_changed(tmp_path):
    """Strings, comments, matrices and names with the words of statements are no statements."""
    text = (
        'model M "algorithm x := 1; for i loop" Real x[2] = [1, 2; 3, 4][1, :]; /* if a then assert(b) end if; */\n'
        "  Real 'for i loop'; A a(b(c = 1), each d = f(x = 2));\nequation\n  for i in 1:2 loop x[i] = i; end for;\n"
        "  if x[1] > 0 then 'for i loop' = 1; else 'for i loop' = 2; end if; // assert(false)\n"
        "end M;\n"
    )
    assert rewrite({"M": text}) == {}
