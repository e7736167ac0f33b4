"""Slip control whose set point climbs the slope of adhesion over slip, as far as the slope is known.

The slip of the maximum adhesion depends on the contamination of the rail: half a per cent, or twenty. The sign of ṡ·α̇
(see `railgrip.controllers.laws.adhesion_based`) asks at every instant on which side of the peak a wheel is; on a broad
curve the answer is noise. Here the question is put over a window: the elasticity e = d(ln α)/d(ln s) is a regression of
estimated adhesion on estimated slip, with its standard error. Where it is known the set point follows it; where it is
not, the set point returns to a slip that is a fair guess on most rails.

Sources: extremum seeking with a periodic excitation and washout filters (Krstić and Wang, Automatica 36 (2000) 595);
the equivalent control from the torque balance of the wheelset as in `AdhesionBased`. The regression with its error, and
shrinking by it, are this project's.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi
from typing import Annotated, ClassVar

import casadi as ca

from railgrip.controllers.brake import pressure_for
from railgrip.controllers.law import Demand, GroupLaw, GroupObservation, Ranges, Tuning
from railgrip.controllers.sampled import Expression, FormulaBuilder, choose, either, every, within
from railgrip.vehicle.brake import piston_force


@dataclass(frozen=True, slots=True, kw_only=True)
class SlopeTuning(Tuning):
    """Parameters of `SlopeSeeking`, one set for every actuation.

    Filters and bounds of rates are slower than valves and quicker than the rail; the limit of adhesion is the TSI's.
    """

    period: Annotated[float, "s", "between two decisions"]
    filter_time: Annotated[float, "s", "time constant of the filters of slip and adhesion"] = 0.03
    pressure_lag: Annotated[float, "s", "of the reading of the pressure"]
    washout_time: Annotated[float, "s", "time constant beyond which changes count as the rail's, not the slip's"]
    window: Annotated[float, "s", "time constant of forgetting in the regression"]
    correlation_time: Annotated[float, "s", "between two residuals of the regression that are independent"] = 0.1
    log_slip_noise: Annotated[float, "1", "standard deviation of ln(slip) that is noise, which excites nothing"] = 0.03
    elasticity_spread: Annotated[
        float, "1", "standard deviation of elasticities that are met: what an estimate is weighed by"
    ]
    elasticity_bias: Annotated[float, "1", "added to the elasticity: more slip costs less than less slip"]
    pull: Annotated[float, "1", "elasticity expected where nothing is known, a unit of ln(slip) below the usual slip"]
    climb_rate: Annotated[float, "1/s", "rate of ln(slip) for each unit of elasticity"]
    rise_rate: Annotated[float, "1/s", "highest rate of ln(slip) upwards"] = 0.8
    fall_rate: Annotated[float, "1/s", "highest rate of ln(slip) downwards"] = 0.8
    slip_usual: Annotated[float, "1", "slip that is sought where nothing is known, at high speed"]
    creep_usual: Annotated[float, "m/s", "creep speed that adds to it: peaks move to larger slip as a train slows"]
    slip_most: Annotated[float, "1", "largest slip that is sought, dither included"] = 0.42
    dither: Annotated[float, "1", "amplitude of the excitation of ln(slip)"]
    dither_time: Annotated[float, "s", "its period"]
    gain: Annotated[float, "1/s", "rate at which slip is led to its set point"] = 5.0
    share_added: Annotated[float, "1", "largest share of the equivalent torque added"] = 0.3
    slip_small: Annotated[float, "1", "slip below which the wheel counts as rolling, at high speed"] = 0.006
    creep_small: Annotated[float, "m/s", "creep speed that adds to it: errors of the train speed that are no scale"]
    slip_vent: Annotated[float, "1", "slip above which the brake is released"] = 0.45
    adhesion_max: Annotated[float, "1", "highest adhesion that may be used"]
    adhesion_guard: Annotated[float, "1", "distance below adhesion_max at which the torque is capped"] = 0.003
    speed_min: Annotated[float, "m/s", "train speed below which the brake is simply applied"] = 0.5

    LAW: ClassVar[str] = "SlopeSeeking"
    POSITIVE: ClassVar[frozenset[str]] = frozenset(
        {"period", "filter_time", "washout_time", "window", "correlation_time", "dither_time"}
    )
    FIXED: ClassVar[frozenset[str]] = frozenset({"period", "pressure_lag", "adhesion_max"})

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


class SlopeSeeking(GroupLaw):
    """Slip control with a set point on the slope of adhesion over slip.

    Per group, with s the slip less that of a rolling wheel and a = α̂. Neighbouring groups are dithered half a period
    apart; Δ is half the difference between the sliding groups of odd and of even number, ⟨·⟩ a mean over such groups,
    weighted by what each holds, and E one over `window`:

        x, y = Δ⟨ln s⟩, Δ ln⟨a⟩, filtered, high-passed with `washout_time`
        x, y = 0 in E where |y| > dither and xy < −x²/2       a change of the rail, under one group before the others
        e = E(xy)/(E(x²) + log_slip_noise²), its variance from the residual of the regression
        w = spread²/(spread² + var e)                          weight of e: 1 known, 0 unknown
        r = E(x²)/(E(x²) + log_slip_noise²)                    weight of the excitation by changes of slip
        d(ln s_set)/dt = climb_rate·(w (e + bias) + (1 − w)·pull·q + w (1 − r)·pull·max(q, 0)),  q = ln(s_usual/s_set)
        s_usual = slip_usual + creep_usual/v
        s* = s_set·exp(±dither·sin φ)
        T = a F_z r − J (1−s) v̇/r + (J v/r)(ṡ* + gain (s* − s + i))  leads s to s* at `gain`
        di/dt = (s* − s)/0.2 s  while s < s*; else i = 0              what valves hold back
        p = p(T), with the estimated pad friction

    All groups share one set point. What a changing rail does to wheels alike cancels in the difference: of one group,
    or of the train's sum, a loss of friction makes slip rise as adhesion falls, which looks like the far side of a
    peak. A train of one group cannot compare, and takes x and y of that group.

    A wheel that is not braked yet rolls, and the slip it shows then is an error of radius or speed: it is averaged and
    taken from all that follows. Wheels worn by 3 % and a radar off by 1 % would else look like slides. The same holds
    later for a wheel that nothing brakes and the rail does not turn: where the train's speed is wrong, all wheels seem
    to slide, are released, roll, and show by how much.

    Start: a wheel with slip below slip_small + creep_small/v rolls, and is braked as far as `adhesion_max` allows.
    Low adhesion alone does not mean rolling: on oil a sliding wheel has hardly any. Standstill: below `speed_min` the
    slip is no longer known, and the brake is applied as at the start.

    An implausible wheel speed is rejected: an unknown one (NaN), a slip below −5 %, or a slide that does not end
    although the brake is off. Such a group gets the torque for eight tenths of the adhesion that the others use, by the
    pad friction that it had before, until its wheel speed makes sense again; where the pressure is above what all of
    that adhesion carries, its brake is released.
    """

    description = "Slip control on the slope of adhesion over slip"
    needs = ("adhesion", "pad_friction")
    tuning = SlopeTuning
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
    # A set point that moves all the time asks for a pulse at every decision; with 20 instead of 6 kPa a slide costs
    # half the strokes, and no distance.
    valve_band = 20e3

    @staticmethod
    def demand_with(draft: FormulaBuilder, tuning: Mapping[str, Expression]) -> Demand:
        """Return the demand of one group."""
        t = tuning
        started = draft.state("started", "1", "1 once there is a sample before this one")
        draft.keep(started, 1.0)
        train: list[_Wheels] = []
        targets: list[tuple[Expression, Expression]] = []  # of each group, and its rate

        def demand(draft: FormulaBuilder, group: GroupObservation) -> Expression:
            if not train:
                train.extend(_wheels(draft, each, t, started) for each in group.train)
                targets.extend(_targets(draft, train, t))
            target = targets[group.index - 1]
            signals, brake, speed = train[group.index - 1], group.brake, group.speed
            radius = brake["wheel_radius"]
            inertia = brake["inertia"]
            rolling = either(ca.logic_not(signals.sliding), speed < t["speed_min"])

            # The torque that leads to the set point.
            unit_torque = brake["load"] * radius  # torque per adhesion
            inertial = -inertia * (1.0 - signals.slip) * group.acceleration / radius
            balance = group.adhesion * unit_torque + inertial
            limit = (t["adhesion_max"] - t["adhesion_guard"]) * unit_torque + inertial
            torque_per_rate = inertia * speed / radius  # of slip
            error = target[0] - signals.slip
            last = draft.state(group.label("error"), "s", "integral of slip below its set point, since it last was not")
            integral = choose(every(ca.logic_not(rolling), error > 0.0), last + error * t["period"], 0.0)
            draft.keep(last, integral)
            # Up in small shares, down as far as it takes: a deep slide draws little, and a share of little ends none.
            extra = ca.fmin(torque_per_rate * (target[1] + t["gain"] * error), t["share_added"] * balance)
            goal = balance + extra + torque_per_rate * t["gain"] / _PATIENCE * integral
            torque = choose(rolling, limit, ca.fmin(goal, limit))
            venting = every(signals.slip > t["slip_vent"], speed >= t["speed_min"])
            controlled = choose(venting, 0.0, pressure_for(torque, group.pad_friction, brake))
            # A wheel whose speed is not known is given the adhesion of the others.
            others = [each for each in train if each is not signals]
            compared = either(0.0, *(each.valid for each in others))
            following = every(ca.logic_not(signals.valid), compared, speed >= t["speed_min"])
            mode = choose(rolling, _ROLLING, choose(venting, _VENTING, _SEEKING))
            draft.show(group.label("mode"), "1", _MODES, choose(following, _FOLLOWING, mode))
            draft.show(group.label("slip_target"), "1", "slip that is sought, dither included", target[0])
            before = draft.state(
                group.label("pad_friction"), "1", "pad friction when the wheel speed was last credible"
            )
            pad_friction = choose(either(signals.credible, before <= 0.0), group.pad_friction, before)
            draft.keep(before, pad_friction)
            if not others:
                return controlled
            loads = [each.group.brake["load"] for each in others]
            share = _mean([(each.valid, each.adhesion) for each in others], loads)
            followed = pressure_for(_FOLLOWED * share * unit_torque, pad_friction, brake)
            # Valves hold a pressure slightly too high: a wheel without a speed reading locks by it once the rail gets
            # worse.
            most = pressure_for(share * unit_torque, pad_friction, brake)
            followed = choose(group.pressure > most, 0.0, followed)
            return choose(following, followed, controlled)

        return demand


_UNBRAKED = 0.9
"""Share of the spring's force that the piston may have while the pads are surely off."""

_AVERAGED = 1.0  # s, over which the slip of a rolling wheel is averaged, where it rolls for so long
_LEASH, _LEASH_UP = 0.5, 0.8
"""How far ln(s_set) may be below and above ln(s): a set point that the brake cannot reach must not run away."""

_PATIENCE = 0.2
"""Integration time [s] of a slip that stays below its set point.

Left of the peak more slip requires more torque; if a wheel uses little adhesion, the torque that `gain` and
`share_added` allow is less than the band within which valves hold, and slip would remain at a tenth of the set point.
As Clegg's (Trans. AIEE 77 (1958) 41) the integral is zero as soon as the error is, so that it does not act beyond the
peak."""

_RADIUS_ERROR = 0.08  # a larger deviation is implausible: new and worn wheels differ by some 8 %
_SPEED_ERROR = 0.8  # of the train's speed after a radar has lied
_TOUCHING = 1.15  # times the force of the spring, which the law demands where it requires no torque
_NOTHING = 5e-3
"""Adhesion below which nothing turns a wheel: bearings take 0.001, and the estimate's noise is some 0.002."""

_REGAINED = 0.2  # s, over which the slip of a wheel is averaged that rolls again
_ANY_SPEED = 1e6  # rad/s
_BACKWARDS = -0.05  # slip of a braked wheel that no wheel has
_DRAWN = 0.25
"""Minimum adhesion of a sliding wheel over that of the other wheels: creep curves fall to 0.4 of their peak."""

_DOUBTED = 0.5  # s, after which a wheel with an implausible speed is rejected
_FOLLOWED = 0.8
"""Share of the others' adhesion that is demanded from a wheel whose speed is not known: with all it may lock unseen."""

_STEEPEST = 0.5
"""Of adhesion over slip: what falls faster, and farther than the dither takes it, is the rail that changes.

Polach's curves with A = 0.4 fall by up to 0.38, those with A = 0.1 by more than 0.5 where wheels creep at 3 m/s."""

_ROLLING, _SEEKING, _VENTING, _FOLLOWING = range(4)
_MODES = "what rules the group: 0 rolls, 1 seeks slip, 2 vented, 3 its speed is unknown, follows the others"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Wheels:
    """What the law makes of one group.

    Attributes:
        group: As the law is shown it.
        slip: Less that of a rolling wheel.
        filtered: The same, filtered.
        slip_change: Of ln(filtered slip) since the last sample.
        adhesion_change: Of the filtered adhesion since then.
        adhesion: Filtered, not negative.
        credible: Whether its speed is plausible and the group is not in a deep slide.
        valid: Whether its speed can be true, or could a moment ago.
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


def _mean(values: Sequence[tuple[Expression, Expression]], weights: Sequence[Expression]) -> Expression:
    """Return the weighted mean of the values whose condition holds; 0 where none does."""
    counted = [choose(condition, weight, 0.0) for (condition, _), weight in zip(values, weights, strict=True)]
    total = sum(weight * value for weight, (_, value) in zip(counted, values, strict=True))
    return total / ca.fmax(sum(counted), 1e-9)


def _wheels(
    draft: FormulaBuilder, group: GroupObservation, t: Mapping[str, Expression], started: Expression
) -> _Wheels:
    """Return the signals of one group."""
    period, small = t["period"], t["slip_small"] + t["creep_small"] / group.speed
    pads_off = group.pressure * group.brake["piston_area"] < _UNBRAKED * group.brake["spring_force"]
    slip = _correct_slip(draft, group, pads_off, period)

    def filtered(name: str, sample: Expression) -> tuple[Expression, Expression]:
        """Return the filtered value before and now."""
        before = draft.state(group.label(name), "1", "filtered value")
        now = choose(started, before + period / (t["filter_time"] + period) * (sample - before), sample)
        draft.keep(before, now)
        return choose(started, before, now), now

    slip_before, slip_now = filtered("filtered_slip", slip)
    adhesion_before, adhesion_now = filtered("filtered_adhesion", _without_lag(draft, group, t, started))

    # A wheel that slides is turned by the rail, however little, once its brake is off.
    loads = sum(each.brake["load"] for each in group.train)
    mean = sum(each.adhesion * each.brake["load"] for each in group.train) / loads
    turned = group.adhesion > _DRAWN * mean
    doubted = draft.state(group.label("doubted"), "s", "for how long the wheel speed has been one that cannot be")
    impossible = either(
        ca.logic_not(group.wheelset_speed > -_ANY_SPEED),  # not known
        slip < _BACKWARDS,
        every(slip > t["slip_vent"], either(doubted >= _DOUBTED, every(pads_off, ca.logic_not(turned)))),
    )
    doubt = choose(every(impossible, group.speed >= t["speed_min"]), doubted + period, 0.0)
    draft.keep(doubted, doubt)
    valid = doubt < _DOUBTED
    return _Wheels(
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


def _without_lag(
    draft: FormulaBuilder, group: GroupObservation, t: Mapping[str, Expression], started: Expression
) -> Expression:
    """Return the estimated adhesion without the error that the lag of the pressure reading leaves in it.

    What turns a wheel is adhesion less brake torque; a torque known too late leaves the lag times its rate in the
    adhesion. A slip that swings needs a torque that swings with its second derivative, so that the error is in phase
    with the slip, and looks like a slope.
    """
    brake = group.brake
    force = piston_force(group.pressure, piston_area=brake["piston_area"], spring_force=brake["spring_force"])
    torque = brake["units"] * group.pad_friction * brake["friction_radius"] * brake["rigging"] * force
    before = draft.state(group.label("torque"), "N.m", "brake torque at the last sample")
    draft.keep(before, torque)
    rate = choose(started, (torque - before) / t["period"], 0.0)
    return group.adhesion + t["pressure_lag"] * rate / (brake["load"] * brake["wheel_radius"])


def _slope(
    draft: FormulaBuilder,
    train: Sequence[_Wheels],
    signs: Sequence[float],
    t: Mapping[str, Expression],
    rolling: Expression,
) -> tuple[Expression, Expression, Expression]:
    """Return the elasticity of adhesion over slip, and from 0 to 1 how well the rail fits it and how far slip moved.

    Half the difference between the groups of either sign, each a mean of its sliding ones, weighted by their adhesion;
    it does not change while there are no groups of one sign. If all have the same sign, their mean is the difference.
    """
    loads = [each.group.brake["load"] for each in train]

    def mean(part: Sequence[int], values: Sequence[Expression], weights: Sequence[Expression]) -> Expression:
        return _mean([(train[g].sliding, values[g]) for g in part], [weights[g] for g in part])

    def changes(part: Sequence[int]) -> Expression:
        """Return those of ln s and ln a since the last sample."""
        adhesion = mean(part, [each.adhesion for each in train], loads)
        change = mean(part, [each.adhesion_change for each in train], loads)
        forces = [load * each.adhesion for load, each in zip(loads, train, strict=True)]
        slip_change = mean(part, [each.slip_change for each in train], forces)
        return ca.vertcat(slip_change, change / ca.fmax(adhesion, 1e-3))

    parts = [[g for g, other in enumerate(signs) if other == sign] for sign in dict.fromkeys(signs)]
    comparable = every(*(either(*(train[g].sliding for g in part)) for part in parts))
    each = [changes(part) for part in parts]
    x, y = ca.vertsplit(each[0] if len(each) == 1 else 0.5 * (each[0] - each[1]))
    compared = choose(comparable, x, 0.0), choose(comparable, y, 0.0)
    elasticity, variance, excitation = _regression(draft, t, compared, rolling)
    spread = t["elasticity_spread"] ** 2
    weight = spread / (spread + variance)
    draft.show("elasticity", "1", "of adhesion over slip, as estimated", elasticity)
    draft.show("belief", "1", "how far that is believed: 0 not at all, 1 wholly", weight * excitation)
    return elasticity, weight, excitation


def _targets(
    draft: FormulaBuilder, train: Sequence[_Wheels], t: Mapping[str, Expression]
) -> list[tuple[Expression, Expression]]:
    """Return the slip that is sought of each group, dither included, and its rate."""
    period, speed = t["period"], train[0].group.speed
    rolling = either(every(*(ca.logic_not(each.sliding) for each in train)), speed < t["speed_min"])
    signs = [1.0 if g % 2 == 0 else -1.0 for g in range(len(train))]
    elasticity, weight, excitation = _slope(draft, train, signs, t, rolling)

    usual = ca.log(ca.fmin(t["slip_usual"] + t["creep_usual"] / speed, t["slip_most"]))
    previous = draft.state("set_point", "1", "logarithm of the slip that is sought; 0 before the first")
    last = choose(previous < 0.0, previous, usual)
    expected = weight * (elasticity + t["elasticity_bias"]) + (1.0 - weight) * t["pull"] * (usual - last)
    # Without excitation any rail fits the observations: below the usual slip the set point must not stay there.
    expected += weight * (1.0 - excitation) * t["pull"] * ca.fmax(usual - last, 0.0)
    moved = last + within(t["climb_rate"] * expected, -t["fall_rate"], t["rise_rate"]) * period
    least = t["slip_small"] + t["creep_small"] / speed
    forces = [each.group.brake["load"] * each.adhesion for each in train]
    present = _mean([(each.sliding, ca.log(ca.fmax(each.filtered, least))) for each in train], forces)
    near = within(moved, present - _LEASH, present + _LEASH_UP)
    set_point = choose(rolling, last, within(near, ca.log(least), ca.log(t["slip_most"]) - t["dither"]))
    draft.keep(previous, set_point)
    phase = draft.state("phase", "1", "periods of the dither since the start")
    draft.keep(phase, phase + period / t["dither_time"])
    angle = 2.0 * pi * phase
    targets: list[tuple[Expression, Expression]] = []
    for sign in signs:
        target = ca.exp(set_point + sign * t["dither"] * ca.sin(angle))
        targets.append((target, sign * target * t["dither"] * 2.0 * pi / t["dither_time"] * ca.cos(angle)))
    return targets


def _correct_slip(
    draft: FormulaBuilder, group: GroupObservation, pads_off: Expression, period: Expression
) -> Expression:
    """Return the slip less what the wheel showed when it surely rolled.

    That is so before it has been braked, and again when its pads have been off for long and it draws no adhesion: a
    wheel that slides is turned by the rail. Then it is the train's speed that is wrong, as after a radar has lied.
    """
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
    draft: FormulaBuilder, t: Mapping[str, Expression], changes: tuple[Expression, Expression], rolling: Expression
) -> tuple[Expression, Expression, Expression]:
    """Return the elasticity d(ln α)/d(ln s), its variance, and the share of the excitation above noise, from 0 to 1.

    Args:
        draft: Keeps the moments.
        t: The parameters.
        changes: Of ln s and ln α since the last sample.
        rolling: Whether the wheel rolls; without slip the estimate is reset.
    """
    forgets, fades = t["period"] / t["window"], 1.0 - t["period"] / t["washout_time"]
    names = ("log_slip", "log_adhesion")
    states = [draft.state(name, "1", f"{name}, less what is slow") for name in names]
    x, y = (fades * (last + change) for last, change in zip(states, changes, strict=True))
    for state, value in zip(states, (x, y), strict=True):
        draft.keep(state, choose(rolling, fades * state, value))
    rail = every(x * y < -_STEEPEST * x * x, ca.fabs(y) > t["dither"])
    moments: list[Expression] = []
    for name, product in (("slip_slip", x * x), ("slip_adhesion", x * y), ("adhesion_adhesion", y * y)):
        state = draft.state(name, "1", f"mean of {name.replace('_', ' times ')}, logarithms")
        moments.append((1.0 - forgets) * state + forgets * choose(rail, 0.0, product))
        draft.keep(state, choose(rolling, (1.0 - forgets) * state, moments[-1]))
    xx, xy, yy = moments
    excited = xx + t["log_slip_noise"] ** 2
    elasticity = xy / excited
    residual = ca.fmax(yy - xy * xy / ca.fmax(xx, 1e-12), 0.0)
    independent = ca.fmax(t["window"] / t["correlation_time"], 1.0)
    variance = residual / (excited * independent)
    return elasticity, variance, xx / excited
