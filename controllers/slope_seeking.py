"""Slip control whose set point climbs the slope of adhesion over slip, as far as the slope is known.

Where adhesion peaks depends on what lies on the rail: at half a per cent of slip or at twenty. The sign of ṡ·α̇ (see
`railgrip.controllers.adhesion_based`) asks at every instant on which side of the peak a wheel is; on a broad curve the
answer is noise. Here the question is put over a window: the elasticity e = d(ln α)/d(ln s) is a regression of estimated
adhesion on estimated slip, with its standard error. Where it is known the set point follows it; where it is not, the
set point returns to a slip that is a fair guess on most rails.

Sources: extremum seeking with a periodic excitation and washout filters (Krstić and Wang, Automatica 36 (2000) 595);
the equivalent control from the torque balance of the wheelset as in `AdhesionBased`. The regression with its error, and
shrinking by it, are this project's.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from math import pi
from types import MappingProxyType
from typing import ClassVar

import casadi as ca

from railgrip.controllers.brake import BrakeGroup, pressure_for
from railgrip.controllers.law import Demand, GroupObservation, Law, Tuning, law, parameters, within
from railgrip.controllers.sampled import Draft, Expression, Formula, choose, either, every


@dataclass(frozen=True, slots=True, kw_only=True)
class SlopeTuning(Tuning):
    """Parameters of `SlopeSeeking`; units and meanings are in `MEANINGS`."""

    period: float
    filter_time: float
    washout_time: float
    window: float
    correlation_time: float
    log_slip_noise: float
    elasticity_spread: float
    elasticity_bias: float
    climb_rate: float
    rise_rate: float
    fall_rate: float
    slip_usual: float
    creep_usual: float
    slip_most: float
    dither: float
    dither_time: float
    gain: float
    share_added: float
    slip_small: float
    creep_small: float
    slip_vent: float
    adhesion_max: float
    adhesion_guard: float
    speed_min: float

    LAW: ClassVar[str] = "SlopeSeeking"
    MEANINGS: ClassVar[Mapping[str, tuple[str, str]]] = MappingProxyType(
        {
            "period": ("s", "between two decisions"),
            "filter_time": ("s", "time constant of the filters of slip and adhesion"),
            "washout_time": ("s", "time constant beyond which changes count as the rail's, not the slip's"),
            "window": ("s", "time constant of forgetting in the regression"),
            "correlation_time": ("s", "between two residuals of the regression that are independent"),
            "log_slip_noise": ("1", "standard deviation of ln(slip) that is noise, which excites nothing"),
            "elasticity_spread": (
                "1",
                "standard deviation of elasticities that are met: what an estimate is weighed by",
            ),
            "elasticity_bias": ("1", "added to the elasticity: more slip costs less than less slip"),
            "climb_rate": ("1/s", "rate of ln(slip) for each unit of elasticity"),
            "rise_rate": ("1/s", "highest rate of ln(slip) upwards, and of the return to the usual slip"),
            "fall_rate": ("1/s", "highest rate of ln(slip) downwards"),
            "slip_usual": ("1", "slip that is sought where nothing is known, at high speed"),
            "creep_usual": ("m/s", "creep speed that adds to it: peaks move to larger slip as a train slows"),
            "slip_most": ("1", "largest slip that is sought"),
            "dither": ("1", "amplitude of the excitation of ln(slip)"),
            "dither_time": ("s", "its period"),
            "gain": ("1/s", "rate at which slip is led to its set point"),
            "share_added": ("1", "largest share of the equivalent torque added"),
            "slip_small": ("1", "slip below which the wheel counts as rolling, at high speed"),
            "creep_small": ("m/s", "creep speed that adds to it: errors of the train speed that are no scale"),
            "slip_vent": ("1", "slip above which the brake is released"),
            "adhesion_max": ("1", "highest adhesion that may be used"),
            "adhesion_guard": ("1", "distance below adhesion_max at which the torque is capped"),
            "speed_min": ("m/s", "train speed below which the brake is simply applied"),
        }
    )
    POSITIVE: ClassVar[frozenset[str]] = frozenset(name for name, (unit, _) in MEANINGS.items() if unit == "s")
    FIXED: ClassVar[frozenset[str]] = frozenset({"period", "adhesion_max"})

    def __post_init__(self) -> None:
        """Refuse what would run and mean nothing.

        Raises:
            ValueError: See `Tuning`; or the slips are not in order.
        """
        Tuning.__post_init__(self)
        if not 0.0 < self.slip_small < self.slip_most < 1.0 or not 0.0 < self.slip_usual < 1.0:
            raise ValueError(
                "SlopeSeeking: slips must have 0 < slip_small < slip_most < 1 and 0 < slip_usual < 1, got "
                f"{self.slip_small}, {self.slip_most} and {self.slip_usual}."
            )


class SlopeSeeking(Law):
    """Slip control with a set point on the slope of adhesion over slip.

    Per group, with s the slip less that of a rolling wheel and a = α̂:

        x, y = ln s, ln a, filtered, less what is slower than `washout_time`
        e = ⟨xy⟩/(⟨x²⟩ + log_slip_noise²), its variance from the residual of the regression, ⟨ ⟩ over `window`
        w = spread²/(spread² + var e)                          how far e is believed: 1 known, 0 unknown
        d(ln s_set)/dt = w·climb_rate·(e + bias) + (1 − w)·(return to slip_usual + creep_usual/v), within its rates
        s* = s_set·exp(dither·sin φ)                           φ a quarter turn apart from group to group
        T = a F_z r − J (1−s) v̇/r + (J v/r)(ṡ* + gain (s* − s))  leads s to s* at `gain`
        p = p(T), with the estimated pad friction

    A wheel that is not braked yet rolls, and the slip it shows then is an error of radius or speed: it is averaged and
    taken from all that follows. Wheels worn by 3 % and a radar off by 1 % would else look like slides.

    Start: a wheel with slip below slip_small + creep_small/v rolls, and is braked as far as `adhesion_max` allows. A
    low adhesion alone is no sign of rolling: on oil a sliding wheel has next to none. Standstill: below `speed_min` the
    slip is no longer known, and the brake is applied as at the start.
    """

    needs = ("adhesion", "pad_friction")

    def __init__(self, groups: Sequence[BrakeGroup], tuning: SlopeTuning) -> None:
        """Control `groups` with one `tuning`."""
        super().__init__(slope_seeking(len(groups)), groups, asdict(tuning))


_UNBRAKED = 0.9
"""Share of the spring's force that the piston may have while the pads are surely off."""

_AVERAGED = 1.0  # s, over which the slip of a rolling wheel is averaged, where it rolls for so long
_TURN = 0.25  # of the dither's period, between two groups: what they excite does not add up to a jerk of the train
_LEAST_ADHESION = 1e-3  # an estimate near or below zero has no logarithm
_LEASH = 0.5
"""How far ln(s_set) may be from ln(s): a set point that the brake cannot reach must not run away."""


@cache
def slope_seeking(groups: int) -> Formula:
    """Return the formula of `SlopeSeeking` for so many groups."""

    def demand_with(draft: Draft) -> Demand:
        t = parameters(draft, SlopeTuning.MEANINGS)
        period = t["period"]
        started = draft.state("started", "1", "1 once there is a sample before this one")
        phase = draft.state("phase", "1", "periods of the dither since the start")
        draft.keep(started, 1.0)
        draft.keep(phase, phase + period / t["dither_time"])

        def demand(draft: Draft, seen: GroupObservation) -> Expression:
            brake, radius, inertia, speed = seen.brake, seen.brake["wheel_radius"], seen.brake["inertia"], seen.speed
            slip = _corrected(draft, seen, period)
            small = t["slip_small"] + t["creep_small"] / speed

            def logarithm(name: str, sample: Expression, least: Expression) -> tuple[Expression, Expression]:
                """Return the filtered value, and the change of its logarithm since the last sample."""
                before = draft.state(seen.named(name), "1", "filtered value")
                value = choose(started, before + period / (t["filter_time"] + period) * (sample - before), sample)
                draft.keep(before, value)
                return value, choose(started, ca.log(ca.fmax(value, least) / ca.fmax(before, least)), 0.0)

            filtered, slip_change = logarithm("filtered_slip", slip, small)
            _, adhesion_change = logarithm("filtered_adhesion", seen.adhesion, _LEAST_ADHESION)
            rolling = either(filtered < small, speed < t["speed_min"])
            elasticity, weight = _regression(draft, seen, t, (slip_change, adhesion_change), rolling)

            # The set point, as a logarithm.
            usual = ca.log(ca.fmin(t["slip_usual"] + t["creep_usual"] / speed, t["slip_most"]))
            kept = draft.state(seen.named("set_point"), "1", "logarithm of the slip that is sought; 0 before the first")
            last = choose(kept < 0.0, kept, usual)
            back = within(usual - last, -t["rise_rate"] * period, t["rise_rate"] * period)
            climb = within(t["climb_rate"] * (elasticity + t["elasticity_bias"]), -t["fall_rate"], t["rise_rate"])
            moved = last + weight * climb * period + (1.0 - weight) * back
            present = ca.log(ca.fmax(filtered, small))
            near = within(moved, present - _LEASH, present + _LEASH)
            set_point = choose(rolling, last, within(near, ca.log(small), ca.log(t["slip_most"])))
            draft.keep(kept, set_point)
            angle = 2.0 * pi * (phase + _TURN * seen.index)
            target = ca.exp(set_point + t["dither"] * ca.sin(angle))
            target_rate = target * t["dither"] * 2.0 * pi / t["dither_time"] * ca.cos(angle)

            # The torque that leads there.
            held = brake["load"] * radius  # torque per adhesion
            inertial = -inertia * (1.0 - slip) * seen.acceleration / radius
            balance = seen.adhesion * held + inertial
            limit = (t["adhesion_max"] - t["adhesion_guard"]) * held + inertial
            extra = inertia * speed / radius * (target_rate + t["gain"] * (target - slip))
            # Up in small shares, down as far as it takes: a deep slide draws little, and a share of little ends none.
            sought = balance + ca.fmin(extra, t["share_added"] * balance)
            torque = choose(rolling, limit, ca.fmin(sought, limit))
            venting = every(slip > t["slip_vent"], speed >= t["speed_min"])
            return choose(venting, 0.0, pressure_for(torque, seen.pad_friction, brake))

        return demand

    return law("SlopeSeeking", "Slip control on the slope of adhesion over slip", groups, demand_with)


def _corrected(draft: Draft, seen: GroupObservation, period: Expression) -> Expression:
    """Return the slip less what the wheel showed while it had not been braked yet."""
    offset = draft.state(seen.named("offset"), "1", "slip that the wheel shows when it rolls")
    count = draft.state(seen.named("count"), "1", "samples that it is the mean of; -1 once the wheel has been braked")
    pads_off = seen.pressure * seen.brake["piston_area"] < _UNBRAKED * seen.brake["spring_force"]
    rolls = every(count >= 0.0, pads_off)
    share = ca.fmax(1.0 / (1.0 + count), period / _AVERAGED)
    mean = choose(rolls, offset + share * (seen.slip - offset), offset)
    draft.keep(offset, mean)
    draft.keep(count, choose(rolls, count + 1.0, -1.0))
    return 1.0 - (1.0 - seen.slip) / (1.0 - mean)


def _regression(
    draft: Draft,
    seen: GroupObservation,
    t: Mapping[str, Expression],
    changes: tuple[Expression, Expression],
    rolling: Expression,
) -> tuple[Expression, Expression]:
    """Return the elasticity d(ln α)/d(ln s), and from 0 to 1 how far it is to be believed.

    Args:
        draft: Keeps the moments.
        seen: Of which group.
        t: The parameters.
        changes: Of ln s and ln α since the last sample.
        rolling: No slip, nothing to learn; what is known is forgotten.
    """
    forgets, fades = t["period"] / t["window"], 1.0 - t["period"] / t["washout_time"]
    names = ("log_slip", "log_adhesion")
    kept = [draft.state(seen.named(name), "1", f"{name}, less what is slow") for name in names]
    x, y = (fades * (last + change) for last, change in zip(kept, changes, strict=True))
    for state, value in zip(kept, (x, y), strict=True):
        draft.keep(state, choose(rolling, fades * state, value))
    moments: list[Expression] = []
    for name, product in (("slip_slip", x * x), ("slip_adhesion", x * y), ("adhesion_adhesion", y * y)):
        state = draft.state(seen.named(name), "1", f"mean of {name.replace('_', ' times ')}, logarithms")
        moments.append((1.0 - forgets) * state + forgets * product)
        draft.keep(state, choose(rolling, (1.0 - forgets) * state, moments[-1]))
    xx, xy, yy = moments
    excited = xx + t["log_slip_noise"] ** 2
    elasticity = xy / excited
    residual = ca.fmax(yy - xy * xy / ca.fmax(xx, 1e-12), 0.0)
    independent = ca.fmax(t["window"] / t["correlation_time"], 1.0)
    variance = residual / (excited * independent)
    spread = t["elasticity_spread"] ** 2
    return elasticity, spread / (spread + variance)
