"""What a step of the compiled filter of the roller rig costs."""

import numpy as np

from railgrip.bench.stop import FilterCost, step_times
from railgrip.estimation.run import by_name
from railgrip.estimation.spec import LIBRARY, load_specification, prediction_for, settings_for
from railgrip.estimators.compiled import CompiledFilter


def rig_filter_cost(*, count: int = 20_000, rounds: int = 7, period: float = 5e-3) -> FilterCost:
    """Step the filter of the rig, again and again, from a braked start with readings that fit it; `period` in s."""
    specification = load_specification(LIBRARY / "rig_own.toml")
    prediction, settings = prediction_for(specification), settings_for(specification, period)
    process = by_name("process", settings.process, prediction.states)
    readings = by_name("readings", settings.readings, prediction.outputs)
    running = CompiledFilter(prediction, process, readings, period, settings.gate)
    mean = np.array([70.0, 33.0, 0.35, 0.05])
    first = running.start(mean, by_name("deviation", settings.start_deviation, prediction.states) ** 2)
    advance, step = step_times(running, first, np.array([20e3]), mean[:2].copy(), count, rounds)
    return FilterCost(states=len(prediction.states), advance=advance, step=step)
