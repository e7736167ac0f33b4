"""Short runs of a plant before its stop, which check map, units, signs and the order of groups.

A foreign train coasts, then brakes fully on a good rail. Ratios that physics determines are compared: distance over the
integral of the speed, speed over that of the acceleration, speed of the train over that of its wheels. A run on a poor
rail checks whether friction bounds the deceleration.

In a stop all groups get nearly the same commands and friction, so that a map that exchanges two of them, or counts from
the rear, would go unnoticed. In further runs, some groups are braked and the others are not, then all are braked and
some are on a poor rail. Run k selects the groups whose number has bit k set: only the right order of signals passes all
runs. There are log2 of the number of groups.
"""

import math
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace

import numpy as np

from railgrip.base.arrays import Mask, Matrix, Vector
from railgrip.base.units import GRAVITY, mistake
from railgrip.simulate.loop.interfaces import LoopPlant
from railgrip.simulate.loop.plausible import Slowing
from railgrip.vehicle.signals import Layout

_COAST, _BRAKE = 0.5, 5.0  # s; a cylinder of a passenger train is full after 3 to 5 s (UIC 540)
GOOD_RAIL = 0.4
POOR_RAIL = 0.01
"""Friction for 0.1 m/s2, which is less than any full brake, and too large to be rounded to 0."""
LONGEST_TRIAL = 20.0
"""Time of the FMU that no trial exceeds [s]."""
_CLOSE = 0.01  # m/s2; resolution of a speed in steps of 0.1 km/h, over 5 s
_CURVE = {"curve_k_A": 1.0, "curve_k_S": 0.4, "curve_A": 0.4, "curve_B": 0.6}
"""Polach (2005), dry."""
_WEAR = 0.08
"""Difference of radius between a new wheel and a worn one; a larger one looks like a wheel in slide."""
_ATMOSPHERE = (0.85e5, 1.1e5)
"""Pressure of the air at places of railways [Pa]."""
_LOCKED = 0.3
"""Share of the speed of rolling below which a wheel is locked, or about to be."""
_MIN_DECELERATION = 0.1  # m/s2; the weakest full brakes of freight trains reach 0.3


@dataclass(frozen=True, slots=True, kw_only=True)
class SignalCheck:
    """Result of the run for one signal.

    Attributes:
        signal: Signal of the harness.
        good: Whether it agrees with the expectation.
        sentence: Values, and the expectation.
        ratio: Value over expected value; NaN where a ratio has no meaning.
    """

    signal: str
    good: bool
    sentence: str
    ratio: float = math.nan


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trial:
    """The outputs of a plant that coasted and braked.

    Attributes:
        layout: Layout of the plant's vectors.
        rows: A row for each sample, with the outputs in the order of `layout`; NaN for outputs that the plant lacks.
        coasting: Number of rows before the brakes were applied.
        period: Period of the samples [s].
    """

    layout: Layout
    rows: Matrix
    coasting: int
    period: float

    def output(self, name: str) -> Matrix:
        """Return an output at every sample, shape (samples, elements)."""
        return self.rows[:, self.layout.output[name]]

    @property
    def deceleration(self) -> float:
        """Mean deceleration in braking [m/s2]."""
        speed = self.output("speed")[:, 0]
        return float((speed[self.coasting - 1] - speed[-1]) / ((len(speed) - self.coasting) * self.period))


Trials = tuple[Trial, Trial]
"""Trials on a good rail and on a poor one."""


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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TrialPlant:
    """A plant for short runs, each of which opens it; all raise `PlantFailed` if it refuses a step.

    Attributes:
        opening: Function that opens the plant, not started.
        layout: Layout of its vectors.
        period: Its communication period [s].
        release: Command of each group that releases the brakes.
        brake: Full brake command of each group.
    """

    opening: Callable[[], AbstractContextManager[LoopPlant]]
    layout: Layout
    period: float
    release: tuple[float, ...]
    brake: tuple[float, ...]

    def trials(self) -> Trials:
        """Return the trials on a good rail and on a poor one."""
        return self.run(GOOD_RAIL), self.run(POOR_RAIL)

    def run(self, friction: float) -> Trial:
        """Let the plant coast and brake fully on a rail, until it has lost half of its speed or after 5 s."""
        inputs, coasting = self._released(friction), max(round(_COAST / self.period), 2)
        speed = self.layout.output["speed"].start
        with self.opening() as plant:
            rows = [plant.start(inputs)]
            rows += [plant.step(inputs) for _ in range(coasting)]
            inputs[self.layout.input["command"]] = self.brake
            for _ in range(max(round(_BRAKE / self.period), 2)):
                rows.append(plant.step(inputs))
                if abs(rows[-1][speed]) < 0.5 * abs(rows[0][speed]):
                    break
        return Trial(layout=self.layout, rows=np.array(rows), coasting=coasting + 1, period=self.period)

    def orders(self) -> Iterator[OrderRun]:
        """Yield the runs that identify each group."""
        groups = self.layout.formation.groups
        for bit in range((groups - 1).bit_length()):
            with self.opening() as plant:
                yield self._order(plant, (np.arange(groups) >> bit & 1).astype(bool))

    def force_finding(self, mass: float, *, is_known: bool) -> SignalCheck:
        """Return the finding of a run in which a force pushes the rolling train.

        The force is 5 % of the weight of a train of this mass; acceleration with and without it gives the mass.

        Args:
            mass: Mass of the train [kg].
            is_known: Whether it is that of this train; else a guess, and any mass of a vehicle is right.
        """
        inputs, steps = self._released(GOOD_RAIL), max(round(1.0 / self.period), 2)
        speed, force = self.layout.output["speed"].start, _FORCE * 9.81 * mass
        with self.opening() as plant:
            speeds = [plant.start(inputs)[speed]]
            speeds += [plant.step(inputs)[speed] for _ in range(steps)]
            inputs[self.layout.input["track_force"]] = force
            speeds += [plant.step(inputs)[speed] for _ in range(steps)]
        gained = (speeds[-1] - 2.0 * speeds[steps] + speeds[0]) / (steps * self.period)
        found = float(force / gained) if gained else np.inf
        low, high = _LIGHTEST, _HEAVIEST
        if is_known:
            low, high = (1.0 - _MASS_TOLERANCE) * mass, (1.0 + _MASS_TOLERANCE) * mass
        return SignalCheck(
            signal="track_force",
            good=bool(low <= found <= high),
            sentence=f"of {force:.4g} N forward accelerates the train by {gained:.4g} m/s2, as one of {found:.4g} kg; "
            f"{low:.3g} to {high:.3g} kg are expected: look at its unit and sign",
            ratio=float(mass / found),
        )

    def _released(self, friction: float) -> Vector:
        """Return inputs that release the brakes, on a rail with this friction and the creep curve of a dry rail."""
        inputs = np.zeros(self.layout.inputs)
        for name, value in ({"command": self.release, "mu0": friction} | _CURVE).items():
            if name in self.layout.input:
                inputs[self.layout.input[name]] = value
        return inputs

    def _order(self, plant: LoopPlant, selected: Mask) -> OrderRun:
        layout, places, inputs = self.layout, self.layout.input, self._released(GOOD_RAIL)
        plant.start(inputs)

        def hold(duration: float, ended: Callable[[Vector], bool] = lambda row: False) -> Vector:
            row = plant.step(inputs).copy()
            for _ in range(round(duration / self.period)):
                if ended(row):
                    break
                row = plant.step(inputs).copy()
            return row

        rolling = hold(_COAST_BEFORE_ORDERS)
        inputs[places["command"]] = np.where(selected, self.brake, self.release)
        pressure, speed = layout.output["cylinder_pressure"], layout.output["speed"].start
        enough = _FILLED * np.array(self.brake)[selected]
        braked = hold(_SELECTED, lambda row: bool(np.all(row[pressure][selected] > enough) and np.all(enough > 1.0)))
        run = OrderRun(layout=layout, selected=selected, rolling=rolling, braked=braked, alone=braked, sliding=braked)

        def slides(row: Vector) -> bool:
            return bool(np.all(run.slip(row)[selected] > _SLIDES) or row[speed] < 0.5 * rolling[speed])

        inputs[places["mu0"]] = POOR_RAIL
        alone = hold(_ALL, slides)
        inputs[places["command"]] = self.brake
        inputs[places["mu0"]] = np.where(selected[layout.formation.group_of_wheelset], POOR_RAIL, GOOD_RAIL)
        # Wheels of the selected groups slide at once; pressures of the others have to build up.
        sliding = hold(_ALL, lambda row: slides(row) and bool(row[pressure].min() > _FILLED * row[pressure].max()))
        return replace(run, alone=alone, sliding=sliding)


def findings(
    trial: Trial, poor: Trial, *, speed: float, radius: tuple[float, ...], pressure: tuple[float, ...], slowing: Slowing
) -> tuple[SignalCheck, ...]:
    """Return the findings of two trials; signals that the plant lacks have none.

    Args:
        trial: Trial on a rail of `GOOD_RAIL`.
        poor: Trial on a rail of `POOR_RAIL`.
        speed: Requested initial speed [m/s].
        radius: Wheel radius of each group that the harness assumes [m].
        pressure: Full brake cylinder pressure of each group [Pa].
        slowing: Bounds of the train's deceleration by other causes than adhesion.
    """
    return (
        *_of_train(trial, poor, speed, slowing),
        *(finding for g in range(len(radius)) for finding in _of_group(trial, g, radius[g], pressure[g])),
        *_of_wheelsets(trial),
    )


def _of_train(trial: Trial, poor: Trial, speed: float, slowing: Slowing) -> Iterator[SignalCheck]:
    v, x, a = (trial.output(name)[:, 0] for name in ("speed", "distance", "acceleration"))
    last, braking = trial.coasting - 1, trial.deceleration
    yield _ratio("speed", v[0], speed, 0.001, "m/s at the start, [start] speed is")
    yield _ratio("distance", x[-1] - x[0], float(np.trapezoid(v, dx=trial.period)), 0.01, "m, its speed gives")
    sentence = f"full brakes slow the train by {braking:.3g} m/s2, {_MIN_DECELERATION:g} and more is expected"
    yield SignalCheck(signal="pressure_command", good=braking >= _MIN_DECELERATION, sentence=sentence)
    wheels = trial.output("wheelset_speed")
    if np.all(wheels[-1] < _LOCKED * wheels[last] * (v[-1] / v[last])):
        sentence = f"locks all wheels on a rail with friction of {GOOD_RAIL:g}; full brakes of a train do not"
        yield _wrong("pressure_command", sentence)
    most = POOR_RAIL * GRAVITY + slowing.maximum(speed) + _CLOSE
    sentence = (
        f"does not bound the brakes: they slow the train by {braking:.3g} m/s2 with friction of {GOOD_RAIL:g} and by "
        f"{poor.deceleration:.3g} m/s2 with {POOR_RAIL:g}, where {most:.3g} or less is expected; give brakes on the "
        "rail itself in [vehicle.formation] track_brakes"
    )
    yield SignalCheck(signal="mu0", good=poor.deceleration <= most, sentence=sentence)
    loss, integral = v[-1] - v[last], float(np.trapezoid(a[last:], dx=trial.period))
    if abs(loss) > 0.1:
        yield _ratio("acceleration", integral, loss, 0.1, "m/s as its integral in braking, the speed changes by")


def _of_group(trial: Trial, g: int, radius: float, pressure: float) -> Iterator[SignalCheck]:
    """Yield the findings for a group with this radius [m] and full pressure [Pa], from the trial on a good rail."""
    last = trial.coasting - 1
    v, wheel, slip = (trial.output(name)[last, at] for name, at in (("speed", 0), ("wheelset_speed", g), ("slip", g)))
    rolling = v / wheel if wheel else math.inf
    words = f"m of radius by speed over wheel speed; controller and estimator assume {radius:.6g} m"
    near = abs(rolling / radius - 1) <= _WEAR
    hint = "" if near else _hint(radius / rolling)
    if not near and not hint:
        slipping = f"{100 * (1 - radius / rolling):.0f} %"
        hint = f": a constant slip of {slipping}; give the controller and the estimator this r_wheel"
    yield SignalCheck(signal=f"wheelset_speed[{g + 1}]", good=near, sentence=f"rolls with {rolling:.6g} {words}{hint}")
    if not math.isnan(slip):
        braking = trial.output("slip")[-1, g]
        good = abs(slip) <= 0.02 and braking > -0.005
        sentence = f"is {slip:.3g} coasting and {braking:.3g} in full braking; 0, and then above, is expected"
        yield SignalCheck(signal=f"slip[{g + 1}]", good=good, sentence=sentence)
    released, full = trial.output("cylinder_pressure")[[last, -1], g]
    if _ATMOSPHERE[0] < released < _ATMOSPHERE[1] and full > 1.2 * released:
        sentence = (
            f"is {released:.6g} Pa with the brake released, as an absolute pressure is; pressures here are those above "
            "the air's: subtract it in the FMU"
        )
        yield _wrong(f"cylinder_pressure[{g + 1}]", sentence)
    yield _ratio(f"cylinder_pressure[{g + 1}]", full, pressure, 0.5, "Pa of")


def _of_wheelsets(trial: Trial) -> Iterator[SignalCheck]:
    """Yield the findings for each wheelset whose adhesion the plant outputs, from the trial on a good rail."""
    for i, adhesion in enumerate(trial.output("adhesion")[-1]):
        if not math.isnan(adhesion):
            good = 0 < adhesion <= GOOD_RAIL * 1.01
            sentence = f"is {adhesion:.3g} in full braking; above 0 and at most mu0 = {GOOD_RAIL:g} is expected"
            yield SignalCheck(signal=f"adhesion[{i + 1}]", good=good, sentence=sentence)


def _ratio(signal: str, value: float, expected: float, tolerance: float, words: str) -> SignalCheck:
    """Compare a value with the expected one, within a relative tolerance, and name the mistake that fits the ratio."""
    ratio = value / expected if expected else math.inf
    good = abs(ratio - 1) <= tolerance
    return SignalCheck(
        signal=signal,
        good=good,
        sentence=f"has {value:.6g} {words} {expected:.6g}{'' if good else _hint(ratio)}",
        ratio=ratio,
    )


def _hint(ratio: float) -> str:
    likely = mistake(ratio)
    return f"; it looks like {likely}" if likely else ""


_COAST_BEFORE_ORDERS, _SELECTED, _ALL = 0.2, 2.0, 4.0  # s; of each part of a run
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
    remedy = "look at the order of {}, from the leading one on"
    if not any(count > 1 for count in run.layout.formation.groups_per_valve):
        for name, unit in (("cylinder_pressure", "Pa"), ("brake_torque", "N.m")):
            values = run.output(run.braked, name)
            if _are_exchanged(values, run.selected):
                found = f"is {_list(values)} {unit} while only group {selected} is braked"
                yield _wrong(name, f"{found}; {remedy.format('groups')}")
    torque = run.output(run.braked, "brake_torque")[run.selected]
    if np.any(torque < 0.0):
        found = f"is {_list(torque)} N.m on the braked group {selected}"
        yield _wrong("brake_torque", f"{found}; a torque that brakes is positive")
    slip = run.slip(run.alone)
    if reacts and _are_exchanged(slip, run.selected):
        found = f"gives slips of {_list(slip)} while only group {selected} is braked on a poor rail"
        yield _wrong("wheelset_speed", f"{found}; {remedy.format('groups')}")
    slip = run.slip(run.sliding)
    if reacts and _are_exchanged(slip, run.selected):
        found = f"and wheelset_speed: slips are {_list(slip)} while only group {selected} is on a poor rail"
        yield _wrong("mu0", f"{found}; {remedy.format('wheelsets')}")
    elif reacts:
        yield from _slip(run, slip)
        adhesion, poor = run.output(run.sliding, "adhesion"), run.selected[run.layout.formation.group_of_wheelset]
        if np.isfinite(adhesion).all() and np.any(np.abs(adhesion[poor]) > _APART * POOR_RAIL):
            found = f"is {_list(adhesion)} while the wheelsets of group {selected} are on a rail with friction of"
            yield _wrong("adhesion", f"{found} {POOR_RAIL:g}; {remedy.format('wheelsets')}")


def _wrong(signal: str, sentence: str) -> SignalCheck:
    return SignalCheck(signal=signal, good=False, sentence=sentence)


def _slip(run: OrderRun, slip: Vector) -> Iterator[SignalCheck]:
    shown = run.output(run.sliding, "slip")
    # Over the wheel's speed instead of the train's, a slip of s is s/(1 - s).
    other = slip / np.maximum(1.0 - slip, _CREEP)
    near = [np.abs(shown - expected) <= _CREEP + 0.1 * np.abs(expected) for expected in (slip, other)]
    if np.isfinite(shown).all() and not np.all(near[0] | near[1]):
        found = f"is {_list(shown)}, by speed and wheel speeds it is {_list(slip)}"
        yield _wrong("slip", f"{found}; look at unit, sign and order of groups")


def _are_exchanged(values: Vector, selected: Mask) -> bool:
    """Return whether values that are high for selected groups only are high for others."""
    if not np.isfinite(values).all() or selected.all():
        return False
    high, low = values[selected], values[~selected]
    # Values that hardly differ do not identify a group, as of one command for the whole train.
    spread = values.max() > _APART * max(values.min(), 0.0) and values.max() > 0.0
    return bool(spread and high.min() < low.max())


def _list(values: Vector) -> str:
    return ", ".join(f"{value:.3g}" for value in values)
