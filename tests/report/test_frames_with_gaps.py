"""Missing, infinite and large numbers keep their meaning in frames, intervals, JSON and pages."""

import json
import math
from pathlib import Path

import numpy as np
import pandas
import pytest
from legible import needs_browser, title_of
from scipy import stats
from test_distributions import frame, row

import railgrip.report.table
from railgrip.report.distances import write_table
from railgrip.report.distribution import distributions_of, plain_distributions
from railgrip.report.frame import frame_of, groups_of, plain_rows
from railgrip.report.results import read_results
from railgrip.report.statistics import FEWEST_DRAWS, bootstrap_interval, draws_for_interval, quantile_interval
from railgrip.report.table import ReportTable

CAMPAIGN = """
name = "mixed"
scenarios = ["{library}/random.toml", "{library}/trapezoid.toml"]
[draws]
first = 9007199254740993
last = 9007199254740994
[axes.controller]
sbc = {{ controller.kind = "slip_two_state" }}
abc = {{ controller.kind = "adhesion_based" }}
"""


def test_seeds_beyond_the_integers_of_a_float_stay_exact(folder):
    """2^53 + 1 is not a float; in a column of numbers with a missing one it would become 2^53."""
    seeds = {9007199254740993, 9007199254740994}
    found = frame_of(read_results(folder))
    assert set(found["draw"].dropna()) >= seeds
    content = json.loads(write_table(read_results(folder), folder)[0].read_text(encoding="utf-8"))
    assert {each["draw"] for each in content["rows"]} - {None} == set(found["draw"].dropna()) >= seeds
    assert {int(draw) for each in content["distributions"] for draw in each["distances_m"]} >= seeds


def test_rows_with_a_missing_key_are_a_group():
    """By default, pandas drops them."""
    gaps = pandas.DataFrame({"axis": ["a", None, "a", None], "value": [1.0, 2.0, 3.0, 4.0]})
    sums = [float(of["value"].sum()) for _, of in groups_of(gaps, ("axis",))]
    assert sums == [4.0, 6.0]
    assert list(groups_of(gaps.head(0), ("axis",))) == []


def test_json_has_null_for_a_draw_without_standstill():
    def refuse(name):
        raise AssertionError(f"{name} is not JSON")

    stops = frame(row(1, None), row(2, 90.0)).assign(**dict.fromkeys(("air_used", "actuations"), math.nan))
    (one,) = plain_distributions(distributions_of(stops))
    assert math.isinf(one["distances_m"][1])
    first, second = json.loads(json.dumps(plain_rows(stops), allow_nan=False), parse_constant=refuse)
    assert first["distance_m"] is first["air_l"] is first["valve_strokes"] is None
    assert second["distance_m"] == 90.0


def test_a_bootstrap_interval_is_that_of_scipy_up_to_its_draws():
    """Both draw 2000 times; ends of a mean of 200 differ by a few hundredths of its standard deviation."""
    values = np.random.default_rng(3).exponential(size=200)
    own = bootstrap_interval(values, lambda draws: draws.mean(axis=-1))
    other = stats.bootstrap((values,), np.mean, method="percentile", n_resamples=2000, rng=1).confidence_interval
    assert own == pytest.approx((other.low, other.high), abs=0.2 * values.std() / math.sqrt(200))


def mean_of(draws):
    return draws.mean(axis=-1)


def test_a_bootstrap_interval_of_equal_values_has_no_width():
    assert bootstrap_interval([0.95] * 20, mean_of) == pytest.approx((0.95, 0.95), abs=1e-12)


@pytest.mark.parametrize(("share", "count"), [(0.5, 20), (0.9, 36), (0.95, 72), (0.1, 36)])
def test_too_few_cases_have_no_interval(share, count):
    """0.95^72 is 2.5 %: with fewer draws the largest is below the quantile more often than the interval may miss it."""
    assert draws_for_interval(share) == count
    assert quantile_interval([1.0] * (count - 1), share) is None
    assert quantile_interval([1.0] * count, share) == (1.0, 1.0)
    assert bootstrap_interval([1.0] * (FEWEST_DRAWS - 1), mean_of) is None


@pytest.mark.parametrize(("count", "low", "high"), [(4, 0.70, 0.87), (FEWEST_DRAWS, 0.88, 0.96)])
def test_a_bootstrap_interval_covers_nearly_its_share_from_the_minimum_number_of_draws_on(count, low, high):
    """In 300 samples of a normal distribution: of 4 draws the interval of the mean covers 79 %, of 20 91 %."""
    samples = np.random.default_rng(1).standard_normal((300, count))
    ends = np.array([bootstrap_interval(sample, mean_of, fewest=2) for sample in samples])
    assert low < np.mean((ends[:, 0] < 0.0) & (ends[:, 1] > 0.0)) < high


def test_a_missing_case_is_refused_and_an_infinite_one_only_where_it_is_averaged():
    for value in (math.nan, math.inf):
        with pytest.raises(ValueError, match="leave out the cases without one"):
            bootstrap_interval([1.0, value, 2.0], lambda draws: draws.mean(axis=-1))
    with pytest.raises(ValueError, match="leave out the cases without one"):
        quantile_interval([1.0, math.nan], 0.5)
    assert quantile_interval([1.0] * 10 + [math.inf] * 12, 0.5) == (1.0, math.inf)


def test_a_cell_without_a_number_has_none_to_sort_by():
    """A comparison with NaN is false, and would leave other rows in a wrong order."""
    gaps = pandas.DataFrame({"score": [5.0, math.nan, 1.0]})
    for table in (ReportTable.of_frame(gaps), ReportTable(gaps.to_dict("records"))):
        html = table.__html__()
        assert html.count("data-value") == 2
        assert "nan" not in html


@needs_browser
def test_cells_without_a_number_follow_the_others_in_both_orders(tmp_path):
    """Negative numbers, a text in place of a number, and two empty cells, which counted as 0 between the numbers."""
    cells = [5.0, math.nan, -1.0, "none: horizon", 3.0, math.nan]
    rows = [{"stop": f"stop {number}", "change": cell} for number, cell in enumerate(cells)]
    table = ReportTable(rows, {"change": "{:+.0f}"}).__html__()
    code = (Path(railgrip.report.table.__file__).parent / "page.js").read_text(encoding="utf-8")
    clicks = """
      const number = (row) => row.cells[0].textContent.slice(5);
      const order = () => [...document.querySelectorAll("tbody tr")].map(number).join("");
      const head = document.querySelectorAll("th")[1], found = [];
      for (let n = 0; n < 2; n++) { head.click(); found.push(order()); }
      document.title = found.join(" ");
    """
    page = tmp_path / "page.html"
    page.write_text(f"<body>{table}<script>{code}</script><script>{clicks}</script></body>", encoding="utf-8")
    assert title_of(page, tmp_path) == "240315 304215"
