"""Fit the levels of the low-adhesion scenarios.

Schwarz, Posielek and Goetjes (2021) give the friction of their scenarios only as a figure without numbers, and do not
state their Polach parameters. One factor on the friction of each scenario is fitted, for each shape of the creep curve,
so that slip-based two-level control with ideal actuation and sensors stops in the distance of their Table 1. All other
entries of the table, above all those of adhesion-based control, are then predictions.
"""

import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from railgrip.base.files import write_text
from railgrip.campaign.workers import workers
from railgrip.scenario.load import load
from railgrip.simulate.run import braking_distance

TARGETS = {"trapezoid": 382.9, "sine_sweep": 316.2, "random": 339.6}
"""Braking distance of slip-based control [m]: Schwarz, Posielek and Goetjes (2021), Table 1."""

SHAPES = ("dry", "wet", "low_steep", "poor_wheelset_study")
"""Published shapes of the creep curve for which levels are fitted."""

LIBRARY = Path(__file__).parents[1] / "scenario" / "library"

_CLOSE = 0.05  # m: the table has tenths of a metre; the required bound is 1 %, some 3 m
_ROUNDS = 25


class FittedLevel(NamedTuple):
    """Scenario of the library, named Polach set, factor on the friction, and the resulting distance [m] of SBC."""

    scenario: str
    shape: str
    level: float
    distance: float


def calibrate(notify: Callable[[FittedLevel], None]) -> list[FittedLevel]:
    """Fit every level and write all of them to the scenario files of the library.

    Raises:
        ArithmeticError: The distance is not reached with a level from 0.3 to 3.
    """
    fits: list[FittedLevel] = []
    with workers(2) as pool:
        futures = [pool.submit(fit, scenario, shape) for scenario in TARGETS for shape in SHAPES]
        for answer in futures:
            fits.append(answer.result())
            notify(fits[-1])
    for scenario in TARGETS:
        path = LIBRARY / f"{scenario}.toml"
        levels = {fit.shape: fit.level for fit in fits if fit.scenario == scenario}
        write_text(path, with_levels(path.read_text(encoding="utf-8"), levels))
    return fits


def fit(scenario: str, shape: str, library: Path = LIBRARY) -> FittedLevel:
    """Find the level at which slip-based control stops in the published distance, by regula falsi (Illinois).

    Raises:
        ArithmeticError: The distance is not reached with a level from 0.3 to 3.
    """
    target = TARGETS[scenario]

    def excess(level: float) -> float:
        overrides = [
            "controller.kind=slip_two_state",
            "estimator.kind=none",
            f"adhesion.polach={shape}",
            f"adhesion.calibrated.{shape}={level!r}",
        ]
        distance = braking_distance(load(library / f"{scenario}.toml", overrides))
        # A train that slides until the horizon is on a rail that is far too slippery.
        return 1e3 if distance is None else distance - target

    low, high = 0.6, 1.6
    over, under = excess(low), excess(high)
    while over < 0.0 and low > 0.3:
        low *= 0.8
        over = excess(low)
    while under > 0.0 and high < 3.0:
        high *= 1.2
        under = excess(high)
    if over < 0.0 or under > 0.0:
        raise ArithmeticError(f"{scenario}, {shape}: no level between 0.3 and 3 stops in {target} m.")
    level, residual = low, over
    for _ in range(_ROUNDS):
        # The file has five digits; finer steps would change the distance by less than the tolerance.
        level = round(low + (high - low) * over / (over - under), 5)
        residual = excess(level)
        if abs(residual) < _CLOSE or high - low < 2e-5:
            break
        if residual > 0.0:
            low, over, under = level, residual, 0.5 * under
        else:
            high, under, over = level, residual, 0.5 * over
    return FittedLevel(scenario, shape, level, target + residual)


def with_levels(text: str, levels: dict[str, float]) -> str:
    """Return the text of a scenario file with other calibrated levels; all other lines are unchanged."""
    line = "calibrated = { " + ", ".join(f"{shape} = {level:.5f}" for shape, level in levels.items()) + " }"
    result, count = re.subn(r"(?m)^calibrated = .*$", line, text)
    if count != 1:
        raise ValueError("a scenario of the library has exactly one line 'calibrated = …' in [adhesion]")
    return result
