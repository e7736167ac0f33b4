"""Peak seeking (railgrip): seek the peak of adhesion, after the law of Schwarz, Posielek, Goetjes (2021).

The law as printed is in `railgrip.controllers.laws.adhesion_literal`, "ABC (paper)" in tables. This one is sliding mode
with equivalent control: the estimated adhesion gives the pressure that would keep the slip constant (the equivalent
control, from the torque balance of the wheelset), and the sign of ṡ·α̇ decides only whether to demand slightly more or
less. The paper allows this: L may be a function of the states to compensate their influence (end of §3.2).
"""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from railgrip.controllers.law import GroupLaw, GroupObservation, Ranges, pressure_for
from railgrip.controllers.laws.adhesion_literal import SwitchingTuning, is_rolling
from railgrip.controllers.sampled import Expression, FormulaBuilder, Symbols, choose, either, every, low_pass


@dataclass(frozen=True, slots=True, kw_only=True)
class AdhesionBasedTuning(SwitchingTuning):
    """Parameters of peak seeking.

    With a `margin` of zero the law seeks the peak itself; with a small positive one a rise of adhesion along the track
    is not mistaken for an effect of the slip. The guard keeps the true adhesion below `adhesion_max` if the estimate
    has an error of 0.003.
    """

    margin: Annotated[float, "1", "elasticity of adhesion over slip at which the peak counts as reached"]
    rise: Annotated[float, "1", "share of the equivalent torque added while seeking upwards"]
    fall: Annotated[float, "1", "share of the equivalent torque subtracted while seeking downwards"]
    slip_rate_max: Annotated[float, "1/s", "largest relative slip rate that a torque may cause"]
    slip_rate_min: Annotated[float, "1/s", "relative slip rate below which slip is increased"]
    dwell: Annotated[float, "s", "shortest time between two changes of direction"]
    slip_vent: Annotated[float, "1", "slip above which the brake is released"]
    adhesion_guard: Annotated[float, "1", "distance below adhesion_max at which the torque is capped"] = 0.003


class AdhesionBased(GroupLaw):
    """Sliding-mode peak seeking with equivalent control.

    Per group, with the estimated adhesion α and the slip s, both low-pass filtered, and their derivatives:

        σ = (ṡ/s)·(α̇/α − margin·ṡ/s)                     switching function, eq. (10) in relative rates
        T_eq = α F_z r − J (1−s) v̇/r                     torque at which ṡ = 0
        p = p(T_eq + L·sgn σ)                            eq. (11), limited to adhesion_max − adhesion_guard
        L = rise·T_eq or fall·T_eq                       limited to J·slip_rate_max·s·v/r

    The relative rates make the law independent of the scale of the adhesion curve, whose peak may be anywhere between
    0.5 % and 40 % slip. Eq. (12) neglects ∂α/∂v·v̇, and does not have ∂α/∂μ0·μ̇0 because the paper's α does not depend
    on time: a rising μ0 would increase the slip without end, which `margin`, and finally `slip_vent`, prevents.

    Start: a wheel with slip below slip_small + creep_small/v or adhesion below `adhesion_small` is rolling. It is
    braked as far as `adhesion_max` allows, with the pressure that gives this torque at the estimated pad friction.

    The bound on slip must exceed the error of the slip at every speed. Below that error the wheel does not slide: ṡ·α̇
    is noise, and T_eq only keeps the present pressure. A speed that is too high by δ looks like a slip of δ/v: an
    accelerometer with an error of 0.12 m/s² causes an error of 0.05 m/s in the filter's speed, 0.2 % of slip at 80 km/h
    and 1 % at 18 km/h. A bound in slip alone that suits one of these speeds mistakes a rolling wheel for a sliding one
    at the other, and the law stays at a low pressure.

    Standstill: below `speed_min` the slip is not known well enough to seek, and the brake is applied as at the start.
    """

    description = "Adhesion-based wheel-slide protection, peak seeking"
    needs = ("adhesion", "pad_friction")
    tuning = AdhesionBasedTuning
    # Times and rates range from faster than the actuation to slower than changes of the rail. `slip_small` and
    # `creep_small` depend on the smallest slip that the sensors resolve; ideal sensors resolve any, so they are fixed.
    ranges: ClassVar[Ranges] = {
        ("ideal", "estimated"): {
            "filter_time": (3e-3, 50e-3),
            "margin": (3e-3, 0.1),
            "rise": (0.03, 0.5),
            "fall": (0.03, 0.5),
            "slip_rate_max": (1.0, 20.0),
            "slip_rate_min": (0.02, 1.0),
            "dwell": (3e-3, 0.3),
            "slip_vent": (0.1, 0.6),
            "adhesion_small": (5e-3, 3e-2),
        },
        ("pneumatic", "estimated"): {
            "filter_time": (30e-3, 0.5),
            "margin": (3e-3, 0.1),
            "rise": (0.03, 0.5),
            "fall": (0.03, 0.5),
            "slip_rate_max": (0.3, 10.0),
            "slip_rate_min": (0.02, 1.0),
            "dwell": (0.03, 1.0),
            "slip_small": (1e-3, 3e-2),
            "creep_small": (0.01, 0.2),
            "slip_vent": (0.1, 0.6),
            "adhesion_small": (5e-3, 3e-2),
        },
    }

    @classmethod
    def demand(cls, draft: FormulaBuilder, tuning: Symbols, group: GroupObservation) -> Expression:
        """Return the demanded pressure of one group [Pa]."""
        brake, radius, inertia = group.brake, group.brake["wheel_radius"], group.brake["inertia"]
        slip, slip_rate = low_pass(draft, tuning, group.label("seen_slip"), group.slip)
        adhesion, adhesion_rate = low_pass(draft, tuning, group.label("seen_adhesion"), group.adhesion)
        upwards = draft.state(group.label("upwards"), "1", "1 while it seeks upwards", start=1.0)
        wait = draft.state(group.label("wait"), "s", "until the direction may change again")
        # The vent uses the unfiltered slip: the filter would delay it.
        seeking, creeping = group.speed >= tuning["speed_min"], group.speed < tuning["speed_min"]
        venting = every(group.slip > tuning["slip_vent"], seeking)
        rolling = either(is_rolling(tuning, group.speed, slip, adhesion), creeping)

        # Direction: sign of the switching function (10), σ = ṡ·α̇, in relative rates. For ṡ ≠ 0 it is the sign of
        # ∂α/∂s, eq. (13). For ṡ ≈ 0 it is noise, so the slip is increased until the response of α is measurable.
        s_rate, a_rate = slip_rate / slip, adhesion_rate / adhesion
        still = every(-tuning["slip_rate_min"] < s_rate, s_rate < tuning["slip_rate_min"])
        rising = either(still, s_rate * (a_rate - tuning["margin"] * s_rate) > 0.0)
        # Right after a reversal σ is still the response to the previous direction: a direction lasts for `dwell`.
        remaining = wait - tuning["period"]
        direction = choose(remaining > 0.0, upwards, rising)
        new_wait = choose(direction != upwards, tuning["dwell"], remaining)

        # Equivalent control: ṡ = 0 in eq. (3), with J ω̇ = F_x r − T and ω̇ = (1 − s) v̇/r at constant slip.
        unit_torque = brake["load"] * radius  # torque per adhesion
        inertial = -inertia * (1.0 - group.slip) * group.acceleration / radius
        # Below speed_min a wheel may lock: then the contact carries all of the brake torque.
        limit = (tuning["adhesion_max"] - tuning["adhesion_guard"]) * unit_torque + choose(creeping, 0.0, inertial)
        equivalent = adhesion * unit_torque + inertial
        # L·sgn σ of eq. (11), with L proportional to T_eq. An additional torque ΔT changes the slip at the rate
        # ΔT r/(J v), which is limited to slip_rate_max·s: at low speed the slip would otherwise leap over the peak.
        extra = choose(direction, tuning["rise"], tuning["fall"]) * equivalent
        extra_max = inertia * tuning["slip_rate_max"] * slip * group.speed / radius
        extra = choose(extra > extra_max, extra_max, extra)
        goal = choose(direction, equivalent + extra, equivalent - extra)
        torque = choose(rolling, limit, choose(goal < limit, goal, limit))

        # A vented group was beyond the peak, so it continues downwards; one that rolled starts upwards.
        draft.keep(upwards, choose(venting, 0.0, choose(rolling, 1.0, direction)))
        draft.keep(wait, choose(either(venting, rolling), wait, new_wait))
        return choose(venting, 0.0, pressure_for(torque, group.pad_friction, brake))
