"""Speed from a rolling wheel while the radar is silent: the function for an invented train of two groups."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from synthetic import GROUP

from railgrip.controllers.free_wheel import FreeWheel, FreeWheelParameters

PERIOD = 10e-3
VALUES = FreeWheelParameters(period=PERIOD)
OFF, ON = 0.0, 2e5  # Pa; the spring takes 0.4 bar
NAN = math.nan


@pytest.fixture
def watch():
    return FreeWheel((GROUP, GROUP), PERIOD)


def over(watch, seconds, speed, rims, pressures):
    """Return the outputs after a number of seconds; rim speeds [m/s] are numbers or functions of time."""
    for k in range(1, round(seconds / PERIOD) + 1):
        now = [rim(k * PERIOD) if callable(rim) else rim for rim in rims]
        last = watch.call([speed, *(rim / GROUP.wheel_radius for rim in now), *pressures])
    return last


def given_within(watch, seconds, rims, pressures):
    """Return the speeds that are output within a number of seconds while the radar is silent."""
    given = [over(watch, PERIOD, NAN, rims, pressures)[0] for _ in range(round(seconds / PERIOD))]
    return [speed for speed in given if not math.isnan(speed)]


@given(st.lists(st.floats(0.0, 60.0), min_size=1, max_size=50))
def test_a_radar_reading_is_used_whenever_available(readings):
    watch = FreeWheel((GROUP, GROUP), PERIOD)
    for reading in readings:
        assert watch.call([reading, 10.0, 20.0, OFF, ON]) == (reading, 0.0, 0.0)


def test_a_released_wheel_replaces_the_radar_after_the_silence(watch):
    over(watch, 3.0, 20.0, (20.0, 18.0), (ON, ON))
    assert not given_within(watch, VALUES.silence - 0.02, (20.0, 18.0), (OFF, ON))
    speeds = given_within(watch, 1.0, (20.0, 18.0), (OFF, ON))
    assert len(speeds) in (9, 10)  # one every 0.1 s, a time that sums of hundredths reach or just miss
    assert set(speeds) == {20.0}


def test_a_brake_must_have_been_off_for_a_while(watch):
    over(watch, 3.0, NAN, (20.0, 18.0), (ON, ON))
    assert not given_within(watch, VALUES.release - 0.02, (20.0, 18.0), (OFF, ON))
    assert given_within(watch, 0.2, (20.0, 18.0), (OFF, ON))


def test_a_wheel_that_spins_up_is_not_a_reference(watch):
    over(watch, 3.0, NAN, (10.0, 9.0), (ON, ON))
    rising = lambda t: 10.0 + 0.5 * t
    for k in range(200):
        # No speed may be output during the time constants that the filter needs to follow the rise.
        speed = over(watch, PERIOD, NAN, (rising(k * PERIOD), 9.0), (OFF, ON))[0]
        assert math.isnan(speed)


@pytest.mark.parametrize("released", [0.0, NAN, 9.0])
def test_a_released_wheel_slower_than_a_braked_one_is_not_a_reference(watch, released):
    """Its sensor is dead, or counts too few teeth: a braked wheel cannot be faster than a rolling one."""
    over(watch, 3.0, NAN, (released, 18.0), (ON, ON))
    assert not given_within(watch, 2.0, (released, 18.0), (OFF, ON))
    assert given_within(watch, 2.0, (9.0, 8.0), (OFF, ON))


def test_groups_are_released_in_turn_if_the_law_releases_none(watch):
    """These releases yield no speed: the pressures do not follow, so no wheel rolls freely."""
    order, last = [], (0.0, 0.0)
    for _ in range(round(30.0 / PERIOD)):
        _, *released = over(watch, PERIOD, NAN, (15.0, 15.0), (ON, ON))
        if tuple(released) != last and any(released):
            order.append(released.index(1.0))
        assert sum(released) <= 1.0
        last = tuple(released)
    # 5 s without a speed, 7 s of release, and again: three releases start within 30 s, beginning with the rear group.
    assert order == [1, 0, 1]


def test_a_test_release_ends_when_it_yields_a_speed(watch):
    over(watch, 1.0, 15.0, (15.0, 12.0), (ON, ON))
    assert over(watch, VALUES.test_after + 0.02, NAN, (15.0, 15.0), (ON, ON))[1:] == (0.0, 1.0)
    assert over(watch, 0.4, NAN, (15.0, 15.0), (ON, OFF))[1:] == (0.0, 1.0)
    assert over(watch, 0.2, NAN, (15.0, 15.0), (ON, OFF))[1:] == (0.0, 0.0)
