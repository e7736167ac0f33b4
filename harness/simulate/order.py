"""Short runs of a plant in which groups of wheelsets differ, which check the order of groups in its signals.

In a stop all groups get nearly the same commands and friction, so that a map that exchanges two of them, or counts from
the rear, would go unnoticed. Here, some groups are braked and the others are not, then all are braked and some are on a
poor rail. Run k selects the groups whose number has bit k set: only the right order of signals passes all runs. There
are log2 of the number of groups.
"""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace

import numpy as np

from railgrip.base.arrays import Mask, Vector
from railgrip.simulate.loop.parts import LoopPlant
from railgrip.simulate.trial import GOOD_RAIL, POOR_RAIL, SignalCheck, Trial, set_curve
from railgrip.vehicle.signals import Layout

_COAST, _SELECTED, _ALL = 0.2, 2.0, 4.0  # s; of each part of a run
_FILLED = 0.3
"""Share of full pressure at which cylinders differ clearly."""
_SLIDES = 0.3
"""Slip at which wheels slide clearly."""
_APART = 2.0
"""Ratio of two values that differ clearly."""
_FORCE = 0.05
"""Force along the track in the run that tests it, over the weight of the train."""
_LIGHTEST, _HEAVIEST = 1e3, 2e7  # kg
_MASS_TOLERANCE = 0.4
"""Relative difference of two statements of a mass; rotating parts add up to 30 %."""
_CREEP = 0.05
"""Difference of two definitions of slip at small slip, from the speed at which they are regularised."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OrderRun:
    """Outputs of a run in which groups differ.

    Attributes:
        layout: Layout of the plant's vectors.
        selected: Groups that were braked alone, and then were on a poor rail, shape (groups,).
        rolling: Outputs at the end of coasting.
        braked: Outputs at the end of the part in which only selected groups were braked, on a good rail.
        alone: Outputs at the end of the part in which only selected groups were braked, on a poor rail.
        sliding: Outputs at the end of the part in which only selected groups were on a poor rail.
    """

    layout: Layout
    selected: Mask
    rolling: Vector
    braked: Vector
    alone: Vector
    sliding: Vector

    def output(self, row: Vector, name: str) -> Vector:
        """Return the elements of an output in a row."""
        return row[self.layout.output[name]]

    def slip(self, row: Vector) -> Vector:
        """Return the slip of each group by speeds, shape (groups,), with radii by the speeds at the end of coasting."""
        rolling, now = (self.output(r, "wheelset_speed") / self.output(r, "speed") for r in (self.rolling, row))
        return 1.0 - now / rolling


def run_orders(
    opening: Callable[[], AbstractContextManager[LoopPlant]],
    layout: Layout,
    *,
    period: float,
    release: tuple[float, ...],
    brake: tuple[float, ...],
) -> list[OrderRun]:
    """Return the runs that identify each group, of plants opened for each; arguments as of `trial.run_trial`.

    Raises:
        PlantFailed: The plant refused a step.
    """
    groups = layout.formation.groups
    runs: list[OrderRun] = []
    for bit in range((groups - 1).bit_length()):
        selected = (np.arange(groups) >> bit & 1).astype(bool)
        with opening() as plant:
            runs.append(_run(layout, plant, selected, period=period, release=release, brake=brake))
    return runs


def _run(
    layout: Layout, plant: LoopPlant, selected: Mask, *, period: float, release: tuple[float, ...],
    brake: tuple[float, ...],
) -> OrderRun:  # fmt: skip
    places, inputs = layout.input, np.zeros(layout.inputs)
    inputs[places["command"]], inputs[places["mu0"]] = release, GOOD_RAIL
    set_curve(layout, inputs)
    plant.start(inputs)

    def hold(duration: float, ended: Callable[[Vector], bool] = lambda row: False) -> Vector:
        row = plant.step(inputs).copy()
        for _ in range(round(duration / period)):
            if ended(row):
                break
            row = plant.step(inputs).copy()
        return row

    rolling = hold(_COAST)
    inputs[places["command"]] = np.where(selected, brake, release)
    pressure, speed = layout.output["cylinder_pressure"], layout.output["speed"].start
    enough = _FILLED * np.array(brake)[selected]
    braked = hold(_SELECTED, lambda row: bool(np.all(row[pressure][selected] > enough) and np.all(enough > 1.0)))
    run = OrderRun(layout=layout, selected=selected, rolling=rolling, braked=braked, alone=braked, sliding=braked)

    def slides(row: Vector) -> bool:
        return bool(np.all(run.slip(row)[selected] > _SLIDES) or row[speed] < 0.5 * rolling[speed])

    inputs[places["mu0"]] = POOR_RAIL
    alone = hold(_ALL, slides)
    inputs[places["command"]] = brake
    inputs[places["mu0"]] = np.where(selected[layout.formation.group_of_wheelset], POOR_RAIL, GOOD_RAIL)
    # Wheels of the selected groups slide at once; pressures of the others have to build up.
    sliding = hold(_ALL, lambda row: slides(row) and bool(row[pressure].min() > _FILLED * row[pressure].max()))
    return replace(run, alone=alone, sliding=sliding)


def reacts(good: Trial, poor: Trial) -> bool:
    """Return whether all wheels slide in a trial on a poor rail, and none do in one on a good rail."""

    def slip(trial: Trial) -> Vector:
        ratio = trial.output("wheelset_speed") / trial.output("speed")
        return 1.0 - ratio[-1] / ratio[trial.coasting - 1]

    return bool(slip(poor).min() > max(_APART * slip(good).max(), _CREEP))


def order_findings(run: OrderRun, *, reacts: bool) -> Iterator[SignalCheck]:
    """Yield the contradictions of a run.

    Args:
        run: Run in which groups differ.
        reacts: Whether wheels on a poor rail slide, and those on a good one do not, when all are braked.
    """
    selected = ", ".join(str(group + 1) for group in np.flatnonzero(run.selected))
    if not any(count > 1 for count in run.layout.formation.groups_per_valve):
        for name, unit in (("cylinder_pressure", "Pa"), ("brake_torque", "N.m")):
            values = run.output(run.braked, name)
            if _are_exchanged(values, run.selected):
                yield SignalCheck(
                    signal=name,
                    good=False,
                    sentence=f"is {_list(values)} {unit} while only group {selected} is braked; look at the order of "
                    "groups, from the leading one on",
                )
    torque = run.output(run.braked, "brake_torque")[run.selected]
    if np.any(torque < 0.0):
        yield SignalCheck(
            signal="brake_torque",
            good=False,
            sentence=f"is {_list(torque)} N.m on the braked group {selected}; a torque that brakes is positive",
        )
    slip = run.slip(run.alone)
    if reacts and _are_exchanged(slip, run.selected):
        yield SignalCheck(
            signal="wheelset_speed",
            good=False,
            sentence=f"gives slips of {_list(slip)} while only group {selected} is braked on a poor rail; look at the "
            "order of groups, from the leading one on",
        )
    slip = run.slip(run.sliding)
    if reacts and _are_exchanged(slip, run.selected):
        yield SignalCheck(
            signal="mu0",
            good=False,
            sentence=f"and wheelset_speed: slips are {_list(slip)} while only group {selected} is on a poor rail; look "
            "at the order of wheelsets, from the leading one on",
        )
    elif reacts:
        yield from _slip(run, slip)
        yield from _adhesion(run, selected)


def _slip(run: OrderRun, slip: Vector) -> Iterator[SignalCheck]:
    shown = run.output(run.sliding, "slip")
    # Over the wheel's speed instead of the train's, a slip of s is s/(1 - s).
    other = slip / np.maximum(1.0 - slip, _CREEP)
    near = [np.abs(shown - expected) <= _CREEP + 0.1 * np.abs(expected) for expected in (slip, other)]
    if np.isfinite(shown).all() and not np.all(near[0] | near[1]):
        yield SignalCheck(
            signal="slip",
            good=False,
            sentence=f"is {_list(shown)}, by speed and wheel speeds it is {_list(slip)}; look at unit, sign and order "
            "of groups",
        )


def _adhesion(run: OrderRun, selected: str) -> Iterator[SignalCheck]:
    adhesion = run.output(run.sliding, "adhesion")
    poor = run.selected[run.layout.formation.group_of_wheelset]
    if np.isfinite(adhesion).all() and np.any(np.abs(adhesion[poor]) > _APART * POOR_RAIL):
        yield SignalCheck(
            signal="adhesion",
            good=False,
            sentence=f"is {_list(adhesion)} while the wheelsets of group {selected} are on a rail with friction of "
            f"{POOR_RAIL:g}; look at the order of wheelsets, from the leading one on",
        )


def _are_exchanged(values: Vector, selected: Mask) -> bool:
    """Return whether values that are high for selected groups only are high for others."""
    if not np.isfinite(values).all() or selected.all():
        return False
    high, low = values[selected], values[~selected]
    # Values that hardly differ do not identify a group, as of one command for the whole train.
    spread = values.max() > _APART * max(values.min(), 0.0) and values.max() > 0.0
    return bool(spread and high.min() < low.max())


def force_finding(
    opening: Callable[[], AbstractContextManager[LoopPlant]],
    layout: Layout,
    *,
    period: float,
    release: tuple[float, ...],
    mass: float,
    is_known: bool,
) -> SignalCheck:
    """Return the finding of a run in which a force pushes the rolling train.

    The force is 5 % of the weight of a train of this mass; acceleration with and without it gives the mass.

    Args:
        opening: Function that opens the plant, not started.
        layout: Layout of its vectors.
        period: Its communication period [s].
        release: Command of each group that releases the brakes.
        mass: Mass of the train [kg].
        is_known: Whether it is that of this train; else a guess, and any mass of a vehicle is right.

    Raises:
        PlantFailed: The plant refused a step.
    """
    inputs, steps = np.zeros(layout.inputs), max(round(1.0 / period), 2)
    inputs[layout.input["command"]], inputs[layout.input["mu0"]] = release, GOOD_RAIL
    set_curve(layout, inputs)
    speed, force = layout.output["speed"].start, _FORCE * 9.81 * mass
    with opening() as plant:
        speeds = [plant.start(inputs)[speed]]
        speeds += [plant.step(inputs)[speed] for _ in range(steps)]
        inputs[layout.input["track_force"]] = force
        speeds += [plant.step(inputs)[speed] for _ in range(steps)]
    gained = (speeds[-1] - 2.0 * speeds[steps] + speeds[0]) / (steps * period)
    found = float(force / gained) if gained else np.inf
    low, high = ((1.0 - _MASS_TOLERANCE) * mass, (1.0 + _MASS_TOLERANCE) * mass) if is_known else (_LIGHTEST, _HEAVIEST)
    return SignalCheck(
        signal="track_force",
        good=bool(low <= found <= high),
        sentence=f"of {force:.4g} N forward accelerates the train by {gained:.4g} m/s2, as one of {found:.4g} kg; "
        f"{low:.3g} to {high:.3g} kg are expected: look at its unit and sign",
        ratio=float(mass / found),
    )


def _list(values: Vector) -> str:
    return ", ".join(f"{value:.3g}" for value in values)
