"""Stops of the train FMUs, stepped through FMPy, for the tests of the Modelica library."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache

import numpy as np
from slave import Slave

from railgrip.fmus.build import fmu

Signal = Callable[[float], float | Sequence[float] | np.ndarray]
Record = dict[str, np.ndarray]

WATCHED = [
    *("distance", "speed", "acceleration", "standstill", "air_used"),
    *("contact_heat", "pad_heat", "damper_heat", "resistance_work", "kinetic_energy"),
    *("wheelset_speed[4]", "locked[4]", "slip[4]", "adhesion[6]", "group_adhesion[4]"),
    *("wheelset_load[6]", "deflection[6]", "cylinder_pressure[4]", "pad_force[4]", "pad_friction[4]"),
    *("disc_temperature[4]", "disc_surface_temperature[4]", "brake_torque[4]"),
]
"""Recorded outputs; a number in brackets is a length."""

BOOLEAN = ("standstill", "locked[4]")


def scalars(name: str) -> list[str]:
    """Return the scalar names of an entry of `WATCHED`."""
    stem, bracket, rest = name.partition("[")
    return [f"{stem}[{i + 1}]" for i in range(int(rest[:-1]))] if bracket else [name]


class Train:
    """A train FMU that can be stopped repeatedly."""

    def __init__(self, name: str) -> None:
        self.file = fmu(name)

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

        Half the step hardly changes a stop (test_train_stops.py), and calls of FMPy take longer than the FMU.
        Inputs are held over a step; a signal that returns a sequence sets `name[1]`, `name[2]` and so on.
        """
        boolean = [s for name in BOOLEAN for s in scalars(name)]
        real = [s for name in WATCHED if name not in BOOLEAN for s in scalars(name)]
        rows: list[list[float]] = []
        with Slave(self.file, {**parameters, **at(inputs, 0.0)}) as train:
            references = [train.reference[s] for s in boolean]
            for k in range(round(until / step) + 1):
                if k % keep == 0:
                    flags = train.fmu.getBoolean(references)
                    rows.append([k * step, *train.get(*real), *map(float, flags)])
                    if flags[boolean.index("standstill")] and k > 0 and not past_standstill:
                        break
                train.step(k, step, **at(inputs, k * step))
        table = dict(zip(["time", *real, *boolean], np.array(rows).T, strict=True))
        columns = {name: [table[s] for s in scalars(name)] for name in WATCHED}
        return {"time": table["time"]} | {
            name.partition("[")[0]: np.stack(own, axis=1) if "[" in name else own[0] for name, own in columns.items()
        }


def at(inputs: Mapping[str, Signal], time: float) -> dict[str, float]:
    """Return the values of scalar inputs at a time."""
    values: dict[str, float] = {}
    for name, signal in inputs.items():
        now = signal(time)
        elements = {name: now} if np.isscalar(now) else {f"{name}[{i + 1}]": value for i, value in enumerate(now)}
        values |= {element: float(value) for element, value in elements.items()}
    return values


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
