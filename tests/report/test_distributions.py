"""Many draws are summarised for each controller: the distribution, and the change of each draw relative to SBC."""

import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas
import pytest
from scipy import stats
from scipy.stats import norm

from railgrip.report.campaign_figures import distribution_figure, exceedance_figure
from railgrip.report.distances import documentation_tables, headline, write_table
from railgrip.report.distribution import compare_pairs, distribution_table, distributions_of, quantile_table
from railgrip.report.frame import StatedDistance, _reduction, frame_of
from railgrip.report.index import write_report
from railgrip.report.results import read_results
from railgrip.report.statistics import quantile_interval

CAMPAIGN = """
name = "drawn"
scenarios = ["{library}/random.toml"]
[draws]
first = 1
last = 4
[axes.controller]
sbc = {{ controller.kind = "slip_two_state" }}
low = {{ controller = {{ kind = "slip_two_state", parameters = {{ low = 0.01, high = "2 %" }} }} }}
mid = {{ controller = {{ kind = "slip_three_state", parameters = {{ low = 0.05 }} }} }}
abc = {{ controller.kind = "adhesion_based" }}
"""


def row(draw, distance, controller="adhesion_based", reference=None, **changes):
    values = {
        "label": "random", "scenario": "random", "case": "", "polach": "dry", "actuation": "ideal", "sensors": "ideal",
        "controller": controller, "controller_label": controller, "estimator": "none", "draw": draw,
        "reference": reference, "distance": math.nan if distance is None else distance, "longest_lock": 0.0,
        "flat_length": 0.0, "reduction_vs_sbc": math.nan, "stated_vs_sbc": math.nan, "stated_vs_tuned": math.nan,
        "stated": StatedDistance((math.inf if distance is None else distance,)), "breaks": [],
    }  # fmt: skip
    return values | changes


def frame(*rows):
    return pandas.DataFrame(rows).astype({"draw": object})


def stops(distances, others):
    return frame(
        *(row(draw, distance) for draw, distance in enumerate(distances)),
        *(row(draw, distance, "slip_two_state", "published") for draw, distance in enumerate(others)),
    )


def each(frame):
    """Return the rows of a frame."""
    return list(frame.itertuples())


def test_draws_are_compared_one_by_one():
    """Rails differ by far more than controllers: a change of 3 % on each of them is reported exactly."""
    rails = np.linspace(200, 500, 101)
    abc, sbc = each(distributions_of(stops(0.97 * rails, rails)))
    assert sbc.vs_sbc is None
    assert (sbc.median, sbc.worst, sbc.worst_draw) == (350, 500, 100)
    assert (sbc.low, sbc.high) == (pytest.approx(215), pytest.approx(485))  # the 6th and the 96th of 101
    assert abc.vs_sbc.change == pytest.approx(-0.03)
    assert abc.vs_sbc.change_interval == pytest.approx((-0.03, -0.03))
    assert abc.vs_sbc.shorter == 1
    # None of n is longer: the bound of Clopper and Pearson is (α/2)^(1/n).
    assert abc.vs_sbc.shorter_interval == pytest.approx((0.025 ** (1 / 101), 1))


def test_stops_without_standstill_count_in_the_headline_as_endless():
    """A law that stops in two of five cases, and shorter there, is not shorter in the median of the two."""
    distances = [90.0, 95.0, None, None, None]
    sbc = SimpleNamespace(braking_distance=100.0)
    reductions = [_reduction(distance, sbc, SimpleNamespace()) for distance in distances]
    assert reductions == pytest.approx([0.1, 0.05, -math.inf, -math.inf, -math.inf])
    assert math.isnan(_reduction(90.0, sbc, sbc))
    breaks = [[], [], *[["stops"]] * 3]
    rows = [
        row(draw, distance, stated_vs_sbc=-reduction, breaks=broken)
        for draw, (distance, reduction, broken) in enumerate(zip(distances, reductions, breaks, strict=True))
    ]
    text = headline(frame(*rows))
    assert "by endless in the median of 5 stops, from −10.0 % to endless" in text
    assert "adhesion_based did not come to a standstill in 3 of 5." in text


def test_the_headline_counts_the_stops_whose_reference_does_not_come_to_a_standstill():
    """Slip-based control slides through in one of three draws, and in the other two is 10 % longer."""
    rows = [row(draw, 90.0, stated_vs_sbc=share) for draw, share in enumerate((-0.1, -0.1, math.nan))]
    others = [row(draw, distance, "slip_two_state", "published") for draw, distance in enumerate((100, 100, None))]
    sentence = "no change, because slip-based control does not come to a standstill there. 5 of 6 stops come"
    text = headline(frame(*rows, *others))
    assert "in the median of 2 stops" in text
    assert f"1 stop has {sentence}" in text
    assert "no change" not in headline(frame(*rows[:2], *others[:2]))
    # Nor does a campaign without any comparison stay silent; one without slip-based control has none.
    alone = headline(frame(rows[2], others[2]))
    assert alone.startswith("1 stop has no change")
    assert headline(frame(rows[2])) == "1 of 1 stops come to a standstill."


@pytest.mark.parametrize("actuations", [("ideal",), ("ideal", "pneumatic")])
def test_a_table_for_the_documentation_names_the_settings_that_differ(actuations):
    drawn = pandas.concat([stops(np.ones(3), np.ones(3)).assign(actuation=name) for name in actuations])
    table = documentation_tables(drawn)["draws"]
    assert ("actuation" in table.columns) == (len(actuations) > 1)
    assert not {"sensors", "creep curve"} & set(table.columns)


def test_a_distance_that_depends_on_rounding_has_its_range_in_the_documentation():
    sbc, law = row(None, 400.0, "slip_two_state", "published"), row(None, 380.0)
    law |= {"stated_vs_sbc": -0.05, "stated": StatedDistance((377.96, 380.0, 391.0))}
    (cells,) = documentation_tables(frame(sbc, law))["distances"].rows
    assert (cells["slip_two_state"], cells["adhesion_based"]) == ("400.0 m", "380.0 m (378.0 – 391.0 m; −5.0 %)")


def test_the_interval_of_the_median_has_its_nominal_coverage():
    """In 400 samples of 20 draws from a skewed distribution, the interval misses the true median in up to 5 %."""
    rng = np.random.default_rng(1)
    misses, reference = 0, frame(*(row(n, 1.0) for n in range(20)))
    for _ in range(400):
        changes = rng.exponential(size=20)
        one_draw = compare_pairs(pandas.Series(1 + changes), reference)
        low, high = one_draw.change_interval
        misses += not low <= math.log(2) <= high
    assert misses <= stats.binom.ppf(0.999, 400, 0.05)
    assert misses > 0  # an interval that never misses would be too wide


def test_an_interval_of_a_quantile_may_end_in_infinite_distances():
    """Of 100 draws 7 of which do not stop, a resample has 5 % or fewer that do not with a probability of 29 %."""
    assert quantile_interval([1.0] * 93 + [math.inf] * 7, 0.95) == (1.0, math.inf)
    assert quantile_interval([math.inf] * 72, 0.95) == (math.inf, math.inf)


def test_a_draw_without_a_standstill_is_longer_than_any_other():
    distributions = distributions_of(stops([90, None, None, 90, 90], [100, 100, None, None, 100]))
    abc, _ = each(distributions)
    assert (abc.stood, abc.draws, abc.worst, abc.worst_draw) == (3, 5, math.inf, 1)
    assert abc.vs_sbc.changes == pytest.approx((-0.1, math.inf, 0.0, -1.0, -0.1))
    assert abc.vs_sbc.shorter == 0.6
    assert abc.vs_sbc.change_interval is None  # five draws have no interval of 95 %
    texts = distribution_table(distributions).texts
    assert texts[0]["worst (draw)"] == "no stop (1)"
    assert texts[0]["draws"] == "5, 2 without stop"


def test_controllers_are_compared_with_the_published_and_the_best_tuned_sbc(folder):
    """The synthetic three-state control stops shorter than the two-state one, whatever its thresholds."""
    distributions = {one.controller_label: one for one in each(distributions_of(frame_of(read_results(folder))))}
    published, low, mid = "SBC, two-state 10/15 %", "SBC, two-state 1/2 %", "SBC, three-state 5/15 %"
    assert set(distributions) == {published, low, mid, "peak seeking (railgrip)"}
    assert all(one.draws == one.stood == 4 for one in distributions.values())
    abc = distributions["peak seeking (railgrip)"]
    assert (abc.vs_sbc.label, abc.vs_tuned.label) == (published, mid)
    assert abc.vs_sbc.change == pytest.approx(0.8 / 0.95 - 1, abs=1e-3)
    assert abc.vs_tuned.change == pytest.approx(0.85 / 0.95 - 1, abs=1e-3)
    assert distributions[mid].vs_tuned is None
    assert distributions[low].vs_tuned.change == pytest.approx(0.85 / 0.8 - 1, abs=1e-3)


@pytest.fixture(scope="module")
def page(folder):
    """The page of the campaign, with those of its longest stops."""
    return write_report(folder, panels="none")


def test_the_figure_has_a_point_for_each_draw_and_a_panel_for_each_reference(folder):
    distributions = distributions_of(frame_of(read_results(folder)))
    panels = distribution_figure(distributions).axes
    assert [panel.get_xlabel() for panel in panels] == [
        "braking distance [m]", "change against the published SBC [%]", "change against the best tuned SBC [%]"
    ]  # fmt: skip
    points = [line for line in panels[0].lines if line.get_marker() == "."]
    assert [sorted(line.get_xdata()) for line in points] == [
        pytest.approx(sorted(one.distances)) for one in each(distributions)
    ]


def test_the_published_thresholds_are_those_of_the_law():
    """The name of a law with default parameters contains 10/15 %, and `vs SBC` refers to it."""
    from railgrip.controllers.laws.slip_two_state import SlipTwoState
    from railgrip.report.reference import PUBLISHED

    levels = SlipTwoState.load_tuning("ideal", "read", "paper")
    assert (levels.low, levels.high) == PUBLISHED


def test_a_table_of_many_missing_stops_names_a_few(folder):
    results = replace(read_results(folder), missing=tuple(f"stop{n}" for n in range(40)))
    text = write_table(results, folder)[1].read_text(encoding="utf-8")
    assert "Not run: stop0, stop1, stop2, stop3, stop4, stop5, stop6, stop7 and 32 more." in text


def test_quantiles_and_exceedance_of_many_draws_agree_with_their_distribution(folder):
    """Ten thousand draws of a known distribution: quantiles are within their intervals, and few points are drawn."""
    one = distributions_of(frame_of(read_results(folder))).head(1)
    draws = 300.0 + 20.0 * norm.ppf((np.arange(10_000) + 0.5) / 10_000)
    many = one.assign(draws=draws.size, stood=draws.size, distances=[pandas.Series(draws)])
    (row,) = quantile_table(many, 340.0).rows
    for share in (0.5, 0.95, 0.99):
        value, low, high = map(float, re.findall(r"\d+\.\d", row[f"P{100 * share:.0f}"]))
        exact = 300.0 + 20.0 * norm.ppf(share)
        assert value == pytest.approx(exact, abs=0.1)
        # Standard error of a quantile of n draws: sqrt(p(1-p)/n) over the density there; 1.96 of them to either side.
        reach = 1.96 * np.sqrt(share * (1 - share) / draws.size) / norm.pdf(norm.ppf(share)) * 20.0
        assert (exact - low, high - exact) == pytest.approx((reach, reach), abs=0.2 * reach + 0.1)
    assert float(row["over 340 m"].split(" ")[0]) == pytest.approx(100 * norm.sf(2.0), abs=0.01)
    counts, shares = exceedance_figure(many, 340.0).axes
    assert len(counts.lines[0].get_xdata()) <= 60
    assert np.interp(340.0, *shares.lines[0].get_data()) == pytest.approx(100 * norm.sf(2.0), rel=0.02)


def test_the_longest_of_all_draws_have_pages(folder, page):
    rows = [row for row in each(frame_of(read_results(folder))) if row.controller != "ideal_bound"]
    longest = sorted(rows, key=lambda row: -row.distance)[:10]
    text = page.read_text(encoding="utf-8")
    assert [row.stop for row in longest if f'href="{row.stop}/index.html"' not in text] == []
    assert all((folder / row.stop / "index.html").exists() for row in longest)
