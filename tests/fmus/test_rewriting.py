"""Forms that the front end does not read are rewritten with the same meaning, or refused (chapters 7, 8, 10 and 11)."""

import random
from contextlib import suppress

import casadi as ca
import pytest
from sampling import sample

from railgrip.base.errors import InputError
from railgrip.fmus.native import dae
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.equations import model_of
from railgrip.fmus.native.rewriting import rewrite
from railgrip.fmus.native.system import explicit

T = 0.75
"""Time at which values are compared [s]; all of them are exact in binary."""


def model(body):
    return f"model M\n{body}\nend M;\n"


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
def test_random_algorithms_have_the_values_of_their_execution(written, seed):
    draw = random.Random(seed)
    readable = ["y", "z", "x[1]", "x[2]", "t"]
    lines = [*program(draw, 0, readable), "y := y + 1;", "z := z - y;", "x[1] := x[1] + z;", "x[2] := 2*x[2];"]
    body = "output Real y; output Real z; output Real x[2]; Real t = time;\nalgorithm\n" + "\n".join(lines)
    lowered = model_of(explicit(read("M", written(model(body)))))
    for time in (0.25, 2.0):
        output = lowered.output(time, [], [], []).full().ravel()
        value = dict(zip((v.name for v in lowered.outputs), output, strict=True))
        found = [value[name] for name in ("y", "z", "x[1]", "x[2]")]
        # Sums of products of small whole numbers and quarters are exact.
        assert found == run(lines, time)


def test_places_are_those_of_the_lines_that_were_written(written):
    body = (
        "Real y;\nequation\n  y = 1;  // a comment\n\n  if time > 0.5 then\n    assert(time < 1, \"late\");\n  else\n\n"
        "    assert(time > -1,\n      \"early\");\n  end if;\nalgorithm\n  for i in 1:2 loop\n"
        "    assert(i*time < 3, \"loop\");\n  end for;"
    )  # fmt: skip
    assertions = explicit(read("M", written(model(body)))).assertions
    assert [(a.where, a.message[0]) for a in assertions] == [
        ("M.mo:7", "late"), ("M.mo:10", "early"), ("M.mo:15", "loop"), ("M.mo:15", "loop"),
    ]  # fmt: skip


def test_an_assertion_of_an_if_equation_holds_where_its_branch_is_not_active(written):
    body = (
        'Real y = time; equation if y > 2 then assert(y > 3, "a"); elseif y > 1 then assert(y < 1.5, "b"); else\n'
        'if y > 0 then assert(y < 0.5, "c"); end if; end if;'
    )
    system = explicit(read("M", written(model(body))))
    holds = ca.Function("holds", [system.time], [a.holds for a in system.assertions])
    for time, expected in ((-1.0, [1, 1, 1]), (0.25, [1, 1, 1]), (0.75, [1, 1, 0]), (1.25, [1, 1, 1]),
                           (1.75, [1, 0, 1]), (2.5, [0, 1, 1]), (3.5, [1, 1, 1])):  # fmt: skip
        assert [float(value) for value in holds(time)] == expected


@pytest.mark.parametrize(
    ("condition", "start", "later"),
    [("initial() or y < 0.5", 1, 0), ("not initial() or y < 0.5", 0, 1), ("initial()", 1, 0)],
)
def test_initial_is_true_in_an_assertion_at_the_start_only(written, condition, start, later):
    """The condition is evaluated for y = 1."""
    system = explicit(read("M", written(model(f'Real y = 1 + 0*time; equation assert({condition}, "a");'))))
    (at_start,), (running,) = ([a.holds for a in system.checks(when)] for when in ("start", "running"))
    assert (float(at_start), float(running)) == (start, later)


def test_texts_that_the_front_end_reads_are_not_changed():
    """Strings, comments, matrices and names with the words of statements are no statements."""
    text = (
        'model M "algorithm x := 1; for i loop" Real x[2] = [1, 2; 3, 4][1, :]; /* if a then assert(b) end if; */\n'
        "  Real 'for i loop'; A a(b(c = 1), each d = f(x = 2));\nequation\n  for i in 1:2 loop x[i] = i; end for;\n"
        "  if x[1] > 0 then 'for i loop' = 1; else 'for i loop' = 2; end if; // assert(false)\n"
        "end M;\n"
    )
    assert rewrite({"M": text}) == {}


def test_a_class_is_read_as_often_as_its_text_differs(written, monkeypatch):
    """It is read once as it is and once for each way to rewrite it; an error is diagnosed in a further reading."""
    read_once, paths = dae._read, []

    def count(name, path, *more, **options):
        paths.append(path)
        return read_once(name, path, *more, **options)

    monkeypatch.setattr(dae, "_read", count)
    empty = "parameter Integer n = 0; Real x[n]; Real y; equation for k in 1:n loop x[k] = 1; end for; y = "
    for body, times in (
        ("Real y = unknown;", 2),
        ("Real y = unknown; A a(b.c = 1);", 3),
        (f"{empty}sum(x[k] for k in 1:n);", 2),
        (f"{empty}{{sum(x[k] for k in 1:n), 1}};", 3),
    ):
        paths.clear()
        with suppress(InputError):
            read("M", written(model(body)))
        assert len(paths) == times, body
