"""The field test's runs, stops of the scenarios of a campaign, and its filter of 13 states with twelve parameters.

The parameters are the noises of equation (13).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import xarray
from numpy.typing import ArrayLike

from railgrip.base.errors import EstimationError
from railgrip.base.files import replacing
from railgrip.estimation.models import units_of
from railgrip.estimation.motion import Braking, braking_of
from railgrip.estimation.run import FilterData, by_name, filter_data
from railgrip.estimation.sources import stop_read
from railgrip.estimation.spec import (
    LIBRARY,
    CourseTable,
    NoiseTable,
    Specification,
    equations_for,
    load_specification,
    prediction_for,
    settings_for,
)
from railgrip.estimators.belief import Array, GaussianEstimate
from railgrip.estimators.compiled import CompiledFilter, FilterRecord
from railgrip.estimators.consistency import loss_step
from railgrip.estimators.prediction import CasadiPrediction, PredictionInC
from railgrip.recording.samples import knows, period_of, truth_of
from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.load import read_toml, validate_table
from railgrip.scenario.schema import Scenario
from railgrip.scenario.track import Plan
from railgrip.simulate.vehicle_data import VehicleData

TUNING = ("c1", "c2", "c3", "c4", "c5")
TEST = "c6"
"""Case that is never used for tuning."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldRun:
    """A run from rest to the stop.

    Attributes:
        recording: The whole run.
        braking: Its part for the filter.
        plan: Plan of the track, with the position at which the run begins.
    """

    recording: xarray.Dataset
    braking: Braking
    plan: Plan

    def plan_geometry(self, distance: Array) -> tuple[Array, Array]:
        """Return slope and curvature [1/m] of the plan in the direction of travel, at distances from the start [m]."""
        track, place = self.plan.alignment(), self.plan.place(distance)
        return self.plan.way * track.slope(place), self.plan.way * track.curvature(place)


def cases(file: Path | None = None, names: Sequence[str] = ()) -> dict[str, Scenario]:
    """Return the scenarios of a campaign by their variant of its axis `case`.

    Args:
        file: The campaign; field_test.toml when None.
        names: Cases to return; all if empty.

    Raises:
        ScenarioError: The file is missing or not a campaign.
        EstimationError: It has no such axis, a scenario has no [track.plan], or a case does not exist.
    """
    campaign = load_campaign(file or Path("field_test"))
    unlaid = next((stop.name for stop in campaign.stops if stop.scenario.track.plan is None), None)
    if unlaid is not None:
        raise EstimationError(f"{campaign.name}: the field test needs a [track.plan]; {unlaid} has none.")
    if any("case" not in stop.variants for stop in campaign.stops):
        raise EstimationError(f"{campaign.name}: the field test needs its cases as [axes.case.NAME].")
    scenarios = {stop.variants["case"]: stop.scenario for stop in campaign.stops}
    missing = [name for name in names if name not in scenarios]
    if missing:
        raise EstimationError(f"the field test needs the cases {', '.join(names)}; there is no {', '.join(missing)}.")
    return {name: scenarios[name] for name in names or scenarios}


def run(case: tuple[str, Scenario], import_from: Sequence[Path] = ()) -> FieldRun:
    """Return the run of a case by its name; classes that its scenario names are imported from `import_from`.

    Raises:
        EstimationError: See `braking_of`.
        ScenarioError: The stop fails.
    """
    name, scenario = case
    track = scenario.track
    assert track.plan is not None  # of every scenario of `cases`
    recording, vehicle = stop_read(scenario, f"{scenario.name} {name}", import_from), VehicleData(scenario)
    course = CourseTable(
        mass=vehicle.mass, wheelset_position=vehicle.formation.wheelset_position, curve_law=track.curve_law
    )
    return FieldRun(
        recording=recording,
        braking=braking_of(recording, course),
        plan=track.plan,
    )


NOISES = Path(__file__).parent / "library"
"""Folder of the tuned noises."""
GROUPS = 4
NAMES = (
    "R_v", *(f"R_w{i}" for i in range(1, GROUPS + 1)),
    "Q_v", *(f"Q_w{i}" for i in range(1, GROUPS + 1)), "Q_mu_b", "Q_alpha",
)  # fmt: skip
READINGS = ("speed", *(f"wheelset_speed[{i}]" for i in range(1, GROUPS + 1)))
PROCESSES = (
    "speed", *(f"wheelset_speed[{i}]" for i in range(1, GROUPS + 1)), "pad_friction", "group_adhesion",
)  # fmt: skip
"""The same in the [noise] of an estimation; μ_B has one number for all groups, and so has α."""
UNITS = (
    "(m/s)2", *["(rad/s)2"] * GROUPS, "(m/s)2/s", *["(rad/s)2/s"] * GROUPS, "1/s", "1/s",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Noise:
    """Noises of the 13-state filter, all positive.

    Attributes:
        values: In the order of `NAMES`: variances of speed and wheelset speeds, densities of v, w, μ_B and α.
    """

    values: tuple[float, ...]

    @classmethod
    def of(cls, logarithms: ArrayLike) -> "Noise":
        """Return the noises of given decadic logarithms."""
        return cls(tuple(float(v) for v in 10.0 ** np.asarray(logarithms, dtype=np.float64)))

    @property
    def logarithms(self) -> Array:
        """Decadic logarithms, shape (12,)."""
        return np.log10(self.values)

    @property
    def readings(self) -> Array:
        """Variances of speed and wheelset speeds, shape (5,)."""
        return np.array(self.values[: 1 + GROUPS])

    @property
    def process(self) -> Array:
        """Densities of v, w, μ_B, α, shape (13,)."""
        v, *w, mu, alpha = self.values[1 + GROUPS :]
        return np.array([v, *w, *[mu] * GROUPS, *[alpha] * GROUPS])

    def scale(self, readings: float, process: float) -> "Noise":
        """Return the noises with all variances of readings times one factor, and all densities times another."""
        return Noise(
            (*(v * readings for v in self.values[: 1 + GROUPS]), *(v * process for v in self.values[1 + GROUPS :]))
        )


PHYSICAL = Noise((0.03**2, *[0.02**2] * GROUPS, 1e-3**2, *[1e-2**2] * GROUPS, 0.01**2, 0.1**2))
"""From sensors and physics, without tuning: noise of the sensors, 100 N of wind on 84 t, pad friction that changes by
0.05 in a stop, adhesion that changes by 0.03 in 0.1 s."""


def load_noise(path: Path) -> Noise:
    """Return the noises in a file by `save_noise`, the [noise] of an estimation.

    Raises:
        ScenarioError: The file does not exist, or one of the twelve values is missing or not positive.
    """
    content = read_toml(path)
    table = validate_table(NoiseTable, content.get("noise", {}), directory=path.parent, origin=f"{path.name}: [noise]")
    if table.kind != "density":
        raise EstimationError(f"{path}: [noise] kind is '{table.kind}'; the field test's noises are densities.")
    readings = by_name(f"{path.name}: readings", table.readings, READINGS)
    process = by_name(f"{path.name}: process", table.process, PROCESSES)
    if not (process > 0.0).all():
        raise EstimationError(f"{path}: [noise.process] needs positive numbers; their logarithms are searched.")
    return Noise((*readings.tolist(), *process.tolist()))


def save_noise(noise: Noise, path: Path, *, title: str, command: str, results: dict[str, float]) -> Path:
    """Write noises with the command that found them and its results."""
    lines = [f"# {title}", f'command = "{command}"', "", "[noise]", 'kind = "density"', "", "[noise.readings]"]
    rows = zip((*READINGS, *PROCESSES), noise.values, UNITS, NAMES, strict=True)
    for name, value, unit, symbol in rows:
        if symbol == "Q_v":
            lines += ["", "[noise.process]"]
        lines.append(f'"{name}" = {value:.6e}  # {symbol}, {unit}')
    lines += ["", "[found]", *(f"{name} = {value:.6g}" for name, value in results.items()), ""]
    with replacing(path) as partial:
        partial.write_text("\n".join(lines), encoding="utf-8")
    return path


@cache
def specification() -> Specification:
    """Return the estimation of the field test, with its model, start and gate."""
    return load_specification(LIBRARY / "field.toml")


@dataclass(frozen=True, slots=True)
class FilterTask:
    """A braking as arrays, for many runs of the filter.

    Attributes:
        braking: Source of the arrays.
        data: Pressures and track force, speed and wheelset speeds, the start; k samples.
        truth: Of all 13 states at the end of each period, shape (k, 13), or None.
    """

    braking: Braking
    data: FilterData
    truth: Array | None


def prediction() -> PredictionInC:
    """Return the prediction of the field test; equations (1) to (5), (10) to (12) of the paper."""
    return prediction_for(specification())


def equations() -> CasadiPrediction:
    """Return the same prediction as equations, which threads may share."""
    return equations_for(specification())


def task_of(braking: Braking, model: PredictionInC) -> FilterTask:
    """Return a braking as arrays, from its first sample of coasting.

    Raises:
        EstimationError: A reading is missing.
    """
    recording, specified = braking.recording, specification()
    settings = settings_for(specified, period_of(recording))
    has_truth = all(knows(recording, state) for state in model.states)
    truth = np.column_stack([truth_of(recording, state) for state in model.states])[1:] if has_truth else None
    data = filter_data(recording, model, settings, units_of(specified.model.prediction.model))
    return FilterTask(braking=braking, data=data, truth=truth)


def filter_of(model: PredictionInC, period: float, noise: Noise = PHYSICAL) -> CompiledFilter:
    """Return a compiled filter for brakings of one period."""
    gate = settings_for(specification(), period).gate
    return CompiledFilter(model, noise.process, noise.readings, period, gate)


def follow(task: FilterTask, filter_: CompiledFilter, noise: Noise, start_scale: float = 1.0) -> FilterRecord:
    """Return the estimates over a braking with given noises.

    Args:
        filter_: Result of `filter_of`; no other thread may use it at the same time.
        start_scale: Factor on the covariance at the start.

    Raises:
        FilterDiverged: The filter diverged.
    """
    filter_.retune(noise.process, noise.readings)
    start = GaussianEstimate(mean=task.data.mean, covariance=start_scale * task.data.covariance)
    return filter_.follow(start, task.data.inputs, task.data.readings)


def divergence_time(task: FilterTask, estimate: FilterRecord) -> float | None:
    """Return the time from the first sample [s] at which the innovations indicate a lost filter, or None."""
    step = loss_step(estimate.squared_innovation, estimate.degrees)
    return None if step is None else (step + 1) * task.data.period
