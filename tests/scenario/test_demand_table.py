"""The table [demand]: its meaning in numbers, and its refusals."""

import tomllib
from functools import partial

import numpy as np
import pytest
import synthetic
from calls import calls_of
from synthetic import LAYOUT, LIBRARY

from railgrip.base.errors import ScenarioError
from railgrip.kernel import kernel
from railgrip.scenario.demand import Driver, phases_of
from railgrip.scenario.file import merge
from railgrip.scenario.load import scenario_of
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.signals import layout_of

FULL = (3.4e5, 3.0e5)
TWO_GROUPS = layout_of(Formation((1, 1)))
ENDS = kernel(TWO_GROUPS).functions


def scenario_with(demand, directory=LIBRARY):
    table = tomllib.loads((LIBRARY / "plain.toml").read_text(encoding="utf-8"))
    return scenario_of(merge(table, {"demand": demand}), directory=directory, origin="mine.toml")


def phases(demand, directory=LIBRARY):
    return phases_of(TWO_GROUPS, scenario_with(demand, directory).demand, FULL)


def test_one_pressure_applies_to_all_groups_and_full_is_that_of_each():
    one, each, full = phases(
        {
            "phases": [
                {"pressure": "1.5 bar", "until": {"time": "2 s"}},
                {"pressure": ["0.5 bar", "full"], "until": {"speed_below": "36 km/h"}},
                {"pressure": "full"},
            ]
        }
    )
    assert (*one["pressure"], one["until"], one["end"]) == (1.5e5, 1.5e5, ENDS.AT_TIME, 2.0)
    assert (*each["pressure"], each["until"], each["end"]) == (0.5e5, 3.0e5, ENDS.AT_SPEED_BELOW, 10.0)
    assert (*full["pressure"], full["until"]) == (*FULL, ENDS.AT_END)


def test_a_profile_is_linear_between_its_points(tmp_path):
    (tmp_path / "brake.csv").write_text("time,pressure_1,pressure_2\n1,0,0\n3,1e5,2e5\n4,1e5,0\n")
    before, rise, fall, after = phases({"file": "brake.csv"}, tmp_path)
    assert (before["end"], before["pressure"].tolist()) == (1.0, [0.0, 0.0])
    assert (rise["begin"], rise["end"], rise["pressure"].tolist()) == (1.0, 3.0, [0.0, 0.0])
    assert rise["slope"].tolist() == [0.5e5, 1e5]
    assert fall["slope"].tolist() == [0.0, -2e5]
    assert (after["until"], after["pressure"].tolist()) == (ENDS.AT_END, [1e5, 0.0])
    # Everything else is as in a phase given by keys.
    (written,) = phases({"phases": [{"pressure": 0}]})
    for name in ("force", "power", "rate"):
        assert set(phases({"file": "brake.csv"}, tmp_path)[name]) == {written[name]}


def test_a_long_profile_needs_few_calls_per_row(tmp_path):
    """A million rows take some ten seconds with few calls per row."""

    for rows in (3, 1000, 3000):
        lines = "".join(f"{number},{1e5 * (number % 3)}\n" for number in range(rows))
        (tmp_path / f"{rows}.csv").write_text(f"time,pressure\n{lines}", encoding="utf-8")

    def read(rows):
        demand = scenario_with({"file": f"{rows}.csv"}, tmp_path).demand
        drawn = phases_of(LAYOUT, demand, synthetic.FULL.tolist())
        Driver(LAYOUT, 1e-3, full=synthetic.FULL, release_pressure=np.zeros(4), phases=drawn)

    read(3)  # import everything that is imported once
    short, long = (calls_of(partial(read, rows)) for rows in (1000, 3000))
    assert long - short < 10 * 2000  # reading a row of two cells takes five; a quadratic algorithm would take thousands


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("time,pressure\n0,0\n1,-1\n", r"line 3: pressure must be at least 0 and at most 1e\+08 Pa; a column in anoth"),
        ("distance,pressure\n0,0\n1,1\n", r"first line must name time \[s\], and pressure"),
    ],
)
def test_a_bad_profile_is_refused_in_a_sentence(content, words, tmp_path):
    (tmp_path / "brake.csv").write_text(content)
    with pytest.raises(ScenarioError, match=rf"^mine\.toml: \[demand.*{words}"):
        scenario_with({"file": "brake.csv"}, tmp_path)
