"""The contracts of `railgrip.testing` for parts of users: built-in parts satisfy them, and violations are reported."""

from contextlib import nullcontext

import numpy as np
import pytest

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


class Good:
    def start(self, formation):
        self.demand = formation.pressure_max / 2

    def decide(self, observation):
        return self.demand


class Forgetful(Good):
    def start(self, formation):
        if not hasattr(self, "calls"):
            self.calls = 0
        self.p_max = formation.pressure_max

    def decide(self, observation):
        self.calls += 1
        return self.p_max / self.calls


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        (Forgetful, "something else after a second start"),
        (type("FourGroups", (Good,), {"decide": lambda self, seen: np.zeros(4)}), r"shape \(4,\)"),
        (
            type("Beyond", (Good,), {"decide": lambda self, seen: 3 * self.demand}),
            "demands 570000 Pa; a cylinder takes",
        ),
        (
            type("Unread", (Good,), {"decide": lambda self, seen: seen.slip}),
            r"NaN .* np\.nan_to_num",
        ),
        (type("Writes", (Good,), {"decide": lambda self, seen: seen.pressure.sort()}), "read-only"),
        (type("Sure", (Good,), {"decide": lambda self, seen: self.demand * (seen.adhesion > 0)}), "TypeError"),
        (object, "has no method start and decide"),
    ],
)
def test_a_broken_controller_is_reported(broken, words):
    with pytest.raises(ContractBroken, match=words):
        check_controller(broken)


def test_the_controller_that_the_broken_ones_extend_is_accepted():
    check_controller(Good)


def fails_on(condition):
    """Return a law that fails where a condition of the observation is true."""

    def decide(self, seen):
        if condition(seen):
            raise ValueError("cannot go on")
        return self.demand

    return type("Picky", (Good,), {"decide": decide})


@pytest.mark.parametrize(
    ("condition", "named"),
    [
        (lambda seen: np.isnan(seen.slip).any(), r"fails on slip = \[nan"),
        (lambda seen: np.isnan(seen.speed), "fails on speed = nan;"),
        (lambda seen: np.isnan(seen.wheelset_speed).any(), r"fails on wheelset_speed = \[nan"),
        (lambda seen: seen.adhesion is None, "fails on adhesion = None;"),
        (lambda seen: seen.pad_friction is None, "fails on pad_friction = None;"),
        (lambda seen: seen.speed == 0.0, "fails on speed = 0.0;"),
        (lambda seen: np.isnan(seen.speed) or np.isnan(seen.slip).any(), r"fails on speed = nan, slip = \[nan"),
    ],
    ids=["slip", "speed", "wheelset speed", "adhesion", "pad friction", "standstill", "two of them"],
)
def test_the_inputs_that_a_law_fails_on_are_named(condition, named):
    with pytest.raises(ContractBroken, match=named):
        check_controller(fails_on(condition))


def test_the_input_of_a_law_that_returns_nan_for_nan_is_named():
    own = type("Unread", (Good,), {"decide": lambda self, seen: seen.slip * self.demand})
    with pytest.raises(ContractBroken, match=r"nan.*It fails on slip = \[nan"):
        check_controller(own)


def test_no_input_is_named_for_a_law_that_fails_on_all():
    with pytest.raises(ContractBroken) as broken:
        check_controller(fails_on(lambda seen: True))
    assert "fails on" not in str(broken.value)


class Reckoned:
    provides = ("adhesion", "adhesion_sd")

    def start(self, first, formation):
        self.n = formation.groups

    def step(self, observation):
        adhesion = np.full(self.n, -observation.acceleration / 9.81)
        return rg.Estimate(adhesion=adhesion, adhesion_sd=0.1 * adhesion)


def reckoned(name, step):
    return type(name, (Reckoned,), {"step": step})


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        (reckoned("Less", lambda self, seen: rg.Estimate(adhesion=np.zeros(self.n))), "it provides"),
        (reckoned("Sign", lambda self, seen: rg.Estimate(adhesion=seen.slip, adhesion_sd=-seen.slip)), "negative adh"),
        (type("Silent", (Reckoned,), {"provides": ()}), "`provides` is"),
    ],
)
def test_a_broken_estimator_is_reported(broken, words):
    check_estimator(Reckoned)
    with pytest.raises(ContractBroken, match=words):
        check_estimator(broken)


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
    own = type(
        "Own",
        (Reckoned,),
        {"provides": (provides,), "step": lambda self, seen: rg.Estimate(**{provides: value(seen, self.n)})},
    )
    with nullcontext() if words is None else pytest.raises(ContractBroken, match=words):
        check_estimator(own)


class Exact:
    def start(self, formation, random):
        self.random = random

    def read(self, time, truth):
        return {name: truth[name] for name in ("speed", "wheelset_speed", "acceleration", "cylinder_pressure")}


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        (type("Blind", (Exact,), {"read": lambda self, time, truth: {}}), "no reading at all"),
        (
            type("Own", (Exact,), {"read": lambda self, time, truth: {"speed": np.random.rand()}}),
            "something else after",
        ),
        (type("Two", (Exact,), {"read": lambda self, time, truth: {"speed": np.ones(2)}}), r"shape \(2,\)"),
    ],
)
def test_broken_sensors_are_reported(broken, words):
    check_sensors(Exact)
    with pytest.raises(ContractBroken, match=words):
        check_sensors(broken)
