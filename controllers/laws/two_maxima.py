"""Slip control at the better of two maxima of adhesion: that of the film, or that of the rail that slip cleans.

Where slip removes the film, adhesion has a second maximum at large slip, and groups of wheelsets that follow pass a
cleaner rail. Whether this pays depends on the rail, and the train shows it before any wheelset slips deep: on a rail
that slip cleans, groups behind have more adhesion than the first one had at the same place.

Sources: cleaning by slip energy after Allotta, Meli, Ridolfi and Rindi, Tribology International 69 (2014) 128. The slip
at the first maximum is that of `SlopeSeeking`. The comparison at the same place is this project's.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from math import log
from typing import Annotated, ClassVar

import casadi as ca

from railgrip.controllers.law import Demand, Ranges, Tuning
from railgrip.controllers.laws.slope_seeking import (
    SlopeSeeking,
    SlopeTuning,
    Target,
    Wheels,
    seek,
    slope_targets,
    weighted_mean,
)
from railgrip.controllers.parameters import SEARCHED, SlipSource
from railgrip.controllers.sampled import Expression, FormulaBuilder, choose, either, every, within


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoMaximaTuning(SlopeTuning):
    """Parameters of `TwoMaxima`, besides those of `SlopeSeeking`."""

    slip_deep: Annotated[float, "1", "slip that is sought on a rail that slip cleans"]
    advantage_high: Annotated[float, "1", "ln of adhesion of groups behind over that of the first: above it deep slip"]
    advantage_low: Annotated[float, "1", "the same, in deep slip: below it back to the slope"]
    comparison_time: Annotated[float, "s", "time constant of the mean of the comparison"]
    speed_ratio: Annotated[float, "1", "train speed of another deep slip over that at the end of the last"] = 0.7
    deep_rate: Annotated[float, "1/s", "rate of ln(slip) towards deep slip"] = 6.0
    slip_vent_deep: Annotated[float, "1", "slip above which the brake is released, in deep slip"] = 0.85
    work_max: Annotated[float, "m", "work of deep slip over the load of a group, at most; limits the tread's heat"] = (
        60.0
    )

    LAW: ClassVar[str] = "TwoMaxima"
    POSITIVE: ClassVar[frozenset[str]] = SlopeTuning.POSITIVE | {"comparison_time"}

    def __post_init__(self) -> None:
        """Check the parameters.

        Raises:
            ValueError: See `SlopeTuning`; or the slips are not in order.
        """
        SlopeTuning.__post_init__(self)
        if not 0.0 < self.slip_deep < self.slip_vent_deep < 1.0:
            raise ValueError(
                "TwoMaxima: slips must have 0 < slip_deep < slip_vent_deep < 1, got "
                f"{self.slip_deep} and {self.slip_vent_deep}."
            )


class TwoMaxima(SlopeSeeking):
    """Slope seeking, and deep slip on a rail that slip cleans.

    The law remembers over the distance the adhesion of the first group that slides, α_1. A group k behind is compared
    with it at the same place x, and at the same time t:

        d_k = ln α_k − ln α_1(x) or ln α_k − ln α_1(t), the one of smaller magnitude
        g = ⟨d_k⟩                        mean over the groups behind, weighted by load, averaged over `comparison_time`
        deep slip begins                 where g > advantage_high
        deep slip ends                   where g < advantage_low

    Friction that varies along the track cancels in the first difference, friction that varies over time in the second.
    Only groups whose adhesion the rail limits are compared: they slide by similar slips, with less than `_FULL` of the
    highest pressure. A change between slope and deep slip clears the memory, because both groups of a comparison must
    have the same slip.

    In deep slip all groups seek `slip_deep`; a group whose deep slip has done `work_max` returns to the slope. After
    deep slip has ended, it does not begin again before the speed is down to `speed_ratio` of that at the end. If the
    positions of the groups are not known, or there is one group, the law is slope seeking.
    """

    description = "Slip control at the better of two maxima of adhesion"
    tuning = TwoMaximaTuning
    ranges: ClassVar[Ranges] = {
        ("pneumatic", "estimated"): {
            "slip_deep": (0.3, 0.6),
            "advantage_high": (0.06, 0.2),
            "advantage_low": (0.02, 0.06),
            "comparison_time": (0.5, 2.0),
        }
    }

    @classmethod
    def load_tuning(cls, actuation: str, slip: SlipSource, name: str = SEARCHED, /, **others: float) -> Tuning:
        """Return the parameters of one of the law's sets, with those of `SlopeSeeking` for the slope.

        Raises:
            ValueError: See `GroupLaw.load_tuning`.
        """
        slope = asdict(SlopeSeeking.load_tuning(actuation, slip, SEARCHED, **others))
        return super().load_tuning(actuation, slip, name, **{**slope, **others})

    @staticmethod
    def demand_with(draft: FormulaBuilder, tuning: Mapping[str, Expression]) -> Demand:
        """Return the demand of one group."""
        deep = draft.state("deep", "1", "1 in deep slip")

        def targets_of(draft: FormulaBuilder, train: Sequence[Wheels], t: Mapping[str, Expression]) -> list[Target]:
            advantage = _advantage(draft, train, t, deep)
            speed = train[0].group.speed
            ended = draft.state("ended_speed", "m/s", "train speed at which deep slip ended last", _ANY_SPEED)
            ends = every(deep > 0.5, advantage < t["advantage_low"])
            begins = every(deep < 0.5, advantage > t["advantage_high"], speed < t["speed_ratio"] * ended)
            draft.keep(ended, choose(ends, speed, ended))
            following = choose(begins, 1.0, choose(ends, 0.0, deep))
            draft.keep(deep, following)
            draft.show("deep_slip", "1", "1 in deep slip", following)
            return _slips(draft, train, t, deep > 0.5)

        vent = choose(deep > 0.5, tuning["slip_vent_deep"], tuning["slip_vent"])
        return seek(draft, {**tuning, "slip_vent": vent}, targets_of)


_CELL, _CELLS = 1.0, 48
"""Length [m] and number of the cells of the memory: groups further behind the first than all cells are not compared."""

_ANY_SPEED = 1e9  # m/s
_UNKNOWN = 0.0  # ln(adhesion) of a cell without one
_LEAST = 1e-3  # adhesion, in logarithms
_LARGEST = 0.6  # magnitude of a difference of ln(adhesion), beyond which it has other causes
_FULL = 0.95  # share of the highest pressure from which the brake, not the rail, limits adhesion
_AHEAD = 4  # cells that are cleared ahead of the first group: more than it passes within one sample
_ALIKE = 2.0  # largest ratio of slips of groups that are compared: a valve that sticks leaves a group elsewhere
_REACHED = 0.6  # share of deep slip from which a group is in it
_BACK = 1.3  # slip over its target above which a group still returns from deep slip
_BEGIN = 0.03  # lowest slip from which deep slip is approached


def _advantage(
    draft: FormulaBuilder, train: Sequence[Wheels], t: Mapping[str, Expression], deep: Expression
) -> Expression:
    """Return ln of the adhesion of groups over that which the first one had at the same place, averaged."""
    last_distance = draft.state("distance", "m", "distance since braking began")
    distance = last_distance + train[0].group.speed * t["period"]
    draft.keep(last_distance, distance)
    logarithms = [ca.log(ca.fmax(each.adhesion, _LEAST)) for each in train]
    limited: list[Expression] = []
    for each in train:
        enough = choose(deep > 0.5, each.filtered > _REACHED * t["slip_deep"], 1.0)
        by_rail = each.group.pressure < _FULL * each.group.brake["pressure_max"]
        limited.append(every(each.sliding, enough, by_rail))

    positions = [draft.parameter(each.group.label("position"), "m", _POSITION) for each in train]
    loads = [each.group.brake["load"] for each in train]
    found, place, value, slip = 0.0, distance, _UNKNOWN, 1.0  # of the first group that the rail limits
    behind: list[Expression] = []
    for each, position, logarithm, counts in zip(train, positions, logarithms, limited, strict=True):
        is_first = every(found < 0.5, counts)
        behind.append(every(found > 0.5, counts))
        place = choose(is_first, distance - position, place)
        value = choose(is_first, logarithm, value)
        slip = choose(is_first, each.filtered, slip)
        found = choose(is_first, 1.0, found)
    recall = _memory(draft, place, value, deep)
    differences: list[tuple[Expression, Expression]] = []
    for each, counts, position, logarithm in zip(train, behind, positions, logarithms, strict=True):
        known = recall(distance - position)
        near = place - (distance - position) < _CELL * (_CELLS - _AHEAD - 1)
        at_place, at_time = logarithm - known, logarithm - value
        smaller = choose(ca.fabs(at_place) < ca.fabs(at_time), at_place, at_time)
        alike = every(each.filtered < _ALIKE * slip, slip < _ALIKE * each.filtered)
        counts = every(counts, alike, near, known < _UNKNOWN, value < _UNKNOWN)
        differences.append((counts, within(smaller, -_LARGEST, _LARGEST)))
    compares = either(0.0, *(counts for counts, _ in differences))
    last = draft.state("advantage_before", "1", "mean of the comparison at the last sample")
    share = choose(compares, t["period"] / t["comparison_time"], 0.0)
    advantage = last + share * (weighted_mean(differences, loads) - last)
    draft.keep(last, advantage)
    draft.show("advantage", "1", "ln(adhesion) of groups behind over that of the first at the same place", advantage)
    return advantage


_POSITION = "distance of the group behind the leading wheelset"


def _memory(
    draft: FormulaBuilder, place: Expression, value: Expression, deep: Expression
) -> Callable[[Expression], Expression]:
    """Keep a value at a place [m], and return a function that returns the value at an earlier place."""
    before = draft.state("deep_before", "1", "1 in deep slip at the last sample")
    draft.keep(before, deep)

    def cell_of(place: Expression) -> Expression:
        return ca.fmod(ca.floor(ca.fmax(place, 0.0) / _CELL), float(_CELLS))

    here = cell_of(place)
    cells = [draft.state(f"memory[{i + 1}]", "1", "ln(adhesion) of the first group at a place") for i in range(_CELLS)]
    for i, cell in enumerate(cells):
        ahead = ca.fmod(i - here + _CELLS, float(_CELLS))
        # Metres that the train passes within one sample have no value; those of one turn of the memory before go.
        kept = choose(either(ahead <= _AHEAD, deep != before), _UNKNOWN, cell)
        draft.keep(cell, choose(ahead == 0.0, value, kept))

    def recall(place: Expression) -> Expression:
        wanted = cell_of(place)
        return choose(place > 0.0, sum(choose(wanted == float(i), cell, 0.0) for i, cell in enumerate(cells)), _UNKNOWN)

    return recall


def _slips(
    draft: FormulaBuilder, train: Sequence[Wheels], t: Mapping[str, Expression], deep: Expression
) -> list[Target]:
    """Return the slip that each group seeks, and its rate [1/s]."""
    period = t["period"]
    dives: list[Expression] = []
    returning: list[Expression] = []
    for each in train:
        work = draft.state(each.group.label("slip_work"), "m", "work of deep slip over the load")
        dives.append(every(deep, work < t["work_max"]))
        draft.keep(work, work + choose(dives[-1], each.adhesion * each.filtered * each.group.speed * period, 0.0))
        returning.append(draft.state(each.group.label("returning"), "1", "1 until deep slip has ended"))
    # The slope is that of the groups that seek it.
    seeking = [
        replace(each, sliding=every(each.sliding, ca.logic_not(either(dive, returns))))
        for each, dive, returns in zip(train, dives, returning, strict=True)
    ]
    slope = slope_targets(draft, seeking, t)
    targets: list[Target] = []
    goal, step = ca.log(t["slip_deep"]), t["deep_rate"] * period
    for each, dive, returns, (slip, rate) in zip(train, dives, returning, slope, strict=True):
        draft.keep(returns, either(dive, every(returns, each.filtered > _BACK * slip)))
        last = draft.state(
            each.group.label("deep_set_point"), "1", "logarithm of the deep slip that is sought", log(_BEGIN)
        )
        begin = ca.log(ca.fmax(each.filtered, _BEGIN))
        now = choose(every(dive, each.sliding), last + within(goal - last, -step, step), begin)
        draft.keep(last, now)
        rising = ca.fmax(ca.exp(now) - ca.exp(last), 0.0) / period
        targets.append((choose(dive, ca.exp(now), slip), choose(dive, rising, rate)))
    return targets
