"""The force of brakes on the rail itself, which the Kalman filter of a train file assumes.

They brake the train without its wheelsets. A filter that does not know their force takes the train for faster than it
is as soon as no sensor reads the speed over ground, and slide protection then releases wheelsets that roll.
"""

from collections.abc import Sequence

from railgrip.base.system import SampledSystem
from railgrip.controllers.sampled import Expression, FormulaBuilder, Sampled, choose, either, every, within
from railgrip.rolling_stock.brakes import RailBrake, TrackBrake
from railgrip.rolling_stock.schema import Train
from railgrip.vehicle.signals import RAIL_BRAKE_INPUTS

_STANDING = 0.1  # m/s, below which friction falls to 0 linearly, as in RailBraking.Components.MagneticTrackBrake


def rail_brakes_of(train: Train, period: float) -> Sampled | None:
    """Return the force of a train's brakes on the rail itself [N], called every `period` [s]; None without any.

    Inputs are `RAIL_BRAKE_INPUTS`. The forces are those of RailBraking.Components.MagneticTrackBrake and
    EddyCurrentBrake with the data of the train file, which is what an onboard computer can know.
    """
    units: list[tuple[RailBrake, int]] = []
    for *_, brake in train.rail_brakes:
        place = next((i for i, (known, _) in enumerate(units) if known == brake), None)
        if place is None:
            units.append((brake, 1))
        else:
            units[place] = (brake, units[place][1] + 1)
    return Sampled(_formula(units, period), {}) if units else None


def _formula(units: Sequence[tuple[RailBrake, int]], period: float) -> SampledSystem:
    draft = FormulaBuilder()
    ((speed,), (braking,), (magnets,)) = draft.vector(RAIL_BRAKE_INPUTS, 1)
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
    draft.output("force", "N", "braking force on the rail itself", force * within(speed / _STANDING, 0.0, 1.0))
    return draft.formula("RailBrakes", "Force of magnetic track brakes and linear eddy-current brakes")


def _shape(brake: RailBrake, speed: Expression) -> Expression:
    """Return the developed force of one bogie's brake at a speed [N]."""
    if isinstance(brake, TrackBrake):
        fall = (brake.friction_slow - brake.friction_fast) / (1.0 + speed / brake.friction_speed)
        return brake.magnets * brake.attraction * (brake.friction_fast + fall)
    fade = within((speed - brake.speed_end) / (brake.speed_full - brake.speed_end), 0.0, 1.0)
    return brake.force * 2.0 * brake.speed_peak * speed / (brake.speed_peak**2 + speed**2) * fade
