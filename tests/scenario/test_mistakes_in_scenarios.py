"""Plausible mistakes in a scenario are refused, announced, or leave the scenario as it is.

Each mistake turns a correct scenario into one that a person may well write: another unit, per cent for a share, a
frequency for a period, a reversed list. Correct values are drawn; where a mistake is only noticed in a part of the
usual range, the draw states that part, and docs/limits_of_checks.md has the rest.
"""

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy
from sampling import FUZZ

from railgrip.base.errors import InputError, ScenarioError
from railgrip.base.registry import shelf
from railgrip.report.comparison import flat
from railgrip.scenario.load import load, scenario_of
from railgrip.scenario.schema import Scenario
from railgrip.simulate.assembly import assemble
from railgrip.simulate.remarks import remarks_after, remarks_before

Tables = dict[str, Any]

SAME = 1e-3
"""Relative change of a value up to which a stop is the same: published distances are rounded to more than this."""

LONGEST = 60.0, 1500.0
"""Duration [s] and distance [m] of a stop that is longer than any of the scenarios here."""


def numbers(low: float, high: float) -> SearchStrategy[float]:
    """Return numbers as people write them, with three digits."""
    return st.floats(low, high).map(lambda value: float(f"{value:.3g}"))


@dataclass(frozen=True)
class Mistake:
    """A mistake at a key.

    Attributes:
        key: Path of the key, with zero-based indices of lists.
        correct: Strategy for correct values in SI units.
        wrong: Function from the correct value to the one written by mistake.
        base: Scenario of the library with that key, or extra tables of `EXTRA`.
    """

    key: str
    correct: SearchStrategy[Any]
    wrong: Callable[[Any], Any]
    base: str = "plain"


EXTRA: dict[str, Tables] = {
    "hill": {"track": {"gradient": [{"begin": 0.0, "slope": 0.0}], "curve": [{"begin": 0.0, "radius": 500.0}]}},
    "patches": {
        "adhesion": {
            "patch": [
                {"begin": 50.0, "length": 20.0, "mu0": 0.04},
                {"begin": 120.0, "length": 20.0, "mu0": 0.04},
            ]
        }
    },
    "conditioned": {"adhesion": {"conditioning": {"fraction": 0.1, "recovered": 0.13, "by": "group"}}},
    "points": {
        "adhesion": {
            "kind": "points",
            "polach": "wet",
            "over": "distance",
            "points": [[0.0, 0.1], [100.0, 0.05], [400.0, 0.1]],
        }
    },
    "sanded": {
        "adhesion": {"sand": {"mu0": 0.2, "density": 0.008, "left": 0.6}},
        "sanders": [{"wheelset": 3, "rate": 0.03, "delay": 0.6, "begin": 2.0, "end": 8.0}],
    },
    "driven": {
        "demand": {
            "phases": [
                {"pressure": 0.0, "traction": {"force": 6e4, "power": 8e5}, "until": {"time": 10.0}},
                {"pressure": 1e5, "until": {"time": 15.0}},
                {"pressure": "full"},
            ]
        }
    },
    "target": {"demand": {"phases": [{"stop_at": {"distance": 700.0, "deceleration": 0.6, "full_deceleration": 1.2}}]}},
    "faulty": {
        "faults": [
            {"part": "radar", "kind": "dead", "begin": 3.0, "end": 5.0},
            {"part": "transducer", "kind": "scaled", "group": 1, "value": 0.8},
        ]
    },
    "untrue": {"truth": {"load": [1.0], "pad_friction": [1.0], "wheel_radius": [1.0]}},
    "thresholds": {
        "controller": {"kind": "slip_two_state", "tuning": "paper", "parameters": {"low": 0.1, "high": 0.15}}
    },
}
"""Name → tables that are overlaid on the scenario `plain`."""


@cache
def _base(name: str) -> Tables:
    tables = load(shelf("scenarios")[name if name in shelf("scenarios") else "plain"]).tables()
    tables["estimator"], tables["controller"] = {"kind": "none"}, {"kind": "slip_three_state"}
    for table, keys in EXTRA.get(name, {}).items():
        replaced = keys.get("kind") if isinstance(keys, dict) else None
        tables[table] = {**(tables.get(table) or {}), **keys} if isinstance(keys, dict) and not replaced else keys
    return tables


def _with(tables: Tables, key: str, value: Any) -> Tables:
    changed = copy.deepcopy(tables)
    *path, last = [int(part) if part.isdigit() else part for part in key.split(".")]
    at: Any = changed
    for part in path:
        if isinstance(at[part], tuple):
            at[part] = list(at[part])
        at = at[part]
    at[last] = value
    return changed


def percent(value: float) -> float:
    return 100.0 * value


def percent_sign(value: float) -> str:
    """Write a share with the sign of per cent after it."""
    return f"{value} %"


def milli(value: float) -> float:
    return 1e3 * value


def frequency(value: float) -> float:
    return 1.0 / value


def swapped(values: list[Any]) -> list[Any]:
    return values[::-1]


FRICTION = numbers(0.02, 0.3)
SHARE = numbers(0.02, 0.5)
ERROR = numbers(2e-3, 0.02)
PERIOD = st.sampled_from([0.001, 0.002, 0.005, 0.01, 0.02, 0.05])
STEP = PERIOD.filter(lambda period: period <= 0.01)  # slip control takes no longer ones

MISTAKES: dict[str, Mistake] = {
    "the speed in km/h as a bare number": Mistake("start.speed", numbers(45 / 3.6, 150 / 3.6), lambda v: 3.6 * v),
    "the speed in km/h with the unit m/s": Mistake(
        "start.speed", numbers(45 / 3.6, 150 / 3.6), lambda v: f"{3.6 * v} m/s"
    ),
    "friction in per cent": Mistake("adhesion.mu0", FRICTION, percent),
    "a share of friction with the sign of per cent": Mistake("adhesion.mu0", FRICTION, percent_sign),
    "friction ten times as high": Mistake("adhesion.mu0", numbers(0.07, 0.3), lambda v: 10 * v),
    "the level in per cent": Mistake("adhesion.level", numbers(0.5, 1.5), percent),
    "the level as the difference to 1": Mistake("adhesion.level", numbers(0.8, 1.19), lambda v: round(v - 1, 3)),
    "conditioning in per cent": Mistake("adhesion.conditioning.fraction", numbers(0.02, 0.4), percent, "conditioned"),
    "a share of conditioning with the sign of per cent": Mistake(
        "adhesion.conditioning.fraction", numbers(0.02, 0.4), percent_sign, "conditioned"
    ),
    "the friction of the clean rail in per cent": Mistake(
        "adhesion.conditioning.recovered", numbers(0.1, 0.4), percent, "conditioned"
    ),
    "the period of the plant as a frequency": Mistake("periods.communication", STEP, frequency),
    "the period of the controller as a frequency": Mistake("periods.controller", PERIOD, frequency),
    "the period of the estimator as a frequency": Mistake("periods.estimator", PERIOD, frequency),
    "the period of the plant in ms": Mistake("periods.communication", STEP.filter(lambda v: v > 0.001), milli),
    "the period of the controller in ms": Mistake("periods.controller", PERIOD.filter(lambda v: v > 0.001), milli),
    "the gradient in per mille as a bare number": Mistake(
        "track.gradient.0.slope", numbers(0.001, 0.035), milli, "hill"
    ),
    "the gradient in per cent as a bare number": Mistake(
        "track.gradient.0.slope", numbers(0.001, 0.035), percent, "hill"
    ),
    "per cent of a gradient for per mille": Mistake(
        "track.gradient.0.slope", numbers(0.0041, 0.035), lambda v: f"{1e3 * v} %", "hill"
    ),
    "the angle of a gradient for its tangent": Mistake(
        "track.gradient.0.slope", numbers(0.001, 0.035), lambda v: f"{math.degrees(math.atan(v))} deg", "hill"
    ),
    "the radius of a curve in km": Mistake("track.curve.0.radius", numbers(150, 9000), lambda v: v / 1e3, "hill"),
    "the curvature for the radius": Mistake("track.curve.0.radius", numbers(150, 9000), lambda v: 1.0 / v, "hill"),
    "the force of the track in kN": Mistake("track.force", numbers(1e3, 9e4), lambda v: v / 1e3),
    "the maximum adhesion in per cent": Mistake("limits.alpha_max", SHARE, percent),
    "a share of adhesion with the sign of per cent": Mistake("limits.alpha_max", SHARE, percent_sign),
    "the speed of standstill in km/h": Mistake("limits.stop_speed", numbers(0.3, 1.0), lambda v: 3.6 * v),
    "slips in per cent": Mistake("controller.parameters.low", numbers(0.02, 0.1), percent, "thresholds"),
    "a share of slip with the sign of per cent": Mistake(
        "controller.parameters.low", numbers(0.02, 0.14), percent_sign, "thresholds"
    ),
    "thresholds of slip exchanged": Mistake("controller.parameters", st.just({"low": 0.1, "high": 0.15}),
        lambda v: {"low": v["high"], "high": v["low"]}, "thresholds"),
    "the demand in bar": Mistake("demand.phases.1.pressure", numbers(5e4, 3e5), lambda v: v / 1e5, "driven"),
    "the demand in kPa": Mistake("demand.phases.1.pressure", numbers(5e4, 3e5), lambda v: v / 1e3, "driven"),
    "the demand in MPa with the unit bar": Mistake(
        "demand.phases.1.pressure", numbers(5e4, 3e5), lambda v: f"{v / 1e6} Pa", "driven"
    ),
    "the demand in bar with the unit MPa": Mistake(
        "demand.phases.1.pressure", numbers(5e4, 3e5), lambda v: f"{v / 1e5} MPa", "driven"
    ),
    "traction in kN": Mistake("demand.phases.0.traction.force", numbers(2e4, 3e5), lambda v: v / 1e3, "driven"),
    "power in kW": Mistake("demand.phases.0.traction.power", numbers(1e5, 6e6), lambda v: v / 1e3, "driven"),
    "times of phases in reversed order": Mistake(
        "demand.phases.1.until.time", numbers(11, 30), lambda v: v - 10.5 if v < 20 else v - 20, "driven"
    ),
    "a deceleration in km/h a second": Mistake(
        "demand.phases.0.stop_at.deceleration", numbers(0.35, 1.2), lambda v: 3.6 * v, "target"
    ),
    "a deceleration in per cent of g": Mistake(
        "demand.phases.0.stop_at.deceleration", numbers(0.2, 1.2), lambda v: 100 * v / 9.81, "target"
    ),
    "the end of a patch for its length": Mistake(
        "adhesion.patch.0.length", numbers(21, 60), lambda v: 50 + v, "patches"
    ),
    "places of patches in km": Mistake(
        "adhesion.patch",
        st.tuples(numbers(5, 60), numbers(100, 300), numbers(2, 30)).map(
            lambda v: [{"begin": begin, "length": v[2], "mu0": 0.04} for begin in v[:2]]
        ),
        lambda patches: [{**patch, "begin": patch["begin"] / 1e3} for patch in patches],
        "patches",
    ),
    "places of patches as chainages": Mistake(
        "adhesion.patch.1.begin", numbers(100, 300), lambda v: 12350 + v, "patches"
    ),
    "friction of wheelsets from the rear": Mistake(
        "adhesion.mu0", st.lists(FRICTION, min_size=6, max_size=6, unique=True).map(sorted), swapped
    ),
    "columns of points exchanged": Mistake(
        "adhesion.points", st.just([[0.0, 0.1], [100.0, 0.05], [400.0, 0.1]]),
        lambda points: [point[::-1] for point in points], "points",
    ),
    "points in the reversed order": Mistake(
        "adhesion.points", st.just([[0.0, 0.1], [100.0, 0.05], [400.0, 0.1]]), swapped, "points"
    ),
    "points as chainages": Mistake(
        "adhesion.points", numbers(5e3, 1e5), lambda v: [[v, 0.1], [v + 100.0, 0.05]], "points"
    ),
    "friction of points in per cent": Mistake(
        "adhesion.points", st.just([[0.0, 0.1], [100.0, 0.05], [400.0, 0.1]]),
        lambda points: [[place, 100 * friction] for place, friction in points], "points",
    ),
    "k_A and k_S exchanged": Mistake(
        "adhesion.polach", st.tuples(numbers(0.3, 1.0), numbers(0.05, 0.25)).map(
            lambda k: {"k_A": k[0], "k_S": k[1], "A": 0.4, "B": 0.2}),
        lambda curve: {**curve, "k_A": curve["k_S"], "k_S": curve["k_A"]},
    ),
    "B in s/km": Mistake(
        "adhesion.polach", numbers(0.1, 1.0).map(lambda b: {"k_A": 0.3, "k_S": 0.1, "A": 0.4, "B": b}),
        lambda curve: {**curve, "B": 1e3 * curve["B"]},
    ),
    "A in per cent": Mistake(
        "adhesion.polach", numbers(0.1, 0.5).map(lambda a: {"k_A": 0.3, "k_S": 0.1, "A": a, "B": 0.2}),
        lambda curve: {**curve, "A": percent(curve["A"])},
    ),
    "a difference of load for the factor": Mistake(
        "truth.load", numbers(0.8, 1.29), lambda v: round(v - 1.0, 3), "untrue"
    ),
    "the load in per cent": Mistake("truth.load", numbers(0.8, 1.3), percent, "untrue"),
    "the friction of pads for the factor": Mistake("truth.pad_friction", numbers(0.8, 1.2),
        lambda v: round(0.29 * v / 1.2, 3), "untrue"),
    "the radius of wheels in mm for the factor": Mistake(
        "truth.wheel_radius", numbers(0.9, 1.0), lambda v: 430.0 * v, "untrue"
    ),
    "the radius of wheels in m for the factor": Mistake(
        "truth.wheel_radius", numbers(0.9, 1.0), lambda v: round(0.35 * v, 3), "untrue"
    ),
    "the begin of a fault in ms": Mistake("faults.0.begin", numbers(1, 4), milli, "faulty"),
    "begin and end of a fault exchanged": Mistake("faults.0.end", numbers(5, 20), lambda v: 3.0 - v / 10, "faulty"),
    "a fault of a group counted from 0": Mistake("faults.1.group", st.just(1), lambda v: v - 1, "faulty"),
    "a fault of a group that does not exist": Mistake("faults.1.group", st.just(4), lambda v: v + 1, "faulty"),
    "a factor of a fault in per cent": Mistake("faults.1.value", numbers(0.5, 1.5), percent, "faulty"),
    "the wheelset of a sander counted from 0": Mistake("sanders.0.wheelset", st.just(1), lambda v: v - 1, "sanded"),
    "the wheelset of a sander beyond the last": Mistake("sanders.0.wheelset", st.just(6), lambda v: v + 1, "sanded"),
    "the rate of a sander in g/s": Mistake("sanders.0.rate", numbers(5e-3, 0.06), milli, "sanded"),
    "the rate of a sander in kg/min": Mistake("sanders.0.rate", numbers(5e-3, 0.06), lambda v: 60 * v, "sanded"),
    "the delay of sand in ms": Mistake("sanders.0.delay", numbers(0.2, 3), milli, "sanded"),
    "times of a sander in ms": Mistake("sanders.0.begin", numbers(1, 7), milli, "sanded"),
    "sand that is left in per cent": Mistake("adhesion.sand.left", numbers(0.1, 0.9), percent, "sanded"),
    "the density of sand in g/m": Mistake("adhesion.sand.density", numbers(2e-3, 0.05), milli, "sanded"),
    "the period of the radar as a frequency": Mistake("sensors.speed.period", PERIOD, frequency, "degraded"),
    "the period of the radar in ms": Mistake(
        "sensors.speed.period", PERIOD.filter(lambda v: v > 0.001), milli, "degraded"
    ),
    "the latency of the radar in ms": Mistake("sensors.speed.latency", numbers(0.01, 0.2), milli, "degraded"),
    "the error of the scale in per cent": Mistake("sensors.speed.scale_error", ERROR, percent, "degraded"),
    "the error of the pitch in per cent": Mistake("sensors.wheel.pitch_error", ERROR, percent, "degraded"),
    "the clock in us": Mistake("sensors.wheel.clock", numbers(1e-6, 1e-5), lambda v: 1e6 * v, "degraded"),
    "full scale in bar": Mistake("sensors.pressure.full_scale", numbers(6e5, 2e6), lambda v: v / 1e5, "degraded"),
    "full scale in kPa": Mistake("sensors.pressure.full_scale", numbers(6e5, 2e6), lambda v: v / 1e3, "degraded"),
    "the lag of transducers in ms": Mistake("sensors.pressure.lag", numbers(5e-3, 0.1), milli, "degraded"),
    "the error of transducers in per cent": Mistake(
        "sensors.pressure.error", numbers(2e-3, 0.02), percent, "degraded"
    ),
    "the noise of deflections in mm": Mistake("sensors.deflection.noise", numbers(1e-4, 1e-3), milli, "degraded"),
    "the noise of accelerations in m/s2 as mm/s2": Mistake(
        "sensors.acceleration.noise", numbers(0.01, 0.2), milli, "degraded"
    ),
}  # fmt: skip


def scenario(tables: Tables) -> Scenario:
    return scenario_of(tables, directory=Path.cwd(), origin="mine.toml")


def differ(first: Scenario, second: Scenario) -> bool:
    """Return whether any value differs by more than `SAME`."""
    a, b = flat(first.resolved()), flat(second.resolved())
    return a.keys() != b.keys() or any(_differs(a[key], b[key]) for key in a)


def _differs(a: Any, b: Any) -> bool:
    if isinstance(a, float) and isinstance(b, float):
        return not math.isclose(a, b, rel_tol=SAME)
    return a != b


def verdict(tables: Tables, correct: Scenario) -> str:
    """Return the fate of a scenario: refused, announced, unchanged, or unnoticed."""
    try:
        wrong = scenario(tables)
        if not differ(wrong, correct):
            return "unchanged"
        if remarks_before(wrong) or remarks_after(wrong, *LONGEST):
            return "announced"
        with assemble(wrong):
            pass
    except InputError:
        return "refused"
    return "unnoticed"


@pytest.mark.parametrize("name", sorted(MISTAKES))
def test_a_mistake_is_noticed(name: str) -> None:
    mistake = MISTAKES[name]

    @settings(max_examples=12 if FUZZ else 4, deadline=None, database=None, derandomize=True)
    @given(mistake.correct)
    def check(value: Any) -> None:
        base = _base(mistake.base)
        correct = scenario(base if name == "points as chainages" else _with(base, mistake.key, value))
        assert not remarks_before(correct), "a correct scenario has no remarks"
        found = verdict(_with(base, mistake.key, mistake.wrong(value)), correct)
        assert found != "unnoticed", f"{name}: {value}"

    check()


def test_a_creep_curve_that_exceeds_friction_is_refused() -> None:
    """The share of friction is 2/π (k_A ε/(1 + (k_A ε)²) + arctan(k_S ε)), Polach (2005), equation 6."""
    creep = np.logspace(-3, 5, 20001)
    for k_a, k_s in ((1.0, 1.0), (0.3, 0.3), (0.3, 0.1), (0.1, 0.12), (0.1, 0.3)):
        share = 2 / math.pi * (k_a * creep / (1 + (k_a * creep) ** 2) + np.arctan(k_s * creep))
        curve = {"k_A": k_a, "k_S": k_s, "A": 0.4, "B": 0.2}
        if share.max() <= 1.0:
            scenario(_with(_base("plain"), "adhesion.polach", curve))
            continue
        with pytest.raises(ScenarioError, match="would use more than mu0"):
            scenario(_with(_base("plain"), "adhesion.polach", curve))
    with pytest.raises(ScenarioError, match=r"\[truth\] creep raises k_S to 2"):
        scenario(_with(_base("plain"), "truth", {"creep": {"k_S": 5.0}}))


@pytest.mark.parametrize("name", sorted({"plain", "trapezoid", "sine_sweep", "random", "degraded", "service_steps"}))
def test_scenarios_of_the_library_have_no_remarks(name: str) -> None:
    assert remarks_before(load(shelf("scenarios")[name])) == []
