"""Slip control whose set point climbs the slope of adhesion over slip, as far as the slope is known.

The slip of maximum adhesion depends on the contamination of the rail: half a per cent, or twenty. The sign of ṡ·α̇ (see
`railgrip.controllers.laws.adhesion_based`) states at every instant on which side of the peak a wheel is, but on a broad
curve this sign is noise. Here it is replaced by an estimate over a window: the elasticity e = d(ln α)/d(ln s) is a
regression of estimated adhesion on estimated slip, with its standard error. Where the elasticity is known, the set
point follows it; where it is not, the set point returns to a slip that is a fair guess on most rails.

Sources: extremum seeking with a periodic excitation and washout filters (Krstić and Wang, Automatica 36 (2000) 595);
the equivalent control from the torque balance of the wheelset as in `AdhesionBased`. The regression with its error, and
shrinking by it, are this project's.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import pi
from typing import Annotated, ClassVar

import casadi as ca

from railgrip.controllers.law import GroupLaw, GroupObservation, Ranges, Tuning, pressure_for
from railgrip.controllers.parameters import SEARCHED, SlipSource
from railgrip.controllers.sampled import Expression, FormulaBuilder, Symbols, choose, either, every, within
from railgrip.vehicle.brake import piston_force


@dataclass(frozen=True, slots=True, kw_only=True)
class SlopeSeekingTuning(Tuning):
    """Parameters of `SlopeSeeking`, one set for every actuation.

    Filters and rate limits are slower than the valves and faster than changes of the rail; the limit of adhesion is the
    TSI's.
    """

    period: Annotated[float, "s", "between two decisions"]
    filter_time: Annotated[float, "s", "time constant of the filters of slip and adhesion"] = 0.03
    pressure_lag: Annotated[float, "s", "of the reading of the pressure"]
    washout_time: Annotated[float, "s", "time constant of the high-pass: slower changes are the rail's"]
    window: Annotated[float, "s", "time constant of forgetting in the regression"]
    correlation_time: Annotated[float, "s", "between two residuals of the regression that are independent"] = 0.1
    log_slip_noise: Annotated[float, "1", "standard deviation of the noise of ln(slip)"] = 0.03
    elasticity_spread: Annotated[
        float, "1", "standard deviation of elasticities over all rails, the prior of the estimate"
    ]
    elasticity_bias: Annotated[float, "1", "added to the elasticity: more slip costs less than less slip"]
    pull: Annotated[float, "1", "elasticity assumed if unknown, for each unit of ln(slip) below the usual slip"]
    climb_rate: Annotated[float, "1/s", "rate of ln(slip) for each unit of elasticity"]
    rise_rate: Annotated[float, "1/s", "highest rate of ln(slip) upwards"] = 0.8
    fall_rate: Annotated[float, "1/s", "highest rate of ln(slip) downwards"] = 0.8
    slip_usual: Annotated[float, "1", "slip that is sought if the elasticity is unknown, at high speed"]
    creep_usual: Annotated[
        float, "m/s", "creep speed that adds to it: peaks move to larger slip as the train slows down"
    ]
    slip_most: Annotated[float, "1", "largest slip that is sought, dither included"] = 0.42
    dither: Annotated[float, "1", "amplitude of the excitation of ln(slip)"]
    dither_time: Annotated[float, "s", "period of the dither"]
    gain: Annotated[float, "1/s", "rate at which slip approaches its set point"] = 5.0
    share_added: Annotated[float, "1", "largest share of the equivalent torque added"] = 0.3
    slip_small: Annotated[float, "1", "slip below which the wheel counts as rolling, at high speed"] = 0.006
    creep_small: Annotated[float, "m/s", "creep speed that adds to it: errors of the train speed not of its scale"]
    slip_vent: Annotated[float, "1", "slip above which the brake is released"] = 0.45
    adhesion_max: Annotated[float, "1", "highest adhesion that may be used"]
    adhesion_guard: Annotated[float, "1", "distance below adhesion_max at which the torque is capped"] = 0.003
    speed_min: Annotated[float, "m/s", "train speed below which the brake is simply applied"] = 0.5

    POSITIVE: ClassVar[frozenset[str]] = frozenset(
        {"period", "filter_time", "washout_time", "window", "correlation_time", "dither_time"}
    )
    FIXED: ClassVar[frozenset[str]] = frozenset({"period", "pressure_lag", "adhesion_max"})
    ORDER: ClassVar[tuple[str, ...]] = ("0 < slip_small < slip_most < 1", "0 < slip_usual < 1")


class SlopeSeeking(GroupLaw):
    """Slip control with a set point on the slope of adhesion over slip.

    Per group, with s the slip minus that of the rolling wheel and a = α̂. Neighbouring groups are dithered in
    antiphase. Δ is half the difference between the sliding groups of odd and of even number, ⟨·⟩ a mean over these
    groups, weighted by their adhesion force, and E a mean over `window`:

        x, y = Δ⟨ln s⟩, Δ ln⟨a⟩, filtered, high-passed with `washout_time`
        x, y = 0 in E where |y| > dither and xy < −x²/2       a change of the rail, under one group before the others
        e = E(xy)/(E(x²) + log_slip_noise²), its variance from the residual of the regression
        w = spread²/(spread² + var e)                          weight of e: 1 known, 0 unknown
        r = E(x²)/(E(x²) + log_slip_noise²)                    weight of the excitation by changes of slip
        d(ln s_set)/dt = climb_rate·(w (e + bias) + (1 − w)·pull·q + w (1 − r)·pull·max(q, 0)),  q = ln(s_usual/s_set)
        s_usual = slip_usual + creep_usual/v
        s* = s_set·exp(±dither·sin φ)
        T = a F_z r − J (1−s) v̇/r + (J v/r)(ṡ* + gain (s* − s + i))  s approaches s* at the rate `gain`
        di/dt = (s* − s)/0.2 s  while s < s*; else i = 0              overcomes the band in which valves hold
        p = p(T), with the estimated pad friction

    All groups share one set point. A change of the rail that affects all wheels cancels in the difference. In a single
    group, or in the sum over the train, a loss of friction makes slip rise while adhesion falls, which looks like the
    far side of a peak. With one group, x and y are those of that group.

    A wheel that is not braked yet rolls. Any slip read then is an error of radius or speed: its mean is subtracted from
    all later readings. Otherwise wheels worn by 3 % and a radar with an error of 1 % would look like slides. The same
    applies later to a wheel that is neither braked nor turned by the rail: if the train's speed is wrong, all wheels
    seem to slide, are released and roll, and their slip is the error.

    Start: a wheel with slip below slip_small + creep_small/v rolls, and is braked as far as `adhesion_max` allows.
    Low adhesion alone does not mean rolling: on oil a sliding wheel has hardly any. Standstill: below `speed_min` the
    slip is unknown, and the brake is applied as at the start.

    An implausible wheel speed is rejected: an unknown one (NaN), a slip below −5 %, or a slide that does not end
    although the brake is off. Until its wheel speed is plausible again, such a group gets the torque for eight tenths
    of the adhesion that the others use, with its last credible pad friction. If its pressure exceeds that for the
    whole of this adhesion, its brake is released.
    """

    description = "Slip control on the slope of adhesion over slip"
    needs = ("adhesion", "pad_friction")
    tuning = SlopeSeekingTuning
    ranges: ClassVar[Ranges] = {
        ("pneumatic", "estimated"): {
            "window": (0.3, 0.7),
            "washout_time": (0.2, 1.0),
            "elasticity_spread": (0.05, 0.5),
            "elasticity_bias": (0.005, 0.2),
            "pull": (0.03, 0.5),
            "climb_rate": (2.0, 6.0),
            "slip_usual": (0.03, 0.15),
            "creep_usual": (0.1, 2.0),
            "dither": (0.08, 0.4),
            "dither_time": (0.7, 2.0),
            "creep_small": (0.03, 0.2),
        }
    }
    # The set point moves all the time, which would cause a valve pulse at every decision. With 20 instead of 6 kPa a
    # slide takes half the valve strokes and no more distance.
    valve_band = 20e3

    @classmethod
    def load_tuning(cls, actuation: str, slip: SlipSource, name: str = SEARCHED, /, **others: float) -> Tuning:
        """Return the parameters of one of the law's sets; a law derived from this one has this one's for the slope.

        Raises:
            ValueError: See `GroupLaw.load_tuning`.
        """
        if cls is not SlopeSeeking:
            slope = asdict(SlopeSeeking.load_tuning(actuation, slip, SEARCHED, **others))
            others = {key: value for key, value in slope.items() if key not in cls.tuning.__annotations__} | others
        return super().load_tuning(actuation, slip, name, **others)

    @classmethod
    def demands(cls, draft: FormulaBuilder, tuning: Symbols, train: Sequence[GroupObservation]) -> list[Expression]:
        """Return the demanded pressure of each group [Pa]."""
        wheels = [wheels_of(draft, group, tuning) for group in train]
        return seek(draft, wheels, slope_targets(draft, wheels, tuning), tuning)


_UNBRAKED = 0.9
"""Share of the spring's force that the piston may have while the pads are surely off."""

_AVERAGED = 1.0  # s, averaging time of the slip of a rolling wheel before it is braked
_LEASH, _LEASH_UP = 0.5, 0.8
"""Limits of ln(s_set) below and above ln(s): a set point that the brake cannot reach must not run away."""

_PATIENCE = 0.2
"""Integration time [s] of a slip that stays below its set point.

Left of the peak more slip requires more torque; if a wheel uses little adhesion, the torque that `gain` and
`share_added` allow is less than the band within which valves hold, and slip would remain at a tenth of the set point.
As in Clegg's integrator (Trans. AIEE 77 (1958) 41), the integral is reset when the error is zero, so that it does not
act beyond the peak."""

_RADIUS_ERROR = 0.08  # a larger deviation is implausible: new and worn wheels differ by some 8 %
_SPEED_ERROR = 0.8  # largest relative error of the train's speed after wrong radar readings
_TOUCHING = 1.15  # piston force over spring force: the law demands the spring's force when it requires no torque
_NOTHING = 5e-3
"""Adhesion below which the rail does not turn a wheel: bearings take 0.001, and the estimate's noise is some 0.002."""

_REGAINED = 0.2  # s, averaging time of the slip of a wheel that rolls again
_ANY_SPEED = 1e6  # rad/s, beyond every speed; comparisons with it are false for NaN
_BACKWARDS = -0.05  # a braked wheel cannot run this much faster than the train
_DRAWN = 0.25
"""Minimum adhesion of a sliding wheel over that of the other wheels: creep curves fall to 0.4 of their peak."""

_DOUBTED = 0.5  # s, after which a wheel with an implausible speed is rejected
_FOLLOWED = 0.8
"""Share of the others' adhesion that is demanded from a wheel whose speed is not known: with all it may lock unseen."""

_STEEPEST = 0.5
"""Slope of adhesion over slip: a steeper fall, and one larger than the dither causes, is a change of the rail.

Polach's curves with A = 0.4 fall by up to 0.38, those with A = 0.1 by more than 0.5 where wheels creep at 3 m/s."""

_ROLLING, _SEEKING, _VENTING, _FOLLOWING = range(4)
_MODES = "what rules the group: 0 rolls, 1 seeks slip, 2 vented, 3 its speed is unknown, follows the others"


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheels:
    """Signals of one group that the law derives from its observation.

    Attributes:
        group: The observation.
        slip: Slip minus that of the rolling wheel.
        filtered: The same, filtered.
        slip_change: Change of ln(filtered slip) since the last sample.
        adhesion_change: Change of the filtered adhesion since the last sample.
        adhesion: Filtered adhesion, not negative.
        credible: Whether its speed is plausible and the group is not in a deep slide.
        valid: Whether its speed has been plausible within the last `_DOUBTED`.
        sliding: Whether it is valid, and slips by more than a rolling wheel.
    """

    group: GroupObservation
    slip: Expression
    filtered: Expression
    slip_change: Expression
    adhesion_change: Expression
    adhesion: Expression
    credible: Expression
    valid: Expression
    sliding: Expression


Target = tuple[Expression, Expression]
"""Slip that a group seeks, and its rate [1/s]."""


def seek(draft: FormulaBuilder, train: Sequence[Wheels], targets: Sequence[Target], t: Symbols) -> list[Expression]:
    """Return the demanded pressure of each group [Pa] that brings its slip to its target.

    Args:
        draft: Formula that gets the states.
        train: Signals of the groups.
        targets: Slip that each group seeks, and its rate [1/s].
        t: Parameters, those of `SlopeSeekingTuning`.
    """
    demands: list[Expression] = []
    for signals, target in zip(train, targets, strict=True):
        group = signals.group
        brake, speed = group.brake, group.speed
        radius = brake["wheel_radius"]
        inertia = brake["inertia"]
        creeping = speed < t["speed_min"]
        rolling = either(ca.logic_not(signals.sliding), creeping)

        # Torque balance of the wheelset, J ω̇ = F_x r − T, for ṡ = ṡ* + gain (s* − s + i).
        unit_torque = brake["load"] * radius  # torque per adhesion
        inertial = -inertia * (1.0 - signals.slip) * group.acceleration / radius
        balance = group.adhesion * unit_torque + inertial
        # Below speed_min a wheel may lock: then the contact carries all of the brake torque.
        limit = (t["adhesion_max"] - t["adhesion_guard"]) * unit_torque + choose(creeping, 0.0, inertial)
        torque_per_rate = inertia * speed / radius  # of slip
        error = target[0] - signals.slip
        last = draft.state(group.label("error"), "s", "integral of the slip's distance below its set point")
        integral = choose(every(ca.logic_not(rolling), error > 0.0), last + error * t["period"], 0.0)
        draft.keep(last, integral)
        # Upwards the extra torque is limited, downwards not: in a deep slide adhesion is low, and a small share of
        # its torque would not end the slide.
        extra = ca.fmin(torque_per_rate * (target[1] + t["gain"] * error), t["share_added"] * balance)
        goal = balance + extra + torque_per_rate * t["gain"] / _PATIENCE * integral
        torque = choose(rolling, limit, ca.fmin(goal, limit))
        venting = every(signals.slip > t["slip_vent"], speed >= t["speed_min"])
        controlled = choose(venting, 0.0, pressure_for(torque, group.pad_friction, brake))
        # A wheel whose speed is unknown is braked by the adhesion of the others.
        others = [each for each in train if each is not signals]
        compared = either(0.0, *(each.valid for each in others))
        following = every(ca.logic_not(signals.valid), compared, speed >= t["speed_min"])
        mode = choose(rolling, _ROLLING, choose(venting, _VENTING, _SEEKING))
        draft.show(group.label("mode"), "1", _MODES, choose(following, _FOLLOWING, mode))
        draft.show(group.label("slip_target"), "1", "slip that is sought, dither included", target[0])
        before = draft.state(group.label("pad_friction"), "1", "pad friction when the wheel speed was last credible")
        pad_friction = choose(either(signals.credible, before <= 0.0), group.pad_friction, before)
        draft.keep(before, pad_friction)
        if not others:
            return [controlled]
        loads = [each.group.brake["load"] for each in others]
        share = weighted_mean([(each.valid, each.adhesion) for each in others], loads)
        followed = pressure_for(_FOLLOWED * share * unit_torque, pad_friction, brake)
        # Within their band the valves hold a pressure that is slightly too high: a wheel without a speed reading
        # would lock unnoticed as soon as the rail gets worse.
        most = pressure_for(share * unit_torque, pad_friction, brake)
        followed = choose(group.pressure > most, 0.0, followed)
        demands.append(choose(following, followed, controlled))
    return demands


def weighted_mean(values: Sequence[tuple[Expression, Expression]], weights: Sequence[Expression]) -> Expression:
    """Return the weighted mean of the values whose condition holds, 0 if none does; `values` are pairs of both."""
    counted = [choose(condition, weight, 0.0) for (condition, _), weight in zip(values, weights, strict=True)]
    total = sum(weight * value for weight, (_, value) in zip(counted, values, strict=True))
    return total / ca.fmax(sum(counted), 1e-9)


def wheels_of(draft: FormulaBuilder, group: GroupObservation, t: Symbols) -> Wheels:
    """Return the signals that the law derives from the observation of a group, and keep their filters."""
    started = draft.started
    period, small = t["period"], t["slip_small"] + t["creep_small"] / group.speed
    pads_off = group.pressure * group.brake["piston_area"] < _UNBRAKED * group.brake["spring_force"]
    slip = _correct_slip(draft, group, pads_off, period)

    def filtered(name: str, sample: Expression) -> tuple[Expression, Expression]:
        before = draft.state(group.label(name), "1", "filtered value")
        now = choose(started, before + period / (t["filter_time"] + period) * (sample - before), sample)
        draft.keep(before, now)
        return choose(started, before, now), now

    slip_before, slip_now = filtered("filtered_slip", slip)
    adhesion_before, adhesion_now = filtered("filtered_adhesion", _without_lag(draft, group, t))

    # With its brake off, a sliding wheel is accelerated by the rail, however little. A deep slide without that means
    # that the reading of the wheel speed is wrong.
    loads = sum(each.brake["load"] for each in group.train)
    mean = sum(each.adhesion * each.brake["load"] for each in group.train) / loads
    turned = group.adhesion > _DRAWN * mean
    doubted = draft.state(group.label("doubted"), "s", "for how long the wheel speed has been impossible")
    impossible = either(
        ca.logic_not(group.wheelset_speed > -_ANY_SPEED),  # NaN: not known
        slip < _BACKWARDS,
        every(slip > t["slip_vent"], either(doubted >= _DOUBTED, every(pads_off, ca.logic_not(turned)))),
    )
    doubt = choose(every(impossible, group.speed >= t["speed_min"]), doubted + period, 0.0)
    draft.keep(doubted, doubt)
    valid = doubt < _DOUBTED
    return Wheels(
        group=group,
        slip=slip,
        filtered=slip_now,
        slip_change=ca.log(ca.fmax(slip_now, small) / ca.fmax(slip_before, small)),
        adhesion_change=adhesion_now - adhesion_before,
        adhesion=ca.fmax(adhesion_now, 0.0),
        credible=every(ca.logic_not(impossible), slip < t["slip_vent"]),
        valid=valid,
        sliding=every(valid, slip_now >= small),
    )


def _without_lag(draft: FormulaBuilder, group: GroupObservation, t: Symbols) -> Expression:
    brake = group.brake
    force = piston_force(group.pressure, piston_area=brake["piston_area"], spring_force=brake["spring_force"])
    torque = brake["units"] * group.pad_friction * brake["friction_radius"] * brake["rigging"] * force
    before = draft.state(group.label("torque"), "N.m", "brake torque at the last sample")
    draft.keep(before, torque)
    rate = choose(draft.started, (torque - before) / t["period"], 0.0)
    return group.adhesion + t["pressure_lag"] * rate / (brake["load"] * brake["wheel_radius"])


def slope_targets(draft: FormulaBuilder, train: Sequence[Wheels], t: Symbols) -> list[Target]:
    """Return the slip that each group seeks on the slope of adhesion; groups that do not slide do not count."""
    period, speed = t["period"], train[0].group.speed
    rolling = either(every(*(ca.logic_not(each.sliding) for each in train)), speed < t["speed_min"])
    signs = [1.0 if g % 2 == 0 else -1.0 for g in range(len(train))]
    loads = [each.group.brake["load"] for each in train]
    forces = [load * each.adhesion for load, each in zip(loads, train, strict=True)]

    def mean(part: Sequence[int], values: Sequence[Expression], weights: Sequence[Expression]) -> Expression:
        return weighted_mean([(train[g].sliding, values[g]) for g in part], [weights[g] for g in part])

    def changes(part: Sequence[int]) -> Expression:
        adhesion = mean(part, [each.adhesion for each in train], loads)
        change = mean(part, [each.adhesion_change for each in train], loads)
        slip_change = mean(part, [each.slip_change for each in train], forces)
        return ca.vertcat(slip_change, change / ca.fmax(adhesion, 1e-3))

    parts = [[g for g, other in enumerate(signs) if other == sign] for sign in dict.fromkeys(signs)]
    comparable = every(*(either(*(train[g].sliding for g in part)) for part in parts))
    sides = [changes(part) for part in parts]
    x, y = ca.vertsplit(sides[0] if len(sides) == 1 else 0.5 * (sides[0] - sides[1]))
    compared = choose(comparable, x, 0.0), choose(comparable, y, 0.0)
    elasticity, variance, excitation = _regression(draft, t, compared, rolling)
    spread = t["elasticity_spread"] ** 2
    weight = spread / (spread + variance)
    draft.show("elasticity", "1", "of adhesion over slip, as estimated", elasticity)
    draft.show("belief", "1", "how far that is believed: 0 not at all, 1 wholly", weight * excitation)

    # In ln s, so that steps are relative to the slip: peaks are anywhere between half a per cent and twenty.
    usual = ca.log(ca.fmin(t["slip_usual"] + t["creep_usual"] / speed, t["slip_most"]))
    previous = draft.state("set_point", "1", "logarithm of the slip that is sought; 0 before the first")
    last = choose(previous < 0.0, previous, usual)
    # Where the elasticity is unknown, its expected value is `pull` times the distance to the usual slip.
    expected = weight * (elasticity + t["elasticity_bias"]) + (1.0 - weight) * t["pull"] * (usual - last)
    # Without excitation the observations fit any elasticity: below the usual slip the set point must not remain.
    expected += weight * (1.0 - excitation) * t["pull"] * ca.fmax(usual - last, 0.0)
    moved = last + within(t["climb_rate"] * expected, -t["fall_rate"], t["rise_rate"]) * period
    least = t["slip_small"] + t["creep_small"] / speed
    present = weighted_mean([(each.sliding, ca.log(ca.fmax(each.filtered, least))) for each in train], forces)
    near = within(moved, present - _LEASH, present + _LEASH_UP)
    set_point = choose(rolling, last, within(near, ca.log(least), ca.log(t["slip_most"]) - t["dither"]))
    draft.keep(previous, set_point)
    phase = draft.state("phase", "1", "periods of the dither since the start")
    draft.keep(phase, phase + period / t["dither_time"])
    angle = 2.0 * pi * phase
    targets: list[Target] = []
    for sign in signs:
        target = ca.exp(set_point + sign * t["dither"] * ca.sin(angle))
        targets.append((target, sign * target * t["dither"] * 2.0 * pi / t["dither_time"] * ca.cos(angle)))
    return targets


def _correct_slip(
    draft: FormulaBuilder, group: GroupObservation, pads_off: Expression, period: Expression
) -> Expression:
    offset = draft.state(group.label("offset"), "1", "slip that the wheel shows when it rolls")
    count = draft.state(group.label("count"), "1", "samples that it is the mean of; -1 once the wheel has been braked")
    free = draft.state(group.label("free"), "s", "for how long nothing has braked the wheel and nothing turned it")
    drawing = within(group.adhesion, -1.0, 1.0)
    touching = group.pressure * group.brake["piston_area"] < _TOUCHING * group.brake["spring_force"]
    draft.keep(free, choose(every(touching, drawing > -_NOTHING, drawing < _NOTHING), free + period, 0.0))
    first = every(count >= 0.0, pads_off, group.slip > -_RADIUS_ERROR, group.slip < _RADIUS_ERROR)
    again = every(count < 0.0, free > _DOUBTED, group.slip > -_SPEED_ERROR, group.slip < _SPEED_ERROR)
    share = choose(first, ca.fmax(1.0 / (1.0 + count), period / _AVERAGED), period / _REGAINED)
    mean = choose(either(first, again), offset + share * (group.slip - offset), offset)
    draft.keep(offset, mean)
    draft.keep(count, choose(first, count + 1.0, choose(pads_off, count, -1.0)))
    return 1.0 - (1.0 - group.slip) / (1.0 - mean)


def _regression(
    draft: FormulaBuilder, t: Symbols, changes: tuple[Expression, Expression], rolling: Expression
) -> tuple[Expression, Expression, Expression]:
    """Return the elasticity d(ln α)/d(ln s), its variance, and the share of the excitation above noise, from 0 to 1.

    Args:
        draft: Formula that gets the moments as states.
        t: Parameters of the law.
        changes: Changes of ln s and ln α since the last sample.
        rolling: Whether the wheel rolls; without slip the moments fade to zero.
    """
    forgets, fades = t["period"] / t["window"], 1.0 - t["period"] / t["washout_time"]
    names = ("log_slip", "log_adhesion")
    states = [draft.state(name, "1", f"{name}, high-passed") for name in names]
    x, y = (fades * (last + change) for last, change in zip(states, changes, strict=True))
    for state, value in zip(states, (x, y), strict=True):
        draft.keep(state, choose(rolling, fades * state, value))
    # A change of the rail under one group before the others: not an effect of slip.
    rail = every(x * y < -_STEEPEST * x * x, ca.fabs(y) > t["dither"])
    moments: list[Expression] = []
    for name, product in (("slip_slip", x * x), ("slip_adhesion", x * y), ("adhesion_adhesion", y * y)):
        state = draft.state(name, "1", f"mean of {name.replace('_', ' times ')}, logarithms")
        moments.append((1.0 - forgets) * state + forgets * choose(rail, 0.0, product))
        draft.keep(state, choose(rolling, (1.0 - forgets) * state, moments[-1]))
    xx, xy, yy = moments
    # Noise of the regressor in the denominator shrinks the slope (errors in variables), so that without excitation the
    # elasticity tends to zero.
    excited = xx + t["log_slip_noise"] ** 2
    elasticity = xy / excited
    residual = ca.fmax(yy - xy * xy / ca.fmax(xx, 1e-12), 0.0)
    # Successive residuals are correlated: only one per correlation time counts for the standard error.
    independent = ca.fmax(t["window"] / t["correlation_time"], 1.0)
    variance = residual / (excited * independent)
    return elasticity, variance, xx / excited
