"""Checks that the signals of a recording agree with each other and with the model: scale, timing and brake force.

A wrong unit, a late channel or another vehicle's data still give estimates, and often a better NIS than right ones,
because adhesion and pad friction absorb the error. Seven comparisons find them:

    origin       v is measured, and not r ω of an axle that slides, or of the fastest or the mean of them
    scale        r ω / v is near 1 while nothing brakes
    timing       r ω <= v while a train slows: a wheelset that turns faster than it rolls is recorded late
    brake force  m Δv + Σ J Δω / r = ∫ (F_external - Σ T_brake / r) dt
    brake delay  the lag at which both sides of this balance fit best is near 0
    release      pressures fall to 0 while the train coasts: absolute pressures do not
    acceleration a = dv/dt + g sin β, at the same time

The fourth is the balance of momentum with the adhesion between wheel and rail eliminated. It therefore holds in any
slide, as long as the wheelsets turn: samples with a locked wheelset are left out. Its tolerance covers gradients of
25 per mille where the track force is not recorded, loads of ±30 % and pad friction of 0.2 to 0.55.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, uniform_filter1d
from scipy.signal import savgol_filter

from railgrip.base.arrays import Mask
from railgrip.base.errors import EstimationError
from railgrip.base.names import ElementName
from railgrip.base.units import GRAVITY, mistake, unit
from railgrip.estimation.run import by_name
from railgrip.estimation.spec import Specification, equations_for, parameters_for, settings_for
from railgrip.estimators.belief import Vector
from railgrip.recording.samples import has_reading, period_of, readings_in, samples

BRAKES: Final[Mapping[str, float]] = {"pad_force": 1.5e3, "cylinder_pressure": 2e4}
"""Inputs that brake, and the value below which they do not brake [N, Pa], unless the estimation has a gate."""
APPLIED = 0.05
"""Share of the largest brake input above which the brake counts as applied."""
SETTLING = 1.5
"""Time after a release in which a sliding wheelset returns to the speed of the train [s]."""
SLOWEST = 2.0
"""Speed below which slip is too uncertain to be compared [m/s]."""
ENOUGH = 1.0
"""Time with usable samples that a comparison needs [s]."""

ALIKE = 0.05
"""Deviation of r ω / v from 1 without a warning: wheels differ by up to 3 % from a nominal radius, sensors by 1 %."""
NO_RADIUS = (0.6, 1.6)
"""r ω / v that no choice of r_wheel explains: radii of trains are 0.3 m to 0.65 m, defaults 0.38 m and 0.46 m."""
STANDING = 0.02
"""r ω / v of a dead sensor or a blocked wheelset, which is not a question of scale."""
SLIDING = (0.35, 0.6)
"""r ω / v at the smallest slip, if a brake is always applied: below the second it is reported, below the first refused.
"""

SAME = 3e-4
"""Share of the speed by which r ω differs from it, if it is computed from ω; creep on a dry rail is larger."""
SLIPPING = (-1.0, 3.5)
"""Decelerations of a braked train [m/s2]; a wheelset that slides leaves this range at its begin and end."""

LATE = 0.15
"""Delay of a wheelset behind the speed with a warning [s]: filters and receivers differ by 0.1 s."""
EARLY = 0.3
"""Lead with a warning [s]; a lead looks like slip and is only certain where it does not depend on the speed."""
SLOWING = 0.3
"""Minimum deceleration at which a delay can be detected [m/s2]."""
SMOOTHING = 0.5
"""Length of the moving mean over speeds, and of the parabola that gives their derivative [s]."""
SCATTER = 0.2
"""Interquartile range of a lead over its median; slip by braking varies by more."""

LOADING = 1.3
"""Ratio of the mass to that of the model, in either direction."""
FRICTION = (0.2, 0.55)
"""Plausible range of the pad friction, averaged over a stop."""
USUAL_FRICTION = 0.35
"""Nominal friction of organic pads by UIC 541-3, for an estimation without an initial value."""
GRADIENT = 25e-3
"""Gradient of a track whose force is not recorded; the steepest main lines have 27 per mille over some kilometres."""
RESIDUAL = 5e-3
"""Gradient that corresponds to the error of a recorded or computed track force."""
BRAKE = (5e4, 1e6)
"""Largest cylinder pressure of a braking [Pa]."""
RELEASED = 3e4
"""Pressure in all cylinders while the train coasts that is reported [Pa]; blocks are clear of wheels below 0.3 bar."""
ABSOLUTE = (0.85e5, 1.15e5)
"""Air pressure from sea level to 1500 m [Pa]."""
COASTING = 0.25
"""Deceleration below which a train coasts [m/s2], or rolls on a gradient of 25 per mille."""
NO_RATIO = (0.3, 3.0)
"""Ratio of both beyond which a recording is refused, if they differ by more than that as well."""
VARIES = 0.15
"""Standard deviation of the deceleration that a comparison of its instants needs [m/s2]."""
OFFSET = 0.35
"""Mean difference of an accelerometer from dv/dt in braking that is reported [m/s2]: that of 25 per mille, and bias."""
LAG = 0.2
"""Lag between brakes or accelerometer and the speed that is reported [s]."""
LONGEST_LAG = 1.5
"""Largest lag that is searched for [s]."""
FOLLOWS = 0.8
"""Correlation of brake inputs and deceleration above which the one follows from the other."""
FITS = 0.7
"""Correlation above which a lag is meaningful."""
BETTER = 0.15
"""Gain of a lag in the area tangent of the correlation; chance reaches 0.02 in simulated stops."""
BEYOND = 2.0
"""Factor on the tolerance of the brake force beyond which a recording is refused."""
EVALUATED = 1500
"""Maximum number of samples at which the model is evaluated."""

_OTHER_LOGGER = "Does one of them come through a filter or from another logger?"
_SPEEDS = ("m/s", "km/h", "mph", "knot", "km/min")
_ROTATIONS = ("rad/s", "rev/min", "rev/s", "deg/s")
_FORCES = ("N", "kN", "MN", "lbf")
_PRESSURES = ("Pa", "hPa", "kPa", "bar", "MPa", "psi", "mbar")


@dataclass(frozen=True, slots=True)
class Disagreement:
    """Signals of a recording that contradict each other or the model.

    Attributes:
        kind: Comparison that failed.
        signals: Names of the signals concerned.
        value: The ratio found; for `timing` the delay of the wheelsets at the end of the braking [s].
        sentence: Description for a reader, with columns and probable cause.
        is_impossible: Whether no vehicle has this value.
    """

    kind: str
    signals: tuple[str, ...]
    value: float
    sentence: str
    is_impossible: bool = False


def require_agreement(
    specification: Specification, run: xarray.Dataset, braking: xarray.Dataset, file: str
) -> list[str]:
    """Return a sentence for each comparison that fails; raise an error for values that no vehicle has.

    With `contradictions = "warn"` in [data] nothing is refused.

    Args:
        specification: The estimation that maps the columns.
        run: The whole recording.
        braking: The part that the filter uses, with its track force.
        file: Name of the recording's file, the opening words of messages.

    Raises:
        EstimationError: A comparison has a result that no vehicle has.
    """
    found = disagreements(specification, run, braking)
    may_refuse = specification.data is None or specification.data.contradictions == "refuse"
    impossible = [each for each in found if each.is_impossible]
    if may_refuse and impossible:
        lines = [f"{file}: {each.sentence}" for each in impossible]
        lines[-1] += ' Correct [data.columns]; if the recording is right, write contradictions = "warn" in [data].'
        raise EstimationError("\n".join(lines))
    return [f"{file}: {each.sentence}" for each in found]


def disagreements(
    specification: Specification, run: xarray.Dataset, braking: xarray.Dataset | None = None
) -> list[Disagreement]:
    """Return the contradictions in a recording; arguments as for `require_agreement`.

    Comparisons without the necessary signals or parameters are omitted.
    """
    comparison = _RecordingComparison(specification, run)
    found = comparison.scales() + comparison.origins()
    if not any(each.is_impossible for each in found):
        found += comparison.delays() + comparison.accelerations()
    found += comparison.releases()
    part = _RecordingComparison(specification, run if braking is None else braking)
    forces = part.forces()
    return found + forces + ([] if forces or found else part.brake_delays())


class _RecordingComparison:
    """The signals of a recording, and the parameters of the model for the comparisons."""

    def __init__(self, specification: Specification, recording: xarray.Dataset) -> None:
        self._specification, self._recording = specification, recording
        self._time = recording["time"].values
        self._period = period_of(recording)
        self._columns: Mapping[str, tuple[str, str]] = recording.attrs.get("columns", {})
        self._smoothed = 2 * max(1, round(SMOOTHING / self._period) // 2) + 1
        source = specification.model.prediction
        model = source.model
        self._units = {variable.name: variable.unit for variable in (*model.inputs, *model.outputs)}
        self._parameters = source.values(parameters_for(specification))
        self._settings = settings_for(specification, self._period)
        names = [variable.name for variable in (*model.inputs, *model.outputs) if has_reading(recording, variable.name)]
        signals = {name: values for name in names if (values := self._signal(name)) is not None}
        self._speed = signals.get("speed")
        self._wheels = {
            name: v for name, v in signals.items() if _base(name) == "wheelset_speed" and self._radius(name)
        }
        self._brakes = {name: values for name, values in signals.items() if _base(name) in BRAKES}
        self._ratio = dict[str, float]()
        """r ω / v of each wheelset while no brake is applied."""

    def _signal(self, name: str) -> Vector | None:
        unit_of_name = self._units.get(name)
        values = samples(self._recording, [name], None if unit_of_name is None else [unit_of_name])[:, 0]
        known = np.isfinite(values)
        return np.interp(self._time, self._time[known], values[known]) if known.sum() > 1 else None

    def _radius(self, wheelset: str) -> float | None:
        of_wheelset = f"r_wheel{ElementName.of(wheelset).bracket}"
        return self._parameters.get("r_wheel", self._parameters.get(of_wheelset))

    def _rim(self, wheelset: str) -> Vector:
        return (self._radius(wheelset) or np.nan) * self._wheels[wheelset]

    def _is_long(self, where: Mask) -> bool:
        return bool(where.sum() * self._period >= ENOUGH and where.sum() >= 10)

    def _brake_mask(self) -> Mask:
        gate = self._settings.gate
        applied = np.zeros(self._time.size, dtype=np.bool_)
        for name, values in self._brakes.items():
            released = BRAKES[_base(name)]
            if gate is not None and name in gate.inputs:
                released = max(released, gate.threshold)
            applied |= values > max(released, APPLIED * float(values.max()))
        return applied

    def _release_mask(self) -> Mask:
        count = round(SETTLING / self._period)
        kernel = np.zeros(2 * count + 1, dtype=np.bool_)
        kernel[count:] = True  # a true sample reaches to the samples after it
        return np.logical_not(binary_dilation(self._brake_mask(), kernel))

    # ---- scale --------------------------------------------------------------------------------------------------

    def scales(self) -> list[Disagreement]:
        """Compare r ω with v."""
        if self._speed is None or not self._wheels or max(map(abs, (self._speed.min(), self._speed.max()))) <= 0.0:
            return []
        top = float(np.quantile(np.abs(self._speed), 0.99))
        fastest = max(float(np.quantile(np.abs(self._rim(name)), 0.99)) for name in self._wheels)
        moving = np.abs(self._speed) > 0.15 * top
        rolling = moving & self._release_mask()
        if max(top, fastest) < SLOWEST or not self._is_long(moving):
            return []
        found: dict[str, float] = {}
        for name in self._wheels:
            if self._is_long(rolling):
                ratio = float(np.median(self._rim(name)[rolling] / self._speed[rolling]))
                self._ratio[name] = ratio
                low = 1.0 - ALIKE
            else:  # slip only makes the ratio smaller, so its upper end is compared
                ratio, low = float(np.quantile(self._rim(name)[moving] / self._speed[moving], 0.95)), SLIDING[1]
                if abs(ratio) < STANDING:  # locked by the brake
                    continue
            if not low <= ratio <= 1.0 + ALIKE:
                found[name] = ratio
        return [self._scale(names, ratio, self._is_long(rolling)) for names, ratio in _alike(found)]

    def _scale(self, names: Sequence[str], ratio: float, is_rolling: bool) -> Disagreement:
        first = names[0]
        when = "while nothing brakes" if is_rolling else "where slip is smallest"
        what = (
            f"{self._describe(names)} times r_wheel ({self._radius(first):g} m) is {ratio:.3g} times "
            f"{self._describe(['speed'])} {when}; expected is 1"
        )
        is_impossible = not (NO_RADIUS if is_rolling else SLIDING)[0] <= ratio <= NO_RADIUS[1]
        if abs(ratio) < STANDING and len(names) < len(self._wheels):
            cause, is_impossible = "Is the sensor dead, or the wheelset blocked?", False
        else:
            cause = self._units_for(
                {"speed": ratio, first: 1.0 / ratio if ratio else np.inf}, ratio, 0.08, mistake(ratio)
            )
            if not is_impossible:
                cause = f"Is r_wheel that of your vehicle? {(self._radius(first) or 0.0) / ratio:.3g} m would fit."
                cause += "" if is_rolling else " Or is one of the columns late?"
        return Disagreement("scale", ("speed", *names), ratio, f"{what}. {cause}", is_impossible)

    def _slowing(self) -> Vector:
        # Too few samples for a derivative: zero.
        if self._speed is None or self._time.size < 2 * self._smoothed:
            return np.zeros(self._time.size)
        return -np.asarray(savgol_filter(self._speed, self._smoothed, 2, deriv=1, delta=self._period), dtype=np.float64)

    # ---- origin -------------------------------------------------------------------------------------------------

    def origins(self) -> list[Disagreement]:
        """Compare the speed with that of wheelsets from which train recorders compute it, where these slide."""
        braked = self._brake_mask()
        if self._speed is None or not self._wheels or not self._is_long(braked := braked & (self._speed > SLOWEST)):
            return []
        speed, rims = self._speed[braked], {self._describe([name]): self._rim(name)[braked] for name in self._wheels}
        every = np.stack(list(rims.values()))
        slowing = self._slowing()[braked]
        slides = (slowing < SLIPPING[0]) | (slowing > SLIPPING[1]) | (every.max(axis=0) > (1.0 + ALIKE) * speed)
        if slides.mean() * speed.size * self._period < ENOUGH:
            return []
        rims |= {"the fastest wheelset_speed": every.max(axis=0), "the mean wheelset_speed": every.mean(axis=0)}
        for words, rim in rims.items():
            steps = [np.diff(np.unique(values.round(9))) for values in (speed, rim)]
            resolution = max(float(np.median(each)) if each.size else 0.0 for each in steps)
            ratio = float(np.median(rim / speed))
            if np.quantile(np.abs(rim / ratio - speed) - SAME * speed, 0.98) > min(resolution, ALIKE):
                continue
            accelerometers = ("acceleration", *readings_in(self._recording, "acceleration_along"))
            sentence = (
                f"{self._describe(['speed'])} is {words} times a radius throughout, also in slides, where no train "
                f"slows by {slowing.min():.2g} to {slowing.max():.2g} m/s2: it is computed, not measured, and friction "
                "would be wrong by these slides. Name the column of a radar, an optical sensor or a satellite receiver"
                ", or one of an accelerometer."
            )
            is_impossible = not any(
                has_reading(self._recording, name) and self._signal(name) is not None for name in accelerometers
            )
            return [Disagreement("origin", ("speed",), ratio, sentence, is_impossible)]
        return []

    # ---- timing -------------------------------------------------------------------------------------------------

    def delays(self) -> list[Disagreement]:
        """Compare the instants of r ω and v while the train slows."""
        if self._speed is None:
            return []
        speed, slowing = self._speed, self._slowing()
        usable = (slowing > SLOWING) & (speed > SLOWEST)
        if not self._is_long(usable):
            return []
        late: dict[str, float] = {}
        early: dict[str, float] = {}
        shifts: dict[str, Vector] = {}
        for name in self._wheels:
            # Without samples of free rolling the radius is known to ALIKE only.
            rim = self._rim(name) / self._ratio.get(name, 1.0 + ALIKE)
            shift = (uniform_filter1d(rim - speed, self._smoothed) / np.where(usable, slowing, 1.0))[usable]
            shifts[name] = shift
            slowest = speed[usable] <= np.median(speed[usable])  # a delay has the largest relative effect here
            delay = float(np.median(shift[slowest]))
            if delay > LATE:
                late[name] = delay
            elif name in self._ratio and (lead := _lead(speed[usable], shift)) is not None:
                early[name] = lead
        found = [self._delay(names, delay, shifts, usable) for names, delay in _alike(late, 0.3)]
        # An apparent lead of only some wheelsets is slip.
        if len(early) == len(self._wheels):
            found += [self._delay(names, lead, shifts, usable) for names, lead in _alike(early, 0.3)]
        return found

    def _delay(self, names: Sequence[str], delay: float, shifts: Mapping[str, Vector], usable: Mask) -> Disagreement:
        time = self._time[usable]
        begin, end = _line(time, shifts[names[0]])
        direction = "behind" if delay > 0.0 else "ahead of"
        what = f"{self._describe(names)} is about {abs(delay):.2g} s {direction} {self._describe(['speed'])}"
        elapsed = float(time[-1] - self._time[0])
        if elapsed > 0.0 and abs(end - begin) > 0.5 * abs(delay) and abs(end) > abs(begin):
            what += f", {abs(begin):.2g} s at {time[0]:.1f} s and {abs(end):.2g} s at {time[-1]:.1f} s"
            cause = f"Does one of their clocks run {100 * abs(end) / elapsed:.1g} % slow?"
        else:
            cause = _OTHER_LOGGER
        sentence = f"{what} while the train slows. {cause} Shift the column in the file."
        return Disagreement("timing", ("speed", *names), delay, sentence)

    # ---- brake force --------------------------------------------------------------------------------------------

    def forces(self) -> list[Disagreement]:
        """Compare the momentum that a train loses in braking with the brake force that the model computes."""
        parts = self._momentum()
        if self._speed is None or parts is None:
            return []
        mass, weights, momentum = parts
        rims = np.stack([self._rim(name) for name in self._wheels], axis=1)
        applied = self._brake_mask()
        is_braked = self._is_long(applied)
        if not is_braked:  # which other force slows the train?
            applied = self._slowing() > 2.0 * GRADIENT * GRAVITY
        usable = applied & (self._speed > SLOWEST) & (rims > 0.05 * self._speed[:, None]).all(axis=1)
        # Both ends of a step must be usable.
        steps = usable[:-1] & usable[1:]
        if not self._is_long(steps):
            return []
        brake, other = self._model_forces(mass, weights, np.flatnonzero(usable))
        duration = float(steps.sum() * self._period)
        lost = -float(np.diff(momentum)[steps].sum()) / duration
        expected = float(np.mean(brake))
        observed = lost + float(np.mean(other))
        recorded_track = has_reading(self._recording, "track_force") and np.ptp(
            samples(self._recording, ["track_force"])[:, 0]
        )
        margin = mass * GRAVITY * (RESIDUAL if recorded_track else GRADIENT)
        friction = float(np.mean(self._friction()))
        weakest, strongest = (expected * bound / friction for bound in FRICTION)
        largest, smallest = LOADING * (observed + margin), (observed - margin) / LOADING
        names = list(self._brakes)
        if expected > 0.0 and weakest > max(largest, 0.0):
            excess = weakest / max(largest, 1e-9)
        elif smallest > strongest:
            excess = smallest / max(strongest, 1e-9)
        else:
            return []
        ratio = expected / observed if observed > 0.0 else np.inf
        text = f"{ratio:.3g} times" if np.isfinite(ratio) else "far more than"
        cause = self._units_for({names[0]: 1.0 / ratio if ratio else np.inf}, ratio, 0.5, self._pressure_unit(names))
        sentence = (
            f"the brake force computed from {self._describe(names)}, {expected / 1e3:.3g} kN on average, is {text} "
            f"the {observed / 1e3:.3g} kN that slow {mass / 1e3:.3g} t in {self._describe(['speed'])}. "
            f"{cause}"
        )
        is_impossible = (is_braked or self._follows_the_brakes()) and excess > BEYOND
        return [Disagreement("brake force", ("speed", *names), ratio, sentence, is_impossible)]

    def _pressure_unit(self, names: Sequence[str]) -> str:
        """Return a question for the unit in which the largest pressure would be that of a brake, or an empty text.

        Springs make forces disproportionate to pressures, so that their ratio does not show a unit.
        """
        column, text = self._columns.get(names[0], ("", ""))
        largest = float(np.max(np.quantile(list(self._brakes.values()), 0.99, axis=1)))
        if _base(names[0]) != "cylinder_pressure" or not text or BRAKE[0] <= largest <= BRAKE[1]:
            return ""
        for other in ("bar", "kPa", "MPa", "psi", "Pa"):
            if BRAKE[0] <= largest * unit(other).factor / unit(text).factor <= BRAKE[1]:
                return f"is column '{column}' in {other}, not {text}"
        return ""

    def _follows_the_brakes(self) -> bool:
        """Return whether the train slows with the brake inputs, however small they are: their scale is wrong then."""
        total = np.sum(list(self._brakes.values()), axis=0)
        slowing = self._slowing()
        if np.std(total) <= 0.0 or np.std(slowing) <= VARIES:
            return False
        return bool(np.corrcoef(uniform_filter1d(total, self._smoothed), slowing)[0, 1] > FOLLOWS)

    # ---- release, delay of the brakes, acceleration -----------------------------------------------------------------

    def releases(self) -> list[Disagreement]:
        """Compare the least cylinder pressures with that of a released brake."""
        pressures = {name: values for name, values in self._brakes.items() if _base(name) == "cylinder_pressure"}
        if self._speed is None or not pressures:
            return []
        least = {name: float(np.quantile(values, 0.01)) for name, values in pressures.items()}
        low, high = min(least.values()), max(least.values())
        total = np.mean(list(pressures.values()), axis=0)
        released = (total < np.mean(list(least.values())) + 0.1 * np.ptp(total) + 2e3) & (self._speed > SLOWEST)
        if low < RELEASED or not self._is_long(released) or np.median(self._slowing()[released]) > COASTING:
            return []
        what = f"{self._describe(list(pressures))} is {low / 1e5:.3g} bar or more, also while the train coasts"
        _, text = self._columns.get(next(iter(pressures)), ("", "Pa"))
        if ABSOLUTE[0] <= low and high <= ABSOLUTE[1]:
            offset = unit("bar").factor / unit(text or "Pa").factor * -1.013
            cause = f"Is it an absolute pressure? Write offset = {offset:.6g} with the column in [data.columns]."
        else:
            cause = "Does the transducer have an offset, or did a brake not release? Correct it with offset."
        return [Disagreement("release", tuple(pressures), low, f"{what}. {cause}")]

    def accelerations(self) -> list[Disagreement]:
        """Compare accelerometers along the vehicle with the derivative of the speed."""
        if self._speed is None:
            return []
        derivative, moving = -self._slowing(), self._speed > SLOWEST
        slowing = moving & (derivative < -SLOWING)
        if not self._is_long(slowing):
            return []
        found: list[Disagreement] = []
        for name in ("acceleration", *readings_in(self._recording, "acceleration_along")):
            if (
                not has_reading(self._recording, name)
                or not self._is_long(moving)
                or np.std(derivative[moving]) < VARIES
            ):
                continue
            values = self._signal(name)
            if values is None:
                continue
            smooth = uniform_filter1d(values, self._smoothed)
            lag, fit = _lag(derivative, smooth, moving, self._period)
            own, others = self._describe([name]), self._describe(["speed"])
            usual, mean = float(np.mean(derivative[slowing])), float(np.mean(smooth[slowing]))
            ratio = mean / usual
            sentence, value, is_impossible = "", ratio, False
            if abs(mean - usual) > OFFSET:
                is_impossible = ratio < NO_RATIO[0] or ratio > NO_RATIO[1]
                cause = f"Ratio {ratio:.3g}: does the accelerometer have an offset, or another scale?"
                if abs(ratio + 1.0) < 0.4:
                    cause = "Is its sign the other one?"
                elif abs(np.log(max(ratio, 1e-9) * GRAVITY)) < 0.3:
                    cause = f"Is column {self._column(name)} in g?"
                sentence = (
                    f"{own} is {mean:.2g} m/s2 on average while the derivative of {others} is {usual:.2g} m/s2, a "
                    f"difference that no gradient explains. {cause}"
                )
            elif fit > FITS and abs(lag) > LAG:
                direction, value = "behind" if lag > 0.0 else "ahead of", lag
                sentence = (
                    f"{own} is about {abs(lag):.2g} s {direction} the derivative of {others}. {_OTHER_LOGGER} "
                    "Shift the column in the file."
                )
            if sentence:
                found.append(Disagreement("acceleration", ("speed", name), value, sentence, is_impossible))
        return found

    def brake_delays(self) -> list[Disagreement]:
        """Compare the instants of the brake force that the model computes and of the momentum that the train loses."""
        parts = self._momentum()
        if self._speed is None or parts is None or self._time.size < 3 * self._smoothed or self._period > LAG:
            return []
        mass, weights, momentum = parts
        rows = np.arange(self._time.size)
        step = _stride(rows.size)
        brake, _ = self._model_forces(mass, weights, rows)
        brake = np.interp(rows, rows[::step][: brake.size], brake)
        impulse = np.concatenate([[0.0], np.cumsum(0.5 * (brake[1:] + brake[:-1])) * self._period])
        lost, braked = (
            np.asarray(savgol_filter(values, self._smoothed, 2, deriv=1, delta=self._period), dtype=np.float64)
            for values in (-momentum, impulse)
        )
        turning = np.stack([self._rim(name) for name in self._wheels], axis=1) > 0.1 * self._speed[:, None]
        kernel = np.ones(2 * round(LONGEST_LAG / self._period) + 1, dtype=np.bool_)
        near = np.asarray(binary_dilation(self._brake_mask(), kernel), dtype=np.bool_)
        moving = (self._speed > SLOWEST) & turning.all(axis=1) & near
        if not self._is_long(moving) or np.std(lost[moving]) < VARIES * mass:
            return []
        lag, fit = _lag(lost, braked, moving, self._period)
        if fit < FITS or abs(lag) <= LAG:
            return []
        names, direction = list(self._brakes), "behind" if lag > 0.0 else "ahead of"
        sentence = (
            f"{self._describe(names)} is about {abs(lag):.2g} s {direction} the deceleration in "
            f"{self._describe(['speed'])} and the wheelset speeds. {_OTHER_LOGGER} Shift the column in the file."
        )
        return [Disagreement("brake delay", ("speed", *names), lag, sentence)]

    def _momentum(self) -> tuple[float, Vector, Vector] | None:
        """Return mass [kg], inertia over radius of each wheelset, and momentum at each sample [kg m/s], if known."""
        masses = [value for name, value in self._parameters.items() if _base(name) == "m_wheelset"]
        mass = self._parameters.get("m", self._parameters.get("m_imitated", sum(masses) or None))
        common = self._parameters.get("J")
        inertias = [self._parameters.get(f"J[{name.partition('[')[2]}", common) for name in self._wheels]
        if self._speed is None or not self._wheels or not self._brakes or mass is None or None in inertias:
            return None
        radii = [self._radius(name) or 1.0 for name in self._wheels]
        weights = np.array([inertia or 0.0 for inertia in inertias]) / radii
        return mass, weights, mass * self._speed + np.stack(list(self._wheels.values()), axis=1) @ weights

    def _friction(self) -> Vector:
        prediction = equations_for(self._specification)
        pads = [state for state in prediction.states if _base(state) == "pad_friction"]
        mean = self._settings.start
        given = {name: value for name, value in mean.items() if _base(name) == "pad_friction"}
        return by_name("[start] mean", {"pad_friction": USUAL_FRICTION} | given, pads)

    def _model_forces(self, mass: float, weights: Vector, at: NDArray[np.intp]) -> tuple[Vector, Vector]:
        """Return brake force and the other forces on the train, without adhesion [N], at the samples `at`."""
        at = at[:: _stride(at.size)]
        prediction = equations_for(self._specification)
        mean = self._settings.start
        states = np.zeros((at.size, len(prediction.states)))
        friction = iter(self._friction())
        for column, state in enumerate(prediction.states):
            base, bracket = ElementName.of(state)
            wheelset = f"wheelset_speed{bracket}"
            if base == "pad_friction":
                states[:, column] = next(friction)
            elif base == "speed" and self._speed is not None:
                states[:, column] = self._speed[at]
            elif base == "wheelset_speed" and wheelset in self._wheels:
                states[:, column] = self._wheels[wheelset][at]
            elif base != "group_adhesion":
                states[:, column] = mean.get(state, mean.get(base, 0.0))
        inputs = samples(self._recording, prediction.inputs, [self._units[name] for name in prediction.inputs])[at]
        without = inputs.copy()
        without[:, [prediction.inputs.index(name) for name in self._brakes]] = 0.0
        places = [prediction.states.index(name) for name in ("speed", *self._wheels)]
        factors = np.concatenate([[mass], weights])

        def force(applied: Vector) -> Vector:
            rows = [prediction.derivative(x, u)[places] @ factors for x, u in zip(states, applied, strict=True)]
            return np.array(rows)

        free = force(without)
        return free - force(inputs), free

    # ---- words --------------------------------------------------------------------------------------------------

    def _describe(self, names: Sequence[str]) -> str:
        elements = [name for name in self._units if _base(name) == _base(names[0])]
        name = _base(names[0]) if len(names) == len(elements) else ", ".join(names)
        columns = [column for each in names if (column := self._column(each))]
        return f"{name} ({'column' if len(columns) == 1 else 'columns'} {', '.join(columns)})" if columns else name

    def _column(self, name: str) -> str:
        column, _ = self._columns.get(name, ("", ""))
        return f"'{column}'" if column else ""

    def _units_for(self, factors: Mapping[str, float], ratio: float, tolerance: float, otherwise: str = "") -> str:
        """Return a question that suggests units of columns which would multiply their signals by these factors.

        Args:
            factors: By signal; one of them would suffice.
            ratio: Ratio that was found.
            tolerance: Tolerance of the logarithm of a factor.
            otherwise: Cause, if no unit has the factor.
        """
        questions: list[str] = []
        for name, factor in factors.items():
            _, unit_of_column = self._columns.get(name, ("", ""))
            source = unit(unit_of_column)
            for text in (*_SPEEDS, *_ROTATIONS, *_FORCES, *_PRESSURES):
                other = unit(text)
                is_same_kind = other.exponents == source.exponents and factor > 0.0
                if is_same_kind and abs(np.log(factor * source.factor / other.factor)) < tolerance:
                    questions.append(f"is column {self._column(name)} in {text}, not {source.name}?")
        if not questions:
            questions.append(f"{otherwise or 'another scale of the column, or another vehicle in [model.parameters]'}?")
        return f"Ratio {ratio:.3g}: {' Or '.join(questions)}"


def _stride(count: int) -> int:
    return -(-count // EVALUATED)


def _shifted(values: Vector, samples_later: int) -> Vector:
    """Return a signal advanced by a number of samples, with its ends repeated."""
    at = np.clip(np.arange(values.size) + samples_later, 0, values.size - 1)
    return values[at]


def _lag(reference: Vector, values: Vector, where: Mask, period: float) -> tuple[float, float]:
    """Return the lag of a signal behind another [s] and the correlation there; the sign of a signal may be wrong.

    The lag is 0 unless its correlation exceeds that without a lag by `BETTER`.
    """
    longest = min(round(LONGEST_LAG / period), int(where.sum()) // 4)
    step = max(1, round(0.02 / period))
    shifts = np.arange(-(longest // step) * step, longest + 1, step)
    fits = np.array([_correlation(reference[where], _shifted(values, shift)[where]) for shift in shifts.tolist()])
    if not np.isfinite(fits).any():
        return 0.0, 0.0
    best = int(np.nanargmax(np.abs(fits)))
    at_zero = _correlation(reference[where], values[where])
    if abs(shifts[best]) >= longest or np.arctanh(abs(fits[best])) - np.arctanh(abs(at_zero)) < BETTER:
        return 0.0, float(at_zero)
    return float(shifts[best] * period), float(fits[best])


def _correlation(a: Vector, b: Vector) -> float:
    return float(np.corrcoef(a, b)[0, 1]) if np.std(a) > 0.0 and np.std(b) > 0.0 else 0.0


def _base(name: str) -> str:
    return ElementName.of(name).array


def _alike(values: Mapping[str, float], difference: float = 0.08) -> list[tuple[list[str], float]]:
    """Group names whose values differ by no more than a share; return them with the first value of each group."""
    groups: list[tuple[list[str], float]] = []
    for name, value in values.items():
        for names, first in groups:
            if abs(value - first) <= difference * abs(first):
                names.append(name)
                break
        else:
            groups.append(([name], value))
    return groups


def _line(x: Vector, y: Vector) -> tuple[float, float]:
    # Medians, so that outliers do not tilt the line.
    third = max(x.size // 3, 1)
    at = [float(np.median(x[part])) for part in (slice(0, third), slice(-third, None))]
    medians = [float(np.median(y[part])) for part in (slice(0, third), slice(-third, None))]
    slope = (medians[1] - medians[0]) / (at[1] - at[0]) if at[1] > at[0] else 0.0
    return medians[0] + slope * (x[0] - at[0]), medians[1] + slope * (x[-1] - at[1])


def _lead(speed: Vector, shift: Vector) -> float | None:
    # The slip of a braked wheelset vanishes with the speed or is irregular; a lead is constant.
    if np.max(speed) < 3.0 * np.min(speed):
        return None
    order = np.argsort(speed)
    speed, shift = speed[order], shift[order]
    slow, fast = _line(speed, shift)
    slope = (fast - slow) / (speed[-1] - speed[0])
    lead = slow - slope * speed[0]
    low, high = np.quantile(shift - lead - slope * speed, (0.25, 0.75))
    return float(lead) if lead < -EARLY and high - low <= SCATTER * abs(lead) else None
