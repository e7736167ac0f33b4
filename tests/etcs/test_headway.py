"""Headways against closed forms by hand, and against two trains that follow each other in time."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from onboard import train_data

from railgrip.supervision.curve import Steps
from railgrip.supervision.headway import SignallingLayout, SignallingTimes, SpeedSection, Stopping, headways, run_of
from railgrip.supervision.model import model_of
from railgrip.supervision.national import NationalValues

EMERGENCY, K_DRY, K_WET, SERVICE, BUILD_UP, SERVICE_TIME = 1.2, 0.8, 0.7, 0.9, 1.5, 2.0
V, LENGTH = 40.0, 100.0
EXACT = NationalValues(Q_NVINHSMICPERM=True)
"""Without inaccuracy of speed, of which the closed forms know nothing."""
DRIVER, INDICATION = 4.0, 5.0 + 4.0
"""T_driver and T_indication [s] (SUBSET-026, A.3.1 and §3.13.9.3.6.2, here 0.8 T_bs is below 5 s)."""


@pytest.fixture(scope="module")
def train():
    data = {"length": LENGTH, "maximum_speed": V, "emergency_time": BUILD_UP, "service_time": SERVICE_TIME}
    return model_of(train_data([(0.0, EMERGENCY)], [(0.0, SERVICE)], k_dry=K_DRY, k_wet=K_WET, **data))


def layout(**changes):
    """Return a line of two blocks, 1,000 m and 1,500 m long, with constant speed unless changed."""
    times = SignallingTimes(setup=7.0, release=3.0, report=5.0, margin=40.0, source="an example")
    values = {
        "speed": [{"begin": 0, "speed": V}], "block": (0.0, 1000.0, 2500.0), "overlap": 60.0, "acceleration": 0.5,
        "deceleration": 0.8, "times": times, **changes,
    }  # fmt: skip
    return SignallingLayout.model_validate(values)


def approach(deceleration, build_up):
    """Return the time from the indication to the target at constant speed and constant deceleration [s]."""
    return V / (2 * deceleration) + build_up + SERVICE_TIME + DRIVER + INDICATION


SAFE = K_DRY * K_WET * EMERGENCY


def test_at_constant_speed_the_headway_is_the_sum_of_the_terms_of_the_longest_block(train):
    fixed, moving = headways(layout(), train, EXACT)
    assert fixed.limit == moving.limit == "EBD"
    assert fixed.place == 1000.0
    # The SvL is 60 m behind the marker, so that the indication is as much closer to it.
    by_hand = {"signalling": 10.0, "approach": approach(SAFE, BUILD_UP) - 60 / V, "block": 1500 / V,
               "clearing": (60 + LENGTH) / V, "dwell": 0.0}  # fmt: skip
    # At its highest speed a curve is exact, and a run at constant speed has no error of its grid.
    assert fixed.parts == pytest.approx(by_hand, abs=1e-6)
    assert fixed.seconds == pytest.approx(sum(by_hand.values()), abs=1e-6)
    assert moving.seconds == pytest.approx(12.0 + approach(SAFE, BUILD_UP) + (40 + LENGTH) / V, abs=1e-6)


def test_with_a_long_overlap_the_service_brake_decides_and_adhesion_does_not(train):
    fixed, _ = headways(layout(overlap=2000.0), train, EXACT)
    assert fixed.limit == "SBD"
    assert fixed.parts["approach"] == pytest.approx(approach(SERVICE, 0.0), abs=1e-6)
    less = replace(train, k_wet=Steps.constant(0.6))
    assert headways(layout(overlap=2000.0), less, EXACT)[0] == fixed


def test_a_stop_in_a_block_adds_dwell_and_the_time_of_braking_and_accelerating(train):
    """Both ramps, 1,000 m to brake and 1,600 m to accelerate, are inside of the block and what has to be cleared."""
    line = layout(block=(0.0, 4000.0), stop=[{"at": 1500.0, "dwell": 45.0}])
    fixed, _ = headways(line, train, EXACT)
    assert fixed.parts["dwell"] == pytest.approx(45.0)
    assert fixed.parts["block"] == pytest.approx(4000 / V + V / (2 * 0.8) + V / (2 * 0.5), abs=0.01)


def test_behind_a_station_a_block_is_needed_from_the_departure_on(train):
    """From rest at the marker, a block of 400 m, overlap and train take √(2 s/a), while v stays below V."""
    line = layout(block=(1000.0, 1400.0), stop=[{"at": 1000.0, "dwell": 45.0}])
    fixed, _ = headways(line, train, EXACT)
    assert fixed.parts["approach"] == pytest.approx(0.0)
    assert fixed.parts["dwell"] == 0.0
    assert fixed.seconds == pytest.approx(10.0 + np.sqrt(2 * (400 + 60 + LENGTH) / 0.5), abs=0.01)


def test_a_moving_block_at_a_station_waits_for_the_train_ahead(train):
    """The train ahead dwells and accelerates until its rear is clear; the next one stops at the same place."""
    line = layout(block=(0.0, 6000.0), stop=[{"at": 3000.0, "dwell": 45.0}])
    _, moving = headways(line, train, EXACT)
    assert moving.parts["dwell"] == pytest.approx(45.0)
    assert moving.seconds > headways(layout(block=(0.0, 6000.0)), train, EXACT)[1].seconds + 45.0


def test_a_restriction_holds_until_the_rear_end_has_left_it():
    """OpenRailAssociation/osrd#13641: 20 m/s over 600 m and the train's length, between ramps at 0.8 and 0.5 m/s²."""
    speeds = [{"begin": 0, "speed": V}, {"begin": 2000.0, "speed": 20.0}, {"begin": 2600.0, "speed": V}]
    run = run_of(layout(speed=speeds), LENGTH, V, [0.0, 6000.0])
    slow = 600 + LENGTH
    down, up = (V**2 - 20**2) / (2 * 0.8), (V**2 - 20**2) / (2 * 0.5)
    by_hand = (6000 - slow - down - up) / V + slow / 20 + (V - 20) / 0.8 + (V - 20) / 0.5
    assert np.diff(np.interp([0.0, 6000.0], run.location, run.moving)) == pytest.approx(
        by_hand, abs=0.02
    )  # two corners within a cell of 5 m
    assert float(np.interp(2650.0, run.location, run.speed)) == pytest.approx(20.0)


def test_a_second_train_at_the_headway_runs_without_an_indication_and_a_second_earlier_with_one(train):
    """Moving block, in time: the end of authority is the rear end of the train ahead as reported before."""
    speeds = [{"begin": 0, "speed": V}, {"begin": 3000.0, "speed": 25.0}, {"begin": 4000.0, "speed": V}]
    line = layout(speed=speeds, block=(0.0, 8000.0))
    _, moving = headways(line, train, EXACT)
    run = run_of(line, LENGTH, V, [-5000.0, 9000.0])
    time = run.moving

    def reserve(headway):
        """Least distance from the second train to its indication [m], while its authority ends on the line."""
        t = np.arange(time[0] + headway, time[-1], 0.05)
        end = np.interp(t - 12.0, time, run.location) - LENGTH - 40.0
        second = np.interp(t - headway, time, run.location)
        v = np.interp(t - headway, time, run.speed)
        needed = v**2 / (2 * SAFE) + v * (BUILD_UP + SERVICE_TIME + DRIVER + INDICATION)
        return (end - second - needed)[(end > 0) & (end < 8000)].min()

    # Ends of authority are 10 m apart: the longest blocking time is between two of them, 2 m or .08 s longer at most.
    assert reserve(moving.seconds) > -2.0
    assert reserve(moving.seconds - 1.0) < 0.0


@given(
    low=st.floats(0.2, 1.0), high=st.floats(0.2, 1.0), overlap=st.integers(0, 400), at=st.floats(200, 2400),
    slow=st.floats(10, V),
)  # fmt: skip
def test_a_better_brake_never_has_a_longer_headway(train, low, high, overlap, at, slow):
    low, high = sorted((low, high))
    line = layout(
        overlap=overlap, gradient=[{"begin": 500, "slope": -0.005}, {"begin": 1500, "slope": 0.01}],
        speed=[SpeedSection(begin=0, speed=V), SpeedSection(begin=1200, speed=slow)], stop=[Stopping(at=at, dwell=30)],
    )  # fmt: skip
    brakes = [replace(train, k_wet=Steps.constant(factor)) for factor in (low, high)]
    for longer, shorter in zip(*(headways(line, brake, NationalValues()) for brake in brakes), strict=True):
        assert shorter.seconds <= longer.seconds + 1e-9
        assert longer.seconds == pytest.approx(sum(longer.parts.values()))
        assert min(longer.parts.values()) >= -1e-9


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"block": (0.0, 500.0, 500.0)}, "block must be at rising locations"),
        ({"stop": [{"at": 5.0, "dwell": 1.0}, {"at": 9.0, "dwell": 1.0}]}, "stations must be at least 10 m apart"),
        ({"deceleration": 30.0}, "must be at most 3"),
    ],
)
def test_a_layout_that_cannot_be_is_refused(changes, sentence):
    with pytest.raises(ValueError, match=sentence):
        layout(**changes)
