"""Deceleration control of the whole train, to a target or as the driver demands, over slide protection of its groups.

Measured deceleration corrects the brake force, and slide protection limits that of each group. Where adhesion is
exhausted, other groups take over, sand is laid, the train brakes ahead of its curve while it can, and magnets are
lowered if all that is not enough.

Sources: the curve of constant deceleration v²/(2 d) and its gain are those of the driver in
`railgrip.scenario.demand`; anti-windup by back-calculation, Åström and Hägglund, Advanced PID Control (2006), §3.5. The
use of the estimated adhesion is this project's.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import casadi as ca

from railgrip.controllers.law import GroupObservation, Ranges, pressure_for
from railgrip.controllers.laws.slope_seeking import SlopeSeeking, SlopeSeekingTuning
from railgrip.controllers.sampled import Expression, FormulaBuilder, Symbols, choose, either, every, within
from railgrip.controllers.train_level import PAD_FRICTION, T_REDISTRIBUTION
from railgrip.vehicle.brake import pad_force


@dataclass(frozen=True, slots=True, kw_only=True)
class DecelerationControlTuning(SlopeSeekingTuning):
    """Parameters of `DecelerationControl`, besides those of `SlopeSeeking`."""

    target: Annotated[float, "m", "distance of the target from the start; 0: none, the driver's demand is followed"] = (
        0.0
    )
    deceleration: Annotated[float, "m/s2", "of the curve to the target; before it the brake is released"] = 0.6
    emergency: Annotated[float, "m/s2", "deceleration to the target from which it brakes as the emergency brake"] = 1.1
    curve_gain: Annotated[float, "1", "gain on the deviation from the curve, in addition to the deviation"] = 2.0
    integral_gain: Annotated[float, "1/s", "gain of the integral of measured deceleration"]
    response_time: Annotated[float, "s", "time constant of the brake, after which deceleration is expected"]
    integral_max: Annotated[float, "m/s2", "largest correction by the integral, of either sign"] = 0.5
    managed: Annotated[
        float, "1", "1: anti-windup, redistribution, reserve, sand and magnets on need; 0: none, sand always", 1.0
    ] = 1.0  # fmt: skip
    reserve: Annotated[float, "1", "share that is demanded in addition on an exhausted rail"]
    utilisation_sand: Annotated[float, "1", "demanded over available adhesion from which sand is laid"]
    utilisation_full: Annotated[float, "1", "the same, from which the whole reserve is demanded"] = 1.0
    utilisation_rise: Annotated[float, "s", "time constant of a rising utilisation"] = 0.3
    utilisation_fall: Annotated[float, "s", "time constant of a falling utilisation: how long a rail is remembered"]
    speed_min: Annotated[float, "m/s", "train speed below which slide protection is off: errors of speed are slip"] = (
        1.5
    )
    sand_speed: Annotated[float, "m/s", "train speed below which no sand is laid"] = 1.0

    POSITIVE: ClassVar[frozenset[str]] = SlopeSeekingTuning.POSITIVE | {"deceleration", "emergency"}
    ORDER: ClassVar[tuple[str, ...]] = (
        *SlopeSeekingTuning.ORDER,
        "deceleration < emergency",
        "utilisation_sand < utilisation_full",
    )


class DecelerationControl(SlopeSeeking):
    """Deceleration control with the slide protection of `SlopeSeeking`.

    With the distance d to the target, by integration of the speed v, or without a target by the driver's pressures:

        a_d = v²/(2 d) + curve_gain (v²/(2 d) − deceleration)     once v²/(2 d) has reached `deceleration`; before, 0
        a_d = Σ F_g/m                                             F_g of the driver's pressures with nominal pads
        a* = a_d (1 + reserve · ((u − utilisation_sand)/(utilisation_full − utilisation_sand)), limited to 0 … 1)
        α* = (a* + i)/g                                           demanded adhesion, equal for all groups
        di/dt = integral_gain (⟨min(a*, g ᾱ − i)⟩ − a)            a measured, ⟨·⟩ first order with `response_time`
        p_g = min(p(α* + ΔF/G_free), protected)                   ΔF force that limited groups lack, filtered
        u = α*/ᾱ                                                  utilisation, which rises faster than it falls

    A group is limited where its slide protection demands less than p(α*), or p(α*) is full pressure. Its available
    adhesion is the estimated one then, else `adhesion_max`; ᾱ is the mean over the loads, and G_free the load of groups
    that are not limited. The integral corrects errors of mass, pads and gradient, and does not wind up where the rail
    limits the force, because it expects no more than ᾱ. On such a rail the train brakes harder than its curve, as far
    as it can, because the next place may be worse.

    Sand is demanded while u exceeds `utilisation_sand`. Magnets, the last reserve, are demanded where a_d exceeds the
    deceleration that the available adhesion allows. Both are states, which the scenario's sanders and the plant's track
    brakes follow.

    Where the driver demands full pressure, and with a target beyond it or from v²/(2 d) = `emergency` on, the demand is
    that of slide protection alone, with sand and magnets: it is never later than the emergency brake.
    """

    description = "Deceleration control of the train over slip control on the slope of adhesion"
    tuning = DecelerationControlTuning
    exceeds_driver = True
    # `railgrip study stop_at_target` searches this law by the error of the stopping point, not by the distance.
    ranges: ClassVar[Ranges] = {}

    @classmethod
    def demands(cls, draft: FormulaBuilder, tuning: Symbols, train: Sequence[GroupObservation]) -> list[Expression]:
        """Return the demanded pressure of each group [Pa]."""
        protected, t = super().demands(draft, tuning, train), tuning
        period, managed, highest = t["period"], t["managed"] > 0.5, t["adhesion_max"]
        speed, loads = ca.fmax(train[0].speed, 0.0), [group.brake["load"] for group in train]
        load = sum(loads)
        demanded, emergency = _demanded(draft, train, t, speed)
        braking = either(demanded > 0.0, emergency)

        # The utilisation of the last call, because that of this call depends on the demand.
        used = draft.state("used", "1", "demanded over available adhesion")
        strain = (used - t["utilisation_sand"]) / (t["utilisation_full"] - t["utilisation_sand"])
        intended = demanded * (1.0 + choose(managed, t["reserve"] * within(strain, 0.0, 1.0), 0.0))
        integral = draft.state("integral", "m/s2", "correction of the demanded deceleration")
        adhesion = within((intended + integral) / _G, 0.0, highest)

        alone = [_pressure(group, adhesion) for group in train]
        limited = [
            either(most < p, p >= _FULL * group.brake["pressure_max"])
            for group, p, most in zip(train, alone, protected, strict=True)
        ]
        available = [
            choose(is_limited, within(group.adhesion, 0.0, highest), highest)
            for group, is_limited in zip(train, limited, strict=True)
        ]
        lacks = sum(w * ca.fmax(adhesion - a, 0.0) for w, a in zip(loads, available, strict=True))
        free = sum(choose(is_limited, 0.0, w) for is_limited, w in zip(limited, loads, strict=True))
        possible = sum(w * a for w, a in zip(loads, available, strict=True)) / load
        lacking = _follow(draft, ("lacking", "N", "force that limited groups lack, filtered"),
                          choose(braking, lacks, 0.0), T_REDISTRIBUTION, period)  # fmt: skip
        more = choose(managed, lacking / ca.fmax(free, 1e-3 * load), 0.0)

        reachable = choose(managed, ca.fmin(intended, _G * possible - integral), intended)
        expected = _follow(
            draft,
            ("expected", "m/s2", "deceleration expected after the response of the brake"),
            choose(braking, reachable, 0.0),
            t["response_time"],
            period,
        )
        lowered = draft.state("lowered", "1", "1 while magnets are demanded")
        # The force of magnets is not known.
        steady = every(braking, ca.logic_not(emergency), speed > _CREEPING, lowered < 0.5)
        moved = integral + t["integral_gain"] * (expected + train[0].acceleration) * period
        draft.keep(integral, choose(steady, within(moved, -t["integral_max"], t["integral_max"]), integral))

        ratio = choose(every(braking, speed > _CREEPING), adhesion / ca.fmax(possible, 1e-3), used)
        time = choose(ratio > used, t["utilisation_rise"], t["utilisation_fall"])
        now = used + period / (time + period) * (ratio - used)
        draft.keep(used, now)
        draft.show("utilisation", "1", "demanded over available adhesion of the train", now)
        useful = every(speed > t["sand_speed"], either(now > t["utilisation_sand"], ca.logic_not(managed)))
        draft.show("sand", "1", "1 while sand is demanded", choose(either(emergency, every(braking, useful)), 1.0, 0.0))
        fails = demanded > _G * possible * choose(lowered > 0.5, _ENOUGH, 1.0)
        lowering = choose(either(emergency, every(managed, braking, fails)), 1.0, 0.0)
        draft.keep(lowered, lowering)
        draft.show("magnets", "1", "1 while magnetic track brakes are demanded", lowering)

        pressures = [_pressure(group, adhesion + more) for group in train]
        controlled = [choose(braking, ca.fmin(p, most), 0.0) for p, most in zip(pressures, protected, strict=True)]
        return [choose(emergency, most, p) for p, most in zip(controlled, protected, strict=True)]


_G = 9.81
_NEAREST = 0.25  # m; the deceleration to a nearer target would be noise
_CREEPING = 1.0  # m/s, below which integral and utilisation stay: the jerk of the halt is not an error of the brakes
_FULL = 0.99  # share of full pressure from which the driver demands full brake
_ENOUGH = 0.7  # share of the possible deceleration below which magnets are lifted


def _demanded(
    draft: FormulaBuilder, train: Sequence[GroupObservation], t: Symbols, speed: Expression
) -> tuple[Expression, Expression]:
    """Return the demanded deceleration [m/s2], and whether the emergency brake is demanded."""
    travelled = draft.state("travelled", "m", "distance since the start, by the speed")
    # The first calls may have no speed yet: NaN must not enter the distance.
    draft.keep(travelled, travelled + choose(train[0].speed >= 0.0, speed * t["period"], 0.0))
    distance = t["target"] - travelled
    needed = 0.5 * speed**2 / ca.fmax(distance, _NEAREST)
    begun = draft.state("begun", "1", "1 once the curve has been reached")
    on_curve = either(begun > 0.5, needed >= t["deceleration"])
    draft.keep(begun, choose(on_curve, 1.0, 0.0))
    by_curve = choose(on_curve, ca.fmax(needed + t["curve_gain"] * (needed - t["deceleration"]), 0.0), 0.0)
    passed = either(distance <= 0.0, needed >= t["emergency"])

    forces = [_nominal_force(group) for group in train]
    load = sum(group.brake["load"] for group in train)
    by_driver = sum(ca.fmax(force, 0.0) for force in forces) * _G / load
    full = every(*(group.driver_demand >= _FULL * group.brake["pressure_max"] for group in train))
    has_target = t["target"] > 0.0
    return choose(has_target, by_curve, by_driver), choose(has_target, passed, full) > 0.5


def _nominal_force(group: GroupObservation) -> Expression:
    """Return the brake force [N] of the driver's pressure with nominal pads."""
    brake = group.brake
    of_unit = pad_force(
        group.driver_demand, **{name: brake[name] for name in ("piston_area", "spring_force", "rigging")}
    )
    return brake["units"] * PAD_FRICTION * brake["friction_radius"] * of_unit / brake["wheel_radius"]


def _follow(
    draft: FormulaBuilder, state: tuple[str, str, str], value: Expression, time: Expression | float, period: Expression
) -> Expression:
    """Return a value after a first-order lag with a time constant [s], kept as a state."""
    last = draft.state(*state)
    now = last + period / (time + period) * (value - last)
    draft.keep(last, now)
    return now


def _pressure(group: GroupObservation, adhesion: Expression) -> Expression:
    torque = adhesion * group.brake["load"] * group.brake["wheel_radius"]
    return pressure_for(torque, group.pad_friction, group.brake)
