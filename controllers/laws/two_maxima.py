"""Slip control at the better of two maxima of adhesion: that of the film, or that of the rail that slip cleans.

Where slip removes the film, adhesion has a second maximum at large slip, and groups of wheelsets that follow pass a
cleaner rail: they have more adhesion than the first one had at the same place. But wheels also clean a rail by rolling
over it, whatever their slip, and there deep slip only costs adhesion. So the first group tries deep slip alone, and the
others follow if that changes adhesion for the better.

Sources: cleaning by slip energy after Allotta, Meli, Ridolfi and Rindi, Tribology International 69 (2014) 128. The slip
at the first maximum is that of `SlopeSeeking`. The comparison at the same place and the trial are
this project's.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import log
from typing import Annotated, ClassVar

import casadi as ca

from railgrip.controllers.law import GroupObservation, Ranges
from railgrip.controllers.laws.slope_seeking import (
    SlopeSeeking,
    SlopeSeekingTuning,
    Target,
    Wheels,
    seek,
    slope_targets,
    weighted_mean,
    wheels_of,
)
from railgrip.controllers.sampled import Expression, FormulaBuilder, Symbols, choose, either, every, within


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoMaximaTuning(SlopeSeekingTuning):
    """Parameters of `TwoMaxima`, besides those of `SlopeSeeking`."""

    slip_deep: Annotated[float, "1", "slip that is sought on a rail that slip cleans"]
    advantage_high: Annotated[float, "1", "ln of adhesion of groups behind over that of the first: above it a trial"]
    advantage_low: Annotated[float, "1", "the same, in deep slip: below it back to the slope"]
    comparison_time: Annotated[float, "s", "time constant of the mean of the comparison"]
    speed_ratio: Annotated[float, "1", "train speed of another deep slip over that at the end of the last"] = 0.7
    slip_trial: Annotated[float, "1", "slip of the first group in a trial"] = 0.35
    trial_speed: Annotated[float, "m/s", "train speed below which no trial begins: too little is left to gain"] = 8.0
    trial_mean: Annotated[float, "s", "time constant of the means of ln(adhesion) in a trial"] = 0.2
    trial_wait: Annotated[float, "s", "time at cleaned places after which a trial fails"] = 0.6
    trial_longest: Annotated[float, "s", "longest trial"] = 4.0
    response_least: Annotated[float, "1", "sum of changes of the first group and those behind for deep slip"] = 0.1
    response_behind: Annotated[float, "1", "change of the groups behind alone for deep slip"] = 0.2
    response_own: Annotated[float, "1", "change of the first group alone for deep slip"] = 0.3
    level_time: Annotated[float, "s", "time constant of the mean of ln(adhesion) of the train"] = 2.0
    level_loss: Annotated[float, "1", "loss of that in deep slip at which it ends"] = 0.1
    deep_rate: Annotated[float, "1/s", "rate of ln(slip) towards deep slip"] = 6.0
    slip_vent_deep: Annotated[float, "1", "slip above which the brake is released, in deep slip"] = 0.85
    work_max: Annotated[float, "m", "work of deep slip over the load of a group, at most; limits the tread's heat"] = (
        60.0
    )

    POSITIVE: ClassVar[frozenset[str]] = SlopeSeekingTuning.POSITIVE | {"comparison_time", "trial_mean", "level_time"}
    ORDER: ClassVar[tuple[str, ...]] = (
        *SlopeSeekingTuning.ORDER,
        "0 < slip_deep < slip_vent_deep < 1",
        "0 < slip_trial < slip_vent_deep < 1",
    )


class TwoMaxima(SlopeSeeking):
    """Slope seeking, and deep slip where a trial shows that slip cleans the rail.

    The law remembers over the distance the adhesion of the first group that slides, α_1. A group k behind is compared
    with it at the same place x, and at the same time t:

        d_k = ln α_k − ln α_1(x) or ln α_k − ln α_1(t), the one of smaller magnitude
        g = ⟨d_k⟩                        mean over the groups behind, weighted by load, averaged over `comparison_time`
        a trial begins                   where g > advantage_high
        deep slip ends                   where g < advantage_low, or where the train has lost adhesion by it

    Friction that varies along the track cancels in the first difference, friction that varies over time in the second.
    Only groups whose adhesion the rail limits are compared: they slide by similar slips, with less than `_FULL` of the
    highest pressure. A change between slope and deep slip clears the memory, because both groups of a comparison must
    have the same slip.

    In a trial the first group alone seeks `slip_trial`. With Δ a change of ln α since its begin, r that of groups
    between the place of the first slide of the stop and the places that the first group has slipped over, and k the
    groups that have reached the latter:

        e_1, e_k = min(Δ_1, Δ_1 − r), min(Δ_k, Δ_k − r)
        deep slip begins                 where e_1 + ⟨e_k⟩ > response_least, ⟨e_k⟩ > response_behind,
                                         or e_1 > response_own

    A change of friction over time is in r, and the rise of α where a group reaches the first slide is not: there the
    slip of the slope cleans the rail. Until then, Δ of a group is r. The cleaning of passing wheels is in both α before
    and after, so that there e_1 is the fall of the creep curve and e_k is zero. The trial fails once two groups have
    been at these places for `trial_wait` without that.

    In deep slip all groups seek `slip_deep`; a group whose deep slip has done `work_max` returns to the slope. Deep
    slip also ends where the mean of ln α of the train, over `level_time`, falls by `level_loss` below that before it.
    After the end of deep slip or of a trial, no trial begins before the speed is down to `speed_ratio` of that at the
    end. If the positions of the groups are not known, or there is one group, the law is slope seeking.
    """

    description = "Slip control at the better of two maxima of adhesion"
    tuning = TwoMaximaTuning
    ranges: ClassVar[Ranges] = {
        ("pneumatic", "estimated"): {
            "slip_deep": (0.3, 0.6),
            "advantage_high": (0.03, 0.2),
            "advantage_low": (0.02, 0.06),
            "comparison_time": (0.5, 2.0),
        }
    }

    @classmethod
    def demands(cls, draft: FormulaBuilder, tuning: Symbols, train: Sequence[GroupObservation]) -> list[Expression]:
        """Return the demanded pressure of each group [Pa]."""
        deep = draft.state("deep", "1", "1 in deep slip")
        trial = draft.state("trial", "1", "1 while one group tries deep slip")
        vent = choose(either(deep > 0.5, trial > 0.5), tuning["slip_vent_deep"], tuning["slip_vent"])
        t = {**tuning, "slip_vent": vent}
        wheels = [wheels_of(draft, group, t) for group in train]
        compared = GroupComparison(draft, wheels, t, deep, trial)
        speed = train[0].speed
        ended = draft.state("ended_speed", "m/s", "train speed at which deep slip or a trial ended last", _BEYOND)
        begins = every(
            deep < 0.5,
            trial < 0.5,
            compared.compares,
            compared.advantage > t["advantage_high"],
            speed < t["speed_ratio"] * ended,
            speed > t["trial_speed"],
        )
        succeeds, fails, leads = compared.attempt(begins)
        ends = every(deep > 0.5, either(compared.advantage < t["advantage_low"], compared.loses()))
        draft.keep(ended, choose(either(ends, fails), speed, ended))
        draft.keep(trial, choose(begins, 1.0, choose(either(succeeds, fails), 0.0, trial)))
        following = choose(succeeds, 1.0, choose(ends, 0.0, deep))
        draft.keep(deep, following)
        draft.show("deep_slip", "1", "1 in deep slip", following)
        draft.show("deep_trial", "1", "1 while one group tries deep slip", trial)
        goal = choose(deep > 0.5, t["slip_deep"], t["slip_trial"])
        dives = [either(deep > 0.5, every(trial > 0.5, lead)) for lead in leads]
        return seek(draft, wheels, _slips(draft, wheels, {**t, "slip_deep": goal}, dives), t)


_CELL, _CELLS = 1.0, 48
"""Length [m] and number of the cells of the memory: groups further behind the first than all cells are not compared."""

_BEYOND = 1e9  # more than any speed [m/s] or place [m]
_UNKNOWN = 0.0  # ln(adhesion) of a cell without one
_LEAST = 1e-3  # adhesion, in logarithms
_LARGEST = 0.6  # magnitude of a difference of ln(adhesion), beyond which it has other causes
_FULL = 0.95  # share of the highest pressure from which the brake, not the rail, limits adhesion
_AHEAD = 4  # cells that are cleared ahead of the first group: more than it passes within one sample
_ALIKE = 2.0  # largest ratio of slips of groups that are compared: a valve that sticks leaves a group elsewhere
_REACHED = 0.6  # share of deep slip from which a group is in it
_BACK = 1.3  # slip over its target above which a group still returns from deep slip
_ENTRY = 5.0  # m, within which a slide begins
_WITNESSES = 2  # groups behind that must have reached the cleaned places
_BEGIN = 0.03  # lowest slip from which deep slip is approached


class GroupComparison:
    """Groups behind compared with the first group that the rail limits, and what follows from it.

    Attributes:
        advantage: ln of the adhesion of groups behind over that of the first one at the same place, averaged.
        compares: Whether groups are compared now.
    """

    def __init__(
        self, draft: FormulaBuilder, train: Sequence[Wheels], t: Symbols, deep: Expression, trial: Expression
    ) -> None:
        """Compare the groups at the same places.

        The distance of a group is that from the place of the leading wheelset at the brake demand.
        """
        last_distance = draft.state("distance", "m", "distance since braking began")
        distance = last_distance + train[0].group.speed * t["period"]
        draft.keep(last_distance, distance)
        logarithms = [ca.log(ca.fmax(each.adhesion, _LEAST)) for each in train]
        limited: list[Expression] = []
        for each in train:
            enough = choose(deep > 0.5, each.filtered > _REACHED * t["slip_deep"], 1.0)
            by_rail = each.group.pressure < _FULL * each.group.brake["pressure_max"]
            limited.append(every(each.sliding, enough, by_rail))

        places = [distance - draft.parameter(each.group.label("position"), "m", _POSITION) for each in train]
        loads = [each.group.brake["load"] for each in train]
        found, place, value, slip = 0.0, distance, _UNKNOWN, 1.0  # of the first group that the rail limits
        behind: list[Expression] = []
        first: list[Expression] = []
        for each, at, logarithm, counts in zip(train, places, logarithms, limited, strict=True):
            is_first = every(found < 0.5, counts)
            first.append(is_first)
            behind.append(every(found > 0.5, counts))
            place = choose(is_first, at, place)
            value = choose(is_first, logarithm, value)
            slip = choose(is_first, each.filtered, slip)
            found = choose(is_first, 1.0, found)
        slide = draft.state("slide_place", "m", "where the first group first slid", _BEYOND)
        draft.keep(slide, choose(found > 0.5, ca.fmin(slide, place), slide))
        recall = _memory(draft, place, value, deep + trial)
        differences: list[tuple[Expression, Expression]] = []
        for each, counts, at, logarithm in zip(train, behind, places, logarithms, strict=True):
            known = recall(at)
            near = place - at < _CELL * (_CELLS - _AHEAD - 1)
            at_place, at_time = logarithm - known, logarithm - value
            smaller = choose(ca.fabs(at_place) < ca.fabs(at_time), at_place, at_time)
            alike = every(each.filtered < _ALIKE * slip, slip < _ALIKE * each.filtered)
            counts = every(counts, alike, near, known < _UNKNOWN, value < _UNKNOWN, trial < 0.5)
            differences.append((counts, within(smaller, -_LARGEST, _LARGEST)))
        compares = either(0.0, *(counts for counts, _ in differences))
        last = draft.state("advantage_before", "1", "mean of the comparison at the last sample")
        share = choose(compares, t["period"] / t["comparison_time"], 0.0)
        advantage = last + share * (weighted_mean(differences, loads) - last)
        draft.keep(last, advantage)
        meaning = "ln(adhesion) of groups behind over that of the first at the same place"
        draft.show("advantage", "1", meaning, advantage)
        self.advantage, self.compares = advantage, compares
        self._draft, self._train, self._t, self._deep, self._trial = draft, train, t, deep, trial
        self._places, self._logarithms, self._loads = places, logarithms, loads
        self._is_first, self._limited, self._slide = first, limited, slide

    def attempt(self, begins: Expression) -> tuple[Expression, Expression, list[Expression]]:
        """Let the first group slip deep; return whether the trial succeeds or fails now, and whether each group leads.

        The cleaning of passing wheels does not depend on their slip. So the trial succeeds where the first group loses
        no adhesion by deep slip, or where groups behind gain as much at the places that it has slipped over.
        """
        draft, t, trial = self._draft, self._t, self._trial
        leads: list[Expression] = []
        for each, is_first in zip(self._train, self._is_first, strict=True):
            lead = draft.state(each.group.label("leads"), "1", "1 if it slips deep in a trial")
            leads.append(choose(begins, is_first, lead))
            draft.keep(lead, leads[-1])
        is_lead = [lead > 0.5 for lead in leads]
        own, behind, reached, enough = self._response(begins, is_lead)
        period = t["period"]
        settled = draft.state("settled", "s", "time since the first group reached its slip")
        waited = draft.state("waited", "s", "time for which enough groups have been at places that it has slipped over")
        elapsed = draft.state("elapsed", "s", "time since the trial began")
        draft.keep(settled, choose(begins, 0.0, settled + choose(reached, period, 0.0)))
        draft.keep(waited, choose(begins, 0.0, waited + choose(enough, period, 0.0)))
        draft.keep(elapsed, choose(begins, 0.0, elapsed + period))
        gains = either(own + behind > t["response_least"], behind > t["response_behind"])
        by_behind = every(enough, waited > t["trial_mean"], gains)
        by_own = every(settled > 2.0 * t["trial_mean"], own > t["response_own"])
        succeeds = every(trial > 0.5, either(by_behind, by_own))
        over = either(waited > t["trial_wait"], elapsed > t["trial_longest"])
        fails = every(trial > 0.5, over, ca.logic_not(succeeds))
        return succeeds, fails, is_lead

    def _response(
        self, begins: Expression, is_lead: Sequence[Expression]
    ) -> tuple[Expression, Expression, Expression, Expression]:
        """Return the changes of ln(adhesion) since the trial began, without those that all groups have.

        These are the change of the first group, and the mean change of the groups behind that are at places that it
        has slipped over; then whether the first group has reached its slip, and whether `_WITNESSES` groups, or all
        that the rail limited before the trial, are at these places.

        A group that the brake limits at the cleaned places gains at least what it shows. Friction that varies over time
        changes the groups that have not reached these places, too: the smaller one of a change and its difference to
        theirs counts.
        """
        draft, train, t, trial = self._draft, self._train, self._t, self._trial

        def of_lead(values: Sequence[Expression]) -> Expression:
            return sum(choose(lead, value, 0.0) for lead, value in zip(is_lead, values, strict=True))

        place = of_lead(self._places)
        dive = draft.state("dive_place", "m", "where the first group left the slope")
        draft.keep(dive, choose(begins, place, dive))
        begin = draft.state("trial_place", "m", "where the first group reached its slip in a trial; 0 before that")
        has_slip = of_lead([each.filtered for each in train]) > _REACHED * t["slip_trial"]
        start = choose(begins, 0.0, choose(every(trial > 0.5, begin <= 0.0, has_slip), place, begin))
        draft.keep(begin, start)

        entered = self._slide + _ENTRY
        last_of_rail = draft.state("change_of_rail", "1", "change of ln(adhesion) of groups before the cleaned places")
        changes: list[Expression] = []
        others: list[Expression] = []
        rows = zip(train, self._places, self._logarithms, self._limited, is_lead, strict=True)
        for each, at, logarithm, limits, lead in rows:
            last = draft.state(each.group.label("smooth"), "1", "mean of ln(adhesion)")
            mean = last + t["period"] / (t["trial_mean"] + t["period"]) * (logarithm - last)
            draft.keep(last, mean)
            before = draft.state(each.group.label("before"), "1", "that before the trial, or after the first slide")
            draft.keep(before, choose(begins, mean, choose(at < entered, mean - last_of_rail, before)))
            changes.append(mean - before)
            was = draft.state(each.group.label("was_limited"), "1", "1 if the rail limited adhesion before the trial")
            draft.keep(was, choose(begins, limits, was))
            others.append(every(was > 0.5, ca.logic_not(lead)))
        untouched = [every(other, at > entered, at < dive) for other, at in zip(others, self._places, strict=True)]
        inside = [every(other, start > 0.0, at > start) for other, at in zip(others, self._places, strict=True)]
        present = weighted_mean(list(zip(untouched, changes, strict=True)), self._loads)
        of_rail = choose(either(0.0, *untouched), present, last_of_rail)
        draft.keep(last_of_rail, choose(begins, 0.0, of_rail))
        by_slip = [ca.fmin(change, change - of_rail) for change in changes]
        own, behind = of_lead(by_slip), weighted_mean(list(zip(inside, by_slip, strict=True)), self._loads)
        number = sum(choose(other, 1.0, 0.0) for other in others)
        count = sum(choose(each, 1.0, 0.0) for each in inside)
        meaning = "ln(adhesion) in a trial: change of the first group and of those behind"
        draft.show("response", "1", meaning, own + behind)
        return own, behind, start > 0.0, count >= ca.fmin(number, _WITNESSES)

    def loses(self) -> Expression:
        """Return whether the train has less adhesion in deep slip than on the slope before it."""
        draft, t = self._draft, self._t
        pairs = list(zip([each.valid for each in self._train], self._logarithms, strict=True))
        present, is_deep, period = weighted_mean(pairs, self._loads), self._deep > 0.5, t["period"]

        def mean(name: str, counts: Expression, begins: Expression) -> tuple[Expression, Expression]:
            """Return the mean since it began, over the last `level_time` at most, and its time so far."""
            before = draft.state(f"level_{name}", "1", f"mean of ln(adhesion) of the train {name}")
            since = draft.state(f"time_{name}", "s", "for how long that has been formed")
            last = choose(begins, 0.0, since)
            time = choose(counts, last + period, last)
            share = choose(counts, period / ca.fmax(ca.fmin(time, t["level_time"]), period), 0.0)
            now = before + share * (present - before)
            draft.keep(before, now)
            draft.keep(since, time)
            return now, time

        on_slope = every(ca.logic_not(is_deep), self._trial < 0.5, either(0.0, *self._limited))
        slope, _ = mean("on_slope", on_slope, 0.0)
        level, time = mean("in_deep_slip", is_deep, ca.logic_not(is_deep))
        return every(is_deep, time >= t["level_time"], level < slope - t["level_loss"])


_POSITION = "distance of the group behind the leading wheelset"


def _memory(
    draft: FormulaBuilder, place: Expression, value: Expression, regime: Expression
) -> Callable[[Expression], Expression]:
    """Keep a value at a place [m], and return a function that returns the value at an earlier place."""
    before = draft.state("regime_before", "1", "1 in deep slip or a trial at the last sample")
    draft.keep(before, regime)

    def cell_of(place: Expression) -> Expression:
        return ca.fmod(ca.floor(ca.fmax(place, 0.0) / _CELL), float(_CELLS))

    here = cell_of(place)
    cells = [draft.state(f"memory[{i + 1}]", "1", "ln(adhesion) of the first group at a place") for i in range(_CELLS)]
    for i, cell in enumerate(cells):
        ahead = ca.fmod(i - here + _CELLS, float(_CELLS))
        # Metres that the train passes within one sample have no value; those of one turn of the memory before go.
        kept = choose(either(ahead <= _AHEAD, regime != before), _UNKNOWN, cell)
        draft.keep(cell, choose(ahead == 0.0, value, kept))

    def recall(place: Expression) -> Expression:
        wanted = cell_of(place)
        return choose(place > 0.0, sum(choose(wanted == float(i), cell, 0.0) for i, cell in enumerate(cells)), _UNKNOWN)

    return recall


def _slips(draft: FormulaBuilder, train: Sequence[Wheels], t: Symbols, dive_now: Sequence[Expression]) -> list[Target]:
    """Return the slip that each group seeks, and its rate [1/s]."""
    period = t["period"]
    dives: list[Expression] = []
    returning: list[Expression] = []
    for each, deep in zip(train, dive_now, strict=True):
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
