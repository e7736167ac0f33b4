"""The parties of the open loop: the car's axle boxes as sensors, and trained estimators, in CasADi or as an FMU."""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import numpy as np

from railgrip.errors import FmuError
from railgrip.estimators.belief import Vector
from railgrip.estimators.learned.ensemble import QUANTILE
from railgrip.estimators.learned.online import BOXES, Online
from railgrip.fmu import Signal, bind, describe, open_plant
from railgrip.fmus.native import Variable
from railgrip.studies.axle_box.accelerometer import AXLE_BOX, SampleBySample
from railgrip.studies.axle_box.instrumented_car import Pass, held_speed
from railgrip.studies.axle_box.measured import disturbance_of

READINGS: Final = (*BOXES, "speed")
"""What the instruments of the car show, in order: m/s² in axes of the car, and m/s."""


class AxleBoxes:
    """The instruments of the car on one run, sampled as its plant is: `READINGS` out of what the car shows."""

    def __init__(self, run: Pass, count: int) -> None:
        """Mount them for a run of `count` samples."""
        self._sensors = SampleBySample(AXLE_BOX, disturbance_of(run, count, held_speed(run)))
        self._backwards = run.backwards

    def read(self, sample: int, truth: Vector) -> Vector:
        """Return the reading of a sample; `truth` as `instrumented_car.car_of` describes it."""
        left, right, lateral = truth[0:4], truth[4:8], truth[8:12]
        if self._backwards:  # the sensors are fixed to a car that is turned by half a turn
            left, right, lateral = -right[::-1], -left[::-1], -lateral[::-1]
        boxes = self._sensors.read(sample, np.concatenate([left, right, lateral]))
        return np.append(boxes, truth[20])


class LearnedFriction:
    """A trained estimator as the loop's `Estimator`: a belief about friction alone, beside the memory of its filters.

    Attributes:
        mean: Friction, NaN before there is an estimate, shape (1,).
        covariance: Its variance, infinite before there is an estimate and NaN where there is no interval, shape (1, 1).
        inputs: Direction: +1 wheelset 1 leads, −1 wheelset 4 does, shape (1,).
        readings: As `READINGS`; where an entry is NaN the last one stands.
    """

    def __init__(self, advance: Callable[[Vector], Vector], inputs: tuple[str, ...], outputs: tuple[str, ...]) -> None:
        """Take what steps the estimator: from `inputs` at a sample to `outputs` after it."""
        self.mean, self.covariance = np.array([np.nan]), np.array([[np.inf]])
        self.inputs, self.readings = np.ones(1), np.full(len(READINGS), np.nan)
        self._advance = advance
        signals = (*READINGS, "direction")
        self._order = np.array([signals.index(name) for name in inputs])
        self._at = {name: place for place, name in enumerate(outputs)}
        self._latest = self.readings.copy()

    def advance(self) -> None:
        """Go on by one sample."""
        np.copyto(self._latest, self.readings, where=~np.isnan(self.readings))
        outputs, at = self._advance(np.concatenate([self._latest, self.inputs])[self._order]), self._at
        if outputs[at["known"]] < 0.5:
            return
        friction = self.mean[0] = outputs[at["friction"]]
        if "upper" not in at:
            self.covariance[0, 0] = np.nan
            return
        # Ends are cut off at 0 and 1; the longer half is the whole one.
        half = max(outputs[at["upper"]] - friction, friction - outputs[at["lower"]])
        self.covariance[0, 0] = (half / QUANTILE) ** 2


def in_casadi(online: Online) -> LearnedFriction:
    """Return a trained estimator stepped as a CasADi function."""
    return LearnedFriction(online.stepper(), _names(online.inputs), _names(online.outputs))


@contextmanager
def in_fmu(
    file: Path, rate: int, *, trusted: bool = False, tell: Callable[[str], None] = lambda sentence: None
) -> Generator[LearnedFriction]:
    """Yield a trained estimator that steps an FMU, made by `railgrip learn` or by anybody.

    Args:
        file: Co-simulation FMU with inputs out of `READINGS` and `direction`, and outputs `friction`, `known` and, if
            it gives an interval, `lower` and `upper`.
        rate: Samples a second that it is sent.
        trusted: Load it into this process; otherwise it runs in one of its own.
        tell: Gets a sentence for the user when it does.

    Raises:
        FmuError: It is no such FMU.
        PlantFailed: While it is stepped: it refuses a sample.
    """
    description = describe(file)
    units = dict.fromkeys(BOXES, "m/s2") | {"speed": "m/s", "direction": "1"}
    inputs = tuple(name for name in units if name in description.variables)
    outputs = tuple(name for name in ("friction", "lower", "upper", "known") if name in description.variables)
    if not {"friction", "known"} <= set(outputs) or not inputs:
        raise FmuError(
            f"{file}: is no estimator of friction; it wants outputs friction and known, and inputs among left[1] … "
            "lateral[4], speed and direction."
        )
    binding = bind(
        description,
        inputs=tuple(Signal(name=name, unit=units[name], size=0, needed=True) for name in inputs),
        outputs=tuple(Signal(name=name, unit="1", size=0, needed=True) for name in outputs),
        parameters=(), table={}, where=file.name,
    )  # fmt: skip
    context = open_plant(
        description, binding, period=1 / rate, parameters={}, trusted=trusted, tell=tell, table="[estimator]"
    )
    with context as model:
        has_begun = False

        def advance(sample: Vector) -> Vector:
            nonlocal has_begun
            if not has_begun:
                model.start(sample)
                has_begun = True
            return model.step(sample)

        yield LearnedFriction(advance, inputs, outputs)


def _names(variables: tuple[Variable, ...]) -> tuple[str, ...]:
    return tuple(variable.name for variable in variables)
