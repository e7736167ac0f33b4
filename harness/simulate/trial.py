"""Short runs of a plant before its stop, which check map, units, signs and parameters.

A foreign train coasts, then brakes fully on a good rail. Ratios that physics determines are compared: distance over the
integral of the speed, speed over that of the acceleration, speed of the train over that of its wheels. A run on a poor
rail checks whether friction bounds the deceleration.

Wheel radius and creep curve are read back from outputs. A compiler that drops a modifier leaves parameters at their
defaults without an error: the FMU has the parameter, but its contacts have another value. That value follows from
relations between outputs: slip is (v - r w)/sqrt(v² + v_small²), and adhesion that of the contact law at slip, speed,
load and mu0.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from railgrip.base.arrays import Matrix
from railgrip.base.errors import FmuError
from railgrip.base.units import GRAVITY, mistake
from railgrip.simulate.loop.parts import LoopPlant
from railgrip.simulate.loop.plausible import Slowing
from railgrip.trace.contact import Contact
from railgrip.vehicle.signals import CURVE, Layout

_COAST, _BRAKE = 0.5, 5.0  # s; a cylinder of a passenger train is full after 3 to 5 s (UIC 540)
GOOD_RAIL = 0.4
POOR_RAIL = 0.01
"""Friction for 0.1 m/s2, which is less than any full brake, and too large to be rounded to 0."""
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


def run_trial(
    layout: Layout,
    plant: LoopPlant,
    *,
    period: float,
    release: tuple[float, ...],
    brake: tuple[float, ...],
    friction: float = GOOD_RAIL,
) -> Trial:
    """Let a plant coast and brake fully, until it has lost half of its speed or after 5 s.

    Args:
        layout: Layout of the plant's vectors.
        plant: Plant that has not been started.
        period: Its communication period [s].
        release: Command of each group that releases the brakes.
        brake: Full brake command of each group.
        friction: Friction of the rail.

    Raises:
        PlantFailed: The plant refused a step.
    """
    command = layout.input["command"]
    inputs = np.zeros(layout.inputs)
    inputs[command], inputs[layout.input["mu0"]] = release, friction
    set_curve(layout, inputs)
    rows = [plant.start(inputs)]
    coasting = max(round(_COAST / period), 2)
    rows += [plant.step(inputs) for _ in range(coasting)]
    inputs[command] = brake
    speed = layout.output["speed"].start
    for _ in range(max(round(_BRAKE / period), 2)):
        rows.append(plant.step(inputs))
        if abs(rows[-1][speed]) < 0.5 * abs(rows[0][speed]):
            break
    return Trial(layout=layout, rows=np.array(rows), coasting=coasting + 1, period=period)


def set_curve(layout: Layout, inputs: Matrix) -> None:
    """Set the inputs for the creep curve, if the plant has them, to that of a dry rail."""
    for name, place in layout.input.items():
        if name in _CURVE:
            inputs[place] = _CURVE[name]


Trials = tuple[Trial, Trial]
"""Trials on a good rail and on a poor one."""


def on_both_rails(opening: Callable[[], AbstractContextManager[LoopPlant]], layout: Layout, **how: Any) -> Trials:
    """Return the trials of a plant on a good rail and on a poor one, opened for each; `how` as for `run_trial`."""

    def on(friction: float) -> Trial:
        with opening() as plant:
            return run_trial(layout, plant, friction=friction, **how)

    return on(GOOD_RAIL), on(POOR_RAIL)


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
        yield SignalCheck(signal="pressure_command", good=False, sentence=sentence)
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
        yield SignalCheck(signal=f"cylinder_pressure[{g + 1}]", good=False, sentence=sentence)
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


Matrix = NDArray[np.float64]

RADIUS_TOLERANCE = 1e-3
"""Relative tolerance of the radius.

A solver's slip is accurate to 1e-6 or better, and half a millimetre is the smallest wear that users set.
"""
ADHESION_TOLERANCE = 1e-3
"""Relative to mu0: the same, and the load is rounded by the square of 50 N over it.

Published creep curves differ a hundred times as much somewhere below `_SLIDING`.
"""
_SLIDING = 0.1
_WALKING = 2.0  # m/s; twenty times the speed below which slip is regularised
_MAX_FILLING_TIME = (
    4.0  # s; passenger trains fill cylinders in 3 to 5 s (UIC 540), on this rail wheels slide before that
)
_RAIL = 0.06
_ADVICE = "the compiler lost a modifier: report it with the compiler's version, or use the other compiler."
V_SMALL = 0.1  # m/s, of a plant that does not declare it: RailBraking.Components.Wheelsets


def probe_outputs(
    plant: LoopPlant, layout: Layout, *, period: float, brake: tuple[float, ...], curve: Mapping[str, float]
) -> Matrix:
    """Return the outputs of a plant that brakes on a poor rail until its wheels slide, one row per sample.

    Args:
        plant: Plant that has not been started.
        layout: Layout of its vectors.
        period: Its communication period [s].
        brake: Full brake command of each group.
        curve: Polach's four numbers, for a plant with inputs for them.

    Raises:
        PlantFailed: The plant refused a step.
    """
    inputs = np.zeros(layout.inputs)
    inputs[layout.input["command"]], inputs[layout.input["mu0"]] = brake, _RAIL
    for signal, value in zip(CURVE, curve.values(), strict=True):
        if signal.name in layout.input:
            inputs[layout.input[signal.name]] = value
    rows = [plant.start(inputs).copy()]
    slip, speed = layout.output["slip"], layout.output["speed"].start
    for _ in range(round(_MAX_FILLING_TIME / period)):
        rows.append(plant.step(inputs).copy())
        if np.nanmin(rows[-1][slip]) > _SLIDING or rows[-1][speed] < 0.5 * rows[0][speed]:
            break
    return np.array(rows)


def require_radius(file: str, layout: Layout, rows: Matrix, expected: tuple[float, ...], v_small: float) -> None:
    """Compare the radius of each group's contacts with the expected one [m].

    Args:
        file: Name of the FMU.
        layout: Layout of the plant's vectors.
        rows: Outputs of the plant, one row per sample.
        expected: Expected radius of each group [m].
        v_small: Speed below which slip is regularised [m/s].

    Raises:
        FmuError: A radius differs.
    """
    first = rows[0]
    v, w, slip = (first[layout.output[name]] for name in ("speed", "wheelset_speed", "slip"))
    if not np.all(w > 0.0):
        return  # at rest no speed reveals a radius; the same FMU is checked when it starts moving
    found = (v - slip * np.sqrt(v**2 + v_small**2)) / w
    for g, (here, there) in enumerate(zip(found.tolist(), expected, strict=True)):
        if abs(here / there - 1.0) > RADIUS_TOLERANCE:
            raise FmuError(
                f"{file}: the contacts of group {g + 1} have a wheel radius of {here:.6g} m by slip[{g + 1}], speed "
                f"and wheelset_speed[{g + 1}], its parameter r_wheel is {there:.6g} m; {_ADVICE}"
            )


def require_curve(
    file: str, layout: Layout, rows: Matrix, contacts: tuple[Contact, ...], curve: Mapping[str, float]
) -> None:
    """Compare the adhesion of each wheelset with that of the expected creep curve.

    Args:
        file: Name of the FMU.
        layout: Layout of the plant's vectors.
        rows: Outputs of the plant on the rail of the probe, one row per sample.
        contacts: Contact law of each group, with the expected curve.
        curve: Expected curve, by the names of the plant's parameters.

    Raises:
        FmuError: The curve differs.
    """
    group_of = np.repeat(np.arange(layout.formation.groups), layout.formation.wheelsets_per_group)
    speed = rows[:, layout.output["speed"]][:, 0]
    slip, adhesion, load = (rows[:, layout.output[name]] for name in ("slip", "adhesion", "wheelset_load"))
    for i, g in enumerate(group_of):
        rail = np.full(len(rows), _RAIL)
        expected = contacts[g](slip[:, g], speed, load[:, i], rail)
        # At walking pace the regularisation of the slip matters, and a probe from there does not reveal the curve.
        error = np.where(speed > _WALKING, np.abs(adhesion[:, i] - expected), 0.0)
        worst = int(np.argmax(error))
        if error[worst] > ADHESION_TOLERANCE * _RAIL:
            values = ", ".join(f"{name} = {value:g}" for name, value in curve.items())
            raise FmuError(
                f"{file}: adhesion[{i + 1}] is {adhesion[worst, i]:.6g} at slip {slip[worst, g]:.4g} and mu0 "
                f"{_RAIL:g}, by the creep curve of the scenario ({values}) it is {expected[worst]:.6g}; {_ADVICE}"
            )
