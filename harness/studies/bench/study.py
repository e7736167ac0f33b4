"""Everything whose duration is measured, in the order of the table."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Final

from railgrip.campaign.work import Work
from railgrip.report.page import Page
from railgrip.report.table import Table
from railgrip.studies.bench import Row, filters, fmi, machine, stop
from railgrip.studies.study import Study

CASES: Final[Mapping[str, Callable[[], Iterator[Row]]]] = {
    "cold build of all FMUs": stop.of_recipes,
    **{f"steps of {name}": partial(fmi.steps_of, name) for name in ("TwoPartTrain", "TwoPartTrainPneumatic")},
    "trains of 1 to 16 cars": stop.of_consists,
    "filter over TrainPrediction": partial(filters.of_train, "TrainPrediction", "train_ideal", "15 µs"),
    "filter over TrainPredictionReduced": partial(filters.of_train, "TrainPredictionReduced", "reduced_ideal", "5 µs"),
    **{f"decentralised filter, {groups} groups": partial(filters.of_groups, groups) for groups in (4, 8, 16, 32)},
    "filter of the roller rig": filters.of_rig,
    "filter of the field test over a recording": filters.of_recording,
    "whole stops, adhesion-based control": partial(stop.of_scenario, "adhesion-based control"),
    "whole stops, slip-based control": partial(
        stop.of_scenario, "slip-based control", "controller.kind=slip_two_state", "estimator.kind=none"
    ),
    "stops by what the filter evaluates": stop.of_predictions,
    "stops in two processes": stop.of_workers,
}
"""Activity → its rows."""


@dataclass(frozen=True)
class Bench(Study):
    """Measure durations, as medians and ratios of cases that run in turn.

    They are printed beside their targets and are not judged. Run it while nothing else runs.
    """

    def page(self, work: Work) -> Page:
        """Measure one case after the other, in this process, and return the table."""
        rows: list[Row] = []
        for doing, case in CASES.items():
            work.notify(doing)
            rows += case()
        table = Table.of(("what", "measured", "target"), rows, title=machine())
        return Page(
            title="Durations",
            question="How long do the parts of a stop take, and how do their durations compare?",
            answer=f"{len(rows)} durations and ratios were measured on {machine()}. The table has them beside targets.",
            template="studies/bench/bench.md.jinja",
            values={"machine": machine(), "durations": table},
            tables={"durations.csv": table},
            screen=(table,),
        )


STUDY = Bench
