"""Fit the levels of the low-adhesion scenarios to published braking distances.

Schwarz, Posielek and Goetjes (2021) give the friction of their scenarios only as a figure without numbers, and do not
state their Polach parameters. One factor on the friction of each scenario is fitted, for each shape of the creep curve,
so that slip-based two-level control with ideal actuation and sensors stops in the distance of their Table 1. All other
entries of the table, above all those of adhesion-based control, are then predictions.
"""

import re
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import typer

from railgrip.base.files import write_text
from railgrip.base.records import make_folder
from railgrip.base.registry import shelf
from railgrip.campaign.workers import workers
from railgrip.report.console import progress, say
from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.load import load
from railgrip.simulate.run import braking_distance

TARGETS = {
    one.match["scenario"].removeprefix("identified_"): one.distance
    for one in load_campaign(shelf("campaigns")["identified"]).references
    if one.match["controller"] == "slip_two_state"
}
"""Scenario → braking distance of slip-based control in Table 1 [m], to which its level is fitted."""

SHAPES = ("dry", "wet", "low_steep", "poor_wheelset_study")
"""Published shapes of the creep curve for which levels are fitted."""

_CLOSE = 0.05  # m: the table has tenths of a metre; the required bound is 1 %, some 3 m
_ROUNDS = 25


class FittedLevel(NamedTuple):
    """Scenario of the library, named Polach set, factor on the friction, and the resulting distance [m] of SBC."""

    scenario: str
    shape: str
    level: float
    distance: float


def calibrate(
    scenario: Annotated[
        Literal["trapezoid", "sine_sweep", "random"] | None,
        typer.Option(help="The only scenario to fit; all unless given."),
    ] = None,
    out: Annotated[
        Path, typer.Option(help="Folder of the scenario files.", show_default="the library of the project")
    ] = Path("harness/scenario/library"),
) -> None:
    """Fit the levels of the scenarios to the published distances."""
    make_folder(out)
    levels: dict[str, dict[str, float]] = {name: {} for name in ([scenario] if scenario else TARGETS)}
    with progress("levels", "some ten stops each"), workers(2) as pool:
        for answer in [pool.submit(fit, name, shape) for name in levels for shape in SHAPES]:
            name, shape, level, distance = answer.result()
            levels[name][shape] = level
            say(f"{name}, {shape}: level {level:.5f}, {distance:.1f} m (target {TARGETS[name]} m)")
    for name, of_shapes in levels.items():
        text = shelf("scenarios")[name].read_text(encoding="utf-8")
        write_text(out / f"{name}.toml", with_levels(text, of_shapes))


def fit(scenario: str, shape: str) -> FittedLevel:
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
        distance = braking_distance(load(shelf("scenarios")[scenario], overrides))
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
