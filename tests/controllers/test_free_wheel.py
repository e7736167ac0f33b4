"""The speed that a rolling wheel shows while the radar is silent: formulas of a made-up train of two groups."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from railgrip.controllers.free_wheel import FreeWheel, FreeWheelParameters
from railgrip.vehicle.brake import Brake

PERIOD = 10e-3
VALUES = FreeWheelParameters(period=PERIOD)
RADIUS = 0.5
GROUP = Brake(
    load=140e3, inertia=240.0, wheel_radius=RADIUS, units=4, friction_radius=0.25, piston_area=0.02, rigging=8.0,
    spring_force=600.0, pressure_max=3.8e5,
)  # fmt: skip
OFF, ON = 0.0, 2e5  # Pa; the spring takes 0.3 bar
NAN = math.nan


@pytest.fixture
def watch():
    return FreeWheel((GROUP, GROUP), PERIOD)


def over(watch, seconds, speed, rims, pressures):
    """What it returns at the last of so many seconds; rims [m/s] are numbers or functions of time."""
    for k in range(1, round(seconds / PERIOD) + 1):
        now = [rim(k * PERIOD) if callable(rim) else rim for rim in rims]
        last = watch.call([speed, *(rim / RADIUS for rim in now), *pressures])
    return last


def given_within(watch, seconds, rims, pressures):
    """The speeds that it gave meanwhile, the radar silent."""
    given = [over(watch, PERIOD, NAN, rims, pressures)[0] for _ in range(round(seconds / PERIOD))]
    return [speed for speed in given if not math.isnan(speed)]


@given(st.lists(st.floats(0.0, 60.0), min_size=1, max_size=50))
def test_a_radar_that_shows_something_is_what_counts(readings):
    watch = FreeWheel((GROUP, GROUP), PERIOD)
    for reading in readings:
        assert watch.call([reading, 10.0, 20.0, OFF, ON]) == (reading, 0.0, 0.0)


def test_a_released_wheel_stands_in_after_the_silence(watch):
    over(watch, 3.0, 20.0, (20.0, 18.0), (ON, ON))
    assert not given_within(watch, VALUES.silence - 0.02, (20.0, 18.0), (OFF, ON))
    speeds = given_within(watch, 1.0, (20.0, 18.0), (OFF, ON))
    assert len(speeds) in (9, 10)  # one every 0.1 s, which hundredths reach or just miss
    assert set(speeds) == {20.0}


def test_a_brake_must_have_been_off_for_a_while(watch):
    over(watch, 3.0, NAN, (20.0, 18.0), (ON, ON))
    assert not given_within(watch, VALUES.release - 0.02, (20.0, 18.0), (OFF, ON))
    assert given_within(watch, 0.2, (20.0, 18.0), (OFF, ON))


def test_a_wheel_that_spins_up_is_no_reference(watch):
    over(watch, 3.0, NAN, (10.0, 9.0), (ON, ON))
    rising = lambda t: 10.0 + 0.5 * t
    for k in range(200):
        # The filter has to see the rise first: for three of its time constants nothing may be said.
        speed = over(watch, PERIOD, NAN, (rising(k * PERIOD), 9.0), (OFF, ON))[0]
        assert math.isnan(speed)


def test_a_dead_sensor_of_a_released_wheel_is_none_either(watch):
    over(watch, 3.0, NAN, (0.0, 18.0), (ON, ON))
    assert not given_within(watch, 2.0, (0.0, 18.0), (OFF, ON))
    over(watch, 3.0, NAN, (NAN, 18.0), (ON, ON))
    assert not given_within(watch, 2.0, (NAN, 18.0), (OFF, ON))


def test_a_released_wheel_that_is_slower_than_a_braked_one_is_none(watch):
    """Its sensor counts too few teeth: nothing that brakes makes a wheel faster than one that rolls."""
    over(watch, 3.0, NAN, (9.0, 18.0), (ON, ON))
    assert not given_within(watch, 2.0, (9.0, 18.0), (OFF, ON))
    assert given_within(watch, 2.0, (9.0, 8.0), (OFF, ON))


def test_where_no_law_releases_a_group_each_is_in_its_turn(watch):
    """In vain here: pressures do not follow, so no wheel rolls."""
    order, last = [], (0.0, 0.0)
    for _ in range(round(30.0 / PERIOD)):
        _, *released = over(watch, PERIOD, NAN, (15.0, 15.0), (ON, ON))
        if tuple(released) != last and any(released):
            order.append(released.index(1.0))
        assert sum(released) <= 1.0
        last = tuple(released)
    # 5 s without, 7 s of release, and again: three begin in 30 s, the rear one first.
    assert order == [1, 0, 1]


def test_a_release_ends_with_the_speed_that_it_shows(watch):
    over(watch, 1.0, 15.0, (15.0, 12.0), (ON, ON))
    assert over(watch, VALUES.test_after + 0.02, NAN, (15.0, 15.0), (ON, ON))[1:] == (0.0, 1.0)
    assert over(watch, 0.4, NAN, (15.0, 15.0), (ON, OFF))[1:] == (0.0, 1.0)
    assert over(watch, 0.2, NAN, (15.0, 15.0), (ON, OFF))[1:] == (0.0, 0.0)
