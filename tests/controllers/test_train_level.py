"""Decisions for the whole train: valves shared by several groups, and redistribution of force."""

from dataclasses import replace

import numpy as np
import pytest
import synthetic

from railgrip.controllers.law import GroupLaw, Law
from railgrip.controllers.laws.recursive_slope import RecursiveSlope
from railgrip.controllers.laws.slip_two_state import SlipLevels, SlipTwoState
from railgrip.controllers.observation import Observation
from railgrip.controllers.train_level import (
    PAD_FRICTION,
    pass_through,
    with_redistribution,
    with_release_limit,
    with_shared_valves,
)

GROUP = replace(synthetic.GROUP, pressure_max=3e5)
GROUPS = (GROUP, GROUP, replace(GROUP, pressure_max=2e5))
LEVELS = SlipLevels(low=0.05, high=0.1, speed_min=1.0)


def observed(slip: tuple[float, float, float], demand: float) -> Observation:
    limit = np.array([demand * group.pressure_max for group in GROUPS])
    wheels = 20.0 / GROUP.wheel_radius * (1.0 - np.array(slip))
    return Observation(0.0, 20.0, -0.5, wheels, np.array(slip), False, None, None, np.zeros(3), limit)


def slip_based() -> Law:
    return SlipTwoState(GROUPS, LEVELS)


def force(pressures: np.ndarray) -> float:
    """Return the force of all brakes at the rims [N] with the pad friction assumed in the absence of an estimate."""
    per_pascal = GROUP.units * PAD_FRICTION * GROUP.friction_radius * GROUP.rigging * GROUP.piston_area
    return float(np.sum(pressures)) * per_pascal / GROUP.wheel_radius


def test_groups_of_a_shared_valve_use_the_lowest_or_the_mean_demand():
    law = with_shared_valves(slip_based(), GROUPS, (1, 2), "lowest")
    assert law.decide(observed((0.01, 0.01, 0.01), 1.0)) == (3e5, 3e5, 2e5)
    assert law.decide(observed((0.01, 0.2, 0.01), 1.0)) == (3e5, 0.0, 0.0)
    assert law.decide(observed((0.2, 0.01, 0.01), 1.0)) == (0.0, 3e5, 2e5)
    law = with_shared_valves(slip_based(), GROUPS, (1, 2), "mean")
    assert law.decide(observed((0.01, 0.2, 0.01), 1.0)) == pytest.approx((3e5, 1.5e5, 1e5))


def test_one_valve_for_each_group_changes_nothing():
    plain, shared = slip_based(), with_shared_valves(slip_based(), GROUPS, (1, 1, 1), "mean")
    for slip in ((0.01, 0.2, 0.07), (0.07, 0.01, 0.3), (0.0, 0.0, 0.0)):
        assert plain.decide(observed(slip, 0.5)) == shared.decide(observed(slip, 0.5))


def settled(law: Law, now: Observation) -> np.ndarray:
    """Return the demands after five seconds with the same observation."""
    for _ in range(5000):
        demands = law.decide(now)
    return np.array(demands)


def test_other_groups_replace_the_missing_force_of_a_sliding_group():
    """The total force is the driver's demand; each other group adds the same share of its reserve."""
    now = observed((0.2, 0.01, 0.01), 0.5)
    law = with_redistribution(slip_based(), GROUPS, period=1e-3, adhesion_max=0.3)
    demands = settled(law, now)
    assert demands[0] == 0.0
    assert force(demands) == pytest.approx(force(now.driver_demand), rel=1e-6)
    left = (demands[1:] - now.driver_demand[1:]) / (np.array([3e5, 2e5]) - now.driver_demand[1:])
    assert left[0] == pytest.approx(left[1])


def test_no_group_gives_more_than_the_limit_of_adhesion():
    now = observed((0.2, 0.01, 0.01), 0.3)
    law = with_redistribution(slip_based(), GROUPS, period=1e-3, adhesion_max=0.03)
    demands = settled(law, now)
    pad = (demands[1] * GROUP.piston_area - GROUP.spring_force) * GROUP.rigging
    adhesion = GROUP.units * PAD_FRICTION * GROUP.friction_radius * pad / GROUP.wheel_radius / GROUP.load
    assert demands[1] > now.driver_demand[1]
    assert adhesion == pytest.approx(0.03, rel=1e-6)


def test_with_full_brake_or_without_slip_nothing_is_redistributed():
    for slip, demand in (((0.2, 0.01, 0.01), 1.0), ((0.01, 0.01, 0.01), 0.5)):
        now = observed(slip, demand)
        demands = settled(with_redistribution(slip_based(), GROUPS, period=1e-3, adhesion_max=0.3), now)
        lower = np.minimum(slip_based().decide(now), now.driver_demand)
        assert demands == pytest.approx(lower)


def test_a_release_ends_after_its_longest_time_and_no_law_prevents_it():
    """Of the group whose sensor is dead only; for 1 s the driver's demand is applied, and then it starts again."""
    law = with_release_limit(slip_based(), GROUPS, period=0.1, release_max=2.0)
    second = np.array([law.decide(observed((1.0, 0.01, 0.01), 0.5)) for _ in range(62)])
    released = ([0.0] * 20 + [1.5e5] * 11) * 2
    assert second[:, 0] == pytest.approx(released)
    assert second[:, 1:] == pytest.approx(np.array([slip_based().decide(observed((0.01,) * 3, 0.5))] * 62)[:, 1:])


OVER_THE_TRAIN = pytest.mark.parametrize(
    "over",
    [
        lambda law: with_shared_valves(law, GROUPS, (1, 2), "lowest"),
        lambda law: with_shared_valves(law, GROUPS, (1, 2), "mean"),
        lambda law: with_redistribution(law, GROUPS, period=1e-3, adhesion_max=0.15),
        lambda law: with_release_limit(law, GROUPS, period=1e-3, release_max=0.02),
    ],
    ids=["lowest", "mean", "redistribution", "limit on releases"],
)


@OVER_THE_TRAIN
def test_redistribution_on_top_of_any_controller_equals_that_inside_a_law(over):
    """Bit for bit: the controller below may be a law, a class or an FMU."""
    inside, law, outside = over(slip_based()), slip_based(), over(pass_through(GROUPS))
    random = np.random.default_rng(3)
    for _ in range(200):
        now = observed(tuple(random.uniform(0.0, 0.2, 3)), random.uniform(0.1, 1.0))
        assert outside.decide(now, law.decide(now)) == inside.decide(now)


@OVER_THE_TRAIN
def test_a_law_starts_with_the_states_of_its_parameters(over):
    law = RecursiveSlope(GROUPS, RecursiveSlope.load_tuning("pneumatic", "estimated", period=10e-3))
    assert np.any(law.state != [state.start for state in law.formula.states])
    assert over(law).state[: law.state.size] == pytest.approx(law.state)


class _Timed(GroupLaw):
    """A law whose states have the names of those that are added to it."""

    description = "Brakes as demanded"

    @classmethod
    def demand(cls, draft, tuning, group):
        for name in (group.label("release_time"), *(["missing"] if group.index == 1 else [])):
            draft.keep(draft.state(name, "1", "of the law"), 7.0)
        return group.driver_demand


def test_states_of_a_law_may_have_the_names_of_those_that_are_added():
    law: Law = _Timed(GROUPS, _Timed.tuning_with(period=1e-3))
    law = with_redistribution(law, GROUPS, period=1e-3, adhesion_max=0.3)
    law = with_release_limit(law, GROUPS, period=1e-3, release_max=2.0)
    law.decide(observed((0.01, 0.01, 0.01), 1.0))
    states = dict(zip((state.name for state in law.formula.states), law.state, strict=True))
    assert [states[name] for name in ("missing", "release_time[1]", "release_time[3]")] == [7.0] * 3
    assert {"_missing", "_release_time[1]", "_release_time[3]"} <= states.keys()
