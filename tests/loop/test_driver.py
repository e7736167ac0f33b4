"""The demand of the driver as a function of place, time and speed."""

import numpy as np
import pytest
from kernel_calls import drive, phase_of
from synthetic import FULL, LAYOUT

from railgrip.scenario.demand import Driver

PERIOD = 0.01
RELEASE = 3e4


def phase(pressure=0.0, until="end", end=np.nan, **changes):
    return phase_of(until, end=end, pressure=pressure, **changes)


def driver(*phases):
    return Driver(LAYOUT, PERIOD, full=FULL, release_pressure=np.full(4, RELEASE), phases=np.concatenate(phases))


def pressure_at(one, sample, speed=20.0, distance=0.0):
    truth = np.zeros(LAYOUT.outputs)
    truth[LAYOUT.output["speed"]], truth[LAYOUT.output["distance"]] = speed, distance
    pressure = drive(one, sample, truth)
    assert len(set(pressure)) == 1
    return pressure[0]


def test_times_are_rounded_to_the_nearest_sample():
    """0.57 s is sample 57, although 57 times 0.01 s is less in floating point."""
    one = driver(phase(1.0, "time", 0.57), phase(2.0, "duration", 0.29), phase(3.0))
    pressures = [pressure_at(one, k) for k in range(100)]
    assert pressures == [1.0] * 57 + [2.0] * 29 + [3.0] * 14


def test_places_and_speeds_end_phases():
    one = driver(
        phase(1.0, "distance", 100.0), phase(2.0, "speed_below", 15.0), phase(3.0, "speed_above", 16.0), phase()
    )
    courses = [(20, 99.9), (20, 100), (15.1, 101), (15, 102), (15.9, 103), (16, 104), (10, 105)]
    assert [pressure_at(one, k, *course) for k, course in enumerate(courses)] == [1, 2, 2, 3, 3, 0, 0]


def test_phases_that_have_already_ended_are_skipped():
    one = driver(phase(1.0, "distance", 10.0), phase(2.0, "speed_below", 30.0), phase(3.0, "time", 0.0), phase(4.0))
    assert pressure_at(one, 0, speed=20.0, distance=11.0) == 4.0


def test_a_profile_is_linear():
    line = phase_of("time", end=2.0, begin=1.0, pressure=1e5, slope=5e4)
    one = driver(phase(1e5, "time", 1.0), line, phase(1.5e5))
    assert [pressure_at(one, k) for k in (0, 100, 150, 199, 200, 300)] == pytest.approx(
        [1e5, 1e5, 1.25e5, 1.495e5, 1.5e5, 1.5e5]
    )


def test_traction_is_limited_by_force_power_and_rate():
    """50 kN, 500 kW: the power limits above 10 m/s; 100 kN/s are 1 kN per sample, also when falling."""
    traction = {"force": 5e4, "rate": 1e5}
    one = driver(phase(until="time", end=1.0, power=5e5, **traction), phase(rate=1e5))

    def force(sample, speed):
        pressure_at(one, sample, speed)
        return one.struct.pointer.force

    assert [force(k, 5.0) for k in range(3)] == pytest.approx([1e3, 2e3, 3e3])
    assert [force(k, 5.0) for k in range(3, 60)][-1] == 5e4
    assert [force(k, 20.0) for k in range(60, 100)][-1] == pytest.approx(2.5e4)
    assert [force(k, 20.0) for k in range(100, 103)] == pytest.approx([2.4e4, 2.3e4, 2.2e4])


@pytest.mark.parametrize("braking", [0.7, 1.0, 1.2])
def test_a_block_stops_at_the_target(braking):
    """A block that brakes immediately stops within a centimetre of the target with a brake of unexpected strength.

    No brake is demanded before the curve of 0.6 m/s², v²/(2 a) before the target.
    """
    one = driver(phase(target=500.0, deceleration=0.6, full_deceleration=1.2))
    speed, distance, begun = 20.0, 0.0, None
    for k in range(20_000):
        share = max(pressure_at(one, k, speed, distance) - RELEASE, 0.0) / (FULL[0] - RELEASE)
        begun = distance if begun is None and share > 0 else begun
        slowing = 1.2 * braking * share
        distance += speed * PERIOD - slowing * PERIOD**2 / 2
        speed -= slowing * PERIOD
        if speed <= 0.01:
            break
    assert begun == pytest.approx(500.0 - 20.0**2 / (2 * 0.6), abs=20.0 * PERIOD)
    assert distance == pytest.approx(500.0, abs=0.01)


def test_beyond_the_target_full_brake_is_demanded():
    one = driver(phase(target=500.0, deceleration=0.6, full_deceleration=1.2))
    assert pressure_at(one, 0, 5.0, 500.0) == FULL[0]
