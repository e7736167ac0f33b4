"""A ride of the instrumented car with a trained estimator beside it, as a TOML file: sample by sample, in the loop.

name = "wet-60mph"

[car]
speed = "60 mph"
condition = "wet"                   # dry, friction modifier, wet, detergent, paper tape
friction = 0.2
track = "erri-low"                  # erri-low, erri-high, fra-5, fra-6
track_seed = 40
seed = 41
length = "400 m"
direction = 1                       # -1: the fourth wheelset leads

[estimator]
kind = "learned"                    # what `railgrip learn` trained, in CasADi; or "fmu", any FMU of the same edge
file = "build/learn/friction.json"      # from here or from the folder of this file
"""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import xarray
from matplotlib.figure import Figure
from pydantic import Field, StrictInt

from railgrip.errors import ScenarioError
from railgrip.estimators.arrays import Array
from railgrip.estimators.learned.ensemble import QUANTILE
from railgrip.estimators.learned.online import BOXES
from railgrip.estimators.learned.trained import RunEstimates, Trained, load
from railgrip.loop.beside import Watched, watch
from railgrip.report.style import GREEN, band, dress, panels
from railgrip.scenario.load import read_toml, validated
from railgrip.scenario.table import Friction, Length, Name, Seed, Speed, Table, one_of
from railgrip.studies.axle_box.accelerometer import RATE
from railgrip.studies.axle_box.instrumented_car import SURFACES, Pass, car_of
from railgrip.studies.axle_box.parties import AxleBoxes, in_casadi, in_fmu
from railgrip.track.irregularity import TRACKS

LIBRARY = Path(__file__).parent / "library"


class CarTable(Table):
    """[car]: everything that decides what is simulated."""

    speed: Speed
    condition: Annotated[str, one_of(SURFACES)]
    friction: Friction
    track: Annotated[str, one_of(TRACKS)]
    track_seed: Annotated[StrictInt, Field(ge=0)]
    seed: Seed
    length: Length
    direction: Literal[1, -1] = 1


class EstimatorTable(Table):
    """[estimator]: who listens."""

    kind: Literal["learned", "fmu"]
    file: str = Field(
        description=".json of `railgrip learn`, or an FMU; from the working directory or this file's folder"
    )
    trust: bool = Field(default=False, description="load an FMU into this process; otherwise it has one of its own")


class RideFile(Table):
    """Everything that decides a ride."""

    name: Name
    car: CarTable
    estimator: EstimatorTable

    def run(self) -> Pass:
        """Return what is simulated."""
        car = self.car
        return Pass(
            # Not the name of the file: what is simulated hangs on the seeds alone.
            name="ride", speed=car.speed, condition=car.condition, friction=car.friction, track=car.track,
            track_seed=car.track_seed, seed=car.seed, backwards=car.direction < 0, length=car.length,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RideResult:
    """What a ride gave.

    Attributes:
        trace: Truth, readings and belief on the grid of the loggers.
        apart: Largest difference in friction between the loop and the same estimator over the recorded readings at
            once; None where the estimator is not known but as an FMU.
    """

    trace: xarray.Dataset
    apart: float | None


def read_ride(file: Path) -> RideFile:
    """Return the ride that a TOML file describes.

    Raises:
        ScenarioError: The file is missing or not a ride; each problem in one sentence.
    """
    return validated(RideFile, read_toml(file), directory=file.parent, origin=file.name)


def ride_beside(
    ride_file: RideFile,
    directory: Path,
    progress: Callable[[float], None] = lambda share: None,
    tell: Callable[[str], None] = lambda sentence: None,
) -> RideResult:
    """Run the car and the estimator side by side, sample by sample, through the protocols of the loop.

    Args:
        directory: Where the file of the estimator is, if not in the working directory.
        progress: Told the share that is done.
        tell: Gets a sentence for the user when an FMU runs in a process of its own.

    Raises:
        ScenarioError, EstimatorError, FmuError: The estimator cannot be used.
        PlantFailed: The car or an FMU could not be stepped.
    """
    run, file = ride_file.run(), Path(ride_file.estimator.file)
    if not file.is_file():
        file = directory / file
    with ExitStack() as stack:
        trained: Trained | None = None
        if ride_file.estimator.kind == "learned":
            trained = load(file)
            _require_rate(file, trained.rate)
            estimator = in_casadi(trained.online())
        else:
            estimator = stack.enter_context(in_fmu(file, RATE, trusted=ride_file.estimator.trust, tell=tell))
        car, inputs, lead_in = stack.enter_context(car_of(run, rate=RATE))
        count = len(inputs) - lead_in
        record = watch(
            plant=car,
            inputs=inputs,
            sensors=AxleBoxes(run, count),
            estimator=estimator,
            estimator_inputs=np.array([-1.0 if run.backwards else 1.0]),
            lead_in=lead_in,
            progress=lambda sample: progress(sample / count),
        )
    apart = None if trained is None else difference(record, said_of(trained, record, run))
    return RideResult(trace=_trace(ride_file, record, inputs[lead_in:, 16:]), apart=apart)


def said_of(trained: Trained, record: Watched, run: Pass) -> RunEstimates:
    """Return what an estimator says of the readings of a ride, all at once."""
    return trained.offline(record.reading[:, : len(BOXES)], record.reading[:, len(BOXES)], backwards=run.backwards)


def difference(record: Watched, answer: RunEstimates) -> float:
    """Return the largest difference in friction between the loop and an estimate of the same readings at once."""
    return float(np.max(np.abs(record.mean[answer.sample, 0] - answer.friction), initial=0.0))


def _require_rate(file: Path, rate: int) -> None:
    if rate != RATE:
        raise ScenarioError(f"{file}: it takes {rate} samples a second, the loggers of the car write {RATE}.")


def ride_figure(trace: xarray.Dataset) -> Figure:
    """Return friction over the distance: the truth under the car, the estimate and its 90 % interval."""
    sheet, axes = panels(8.0, 3.0)
    every = trace.isel(time=slice(RATE // 10, None, RATE // 10))
    distance = np.cumsum(trace["speed"].values)[RATE // 10 :: RATE // 10] / RATE
    friction, half = every["friction"].values, QUANTILE * every["friction_sd"].values
    axes.plot(distance, every["true_friction"].values, color="black", linewidth=1.2, label="true, mean of wheelsets")
    axes.plot(distance, friction, color=GREEN, linewidth=1.2, label="estimate")
    if np.isfinite(half).any():
        low, high = np.maximum(friction - half, 0), np.minimum(friction + half, 1)
        band(axes, distance, low, high, GREEN, 0.2, label="90 % interval")
    axes.set_ylim(0, 0.6)
    axes.set_xlim(0, None)
    axes.legend(fontsize=8, ncols=3, loc="upper right")
    dress(axes, x="distance [m]", y="friction", title=trace.attrs["name"])
    return sheet


def _trace(ride_file: RideFile, record: Watched, friction: Array) -> xarray.Dataset:
    count = len(record.mean)
    time = np.arange(count) / RATE
    signals = {name: (record.reading[:, k], "m/s2") for k, name in enumerate(BOXES)}
    signals["speed"] = record.reading[:, len(BOXES)], "m/s"
    signals["true_friction"] = friction.mean(axis=1), "1"
    signals["friction"] = record.mean[:, 0], "1"
    signals["friction_sd"] = np.sqrt(record.variance[:, 0]), "1"
    return xarray.Dataset(
        {name: ("time", values, {"units": unit}) for name, (values, unit) in signals.items()},
        coords={"time": ("time", time, {"units": "s"})},
        attrs={"name": ride_file.name, "period": 1 / RATE, "estimator": ride_file.estimator.file},
    )
