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
from wrong import change
from wrong import table as stored

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


TABLES = stored(__file__, "tables.toml")
EXTRA: dict[str, Tables] = TABLES["extra"]
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
    change(changed, key, value)
    return changed


def milli(value: float) -> float:
    return 1e3 * value


def frequency(value: float) -> float:
    return 1.0 / value


def swapped(values: list[Any]) -> list[Any]:
    return values[::-1]


def _scaled(key: str, range: list[float], factor: float = 1.0, unit: str = "", base: str = "plain") -> Mistake:
    """Return a mistake by which numbers within a range are multiplied by a factor, or have a unit."""
    return Mistake(key, numbers(*range), lambda v: f"{factor * v} {unit}" if unit else factor * v, base)


FRICTION = numbers(0.02, 0.3)
PERIOD = st.sampled_from([0.001, 0.002, 0.005, 0.01, 0.02, 0.05])
STEP = PERIOD.filter(lambda period: period <= 0.01)  # slip control takes no longer ones

MISTAKES: dict[str, Mistake] = {name: _scaled(**row) for name, row in TABLES["mistakes"].items()} | {
    "the level as the difference to 1": Mistake("adhesion.level", numbers(0.8, 1.19), lambda v: round(v - 1, 3)),
    "the period of the plant as a frequency": Mistake("periods.communication", STEP, frequency),
    "the period of the controller as a frequency": Mistake("periods.controller", PERIOD, frequency),
    "the period of the estimator as a frequency": Mistake("periods.estimator", PERIOD, frequency),
    "the period of the plant in ms": Mistake("periods.communication", STEP.filter(lambda v: v > 0.001), milli),
    "the period of the controller in ms": Mistake("periods.controller", PERIOD.filter(lambda v: v > 0.001), milli),
    "the angle of a gradient for its tangent": Mistake(
        "track.gradient.0.slope", numbers(0.001, 0.035), lambda v: f"{math.degrees(math.atan(v))} deg", "hill"
    ),
    "the curvature for the radius": Mistake("track.curve.0.radius", numbers(150, 9000), lambda v: 1.0 / v, "hill"),
    "thresholds of slip exchanged": Mistake("controller.parameters", st.just({"low": 0.1, "high": 0.15}),
        lambda v: {"low": v["high"], "high": v["low"]}, "thresholds"),
    "times of phases in reversed order": Mistake(
        "demand.phases.1.until.time", numbers(11, 30), lambda v: v - 10.5 if v < 20 else v - 20, "driven"
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
        lambda curve: {**curve, "A": 100 * curve["A"]},
    ),
    "a difference of load for the factor": Mistake(
        "truth.load", numbers(0.8, 1.29), lambda v: round(v - 1.0, 3), "untrue"
    ),
    "the friction of pads for the factor": Mistake("truth.pad_friction", numbers(0.8, 1.2),
        lambda v: round(0.29 * v / 1.2, 3), "untrue"),
    "the radius of wheels in m for the factor": Mistake(
        "truth.wheel_radius", numbers(0.9, 1.0), lambda v: round(0.35 * v, 3), "untrue"
    ),
    "begin and end of a fault exchanged": Mistake("faults.0.end", numbers(5, 20), lambda v: 3.0 - v / 10, "faulty"),
    "a fault of a group counted from 0": Mistake("faults.1.group", st.just(1), lambda v: v - 1, "faulty"),
    "a fault of a group that does not exist": Mistake("faults.1.group", st.just(4), lambda v: v + 1, "faulty"),
    "the wheelset of a sander counted from 0": Mistake("sanders.0.wheelset", st.just(1), lambda v: v - 1, "sanded"),
    "the wheelset of a sander beyond the last": Mistake("sanders.0.wheelset", st.just(6), lambda v: v + 1, "sanded"),
    "the period of the radar as a frequency": Mistake("sensors.speed.period", PERIOD, frequency, "degraded"),
    "the period of the radar in ms": Mistake(
        "sensors.speed.period", PERIOD.filter(lambda v: v > 0.001), milli, "degraded"
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


def test_a_gradient_behind_the_end_of_the_stop_is_remarked():
    made = load("plain", ["track.gradient=[{begin=0, slope=0.01}, {begin=300, slope=0.02}]"])
    assert remarks_after(made, 20.0, 250.0) == [
        "plain: [track.gradient[2]] had no effect: it begins at 300 m, and the stop ended at 250 m."
    ]
