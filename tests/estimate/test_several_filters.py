"""Several filters on one recording."""

import numpy as np
import pytest

import railgrip as rg
from railgrip.base.errors import EstimationError


@pytest.fixture(scope="module")
def recording():
    scenario = rg.Scenario.load("trapezoid", {"start.speed": "20 km/h", "estimator": {"kind": "none"},
                                              "controller": {"kind": "full_brake"}})  # fmt: skip
    return rg.run(scenario).trace.isel(time=slice(0, 40))


def test_filters_are_compared_and_the_first_is_the_usual_one(recording):
    alone = rg.estimate(recording)
    several = rg.estimate(recording, filters=["fmu", "unscented"])
    assert list(several["filter"].values) == ["fmu", "unscented"]
    first = several.sel(filter="fmu")
    np.testing.assert_allclose(first["mean"].values, alone["mean"].values, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(first["sd"].values, alone["sd"].values, rtol=1e-9, atol=1e-12)
    assert several.attrs["parameters"] == alone.attrs["parameters"]
    deviation = several.sel(filter="unscented")["sd"]
    assert float(np.abs(several["mean"].diff("filter") / deviation).max()) < 1.0
    assert "filter" in repr(several)


def test_an_unknown_filter_is_refused_with_the_nearest_name(recording):
    with pytest.raises(EstimationError, match="did you mean 'unscented'"):
        rg.estimate(recording, filters=["unscentd"])
