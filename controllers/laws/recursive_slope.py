"""Maximum-adhesion tracking on the slope of adhesion over slip from recursive least squares."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

from railgrip.controllers.law import DitheredSlipLaw, DitheredSlipTuning, GroupObservation, Ranges
from railgrip.controllers.laws.constant_slip import slip_control
from railgrip.controllers.sampled import Expression, FormulaBuilder, Symbols, choose, every, within
from railgrip.vehicle.brake import Brake


@dataclass(frozen=True, slots=True, kw_only=True)
class RecursiveSlopeTuning(DitheredSlipTuning):
    """Parameters of tracking by recursive least squares.

    `covariance_max` limits the growth of the covariance while the slip
    does not change.
    """

    memory: Annotated[float, "s", "time constant of forgetting"]
    covariance_max: Annotated[float, "1", "maximum of the covariance of the slope over the noise"] = 1e3
    frequency: Annotated[float, "Hz", "of the dither"] = 1.0

    POSITIVE: ClassVar[frozenset[str]] = frozenset(
        {"period", "slip_start", "slip_least", "memory", "covariance_max", "integral_time", "adhesion_small"}
    )


class RecursiveSlope(DitheredSlipLaw):
    """Gradient tracking of the maximum adhesion; PI control holds the slip.

    Per group, with x and y the high-pass filtered relative slip s/s_set and relative adhesion α/ᾱ, the elasticity
    e = d ln α/d ln s follows from recursive least squares with the forgetting factor λ = memory/(memory + period):

        K = P x/(λ + P x²),  e ← e + K (y − e x) within ±1,  P ← min((1 − K x) P/λ, covariance_max)
        ṡ_set/s_set = climb·e,  and slip control is given s_set (1 + dither·sin ωt)

    Sources: the gradient method of maximum adhesion tracking as reviewed by Abouzeid, Guerrero, Lejarza, Muniategui,
    Endemaño and Briz, arXiv:2406.13650 (2024); the slope of the friction curve, calculated while braking, as the
    reference of slip control, Automatika 60 (2019) 413; the recursion, Ljung, System Identification (1999), §11.2.
    Relative quantities are this project's, as in `railgrip.controllers.laws.extremum_seeking`.
    """

    description = "Wheel-slide protection on the slope from recursive least squares"
    tuning = RecursiveSlopeTuning
    ranges: ClassVar[Ranges] = {
        ("pneumatic", "estimated"): {
            "slip_start": (0.01, 0.15),
            "washout_time": (0.2, 3.0),
            "memory": (0.2, 5.0),
            "dither": (0.03, 0.5),
            "climb": (0.1, 3.0),
            "gain": (0.05, 1.0),
            "integral_time": (0.1, 2.0),
        }
    }

    def __init__(self, groups: Sequence[Brake], tuning: RecursiveSlopeTuning) -> None:
        """Control `groups` with one `tuning`, starting with its first set slip and an unknown slope."""
        super().__init__(groups, tuning)
        self.state[[quantity.name.startswith("covariance") for quantity in self.formula.states]] = tuning.covariance_max

    @classmethod
    def demand(cls, draft: FormulaBuilder, tuning: Symbols, group: GroupObservation) -> Expression:
        """Return the demanded pressure of one group [Pa]."""
        period = tuning["period"]
        share = period / (tuning["washout_time"] + period)
        forgetting = tuning["memory"] / (tuning["memory"] + period)
        slip = draft.state(group.label("set_slip"), "1", "set slip without the dither")
        last_slip = draft.state(group.label("steady_slip"), "1", "low-pass filtered slip")
        last_adhesion = draft.state(group.label("steady_adhesion"), "1", "low-pass filtered adhesion")
        elasticity = draft.state(group.label("elasticity"), "1", "estimate of d ln α/d ln s")
        covariance = draft.state(group.label("covariance"), "1", "covariance of the estimate over the noise")
        started = draft.state(group.label("started"), "1", "1 once the filters have a sample")
        ready = every(group.adhesion >= tuning["adhesion_small"], group.speed >= tuning["speed_min"])
        mean_slip = choose(started, last_slip + share * (group.slip - last_slip), group.slip)
        mean_adhesion = choose(started, last_adhesion + share * (group.adhesion - last_adhesion), group.adhesion)
        x, y = (group.slip - mean_slip) / slip, (group.adhesion - mean_adhesion) / mean_adhesion
        gain = covariance * x / (forgetting + covariance * x * x)
        estimate = within(elasticity + gain * (y - elasticity * x), -1.0, 1.0)
        new_covariance = within((1.0 - gain * x) * covariance / forgetting, 0.0, tuning["covariance_max"])
        moved = slip * (1.0 + tuning["climb"] * estimate * period)
        draft.keep(slip, choose(ready, within(moved, tuning["slip_least"], tuning["slip_most"]), slip))
        draft.keep(last_slip, choose(ready, mean_slip, last_slip))
        draft.keep(last_adhesion, choose(ready, mean_adhesion, last_adhesion))
        draft.keep(elasticity, choose(ready, estimate, elasticity))
        draft.keep(covariance, choose(ready, new_covariance, covariance))
        draft.keep(started, choose(ready, 1.0, 0.0))
        return slip_control(draft, group, tuning, slip * (1.0 + tuning["dither"] * tuning["wave"]))
