"""The wheel: one complete package that runs without the project's sources."""

import json
import re
import shutil
import subprocess
import sys
import zipfile

import pytest
import xarray
from command_line import NO_NETWORK, ran
from project_files import ROOT, project_files
from wrong import table

DATA = {".typed", ".csv", ".yml", ".toml", ".json", ".mo", ".order", ".c", ".h", ".jinja", ".js", ".gz", ".txt", ".ld"}


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """The unpacked source distribution of a copy of the project, in which no folder of an earlier build is."""
    project, out = tmp_path_factory.mktemp("project"), tmp_path_factory.mktemp("source")
    for name in project_files():
        (project / name).parent.mkdir(parents=True, exist_ok=True)
        (project / name).write_bytes((ROOT / name).read_bytes())
    build = f"from setuptools.build_meta import build_sdist; build_sdist({str(out)!r})"
    subprocess.run([sys.executable, "-c", build], cwd=project, check=True, capture_output=True)
    (built,) = out.glob("*.tar.gz")
    shutil.unpack_archive(built, out, filter="data")
    return out / built.name.removesuffix(".tar.gz")


@pytest.fixture(scope="module")
def wheel(source, tmp_path_factory):
    out = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "-w", str(out)]
    copy = shutil.copytree(source, out / "source")  # pip leaves a folder `build` in it
    subprocess.run([*build, str(copy)], check=True, capture_output=True)
    (built,) = out.glob("*.whl")
    return built, source


def test_the_source_distribution_has_every_file_of_the_project(source):
    """Tests, documentation and the Makefile work in it as in a clone."""
    files = {path.relative_to(source).as_posix() for path in source.rglob("*") if path.is_file()}
    extra = {name for name in files if name.startswith("railgrip.egg-info/")} | {"PKG-INFO", "setup.cfg"}
    assert files - extra == set(project_files()) - extra  # which an unpacked distribution has, too


def test_the_description_for_an_index_has_no_link_or_picture_of_a_file(source):
    """A package index shows neither; paths are those of the source distribution."""
    text = (source / "PKG-INFO").read_text(encoding="utf-8").partition("\n\n")[2]
    assert text.startswith("# railgrip\n")
    assert not re.findall(r"\]\((?!https:)|!\[|<!--", text)
    named = re.findall(r"`([\w/]+\.(?:md|cff))`", text)
    assert len(named) > 6
    assert not [name for name in named if not (source / name).is_file()]


def test_it_contains_one_package_with_every_file(wheel):
    built, source = wheel
    names = {name for name in zipfile.ZipFile(built).namelist() if ".dist-info/" not in name}
    assert {name.partition("/")[0] for name in names} == {"railgrip"}
    expected = set[str]()
    for folder, package in {
        "harness": "railgrip", **{r: f"railgrip/{r}" for r in ("controllers", "estimators", "fmus", "modelica")}
    }.items():  # fmt: skip
        files = (path for path in (source / folder).rglob("*") if path.suffix in DATA | {".py"})
        expected |= {f"{package}/{path.relative_to(source / folder).as_posix()}" for path in files}
    assert expected | {"railgrip/report/plotly/LICENSE"} == names


TINY = table(__file__, "tables.toml")["tiny_laws"]


@pytest.fixture(scope="module")
def environment(wheel, tmp_path_factory):
    """A folder where the wheel is installed with another package that provides parts, and an empty user cache."""
    site, tiny = tmp_path_factory.mktemp("site"), tmp_path_factory.mktemp("tiny")
    for name, text in TINY.items():
        (tiny / name).write_text(text)
    install = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-compile", "--no-index"]
    install += ["--no-build-isolation", "--target", str(site)]
    subprocess.run([*install, str(wheel[0]), str(tiny)], check=True, capture_output=True)
    return site, tmp_path_factory.mktemp("cache")


def alone(environment, here, *arguments):
    """Run Python in a folder with only the installed packages, and without a network."""
    site, cache = environment
    result = ran([sys.executable, *arguments], here, **NO_NETWORK, PYTHONPATH=str(site), RAILGRIP_CACHE=str(cache))
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_it_runs_from_an_empty_folder_without_a_network(environment, tmp_path):
    """Its own FMU, filter and loop are compiled on demand, into the user's cache and nowhere else."""
    (site, cache), here = environment, tmp_path
    printed = alone(environment, here, "-m", "railgrip", "run", "trapezoid")
    assert "trapezoid: standstill, 293.72 m" in printed
    assert {path.name for path in here.iterdir()} == {"build"}
    assert [path.name for path in (here / "build").iterdir()] == ["runs"]
    assert any(cache.rglob("TwoPartTrain.fmu"))
    assert not [path for path in site.rglob("*") if path.suffix in {".so", ".fmu", ".dll", ".dylib"}]


def test_parts_of_an_installed_package_are_found_by_their_names(environment, tmp_path):
    """Through their entry points, by the command line; half of 3.4 and 2 bar."""
    kinds = {"controller": "half", "estimator": "drag", "sensors": "exact"}
    tables = [text for role, kind in kinds.items() for text in ("--set", f"{role}={{kind='{kind}'}}")]
    alone(environment, tmp_path, "-m", "railgrip", "run", "trapezoid", *tables, "--set", "start.speed=5 km/h")
    (record,) = tmp_path.rglob("stop.json")
    classes = json.loads(record.read_text())["classes"]
    assert {role: part["class"] for role, part in classes.items()} == {
        "controller": "tiny_laws:Share", "estimator": "tiny_laws:Drag", "sensors": "tiny_laws:Exact",
    }  # fmt: skip
    with xarray.open_dataset(record.with_name("trace.nc")) as trace:
        assert trace["demand"].values[-1].tolist() == [1.7e5, 1e5, 1e5, 1.7e5]
        assert "estimate_pad_friction" not in trace


SHORTER = """
import railgrip.api as api
load = api.Scenario.load.__func__
api.Scenario.load = classmethod(lambda cls, source, changes=None: load(cls, source, {"limits.horizon": "0.2 s"}))
"""

CELLS = """
import json, sys
for number, cell in enumerate(c for c in json.load(open(sys.argv[1]))["cells"] if c["cell_type"] == "code"):
    exec(compile("".join(cell["source"]), f"<cell {number}>", "exec"), globals())
"""


def test_the_page_about_python_runs_with_the_installed_wheel(environment, tmp_path):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "api.md").read_text(), re.DOTALL)
    assert len(blocks) >= 2
    results = "print(mine.trace.sizes['time'], bench.stop.outcome.value, rg.__file__)"
    printed = alone(environment, tmp_path, "-c", "\n".join((SHORTER, *blocks, results)))
    samples, outcome, file = printed.splitlines()[-1].split(maxsplit=2)
    assert (samples, outcome) == ("201", "horizon")
    assert file.startswith(str(environment[0]))


def test_the_notebook_of_own_parts_runs_with_the_installed_wheel(environment, tmp_path):
    """Cell by cell, as in a notebook: classes belong to the main module and have no file. The sweep has fewer seeds."""
    text = (ROOT / "docs" / "examples" / "own_parts.ipynb").read_text(encoding="utf-8")
    notebook = tmp_path / "own_parts.ipynb"
    notebook.write_text(text.replace("range(25)", "range(4)"), encoding="utf-8")
    figures = """
print(json.dumps({
    "distances": [stop.metrics.distance for stop in (bang_bang, noisy, sprinter)],
    "outcomes": [stop.outcome.value for stop in (bang_bang, estimated, noisy, sprinter)],
    "rows": len(table), "drawn": int(table["distance"].nunique()), "ended": sorted(set(table["outcome"])),
    "classes": {role: part["class"] for role, part in (estimated.classes | noisy.classes).items()},
}))
"""
    printed = json.loads(alone(environment, tmp_path, "-c", CELLS + figures, str(notebook)).splitlines()[-1])
    assert printed["outcomes"] == ["standstill"] * 4
    assert printed["rows"] == 8
    assert printed["ended"] == ["standstill"]
    assert printed["drawn"] > 4  # noise of the wheels depends on the seed
    own, noisy, light = printed["distances"]
    assert 5.0 < light < own < 60.0
    assert abs(noisy - own) < 5.0
    assert printed["classes"] == {
        "controller": "__main__:BangBang", "estimator": "__main__:Drag", "sensors": "__main__:NoisyWheels",
    }  # fmt: skip
    assert {path.name for path in tmp_path.iterdir()} == {"own_parts.ipynb", "Sprinter.mo"}
