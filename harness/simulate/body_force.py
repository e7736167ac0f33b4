"""The braking force on the body of a train, which the Kalman filter of a train file assumes.

Brakes on the rail itself and the linear part of the running resistance brake a train without its wheelsets. A filter
that does not know them takes the train for faster than it is as soon as no sensor reads the speed over ground, and
slide protection then releases wheelsets that roll.
"""

from collections.abc import Sequence

from railgrip.base.system import SampledSystem
from railgrip.controllers.sampled import Expression, FormulaBuilder, Sampled, choose, either, every, within
from railgrip.rolling_stock.brakes import RailBrake, TrackBrake
from railgrip.rolling_stock.schema import Train
from railgrip.vehicle.signals import BODY_FORCE_INPUTS

_STANDING = 0.1  # m/s, below which friction falls to 0 linearly, as in RailBraking.Components.MagneticTrackBrake


def body_force_of(train: Train, period: float) -> Sampled | None:
    """Return the braking force on the body of a train [N], called every `period` [s]; None without any.

    Inputs are `BODY_FORCE_INPUTS`. The forces are those of RailBraking.Components.MagneticTrackBrake and
    EddyCurrentBrake, and of the plant's linear resistance, with the data of the train file, which is what an onboard
    computer can know.
    """
    units: list[tuple[RailBrake, int]] = []
    for *_, brake in train.rail_brakes:
        place = next((i for i, (known, _) in enumerate(units) if known == brake), None)
        if place is None:
            units.append((brake, 1))
        else:
            units[place] = (brake, units[place][1] + 1)
    if not units and not train.linear_resistance:
        return None
    return Sampled(_formula(units, train.linear_resistance, period), {})


def _formula(units: Sequence[tuple[RailBrake, int]], linear: float, period: float) -> SampledSystem:
    draft = FormulaBuilder()
    ((speed,), (braking,), (magnets,)) = draft.vector(BODY_FORCE_INPUTS, 1)
    speed = choose(speed > 0.0, speed, 0.0)
    before = draft.state("applied", "1", "1 once the brakes have been applied")
    applied = either(before > 0.5, braking > 0.5)
    draft.keep(before, choose(applied, 1.0, 0.0))
    force: Expression = 0.0
    for number, (brake, count) in enumerate(units, start=1):
        is_on, shape = applied, _shape(brake, speed)
        if isinstance(brake, TrackBrake):
            since = draft.state(f"lowering[{number}]", "s", "since the magnets have been demanded")
            for_now = choose(every(applied, magnets > 0.5), since + period, 0.0)
            draft.keep(since, for_now)
            is_on = for_now > brake.delay
        field = draft.state(f"field[{number}]", "1", "force relative to that of the full field")
        share = period / (brake.time_constant + period)
        now = field + share * (choose(is_on, 1.0, 0.0) - field)
        draft.keep(field, now)
        force += count * now * shape
    force = linear * speed + force * within(speed / _STANDING, 0.0, 1.0)
    draft.output("force", "N", "braking force on the body", force)
    return draft.formula("BodyForce", "Force of brakes on the rail itself and of linear resistance")


def _shape(brake: RailBrake, speed: Expression) -> Expression:
    """Return the developed force of one bogie's brake at a speed [N]."""
    if isinstance(brake, TrackBrake):
        fall = (brake.friction_slow - brake.friction_fast) / (1.0 + speed / brake.friction_speed)
        return brake.magnets * brake.attraction * (brake.friction_fast + fall)
    fade = within((speed - brake.speed_end) / (brake.speed_full - brake.speed_end), 0.0, 1.0)
    return brake.force * 2.0 * brake.speed_peak * speed / (brake.speed_peak**2 + speed**2) * fade
