"""What a step of the compiled filter of the roller rig costs."""

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from railgrip.estimation.run import by_name
from railgrip.estimation.spec import LIBRARY, load_specification, prediction_for, settings_for
from railgrip.estimators.compiled import CompiledFilter


@dataclass(frozen=True, slots=True, kw_only=True)
class FilterCost:
    """Cost of one step, prediction and update.

    Attributes:
        states: Of the filter.
        advance: Best of the rounds of a step through `CompiledFilter.advance` [µs]; what a loop pays.
        step: The same through `CompiledFilter.step`, which makes a new belief each time [µs].
    """

    states: int
    advance: float
    step: float


def rig_filter_cost(*, count: int = 20_000, rounds: int = 7, period: float = 5e-3) -> FilterCost:
    """Step the filter of the rig in place, again and again, from a braked start with readings that fit it.

    Args:
        count: Steps of a round.
        rounds: Their median counts.
        period: Of the filter [s].
    """
    specification = load_specification(LIBRARY / "rig_own.toml")
    prediction, settings = prediction_for(specification), settings_for(specification, period)
    process = by_name("process", settings.process, prediction.states)
    readings = by_name("readings", settings.readings, prediction.outputs)
    running = CompiledFilter(prediction, process, readings, period, settings.gate)
    mean = np.array([70.0, 33.0, 0.35, 0.05])
    first = running.start(mean, by_name("deviation", settings.start_deviation, prediction.states) ** 2)
    inputs, measured = np.array([20e3]), mean[:2].copy()
    advance: list[float] = []
    step: list[float] = []
    for _ in range(rounds):
        running.hold(first)
        running.held[:], running.seen[:] = inputs, measured
        start = perf_counter()
        for _ in range(count):
            running.advance()
        advance.append((perf_counter() - start) / count * 1e6)
        belief = first
        start = perf_counter()
        for _ in range(count):
            belief = running.step(belief, inputs, measured)
        step.append((perf_counter() - start) / count * 1e6)
    return FilterCost(states=len(prediction.states), advance=min(advance), step=min(step))
