"""The certificate of bounded slip in simulated stops of the type test."""

from dataclasses import replace

import pytest

from railgrip.simulate.run import run_stop
from railgrip.studies.certificate import LAWS, count_of, table_of
from railgrip.studies.type_test.entrants import campaign_of, entrants, train_of
from railgrip.studies.type_test.track_case import HEADLINES

CASES = [replace(HEADLINES[0], name="steps", rail="steps", curve="dry", other="", scale=15.0, speed=12.0)]


@pytest.fixture(scope="module")
def stops():
    return campaign_of(CASES, {law: entrants(2)[law] for law in LAWS}, train_of(None)).stops


def test_no_released_wheelset_exceeds_its_bound(stops):
    counts = [count_of(run_stop(stop.scenario)) for stop in stops]
    for count in counts:
        assert count["exceeded"] == 0
        assert count["sliding"] >= count["inside"] >= count["released"] > 50
        assert count["slope visible"] >= count["slope significant"]
    table = table_of(stops, counts)
    assert table.rows[0]["family"] == "all cases"
    assert table.rows[0]["cases"] == len(CASES)
    assert {row["family"] for row in table.rows} >= {"rail: steps", "mechanics: simple"}
