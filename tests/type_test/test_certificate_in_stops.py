"""The certificate of bounded slip in simulated stops of the type test."""

from dataclasses import replace

import pytest
from bounded_slip import count_of

from railgrip.simulate.run import run_stop
from railgrip.studies.type_test.entrants import campaign_of, entrants, train_of
from railgrip.studies.type_test.track_case import HEADLINES

CASE = replace(HEADLINES[0], name="steps", rail="steps", curve="dry", other="", scale=15.0, speed=12.0)


@pytest.mark.parametrize("law", ["adhesion_based", "slope_seeking"])
def test_no_released_wheelset_exceeds_its_bound(law):
    (stop,) = campaign_of([CASE], {law: entrants(2)[law]}, train_of(None)).stops
    count = count_of(run_stop(stop.scenario))
    assert count["exceeded"] == 0
    assert count["sliding"] >= count["inside"] >= count["released"] > 50
    assert count["slope visible"] >= count["slope significant"]
