"""All measurements, in the order of the table."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

from railgrip.base.units import quantity
from railgrip.campaign.work import Work
from railgrip.report.page import Page
from railgrip.report.table import ReportTable
from railgrip.studies.bench import Row, filters, machine, stop
from railgrip.studies.study import Study

CASES: Final[Mapping[str, Callable[[], Iterator[Row]]]] = {
    "cold build of all FMUs": stop.of_recipes,
    **{f"steps of {name}": partial(stop.steps_of, name) for name in ("TwoPartTrain", "TwoPartTrainPneumatic")},
    "trains of 1 to 16 cars": stop.of_consists,
    "filter over TrainPrediction": partial(filters.of_train, "TrainPrediction", "train_ideal", "15 µs"),
    "filter over TrainPredictionReduced": partial(filters.of_train, "TrainPredictionReduced", "reduced_ideal", "5 µs"),
    **{f"decentralised filter, {groups} groups": partial(filters.of_groups, groups) for groups in (4, 8, 16, 32)},
    "filter of the roller rig": filters.of_rig,
    "filter of the field test over a recording": filters.of_recording,
    f"whole stops, {stop.ABC}": partial(stop.of_scenario, stop.ABC),
    "whole stops, slip-based control": partial(
        stop.of_scenario, "slip-based control", "controller.kind=slip_two_state", "estimator.kind=none"
    ),
    "stops by what the filter evaluates": stop.of_predictions,
    "stops in two processes": stop.of_workers,
}
"""Activity → its rows."""


@dataclass(frozen=True)
class BenchStudy(Study):
    """Measure durations, as medians and ratios of cases that run in turn.

    The page lists those that exceed their targets, which is not an error. Run it on an idle machine.
    """

    has_cases = False

    def page(self, work: Work) -> Page:
        """Measure one case after the other, in this process, and return the table."""
        rows: list[Row] = []
        for doing, case in CASES.items():
            work.notify(doing)
            rows += case()
        table = ReportTable.of(("what", "measured", "target"), rows, title=machine())
        return Page(
            title="Durations",
            question="How long do the parts of a stop take, and how do their durations compare?",
            answer=answer(rows),
            template="studies/bench/bench.md.jinja",
            values={"machine": machine(), "durations": table},
            tables={"durations.csv": table},
            screen=(table,),
        )


def answer(rows: Sequence[Row]) -> str:
    """Return the time of a cycle, the speed of a stop relative to real time, and the times that exceed their target."""
    measured = {what: figure for what, figure, _ in reversed(rows)}  # of rows with one name, the first
    cycle, faster = measured[f"{stop.ABC}{stop.CYCLE}"], measured[stop.FASTER]
    judged, over, head = 0, list[str](), ""
    for what, figure, target in rows:
        head = head if what.startswith(" ") else what
        judged += bool(target)
        if target and _is_over(figure, target):
            name = head if what == head else f"{head} – {what.strip()}"
            over.append(f"{name}: {figure}, target {target}")
    verdict = f"{len(over)} over target: {'; '.join(over)}" if over else "none is over it"
    return (
        f"With {stop.ABC} and a compiled law, a cycle of the loop takes {cycle}, and a stop with assembly and "
        f"figures runs {faster} times faster than real time. Of {judged} durations and ratios with a target, {verdict}."
    )


def _is_over(figure: str, target: str) -> bool:
    limit = target.removeprefix(stop.AT_LEAST)
    sizes: list[float] = []
    for text in (figure, limit):
        match = re.match(r"[\d.]+( ([µm]?s|min)\b)?", text)
        assert match is not None, text
        number, unit = quantity(match[0])
        sizes.append(unit.factor * number)
    return sizes[0] > sizes[1] if limit == target else sizes[0] < sizes[1]


STUDY = BenchStudy
