"""Extremum seeking as in the literature: the set slip is dithered and moves in the direction of higher adhesion."""

from dataclasses import dataclass
from typing import ClassVar

from railgrip.controllers.law import DitheredSlipLaw, DitheredSlipTuning, GroupObservation, Ranges
from railgrip.controllers.laws.constant_slip import slip_control
from railgrip.controllers.sampled import Expression, FormulaBuilder, Symbols, choose, within


@dataclass(frozen=True, slots=True, kw_only=True)
class ExtremumSeekingTuning(DitheredSlipTuning):
    """Parameters of extremum seeking."""

    POSITIVE: ClassVar[frozenset[str]] = frozenset(
        {"period", "slip_start", "slip_least", "dither", "frequency", "integral_time", "adhesion_small"}
    )

    def __post_init__(self) -> None:
        """Check the parameters.

        Raises:
            ValueError: See `Tuning`; or the dither is too fast for the period.
        """
        DitheredSlipTuning.__post_init__(self)
        if self.frequency * self.period >= 0.25:
            raise ValueError(
                f"ExtremumSeeking: frequency {self.frequency} Hz leaves less than four decisions of {self.period} s to "
                "a wave; lower it."
            )


class ExtremumSeeking(DitheredSlipLaw):
    """Extremum seeking with sinusoidal dither, washout and demodulation; an inner PI loop controls the slip.

    Per group, with estimated adhesion α:

        s_set = ŝ (1 + dither·sin ωt)                    set slip of the inner loop
        η̇ = (α − η)/washout_time                         slow part of the adhesion
        ŝ̇/ŝ = climb · 2/dither · (α − η)/η · sin ωt      within ±frequency; its mean is climb · d ln α/d ln s

    Source: Krstić and Wang, Stability of extremum seeking feedback for general nonlinear dynamic systems, Automatica 36
    (2000) 595; for brakes Ariyur and Krstić, Real-Time Optimization by Extremum-Seeking Control (2003), ch. 7. Relative
    rates in place of absolute ones are this project's, because peaks are anywhere between 0.5 % and 40 % slip.
    """

    description = "Wheel-slide protection by extremum seeking"
    tuning = ExtremumSeekingTuning
    ranges: ClassVar[Ranges] = {
        ("pneumatic", "estimated"): {
            "slip_start": (0.01, 0.15),
            "dither": (0.1, 0.5),
            "frequency": (0.3, 3.0),
            "washout_time": (0.1, 2.0),
            "climb": (0.1, 3.0),
            "gain": (0.05, 1.0),
            "integral_time": (0.1, 2.0),
        }
    }

    @classmethod
    def demand(cls, draft: FormulaBuilder, tuning: Symbols, group: GroupObservation) -> Expression:
        """Return the demanded pressure of one group [Pa]."""
        slip = draft.state(group.label("set_slip"), "1", "set slip without the dither")
        steady = draft.state(group.label("steady"), "1", "slow part of the adhesion")
        started = draft.state(group.label("started"), "1", "1 once there is an adhesion worth following")
        ready = group.adhesion >= tuning["adhesion_small"]
        share = tuning["period"] / (tuning["washout_time"] + tuning["period"])
        # Washout: without it the level of α, which the dither does not change, would dominate the product below.
        mean = choose(started, steady + share * (group.adhesion - steady), group.adhesion)
        # Demodulation: the mean of sin² is 1/2, hence the factor 2/dither.
        elasticity = (group.adhesion - mean) / mean * tuning["wave"] * 2.0 / tuning["dither"]
        # A step of the rail is not a response to the dither: it must not double the slip within half a wave.
        rate = within(tuning["climb"] * elasticity, -tuning["frequency"], tuning["frequency"])
        moved = within(slip * (1.0 + rate * tuning["period"]), tuning["slip_least"], tuning["slip_most"])
        draft.keep(slip, choose(ready, moved, slip))
        draft.keep(steady, choose(ready, mean, steady))
        draft.keep(started, choose(ready, 1.0, 0.0))
        return slip_control(draft, group, tuning, slip * (1.0 + tuning["dither"] * tuning["wave"]))
