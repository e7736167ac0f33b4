"""Speed over ground from a rolling wheel, while the radar provides no reading."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cache
from typing import Annotated

from railgrip.base.system import SampledSystem
from railgrip.controllers.law import by_name
from railgrip.controllers.parameters import Parameters
from railgrip.controllers.sampled import Expression, FormulaBuilder, Sampled, choose, either, every
from railgrip.vehicle.brake import BRAKE, Brake
from railgrip.vehicle.signals import REFERENCE_INPUTS


@dataclass(frozen=True, slots=True, kw_only=True)
class FreeWheelParameters(Parameters):
    """Parameters of `FreeWheel`.

    `spin_up`: an adhesion of 0.004, lower than on leaves, accelerates the rim of a wheelset of 120 kg·m² under 7 t at
    0.3 m/s², so a released wheel that accelerates less rolls. `test_most`: an axle may be vented for 5 to 10 s before
    it has to brake again.
    """

    period: Annotated[float, "s", "between two samples"]
    silence: Annotated[float, "s", "time without a reading of the speed, after which a wheel speed replaces it"] = 1.0
    release: Annotated[float, "s", "time for which a brake must have been off"] = 0.5
    filter_time: Annotated[float, "s", "time constant of the filter that differentiates wheel speeds"] = 0.3
    spin_up: Annotated[float, "m/s2", "acceleration at the rim above which a released wheel still slides"] = 0.3
    interval: Annotated[
        float, "s", "between two speeds from wheels: their error is that of a radius, and does not average out"
    ] = 0.1
    test_after: Annotated[float, "s", "time without any speed, after which a group is released to measure it"] = 5.0
    test_most: Annotated[float, "s", "longest such release"] = 7.0


_ANY_SPEED = 1e6  # m/s, beyond every speed
_BRAKE_DATA = ("wheel_radius", "piston_area", "spring_force")


class FreeWheel(Sampled):
    """Replaces missing readings of the speed by a rolling wheel's speed, and requests test releases.

    Its outputs are the speed [m/s] for the Kalman filter, NaN while it is unknown, and for each group 1 while it is to
    be released.
    """

    def __init__(self, groups: Sequence[Brake], period: float) -> None:
        """Start for `groups`, called every `period` [s]."""
        super().__init__(free_wheel(len(groups)), asdict(FreeWheelParameters(period=period)) | by_name(groups))


@cache
def free_wheel(groups: int) -> SampledSystem:
    """Return the formula of `FreeWheel` for a number of groups.

    A wheel rolls if its brake has been off for `release` and its speed rises by no more than `spin_up`. The fastest
    rolling wheel is used, unless another wheel is faster: as no braked wheel can be, the rolling wheel's sensor must be
    dead. If no speed has been known for `test_after`, one group after the other is released, from the rear. Test
    releases for a reference speed are common practice without radar (Pugi et al., Railway Engineering Science 31 (2023)
    108).
    """
    draft = FormulaBuilder()
    numbers = range(1, groups + 1)
    (speed,), wheels, pressures = draft.vector(REFERENCE_INPUTS, groups)
    t = FreeWheelParameters.declare(draft)
    period = t["period"]
    silent = draft.state("silent", "s", "since the last reading of the speed")
    present = _is_known(speed)
    silent_for = choose(present, 0.0, silent + period)
    draft.keep(silent, silent_for)

    fastest: Expression = 0.0
    fastest_rolling: Expression = 0.0
    for g, wheel, pressure in zip(numbers, wheels, pressures, strict=True):
        brake = {name: draft.parameter(f"{name}[{g}]", *BRAKE[name]) for name in _BRAKE_DATA}
        rim = wheel * brake["wheel_radius"]
        filtered = draft.state(f"rim[{g}]", "m/s", "filtered speed of the rim")
        released = draft.state(f"released[{g}]", "s", "for how long the brake has been off")
        change = period / (t["filter_time"] + period) * (rim - filtered)
        draft.keep(filtered, filtered + choose(_is_known(rim), change, 0.0))
        off = pressure * brake["piston_area"] < brake["spring_force"]
        released_for = choose(off, released + period, 0.0)
        draft.keep(released, released_for)
        rolls = every(released_for >= t["release"], change < t["spin_up"] * period)
        fastest = choose(rim > fastest, rim, fastest)
        fastest_rolling = choose(every(rolls, rim > fastest_rolling), rim, fastest_rolling)
    waited = draft.state("waited", "s", "since the last speed from wheels")
    waited_for = waited + period
    available = every(silent_for >= t["silence"], fastest_rolling > 0.0, fastest_rolling >= fastest)
    due = every(available, waited_for >= t["interval"])
    draft.keep(waited, choose(due, 0.0, waited_for))
    known = choose(present, speed, choose(due, fastest_rolling, float("nan")))
    draft.output("speed", "m/s", "speed for the filter", known)

    # A test ends with a speed or after `test_most` without one; the next test releases another group.
    unknown = draft.state("unknown", "s", "since a speed was known, or a test was in vain")
    turn = draft.state("turn", "1", "groups between the last one and the next to be released")
    unknown_for = choose(either(present, available), 0.0, unknown + period)
    testing = unknown_for >= t["test_after"]
    failed = unknown_for >= t["test_after"] + t["test_most"]
    draft.keep(unknown, choose(failed, 0.0, unknown_for))
    over = every(unknown >= t["test_after"], either(failed, unknown_for == 0.0))
    draft.keep(turn, choose(over, choose(turn + 1.0 < groups, turn + 1.0, 0.0), turn))
    for g in numbers:
        release = choose(every(testing, turn == groups - g), 1.0, 0.0)
        draft.output(f"test_release[{g}]", "1", "1 while the group is to be released", release)
    return draft.formula("FreeWheel", "Speed over ground from a wheel that rolls")


def _is_known(reading: Expression) -> Expression:
    # False for NaN; CasADi simplifies x == x to true.
    return reading > -_ANY_SPEED
