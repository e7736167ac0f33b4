"""The cases of version 2, the sealed set of a controller, the number of looks, and results by family."""

from collections import Counter
from dataclasses import replace
from types import SimpleNamespace

import pytest
from rows import row_of

from railgrip.api import Scenario
from railgrip.base.errors import ScenarioError
from railgrip.report.limits import limits_of
from railgrip.studies.study import conduct
from railgrip.studies.type_test import type_test_study as study
from railgrip.studies.type_test.case_set import SEALED, VERSIONS, CaseSet, case_named, count_look
from railgrip.studies.type_test.entrants import (
    Entrant,
    campaign_of,
    controller_digest,
    entrants,
    train_of,
    training,
    training_cases,
)
from railgrip.studies.type_test.family import FEWEST, families, losses
from railgrip.studies.type_test.stop_frames import digest_of, frame_of_rows, judgements, read_shipped, summaries
from railgrip.studies.type_test.track_case import (
    CLEANING,
    FASTEST,
    FRACTION,
    LOAD,
    PASSED_RAILS,
    RADIUS,
    RAILS,
    TRAINS,
)
from railgrip.studies.type_test.type_test_study import TypeTest

SECOND = VERSIONS[2]
CASES = SECOND.draw(SECOND.count, SECOND.test)


def test_the_first_version_keeps_its_cases_its_digest_and_its_entrants():
    first = CaseSet(version=1, count=24, seed=15595)
    assert first.label == "version 1, test, 24 cases"
    header = "a1076805311cab05547c60fe47099991cce78229f1878ad433859c86c2de0736"
    assert digest_of(first.cases(), train_of(None)) == header
    assert entrants(2).keys() - entrants(1).keys() == {
        "perturb_observe", "recursive_slope", "fuzzy_slip", "slip_three_state_deep", "two_maxima",
    }  # fmt: skip


def test_a_full_set_has_more_than_400_cases_and_every_value_at_its_share():
    assert len(CASES) >= 400
    rails = Counter(case.rail for case in CASES)
    assert {rail: round(count * len(RAILS) / len(CASES)) for rail, count in rails.items()} == Counter(RAILS)
    trains = Counter(case.train for case in CASES)
    assert {train: round(count * len(TRAINS) / len(CASES)) for train, count in trains.items()} == Counter(TRAINS)
    assert sum(case.over == "distance" for case in CASES) > 0.7 * len(CASES)
    assert sum(case.over == "time" for case in CASES) < 0.2 * len(CASES)
    assert {len(case.faults) for case in CASES} == {0, 1, 2}
    assert {case.cleaning for case in CASES} >= CLEANING.keys()
    assert 0.3 < sum(bool(case.other) for case in CASES) / len(CASES) < 0.6


def test_values_are_within_their_ranges():
    for case in CASES:
        assert abs(case.load - 1) <= LOAD
        assert 0 <= case.radius <= RADIUS
        assert case.speed <= FASTEST.get(case.train, 200 / 3.6) + 0.01
        assert case.speed * case.horizon < 20e3  # m, the longest tabulated rail


def test_a_pair_of_faults_affects_two_parts_of_the_train():
    pairs = [case for case in CASES if len(case.faults) == 2]
    assert pairs
    for case in pairs:
        rows = case.fault_tables(4)["faults"]
        assert rows[0]["part"] != rows[1]["part"]
        assert all(1 <= row.get("group", 1) <= 4 for row in rows)


def test_a_blend_is_between_its_two_curves():
    case = next(case for case in CASES if {case.curve, case.other} == {"dry", "leaf"})
    polach = case.tables(4)["adhesion"]["polach"]
    assert 0.04 < polach["k_A"] < 1.0
    assert 0.4 < polach["A"] < 0.5


def test_rails_of_passing_wheels_follow_the_other_cases_and_change_none():
    design = SECOND.design(SECOND.count, SECOND.test)
    assert design[: SECOND.count] == CASES
    passed = [case for case in design if CaseSet.of(case.name).part == "p"]
    assert len(passed) == SECOND.count // 6
    assert Counter(case.passage for case in passed) == dict.fromkeys(("by group", "by wheelset"), len(passed) // 2)
    rails = Counter(case.rail for case in passed)
    assert {rail: round(count * len(PASSED_RAILS) / len(passed)) for rail, count in rails.items()} == Counter(
        PASSED_RAILS
    )
    assert {case.cleaning for case in passed} >= CLEANING.keys()
    for case in passed:
        assert FRACTION[0] <= case.fraction <= FRACTION[1]
        assert case.recovered > case.friction
        table = case.tables(4)["adhesion"]["conditioning"]
        assert table == {"fraction": case.fraction, "recovered": case.recovered, "by": case.passage.split()[1]}


def test_the_test_set_has_the_rails_of_table_1_as_the_papers_have_them():
    published = [case for case in SECOND.design(SECOND.small, SECOND.test) if CaseSet.of(case.name).part == "t"]
    assert [case.scenario for case in published] == ["trapezoid", "sine_sweep", "random"]
    stops = campaign_of(published, {"fuzzy_slip": entrants(2)["fuzzy_slip"]}, train_of(None)).stops
    for case, stop in zip(published, stops, strict=True):
        assert stop.scenario.adhesion == Scenario.load(case.scenario).adhesion
        assert stop.scenario.start.speed == pytest.approx(80 / 3.6)
    assert not [case for case in SECOND.design(48, SECOND.training) if "v2t" in case.name]


def test_radii_and_pads_differ_by_group_and_do_not_depend_on_the_number_of_groups():
    case = max(CASES, key=lambda case: case.radius)
    two, four = (case.tables(groups)["truth"] for groups in (2, 4))
    assert len(set(four["wheel_radius"])) == 4
    assert four["wheel_radius"][:2] == two["wheel_radius"]
    assert len(set(four["pad_friction"])) == 4


def test_sets_share_no_case():
    """All have rails of passing wheels; the last one is a sealed set."""
    sets = [
        {replace(case, name="") for case in SECOND.design(96, seed)[:112]}
        for seed in (SECOND.test, SECOND.validation, SECOND.training, 10**9)
    ]
    assert sum(map(len, sets)) == len(set.union(*sets)) == 4 * 112
    assert all(sum(bool(case.fraction) for case in each) == 16 for each in sets)


def test_every_case_is_a_scenario_of_its_train():
    """Only rails that slip does not clean have a pointwise bound."""
    design = CASES[:48]
    trains = {name: train_of(name) for name in FASTEST}
    taking_part = {name: entrants(2)[name] for name in ("dry", "ideal_bound", "fuzzy_slip")}
    stops = campaign_of(design, taking_part, train_of(None), trains=trains).stops
    names = {stop.name for stop in stops}
    for case in design:
        assert f"{case.name}-fuzzy_slip" in names
        assert (f"{case.name}-ideal_bound" in names) == (case.cleaning == "none" and case.mechanics == "simple")
    case = next(case for case in design if case.train == "vt642")
    stop = next(stop for stop in stops if stop.name == f"{case.name}-fuzzy_slip")
    assert stop.scenario.resolved()["vehicle"]["train"] == "vt642"


def test_a_case_is_found_by_its_name_but_not_in_a_sealed_set():
    assert case_named(CASES[6].name) == CASES[6]
    sealed = CaseSet.sealed(2, "0123456789abcdef")
    assert (sealed.kind, sealed.count) == ("sealed", SEALED)
    with pytest.raises(ScenarioError, match="cases of a sealed set are run together"):
        case_named(sealed.cases()[0].name)
    assert CaseSet.sealed(2, "1123456789abcdef") != sealed


def test_a_digest_depends_on_source_and_parameters_but_not_on_comments(tmp_path):
    source = '"""Law."""\n\n\nclass Own:\n    """Law."""\n\n    gain = 1.0\n'
    (tmp_path / "mine.py").write_text(source, encoding="utf-8")
    entrant = Entrant.model_validate({"description": "", "role": "entrant", "controller": {"kind": "mine:Own"}})
    first = controller_digest(entrant, [tmp_path])
    (tmp_path / "mine.py").write_text(source.replace("Law.", "Other words.") + "# comment\n", encoding="utf-8")
    assert controller_digest(entrant, [tmp_path]) == first
    (tmp_path / "mine.py").write_text(source.replace("1.0", "1.1"), encoding="utf-8")
    assert controller_digest(entrant, [tmp_path]) != first
    ours = entrants(2)
    assert len({controller_digest(ours[name]) for name in ours}) == len(ours)
    with pytest.raises(ScenarioError, match="there is no module nowhere"):
        controller_digest(Entrant.model_validate({**entrant.model_dump(), "controller": {"kind": "nowhere:Own"}}))


def test_looks_are_counted_by_set_and_controller(tmp_path, monkeypatch):
    monkeypatch.setenv("RAILGRIP_CACHE", str(tmp_path))
    count_look("one", ["a", "b"])
    count_look("one", ["a"])
    assert count_look("other", ["a"]) == {"one": {"a": 2, "b": 1}, "other": {"a": 1}}


@pytest.mark.usefixtures("in_process")
def test_a_sealed_set_is_run_with_the_baselines_and_reveals_no_single_case(tmp_path, monkeypatch):
    few = {name: entrants(2)[name] for name in ("dry", "slip_two_state", "fuzzy_slip")}
    counted = SimpleNamespace(folder=lambda: tmp_path / "cache")  # FMUs and filters are those of the other tests
    monkeypatch.setattr("railgrip.studies.type_test.case_set.cache", counted)
    monkeypatch.setattr(study, "entrants", lambda version=1: few)
    test = TypeTest(version=2, sealed=True, controller=["fuzzy_slip"], cases=1)
    page, path = conduct(test, tmp_path / "out", workers=1)
    assert path == tmp_path / "out" / "version_2" / "index.html"
    assert {row["controller"] for row in page.values["board"].rows} == {"slip_two_state", "fuzzy_slip"}
    assert page.values["rankings"] == {}
    assert "cases.csv" not in page.tables
    assert "cases" not in page.data["type_test.json"]
    assert page.values["looks"].rows[0]["set"] == "version 2, sealed, 1 cases"


@pytest.fixture(scope="module")
def stops():
    """Fuzzy rules stop a tenth longer than deep three-state control where slip cleans, elsewhere a tenth shorter."""
    found = []
    for case in CASES[:60]:
        found.append(row_of(case, "slip_three_state_deep", 100.0))
        found.append(row_of(case, "slip_two_state", 50.0, longest_lock_s=2.0))
        found.append(row_of(case, "fuzzy_slip", 90.0 if case.cleaning == "none" else 110.0))
    return frame_of_rows(found)


def test_the_best_baseline_may_be_untuned_but_satisfies_the_lock_clause(stops):
    taking_part = entrants(2)
    assert set(judgements(stops, taking_part, limits_of(), only_tuned=False)["best_m"]) == {90.0, 100.0}
    assert set(judgements(stops, taking_part, limits_of())["best_m"]) == {90.0, 110.0}


def test_a_law_loses_in_the_family_with_its_largest_median(stops):
    taking_part = entrants(2)
    judged = judgements(stops, taking_part, limits_of(), only_tuned=False)
    frame = families(judged)
    rows = list(frame.itertuples())
    cleaned = next(row for row in rows if (row.value, row.controller) == ("strong", "fuzzy_slip"))
    assert cleaned.compared >= FEWEST
    assert cleaned.median == pytest.approx(1.1)
    assert cleaned.lost == 1.0
    table = losses(frame, summaries(judged, taking_part))
    where = {row["controller"]: row["loses where"] for row in table.rows}
    always = {f"{row.axis}: {row.value}" for row in rows if row.controller == "fuzzy_slip" and row.lost == 1.0}
    assert {"cleaning: strong", "cleaning: weak"} <= always
    assert where["fuzzy_slip"] in always


def test_training_cases_have_their_trains():
    planned = training(8, version=2)
    trains = [case.train for case in training_cases(8, version=2)]
    assert "vt642" in trains
    assert [stop.scenario.resolved()["vehicle"].get("train", "") for stop in planned] == trains


def test_shipped_results_have_all_controllers_or_a_hint_how_to_renew_them():
    design = CaseSet(version=2, count=SECOND.small, seed=SECOND.test).cases()
    found, (sentence,) = read_shipped(design, train_of(None))
    if found.empty:
        assert "`railgrip study type_test --write` writes" in sentence or "No results" in sentence
        return
    expected = {(case.name, name) for case in design for name in entrants(2)}
    missing = expected - set(zip(found["case"], found["controller"], strict=True))
    assert {name for _, name in missing} <= {"ideal_bound", "ideal_tracking"}


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"cases": 8, "case": ["01of24-15595"]}, "--case and --cases: "),
        ({"sealed": True, "validation": True, "controller": ["a"]}, "--sealed and --validation: "),
        *(({"sealed": True, **more}, "--sealed is for one --controller") for more in ({}, {"controller": ["a", "b"]})),
        ({"shipped": True, "train": "tram"}, "--shipped is for sets of cases of the package"),
    ],
)
def test_options_that_exclude_each_other_are_refused(options, words):
    with pytest.raises(ScenarioError, match=words):
        TypeTest(**options)._require_consistent()
