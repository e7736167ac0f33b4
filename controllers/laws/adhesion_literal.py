"""Adhesion-based control as Schwarz, Posielek and Goetjes (2021) print it: u = L·sgn(ṡ·α̇), eq. (10)-(11).

If slip and adhesion change in the same direction, the wheel is below the peak of adhesion and may be braked harder;
otherwise it is beyond the peak and its brake must be released. With s = 1 − rω/v a higher pressure raises the slip, so
g_s in ṡ = f_s + g_s·u, eq. (3), is positive. The paper calls it negative, but V̇ < 0 in eq. (15) requires the positive
sign, because ∂²α/∂s² < 0. Here u = +L is full pressure and u = −L is zero pressure.
"""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from railgrip.controllers.law import FULL_PRESSURE, GroupLaw, GroupObservation, Ranges, Tuning
from railgrip.controllers.sampled import Expression, FormulaBuilder, Symbols, choose, either, every, low_pass


@dataclass(frozen=True, slots=True, kw_only=True)
class SwitchingTuning(Tuning):
    """Parameters of the switching law: its filters, and the range in which it acts.

    Ideal sensors resolve any slip, and a `slip_small` of 0.3 % is below all published peaks. Below 0.5 m/s slip is the
    ratio of two small numbers. `adhesion_max` is 0.15 in the TSI, 0.13 for short fixed formations.
    """

    period: Annotated[float, "s", "between two decisions"]
    filter_time: Annotated[float, "s", "time constant of the filters that differentiate slip and adhesion"]
    slip_small: Annotated[float, "1", "slip below which the wheel counts as rolling, at high speed"] = 0.003
    creep_small: Annotated[
        float, "m/s", "creep speed that adds to it: errors of the train speed that are not of its scale"
    ] = 0.0
    adhesion_small: Annotated[float, "1", "estimated adhesion below which there is no peak to seek"]
    adhesion_max: Annotated[float, "1", "highest adhesion that may be used"]
    speed_min: Annotated[float, "m/s", "train speed below which the brake is simply applied"] = 0.5

    FIXED: ClassVar[frozenset[str]] = frozenset({"period", "adhesion_max"})


@dataclass(frozen=True, slots=True, kw_only=True)
class LiteralAdhesionBasedTuning(SwitchingTuning):
    """Parameters of the law as printed. It shares all but `hold` with peak seeking."""

    hold: Annotated[float, "1", "1: keep the last pressure while ṡ·α̇ = 0; 0: half pressure, as sgn(0) = 0 gives"] = 1.0
    quotient: Annotated[float, "1", "1: switch by α̇/ṡ, the paper's alternative, with a dead zone; 0: by ṡ·α̇"] = 0.0
    slip_rate_small: Annotated[float, "1/s", "half width of that dead zone, in which α̇/ṡ counts as zero"] = 1e-3


class LiteralAdhesionBased(GroupLaw):
    """The law as printed, eq. (11): full pressure while ṡ·α̇ > 0, zero pressure while it is negative.

    This project adds three guards, each of which can be switched off. A rolling wheel is braked fully, unless
    `slip_small`, `creep_small` and `adhesion_small` are zero. Below `speed_min` the brake is applied. While ṡ·α̇ = 0 the
    last pressure is held, unless `hold` is zero.

    Source: Schwarz, Posielek, Goetjes (2021), §3.2, with the limit α ≤ adhesion_max of the same section.
    """

    description = "Adhesion-based wheel-slide protection as printed"
    brake_data = FULL_PRESSURE
    needs = ("adhesion",)
    tuning = LiteralAdhesionBasedTuning
    # As for peak seeking; the filter may be slower, because nothing else smooths the switching.
    ranges: ClassVar[Ranges] = {
        ("ideal", "estimated"): {
            "filter_time": (3e-3, 0.2),
            "slip_small": (3e-4, 3e-2),
            "adhesion_small": (5e-3, 3e-2),
        },
        ("pneumatic", "estimated"): {
            "filter_time": (3e-3, 0.5),
            "slip_small": (1e-3, 3e-2),
            "creep_small": (0.01, 0.2),
            "adhesion_small": (5e-3, 3e-2),
        },
    }

    @classmethod
    def demand(cls, draft: FormulaBuilder, tuning: Symbols, group: GroupObservation) -> Expression:
        """Return the demanded pressure of one group [Pa]."""
        full, controlling = group.brake["pressure_max"], group.speed >= tuning["speed_min"]
        # ṡ and α̇, "the estimated time derivatives of adhesion and slip" of §3.2. The paper takes them as exact;
        # estimates are noisy, so both pass the same filter, which keeps them in phase with each other.
        _, slip_rate = low_pass(draft, tuning, group.label("seen_slip"), group.slip)
        _, adhesion_rate = low_pass(draft, tuning, group.label("seen_adhesion"), group.adhesion)
        applied = draft.state(group.label("applied"), "1", "1 when the brake was applied, 0 when released", start=1.0)
        # Eq. (10), or the alternative at the end of §3.2: α̇/ṡ has the same sign, but no value at ṡ = 0.
        small = every(-tuning["slip_rate_small"] < slip_rate, slip_rate < tuning["slip_rate_small"])
        quotient = choose(small, 0.0, adhesion_rate / choose(small, 1.0, slip_rate))
        switch = choose(tuning["quotient"] > 0.0, quotient, slip_rate * adhesion_rate)
        rolling = is_rolling(tuning, group.speed, group.slip, group.adhesion)
        # Eq. (11), u = L·sgn(ṡ·α̇), mapped from −L … L to 0 … 1 of full pressure: sgn(0) = 0 is half pressure.
        kept = choose(tuning["hold"] > 0.0, applied, 0.5)
        seeking = choose(either(rolling, switch > 0.0), 1.0, choose(switch < 0.0, 0.0, kept))
        # Limit α ≤ α_max, end of §3.2: the cylinder is vented (§4, effect ii) as long as the estimate exceeds it.
        decided = choose(group.adhesion > tuning["adhesion_max"], 0.0, seeking)
        draft.keep(applied, choose(controlling, decided, applied))
        return choose(controlling, decided * full, full)


def is_rolling(tuning: Symbols, speed: Expression, slip: Expression, adhesion: Expression) -> Expression:
    """Return whether the wheel rolls, so that it cannot seek a peak: slip within its error, or adhesion too small."""
    slip_small = tuning["slip_small"] + tuning["creep_small"] / speed
    return either(slip < slip_small, adhesion < tuning["adhesion_small"])
