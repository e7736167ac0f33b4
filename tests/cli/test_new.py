"""`railgrip new`: each file runs unchanged, agrees with its schema, and never overwrites another."""

import json
import re
import runpy
import tomllib
from pathlib import Path

import jsonschema
import pytest
from wrong import table

from railgrip.scenario.load import load
from railgrip.studies.benefit.line import load_study_line

KINDS = ("scenario", "train", "campaign", "controller", "estimator")


@pytest.fixture
def folder(tmp_path_factory, monkeypatch):
    """An empty folder, which is the current folder."""
    folder = tmp_path_factory.mktemp("begin")
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def answer(command, in_process):
    """A function that runs a command and returns its output."""

    def run(*arguments):
        done = command(*arguments)
        assert done.code == 0, done.err
        return done.out

    return run


def test_a_new_scenario_runs(folder, answer):
    answer("new", "scenario", "mine.toml")
    assert "mine: standstill" in answer("run", "mine.toml")


def test_lines_commented_out_in_a_new_scenario_are_the_defaults(folder, answer):
    """The scenario is the same with every such line uncommented."""
    answer("new", "scenario", "mine.toml")
    text = (folder / "mine.toml").read_text(encoding="utf-8")
    in_force, count = re.subn(r"^# (\[\w+\]|\w+ = )", r"\1", text, flags=re.MULTILINE)
    assert count > 10
    (folder / "other").mkdir()
    (folder / "other" / "mine.toml").write_text(in_force, encoding="utf-8")
    assert load(folder / "other" / "mine.toml") == load(folder / "mine.toml")


def test_a_new_campaign_runs(folder, answer):
    answer("new", "campaign", "pair.toml")
    output = answer("campaign", "pair.toml", "--set", "start.speed=30 km/h")
    assert "build/pair/index.html" in output
    assert len(list((folder / "build/pair").glob("*/stop.json"))) == 4


def test_a_new_train_runs(folder, answer):
    answer("new", "train", "mine.toml")
    checked = answer("train", "check", "mine.toml")
    assert "mine: 88.0 t" in checked
    assert "by hand (EN 14531-1)" in checked
    # Axles that turn as one are compiled in half of the time.
    text = (folder / "mine.toml").read_text(encoding="utf-8").replace("coupled = false", "coupled = true")
    (folder / "mine.toml").write_text(text, encoding="utf-8")
    (folder / "stop.toml").write_text('extends = "plain"\nvehicle.train = "mine.toml"\nestimator.kind = "none"\n')
    assert "stop: standstill" in answer(
        "run", "stop.toml", "--set", "start.speed=30 km/h", "--set", "controller.kind=full_brake"
    )


def test_a_new_line_is_one_of_study_benefit(folder, answer):
    """Lines that are commented out are examples, and valid together."""
    assert "railgrip study benefit emu387 --line my_line.toml" in answer("new", "line", "my_line.toml")
    text = (folder / "my_line.toml").read_text(encoding="utf-8")
    assert load_study_line(Path("my_line.toml")).name == "my_line"
    in_force, count = re.subn(r"^# (\[\w+\]|\w+ = )", r"\1", text, flags=re.MULTILINE)
    assert count == 4
    (folder / "other.toml").write_text(in_force, encoding="utf-8")
    assert load_study_line(Path("other.toml")).stop[0].dwell == 40.0


@pytest.mark.parametrize(
    ("kind", "printed"), [("controller", r"MyController: standstill, \d"), ("estimator", r"root mean square .*\[0\.0")]
)
def test_a_new_part_runs_alone_and_in_a_scenario(folder, answer, capfd, kind, printed):
    answer("new", kind, f"my_{kind}.py")
    runpy.run_path(f"my_{kind}.py", run_name="__main__")
    assert re.search(printed, capfd.readouterr().out)
    command = re.search(r"^railgrip (run .*)$", (folder / f"my_{kind}.py").read_text(encoding="utf-8"), re.MULTILINE)
    assert command is not None
    assert "trapezoid: standstill" in answer(*command[1].split(), "--set", "start.speed=30 km/h")


@pytest.mark.parametrize("kind", ["scenario", "train", "campaign"])
def test_the_first_line_names_the_schema_of_the_file(railgrip, folder, kind):
    assert railgrip("new", kind, "sub/mine.toml").code == 0
    text = (folder / "sub" / "mine.toml").read_text(encoding="utf-8")
    directive, path = text.splitlines()[0].split()
    assert directive == "#:schema"
    schema = json.loads((folder / "sub" / path).read_text(encoding="utf-8"))
    jsonschema.Draft7Validator(schema).validate(tomllib.loads(text))
    assert json.loads(railgrip("schema", kind).out) == schema


@pytest.mark.parametrize("kind", KINDS)
def test_existing_files_are_not_overwritten(railgrip, folder, kind):
    file = "mine.py" if kind in ("controller", "estimator") else "mine.toml"
    (folder / file).write_text("here before", encoding="utf-8")
    (folder / f"{kind}.schema.json").write_text("here before", encoding="utf-8")
    assert railgrip("new", kind, file).refuses(f"{file} exists; choose another file")
    assert railgrip("new", kind, f"other_{file}").code == 0
    assert (folder / file).read_text(encoding="utf-8") == "here before"
    assert (folder / f"{kind}.schema.json").read_text(encoding="utf-8") == "here before"


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    table(__file__, "tables.toml")["wrong_files"],
    ids=str,
)
def test_a_file_that_cannot_be_created_is_refused(railgrip, folder, arguments, sentence):
    (folder / "taken").write_text("a file", encoding="utf-8")
    result = railgrip("new", *arguments)
    assert result.code in (2, 3)
    assert sentence in result.err
    assert [path.name for path in folder.iterdir()] == ["taken"]
