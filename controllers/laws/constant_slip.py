"""PI control of the slip to a set value."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from railgrip.controllers.law import FULL_PRESSURE, GroupLaw, GroupObservation, Ranges, Tuning
from railgrip.controllers.sampled import Expression, FormulaBuilder, Symbols, choose, within


@dataclass(frozen=True, slots=True, kw_only=True)
class ConstantSlipTuning(Tuning):
    """Parameters of control to a set slip."""

    period: Annotated[float, "s", "between two decisions"]
    slip: Annotated[float, "1", "set slip"]
    gain: Annotated[float, "1", "share of the full pressure for an error as large as the set slip"]
    integral_time: Annotated[float, "s", "after which the integral term equals the proportional one"]
    speed_min: Annotated[float, "m/s", "train speed below which the brake is applied"] = 0.5

    POSITIVE: ClassVar[frozenset[str]] = frozenset({"period", "slip", "integral_time"})
    ORDER: ClassVar[tuple[str, ...]] = ("slip < 1; a slip of 1 is that of a locked wheel",)


class ConstantSlip(GroupLaw):
    """PI control of the slip of each group.

    With e = 1 − s/s_set, p = p_max (gain·e + i) within 0 … p_max, di/dt = gain·e/integral_time and i within 0 … 1; i
    starts at 1, full pressure.

    Source: the control to a desired slip of Park, Kim, Choi and Yamazaki, Modeling and control of adhesion force in
    railway rolling stocks, IEEE Control Systems 28(5) (2008) 44, here with PI in place of an adaptive sliding mode. The
    error relative to the set slip and the bounds of the integral are this project's.
    """

    description = "Wheel-slide protection to a set slip"
    brake_data = FULL_PRESSURE
    tuning = ConstantSlipTuning
    ranges: ClassVar[Ranges] = {
        ("pneumatic", "read"): {"slip": (5e-3, 0.2), "gain": (0.05, 1.0), "integral_time": (0.1, 2.0)}
    }

    @classmethod
    def demand(cls, draft: FormulaBuilder, tuning: Symbols, group: GroupObservation) -> Expression:
        """Return the demanded pressure of one group [Pa]."""
        return slip_control(draft, group, tuning, tuning["slip"])


def slip_control(draft: FormulaBuilder, group: GroupObservation, tuning: Symbols, slip: Expression) -> Expression:
    """Return the pressure [Pa] that PI control to a set slip demands.

    Args:
        draft: Formula that gets the integral as a state.
        group: Observation of the group.
        tuning: Parameters, among them `period`, `gain`, `integral_time` and `speed_min` of `ConstantSlipTuning`.
        slip: Set slip.
    """
    full, controlling = group.brake["pressure_max"], group.speed >= tuning["speed_min"]
    integral = draft.state(group.label("integral"), "1", "share of the full pressure", start=1.0)
    proportional = tuning["gain"] * (1.0 - group.slip / slip)
    # The bounds prevent windup while the slip stays below the set slip although the pressure is full.
    following = within(integral + proportional * tuning["period"] / tuning["integral_time"], 0.0, 1.0)
    draft.keep(integral, choose(controlling, following, integral))
    return choose(controlling, full * within(proportional + following, 0.0, 1.0), full)
