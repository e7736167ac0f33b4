"""The contracts of `railgrip.testing` for parts of users: built-in parts satisfy them, and violations are reported."""

from contextlib import nullcontext

import numpy as np
import pytest
from users_parts import Drag, Exact, Hold

import railgrip as rg
from railgrip.base import registry
from railgrip.base.errors import ContractBroken
from railgrip.controllers.law import GroupLaw
from railgrip.testing import check_controller, check_estimator, check_sensors


class Ours:
    """A built-in law, which is created for its brakes, behind the protocol of controllers."""

    def __init__(self, make, needs=()):
        self.make, self.needs = make, needs

    def start(self, formation):
        self.law = self.make(formation.brakes)

    def decide(self, observation):
        return self.law.decide(observation)


@pytest.mark.parametrize("kind", registry.modules(registry.LAWS))
def test_built_in_laws_satisfy_the_contract(kind):
    law = registry.part(registry.LAWS, kind, GroupLaw)
    tuning = law.load_tuning("ideal", "read", period=1e-3, pressure_lag=0.0, adhesion_max=0.15)
    check_controller(lambda: Ours(lambda brakes: law(brakes, tuning), law.needs))


class Forgetful(Hold):
    def start(self, formation):
        if not hasattr(self, "calls"):
            self.calls = 0
        self.p_max = formation.pressure_max

    def decide(self, observation):
        self.calls += 1
        return self.p_max / self.calls


def like(part, **changed):
    """Return a part with other members."""
    return type("Own", (part,), changed)


def fails_on(condition):
    """Return a law that fails where a condition of the observation is true."""

    def decide(self, seen):
        if condition(seen):
            raise ValueError("cannot go on")
        return self.demand

    return like(Hold, decide=decide)


def decides(decide):
    return like(Hold, decide=decide)


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        (Forgetful, "something else after a second start"),
        (decides(lambda self, seen: np.zeros(4)), r"shape \(4,\)"),
        (decides(lambda self, seen: 3 * self.demand), "demands 570000 Pa; a cylinder takes"),
        (decides(lambda self, seen: seen.slip), r"NaN .* np\.nan_to_num"),
        (decides(lambda self, seen: seen.pressure.sort()), "read-only"),
        (decides(lambda self, seen: self.demand * (seen.adhesion > 0)), "TypeError"),
        (object, "has no method start and decide"),
        (fails_on(lambda seen: np.isnan(seen.slip).any()), r"fails on slip = \[nan"),
        (fails_on(lambda seen: np.isnan(seen.speed)), "fails on speed = nan;"),
        (fails_on(lambda seen: np.isnan(seen.wheelset_speed).any()), r"fails on wheelset_speed = \[nan"),
        (fails_on(lambda seen: seen.adhesion is None), "fails on adhesion = None;"),
        (fails_on(lambda seen: seen.pad_friction is None), "fails on pad_friction = None;"),
        (fails_on(lambda seen: seen.speed == 0.0), "fails on speed = 0.0;"),
        (
            fails_on(lambda seen: np.isnan(seen.speed) or np.isnan(seen.slip).any()),
            r"fails on speed = nan, slip = \[nan",
        ),
        (decides(lambda self, seen: seen.slip * self.demand), r"nan.*It fails on slip = \[nan"),
    ],
)
def test_a_broken_controller_is_reported_with_the_inputs_it_fails_on(broken, words):
    with pytest.raises(ContractBroken, match=words):
        check_controller(broken)


def test_no_input_is_named_for_a_law_that_fails_on_all():
    with pytest.raises(ContractBroken) as broken:
        check_controller(fails_on(lambda seen: True))
    assert "fails on" not in str(broken.value)


class Reckoned(Drag):
    provides = ("adhesion", "adhesion_sd")

    def step(self, observation):
        adhesion = super().step(observation).adhesion
        return rg.Estimate(adhesion=adhesion, adhesion_sd=0.1 * adhesion)


def turn(seen, n):
    """Return whether it is the turn of each of n groups, 0.3 s each."""
    return np.arange(n) == int(seen.time / 0.3) % max(n, 2)


@pytest.mark.parametrize(
    ("provides", "value", "words"),
    [
        ("adhesion", lambda seen, n: np.where(turn(seen, n), -0.1, 0.08), None),
        ("adhesion", lambda seen, n: np.full(n, -0.001), None),
        ("pad_friction", lambda seen, n: np.where(turn(seen, n), -0.1, 0.35), None),
        ("speed", lambda seen, n: seen.speed - 0.2, None),
        ("slip", lambda seen, n: seen.slip - np.where(turn(seen, n), 1.0, 0.0), None),
        ("adhesion", lambda seen, n: np.where(np.arange(n) == n - 1, -0.1, 0.08), "adhesion is positive in braking"),
        ("pad_friction", lambda seen, n: np.full(n, -0.35), "friction of pads is positive"),
        ("speed", lambda seen, n: -seen.speed, "other sign"),
        ("slip", lambda seen, n: -seen.slip, "positive in braking"),
    ],
)
def test_an_estimate_may_be_negative_for_a_moment_but_not_throughout(provides, value, words):
    """Each group of an honest estimate may be below zero in its turn."""
    step = lambda self, seen: rg.Estimate(**{provides: value(seen, self.n)})
    own = like(Reckoned, provides=(provides,), step=step)
    with nullcontext() if words is None else pytest.raises(ContractBroken, match=words):
        check_estimator(own)


@pytest.mark.parametrize(
    ("check", "part"), [(check_controller, Hold), (check_estimator, Reckoned), (check_sensors, Exact)]
)
def test_the_parts_that_the_broken_ones_extend_are_accepted(check, part):
    check(part)


@pytest.mark.parametrize(
    ("check", "part", "changed", "words"),
    [
        (check_estimator, Reckoned, {"step": lambda self, seen: rg.Estimate(adhesion=np.zeros(self.n))}, "it provides"),
        (
            check_estimator, Reckoned,
            {"step": lambda self, seen: rg.Estimate(adhesion=seen.slip, adhesion_sd=-seen.slip)}, "negative adh",
        ),
        (check_estimator, Reckoned, {"provides": ()}, "`provides` is"),
        (check_sensors, Exact, {"read": lambda self, time, truth: {}}, "no reading at all"),
        (check_sensors, Exact, {"read": lambda self, time, truth: {"speed": np.random.rand()}}, "something else after"),
        (check_sensors, Exact, {"read": lambda self, time, truth: {"speed": np.ones(2)}}, r"shape \(2,\)"),
        (check_estimator, Reckoned, {"provides": "adhesion"}, "`provides` is 'adhesion'"),
    ],
)  # fmt: skip
def test_a_broken_part_is_reported(check, part, changed, words):
    with pytest.raises(ContractBroken, match=words):
        check(like(part, **changed))
