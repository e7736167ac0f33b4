"""`--json` prints the result and nothing else on standard output; exit codes say whether there is one."""

import json

import pytest


def test_a_run_prints_its_figures_as_json(railgrip, project):
    ended = railgrip("run", "wet.toml", "--json", "--set", "start.speed=36 km/h")
    result = json.loads(ended.out)
    assert ended.code == 0
    assert result["outcome"] == "standstill"
    assert result["braking_distance"] == result["metrics"]["distance"] > 0
    record = json.loads((project / result["folder"] / "stop.json").read_text(encoding="utf-8"))
    assert record["metrics"] == result["metrics"]


def test_a_run_without_standstill_has_a_result_and_exit_code_3(railgrip):
    ended = railgrip("run", "wet.toml", "--json", "--set", "description=slide")
    result = json.loads(ended.out)
    assert ended.code == 3
    assert result["outcome"] == "horizon"
    assert result["braking_distance"] is None
    assert "Still moving" in result["reason"]


@pytest.mark.parametrize(
    "arguments", [("run", "wet.toml", "--set", "start.sped=3"), ("run", "nothing"), ("train", "check", "nothing")]
)
def test_a_wrong_question_leaves_standard_output_empty(arguments, railgrip):
    ended = railgrip(*arguments, "--json")
    assert (ended.code, ended.out) == (2, "")
    assert ended.err


def test_a_train_that_fits_prints_stops_and_no_contradiction(railgrip):
    ended = railgrip("train", "check", "emu387", "--json")
    result = json.loads(ended.out)
    assert ended.code == 0
    assert not any(finding["wrong"] for finding in result["findings"])
    assert all(stop["speed"] ** 2 / (2 * stop["distance"]) < stop["deceleration"] for stop in result["stops"])


def test_a_train_that_contradicts_itself_prints_the_contradictions_and_ends_with_2(railgrip, project):
    assert railgrip("new", "train", "own.toml").code == 0
    text = (project / "own.toml").read_text(encoding="utf-8")
    assert "spring_force" in text
    lines = ['spring_force = "50 kN"' if line.startswith("spring_force") else line for line in text.splitlines()]
    (project / "own.toml").write_text("\n".join(lines), encoding="utf-8")
    ended = railgrip("train", "check", "own.toml", "--json")
    result = json.loads(ended.out)
    assert ended.code == 2
    assert [finding["key"] for finding in result["findings"] if finding["wrong"]]
    assert result["stops"] == []
