"""Names, units, messages and descriptions of a Modelica class cannot change the structure of the C code of its FMU."""

import ctypes
import re
import subprocess
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import casadi as ca
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from railgrip.base.errors import InputError, TranslationError
from railgrip.base.system import SampledSystem, Variable
from railgrip.fmus.build import build_class
from railgrip.fmus.native import lower
from railgrip.fmus.native.c_source import in_c, strings
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.discrete import WrittenStep, sources_of_library
from railgrip.fmus.native.package import HEADERS, Source, archive_bytes, c_identifier, sources
from railgrip.fmus.native.system import System, explicit
from railgrip.fmus.native.toolchain import binary, shared_library

CANARY = '??/"}; __attribute__((constructor)) static void crow(void) { fopen("/canary", "w"); } static char *x[] = {"'
NASTY = [
    CANARY,
    CANARY.replace("??/", ""),
    "??/",
    '\\"',
    "*/",
    "%s%n",
    "\n#include </etc/passwd>\n",
    "\r",
    "ü€\U0001f682",
]
MODEL = """model M "a falling stone"
  Real v(start=1, fixed=true, unit="m/s") "velocity";
  Real y(start=1);
  parameter Real g = 9.81;
equation
  der(v) = -g;
  y + sin(y) = v;
  assert(v > -1e9, "too fast, " + String(v) + " m/s");
end M;
"""
LOOP_TABLES = ("guesses", "updates", "residuals")
TEXTS = st.text(max_size=40) | st.sampled_from(NASTY)
# Without surrogates and NUL, which a C string in UTF-8 cannot contain.
STORABLE = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=40)


@pytest.fixture(scope="module")
def stone(tmp_path_factory: pytest.TempPathFactory) -> System:
    file = tmp_path_factory.mktemp("stone") / "M.mo"
    file.write_text(MODEL)
    return explicit(read("M", file))


def source_with(stone: System, name: str, unit: str, message: str, description: str) -> Source:
    """Return the sources of the stone's FMU with texts that the front end would refuse."""
    (v,) = stone.states
    tables = {k: dict(zip([name], getattr(stone.loops, k).values(), strict=True)) for k in LOOP_TABLES}
    loops = replace(stone.loops, **tables)
    (assertion,) = stone.assertions
    (_, value, _) = assertion.message
    attributes = v.attributes | {"unit": unit, "description": description}
    system = replace(
        stone,
        states=[replace(v, name=name, attributes=attributes)],
        loops=loops,
        assertions=[replace(assertion, message=(message, value, message), where=message)],
    )
    return sources(system, interfaces=("me", "cs"))


def without_literals(c: str) -> str:
    return re.sub(r'"(?:[^"\\]|\\.)*"', '""', c)


@settings(max_examples=60, deadline=None)
@given(TEXTS, TEXTS, TEXTS, TEXTS)
@example(CANARY, CANARY, CANARY, CANARY)
def test_c_is_the_same_but_for_plain_string_literals(
    stone: System, name: str, unit: str, message: str, description: str
):
    # The front end refuses two variables of one name.
    assume(name not in {scalar.name for scalars in stone.variables.of_id.values() for scalar in scalars})
    plain, other = source_with(stone, "w", "m", "", ""), source_with(stone, name, unit, message, description)
    assert without_literals(other.files["model.c"]) == without_literals(plain.files["model.c"])
    for literal in re.findall(r'"(?:[^"\\]|\\.)*"', other.files["model.c"]):
        assert re.fullmatch(r'"(?:[ !#->@-\[\]-~]|\\[0-7]{3})*"', literal), literal
    element = next(
        e for e in ElementTree.fromstring(other.xml).iter("ScalarVariable") if e.get("valueReference") == "1"
    )
    legal = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
    assert element.get("name") == legal.sub("\ufffd", name)
    assert (element.get("description") or "") == legal.sub("\ufffd", description)


def test_the_fmu_with_such_texts_compiles_and_runs_no_constructor(stone: System, tmp_path: Path):
    crowed = tmp_path / "crowed"
    text = CANARY.replace("/canary", str(crowed))
    source = source_with(stone, text, text, text, text)
    assert archive_bytes(source).startswith(b"PK")
    library = shared_library(source.files, "canary", units=["model.c"], include=[HEADERS])
    ctypes.CDLL(str(library))
    assert not crowed.exists()


def test_a_trigraph_in_an_assertion_of_a_class_is_text(written):
    """With trigraphs, `??/` before the closing quotation mark would turn the following text into code."""
    file = written(MODEL.replace("too fast, ", "too fast ??/").replace(' m/s")', ' m/s\\a\\v\\?\t")'))
    system = explicit(read("M", file))
    assert system.assertions[0].message[0] == "too fast ??/"
    assert system.assertions[0].message[2] == " m/s\a\v?\t"
    assert archive_bytes(sources(system, interfaces=("cs",)))


@pytest.mark.parametrize("name", [CANARY, "*/", "\n#error\n"])
def test_c_generated_by_casadi_contains_no_variable_names(name: str):
    """This C is part of compiled filters, formulas of the loop and the contact patch."""

    def text(symbol: str) -> str:
        x, u = ca.SX.sym(symbol, 2), ca.SX.sym(f"u{symbol}")
        return in_c([ca.Function("slope", [x, u], [ca.sin(x) * u], ["x", "u"], ["f"])])[1]

    assert text(name) == text("x")


def test_a_quoted_name_with_a_quotation_mark_is_refused(written):
    with pytest.raises(TranslationError, match="a quoted name with a quotation mark"):
        read("M", written(re.sub(r"\bv\b", lambda _: "'v??/\"; int crow(void) { return 1; }'", MODEL)))


def test_a_quoted_name_of_a_class_is_text(written):
    file = written(re.sub(r"\bv\b", "'v??/; int crow(void) { return 1; }'", MODEL))
    source = sources(explicit(read("M", file)), interfaces=("cs",))
    assert "crow(void)" in source.files["model.c"]
    assert "crow" not in without_literals(source.files["model.c"])
    assert archive_bytes(source)


@settings(max_examples=5, deadline=None)
@given(st.lists(STORABLE, min_size=1, max_size=200))
@example(NASTY)
def test_the_table_of_strings_returns_its_input(texts: list[str]):
    code = "\n".join(
        [
            strings("table", [None, *texts]),
            '__attribute__((visibility("default")))',
            "const char *at(int i) { return table[i]; }",
        ]
    )
    library = ctypes.CDLL(str(shared_library({"table.c": code}, "table")))
    library.at.restype = ctypes.c_char_p
    assert library.at(0) is None
    assert [library.at(i + 1).decode() for i in range(len(texts))] == texts


def test_trigraphs_are_off(tmp_path: Path):
    code = 'int at(void);\n__attribute__((visibility("default"))) int at(void) { return sizeof "??/041"; }\n'
    file = tmp_path / "trigraph.so"
    file.write_bytes(binary({"trigraph.c": code}, "trigraph"))
    assert ctypes.CDLL(str(file)).at() == len("??/041") + 1


def test_a_library_has_a_member_for_each_parameter_of_any_name_and_meaning():
    """`M_PI` is a macro; two letters outside of C become the same one."""
    names = ("double", "register", "class", "M_PI", "größe", "grüße", "slip[1]", "slip[2]")
    odd = tuple(Variable(name=name, unit="*/ 1", description=CANARY + "*/ int x;") for name in names)
    step = WrittenStep(text="#define MEMORY 1", files={})
    header = sources_of_library(SampledSystem(name="Own", description="", parameters=odd, outputs=(), step=step))[
        "Own.h"
    ]
    code = '#include <math.h>\n#include "Own.h"\nchar fits[sizeof(Own_Parameters) == 64 ? 1 : -1];\n'
    assert binary({"Own.h": header, "own.c": code}, "own", units=("own.c",), flags=("-Werror",))


@given(st.text())
def test_the_name_of_the_library_is_an_identifier(name: str):
    assert re.fullmatch(r"([A-Za-z_][A-Za-z0-9_]{0,99})?", c_identifier(name))


@pytest.mark.parametrize("name", ["M'/../../x", "../x", "/tmp/x", "'q'", 'M");system("true', "M.", "", "Mö", "M\n"])
def test_a_class_name_consists_of_plain_identifiers(written, name: str):
    """It is part of file names and of the script that OpenModelica runs."""
    file = written(MODEL)
    with pytest.raises(InputError, match="is not the name of a Modelica class"):
        build_class(name, file, compiler="native")
    with pytest.raises(InputError, match="is not the name of a Modelica class"):
        lower(name, file)


def test_the_c_compiler_of_python_is_not_searched_in_the_current_folder(tmp_path, monkeypatch):
    from railgrip.fmus.native import toolchain

    (tmp_path / "ziglang.py").write_text("open('ran', 'w').close()\nprint('a trap')\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    command = toolchain.compiler().command
    subprocess.run([*command, "--version"], check=True, capture_output=True)
    assert not (tmp_path / "ran").exists()
