"""Imports point one way, as the plan of the house says."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ROOMS = ("fmus", "estimators", "controllers", "harness")

# Room or module → what it may import of ours; the longest matching name decides.
ALLOWED = {
    "fmus": ("fmus",),
    "estimators": ("estimators", "fmus.native", "fmus.errors"),
    "controllers": ("controllers",),
    "harness": ("harness", "controllers", "estimators", "fmus"),
    # The loop knows protocols and the values that pass between parties, no party.
    "harness.units": (),
    "harness.limits": (),
    "harness.formation": (),
    "harness.signals": ("harness.formation",),
    "harness.loop": ("harness.loop", "harness.record.outcome", "harness.record.recorder", "harness.signals",
                     "harness.formation", "controllers.sight", "estimators.belief", "fmus.native.toolchain"),
    "harness.scenario": ("harness.scenario", "harness.formation", "harness.units", "harness.limits"),
    # Whether a filter knows what it does not know is asked in one way, of a stop as of a recording.
    "harness.record": ("harness.record", "harness.scenario", "harness.formation", "harness.signals",
                       "estimators.consistency"),
    "harness.verdict": ("harness.verdict", "harness.record", "harness.scenario", "harness.units"),
    # What a loop in C calls is described where it is called; a child is started deaf to the terminal.
    "harness.fmu": ("harness.fmu", "harness.units", "harness.limits", "harness.interrupted", "harness.scratch",
                    "fmus.native.toolchain", "estimators.prediction", "harness.loop.compiled.Calls",
                    "harness.loop.ports.Edge"),
}  # fmt: skip


def modules():
    """Every module of ours."""
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.py")):
            name = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
            yield pytest.param(name, path, id=name)


def imported(path):
    """Names of modules that a file imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def inside(name, package):
    return name == package or name.startswith(f"{package}.")


@pytest.mark.parametrize(("name", "path"), list(modules()))
def test_imports_point_one_way(name, path):
    allowed = ALLOWED[max((room for room in ALLOWED if inside(name, room)), key=len)]
    for other in imported(path):
        ours = other.split(".")[0] in ROOMS
        assert not ours or any(inside(other, room) for room in allowed), f"{name} imports {other}"


@pytest.mark.parametrize(("name", "path"), list(modules()))
def test_only_the_fmu_room_of_the_harness_imports_fmpy(name, path):
    # fmus/ may use fmpy's checker on what it has built; it runs nothing through it.
    if not inside(name, "harness.fmu") and not inside(name, "fmus"):
        assert not any(inside(other, "fmpy") for other in imported(path))


@pytest.mark.parametrize(("name", "path"), list(modules()))
def test_only_assembly_names_concrete_laws_and_filters(name, path):
    concrete = ("controllers.full_brake", "controllers.slip_based", "controllers.adhesion_based", "estimators.ekf",
                "estimators.compiled")  # fmt: skip
    if inside(name, "harness.loop") or inside(name, "harness.verdict") or inside(name, "harness.record"):
        assert not any(inside(other, part) for other in imported(path) for part in concrete)


def test_no_room_is_called_after_nothing():
    assert not [path for room in ROOMS for path in (ROOT / room).rglob("*") if path.stem in {"core", "common", "utils"}]
