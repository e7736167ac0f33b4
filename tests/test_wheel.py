"""The wheel: one package with everything in it, that runs where nothing of the project is around."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DATA = {".typed", ".toml", ".json", ".mo", ".order", ".c", ".h", ".jinja"}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Built from a copy, so that no folder of an earlier build takes part."""
    source, out = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("wheel")
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True).stdout
    for name in filter(None, listed.decode().split("\0")):
        if not name.startswith("tests/") and (ROOT / name).is_file():
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            (source / name).write_bytes((ROOT / name).read_bytes())
    build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "-w", str(out)]
    subprocess.run([*build, str(source)], check=True, capture_output=True)
    (built,) = out.glob("*.whl")
    return built, source


def test_it_holds_one_package_with_every_file_of_ours(wheel):
    built, source = wheel
    names = {name for name in zipfile.ZipFile(built).namelist() if ".dist-info/" not in name}
    assert {name.partition("/")[0] for name in names} == {"railgrip"}
    expected = set[str]()
    for room, package in {
        "harness": "railgrip", **{r: f"railgrip/{r}" for r in ("controllers", "estimators", "fmus", "modelica")}
    }.items():  # fmt: skip
        files = (path for path in (source / room).rglob("*") if path.suffix in DATA | {".py"})
        expected |= {f"{package}/{path.relative_to(source / room).as_posix()}" for path in files}
    assert expected == names


def test_it_runs_from_an_empty_folder_without_a_network(wheel, tmp_path):
    """Its own FMU, filter and loop are compiled on the way, into the user's cache and nowhere else."""
    site, here, cache = (tmp_path / name for name in ("site", "here", "cache"))
    here.mkdir()
    install = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-compile", "--no-index"]
    subprocess.run([*install, "--target", str(site), str(wheel[0])], check=True, capture_output=True)
    nowhere = dict.fromkeys(("http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY"), "http://127.0.0.1:9")
    done = subprocess.run(
        [sys.executable, "-m", "railgrip", "run", "trapezoid"],
        cwd=here,
        env=os.environ | nowhere | {"PYTHONPATH": str(site), "RAILGRIP_CACHE": str(cache)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "trapezoid: standstill, 293.72 m" in done.stdout
    assert {path.name for path in here.iterdir()} == {"build"}
    assert [path.name for path in (here / "build").iterdir()] == ["runs"]
    assert any(cache.rglob("TwoPartTrain.fmu"))
    assert not [path for path in site.rglob("*") if path.suffix in {".so", ".fmu", ".dll", ".dylib"}]
