"""Parts of the built-in compiler, each tested separately."""

import ctypes
import importlib.util
import math
import os
import re
import shutil
import signal
import tempfile
import threading

import casadi as ca
import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from scipy.linalg import solve_banded
from small_fmus import FEATURES
from waiting import until

from railgrip.base.errors import BuildFailed, CompilerMissing, TranslationError
from railgrip.fmus.native import c_source, code, equations, lower, package, toolchain
from railgrip.fmus.native.c_source import LARGEST, MAX_ENTRIES, MAX_PRODUCTS, eliminate, fits, interpreter, tape
from railgrip.fmus.native.code import LARGEST_INCLUDED, RUNTIME
from railgrip.fmus.native.dae import read
from railgrip.fmus.native.loops import LONGEST, with_loops
from railgrip.fmus.native.system import explicit

POINTER = ctypes.POINTER(ctypes.c_double)
EXPORTED = '__attribute__((visibility("default")))'


def at(values):
    return values.ctypes.data_as(POINTER)


def elimination_library(n, pattern):
    """Return the compiled elimination of a pattern, and room for its factors."""
    elimination = eliminate(n, pattern)
    sizes = {"NX": n, "NJ": len(pattern), "NLU": elimination.entries}
    code = "\n".join(
        [
            "#include <math.h>",
            "#include <string.h>",
            *(f"#define {name} {value}" for name, value in sizes.items()),
            elimination.code,
            f"{EXPORTED} int factor(const double *j, double c, double *a) {{ return sparse_factor(j, c, a); }}",
            f"{EXPORTED} void solve(const double *a, double *b) {{ sparse_solve(a, b); }}",
        ]
    )
    library = ctypes.CDLL(str(toolchain.shared_library({"lu.c": code}, "lu", flags=package.FAST_BUILD)))
    library.factor.argtypes = [POINTER, ctypes.c_double, POINTER]
    library.solve.argtypes = [POINTER, POINTER]
    return library, np.zeros(elimination.entries)


@pytest.mark.parametrize(("seed", "n", "density"), [(0, 17, 0.15), (1, 17, 0.15), (2, 17, 0.15), (3, 60, 0.08)])
def test_sparse_elimination_agrees_with_numpy(seed, n, density):
    """Random sparse J with a shift that makes pivoting unnecessary; condition below 100, so 1e-11 is ample.

    With 60 unknowns factors and solution take more lines than one part of the generated code.
    """
    rng = np.random.default_rng(seed)
    dense = np.where(rng.random((n, n)) < density, rng.normal(size=(n, n)), 0.0)
    columns, rows = np.nonzero(dense.T)
    pattern = list(zip(rows.tolist(), columns.tolist(), strict=True))
    library, factors = elimination_library(n, pattern)
    values = np.array([dense[i, j] for i, j in pattern])
    shift, right = float(n), rng.normal(size=n)
    solution = right.copy()
    assert library.factor(at(values), shift, at(factors)) == 0
    library.solve(at(factors), at(solution))
    assert solution == pytest.approx(np.linalg.solve(shift * np.eye(n) - dense, right), abs=1e-11)


def test_elimination_of_a_long_chain_stays_sparse(monkeypatch):
    """A band matrix with more entries than a full one may have, which is lowered for a tenth of the compiler's time.

    The shift makes pivoting unnecessary and the condition below 10, so 1e-11 is ample.
    """
    for limit in ("MAX_ENTRIES", "MAX_PRODUCTS"):
        monkeypatch.setattr(c_source, limit, getattr(c_source, limit) // 10)
        monkeypatch.setitem(globals(), limit, getattr(c_source, limit))
    n, width = MAX_ENTRIES // 5 + 50, 2
    rng = np.random.default_rng(4)
    pattern = [(i, j) for j in range(n) for i in range(max(j - width, 0), min(j + width + 1, n))]
    values, right, shift = rng.uniform(-1, 1, len(pattern)), rng.normal(size=n), 10.0
    library, factors = elimination_library(n, pattern)
    assert factors.size > MAX_ENTRIES
    bands = np.zeros((2 * width + 1, n))
    bands[width] = shift
    for (i, j), value in zip(pattern, values, strict=True):
        bands[width + i - j, j] -= value
    solution = right.copy()
    assert library.factor(at(values), shift, at(factors)) == 0
    library.solve(at(factors), at(solution))
    assert solution == pytest.approx(solve_banded((width, width), bands, right), abs=1e-11)


def test_a_function_may_have_more_operations_than_its_tape_has_places():
    """A sum of squares of ten values, again and again: many operations, few values at once."""
    x = ca.SX.sym("x", 10)
    total = ca.SX(0)
    for _ in range(LARGEST // 20 + 100):
        total = ca.sin(total + ca.sumsqr(x))
    function = ca.Function("f_total", [x], [total])
    assert function.n_instructions() > LARGEST
    assert fits(function)
    given = [np.linspace(0.1, 1, 10)]
    (found,) = played(function, interpreter(), tape(function), given)
    assert found == np.asarray(function(*given)).ravel()


def test_a_cancelled_pivot_is_reported():
    library, factors = elimination_library(1, [(0, 0)])
    jacobian = np.array([5.0])
    assert library.factor(at(jacobian), 5.0, at(factors)) == 1
    assert library.factor(at(jacobian), 6.0, at(factors)) == 0


@pytest.mark.parametrize("n", [math.isqrt(MAX_ENTRIES) + 1, round((3 * MAX_PRODUCTS) ** (1 / 3)) + 2])
def test_elimination_with_too_many_entries_or_products_uses_pivoting(n):
    """A full matrix of n unknowns has n² entries, and takes (n − 1) n (2 n − 1) / 6 products."""
    library, factors = elimination_library(n, [(i, j) for j in range(n) for i in range(n)])
    assert factors.size == 0
    assert library.factor(at(np.zeros(n * n)), 1.0, at(factors)) == 1


def played(function, prelude, code, given):
    """Return the results of a function computed by the generated C."""
    run = f"{EXPORTED} void run(const double **a, double **r) {{ {function.name()}(a, r); }}"
    text = "\n".join(["#include <math.h>", *prelude, code, run])
    sources = {"model.c": text, "tape.c": (RUNTIME / "tape.c").read_text()}
    library = ctypes.CDLL(str(toolchain.shared_library(sources, "model", units=["model.c"], flags=["-O1"])))
    found = [np.zeros(function.nnz_out(k)) for k in range(function.n_out())]
    library.run((POINTER * len(given))(*map(at, given)), (POINTER * len(found))(*map(at, found)))
    return found


@pytest.mark.parametrize("values", [(2.5, 1.75), (1.75, 2.5), (0.5, -1.25)])
@pytest.mark.parametrize(("prelude", "write"), [(interpreter(), tape), ([], with_loops)], ids=["tape", "loops"])
def test_generated_c_computes_the_same_as_casadi(prelude, write, values):
    """Every operation on both sides of its branches, compared bit by bit with CasADi's own evaluation."""
    x, y = ca.SX.sym("x", 2), ca.SX.sym("y")
    a, b = x[0], x[1]
    every = [
        a + b, a - b, a * b, a / b, -a, 1 / a, a * a, 2 * a, ca.sqrt(a), a**b, a**2.5, ca.exp(b), ca.expm1(b),
        ca.log(a), ca.log1p(a), ca.sin(a), ca.cos(a), ca.tan(a), ca.asin(b / 9), ca.acos(b / 9), ca.atan(a),
        ca.atan2(a, b), ca.sinh(b), ca.cosh(b), ca.tanh(b), ca.asinh(a), ca.acosh(1 + a), ca.atanh(b / 9), ca.erf(b),
        ca.hypot(a, b), ca.fabs(b), ca.sign(b), ca.sign(-a), ca.copysign(a, b), ca.floor(b), ca.ceil(b),
        ca.fmod(a, b), ca.remainder(a, b), ca.fmin(a, b), ca.fmax(a, b), a < b, a <= b, a == b, a != b,
        ca.logic_not(a), ca.logic_and(a, b), ca.logic_or(a, 0 * b), ca.if_else(a < b, a, y), y, 3.25 * y,
    ]  # fmt: skip
    function = ca.Function("f_every", [x, y], [ca.vertcat(*every), a + y])
    given = [np.array(values), np.array([-7.5])]
    found = played(function, prelude, write(function), given)
    for result, expected in zip(found, function(*given), strict=True):
        np.testing.assert_array_equal(result, np.asarray(expected).ravel())


def orbit_of(steps):
    """Return a chaotic map as a function, and its values from 0.3: it amplifies any value lost between two parts."""
    x = ca.SX.sym("x")
    orbit = [x]
    for k in range(steps):
        orbit.append(3.75 * orbit[-1] * (1 - orbit[-1]) + 1e-3 * orbit[k // 2])
    function = ca.Function("f_orbit", [x], [ca.vertcat(*orbit), orbit[steps // 3] + orbit[-1]])
    return function, [np.asarray(values).ravel() for values in function(0.3)]


def test_a_long_function_is_split_into_parts_that_pass_on_their_values():
    function, expected = orbit_of(LONGEST)
    code = with_loops(function)
    assert code.count("static void f_orbit") > function.n_instructions() // LONGEST
    for result, values in zip(played(function, [], code, [np.array([0.3])]), expected, strict=True):
        np.testing.assert_array_equal(result, values)


def chain_of(n):
    """Return the forces in a chain of n wagons, as a function whose operands are in every order that occurs.

    Operands are the same element for all wagons, that of a neighbour, one in reverse order, or a sum over all; results
    are computed values, elements of arguments and constants, some of them twice, in order and in reverse.
    """
    x, v, p = ca.SX.sym("x", n), ca.SX.sym("v", n), ca.SX.sym("p")
    gaps = [ca.tanh(p * (x[i + 1] - x[i])) for i in range(n - 1)]
    behind, ahead = [ca.SX(0), *gaps], [*gaps, ca.SX(0)]
    forces = [a - b - v[i] * ca.fabs(v[i]) for i, (a, b) in enumerate(zip(ahead, behind, strict=True))]
    total = ca.sum1(ca.vertcat(*forces))
    crossed = [f * v[n - 1 - i] / (1 + total**2) for i, f in enumerate(forces)]
    power = [ca.if_else(c > 0, c, g * total) for c, g in zip(crossed, reversed(crossed), strict=True)]
    other = ca.vertcat(v, ca.SX(7), *forces[::-1], x[0], ca.SX(7), total, *crossed[1:], power[0])
    return ca.Function(f"f_chain{n}", [x, v, p], [ca.vertcat(*power), other])


def test_code_of_more_equal_parts_differs_only_in_its_tables():
    """Only the sum over all wagons has an operation more for each wagon."""
    lengths = []
    for n in (10, 20, 40):
        lines = [line for line in with_loops(chain_of(n)).splitlines() if "_places[]" not in line]
        lengths.append(len(lines))
    # The table of parts and the parts themselves grow with the sum, by one line a wagon.
    assert lengths[2] - lengths[1] <= 1.2 * 20
    assert lengths[1] - lengths[0] <= 1.2 * 10


def random_function(name, random):
    """Return a function of operations on random elements: equal ones for several parts, of which some differ."""
    x, parts = ca.SX.sym("x", 6), int(random.integers(1, 6))
    rows = [[x[int(k)] for k in random.integers(6, size=parts)] for _ in range(3)]
    for _ in range(random.integers(1, 15)):
        a, b = (rows[int(k)] for k in random.integers(len(rows), size=2))
        combine = [ca.SX.__add__, ca.SX.__mul__, ca.fmin, ca.hypot][int(random.integers(4))]
        shift = int(random.integers(parts))
        rows.append([combine(a[k], b[(k + shift) % parts]) for k in range(parts)])
        if random.integers(2):
            rows[-1][0] = rows[-1][-1] - 0.5
    every = [value for row in rows for value in row]
    results = [ca.vertcat(*(every[int(k)] for k in random.permutation(len(every)))), ca.vertcat(*rows[-1])]
    return ca.Function(name, [x], results, {"cse": True})


def test_loops_compute_what_casadi_computes():
    """Random functions, and chains, compiled together because a compiler takes a tenth of a second to start."""
    random = np.random.default_rng(0)
    functions = [random_function(f"f{k}_", random) for k in range(100)] + [chain_of(n) for n in (2, 3, 17)]
    runs = [
        f"{EXPORTED} void run{k}(const double **a, double **r) {{ {function.name()}(a, r); }}"
        for k, function in enumerate(functions)
    ]
    text = "\n".join(["#include <math.h>", *map(with_loops, functions), *runs])
    library = ctypes.CDLL(str(toolchain.shared_library({"model.c": text}, "model", flags=["-O1"])))
    for k, function in enumerate(functions):
        given = [random.uniform(-2, 2, function.nnz_in(i)) for i in range(function.n_in())]
        found = [np.zeros(function.nnz_out(i)) for i in range(2)]
        library[f"run{k}"]((POINTER * len(given))(*map(at, given)), (POINTER * 2)(*map(at, found)))
        for result, expected in zip(found, function.call(given), strict=True):
            np.testing.assert_array_equal(result, np.asarray(expected).ravel(), err_msg=f"function {k}")
    assert sum("for (int k = 0; k < " in line for f in functions for line in with_loops(f).splitlines()) > 200


def test_units_that_are_compiled_at_the_same_time_give_the_same_library_each_time():
    sources = {f"part{k}.c": f"double part{k}(double x) {{ return {k} * x; }}" for k in range(5)}
    first, again = (toolchain.binary(sources, "parts", units=[*sources]) for _ in range(2))
    assert first == again


def test_an_error_in_one_of_several_units_is_printed_and_nothing_is_left_behind(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    sources = {"right.c": "int f(void) { return 1; }", "wrong.c": "int g(void) { return }", "slow.c": "int h;"}
    with pytest.raises(BuildFailed, match=r"(?s)^\S+ could not compile parts:\nwrong\.c") as raised:
        toolchain.binary(sources, "parts", units=[*sources])
    assert "right.c" not in str(raised.value)
    assert [*tmp_path.iterdir()] == []


@pytest.mark.usefixtures("alarm")
def test_compilers_of_further_units_end_with_an_interruption(tmp_path, monkeypatch):
    """The compiler is a script that sleeps for an hour; the main thread is interrupted once two have started."""
    script = tmp_path / "cc"
    answer = '#!/bin/sh\ncase "$*" in *--version*) echo sleeper; exit;; esac\n'
    script.write_text(f"{answer}echo $$ >> {tmp_path}/running\nexec sleep 3600\n")
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    monkeypatch.setattr("os.cpu_count", lambda: 2)

    def started():
        return (tmp_path / "running").read_text().split() if (tmp_path / "running").exists() else []

    def interrupt():
        until(lambda: len(started()) >= 2)
        os.kill(os.getpid(), signal.SIGINT)

    # A shell that starts the tests in the background has them ignore the signal.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Thread(target=interrupt, daemon=True).start()
    try:
        with pytest.raises(KeyboardInterrupt):
            toolchain.binary({"a.c": "", "b.c": "", "c.c": ""}, "abc")
    finally:
        signal.signal(signal.SIGINT, before)
    for process in started():
        with pytest.raises(ProcessLookupError):
            os.kill(int(process), 0)


CHAIN = """model Chain "Coupled oscillators: an elimination with fill-in"
  parameter Integer n = 20;
  Real x[n](each start=1, each fixed=true), v[n](each start=0, each fixed=true);
  output Real y = sum(x);
equation
  for i in 1:n loop
    der(x[i]) = v[i];
    der(v[i]) = -sin(x[i])*exp(-x[i]^2) + (if i < n then x[min(i + 1, n)] - x[i] else 0) - 0.1*v[i];
  end for;
end Chain;
"""


def test_an_fmu_of_several_units_lists_them_and_steps_like_one_of_a_single_unit(tmp_path, written, monkeypatch):
    """What modelDescription.xml and buildDescription.xml list is what must be compiled, and nothing else."""
    system = explicit(read("Chain", written(CHAIN, "Chain.mo")))
    found = {}
    for limit in (0, LARGEST_INCLUDED):
        monkeypatch.setattr(code, "LARGEST_INCLUDED", limit)
        source = package.sources(system, interfaces=("me", "cs"))
        file = package.pack(source, tmp_path / f"chain{limit}.fmu")
        found[limit] = fmpy.simulate_fmu(str(file), fmi_type="CoSimulation", stop_time=2.0, output_interval=0.1)
        assert validate_fmu(str(file)) == []
        listed = re.findall('<File name="([^"]*)"/>', source.xml)
        assert listed == [*source.units] * 2
        assert re.findall('SourceFile name="([^"]*)"', package.as_fmi_3(source).files["buildDescription.xml"]) == [
            *source.units
        ]
        assert source.units == (("model.c",) if limit else ("model.c", "elimination.c"))
        # Several FMUs may be linked into one program, in which names of other linkage would clash.
        assert ("static int sparse_factor" in source.files["model.c"]) == bool(limit)
    np.testing.assert_array_equal(found[0], found[LARGEST_INCLUDED])


def test_a_lowered_class_equals_its_equations(written):
    """m dv/dt = u − c v, y = m v, with c computed from a parameter."""
    file = written(
        'model M parameter Real m(unit="kg")=2; parameter Real tau=4; parameter Real c=m/tau;'
        ' input Real u(unit="N"); Real v(unit="m/s",start=m,fixed=true,nominal=10) "speed"; output Real y;'
        " equation m*der(v)=u-c*v; y=m*v; end M;",
    )
    model = lower("M", file)
    assert [s.name for s in model.states] == ["v"]
    assert (model.states[0].unit, model.states[0].start, model.states[0].nominal) == ("m/s", 2.0, 10.0)
    assert [p.name for p in model.parameters] == ["m", "tau"]
    assert float(model.derivative(0, 3, 5, [2, 4])) == (5 - 0.5 * 3) / 2
    assert float(model.derivative(0, 3, 5, [2, 1])) == (5 - 2 * 3) / 2
    assert float(model.output(0, 3, 5, [2, 4])) == 6
    assert float(model.initial([7, 1])) == 7


def test_a_library_class_is_lowered_once_and_again_after_a_change(tmp_path, own_cache, monkeypatch):
    library = tmp_path / "Features"
    shutil.copytree(FEATURES, library)

    def pull():
        """der(v) = −4 x + 3 cos t at x = 1 and t = 0."""
        return float(lower("Features.Oscillator", library).derivative(0, [1, 0], [], [])[1])

    assert pull() == -1
    with monkeypatch.context() as kept:
        kept.setattr(equations.separate_process, "call", lambda *_: pytest.fail("it was kept"))
        assert pull() == -1
    file = library / "Oscillator.mo"
    file.write_text(file.read_text().replace("-4*x", "-9*x"))
    assert pull() == -6
    for written in own_cache.rglob("Features.Oscillator.json"):
        written.write_text("not a model")
    assert pull() == -6


def test_without_any_c_compiler_the_message_names_what_to_install(monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(toolchain.importlib.util, "find_spec", lambda _name: None)
    with pytest.raises(CompilerMissing, match="python -m pip install 'ziglang"):
        toolchain.compiler()


def test_without_a_system_compiler_zig_is_used(monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    assert toolchain.compiler().command[1:] == ("-P", "-m", "ziglang", "cc")


@pytest.mark.skipif(importlib.util.find_spec("ziglang") is None, reason="the Python package ziglang is not installed")
def test_zig_compiles_several_units_at_a_time(monkeypatch, tmp_path):
    """Three compilers start at once and fill the empty cache of zig; each unit has its part of the sum."""
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    for name in ("ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR"):
        monkeypatch.setenv(name, str(tmp_path / name))
    monkeypatch.setattr("os.cpu_count", lambda: 3)
    units = {f"unit{i}.c": f"#include <math.h>\ndouble part{i}(double x) {{ return {i} + cos(x); }}\n" for i in (1, 2)}
    declared = 'double part1(double x), part2(double x);\n__attribute__((visibility("default"))) '
    units["all.c"] = f"{declared}double sum(double x) {{ return part1(x) + part2(x); }}\n"
    library = tmp_path / f"sum{toolchain.SUFFIX}"
    library.write_bytes(toolchain.binary(units, "sum"))
    function = ctypes.CDLL(str(library)).sum
    function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double]
    assert function(0.0) == 5.0


def test_a_library_is_compiled_once(own_cache):
    first = toolchain.shared_library({"a.c": "int f(void) { return 1; }"}, "a")
    file = first.stat().st_ino  # the file's time changes: the cache notes when it was last used
    assert toolchain.shared_library({"a.c": "int f(void) { return 1; }"}, "a").stat().st_ino == file
    other = toolchain.shared_library({"a.c": "int f(void) { return 2; }"}, "a")
    assert other != first
    assert other.read_bytes() != first.read_bytes()


def test_equations_of_an_unknown_kind_of_loop_are_refused(written):
    """Another version of the front end may write others; guessed, each could be repeated or left out."""
    dae = read("Chain", written(CHAIN, "Chain.mo"))
    owner = next(o for o in dae.content["continuous_equation_operations"] if o.get("scalar_view"))
    owner["scalar_view"] = "Diagonal"
    with pytest.raises(
        TranslationError, match=r"^Chain\.mo:\d+: Chain: equations of the kind Diagonal are not supported"
    ):
        explicit(dae)
