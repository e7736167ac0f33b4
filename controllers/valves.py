"""From a demanded pressure to fill, hold and dump valves."""

from collections import deque
from dataclasses import dataclass

FILL, HOLD, DUMP = 1.0, 0.0, -1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ValveModel:
    """What the valve logic believes of one group's valves and brake cylinder.

    Attributes:
        period: Between two commands [s].
        dead_time: From a command to the change of flow [s].
        fill_time: Time constant of filling towards `supply` [s].
        vent_time: Time constant of venting towards zero gauge pressure [s].
        supply: Pressure behind the fill valve [Pa].
        band: Half width of the band around the demand in which the valves hold [Pa].
        pulse_min: Shortest time a valve stays as it is [s].
    """

    period: float
    dead_time: float
    fill_time: float
    vent_time: float
    supply: float
    band: float
    pulse_min: float


class ValveLogic:
    """Three-state tracking of a demanded pressure with a predictor over the dead time.

    The pressure that matters for a command is the one when it takes effect, not the measured one: commands on their
    way are run through the valve model first (Smith, 1957). A demand of zero or of full pressure is passed on at
    once as dump or fill, so that two-level controllers work as they do with binary valves.
    """

    def __init__(self, full: float, model: ValveModel) -> None:
        """Serve a group whose highest pressure is `full` [Pa]."""
        self._full = full
        self._model = model
        delay = max(round(model.dead_time / model.period), 0)
        self._under_way: deque[float] = deque([HOLD] * delay, maxlen=delay) if delay else deque(maxlen=0)
        self._command = HOLD
        self._age = model.pulse_min

    def command(self, demand: float, measured: float) -> float:
        """Return −1 dump, 0 hold or +1 fill for a demanded and a measured pressure [Pa]."""
        model = self._model
        self._age += model.period
        if self._age >= model.pulse_min - 1e-9:
            wanted = self._wanted(demand, self._predicted(measured))
            if wanted != self._command:
                self._command, self._age = wanted, 0.0
        self._under_way.append(self._command)
        return self._command

    def _wanted(self, demand: float, predicted: float) -> float:
        if demand <= 0.0:
            return DUMP
        if demand >= self._full:
            return FILL
        if predicted < demand - self._model.band:
            return FILL
        if predicted > demand + self._model.band:
            return DUMP
        return HOLD

    def _predicted(self, pressure: float) -> float:
        model = self._model
        for command in self._under_way:
            if command == FILL:
                pressure += (model.supply - pressure) * model.period / model.fill_time
            elif command == DUMP:
                pressure -= pressure * model.period / model.vent_time
        return pressure
