"""Figure 4 for all wheelsets, and distances with and without deflections of the primary suspension in the filter."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray
from printed_stops import FILTERS
from table1_stops import used_by_wheelset

from railgrip.api import Scenario
from railgrip.simulate.run import run_stop

PROJECT = Path(__file__).parents[2]


def test_used_adhesion_is_relative_to_the_peak_of_the_group():
    time = np.arange(0.0, 25.0)
    trace = xarray.Dataset(
        {
            "adhesion": (("time", "wheelset"), np.where(time < 9, 1.0, 0.5)[:, None] * [0.05, 0.10, 0.03]),
            "peak_adhesion": (("time", "group"), np.tile([0.20, 0.06], (25, 1))),
            "group_of_wheelset": ("wheelset", [1, 1, 2]),
        },
        coords={"time": time},
    )
    used = used_by_wheelset(SimpleNamespace(trace=trace), limit=0.10)
    # Group 1 uses the limit 0.10, group 2 its peak 0.06; adhesion halves at 9 s.
    assert np.allclose(used, [[0.5, 0.25, 0.25], [1.0, 0.5, 0.5], [0.5, 0.25, 0.25]])


@pytest.mark.parametrize(("name", "count"), list(zip(FILTERS, (12, 6, 6), strict=True)))
def test_each_filter_uses_its_readings_and_has_the_distance_of_the_page(name, count):
    """Readings are those of equation 6: speed, four wheelset speeds, acceleration, and six deflections if read."""
    stop = run_stop(Scenario.load("trapezoid", {"controller.kind": "slope_seeking", **FILTERS[name]}))
    assert stop.trace["estimate_readings"].values[1:].max() == count
    rows = pd.read_csv(PROJECT / "docs/studies/printed_law_filters.csv").set_index(["law", "filter", "scenario"])
    # The stop is smooth: repeats with perturbed plants change it by up to 0.02 m.
    assert stop.metrics.distance == pytest.approx(rows["distance"]["slope_seeking", name, "trapezoid"], abs=0.02)
