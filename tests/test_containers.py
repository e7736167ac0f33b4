"""Container, development container and CI name only existing files and targets."""

import json
import re
import shutil
import subprocess
import sys
import tomllib

import pytest
import yaml
from project_files import ROOT

TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))


def instructions() -> list[list[str]]:
    """Words of each instruction of the Dockerfile."""
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    lines = re.sub(r"^#.*\n", "", text, flags=re.MULTILINE).replace("\\\n", " ").splitlines()
    return [line.split() for line in lines if line.strip()]


def test_the_image_copies_all_sources_of_the_package():
    copied = {word for name, *words in instructions() if name == "COPY" for word in words[:-1]}
    assert all((ROOT / path).exists() for path in copied)
    # setup.py maps these folders to packages; pyproject.toml names the files of its metadata.
    assert copied == {
        *("pyproject.toml", "setup.py", "README.md", "LICENSE"),
        *("harness", "estimators", "controllers", "fmus", "modelica"),
    }
    ignored = (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines()
    assert not copied & set(ignored)


def test_the_image_does_not_run_as_root():
    assert [words for words in instructions() if words[0] == "USER"][-1] == ["USER", "1000"]


def test_the_development_container_uses_that_image_and_a_target_of_make():
    table = json.loads((ROOT / ".devcontainer/devcontainer.json").read_text(encoding="utf-8"))
    folder = ROOT / ".devcontainer"
    assert (folder / table["build"]["dockerfile"]).resolve() == ROOT / "Dockerfile"
    assert (folder / table["build"]["context"]).resolve() == ROOT
    make, target = table["postCreateCommand"].split()
    assert make == "make"
    assert target in TARGETS


def test_ci_calls_existing_targets():
    jobs = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text(encoding="utf-8"))["jobs"]
    commands = [step["run"] for job in jobs.values() for step in job["steps"] if "run" in step]
    called = {match for command in commands for match in re.findall(r"^make ([a-z-]+)", command)}
    assert called >= {"docs", "portable", "test-omc", "regress-omc"}
    assert called <= TARGETS


@pytest.mark.parametrize("system", ["ubuntu-latest", "macos-latest", "windows-latest"])
def test_ci_covers_each_python_on_each_system(system):
    jobs = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text(encoding="utf-8"))["jobs"]
    matrix = jobs["platforms"]["strategy"]["matrix"]
    assert system in matrix["os"]
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    stated = [line.rpartition(" ")[2] for line in project["classifiers"] if re.search(r"Python :: 3\.", line)]
    assert matrix["python"] == stated == ["3.11", "3.12", "3.13", "3.14"]


def test_ci_compares_with_openmodelica_as_before_every_landing():
    """The job on a public runner makes the targets of .ci/run, and installs all programs that omc starts."""
    jobs = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text(encoding="utf-8"))["jobs"]
    job = "\n".join(step["run"] for step in jobs["openmodelica"]["steps"] if "run" in step)
    script = (ROOT / ".ci/run").read_text(encoding="utf-8")
    made, made_by_script = (re.findall(r"^make ([a-z-]+)$", text, re.MULTILINE) for text in (job, script))
    assert ["test", "test-all", *made] == made_by_script
    for text in (job, script, " ".join(word for words in instructions() for word in words)):
        joined = text.replace("\\\n", " ")
        assert all(re.search(rf"install .*\b{one}\b", joined) for one in ("cmake", "make", "zip", "gcc", "libc6-dev"))


PROGRAMS = {"omc", "gcc", "cmake", "zip"}


@pytest.mark.skipif(sys.platform == "win32", reason="a script of bash")
@pytest.mark.parametrize(
    ("place", "missing", "installs", "calls"),
    [
        (None, {"omc"}, True, ["make test", "make test-all"]),
        ("bin", set(), True, ["make test", "make test-all", "make regress-omc", "make test-omc"]),
        ("shared/omc/bin", set(), True, ["make test", "make test-all", "make regress-omc", "make test-omc"]),
        ("bin", {"zip", "cmake"}, True, ["make test", "make test-all", "apt-get", "make regress-omc", "make test-omc"]),
        ("bin", {"zip"}, False, ["make test", "make test-all", "apt-get"]),
    ],
    ids=["no omc", "on the path", "next to the clone", "packages are missing", "packages cannot be installed"],
)
def test_ci_runs_openmodelica_where_it_is(tmp_path, place, missing, installs, calls):
    """Its programs are installed if they are missing; without omc, a line says what was left out."""
    for folder in ("bin", "clone/.ci", "shared/omc/bin"):
        (tmp_path / folder).mkdir(parents=True)
    log = tmp_path / "log"

    def program(name: str, *lines: str) -> None:
        file = tmp_path / (place if name == "omc" and place else "bin") / name
        file.write_text("\n".join(["#!/bin/sh", *lines, ""]))
        file.chmod(0o755)

    for name in PROGRAMS - missing:
        program(name)
    program("make", f'echo "make $1" >> {log}')
    program("id", "echo 0")
    install = [f"cp {tmp_path}/bin/gcc {tmp_path}/bin/{name}" for name in sorted(missing)]
    program(
        "apt-get", 'test "$1" = install || exit 0', f"echo apt-get >> {log}", *(install if installs else ["exit 100"])
    )
    for name in ("dirname", "cp", "sh"):
        (tmp_path / "bin" / name).symlink_to(str(shutil.which(name)))
    script = shutil.copy(ROOT / ".ci/run", tmp_path / "clone/.ci/run")
    ran = subprocess.run(
        [str(shutil.which("bash")), script], env={"PATH": str(tmp_path / "bin")}, capture_output=True, text=True
    )
    assert (ran.returncode, log.read_text().splitlines()) == (0, calls), ran.stderr
    assert ("were left out" in ran.stdout) == ("make test-omc" not in calls)
    assert all(name in ran.stderr for name in missing - {"omc"} if not installs)
