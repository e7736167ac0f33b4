"""Commands for fill, hold and dump valves from demanded pressures."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cache
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from railgrip.base.system import SampledSystem
from railgrip.controllers.parameters import Parameters
from railgrip.controllers.sampled import Expression, FormulaBuilder, Sampled, choose
from railgrip.vehicle.signals import VALVE_INPUTS

FILL, HOLD, DUMP = 1.0, 0.0, -1.0
"""Commands; a valve that dumps vents its cylinders."""

BAND = 6e3
"""Half width [Pa] of the band in which valves hold. At medium pressure the shortest pulse, 20 ms, fills or vents some
15 kPa, and would skip a much narrower band. On the training rails a half width of 3 to 12 kPa changes the mean distance
of adhesion-based control by 0.2 %."""

PULSE_MIN = 20e-3
"""Shortest time [s] between two switchings of a valve: valves in service have minimum pulses of 20-40 ms."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ValveModel(Parameters):
    """Data of valves and brake cylinders that the valve logic assumes.

    Filling is towards the supply pressure, venting towards zero gauge pressure; the band is around the demand.
    """

    period: Annotated[float, "s", "between two commands"]
    dead_time: Annotated[float, "s", "from a command to the change of flow"]
    fill_time: Annotated[float, "s", "time constant of filling"]
    vent_time: Annotated[float, "s", "time constant of venting"]
    band: Annotated[float, "Pa", "half width of the band in which the valves hold"]
    pulse_min: Annotated[float, "s", "shortest time between two switchings"]


class ValveLogic(Sampled):
    """Three-state tracking of demanded pressures with a predictor over the dead time.

    A command acts on the pressure at the end of the dead time, not on the measured one. That pressure is predicted by
    a valve model with the commands that are still to take effect (Smith, 1957). A demand of zero or of full pressure
    is passed on at once as dump or fill, so that two-level controllers work as with binary valves.
    """

    def __init__(self, supplies: Sequence[float], model: ValveModel) -> None:
        """Start with valves that hold.

        Args:
            supplies: Pressure behind the fill valve of each group, the highest that its cylinders reach [Pa].
            model: Dead times and time constants of the valves.
        """
        delay = max(round(model.dead_time / model.period), 0)
        values = {f"supply[{g}]": supply for g, supply in enumerate(supplies, 1)}
        super().__init__(valve_logic(len(supplies), delay), values | asdict(model))
        # A valve may switch at the first command.
        self.state[[variable.name.startswith("age") for variable in self.formula.states]] = model.pulse_min

    def command(self, demands: Sequence[float], measured: Sequence[float] | NDArray[np.float64]) -> tuple[float, ...]:
        """Return −1 dump, 0 hold or +1 fill for each group, from demanded and measured pressures [Pa]."""
        groups = len(demands)
        self.inputs[:groups], self.inputs[groups:] = demands, measured
        return self.evaluate()


@cache
def valve_logic(groups: int, delay: int) -> SampledSystem:
    """Return the formula for a number of groups and a dead time of `delay` periods."""
    draft, numbers = FormulaBuilder(), range(1, groups + 1)
    demands, pressures = draft.vector(VALVE_INPUTS, groups)
    # The dead time is not a parameter of the formula: it determines the number of states.
    period, fill_time, vent_time, band, pulse_min = (
        draft.parameter(name, *meaning) for name, meaning in ValveModel.meanings().items() if name != "dead_time"
    )
    commands: list[Expression] = []
    for g, demand, pressure in zip(numbers, demands, pressures, strict=True):
        supply = draft.parameter(f"supply[{g}]", "Pa", "pressure behind the fill valve")
        command = draft.state(f"command[{g}]", "1", "last command", start=HOLD)
        age = draft.state(f"age[{g}]", "s", "since it changed")
        under_way = [draft.state(f"under_way[{g},{i}]", "1", "a command on its way", HOLD) for i in range(1, delay + 1)]
        predicted = pressure
        for acting in under_way:
            filled = predicted + (supply - predicted) * period / fill_time
            vented = predicted - predicted * period / vent_time
            predicted = choose(acting == FILL, filled, choose(acting == DUMP, vented, predicted))
        tracking = choose(predicted < demand - band, FILL, choose(predicted > demand + band, DUMP, HOLD))
        requested = choose(demand <= 0.0, DUMP, choose(demand >= supply, FILL, tracking))
        older = age + period
        # Ages are sums of periods: the tolerance keeps rounding from adding a period to the shortest pulse.
        sent = choose(older >= pulse_min - 1e-9, requested, command)
        draft.keep(age, choose(sent == command, older, 0.0))
        draft.keep(command, sent)
        # A shift register, oldest command first; without dead time it is empty.
        for place, following in zip(under_way, [*under_way[1:], sent], strict=False):
            draft.keep(place, following)
        commands.append(sent)
    for g, command in zip(numbers, commands, strict=True):
        draft.output(f"command[{g}]", "1", "-1 dump, 0 hold, 1 fill", command, within=(DUMP, FILL))
    return draft.formula("ValveLogic", "Tracks demanded pressures with fill, hold and dump valves")
