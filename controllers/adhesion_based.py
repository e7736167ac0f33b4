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
from dataclasses import asdict, dataclass
from functools import cache
from typing import Annotated, ClassVar

from railgrip.controllers.brake import BrakeGroup, pressure_for
from railgrip.controllers.law import Demand, GroupObservation, Law, Tuning, law, parameters
from railgrip.controllers.sampled import Draft, Expression, Formula, choose, either, every


@dataclass(frozen=True, slots=True, kw_only=True)
class PeakSeekingTuning(Tuning):
    """Parameters of peak seeking; one set serves every scenario.

    A `margin` of zero is the peak itself; a small positive one keeps a rise of adhesion along the track from being
    taken for an effect of the slip. `adhesion_max` is 0.15 in the TSI, 0.13 for short fixed formations.
    """

    period: Annotated[float, "s", "between two decisions"]
    filter_time: Annotated[float, "s", "time constant of the filters that differentiate slip and adhesion"]
    margin: Annotated[float, "1", "elasticity of adhesion over slip at which the peak counts as reached"]
    rise: Annotated[float, "1", "share of the equivalent torque added while seeking upwards"]
    fall: Annotated[float, "1", "share of it taken away while seeking downwards"]
    slip_rate_max: Annotated[float, "1/s", "largest relative slip rate that a torque may cause"]
    slip_rate_min: Annotated[float, "1/s", "relative slip rate below which slip is led upwards"]
    dwell: Annotated[float, "s", "shortest time between two changes of direction"]
    slip_small: Annotated[float, "1", "slip below which the wheel counts as rolling, at high speed"]
    creep_small: Annotated[float, "m/s", "creep speed that adds to it: errors of the train speed that are no scale"]
    slip_vent: Annotated[float, "1", "slip above which the brake is released"]
    adhesion_small: Annotated[float, "1", "estimated adhesion below which there is no peak to seek"]
    adhesion_max: Annotated[float, "1", "highest adhesion that may be used"]
    adhesion_guard: Annotated[float, "1", "distance below adhesion_max at which the torque is capped"]
    speed_min: Annotated[float, "m/s", "train speed below which the brake is simply applied"]

    LAW: ClassVar[str] = "AdhesionBased"
    FIXED: ClassVar[frozenset[str]] = frozenset({"period", "adhesion_max"})


class AdhesionBased(Law):
    """Sliding-mode peak seeking with equivalent control.

    Per group, with a = α̂ and ˙ the filtered derivative:

        σ = (ṡ/s)·(α̇/α − margin·ṡ/s)                     switching function, eq. (10) in relative rates
        T_eq = α̂ F_z r − J (1−s) v̇/r                     torque at which ṡ = 0
        p = p(T_eq + L·sgn σ),  L = rise or fall · T_eq, at most J·slip_rate_max·s·v/r

    The relative rates make the law independent of the scale of the adhesion curve: peaks lie anywhere between 0.5 %
    and 40 % slip. Dropped from eq. (12) are ∂α/∂v·v̇ and ∂α/∂μ0·μ̇0; a rising μ0 would drive the slip up without end,
    which `margin` (and at the last `slip_vent`) prevents.

    Start: a wheel with slip below slip_small + creep_small/v or adhesion below `adhesion_small` is rolling. It is
    braked as far as `adhesion_max` allows; it is the torque for this adhesion that is capped, with the estimated pad
    friction. The bound must lie above the error of the slip at every speed. Below that error nothing can be sought: the
    wheel does not slide, ṡ·α̇ is noise, and T_eq holds whatever pressure there is. A speed that is too high by δ looks
    like a slip of δ/v: with an accelerometer off by 0.12 m/s² the filter's is by 0.05 m/s, 0.2 % at 80 km/h and 1 % at
    18 km/h. A bound in slip alone that suits the one takes the wheel for sliding at the other, and hangs.
    Standstill: below `speed_min` the slip is no longer known well enough to seek, and the brake is applied as at the
    start.
    """

    needs = ("adhesion", "pad_friction")

    def __init__(self, groups: Sequence[BrakeGroup], tuning: PeakSeekingTuning) -> None:
        """Control `groups` with one `tuning`."""
        super().__init__(adhesion_based(len(groups)), groups, asdict(tuning))


class LiteralAdhesionBased(Law):
    """The law as printed, eq. (11): full pressure while ṡ·α̇ > 0, none while it is negative.

    Source: Schwarz, Posielek, Goetjes (2021), §3.2, with the limit α ≤ adhesion_max of the same section. Of `tuning`
    only period, filter_time, adhesion_max, adhesion_small, slip_small, creep_small and speed_min are used.
    """

    needs = ("adhesion", "pad_friction")

    def __init__(self, groups: Sequence[BrakeGroup], tuning: PeakSeekingTuning) -> None:
        """Control `groups` with one `tuning`."""
        super().__init__(literal_adhesion_based(len(groups)), groups, asdict(tuning))


@cache
def adhesion_based(groups: int) -> Formula:
    """Return the formula of `AdhesionBased` for so many groups."""

    def demand_with(draft: Draft) -> Demand:
        tuning = parameters(draft, PeakSeekingTuning.meanings())
        filters = _Derivatives(draft, tuning)

        def demand(draft: Draft, group: GroupObservation) -> Expression:
            brake, radius, inertia = group.brake, group.brake["wheel_radius"], group.brake["inertia"]
            slip, slip_rate = filters.follow(draft, group.label("seen_slip"), group.slip)
            adhesion, adhesion_rate = filters.follow(draft, group.label("seen_adhesion"), group.adhesion)
            upwards = draft.state(group.label("upwards"), "1", "1 while it seeks upwards", start=1.0)
            wait = draft.state(group.label("wait"), "s", "until the direction may change again")
            seeking, creeping = group.speed >= tuning["speed_min"], group.speed < tuning["speed_min"]
            venting = every(group.slip > tuning["slip_vent"], seeking)
            rolling = either(_is_rolling(tuning, group.speed, slip, adhesion), creeping)

            # The direction, from the relative rates.
            s_rate, a_rate = slip_rate / slip, adhesion_rate / adhesion
            still = every(-tuning["slip_rate_min"] < s_rate, s_rate < tuning["slip_rate_min"])
            rising = either(still, s_rate * (a_rate - tuning["margin"] * s_rate) > 0.0)
            rest = wait - tuning["period"]
            turned = choose(rest > 0.0, upwards, rising)
            waits = choose(turned != upwards, tuning["dwell"], rest)

            unit_torque = brake["load"] * radius  # torque per adhesion
            inertial = -inertia * (1.0 - group.slip) * group.acceleration / radius
            limit = (tuning["adhesion_max"] - tuning["adhesion_guard"]) * unit_torque + inertial
            balance = adhesion * unit_torque + inertial
            reached = choose(turned, tuning["rise"], tuning["fall"]) * balance
            reach = inertia * tuning["slip_rate_max"] * slip * group.speed / radius
            extra = choose(reached > reach, reach, reached)
            goal = choose(turned, balance + extra, balance - extra)
            torque = choose(rolling, limit, choose(goal < limit, goal, limit))

            draft.keep(upwards, choose(venting, 0.0, choose(rolling, 1.0, turned)))
            draft.keep(wait, choose(either(venting, rolling), wait, waits))
            return choose(venting, 0.0, pressure_for(torque, group.pad_friction, brake))

        return demand

    return law("AdhesionBased", "Adhesion-based wheel-slide protection, peak seeking", groups, demand_with)


@cache
def literal_adhesion_based(groups: int) -> Formula:
    """Return the formula of `LiteralAdhesionBased` for so many groups."""

    def demand_with(draft: Draft) -> Demand:
        tuning = parameters(draft, {name: PeakSeekingTuning.meanings()[name] for name in _LITERAL})
        filters = _Derivatives(draft, tuning)

        def demand(draft: Draft, group: GroupObservation) -> Expression:
            full, controlling = group.brake["pressure_max"], group.speed >= tuning["speed_min"]
            _, slip_rate = filters.follow(draft, group.label("seen_slip"), group.slip)
            _, adhesion_rate = filters.follow(draft, group.label("seen_adhesion"), group.adhesion)
            applied = draft.state(
                group.label("applied"), "1", "1 when the brake was applied, 0 when released", start=1.0
            )
            switch = slip_rate * adhesion_rate
            rolling = _is_rolling(tuning, group.speed, group.slip, group.adhesion)
            seeking = choose(either(rolling, switch > 0.0), 1.0, choose(switch < 0.0, 0.0, applied))
            decided = choose(group.adhesion > tuning["adhesion_max"], 0.0, seeking)
            draft.keep(applied, choose(controlling, decided, applied))
            return choose(controlling, decided * full, full)

        return demand

    return law("LiteralAdhesionBased", "Adhesion-based wheel-slide protection as printed", groups, demand_with)


_LITERAL = ("period", "filter_time", "adhesion_max", "adhesion_small", "slip_small", "creep_small", "speed_min")


def _is_rolling(
    tuning: Mapping[str, Expression], speed: Expression, slip: Expression, adhesion: Expression
) -> Expression:
    """Return whether there is no peak to seek: slip no larger than its error, or adhesion too small."""
    slip_small = tuning["slip_small"] + tuning["creep_small"] / speed
    return either(slip < slip_small, adhesion < tuning["adhesion_small"])


class _Derivatives:
    """First-order filters and their rates: the filtered derivatives of sampled signals."""

    def __init__(self, draft: Draft, tuning: Mapping[str, Expression]) -> None:
        self._started = draft.state("started", "1", "1 once there is a sample before this one")
        self._share = tuning["period"] / (tuning["filter_time"] + tuning["period"])
        self._period = tuning["period"]
        draft.keep(self._started, 1.0)

    def follow(self, draft: Draft, name: str, sample: Expression) -> tuple[Expression, Expression]:
        """Return the filtered value of a sample and its rate."""
        before = draft.state(name, "1", "filtered value")
        step = self._share * (sample - before)
        # Without this the first sample would look like a jump from zero.
        value = choose(self._started, before + step, sample)
        draft.keep(before, value)
        return value, choose(self._started, step / self._period, 0.0)
