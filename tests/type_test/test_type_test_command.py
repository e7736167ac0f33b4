"""`railgrip study type_test` runs missing stops, evaluates them, and writes the results."""

import json
import shutil
from pathlib import Path

import pandas
import pytest
from command_line import exit_code
from one_process import one_process

from railgrip.base.errors import ScenarioError
from railgrip.studies.type_test import type_test_study
from railgrip.studies.type_test.entrants import entrants, entrants_named, train_of
from railgrip.studies.type_test.page import compare_controllers

OWN = """
name = "own"
[vehicle]
plant = "TwoPartTrainPneumatic"
[controller]
kind = "slip_three_state"
parameters = { low = "5 %", high = "8 %" }
[estimator]
kind = "none"
"""


def run(*arguments):
    with one_process():
        return exit_code("study", "type_test", *arguments)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A folder with one case, stopped by a built-in controller and by one of a scenario."""
    folder = tmp_path_factory.mktemp("type_test")
    (folder / "own.toml").write_text(OWN, encoding="utf-8")
    code = run(
        "--cases", "2", "--controller", "slip_three_state_searched", "--controller", str(folder / "own.toml"),
        "--out", str(folder / "out"),
    )  # fmt: skip
    assert code == 0
    return folder / "out"


def content_of(folder):
    return json.loads((folder / "type_test.json").read_text(encoding="utf-8"))


def test_the_result_has_cases_and_a_summary_of_each_controller(results):
    content = content_of(results)
    first = next(case for case in content["cases"] if case["controller"] == "own")
    assert list(first)[:9] == [
        "case", "controller", "tuned", "outcome", "distance_m", "bound_m", "longest_lock_s", "air_l", "strokes",
    ]  # fmt: skip
    assert {case["controller"] for case in content["cases"]} == {"ideal_bound", "slip_three_state_searched", "own"}
    assert first["outcome"] == "standstill"
    assert first["distance_m"] > first["bound_m"] > first["dry_m"]
    own = content["summary"]["own"]
    assert content["summary"]["slip_three_state_searched"]["median"] == 1.0
    ratios = [case["over_best"] for case in content["cases"] if case["controller"] == "own"]
    assert (own["median"], own["worst"]) == pytest.approx((min(ratios), max(ratios)))


def test_only_missing_stops_are_run(results, tmp_path):
    results = Path(shutil.copytree(results, tmp_path / "out"))
    before = {path: path.stat().st_mtime_ns for path in results.glob("*/stop.json")}
    assert len(before) == 8  # with both references
    assert run("--cases", "2", "--controller", "slip_two_state_searched", "--out", str(results)) == 0
    after = {path: path.stat().st_mtime_ns for path in results.glob("*/stop.json")}
    assert before.items() < after.items()
    assert len(after) == 10
    # Earlier entrants are still on the leaderboard, except for those that are not built-in.
    assert set(content_of(results)["summary"]) == {
        "ideal_bound",
        "slip_two_state_searched",
        "slip_three_state_searched",
    }


EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"


@pytest.mark.usefixtures("blank_figures")
def test_shipped_stops_are_judged_and_not_written_as_those_of_the_present_release(tmp_path, monkeypatch):
    (tmp_path / "docs").mkdir()
    page = tmp_path / "docs/type_test.md"
    shutil.copy(Path(__file__).parents[2] / "docs/type_test.md", page)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(type_test_study, "LIBRARY", tmp_path / "written")
    (tmp_path / "written").mkdir()
    assert run("--version", "2", "--cases", "24", "--shipped", "--write") == 0
    assert list((tmp_path / "written").iterdir()) == []
    assert "24 cases of the test set" in page.read_text(encoding="utf-8")


@pytest.mark.usefixtures("blank_figures")
def test_redistribution_shortens_a_service_brake_on_a_rail_cleaned_by_wheels(tmp_path, capsys):
    """At half of full brake adhesion is unused behind the first groups; the same cases with and without."""
    pair = ["slip_three_state", str(EXAMPLES / "slip_three_state_redistributed.toml")]
    named = [text for name in pair for text in ("--controller", name)]
    task = EXAMPLES / "service_brake.toml"
    arguments = ("--cases", "1", "--task", str(task), "--against", pair[0], "--out", str(tmp_path), *named)
    assert run(*arguments) == 0
    assert "Distance over that of slip_three_state, case by case" in capsys.readouterr().out
    folder = tmp_path / "service_brake"
    distances = {case["controller"]: case["distance_m"] for case in content_of(folder)["cases"]}
    rows = {
        row["controller"]: row
        for row in compare_controllers(pandas.DataFrame(content_of(folder)["cases"]), "slip_three_state").rows
    }
    other = "slip_three_state_redistributed"
    assert set(rows) == {"ideal_bound", other}
    assert rows[other]["mean"] == pytest.approx(distances[other] / distances["slip_three_state"])
    assert rows[other]["in the mean"] == pytest.approx(distances[other] - distances["slip_three_state"])
    assert rows["ideal_bound"]["shorter"] == 1
    assert distances[other] < 0.99 * distances["slip_three_state"]
    scenarios = [json.loads(path.read_text(encoding="utf-8"))["scenario"] for path in folder.glob("*/stop.json")]
    by_law = {one["controller"]["kind"]: one for one in scenarios}
    assert by_law["ideal_bound"].get("demand") is None
    assert by_law["slip_three_state"]["demand"]["phases"][0]["pressure"][0] == pytest.approx(1.9e5)
    assert all(
        by_law[law]["adhesion"]["conditioning"]["fraction"] == 0.12 for law in ("ideal_bound", "slip_three_state")
    )


def test_a_task_has_a_demand_or_states_how_wheels_clean(tmp_path, capsys):
    (tmp_path / "own.toml").write_text(OWN, encoding="utf-8")
    assert run("--task", str(tmp_path / "own.toml"), "--out", str(tmp_path)) == 2
    assert "own.toml: has neither [demand] nor [adhesion.conditioning]" in capsys.readouterr().err
    assert run("--against", "nobody", "--out", str(tmp_path / "results")) == 2
    assert "--against nobody: is not one of dry, ideal_bound" in capsys.readouterr().err


def test_a_wrong_name_is_refused_in_one_sentence(tmp_path, capsys):
    assert run("--controller", "nobody", "--out", str(tmp_path)) == 2
    assert "--controller nobody: is neither one of dry, ideal_bound" in capsys.readouterr().err
    assert run("--train", "nothing", "--controller", "full_brake", "--cases", "2", "--out", str(tmp_path)) == 2
    assert "--train nothing: is neither a scenario" in capsys.readouterr().err
    assert run("--case", "9", "--out", str(tmp_path)) == 2
    assert "there is no such case" in capsys.readouterr().err
    assert run("--controller", "mine:Law", "--out", str(tmp_path)) == 2
    assert "[controller] kind mine:Law: the module mine cannot be imported" in capsys.readouterr().err


def test_an_entrant_is_a_law_a_scenario_an_fmu_or_a_class(tmp_path):
    ours = entrants()
    (tmp_path / "own.toml").write_text(OWN.replace("[controller]", "[controlled]"), encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"own.toml: has no \[controller\]"):
        entrants_named([str(tmp_path / "own.toml")], ours)
    taking_part = entrants_named(["adhesion_based", str(tmp_path / "law.fmu"), "mine:Law"], ours)
    assert list(taking_part) == ["adhesion_based", "law", "Law"]
    (tmp_path / "other").mkdir()
    for name in ("dry.fmu", "other/law.fmu"):  # the baseline's own, and that of another entrant
        with pytest.raises(ScenarioError, match=r"would take part as '(dry|law)', as another controller does"):
            entrants_named([str(tmp_path / "law.fmu"), str(tmp_path / name)], ours)
    assert taking_part["law"].tables == {"controller": {"kind": "fmu", "file": str(tmp_path / "law.fmu")}}
    assert taking_part["Law"].tables == {"controller": {"kind": "mine:Law"}}


def test_a_train_comes_from_the_library_a_recipe_or_a_scenario(tmp_path):
    (tmp_path / "own.toml").write_text(OWN.replace("TwoPartTrainPneumatic", "x.fmu"), encoding="utf-8")
    assert train_of(None)["vehicle"]["plant"] == "TwoPartTrainPneumatic"
    assert train_of("TwoPartTrain")["vehicle"] == {"plant": "TwoPartTrain"}
    plant = train_of(str(tmp_path / "own.toml"))["vehicle"]["plant"]
    assert plant.folder / plant == tmp_path / "x.fmu"
