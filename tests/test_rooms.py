"""Imports point one way, as the plan of the house says."""

import ast
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ROOMS = ("fmus", "estimators", "controllers", "harness")

# Room or module → what it may import of ours; the longest matching name decides.
ALLOWED = {
    "railgrip.errors": (),
    "railgrip.files": (),
    "railgrip.cache": (),
    "railgrip.fmus": ("railgrip.fmus",),
    "railgrip.estimators": ("railgrip.estimators", "railgrip.fmus.native"),
    "railgrip.controllers": ("railgrip.controllers",),
    "railgrip": ("railgrip",),
    # The loop knows protocols and the values that pass between parties, no party.
    "railgrip.units": (),
    "railgrip.limits": (),
    "railgrip.formation": ("railgrip.controllers.brake",),
    "railgrip.signals": ("railgrip.formation",),
    "railgrip.loop": ("railgrip.loop", "railgrip.trace.outcome", "railgrip.trace.recorder", "railgrip.signals",
                      "railgrip.formation", "railgrip.controllers.observation", "railgrip.estimators.belief",
                      "railgrip.fmus.native.toolchain"),
    "railgrip.track": ("railgrip.track",),
    "railgrip.scenario": ("railgrip.scenario", "railgrip.track", "railgrip.formation", "railgrip.units",
                          "railgrip.limits", "railgrip.fmus.native.library", "railgrip.trace.outcome"),
    "railgrip.rolling_stock": ("railgrip.rolling_stock", "railgrip.scenario", "railgrip.report"),
    # Whether a filter knows what it does not know is asked in one way, of a stop as of a recording.
    "railgrip.trace": ("railgrip.trace", "railgrip.formation", "railgrip.signals", "railgrip.units",
                       "railgrip.scenario", "railgrip.estimators.consistency"),
    "railgrip.report": ("railgrip.report", "railgrip.trace", "railgrip.scenario", "railgrip.units"),
    # What a loop in C calls is described where it is called; a child is started deaf to the terminal.
    "railgrip.fmu": ("railgrip.fmu", "railgrip.units", "railgrip.limits", "railgrip.interrupted", "railgrip.files",
                     "railgrip.fmus.native.toolchain", "railgrip.fmus.native.ctext",
                     "railgrip.estimators.model_in_c", "railgrip.loop.ports.CInterface"),
}  # fmt: skip

GROUND = ("railgrip.errors", "railgrip.files", "railgrip.cache")
"""What every room may import."""


def modules():
    """Every module of ours."""
    for room in ROOMS:
        package = "railgrip" if room == "harness" else f"railgrip.{room}"
        for path in sorted((ROOT / room).rglob("*.py")):
            name = ".".join((package, *path.relative_to(ROOT / room).with_suffix("").parts)).removesuffix(".__init__")
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
    targets = (*ALLOWED[max((room for room in ALLOWED if inside(name, room)), key=len)], *GROUND)
    for other in imported(path):
        top = other.split(".")[0]
        assert top not in ROOMS, f"{name} imports {other} by its folder; the package is railgrip"
        assert top != "railgrip" or any(inside(other, room) for room in targets), f"{name} imports {other}"


def test_no_files_import_each_other_in_a_circle():
    """Not even late or for types alone. The door itself, `railgrip`, loads by name what it is asked for."""
    files = {name: path for name, path in (case.values for case in modules()) if name != "railgrip"}
    graph = {
        name: {other if other in files else other.rpartition(".")[0] for other in imported(path)} & files.keys()
        for name, path in files.items()
    }
    TopologicalSorter(graph).prepare()


@pytest.mark.parametrize(("name", "path"), list(modules()))
def test_only_the_fmu_room_of_the_harness_imports_fmpy(name, path):
    # fmus/ may use fmpy's checker on what it has built; it runs nothing through it.
    if not inside(name, "railgrip.fmu") and not inside(name, "railgrip.fmus"):
        assert not any(inside(other, "fmpy") for other in imported(path))


@pytest.mark.parametrize(("name", "path"), list(modules()))
def test_only_assembly_names_concrete_laws_and_filters(name, path):
    concrete = ("railgrip.controllers.full_brake", "railgrip.controllers.slip_based",
                "railgrip.controllers.adhesion_based", "railgrip.estimators.ekf",
                "railgrip.estimators.compiled")  # fmt: skip
    if inside(name, "railgrip.loop") or inside(name, "railgrip.report") or inside(name, "railgrip.trace"):
        assert not any(inside(other, part) for other in imported(path) for part in concrete)


@pytest.mark.parametrize(("name", "path"), list(modules()))
def test_only_the_command_line_knows_studies(name, path):
    edge = ("railgrip.studies", "railgrip.cli", "railgrip.bench")
    if not any(inside(name, room) for room in edge):
        assert not [other for other in imported(path) if inside(other, "railgrip.studies")]


@pytest.mark.parametrize(("name", "path"), list(modules()))
def test_sentences_for_users_have_one_tree(name, path):
    if name in {"railgrip.errors", "railgrip.interrupted"}:  # a signal is no error
        return
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ClassDef):
            parents = [ast.unparse(base) for base in node.bases]
            assert not [base for base in parents if base.endswith(("Error", "Exception"))], f"{name}.{node.name}"


def test_no_room_is_called_after_nothing():
    assert not [path for room in ROOMS for path in (ROOT / room).rglob("*") if path.stem in {"core", "common", "utils"}]
