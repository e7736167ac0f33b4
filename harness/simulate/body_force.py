"""The braking force on the body of a train, which the Kalman filter of a train file assumes.

Brakes on the rail itself and the linear part of the running resistance brake a train without its wheelsets. A filter
that does not know them takes the train for faster than it is as soon as no sensor reads the speed over ground, and
slide protection then releases wheelsets that roll.
"""

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
    if not train.rail_brakes and not train.linear_resistance:
        return None
    return Sampled(_formula(train, period), {})


def _formula(train: Train, period: float) -> SampledSystem:
    """Return the formula; it has states only for brakes on the rail, whose force depends on earlier commands."""
    draft = FormulaBuilder()
    ((speed,), (braking,), (magnets,)) = draft.vector(BODY_FORCE_INPUTS, 1)
    speed = choose(speed > 0.0, speed, 0.0)
    force: Expression = 0.0
    applied: Expression = 0.0
    if train.rail_brakes:
        before = draft.state("applied", "1", "1 once the brakes have been applied")
        applied = either(before > 0.5, braking > 0.5)
        draft.keep(before, choose(applied, 1.0, 0.0))
    for number, (*_, brake) in enumerate(train.rail_brakes, start=1):
        is_on = applied
        if isinstance(brake, TrackBrake):
            since = draft.state(f"lowering[{number}]", "s", "since the magnets have been demanded")
            for_now = choose(every(applied, magnets > 0.5), since + period, 0.0)
            draft.keep(since, for_now)
            is_on = for_now > brake.delay
        field = draft.state(f"field[{number}]", "1", "force relative to that of the full field")
        share = period / (brake.time_constant + period)
        now = field + share * (choose(is_on, 1.0, 0.0) - field)
        draft.keep(field, now)
        force += now * _developed(brake, speed)
    force = train.linear_resistance * speed + force * within(speed / _STANDING, 0.0, 1.0)
    draft.output("force", "N", "braking force on the body", force)
    return draft.formula("BodyForce", "Force of brakes on the rail itself and of linear resistance")


def _developed(brake: RailBrake, speed: Expression) -> Expression:
    """Return the developed force of one bogie's brake at a speed [N]."""
    if isinstance(brake, TrackBrake):
        return brake.force_at(speed)
    # As `force_at` of such a brake, whose limits are those of NumPy.
    fade = within((speed - brake.speed_end) / (brake.speed_full - brake.speed_end), 0.0, 1.0)
    return brake.before_fade(speed) * fade
