"""`--json` prints only the result on standard output; the exit code says whether there is a result."""

import json

import pytest


@pytest.mark.parametrize(
    ("change", "code", "outcome"), [("start.speed=36 km/h", 0, "standstill"), ("description=slide", 3, "horizon")]
)
def test_a_run_prints_its_figures_as_json(railgrip, project, change, code, outcome):
    """Also a run without standstill, which has no braking distance."""
    ended = railgrip("run", "wet.toml", "--json", "--set", change)
    result = json.loads(ended.out)
    assert (ended.code, result["outcome"]) == (code, outcome)
    assert result["braking_distance"] == result["metrics"]["distance"]
    assert (result["braking_distance"] or 0.0) > 0.0 or code == 3
    record = json.loads((project / result["folder"] / "stop.json").read_text(encoding="utf-8"))
    assert record["metrics"] == result["metrics"]
    if code == 3:
        assert result["braking_distance"] is None
        assert "Still moving" in result["reason"]
        assert "the stop ended with horizon: Still moving" in ended.err


def test_a_consistent_train_prints_stops_and_no_contradiction(railgrip):
    ended = railgrip("train", "check", "emu387", "--json")
    result = json.loads(ended.out)
    assert ended.code == 0
    assert not any(finding["wrong"] for finding in result["findings"])
    assert all(stop["speed"] ** 2 / (2 * stop["distance"]) < stop["deceleration"] for stop in result["stops"])


def test_an_inconsistent_train_prints_its_contradictions_and_exits_2(railgrip, project):
    assert railgrip("new", "train", "own.toml").code == 0
    text = (project / "own.toml").read_text(encoding="utf-8")
    assert "spring_force" in text
    lines = ['spring_force = "12 kN"' if line.startswith("spring_force") else line for line in text.splitlines()]
    (project / "own.toml").write_text("\n".join(lines), encoding="utf-8")
    ended = railgrip("train", "check", "own.toml", "--json")
    result = json.loads(ended.out)
    assert ended.code == 2
    assert [finding["key"] for finding in result["findings"] if finding["wrong"]]
    assert result["stops"] == []
