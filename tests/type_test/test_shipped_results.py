"""Results of built-in controllers in the package are listed with those of a user's controller."""

import math
from pathlib import Path

import pandas
import pytest

from railgrip.report.limits import limits_of
from railgrip.simulate.run import run_stop
from railgrip.studies.type_test import design
from railgrip.studies.type_test.case_set import case_named
from railgrip.studies.type_test.design import CASES, SMALL, cases
from railgrip.studies.type_test.entrants import LIBRARY, Entrant, campaign_of, entrants, train_of
from railgrip.studies.type_test.page import page_of
from railgrip.studies.type_test.stop_frames import judgements, read_shipped, write_shipped

TRAIN = train_of(None)
DOCUMENTATION = Path(__file__).parents[2] / "docs/type_test.md"
OWN = "own"


@pytest.fixture(scope="module")
def stops():
    return read_shipped(cases(SMALL), TRAIN)[0]


@pytest.fixture(scope="module")
def page(stops):
    """Page of a controller that stops a tenth longer than three-state control, with the results of the package."""
    longer = stops[(stops["controller"] == "slip_three_state") & stops["distance_m"].notna()]
    longer = longer.assign(controller=OWN, distance_m=1.1 * longer["distance_m"])
    found = pandas.concat([stops[stops["controller"].isin(["dry", "ideal_bound"])], longer])
    own = {OWN: Entrant(description="a controller of a user", role="entrant")}
    again = dict.fromkeys((*entrants(), OWN), "railgrip study type_test --case")
    return page_of(found, entrants() | own, limits_of(), packaged=stops, candidates=[OWN], again=again)


def test_each_case_has_a_stop_of_each_controller_in_the_package(stops):
    names = set(zip(stops["case"], stops["controller"], strict=True))
    assert names == {(case.name, controller) for case in cases(SMALL) for controller in entrants()}
    assert len(names) == len(stops)


def test_a_single_case_has_its_stops_in_the_package():
    stops, sentences = read_shipped([case_named("03of24-15595")], TRAIN)
    assert set(stops["case"]) == {"03of24-15595"}
    assert len(stops) == len(entrants())
    assert len(sentences) == 1


@pytest.mark.parametrize("controller", ["ideal_bound", "slip_three_state_searched", "slope_seeking"])
def test_a_new_run_has_the_distance_in_the_package(stops, controller):
    """Stops that differ by less than two thousandths are equal, as in the comparison of two controllers."""
    case = case_named("03of24-15595")
    (planned,) = campaign_of([case], {controller: entrants()[controller]}, TRAIN).stops
    (expected,) = stops[(stops["case"] == case.name) & (stops["controller"] == controller)].itertuples()
    assert run_stop(planned.scenario).metrics.distance == pytest.approx(expected.distance_m, rel=2e-3)


def test_results_of_other_cases_or_another_train_are_refused(monkeypatch, stops):
    refused = "results_24_15595.csv are not shown: they are of other cases or of another train"
    other = TRAIN | {"periods": {"controller": "10 ms"}}
    assert read_shipped(cases(SMALL), other)[0].empty
    assert refused in read_shipped(cases(SMALL), other)[1][0]
    monkeypatch.setattr(design, "PADS", {**design.PADS, "weak": 0.84})
    found, (sentence,) = read_shipped(cases(SMALL), TRAIN)
    assert found.empty
    assert refused in sentence
    monkeypatch.undo()
    assert read_shipped(cases(SMALL), TRAIN)[0].equals(stops)


def test_cases_without_a_file_are_reported_in_a_sentence():
    found, sentences = read_shipped(cases(CASES), TRAIN)
    assert found.empty
    assert sentences == ["No results of railgrip's controllers come with these 240 cases; they come with --cases 24."]


def test_written_results_read_back(tmp_path, stops):
    write_shipped(stops, cases(SMALL), TRAIN, tmp_path)
    read, (sentence,) = read_shipped(cases(SMALL), TRAIN, tmp_path)
    assert read.equals(stops)
    (file,) = tmp_path.iterdir()
    packaged = (LIBRARY / file.name).read_text(encoding="utf-8").splitlines()
    assert file.read_text(encoding="utf-8").splitlines()[1:] == packaged[1:]
    assert "are of railgrip" in sentence


def test_results_of_a_version_without_the_adhesion_at_the_first_slide_are_read(tmp_path, stops):
    older = stops.assign(adhesion_at_slide=math.nan)
    (path,) = write_shipped(older, cases(SMALL), TRAIN, tmp_path)
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[1].endswith(",adhesion_at_slide")
    path.write_text("\n".join([lines[0], *(line.rpartition(",")[0] for line in lines[1:])]) + "\n", encoding="utf-8")
    assert read_shipped(cases(SMALL), TRAIN, tmp_path)[0].equals(older)
    judged = judgements(older, entrants(), limits_of())
    assert {verdicts["extension"] for verdicts in judged["verdicts"]} == {None}


def test_one_controller_is_listed_among_those_of_the_package(page):
    board = {row["controller"]: row for row in page.values["board"].rows}
    assert board.keys() == entrants().keys() - {"dry"} | {OWN}
    assert board[OWN]["over bound"] == pytest.approx(1.1 * board["slip_three_state"]["over bound"])
    assert [row["controller"] for row in page.values["clauses"].rows] == list(board)
    assert {row["controller"]: row["results"] for row in page.values["controllers"].rows} == {
        name: "run here" if name in (OWN, "ideal_bound") else "shipped" for name in board
    }
    assert page.answer.startswith("own (a controller of a user) is number 12 of 13 controllers in 24 cases")
    assert [summary.controller for summary, _ in page.values["worst"]] == [OWN]


def test_the_documentation_has_the_leaderboard_of_the_stops_in_the_package(stops):
    again = dict.fromkeys(entrants(), "")
    table = page_of(stops, entrants(), limits_of(), again=again).screen[0]
    assert str(table) in DOCUMENTATION.read_text(encoding="utf-8")
