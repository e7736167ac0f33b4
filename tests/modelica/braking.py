"""Stops of the train FMUs for the tests of the Modelica library."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache

import numpy as np
from bound_fmu import bind_all

from railgrip.fmi import CoSimulation, describe
from railgrip.fmus.build import fmu

Signal = Callable[[float], float | Sequence[float] | np.ndarray]
Record = dict[str, np.ndarray]


class Train:
    """A train FMU that can be stopped repeatedly."""

    def __init__(self, name: str) -> None:
        self.description = describe(fmu(name))
        self.binding = bind_all(self.description)
        self.inputs = dict.fromkeys(name.partition("[")[0] for name in self.binding.inputs.elements)

    def run(
        self,
        parameters: Mapping[str, float],
        inputs: Mapping[str, Signal],
        until: float,
        *,
        step: float = 2e-3,
        keep: int = 5,
        past_standstill: bool = False,
    ) -> Record:
        """Step the FMU and record every `keep`-th sample; arrays have shape (samples,) or (samples, n).

        Half the step hardly changes a stop (test_train_stops.py). Inputs are held over a step; a signal returns a value
        for each element of an array.
        """
        elements = self.binding.outputs.elements
        standstill = elements.index("standstill")
        with CoSimulation(self.description, self.binding, period=step, parameters=dict(parameters)) as train:
            rows = [train.start(self.at(inputs, 0.0))]
            for k in range(round(until / step)):
                outputs = train.step(self.at(inputs, k * step))
                if (k + 1) % keep == 0:
                    rows.append(outputs)
                    if outputs[standstill] and not past_standstill:
                        break
        columns: dict[str, list[np.ndarray]] = {}
        for element, values in zip(elements, np.array(rows).T, strict=True):
            columns.setdefault(element.partition("[")[0], []).append(values)
        return {"time": keep * step * np.arange(len(rows))} | {
            name: np.stack(values, axis=1) if f"{name}[1]" in elements else values[0]
            for name, values in columns.items()
        }

    def at(self, inputs: Mapping[str, Signal], time: float) -> np.ndarray:
        """Return the values of all inputs at a time."""
        return np.concatenate([np.atleast_1d(inputs[name](time)) for name in self.inputs]).astype(float)


G = 9.81
FULL = np.array([3.4e5, 2.0e5, 2.0e5, 3.4e5])
"""Largest cylinder pressures of the groups, Pa."""

DRY = {"k_A": 1.0, "k_S": 0.4, "A_falling": 0.4, "B_falling": 0.6}
WET = {"k_A": 0.3, "k_S": 0.1, "A_falling": 0.4, "B_falling": 0.2}
MASS = 84000.0


def emergency(time: float) -> np.ndarray:
    """Pressure of an emergency brake: 0.4 s dead time, then a time constant of 0.5 s."""
    return FULL * (0.0 if time < 0.4 else 1 - np.exp(-(time - 0.4) / 0.5))


def friction(value: float) -> Signal:
    return lambda _: [value] * 6


def brake(train: Train, km_h: float, mu0: float | Signal, surface: dict[str, float], **more: object) -> Record:
    settings = {
        "parameters": surface | {"start_speed": km_h / 3.6},
        "until": 60.0,
        "pressure": emergency,
        "track_force": lambda _: 0.0,
    } | more
    pressure, track_force = settings.pop("pressure"), settings.pop("track_force")
    mu = mu0 if callable(mu0) else friction(mu0)
    inputs = {"pressure_command": pressure, "mu0": mu, "track_force": track_force}
    return train.run(inputs=inputs, **settings)


@cache
def emergency_stop(train: Train, km_h: float) -> Record:
    """Stop on a dry rail; run once and shared, so do not modify it."""
    return brake(train, km_h, 0.55, DRY)
