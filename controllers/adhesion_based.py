"""Adhesion-based control (ABC): seek the peak of adhesion by the sliding-mode law of Schwarz, Posielek, Goetjes (2021).

The law is u = L·sgn(ṡ·α̇), eq. (10)-(11): if slip and adhesion move the same way the wheel is below the peak and may be
braked harder, otherwise it is beyond the peak and must be relieved. With s = 1 − rω/v a higher pressure raises the
slip, so g_s in ṡ = f_s + g_s·u is positive (the paper's text has it negative; its proof needs the positive sign).

Two forms:

- `LiteralAdhesionBased`: the law as printed. u = +L is full pressure, u = −L is none.
- `AdhesionBased`: sliding mode with equivalent control. The estimated adhesion gives the pressure that would keep
  the slip where it is (the equivalent control, from the torque balance of the wheelset); the sign of ṡ·α̇ only says
  whether to go a little above or below it. The paper allows L to depend on the states to compensate f_s.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

from controllers.brake import BrakeGroup
from controllers.sight import Sight


@dataclass(frozen=True, slots=True, kw_only=True)
class SeekerTuning:
    """Parameters of the peak seeker; one set serves every scenario.

    Attributes:
        period: Between two decisions [s].
        filter_time: Time constant of the filters that differentiate slip and adhesion [s].
        margin: Elasticity d(ln α)/d(ln s) at which the peak counts as reached [1]. Zero is the peak itself; a small
            positive value keeps a rise of adhesion along the track from being taken for an effect of the slip.
        rise: Share of the equivalent torque added while seeking upwards [1].
        fall: Share taken away while seeking downwards [1].
        slip_rate_max: Largest relative slip rate |ṡ|/s the added or missing torque may cause [1/s].
        slip_rate_min: Relative slip rate below which ṡ·α̇ says nothing and the seeker goes upwards [1/s].
        dwell: Shortest time between two changes of direction [s].
        slip_small: Slip below which the wheel counts as rolling and there is no peak to seek [1].
        slip_vent: Slip above which the brake is released, whatever the adhesion [1].
        adhesion_small: Estimated adhesion below which there is no peak to seek [1].
        adhesion_max: Highest adhesion that may be used (TSI: 0.15; 0.13 for short fixed formations) [1].
        adhesion_guard: Distance below `adhesion_max` at which the torque is capped [1].
        speed_min: Train speed below which the brake is simply applied [m/s].
    """

    period: float
    filter_time: float
    margin: float
    rise: float
    fall: float
    slip_rate_max: float
    slip_rate_min: float
    dwell: float
    slip_small: float
    slip_vent: float
    adhesion_small: float
    adhesion_max: float
    adhesion_guard: float
    speed_min: float

    UNITS: ClassVar[Mapping[str, str]] = MappingProxyType(
        {
            "filter_time": "s",
            "margin": "1",
            "rise": "1",
            "fall": "1",
            "slip_rate_max": "1/s",
            "slip_rate_min": "1/s",
            "dwell": "s",
            "slip_small": "1",
            "slip_vent": "1",
            "adhesion_small": "1",
            "adhesion_guard": "1",
            "speed_min": "m/s",
        }
    )
    """Unit of each parameter that a user may change; period and adhesion_max are the scenario's."""


class _Derivative:
    """First-order filter and its rate: the filtered derivative of a sampled signal."""

    __slots__ = ("_share", "_started", "_time", "rate", "value")

    def __init__(self, filter_time: float, period: float) -> None:
        self._share = period / (filter_time + period)
        self._time = period
        self._started = False
        self.value = 0.0
        self.rate = 0.0

    def follow(self, sample: float) -> float:
        """Take a sample; return and keep the filtered value, keep its rate."""
        if not self._started:  # without this the first sample would look like a jump from zero
            self._started, self.value = True, sample
            return sample
        step = self._share * (sample - self.value)
        self.value = value = self.value + step
        self.rate = step / self._time
        return value


class AdhesionBased:
    """Sliding-mode peak seeking with equivalent control.

    Per group, with a = α̂ and ˙ the filtered derivative:

        σ = (ṡ/s)·(α̇/α − margin·ṡ/s)                     switching function, eq. (10) in relative rates
        T_eq = α̂ F_z r − J (1−s) v̇/r                     torque at which ṡ = 0
        p = p(T_eq + L·sgn σ),  L = rise or fall · T_eq, at most J·slip_rate_max·s·v/r

    The relative rates make the law independent of the scale of the adhesion curve: peaks lie anywhere between 0.5 %
    and 40 % slip. Dropped from eq. (12) are ∂α/∂v·v̇ and ∂α/∂μ0·μ̇0; a rising μ0 would drive the slip up without end,
    which `margin` (and at the last `slip_vent`) prevents.

    Start: a wheel with slip below `slip_small` or adhesion below `adhesion_small` is braked as far as `adhesion_max`
    allows; it is the torque for this adhesion that is capped, with the estimated pad friction.
    Standstill: below `speed_min` the slip is no longer known well enough to seek, and the brake is applied as at the
    start.
    """

    def __init__(self, groups: Sequence[BrakeGroup], tuning: SeekerTuning) -> None:
        """Control `groups` with one `tuning`."""
        self._seekers = tuple(_Seeker(group, tuning) for group in groups)

    def decide(self, sight: Sight) -> tuple[float, ...]:
        """Return the demanded pressure of each group [Pa].

        Raises:
            ValueError: The sight carries no estimate of adhesion and pad friction.
        """
        _, speed, acceleration, slips, adhesions, pad_frictions, _ = sight
        if adhesions is None or pad_frictions is None:
            raise ValueError("AdhesionBased: needs an estimator; [estimator] kind is 'none' in this scenario.")
        return tuple(
            [
                seeker.demand(speed, acceleration, slip, adhesion, pad_friction)
                for seeker, slip, adhesion, pad_friction in zip(
                    self._seekers, slips, adhesions, pad_frictions, strict=True
                )
            ]
        )


class _Seeker:
    """Seeks the peak of one group."""

    __slots__ = ("_adhesion", "_group", "_slip", "_tuning", "_upwards", "_wait")

    def __init__(self, group: BrakeGroup, tuning: SeekerTuning) -> None:
        self._group = group
        self._tuning = tuning
        self._slip = _Derivative(tuning.filter_time, tuning.period)
        self._adhesion = _Derivative(tuning.filter_time, tuning.period)
        self._upwards = True
        self._wait = 0.0

    def demand(self, speed: float, acceleration: float, slip: float, adhesion: float, pad_friction: float) -> float:
        """Return the demanded pressure [Pa]."""
        tuning, group = self._tuning, self._group
        seen_slip = self._slip.follow(slip)
        seen_adhesion = self._adhesion.follow(adhesion)
        seeking = speed >= tuning.speed_min
        if slip > tuning.slip_vent and seeking:
            self._upwards = False
            return 0.0
        radius, inertia = group.wheel_radius, group.inertia
        held = group.load * radius  # torque per adhesion
        inertial = -inertia * (1.0 - slip) * acceleration / radius
        torque = (tuning.adhesion_max - tuning.adhesion_guard) * held + inertial
        if seen_slip < tuning.slip_small or seen_adhesion < tuning.adhesion_small or not seeking:
            self._upwards = True
            return group.pressure(torque, pad_friction)
        self._turn(self._slip.rate / seen_slip, self._adhesion.rate / seen_adhesion)

        balance = seen_adhesion * held + inertial
        extra = (tuning.rise if self._upwards else tuning.fall) * balance
        reach = inertia * tuning.slip_rate_max * seen_slip * speed / radius
        if extra > reach:
            extra = reach
        sought = balance + extra if self._upwards else balance - extra
        return group.pressure(sought if sought < torque else torque, pad_friction)

    def _turn(self, slip_rate: float, adhesion_rate: float) -> None:
        """Choose the direction of seeking from the relative rates [1/s]."""
        tuning = self._tuning
        self._wait -= tuning.period
        if self._wait > 0.0:
            return
        upwards = (
            -tuning.slip_rate_min < slip_rate < tuning.slip_rate_min
            or slip_rate * (adhesion_rate - tuning.margin * slip_rate) > 0.0
        )
        if upwards != self._upwards:
            self._upwards = upwards
            self._wait = tuning.dwell


class LiteralAdhesionBased:
    """The law as printed, eq. (11): full pressure while ṡ·α̇ > 0, none while it is negative.

    Source: Schwarz, Posielek, Goetjes (2021), §3.2, with the limit α ≤ adhesion_max of the same section. Of `tuning`
    only period, filter_time, adhesion_max, adhesion_small, slip_small and speed_min are used.
    """

    def __init__(self, groups: Sequence[BrakeGroup], tuning: SeekerTuning) -> None:
        """Control `groups` with one `tuning`."""
        self._tuning = tuning
        self._full = tuple(group.pressure_max for group in groups)
        self._demands = list(self._full)
        self._slip = [_Derivative(tuning.filter_time, tuning.period) for _ in groups]
        self._adhesion = [_Derivative(tuning.filter_time, tuning.period) for _ in groups]

    def decide(self, sight: Sight) -> tuple[float, ...]:
        """Return the demanded pressure of each group [Pa].

        Raises:
            ValueError: The sight carries no estimate of adhesion.
        """
        if sight.adhesion is None:
            raise ValueError("LiteralAdhesionBased: needs an estimator; [estimator] kind is 'none' in this scenario.")
        tuning = self._tuning
        if sight.speed < tuning.speed_min:
            return self._full
        for g, (slip, adhesion) in enumerate(zip(sight.slip, sight.adhesion, strict=True)):
            self._slip[g].follow(slip)
            self._adhesion[g].follow(adhesion)
            switch = self._slip[g].rate * self._adhesion[g].rate
            if adhesion > tuning.adhesion_max:
                self._demands[g] = 0.0
            elif slip < tuning.slip_small or adhesion < tuning.adhesion_small or switch > 0.0:
                self._demands[g] = self._full[g]
            elif switch < 0.0:
                self._demands[g] = 0.0
        return tuple(self._demands)
