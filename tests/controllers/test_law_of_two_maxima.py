"""The law of two maxima: its comparison of groups with friction in closed form, and the bounds of its demand."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from wheelset import GROUP, SPEED, observed, state_of

from railgrip.controllers.laws.slope_seeking import SlopeSeeking
from railgrip.controllers.laws.two_maxima import TwoMaxima

PERIOD = 0.01
POSITIONS = (0.0, 15.0, 18.0, 33.0)
TUNING = TwoMaxima.load_tuning("pneumatic", "estimated", period=PERIOD, pressure_lag=0.0, adhesion_max=0.15)
OBSERVING = replace(TUNING, advantage_high=10.0)


def even(time, place):
    return 0.05


def steps(time, place):
    return 0.05 * (1.4 if place % 20.0 < 10.0 else 0.6)


def waves_over_time(time, place):
    return 0.05 * (1.0 + 0.4 * np.sin(2 * np.pi * time / 0.7))


def drive(friction, gain, *, tuning=OBSERVING, positions=POSITIONS, seconds=8.0, slips=(0.03,) * 4, pressure=1.5e5):
    """Return the law after some seconds at constant speed with the given slips.

    The adhesion of the first group is the friction at its time and place; groups behind it have exp(gain) times as
    much.
    """
    law = TwoMaxima([GROUP] * 4, tuning)
    if positions is not None:
        law.place(positions)
    law.decide(observed(0.0, SPEED, 0.0, (0.0,) * 4, (0.0,) * 4, (0.35,) * 4, (0.0,) * 4))
    for k in range(1, round(seconds / PERIOD)):
        places = SPEED * k * PERIOD - np.array(POSITIONS)
        adhesion = [friction(k * PERIOD, place) * np.exp(gain if g else 0.0) for g, place in enumerate(places)]
        law.decide(observed(k * PERIOD, SPEED, -0.5, slips, tuple(adhesion), (0.35,) * 4, (pressure,) * 4))
    return law


@pytest.mark.parametrize("friction", [even, steps, waves_over_time])
@pytest.mark.parametrize("gain", [-0.1, 0.0, 0.2])
def test_the_comparison_finds_the_gain_on_a_rail_that_varies(friction, gain):
    """A mean over eight time constants leaves 0.002, and varying friction hides up to a quarter of the gain.

    Where friction varies, the comparison closer to zero counts, and the adhesion filter smears changes within 0.45 m.
    """
    law = drive(friction, gain)
    assert state_of(law, "advantage") == pytest.approx(gain, abs=0.002 if friction is even else 0.05)


@pytest.mark.parametrize("friction", [even, steps, waves_over_time])
def test_a_rail_that_slip_does_not_clean_has_no_deep_slip(friction):
    assert state_of(drive(friction, 0.0, tuning=TUNING), "deep") == 0.0


def test_a_rail_that_slip_cleans_has_deep_slip():
    assert state_of(drive(steps, 0.2, tuning=TUNING), "deep") == 1.0


def test_deep_slip_ends_where_groups_behind_gain_no_adhesion():
    law = drive(even, 0.2, tuning=TUNING)
    for k in range(600):
        law.decide(observed(k * PERIOD, SPEED, -0.5, (0.45,) * 4, (0.05,) * 4, (0.35,) * 4, (1.5e5,) * 4))
    assert state_of(law, "deep") == 0.0
    # At this speed deep slip does not start again.
    for k in range(600):
        law.decide(observed(k * PERIOD, SPEED, -0.5, (0.03,) * 4, (0.05, *(0.08,) * 3), (0.35,) * 4, (1.5e5,) * 4))
    assert state_of(law, "advantage") > TUNING.advantage_high
    assert state_of(law, "deep") == 0.0


@pytest.mark.parametrize(
    "change",
    [
        {"positions": None},
        {"slips": (0.03, 0.08, 0.08, 0.08)},
        {"slips": (0.001,) * 4},
        {"pressure": 0.99 * GROUP.pressure_max},
        {"positions": (0.0, 60.0, 65.0, 80.0)},
    ],
)
def test_groups_that_differ_otherwise_are_not_compared(change):
    """Their positions or slips differ, they roll, the brake limits them, or the memory is too short."""
    assert state_of(drive(even, 0.2, tuning=TUNING, **change), "advantage") == 0.0


def test_without_positions_the_law_is_slope_seeking():
    slope = SlopeSeeking.load_tuning("pneumatic", "estimated", period=PERIOD, pressure_lag=0.0, adhesion_max=0.15)
    laws = (SlopeSeeking([GROUP] * 2, slope), TwoMaxima([GROUP] * 2, TUNING))
    random = np.random.default_rng(5)
    for k in range(300):
        slips, adhesion = random.uniform(0.0, 0.2, 2), tuple(random.uniform(0.02, 0.1, 2))
        now = observed(k * PERIOD, SPEED, -0.5, tuple(slips), adhesion, (0.35,) * 2, (1e5,) * 2)
        own, other = (law.decide(now) for law in laws)
        assert own == other


OBSERVATIONS = st.lists(
    st.tuples(
        st.floats(0.0, 60.0),
        st.lists(st.floats(-0.3, 1.0), min_size=4, max_size=4),
        st.lists(st.floats(-0.05, 0.2), min_size=4, max_size=4),
        st.lists(st.floats(0.0, 3.4e5), min_size=4, max_size=4),
    ),
    min_size=1,
    max_size=30,
)


@settings(max_examples=60, deadline=None)
@given(OBSERVATIONS, st.sampled_from([0.0, 1.0]))
def test_the_demand_is_bounded(observations, deep):
    """From zero to the pressure of the torque that adhesion_max and the inertia of the wheelset allow."""
    law = TwoMaxima([GROUP] * 4, TUNING)
    law.place(POSITIONS)
    law.state[[quantity.name for quantity in law.formula.states].index("deep")] = deep
    torque = 0.2 * GROUP.load * GROUP.wheel_radius + GROUP.inertia * 1.5 * 1.3 / GROUP.wheel_radius
    highest = (torque / (2 * 0.35 * 0.22) / 5.7 + GROUP.spring_force) / GROUP.piston_area
    for k, (speed, slip, adhesion, pressure) in enumerate(observations):
        now = observed(k * PERIOD, speed, -1.5, tuple(slip), tuple(adhesion), (0.35,) * 4, tuple(pressure))
        demands = np.array(law.decide(now))
        assert np.all(np.isfinite(demands))
        assert np.all(demands >= 0.0)
        assert np.all(demands <= highest)


def test_a_wheel_that_nearly_locks_is_released_in_deep_slip():
    law = drive(even, 0.2, tuning=TUNING)
    for k in range(100):
        first = 0.9 if k == 99 else 0.4
        now = observed(k * PERIOD, SPEED, -0.5, (first, 0.4, 0.4, 0.4), (0.05,) * 4, (0.35,) * 4, (1.5e5,) * 4)
        demands = law.decide(now)
    assert demands[0] == 0.0
    assert min(demands[1:]) > 0.0


def test_a_group_returns_to_slope_seeking_after_deep_slip():
    law = drive(even, 0.2, tuning=replace(TUNING, work_max=0.1))
    for k in range(200):
        law.decide(observed(k * PERIOD, SPEED, -0.5, (0.4,) * 4, (0.05,) * 4, (0.35,) * 4, (1.5e5,) * 4))
    assert state_of(law, "slip_target[1]") < 0.3


@pytest.mark.parametrize("change", [{"slip_deep": 0.9}, {"slip_vent_deep": 1.0}])
def test_slips_out_of_order_are_refused(change):
    with pytest.raises(ValueError, match="TwoMaxima: slips must have 0 < slip_deep"):
        replace(TUNING, **change)
