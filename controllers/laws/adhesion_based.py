"""Adhesion-based control (ABC): seek the peak of adhesion by the sliding-mode law of Schwarz, Posielek, Goetjes (2021).

The law as printed is in `railgrip.controllers.laws.adhesion_literal`. Here it is sliding mode with equivalent control:
the estimated adhesion gives the pressure that would keep the slip where it is (the equivalent control, from the torque
balance of the wheelset); the sign of ṡ·α̇ only says whether to go a little above or below it. The paper allows L to
depend on the states to compensate f_s.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

from railgrip.controllers.brake import pressure_for
from railgrip.controllers.law import Demand, GroupLaw, GroupObservation, Ranges
from railgrip.controllers.laws.adhesion_literal import Derivatives, SwitchingTuning, is_rolling
from railgrip.controllers.sampled import Expression, FormulaBuilder, choose, either, every


@dataclass(frozen=True, slots=True, kw_only=True)
class PeakSeekingTuning(SwitchingTuning):
    """Parameters of peak seeking; one set serves every scenario.

    A `margin` of zero is the peak itself; a small positive one keeps a rise of adhesion along the track from being
    taken for an effect of the slip. The guard keeps an estimate with an error of 0.003 from passing `adhesion_max`.
    """

    margin: Annotated[float, "1", "elasticity of adhesion over slip at which the peak counts as reached"]
    rise: Annotated[float, "1", "share of the equivalent torque added while seeking upwards"]
    fall: Annotated[float, "1", "share of it taken away while seeking downwards"]
    slip_rate_max: Annotated[float, "1/s", "largest relative slip rate that a torque may cause"]
    slip_rate_min: Annotated[float, "1/s", "relative slip rate below which slip is led upwards"]
    dwell: Annotated[float, "s", "shortest time between two changes of direction"]
    slip_vent: Annotated[float, "1", "slip above which the brake is released"]
    adhesion_guard: Annotated[float, "1", "distance below adhesion_max at which the torque is capped"] = 0.003

    LAW: ClassVar[str] = "AdhesionBased"


class AdhesionBased(GroupLaw):
    """Sliding-mode peak seeking with equivalent control.

    Per group, with a = α̂ and ˙ the filtered derivative:

        σ = (ṡ/s)·(α̇/α − margin·ṡ/s)                     switching function, eq. (10) in relative rates
        T_eq = α̂ F_z r − J (1−s) v̇/r                     torque at which ṡ = 0
        p = p(T_eq + L·sgn σ),  L = rise or fall · T_eq, limited to J·slip_rate_max·s·v/r

    The relative rates make the law independent of the scale of the adhesion curve: peaks lie anywhere between 0.5 %
    and 40 % slip. Dropped from eq. (12) are ∂α/∂v·v̇ and ∂α/∂μ0·μ̇0; a rising μ0 would drive the slip up without end,
    which `margin` (and at the last `slip_vent`) prevents.

    Start: a wheel with slip below slip_small + creep_small/v or adhesion below `adhesion_small` is rolling. It is
    braked as far as `adhesion_max` allows; it is the torque for this adhesion that is capped, with the estimated pad
    friction. The bound must lie above the error of the slip at every speed. Below that error nothing can be sought: the
    wheel does not slide, ṡ·α̇ is noise, and T_eq holds whatever pressure there is. A speed that is too high by δ looks
    like a slip of δ/v: with an accelerometer off by 0.12 m/s² the filter's is by 0.05 m/s, 0.2 % at 80 km/h and 1 % at
    18 km/h. A bound in slip alone that suits one of them takes the wheel for sliding at the other, and blocks.
    Standstill: below `speed_min` the slip is no longer known well enough to seek, and the brake is applied as at the
    start.
    """

    description = "Adhesion-based wheel-slide protection, peak seeking"
    needs = ("adhesion", "pad_friction")
    tuning = PeakSeekingTuning
    # Times and rates go from quicker than the actuation to slower than the rail. From what slip on there is a peak to
    # seek depends on the smallest slip that sensors resolve; ideal sensors resolve any.
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

    @staticmethod
    def demand_with(draft: FormulaBuilder, tuning: Mapping[str, Expression]) -> Demand:
        """Return the demand of one group."""
        filters = Derivatives(draft, tuning)

        def demand(draft: FormulaBuilder, group: GroupObservation) -> Expression:
            brake, radius, inertia = group.brake, group.brake["wheel_radius"], group.brake["inertia"]
            slip, slip_rate = filters.follow(draft, group.label("seen_slip"), group.slip)
            adhesion, adhesion_rate = filters.follow(draft, group.label("seen_adhesion"), group.adhesion)
            upwards = draft.state(group.label("upwards"), "1", "1 while it seeks upwards", start=1.0)
            wait = draft.state(group.label("wait"), "s", "until the direction may change again")
            seeking, creeping = group.speed >= tuning["speed_min"], group.speed < tuning["speed_min"]
            venting = every(group.slip > tuning["slip_vent"], seeking)
            rolling = either(is_rolling(tuning, group.speed, slip, adhesion), creeping)

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
