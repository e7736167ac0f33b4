"""A law based on published descriptions of common practice: its reference speed comes from wheel speeds alone."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

from railgrip.controllers.law import FULL_PRESSURE, GroupLaw, GroupObservation, Ranges, Tuning
from railgrip.controllers.sampled import (
    Expression,
    FormulaBuilder,
    Symbols,
    choose,
    either,
    every,
    low_pass,
    time_release,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelReferenceTuning(Tuning):
    """Parameters of the law.

    `vent_max`: an axle may be vented for 5 to 10 s before it has to brake again. `speed_min`: protection is off in the
    last kilometres per hour.
    """

    period: Annotated[float, "s", "between two decisions"]
    filter_time: Annotated[float, "s", "time constant of the filter that differentiates wheel speeds"] = 0.03
    slip_low: Annotated[float, "1", "slip against the reference above which pressure is held"]
    slip_high: Annotated[float, "1", "slip against the reference above which it is vented"]
    deceleration: Annotated[float, "m/s2", "deceleration of a wheel above which it is vented as well"]
    deceleration_max: Annotated[
        float, "m/s2", "largest deceleration assumed for the train: the reference falls no faster"
    ]
    rise: Annotated[float, "1/s", "rate at which pressure rises after a slide, as a share of the full pressure"]
    test_after: Annotated[
        float, "s", "duration of a slide after which the last group is released to measure the train speed"
    ]
    test_time: Annotated[float, "s", "duration of a test release"] = 0.6
    vent_max: Annotated[float, "s", "longest venting of a group, after which it is braked regardless of its slip"] = 7.0
    apply_time: Annotated[float, "s", "duration of this braking"] = 1.0
    speed_min: Annotated[float, "m/s", "reference speed below which protection is off"] = 1.4

    POSITIVE: ClassVar[frozenset[str]] = frozenset(
        {"period", "slip_low", "deceleration", "deceleration_max", "rise", "vent_max"}
    )
    ORDER: ClassVar[tuple[str, ...]] = ("slip_low < slip_high < 1",)


class WheelReference(GroupLaw):
    """Vent, hold and fill by slip and deceleration of each group against a reference speed from the wheels alone.

    The reference is the speed of the fastest wheel, but falls no faster than `deceleration_max`. If every wheel slides,
    it falls below the train's speed; therefore the last group is released for `test_time` after a slide of
    `test_after`, so that its wheels roll.

    A group is vented above `slip_high`, or above `slip_low` while it decelerates by more than `deceleration`. It is
    held above `slip_low`, or below it while it decelerates by more than that. Otherwise it is filled, after a slide at
    the rate `rise`. A watchdog ends venting after `vent_max`. Below `speed_min` the brake is applied.

    The law uses wheel speeds and cylinder pressures only: no radar, accelerometer or estimator.

    Sources, as far as systems in service are published: wheel speeds as the only sensors and dump and refill valves,
    Pugi et al., Railway Engineering Science 31 (2023) 108, and Kim, Lee, Lee and Kang, IFAC 2014; a limit on venting,
    EN 15595. No manufacturer publishes a table of criteria; this one is this project's.
    """

    description = "Wheel-slide protection from wheel speeds alone"
    brake_data = FULL_PRESSURE
    tuning = WheelReferenceTuning
    ranges: ClassVar[Ranges] = {
        ("pneumatic", "read"): {
            "slip_low": (0.01, 0.1),
            "slip_high": (0.05, 0.3),
            "deceleration": (0.8, 5.0),
            "deceleration_max": (0.8, 3.0),
            "rise": (0.1, 3.0),
            "test_after": (2.0, 15.0),
        }
    }

    @classmethod
    def demands(cls, draft: FormulaBuilder, tuning: Symbols, train: Sequence[GroupObservation]) -> list[Expression]:
        """Return the demanded pressure of each group [Pa]."""
        period = tuning["period"]
        before = draft.state("reference", "m/s", "reference speed")
        started = draft.started
        sliding = draft.state("sliding", "s", "since the last test release, while a group slides")
        idle = draft.state("idle", "s", "since the last slide of a group")
        reference = _reference(train, started, before - tuning["deceleration_max"] * period)
        draft.keep(before, choose(reference > 0.0, reference, 0.0))
        protecting = reference >= tuning["speed_min"]
        demands: list[Expression] = []
        slides: list[Expression] = []
        for group in train:
            full, rolling = group.brake["pressure_max"], _rolling(group)
            _, acceleration = low_pass(draft, tuning, group.label("rolling"), rolling, "m/s")
            vented = draft.state(
                group.label("vented"), "s", "time of venting, and of the braking that follows one that lasted too long"
            )
            target = draft.state(group.label("target"), "1", "demanded pressure over the full one", start=1.0)
            slip = choose(reference > tuning["speed_min"], 1.0 - rolling / reference, 0.0)
            decelerating, above_high, above_low = (
                -acceleration > tuning["deceleration"],
                slip > tuning["slip_high"],
                slip > tuning["slip_low"],
            )
            vent_criterion = either(above_high, every(above_low, decelerating))
            test_release = every(sliding >= tuning["test_after"], group is train[-1])
            hold_criterion = either(above_low, decelerating)
            slides.append(every(protecting, either(vent_criterion, above_low)))

            venting = every(protecting, either(vent_criterion, test_release), vented < tuning["vent_max"])
            limit = {"longest": tuning["vent_max"], "applied": tuning["apply_time"]}
            draft.keep(vented, time_release(vented, venting, period=period, **limit))

            # After a slide the pressure rises from its value at the end of the slide, not from zero.
            holding = every(hold_criterion, vented < tuning["vent_max"])
            risen = target + tuning["rise"] * period
            new_target = choose(either(venting, holding), group.pressure / full, choose(risen < 1.0, risen, 1.0))
            draft.keep(target, choose(protecting, new_target, 1.0))
            demands.append(choose(protecting, choose(venting, 0.0, full * new_target), full))

        draft.keep(idle, choose(either(*slides), 0.0, idle + period))
        # Slides come and go within seconds: a shorter pause does not end the count.
        counted = choose(idle < _PAUSE, sliding + period, 0.0)
        over = sliding >= tuning["test_after"] + tuning["test_time"]
        draft.keep(sliding, choose(every(protecting, started), choose(over, 0.0, counted), 0.0))
        return demands


_PAUSE = 2.0  # s, longest time without a slide within one period of sliding


def _reference(train: Sequence[GroupObservation], started: Expression, minimum: Expression) -> Expression:
    fastest = _rolling(train[0])
    for group in train[1:]:
        fastest = choose(_rolling(group) > fastest, _rolling(group), fastest)
    # The minimum follows from the last reference, which does not exist at the first sample.
    return choose(started, choose(fastest > minimum, fastest, minimum), fastest)


def _rolling(group: GroupObservation) -> Expression:
    return group.wheelset_speed * group.brake["wheel_radius"]
