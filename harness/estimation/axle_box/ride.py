"""A ride of the instrumented car with a trained estimator, sample by sample, as a TOML file.

The estimator has no effect on the car: the whole ride is simulated first, then the estimator runs over its readings.

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
kind = "learned"                    # by `make learn`, in CasADi; or "fmu", an FMU with the same interface
file = "build/axle_box/friction.json"   # from the working directory or the folder of this file
"""

from collections.abc import Callable, Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated, Final, Literal

import numpy as np
import xarray
from matplotlib.figure import Figure
from pydantic import Field

from railgrip.base.errors import FmuError, ScenarioError
from railgrip.estimation.axle_box.instrumented_car import RATE, SURFACES, Pass, held_speed, measure_run, ride
from railgrip.estimators.belief import Array
from railgrip.estimators.learned.network import QUANTILE
from railgrip.estimators.learned.preprocessing import BOXES
from railgrip.estimators.learned.trained import Trained, load, run
from railgrip.fmi import Binding, Description, Port, bind, describe, foreign_code, open_plant
from railgrip.report.palette import GREEN
from railgrip.report.style import band, dress, panels
from railgrip.scenario.load import read_toml, validate_table
from railgrip.scenario.table import Friction, Length, Name, Seed, Speed, Table, one_of
from railgrip.scenario.track_geometry import TRACKS

LIBRARY = Path(__file__).parent / "library"
INPUTS: Final = dict.fromkeys(BOXES, "m/s2") | {"speed": "m/s", "direction": "1"}
"""Possible inputs of an estimator in order, and their units; direction: +1 wheelset 1 leads, -1 wheelset 4 does."""


class CarTable(Table):
    """[car]: inputs of the simulation."""

    speed: Speed
    condition: Annotated[str, one_of(SURFACES)]
    friction: Friction
    track: Annotated[str, one_of(TRACKS)]
    track_seed: Seed
    seed: Seed
    length: Length
    direction: Literal[1, -1] = 1


class EstimatorTable(Table):
    """[estimator]: the estimator of the ride."""

    kind: Literal["learned", "fmu"]
    file: str = Field(
        description=".json of `rg.learn_friction`, or an FMU; from the working directory or this file's folder"
    )
    trust: bool = Field(
        default=False, description="load an FMU into this process; otherwise it runs in a separate process"
    )


class RideFile(Table):
    """Inputs of a ride."""

    name: Name
    car: CarTable
    estimator: EstimatorTable

    def run(self) -> Pass:
        """Return the simulated pass."""
        car = self.car
        return Pass(
            # Not the name of the file, so that the simulation depends on the seeds alone.
            name="ride", speed=car.speed, condition=car.condition, friction=car.friction, track=car.track,
            track_seed=car.track_seed, seed=car.seed, backwards=car.direction < 0, length=car.length,
        )  # fmt: skip


def read_ride(file: Path) -> RideFile:
    """Return the ride that a TOML file describes.

    Raises:
        ScenarioError: The file is missing or invalid; it lists all problems.
    """
    return validate_table(RideFile, read_toml(file), directory=file.parent, origin=file.name)


def ride_with_estimator(
    ride_file: RideFile,
    directory: Path,
    progress: Callable[[float], None] = lambda share: None,
    notify: Callable[[str], None] = lambda sentence: None,
) -> tuple[xarray.Dataset, float | None]:
    """Run the car, and the estimator over its readings.

    Returns:
        True values, readings and estimates on the grid of the loggers; and the largest difference in friction between
        the estimator sample by sample and over all readings at once, None for an FMU.

    Args:
        directory: Folder of the file of the estimator, if it is not in the working directory.
        notify: Called with a sentence for the user if an FMU runs in a separate process.

    Raises:
        ScenarioError, EstimatorError, FmuError: The estimator cannot be used.
        PlantFailed: The car or an FMU could not be stepped.
    """
    run, table = ride_file.run(), ride_file.estimator
    file = Path(table.file) if Path(table.file).is_file() else directory / table.file
    trained = load(file) if table.kind == "learned" else None
    if trained is not None and trained.rate != RATE:
        raise ScenarioError(f"{file}: it needs {trained.rate} samples a second, the loggers of the car have {RATE}.")
    fmu = None if trained else bind_estimator(file)
    motion = ride(run, rate=RATE, progress=progress)
    readings = measure_run(run, motion, RATE, held_speed(run))
    boxes = readings.boxes
    direction = np.full(len(boxes), -1.0 if run.backwards else 1.0)
    samples = dict(zip(INPUTS, (*boxes.T, readings.speed, direction), strict=True))
    apart = None
    if fmu is not None:
        friction, deviation = belief_of(outputs_of_fmu(*fmu, RATE, samples, trusted=table.trust, notify=notify))
    else:
        assert trained is not None
        friction, deviation = belief_of(outputs_of(trained, samples))
        answer = trained.offline(boxes, readings.speed, backwards=run.backwards)
        apart = float(np.max(np.abs(friction[answer.sample] - answer.friction), initial=0.0))
    signals = {name: (values, INPUTS[name]) for name, values in samples.items() if name != "direction"}
    signals |= {
        "true_friction": (motion.friction.mean(axis=1), "1"),
        "friction": (friction, "1"),
        "friction_sd": (deviation, "1"),
    }
    trace = xarray.Dataset(
        {name: ("time", values, {"units": unit}) for name, (values, unit) in signals.items()},
        coords={"time": ("time", np.arange(len(boxes)) / RATE, {"units": "s"})},
        attrs={"name": ride_file.name, "period": 1 / RATE, "estimator": table.file},
    )
    return trace, apart


def outputs_of(trained: Trained, samples: Mapping[str, Array]) -> dict[str, Array]:
    """Return the outputs of a trained estimator after each sample, by name; `samples` as for `outputs_of_fmu`."""
    system = trained.online()
    outputs = run(system, np.column_stack([samples[variable.name] for variable in system.inputs]))
    return {variable.name: column for variable, column in zip(system.outputs, outputs.T, strict=True)}


def bind_estimator(file: Path) -> tuple[Description, Binding]:
    """Return an FMU by `make learn`, or of the same interface, and the binding of its variables.

    Args:
        file: Co-simulation FMU with inputs among `INPUTS`, and outputs `friction`, `known` and, with an interval,
            `lower` and `upper`.

    Raises:
        FmuError: Its interface is another one.
    """
    description = describe(file)
    inputs = [name for name in INPUTS if name in description.variables]
    outputs = [name for name in ("friction", "lower", "upper", "known") if name in description.variables]
    if not {"friction", "known"} <= set(outputs) or not inputs:
        raise FmuError(
            f"{file}: is not an estimator of friction; it needs outputs friction and known, and inputs among left[1] … "
            "lateral[4], speed and direction."
        )
    return description, bind(
        description,
        inputs=[Port(name=name, unit=INPUTS[name], size=0, needed=True) for name in inputs],
        outputs=[Port(name=name, unit="1", size=0, needed=True) for name in outputs],
        where=file.name,
    )


def outputs_of_fmu(
    description: Description,
    binding: Binding,
    rate: int,
    samples: Mapping[str, Array],
    *,
    trusted: bool = False,
    notify: Callable[[str], None] = lambda sentence: None,
) -> dict[str, Array]:
    """Return the outputs of an FMU after each sample, by name.

    Args:
        description, binding: See `bind_estimator`.
        rate: Sampling rate [Hz].
        samples: Of each of `INPUTS`, shape (n,).
        trusted: Load the FMU into this process; otherwise it runs in a separate one.
        notify: Called with a sentence for the user when it does.

    Raises:
        PlantFailed: The FMU rejects a sample.
    """
    rows = np.column_stack([samples[name] for name in binding.inputs.elements])
    context = open_plant(
        description,
        binding,
        period=1 / rate,
        parameters={},
        trusted=trusted,
        notify=notify,
        table="[estimator]",
        span=(0.0, len(rows) / rate),
    )
    with foreign_code(description.file.name) if trusted else nullcontext(), context as model:
        model.start(rows[0])
        return dict(zip(binding.outputs.elements, np.array([model.step(row) for row in rows]).T, strict=True))


def belief_of(outputs: Mapping[str, Array]) -> tuple[Array, Array]:
    """Return friction and its standard deviation after each sample, each of shape (n,).

    Before the first estimate friction is NaN and its deviation infinite; without an interval the deviation is NaN.
    """
    known = np.maximum.accumulate(np.where(outputs["known"] >= 0.5, np.arange(len(outputs["known"])), -1))
    latest = {name: values[known] for name, values in outputs.items()}
    friction, half = latest["friction"], np.full(len(known), np.nan)
    if "upper" in latest:
        # Ends are limited to 0 and 1, so the longer half is the complete one.
        half = np.maximum(latest["upper"] - friction, friction - latest["lower"])
    return np.where(known < 0, np.nan, friction), np.where(known < 0, np.inf, half / QUANTILE)


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
