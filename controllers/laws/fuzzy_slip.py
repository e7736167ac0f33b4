"""Fuzzy slip control: rules on slip and on the deceleration of the wheel give the rate of the pressure."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Final

from railgrip.controllers.law import FULL_PRESSURE, GroupLaw, GroupObservation, Ranges, Tuning
from railgrip.controllers.sampled import Expression, FormulaBuilder, Symbols, choose, low_pass, within

_RULES: Final = (
    (1.0, 1.0, 0.0),
    (0.5, 0.0, -0.5),
    (0.0, -0.5, -1.0),
)
"""Rate of the pressure that each rule concludes: a share of `fill_rate` if positive, of `vent_rate` if negative.

Rows: slip small, medium, large. Columns: the wheel regains speed, keeps the deceleration of the train, loses speed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FuzzySlipTuning(Tuning):
    """Parameters of fuzzy slip control: the positions of the fuzzy sets, and the rates of the rules."""

    period: Annotated[float, "s", "between two decisions"]
    filter_time: Annotated[float, "s", "time constant of the filter that differentiates the wheel speed"] = 0.05
    slip_medium: Annotated[float, "1", "slip that is medium and nothing else"]
    slip_ratio: Annotated[float, "1", "slip from which on it is large, over the medium one"]
    deceleration: Annotated[float, "m/s2", "of the wheel beyond the train's at which it loses speed and nothing else"]
    fill_rate: Annotated[float, "1/s", "rate of the pressure over the full one of a rule that fills"]
    vent_rate: Annotated[float, "1/s", "rate of the pressure over the full one of a rule that vents"]
    speed_min: Annotated[float, "m/s", "train speed below which the brake is applied"] = 0.5

    POSITIVE: ClassVar[frozenset[str]] = frozenset({"period", "slip_medium", "deceleration", "vent_rate"})
    ORDER: ClassVar[tuple[str, ...]] = ("slip_medium < 1", "1 < slip_ratio")


class FuzzySlip(GroupLaw):
    """Zero-order Takagi-Sugeno control: rules with constant conclusions, on slip and deceleration of the wheel.

    Per group, with three fuzzy sets of each quantity, whose memberships μ are piecewise linear and have the sum 1:

        ṗ/p_max = Σᵢⱼ μᵢ(s) μⱼ(−r ω̇ + v̇) qᵢⱼ,  qᵢⱼ from the table of rules, times fill_rate or vent_rate

    Sources: Takagi and Sugeno, Fuzzy identification of systems and its applications to modeling and control, IEEE
    Trans. SMC 15 (1985) 116; for the slip of railway wheels, Djukić, Rusov, Mitrović, Obradović and Šalinić, Fuzzy
    model for braking force maximization, J. Theor. Appl. Mech. 50 (2012), for air brakes, and Tian, Daniel, Liu and
    Meehan, Computers in Railways XIV (2014) 885, for traction. The table of rules is this project's; positions of the
    sets and rates are searched.
    """

    description = "Wheel-slide protection by fuzzy rules on slip and deceleration"
    brake_data = FULL_PRESSURE
    tuning = FuzzySlipTuning
    ranges: ClassVar[Ranges] = {
        ("pneumatic", "read"): {
            "slip_medium": (0.01, 0.2),
            "slip_ratio": (1.2, 4.0),
            "deceleration": (0.3, 5.0),
            "fill_rate": (0.1, 3.0),
            "vent_rate": (0.3, 5.0),
        }
    }

    @classmethod
    def demand(cls, draft: FormulaBuilder, tuning: Symbols, group: GroupObservation) -> Expression:
        """Return the demanded pressure of one group [Pa]."""
        full, protecting = group.brake["pressure_max"], group.speed >= tuning["speed_min"]
        rolling = group.wheelset_speed * group.brake["wheel_radius"]
        _, rate = low_pass(draft, tuning, group.label("rolling"), rolling, "m/s")
        share = draft.state(group.label("share"), "1", "demand over the full pressure", start=1.0)
        excess = within((group.acceleration - rate) / tuning["deceleration"], -1.0, 1.0)
        gains, loses = within(-excess, 0.0, 1.0), within(excess, 0.0, 1.0)
        large = within((group.slip / tuning["slip_medium"] - 1.0) / (tuning["slip_ratio"] - 1.0), 0.0, 1.0)
        small = within(1.0 - group.slip / tuning["slip_medium"], 0.0, 1.0)
        slip_sets, speed_sets = (small, 1.0 - small - large, large), (gains, 1.0 - loses - gains, loses)
        pressure_rate = sum(
            slip_set * speed_set * rule * (tuning["fill_rate"] if rule > 0.0 else tuning["vent_rate"])
            for slip_set, rules in zip(slip_sets, _RULES, strict=True)
            for speed_set, rule in zip(speed_sets, rules, strict=True)
            if rule
        )
        demanded = within(share + pressure_rate * tuning["period"], 0.0, 1.0)
        draft.keep(share, choose(protecting, demanded, 1.0))
        return choose(protecting, full * demanded, full)
