"""Everything that `railgrip maintain bench` measures: activity → its rows, in the order of the table."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Final

from railgrip.studies.bench import Row, filters, fmi, stop

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
