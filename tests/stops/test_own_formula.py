"""A user's law that is a formula runs in C like the built-in ones, and stops as the same law in Python does."""

import sys
from dataclasses import dataclass
from typing import Annotated

import casadi as ca
import numpy as np
import pytest

import railgrip as rg
from railgrip.controllers.law import GroupLaw, Tuning
from railgrip.controllers.sampled import Sampled, choose
from railgrip.simulate.assembly import assemble
from railgrip.simulate.user_parts import CustomParts

MODULE = """from dataclasses import dataclass
from typing import Annotated

from railgrip.controllers.law import FULL_PRESSURE, GroupLaw, Tuning
from railgrip.controllers.sampled import choose


@dataclass(frozen=True, kw_only=True)
class Level(Tuning):
    threshold: Annotated[float, "1", "slip above which a group is vented"] = 0.15


class Threshold(GroupLaw):
    description = "One threshold of slip"
    brake_data = FULL_PRESSURE
    tuning = Level

    @classmethod
    def demand(cls, draft, tuning, group):
        return choose(group.slip < tuning["threshold"], group.brake["pressure_max"], 0.0)
"""
NAMED = "extends = 'trapezoid'\nname = 'own'\n[controller]\nkind = 'own_formula:Threshold'\nparameters = {level}\n"


class ThresholdInPython:
    """The law of MODULE."""

    def __init__(self, threshold=0.15):
        self.threshold = threshold

    def start(self, formation):
        self.full = formation.pressure_max

    def decide(self, observation):
        return np.where(observation.slip < self.threshold, self.full, 0.0)


@pytest.fixture
def scenario(tmp_path, monkeypatch):
    monkeypatch.delitem(sys.modules, "own_formula", raising=False)
    (tmp_path / "own_formula.py").write_text(MODULE, encoding="utf-8")

    def load(level="{ threshold = '10 %' }"):
        (tmp_path / "own.toml").write_text(NAMED.replace("{level}", level), encoding="utf-8")
        return rg.Scenario.load(tmp_path / "own.toml")

    return load


NOTED = Annotated[float, "1", ""]


def law(demand, **attributes):
    """Return a class of a formula whose demand is a function of the draft, the parameters and the group."""
    body = {"description": "", "demand": staticmethod(demand)}
    return type("Own", (GroupLaw,), body | attributes)


def remember(draft, name):
    state = draft.state(name, "s", "")
    draft.keep(state, state)
    return state


def tuning(kind, value):
    return dataclass(frozen=True)(type("Own", (Tuning,), {"__annotations__": {"threshold": kind}, "threshold": value}))


def full_if(condition, group):
    return choose(condition, group.brake["pressure_max"], 0.0)


def test_a_formula_stops_as_the_same_law_in_python_and_its_parameters_have_units(scenario, tmp_path):
    named, trapezoid = scenario(), rg.Scenario.load("trapezoid")
    with assemble(named, objects=CustomParts(folders=(tmp_path,))) as opened:
        assert isinstance(opened.parts.controller, Sampled)
    stop = rg.run(named, import_from=tmp_path)
    in_python = rg.run(trapezoid, controller=ThresholdInPython(0.1))
    assert stop.metrics.distance == in_python.metrics.distance


def vented():
    return law(lambda _, tuning, group: full_if(group.slip < tuning["threshold"], group), tuning=tuning(NOTED, 0.15))


def test_a_formula_satisfies_the_contract_of_controllers():
    rg.testing.check_controller(vented())
    for demand, message in (
        (lambda _, __, group: group.slip * 1e9, r"Own\.demand \(.*test_own_formula\.py, line \d+\) returned \[nan"),
        (lambda _, __, group: group.nothing, r"Own\.demand failed in .*test_own_formula\.py, line \d+: AttributeError"),
        (lambda _, __, group: "a", r"Own\.demand \(.*test_own_formula\.py, line \d+\) failed: TypeError"),
    ):
        with pytest.raises(rg.testing.ContractBroken, match=message):
            rg.testing.check_controller(law(demand))


def test_a_sweep_changes_the_parameters_of_a_formula():
    axes = {"controller.parameters.threshold": [0.05, 0.1]}
    distances = [
        rg.sweep(rg.Scenario.load("trapezoid"), axes, controller=each).to_pandas()["distance"].tolist()
        for each in (vented(), ThresholdInPython)
    ]
    assert distances[0] == distances[1]


def test_demands_are_limited_to_the_brake_and_a_missing_slip_brakes_fully(scenario):
    """In the short run slips are .01 and .6; before the first reading of a stop they are NaN."""

    def demand(draft, tuning, group):
        full, slip = group.brake["pressure_max"], group.slip
        return choose(slip < 0.02, full, choose(slip > 0.5, 0.5 * full, slip * 1e9))

    stop = rg.run(rg.Scenario.load("trapezoid"), controller=law(demand))
    demands = stop.trace["demand"].values
    assert stop.outcome == "standstill"
    assert np.nanmin(demands) >= 0.0
    assert np.nanmax(demands) <= 4e5
    assert np.isfinite(demands).all()


SLIP = law(lambda _, __, group: group.slip)
REFUSED = {
    "nan": (law(lambda _, __, group: group.slip * float("nan")), "Own demands .*nan.* Pa in a short run, at slips of"),
    "negative": (law(lambda _, __, group: -1.0 + 0.0 * group.slip), "expected are 0 to"),
    "signal": (law(lambda _, __, group: group.speed_of_sound), "does not give a formula: .*has no 'speed_of_sound'"),
    "parameter": (law(lambda _, tuning, __: tuning["low"]), "does not give a formula: .*'low'"),
    "tuning": (type("Own", (SLIP,), {"tuning": None}), "does not give a formula: .*'units'"),
    "needs": (law(lambda _, __, group: group.adhesion, needs=("adhesion",)), "needs estimates of adhesion"),
    "unknown": (type("Own", (SLIP,), {"needs": ("speed_of_sound",)}), "`needs` is .*expected are names of"),
    "number": (type("Own", (SLIP,), {"needs": 3}), "`needs` is 3"),
    "chain": (law(lambda _, __, group: full_if(0 < group.slip < 1, group)), "formula: Python's if, and, .* use choose"),
    "max": (law(lambda _, __, group: max(0.0, group.slip)), "Python's if, and, .* casadi.fmax"),
    "none": (law(lambda *_: None), r"demand\[1\] is None, but one number"),
    "vector": (law(lambda _, __, group: ca.vertcat(group.slip, 0)), r"demand\[1\] is SX\(.* but one number"),
    "condition": (law(lambda _, __, group: group.slip < 0.1), r"demand\[1\] is the condition .*slip.*; `choose`"),
    "either": (law(lambda _, __, group: ca.logic_or(group.slip < 0.1, group.speed < 1)), "is the condition"),
    "true": (law(lambda *_: True), "is the condition True; `choose`"),
    "incomplete": (type("Own", (GroupLaw,), {"description": ""}), r"Own has no classmethod demand\(cls, draft, tun"),
    "twice": (law(lambda draft, *_: remember(draft, "time")), "the state 'time' is declared twice; `group.label`"),
    "forgotten": (
        law(lambda draft, _, group: draft.state(group.label("t"), "s", "")),
        r"no next value of t\[1\], t\[2\]",
    ),
    "annotation": (law(lambda *_: 0.0, tuning=tuning(float, 1.0)), r"Own: threshold: write Annotated\[float"),
    "text": (law(lambda *_: 0.0, tuning=tuning(NOTED, "high")), "Own: threshold must be finite .*, got 'high' 1"),
    "huge": (law(lambda *_: 0.0, tuning=tuning(NOTED, 10**400)), "threshold must be finite"),
    "driver": (type("Own", (SLIP,), {"exceeds_driver": True}), "have an effect only in laws of railgrip"),
    "valves": (type("Own", (SLIP,), {"valve_band": 1e4}), "leave them out"),
    "train": (law(lambda _, __, group: full_if(group.train[0].slip < 0.1, group)), None),
    "order": (
        law(lambda _, __, group: full_if(group.train[-group.index].slip < 0.1, group)),
        "lowers the pressure of group 4 while the wheels of group 1 slide",
    ),
}


@pytest.mark.parametrize(("own", "sentence"), REFUSED.values(), ids=REFUSED)
def test_a_formula_that_cannot_brake_is_refused(own, sentence):
    scenario = rg.Scenario.load("trapezoid", {"estimator": {"kind": "none"}})
    if sentence is None:
        assert rg.run(scenario, controller=own).outcome == "standstill"
        return
    with pytest.raises(rg.RailgripError, match=sentence):
        rg.run(scenario, controller=own)


@pytest.mark.parametrize(
    ("level", "sentence"),
    [
        ("{ threshold = '10 bar' }", "threshold"),
        ("{ threshold = [1, 2] }", r"threshold is \[1, 2\], but a number"),
        ("{ threshold = -1.0 }", "Level: threshold must be finite and not negative"),
        ("{ level = 1.0 }", "has no parameter 'level'; there is threshold"),
    ],
)
def test_a_wrong_parameter_of_a_formula_is_named(scenario, tmp_path, level, sentence):
    with pytest.raises(rg.RailgripError, match=sentence):
        rg.run(scenario(level), import_from=tmp_path)
