"""Perturb and observe: the set slip changes in steps, which change their direction when adhesion has fallen."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from railgrip.controllers.law import GroupObservation, Ranges, SetSlipLaw, SetSlipTuning
from railgrip.controllers.laws.constant_slip import slip_control
from railgrip.controllers.sampled import Expression, FormulaBuilder, Symbols, choose, every, within


@dataclass(frozen=True, slots=True, kw_only=True)
class PerturbObserveTuning(SetSlipTuning):
    """Parameters of perturb and observe."""

    step: Annotated[float, "1", "relative change of the set slip in a step"]
    interval: Annotated[float, "s", "between two steps"]
    settling: Annotated[float, "1", "share of the interval after a step in which adhesion is not averaged", 0.9] = 0.5

    POSITIVE: ClassVar[frozenset[str]] = frozenset({"period", "slip_start", "slip_least", "interval", "integral_time"})

    def __post_init__(self) -> None:
        """Check the parameters.

        Raises:
            ValueError: See `SetSlipTuning`; or an interval has no sample to average.
        """
        SetSlipTuning.__post_init__(self)
        if (1.0 - self.settling) * self.interval < self.period:
            raise ValueError(
                f"PerturbObserve: an interval of {self.interval} s with a settling share of {self.settling} has no "
                f"decision, {self.period} s apart, to average; lengthen it."
            )


class PerturbObserve(SetSlipLaw):
    """Maximum-adhesion tracking by perturb and observe; PI control holds the slip.

    Each group has a set slip, a direction d of 1 or −1 and the mean ᾱ of its estimated adhesion over the last part of
    each interval:

        d ← d if ᾱ ≥ ᾱ of the interval before, else −d          observe
        s_set ← s_set (1 + step)^d                               perturb

    Source: perturb and observe for maximum adhesion tracking, Abouzeid, Guerrero, Lejarza, Muniategui, Endemaño and
    Briz, Advanced maximum adhesion tracking strategies in railway traction drives, arXiv:2406.13650 (2024), where it
    perturbs the slip velocity in traction. The relative steps of the slip are this project's, because peaks are
    anywhere between 0.5 % and 40 % slip.
    """

    description = "Wheel-slide protection by perturb and observe"
    tuning = PerturbObserveTuning
    ranges: ClassVar[Ranges] = {
        ("pneumatic", "estimated"): {
            "slip_start": (0.01, 0.15),
            "step": (0.03, 0.5),
            "interval": (0.1, 2.0),
            "gain": (0.05, 1.0),
            "integral_time": (0.1, 2.0),
        }
    }

    @classmethod
    def demand(cls, draft: FormulaBuilder, tuning: Symbols, group: GroupObservation) -> Expression:
        """Return the demanded pressure of one group [Pa]."""
        period, interval = tuning["period"], tuning["interval"]
        slip = draft.state(group.label("set_slip"), "1", "set slip")
        clock = draft.state(group.label("clock"), "s", "since the last step")
        total = draft.state(group.label("total"), "1", "sum of the adhesion of this interval")
        count = draft.state(group.label("count"), "1", "number of samples in the sum")
        before = draft.state(group.label("before"), "1", "mean adhesion of the interval before")
        upwards = draft.state(group.label("upwards"), "1", "1 while the slip is increased", start=1.0)
        ready = every(group.adhesion >= tuning["adhesion_small"], group.speed >= tuning["speed_min"])
        elapsed = clock + period
        averaging = choose(elapsed > tuning["settling"] * interval, 1.0, 0.0)
        new_total, new_count = total + choose(averaging, group.adhesion, 0.0), count + averaging
        due = every(elapsed >= interval, new_count > 0.0)
        mean = new_total / new_count
        direction = choose(mean >= before, upwards, 1.0 - upwards)
        factor = choose(direction, 1.0 + tuning["step"], 1.0 / (1.0 + tuning["step"]))
        stepped = within(slip * factor, tuning["slip_least"], tuning["slip_most"])
        # While the adhesion cannot be compared, the set slip stays, and the interval begins again.
        draft.keep(slip, choose(ready, choose(due, stepped, slip), slip))
        draft.keep(clock, choose(ready, choose(due, 0.0, elapsed), 0.0))
        draft.keep(total, choose(ready, choose(due, 0.0, new_total), 0.0))
        draft.keep(count, choose(ready, choose(due, 0.0, new_count), 0.0))
        draft.keep(before, choose(ready, choose(due, mean, before), before))
        draft.keep(upwards, choose(ready, choose(due, direction, upwards), upwards))
        return slip_control(draft, group, tuning, slip)
