"""The law of two maxima: its comparison and its trial on rails in closed form, and the bounds of its demand."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from wheelset import GROUP, SPEED, observed, set_state, state_of

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
    law = drive(friction, 0.0, tuning=TUNING)
    assert state_of(law, "deep") == state_of(law, "trial") == 0.0


class Rail:
    """A rail under a train whose groups have exactly the slip that the law seeks.

    Adhesion is the film's friction times a creep curve that falls beyond its peak at 3 % slip, times what wheels ahead
    have done to the place: each group that has passed it raises friction by `passage`, and their slip energy by
    1 − e^(−energy/`film`) of the gap to ten times the film.
    """

    def __init__(self, friction, passage=0.0, film=np.inf):
        self.friction, self.passage, self.film = friction, passage, film
        self.energy = {}

    def adhesion(self, time, places, slips):
        """Return the adhesion of the groups, lead to trail, and let their slip clean the places."""
        found = []
        for ahead, (place, slip) in enumerate(zip(places, slips, strict=True)):
            cell = int(np.floor(place / 0.5))
            cleaned = 1.0 - np.exp(-(self.energy.get(cell, 0.0)) / self.film)
            film = self.friction(time, place) * np.exp(self.passage * ahead)
            found.append(film * (1.0 + 9.0 * cleaned) * min(slip / 0.03, 1.0) * (0.5 + 0.5 * np.exp(-3.0 * slip)))
        for place, slip, adhesion in zip(places, slips, found, strict=True):
            cell = int(np.floor(place / 0.5))
            self.energy[cell] = self.energy.get(cell, 0.0) + adhesion * slip * SPEED * PERIOD / 0.5
        return found


def ride(rail, *, seconds=10.0, tuning=TUNING, positions=POSITIONS, begin_deep=None, highest=None, lost=None):
    """Return the law, and whether it was in a trial and in deep slip at each sample, on a rail at constant speed.

    Args:
        rail: The rail.
        seconds: Duration.
        tuning: Parameters of the law.
        positions: Distances of the groups behind the first one.
        begin_deep: Time at which deep slip is set.
        highest: Highest slip that each group can reach.
        lost: Number of a group from 0 on, and time from which its wheel speed reads 0.
    """
    law = TwoMaxima([GROUP] * len(positions), tuning)
    law.place(positions)
    slips, trials, dives = [0.0] * len(positions), [], []
    for k in range(round(seconds / PERIOD)):
        time = k * PERIOD
        if begin_deep is not None and k == round(begin_deep / PERIOD):
            set_state(law, "deep", 1.0)
        adhesion = rail.adhesion(time, SPEED * time - np.array(positions), slips)
        seen = [1.0 if lost and (g, True) == (lost[0], time > lost[1]) else slip for g, slip in enumerate(slips)]
        pressures = (0.0 if k < 2 else 1.5e5,) * len(slips)
        law.decide(observed(time, SPEED, -0.5, seen, tuple(adhesion), (0.35,) * len(slips), pressures))
        if k >= 2:  # rolling, until the brake is applied
            slips = [max(state_of(law, f"slip_target[{g}]"), 0.01) for g in range(1, len(slips) + 1)]
            slips = slips if highest is None else [min(pair) for pair in zip(slips, highest, strict=True)]
        trials.append(state_of(law, "trial"))
        dives.append(state_of(law, "deep"))
    return law, np.array(trials), np.array(dives)


FILM = 0.15
"""Adhesion times slip after which 63 % of the film are worn: a pass at 3 % slip and adhesion 0.05 wears 1 % of it."""


def drops(time, place):
    """Friction over time as on the rails of Table 1: trapezoids of 8 s from 0.13 to 0.055 and back."""
    return float(np.interp(time % 8.0, [0.0, 1.0, 5.0, 6.0, 8.0], [0.13, 0.055, 0.055, 0.13, 0.13])) / 2.0


@pytest.mark.parametrize("passage", [0.1, 0.3])
@pytest.mark.parametrize("friction", [even, drops])
def test_the_cleaning_of_passing_wheels_causes_a_trial_but_no_deep_slip(friction, passage):
    """Groups behind have as much more adhesion as before, while the first one loses a third of its own."""
    _, trials, dives = ride(Rail(friction, passage=passage), seconds=20.0)
    assert trials.any()
    assert not dives.any()
    # A trial lasts as long as the second group behind needs to the cleaned places, and less than a second more.
    begins = np.flatnonzero(np.diff(trials) > 0)
    assert trials.sum() * PERIOD < len(begins) * (POSITIONS[2] / SPEED + TUNING.trial_wait + 1.0)


def test_friction_that_rises_along_the_track_in_a_trial_causes_a_short_deep_slip_at_most():
    """Where the first group gets to a better place in its trial, this looks like an effect of its slip."""
    for passage in (0.1, 0.3):
        _, trials, dives = ride(Rail(steps, passage=passage), seconds=20.0)
        assert trials.any()
        assert dives.sum() * PERIOD < 4.0
        assert dives[-1] == 0.0


@pytest.mark.parametrize("film", [0.2 * FILM, FILM, 2.0 * FILM])
@pytest.mark.parametrize("friction", [even, steps])
def test_a_rail_that_slip_cleans_has_deep_slip_after_a_trial(friction, film):
    """The trial begins before the last group is at places where the first one has slid: its gain there is no drift."""
    _, trials, dives = ride(Rail(friction, film=film))
    assert trials.any()
    assert dives[-1] == 1.0
    assert np.argmax(trials) < np.argmax(dives)


def test_after_a_failed_trial_the_next_one_waits_for_a_lower_speed():
    _, trials, _ = ride(Rail(even, passage=0.2), seconds=20.0)
    assert np.count_nonzero(np.diff(trials) > 0) == 1


@pytest.mark.parametrize("scale", [0.3, 2.0])
def test_the_decision_does_not_depend_on_the_level_of_adhesion(scale):
    """Adhesion is compared by ratios; energies that wear the film grow with it, and so does the film here."""
    level = lambda time, place: scale * even(time, place)
    assert not ride(Rail(level, passage=0.2), seconds=20.0)[2].any()
    assert ride(Rail(level, film=scale * FILM))[2][-1] == 1.0


def test_a_first_group_that_cannot_reach_its_slip_ends_the_trial():
    """As with a valve that holds its pressure: the trial must not last for the rest of the stop."""
    _, trials, dives = ride(Rail(even, passage=0.2), seconds=20.0, highest=(0.05, 1.0, 1.0, 1.0))
    assert 0 < trials.sum() <= TUNING.trial_longest / PERIOD + 3
    assert not dives.any()


def test_a_first_group_that_loses_its_wheel_speed_in_a_trial_is_released_and_ends_it():
    """Its reading becomes 0, a slip of 1: its brake must be released, as no sensor can show a lock."""
    law, trials, _ = ride(Rail(even, passage=0.2), seconds=20.0)
    begin = np.argmax(trials) * PERIOD
    law, trials, dives = ride(Rail(even, passage=0.2), seconds=round(begin + 4.0, 2), lost=(0, begin + 0.2))
    assert not trials[-1]
    assert not dives.any()
    assert state_of(law, "mode[1]") in (2.0, 3.0)  # vented, or braked by the adhesion of the others


def test_friction_that_falls_for_all_groups_in_a_trial_is_no_effect_of_slip():
    """As clouds for a tracker of the maximum power point: a change of all units in the trial must not decide."""
    _, trials, _ = ride(Rail(even, passage=0.2), seconds=20.0)
    begin = np.argmax(trials) * PERIOD
    for factor in (0.4, 2.5):
        changing = lambda time, place, factor=factor: 0.05 * (factor if time > begin + 0.8 else 1.0)
        assert not ride(Rail(changing, passage=0.2), seconds=begin + 5.0)[2].any()


def test_a_train_with_two_groups_decides_as_well():
    assert not ride(Rail(even, passage=0.2), seconds=20.0, positions=(0.0, 15.0))[2].any()
    assert ride(Rail(even, film=0.4 * FILM), positions=(0.0, 15.0))[2][-1] == 1.0


def test_no_trial_begins_at_low_speed():
    tuning = replace(TUNING, trial_speed=SPEED + 1.0)
    _, trials, _ = ride(Rail(even, passage=0.2), tuning=tuning)
    assert not trials.any()


def test_only_the_first_group_slips_deep_in_a_trial():
    law, trials, _ = ride(Rail(even, passage=0.2), seconds=20.0)
    end = round((np.argmax(trials) + 60) * PERIOD, 2)
    law, trials, _ = ride(Rail(even, passage=0.2), seconds=end)
    assert trials[-1] == 1.0
    first, *others = (state_of(law, f"slip_target[{g}]") for g in range(1, 5))
    assert first > 0.3
    assert max(others) < 0.15


def test_deep_slip_ends_where_the_train_loses_adhesion_by_it():
    """Deep slip that was begun on a rail that passing wheels clean: the comparison alone would keep it."""
    law, _, dives = ride(Rail(even, passage=0.3), seconds=20.0, begin_deep=10.0)
    assert state_of(law, "advantage") > TUNING.advantage_low
    # The mean of the train falls by more than 0.4; it is formed over `level_time`.
    assert dives.sum() * PERIOD == pytest.approx(TUNING.level_time, abs=2 * PERIOD)


def in_deep_slip():
    """Return the law in deep slip after it has compared groups on an even rail."""
    law = drive(even, 0.2)
    set_state(law, "deep", 1.0)
    set_state(law, "level_on_slope", -9.0)
    return law


def test_deep_slip_ends_where_groups_behind_gain_no_adhesion():
    law = in_deep_slip()
    for k in range(600):
        law.decide(observed(k * PERIOD, SPEED, -0.5, (0.45,) * 4, (0.05,) * 4, (0.35,) * 4, (1.5e5,) * 4))
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
    set_state(law, "deep", deep)
    torque = 0.2 * GROUP.load * GROUP.wheel_radius + GROUP.inertia * 1.5 * 1.3 / GROUP.wheel_radius
    highest = (torque / (2 * 0.35 * 0.22) / 5.7 + GROUP.spring_force) / GROUP.piston_area
    for k, (speed, slip, adhesion, pressure) in enumerate(observations):
        now = observed(k * PERIOD, speed, -1.5, tuple(slip), tuple(adhesion), (0.35,) * 4, tuple(pressure))
        demands = np.array(law.decide(now))
        assert np.all(np.isfinite(demands))
        assert np.all(demands >= 0.0)
        assert np.all(demands <= highest)


def test_a_wheel_that_nearly_locks_is_released_in_deep_slip():
    law = in_deep_slip()
    for k in range(100):
        first = 0.9 if k == 99 else 0.4
        now = observed(k * PERIOD, SPEED, -0.5, (first, 0.4, 0.4, 0.4), (0.05,) * 4, (0.35,) * 4, (1.5e5,) * 4)
        demands = law.decide(now)
    assert demands[0] == 0.0
    assert min(demands[1:]) > 0.0


def test_a_group_returns_to_slope_seeking_after_deep_slip():
    law = in_deep_slip()
    law.parameters[[quantity.name for quantity in law.formula.parameters].index("work_max")] = 0.1
    for k in range(200):
        law.decide(observed(k * PERIOD, SPEED, -0.5, (0.4,) * 4, (0.05,) * 4, (0.35,) * 4, (1.5e5,) * 4))
    assert state_of(law, "slip_target[1]") < 0.3


@pytest.mark.parametrize("change", [{"slip_deep": 0.9}, {"slip_vent_deep": 1.0}, {"slip_trial": 0.9}])
def test_slips_out_of_order_are_refused(change):
    with pytest.raises(ValueError, match="TwoMaxima: 0 < slip_"):
        replace(TUNING, **change)
