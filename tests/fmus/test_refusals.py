"""What the built-in compiler does not translate it refuses: construct, file and line, never silence."""

import pytest

from fmus.errors import Refused, WrongQuestion
from fmus.native import lower
from fmus.native.dae import read
from fmus.native.system import explicit

REFUSED = {
    "delay": "model M\n Real x(start=1,fixed=true);\nequation\n der(x) = -delay(x, 0.1);\nend M;",
    "terminate": "model M\n Real x(start=1,fixed=true);\nequation\n der(x) = -1;\n when x < 0.2 then\n  terminate(\"done\");\n"
    " end when;\nend M;",
    "string": "model M\n Real x(start=1,fixed=true);\nequation\n der(x) = -x;\nprotected\n parameter String s = \"a\";\nend M;",
    "fixed=false": "model M\n Real x(start=1,fixed=true);\n Real y;\n parameter Real k(fixed=false, start=1);\nequation\n"
    " der(x) = -k*x;\n y = x;\ninitial equation\n k = 3;\nend M;",
    "external": "package P function f input Real x; output Real y;\n external \"C\" y = sin(x); end f;\n"
    "model M Real x(start=1,fixed=true); equation\n der(x) = -f(x); end M; end P;",
    "assert inside function": "package P function f input Real x; output Real y;\n algorithm\n assert(x > 0, \"x\");\n"
    " y := sqrt(x); end f; model M Real x(start=1,fixed=true); equation der(x) = -f(x); end M; end P;",
    "depends on T": "model M\n parameter Real T = 0.1;\n discrete Real u(start=0,fixed=true);\nequation\n when sample(0, T) then"
    " u = pre(u) + 1;\n end when;\nend M;",
    "must be differentiated": "model M\n input Real u;\n Real x(start=1,fixed=true);\n Real v;\nequation\n x = u;\n der(x) = v;\nend M;",
}  # fmt: skip


@pytest.mark.parametrize("construct", REFUSED)
def test_it_is_refused_with_construct_file_and_line(tmp_path, construct):
    file = tmp_path / "Model.mo"
    file.write_text(REFUSED[construct])
    name = "P.M" if "package P" in REFUSED[construct] else "M"
    with pytest.raises(Refused, match=construct) as refusal:
        explicit(read(name, file))
    place, _, _ = str(refusal.value).partition(": ")
    file_name, _, line = place.rpartition(":")
    assert file_name == "Model.mo"
    lines = REFUSED[construct].splitlines()
    word = {"string": "String", "external": "f(x)", "must be differentiated": "x = u", "depends on T": "sample",
            "assert inside function": "assert", "terminate": "x < 0.2"}.get(construct, construct)  # fmt: skip
    assert word in lines[int(line) - 1]


def test_a_missing_file_and_a_missing_class_are_told(tmp_path):
    with pytest.raises(WrongQuestion, match=r"no Modelica file .*Nowhere\.mo"):
        lower("M", tmp_path / "Nowhere.mo")
    file = tmp_path / "Model.mo"
    file.write_text("model M end M;")
    with pytest.raises(WrongQuestion, match="Other does not compile"):
        lower("Other", file)


def test_a_modelica_error_keeps_the_front_ends_words(tmp_path):
    file = tmp_path / "Model.mo"
    file.write_text("model M\n Real x(start=1,fixed=true);\nequation\n der(x) = -k*x;\nend M;")
    with pytest.raises(WrongQuestion, match="k"):
        lower("M", file)


def test_too_few_equations_are_counted(tmp_path):
    file = tmp_path / "Model.mo"
    file.write_text("model M Real x; Real y; equation x = 1; end M;")
    with pytest.raises(WrongQuestion, match="1 equations"):
        lower("M", file)


def test_a_class_with_events_is_no_plain_differential_equation(tmp_path):
    file = tmp_path / "Model.mo"
    file.write_text("model M Real x(start=1,fixed=true); equation der(x) = if x > 0.5 then -1 else -x; end M;")
    with pytest.raises(Refused, match="noEvent"):
        lower("M", file)
