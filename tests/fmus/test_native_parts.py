"""Parts of the built-in compiler on their own."""

import ctypes
import math

import numpy as np
import pytest

from fmus.errors import BuildFailed, CompilerMissing
from fmus.native import lower, toolchain
from fmus.native.elimination import eliminate
from fmus.native.units import BASE, parse


@pytest.mark.parametrize(
    ("text", "exponents", "factor"),
    [
        ("N.m/s2", {"kg": 1, "m": 2, "s": -4}, 1.0),
        ("W/(m2.K)", {"kg": 1, "s": -3, "K": -1}, 1.0),
        ("km/h", {"m": 1, "s": -1}, 1000 / 3600),
        ("rad/s", {"rad": 1, "s": -1}, 1.0),
        ("bar", {"kg": 1, "m": -1, "s": -2}, 1e5),
        ("kW.h", {"kg": 1, "m": 2, "s": -2}, 3.6e6),
        ("1/s", {"s": -1}, 1.0),
        ("1", {}, 1.0),
        ("deg", {"rad": 1}, math.pi / 180),
    ],
)
def test_a_unit_string_is_its_si_exponents_and_factor(text, exponents, factor):
    unit = parse(text)
    assert unit is not None
    assert {b: e for b, e in zip(BASE, unit.exponents, strict=True) if e} == exponents
    assert unit.factor == pytest.approx(factor)


def test_degrees_celsius_have_an_offset_only_alone():
    assert parse("degC").offset == 273.15
    assert parse("W/degC").offset == 0.0


def test_an_unknown_unit_is_none_rather_than_wrong():
    assert parse("furlong/s") is None


@pytest.mark.parametrize("seed", range(4))
def test_sparse_elimination_solves_what_numpy_solves(tmp_path, seed):
    """Random sparse J, shifted so far that no pivot is needed; condition below 100, so 1e-11 is ample."""
    rng = np.random.default_rng(seed)
    n = 17
    dense = np.where(rng.random((n, n)) < 0.15, rng.normal(size=(n, n)), 0.0)
    columns, rows = np.nonzero(dense.T)
    pattern = list(zip(rows.tolist(), columns.tolist(), strict=True))
    elimination = eliminate(n, pattern)
    code = "#include <math.h>\n" + elimination.code.replace("static int", "int").replace("static void", "void")
    exported = '__attribute__((visibility("default"))) '
    code = code.replace("int sparse_factor", exported + "int sparse_factor").replace(
        "void sparse_solve", exported + "void sparse_solve"
    )
    library = ctypes.CDLL(str(toolchain.shared_library({"lu.c": code}, tmp_path, "lu")))
    values = np.array([dense[i, j] for i, j in pattern])
    shift, work, right = 8.0, np.zeros(elimination.entries), rng.normal(size=n)
    solution = right.copy()
    pointer = ctypes.POINTER(ctypes.c_double)
    library.sparse_factor.argtypes = [pointer, ctypes.c_double, pointer]
    library.sparse_solve.argtypes = [pointer, pointer]

    def at(a):
        return a.ctypes.data_as(pointer)

    assert library.sparse_factor(at(values), shift, at(work)) == 0
    library.sparse_solve(at(work), at(solution))
    assert solution == pytest.approx(np.linalg.solve(shift * np.eye(n) - dense, right), abs=1e-11)


def test_a_cancelled_pivot_is_reported(tmp_path):
    code = eliminate(1, [(0, 0)]).code.replace("static int", '__attribute__((visibility("default"))) int')
    library = ctypes.CDLL(str(toolchain.shared_library({"lu.c": "#include <math.h>\n" + code}, tmp_path, "lu")))
    library.sparse_factor.argtypes = [
        ctypes.POINTER(ctypes.c_double),
        ctypes.c_double,
        ctypes.POINTER(ctypes.c_double),
    ]
    one, work = (ctypes.c_double * 1)(5.0), (ctypes.c_double * 1)()
    assert library.sparse_factor(one, 5.0, work) == 1
    assert library.sparse_factor(one, 6.0, work) == 0


def test_a_lowered_class_is_its_equations(tmp_path):
    """m dv/dt = u − c v, y = m v, with c computed from a parameter."""
    file = tmp_path / "M.mo"
    file.write_text(
        'model M parameter Real m(unit="kg")=2; parameter Real tau=4; parameter Real c=m/tau;'
        ' input Real u(unit="N"); Real v(unit="m/s",start=m,fixed=true,nominal=10) "speed"; output Real y;'
        " equation m*der(v)=u-c*v; y=m*v; end M;"
    )
    model = lower("M", file)
    assert [s.name for s in model.states] == ["v"]
    assert (model.states[0].unit, model.states[0].start, model.states[0].nominal) == ("m/s", 2.0, 10.0)
    assert [p.name for p in model.parameters] == ["m", "tau"]
    assert float(model.derivative(0, 3, 5, [2, 4])) == (5 - 0.5 * 3) / 2
    assert float(model.derivative(0, 3, 5, [2, 1])) == (5 - 2 * 3) / 2
    assert float(model.output(0, 3, 5, [2, 4])) == 6
    assert float(model.initial([7, 1])) == 7


def test_without_any_c_compiler_the_sentence_says_what_to_install(monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(toolchain.importlib.util, "find_spec", lambda _name: None)
    with pytest.raises(CompilerMissing, match="pip install ziglang"):
        toolchain.compiler()


def test_without_a_system_compiler_zig_is_taken(monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    assert toolchain.compiler().command[1:] == ("-m", "ziglang", "cc")


def test_a_c_error_is_shown(tmp_path):
    with pytest.raises(BuildFailed, match=r"(?s)could not compile wrong.*wrong\.c"):
        toolchain.shared_library({"wrong.c": "int f(void) { return }"}, tmp_path, "wrong")


def test_a_library_is_compiled_once(tmp_path):
    first = toolchain.shared_library({"a.c": "int f(void) { return 1; }"}, tmp_path, "a")
    made = first.stat().st_mtime_ns
    assert toolchain.shared_library({"a.c": "int f(void) { return 1; }"}, tmp_path, "a").stat().st_mtime_ns == made
    assert toolchain.shared_library({"a.c": "int f(void) { return 2; }"}, tmp_path, "a").stat().st_mtime_ns != made
