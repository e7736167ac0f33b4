"""Every curve and limit of eight trains on three gradients, as computed by independent programs.

`evc.csv` has the locations of `EVC/Supervision` of github.com/cesarBLG/ETCS (commit 55c712a, 2025-10-31), with targets
at 0 m, for the trains that it publishes in `EVC/TrainData`, with the speeds of their steps read in m/s, and for four
trains of the conversion model. Two things were given to that program: f41 of SUBSET-041, for which it has 1 % of the
speed; and the build-up times of A.3.8 and A.3.9, whose coefficients it passes in another order than they are declared.
"""

import csv
from pathlib import Path

import numpy as np
import pytest
from onboard import FAR, case_of, percent_data, train_data

from railgrip.supervision.limits import limits_of

K = {"k_dry": 0.8, "k_wet": 0.9}
EVERY_50 = (0.0, 13.8889, 27.7778, 41.6667, 55.5556, 69.4444, 83.3333)
"""Starts of steps every 50 km/h [m/s]."""


def every_50(*decelerations):
    return [*zip(EVERY_50, decelerations, strict=True)]


HIGH_SPEED = {
    "DB 403": (
        [(0, 1.1), (55.5556, 0.95)],
        every_50(0.88, 0.88, 0.85, 0.83, 0.78, 0.7, 0.58),
        {"service_time": 5, "length": 200},
    ),
    "ETR 1000": (
        [(0, 1.0), (38.8889, 0.9), (55.5556, 0.8)],
        [(0, 0.98), (38.8889, 0.94), (55.5556, 0.84)],
        {"service_time": 5, "length": 202},
    ),
    "TGV": (
        [(0, 1.0)],
        every_50(0.95, 0.94, 0.93, 0.84, 0.76, 0.75, 0.74),
        {"service_time": 0.5, "length": 200},
    ),
    "RENFE 103": (
        [(0, 1.1), (55.5556, 0.95)],
        every_50(0.97, 0.95, 0.94, 0.9, 0.89, 0.82, 0.76),
        {"service_time": 0.5, "length": 200},
    ),
}
CONVERTED = {
    "passenger P 135": (135, "passenger P", 400, 200),
    "passenger P 180": (180, "passenger P", 250, 200),
    "freight P 90": (90, "freight P", 700, 120),
    "freight G 65": (65, "freight G", 700, 100),
}


def data_of(train):
    if train in CONVERTED:
        return percent_data(*CONVERTED[train])
    emergency, service, more = HIGH_SPEED[train]
    return train_data(emergency, service, **K, maximum_speed=330 / 3.6, traction_cut_off_time=0.3, **more)


with (Path(__file__).parent / "evc.csv").open(encoding="utf-8") as file:
    ROWS = list(csv.DictReader(file))


@pytest.mark.parametrize("train", [*HIGH_SPEED, *CONVERTED])
def test_all_limits_are_where_an_independent_onboard_unit_has_them(train):
    rows = [row for row in ROWS if row["train"] == train]
    assert {row["gradient"] for row in rows} == {"-10", "0", "8"}
    for row in rows:
        gradient = [{"begin": 0, "slope": float(row["gradient"]) / 1000}]
        case = case_of(data_of(train), (row["target"], FAR, float(row["target_speed"])), gradient=gradient)
        at = limits_of(case, case.line.target[0], float(row["speed"]) / 3.6, float(row["acceleration"]))
        for name, location in at.items():
            # The table has four decimals.
            assert float(location) - FAR == pytest.approx(float(row[name]), abs=1e-3), (row, name)


STEPS = (8.333333, 16.666667, 55.555556, 61.111111)
OSRD = train_data(
    [*zip((0, *STEPS), (1.11, 1.25, 1.34, 1.17, 0.94), strict=True)],
    [*zip((0, *STEPS), (0.74, 0.833333, 0.983333, 0.78, 0.626667), strict=True)],
    normal_service=[{"above": 0, "deceleration": 0.6}, {"above": 61.111111, "deceleration": 0.35}],
    kn=[{"above": 0, "uphill": 6.74e-3, "downhill": 1.74e-3}],
    length=400,
    maximum_speed=80,
    emergency_time=2.5,
    service_time=2,
)
OSRD = OSRD.model_copy(
    update={
        "emergency": tuple(
            step.model_copy(update={"k_dry": k, "k_wet": 0.89})
            for step, k in zip(OSRD.emergency, (0.72, 0.69, 0.69, 0.69, 0.7), strict=True)
        )
    }
)
"""`tests/data/rolling_stocks/etcs_level2_rolling_stock.json` of github.com/OpenRailAssociation/osrd (2025)."""

REST = 0.4
"""Acceleration during T_berem that OSRD assumes always [m/s2]; the train has no T_traction."""


def osrd(kind, speed, target_speed=0):
    """Locations relative to the target of all limits for OSRD's train on level track."""
    case = case_of(OSRD, (kind, FAR, target_speed), national={"Q_NVGUIPERM": True})
    at = limits_of(case, case.line.target[0], np.divide(speed, 3.6), REST)
    return {name: location - FAR for name, location in at.items()}


def test_stops_before_an_end_of_authority_are_where_osrd_has_them():
    """Offsets of `tests/tests/test_train_schedule.py`, whose authors compared OSRD with the Agency's spreadsheet.

    OSRD integrates in steps of 2 s and joins their ends by straight lines in speed: up to a step of speed, 1.2 m/s, the
    chord of such an arc lies a²t²/8 below it, half a metre at 40 km/h.
    """
    assert osrd("EoA", 40)["I"] == pytest.approx(46_754.587 - 47_000, abs=1.0)
    # 1.6 m at 76.84 km/h, where two steps of deceleration meet within a step of time.
    assert osrd("EoA", 76.84)["P"] == pytest.approx(40_649.200 - 41_038, abs=2.0)


def test_interventions_differ_from_osrd_by_the_speed_that_it_adds_twice():
    """OSRD takes the speed of the EBD for V_est in D_bec and V_delta0 (3.13.9.3.2.10): V_bec − V_est is added twice."""
    at = osrd("SvL", 40)
    rest, time = REST * 2.5, 2.5
    under = (2 + 10 * (40 - 30) / 470) / 3.6
    twice = (under + rest) * time
    assert at["I"] - twice == pytest.approx(46_689.738 - 47_000, abs=0.5)
    # From 142 to 112 km/h the offset is nearly the same at both ends of the braking.
    whole = osrd("LoA", [142, 112], 112)["I"]
    assert whole[1] - whole[0] == pytest.approx(44_948.022 - 44_413.825, abs=1.5)
