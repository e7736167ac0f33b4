"""Controllers, estimators and variants are compared on the stops that all of them have, and on no others."""

import ast
import math
from pathlib import Path

import numpy as np
import pandas
import pytest
from test_distributions import frame, row

import railgrip.report
from railgrip.report.campaign_figures import sweep_figure
from railgrip.report.distances import headline
from railgrip.report.distribution import distributions_of
from railgrip.report.reference import references
from railgrip.report.statistics import on_common, rank
from railgrip.studies.estimators.tables import rank_estimators

# Of a hard and two easy cases the first entrant has all, the second one only the easy ones.
CASES = {"all": {"hard": 900.0, "easy": 100.0, "plain": 110.0}, "easy alone": {"easy": 101.0, "plain": 111.0}}


def table(cases=CASES):
    rows = [(name, case, value) for name, of in cases.items() for case, value in of.items()]
    return pandas.DataFrame(rows, columns=["entrant", "case", "value"])


def test_entrants_with_different_stops_are_refused_until_the_common_ones_are_selected():
    with pytest.raises(ValueError, match="have different cases"):
        rank(table(), "entrant", ["case"], "value")
    found = rank(on_common(table(), "entrant", ["case"], "value"), "entrant", ["case"], "value")
    assert list(found.index) == ["all", "easy alone"]
    assert found["cases"].tolist() == [2, 2]
    assert found["median"].tolist() == [105.0, 106.0]


@pytest.mark.parametrize("missing", [math.nan, None])
def test_a_missing_value_is_a_missing_stop(missing):
    gaps = table({"a": {"x": 1.0, "y": missing}, "b": {"x": 2.0, "y": 1.0}})
    assert set(on_common(gaps, "entrant", ["case"], "value")["case"]) == {"x"}
    with pytest.raises(ValueError, match="have different cases"):
        rank(gaps, "entrant", ["case"], "value")


def test_an_entrant_that_comes_to_a_standstill_less_often_is_not_ranked_above():
    found = rank(table({"a": {"x": 1.0, "y": 1.0, "z": math.inf}, "b": dict.fromkeys("xyz", 9.0)}), *RANKED)
    assert list(found.index) == ["b", "a"]
    assert found["failed"].tolist() == [0, 1]


RANKED = ("entrant", ["case"], "value")


def test_an_entrant_with_two_rows_of_a_case_is_refused():
    with pytest.raises(ValueError, match="two rows of the same case"):
        on_common(pandas.concat([table(), table()]), *RANKED)
    assert len(on_common(table({}), *RANKED)) == 0


def test_the_best_tuned_control_is_chosen_on_the_stops_that_all_tuned_controls_have():
    """The second law is better wherever both were run; the first one was not run on the long rail."""

    def scenario(rail, low):
        parameters = {"low": low, "high": 2 * low} if low else {}
        return {
            "rail": rail, "estimator": {"kind": "none"}, "actuation": {"kind": "ideal"}, "sensors": {"kind": "ideal"},
            "adhesion": {"polach": {"name": "dry"}}, "controller": {"kind": "slip_two_state", "parameters": parameters},
        }  # fmt: skip

    stops = [("short", 0.01, 101.0), ("short", 0.02, 100.0), ("long", 0.02, 900.0), ("short", 0, 120.0)]
    found = references(stops, lambda stop: scenario(*stop[:2]), lambda stop: stop[2])
    assert [tuned for _, tuned in found] == [stops[1], stops[1], stops[2], stops[1]]
    alone = [stops[0], stops[2]]
    assert references(alone, lambda stop: scenario(*stop[:2]), lambda stop: stop[2]) == [(None, None)] * 2


def test_distributions_have_the_draws_of_all_controllers():
    long = [row(draw, 100.0 + draw) for draw in range(5)]
    few = [row(draw, None if draw == 4 else 50.0, "slip_two_state", "published") for draw in (1, 2, 4)]
    abc, sbc = distributions_of(frame(*long, *few)).itertuples()
    assert list(abc.distances.index) == list(sbc.distances.index) == [1, 2, 4]
    assert (abc.median, sbc.stood, sbc.worst) == (102.0, 2, math.inf)


def test_laws_without_a_common_stop_are_not_ranked_in_the_headline():
    apart = frame(row(1, 90.0, stated_vs_sbc=-0.1), row(2, 80.0, "slope_seeking", stated_vs_sbc=-0.2))
    assert "adhesion_based, slope_seeking have no stop in common. 2 of 2 stops" in headline(apart)
    longer = [row(draw, 95.0, stated_vs_sbc=-0.05) for draw in (2, 3)]
    text = headline(pandas.concat([apart, frame(*longer)]))
    assert "slope_seeking changes the distance by −20.0 % in one stop, the largest reduction of the 2 of 2" in text
    assert "2 stops that not all of them have are not compared." in text


def test_the_median_of_a_sweep_is_over_the_same_combinations_everywhere():
    """Ten lines over eleven speeds, of which the shortest does not come to a standstill at one of them."""
    axes = {"law": ("a",), "start.speed": tuple(range(11)), "seed": tuple(range(10))}
    distances = np.stack([100.0 + 10 * np.arange(10) + speed for speed in range(11)])[None]
    distances[0, 5, 0] = math.nan
    (panel,) = sweep_figure(axes, distances).axes
    (median,) = [line for line in panel.lines if "median" in str(line.get_label())]
    assert "9 of 10" in median.get_label()
    assert median.get_ydata().tolist() == [150.0 + speed for speed in range(11)]


def estimates(name, errors):
    figures = ("bias", "delay", "step_delay", "microseconds")
    return [
        {"estimator": name, "case": case, "rmse.adhesion": error, "diverged": math.isnan(error)}
        | dict.fromkeys(figures, 0.0)
        for case, error in errors.items()
    ]


def test_an_estimator_that_diverges_where_it_is_hard_is_not_first():
    """Its other errors are smaller than those of the second; the third one has only the easy cases."""
    hard, easy = list("abc"), list("de")
    rows = [
        *estimates("fragile", dict.fromkeys(hard, math.nan) | dict.fromkeys(easy, 0.001)),
        *estimates("robust", dict.fromkeys([*hard, *easy], 0.01)),
    ]
    assert rank_estimators(pandas.DataFrame(rows))["estimator"].tolist() == ["robust", "fragile"]
    few = [*rows, *estimates("easy alone", dict.fromkeys(easy, 0.005))]
    board = rank_estimators(pandas.DataFrame(few))
    assert board[["estimator", "cases"]].values.tolist() == [["fragile", 2], ["easy alone", 2], ["robust", 2]]


PACKAGE = Path(railgrip.report.__file__).parents[1]
PAGES = Path(__file__).parents[2] / "docs" / "studies"
STATISTICS = {"median", "quantile", "nanmedian", "nanquantile", "idxmin", "nsmallest", "sort_values", "sorted", "min"}
ENTRANTS = {"controller", "controller_label", "estimator", "estimates", "law", "system", "filter", "variant"}
COMPLETE = {
    "overview_of": "sorts rows of a table, by the order of the campaign",
    "compare": "`zip` refuses laws whose stops are not those of the present estimates",
    "families": "sorts cases along an axis of friction",
    "compare_controllers": "pairs each controller with the same one, case by case",
    "losses_of": "compares two laws at a time, on the cases that both have",
    "verdict": "counts the cases of each family, and sorts families by name",
    "recommendation": "leaves out laws that lack a case of the rail",
    "lateral_runs": "every filter has every run, and a lost one an infinite error",
    "filter_consistency": "every filter has every stop",
    "adhesion_based": "takes medians over the repeats of one stop, and compares laws stop by stop",
    "certificate": "counts steps, and sorts them along an axis of the cases",
}
"""Function or page that orders entrants or takes quantiles over them without `on_common` or `rank` → why it may."""


def names_of_calls(node):
    return {
        one.func.attr if isinstance(one.func, ast.Attribute) else getattr(one.func, "id", "")
        for one in ast.walk(node)
        if isinstance(one, ast.Call)
    }


def compares_entrants(function):
    """Return whether a function groups by entrants and takes a median, a quantile or an order."""
    groups = (
        one
        for one in ast.walk(function)
        if isinstance(one, ast.Call) and names_of_calls(one) & {"groupby", "groups_of", "pivot", "pivot_table"}
    )
    constants = (each.value for one in groups for each in ast.walk(one) if isinstance(each, ast.Constant))
    return bool(names_of_calls(function) & STATISTICS) and any(value in ENTRANTS for value in constants)


def functions():
    """Yield path, name and tree of each function that may compare entrants, and of each page of a study as a whole."""
    for folder in ("report", "studies", "campaign", "cli", "estimation"):
        for path in sorted((PACKAGE / folder).rglob("*.py")):
            for one in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(one, ast.FunctionDef):
                    yield one.name, one
    for path in sorted(PAGES.glob("*.py")):
        yield path.stem, ast.parse(path.read_text(encoding="utf-8"))


def test_no_function_compares_entrants_without_selecting_common_stops():
    """A new one calls `on_common`, or `rank`, which refuses entrants with different stops."""
    found = [(name, one) for name, one in functions() if compares_entrants(one)]
    bare = {name for name, one in found if not names_of_calls(one) & {"on_common", "rank"}}
    assert len(found) > len(bare) > 0
    assert bare == set(COMPLETE)
