"""An estimation as a TOML file: model, noises, start, gate and source of the recording.

extends = "rig_own"                         # optional: keys that are missing here come from that estimation
name = "rig-slide"

[model]
class = "RollerRigPrediction"
kind = "fmu"                                # or "compiled": its equations in the filter, the same to rounding
parameters = { load = "98.1 kN" }           # the others keep their defaults; SI or with a unit
outputs = ["wheelset_speed", "speed"]       # compared with readings; all unless given

[noise]                                     # or { file = "tuned.toml" }, whose [noise] is taken
kind = "density"                            # or "per_step": covariance added in one step of a discrete filter
process = { w = 1e-4, v = 1e-6, mu_b = 2.5e-5, alpha = 1e-2 }
readings = { wheelset_speed = 1e-6, speed = 1e-8 }     # variances

[start]
mean = { mu_b = 0.35, alpha = 0.0 }         # states that are read directly may be left out
deviation = { w = 0.3, v = 0.1, mu_b = 0.04, alpha = 0.02 }

[gate]                                      # optional: hold states constant while inputs are small
states = ["mu_b"]
inputs = ["pad_force"]
threshold = "1.5 kN"

[course]                                    # optional: compute the track force from the run itself, see `sources`
mass = "84 t"
curve_law = "bogie"

[inputs]                                    # optional: constant inputs in place of recorded ones
track_force = "0 N"

[source]                                    # optional: a scenario whose stop is the recording
scenario = "rig_slide"
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import xarray
from pydantic import Field, PrivateAttr, model_validator

from railgrip.base.errors import EstimationError
from railgrip.base.names import did_you_mean
from railgrip.estimation.run import Kind, Settings, equations_of, estimate, model_of, prediction_of, units_of
from railgrip.estimation.several import estimate_several
from railgrip.estimators.design import Gate
from railgrip.estimators.prediction import CasadiPrediction, PredictionInC
from railgrip.recording.samples import period_of
from railgrip.recording.table import DataTable
from railgrip.scenario.file import locate
from railgrip.scenario.load import Tables, read_toml, require_kind, require_straight, validate_table
from railgrip.scenario.merge import nest, read_overrides
from railgrip.scenario.quantity import Magnitude, NotNegative, Number, UnitRange, in_units
from railgrip.scenario.table import Duration, Length, Mass, Name, Parameters, Seed, Table, table_error
from railgrip.scenario.track.table import CurveLaw

Positive = Annotated[Number, Field(gt=0.0)]


class LowPass(Table):
    """Low-pass of a course over distance."""

    plan: Length = Field(description="cut-off wavelength of north and east")
    height: Length = Field(description="of the height")
    base: Length = Field(description="Δs of the differences")


class SensorDeviations(Table):
    """Standard deviations of the sensors of motion."""

    speed: Annotated[float, UnitRange("m/s", above=0)] = Field(description="of the speed sensor")
    scale: Annotated[float, UnitRange("1", above=0)] = Field(description="of its scale")
    acceleration: Annotated[float, UnitRange("m/s**2", above=0)] = Field(
        description="of the mean of the accelerometers"
    )
    bias: Annotated[float, UnitRange("m/s**2", above=0)] = Field(description="of their bias and gradient at the start")
    drift: Positive = Field(description="of these, per √s [m/s2/√s]")
    jerk: Positive = Field(description="change of acceleration, per √s [m/s2/√s]")
    position: Annotated[float, UnitRange("m", above=0)] = Field(description="of GNSS along the track")


LOW_PASS = LowPass(plan=100.0, height=150.0, base=10.0)
"""For a train at 5 to 30 m/s with a carrier-phase receiver at 10 Hz: transition curves and roundings are 50 to 100 m
long, shorter waves are noise of the receiver.

The values are estimates, not fitted to any case.
"""

SENSOR_DEVIATIONS = SensorDeviations(
    speed=0.03, scale=2e-3, acceleration=0.05, bias=0.15, drift=0.02, jerk=0.7, position=0.3
)
"""Class of the sensors (optical 0.1 %, four accelerometers, receiver wandering by 0.2 m); `drift` is a gradient that
changes by 5 ‰ in 5 s, `jerk` a brake applied within a second."""


class ModelTable(Table):
    """The prediction model, and its parameters that differ from the defaults."""

    class_: str = Field(
        alias="class",
        pattern=r"^[A-Za-z][A-Za-z0-9_.]*$",
        description="Modelica class of the prediction, of those of `railgrip build --list`",
    )
    kind: Kind = Field(
        default="fmu", description="the class as an FMU, stepped through FMI 2.0, or its equations in the filter's C"
    )
    parameters: Parameters = Field(default={}, description="of the class; the others keep their defaults")
    outputs: list[str] | None = Field(default=None, description="outputs compared with readings; all unless given")


class NoiseTable(Table):
    """Variances by name, of processes and readings."""

    kind: Literal["density", "per_step"] = Field(
        description="process noise per second, or the covariance added in one step of a discrete filter"
    )
    process: dict[str, NotNegative] = Field(description="variance of each state, or of all elements of an array")
    readings: dict[str, Positive] = Field(description="variance of each output that is read")


class StartTable(Table):
    """The estimate at the first sample."""

    mean: dict[str, Number] = Field(
        default_factory=dict, description="of each state; a state that is read may be left out"
    )
    deviation: dict[str, Positive] = Field(description="standard deviation of each state")


class GateTable(Table):
    """States held constant while their inputs are below a threshold."""

    states: list[str] = Field(description="states that are held")
    inputs: list[str] = Field(description="inputs that decide it, one for each state")
    threshold: Magnitude = Field(description="below it, in the unit of the inputs, the state is held")


class ObservabilityTable(Table):
    """Typical sizes of the states, and the windows of readings that must determine them."""

    scale: dict[str, Positive] = Field(description="typical size of each state")
    window: Duration = Field(description="length of a window")
    stride: Duration = Field(description="from the start of a window to that of the next")


class CourseTable(Table):
    """The track force of a train from GNSS, speed and accelerometers; the filter runs from coasting on."""

    mass: Mass = Field(description="of the train")
    curve_law: CurveLaw = Field(description="formula of the resistance in curves")
    low_pass: LowPass = LOW_PASS
    trust: SensorDeviations = SENSOR_DEVIATIONS


class SourceTable(Table):
    """A scenario whose stop is the recording; the seed defaults to the scenario's."""

    scenario: str = Field(description="name in the library or path of the scenario")
    seed: Seed | None = Field(default=None, description="of the stop, in place of the scenario's")
    noise: dict[str, Magnitude] = Field(
        default={}, description="signals of the plant that are read, with the standard deviation of each reading"
    )


class Specification(Table):
    """All inputs of an estimation."""

    name: Name = Field(description="of the estimation, and of the folder of its results")
    description: str = Field(default="", description="in a sentence")
    model: ModelTable
    noise: NoiseTable
    start: StartTable
    gate: GateTable | None = None
    outlier_limit: Positive | None = Field(
        default=None, description="readings further from their prediction, in standard deviations, are not used"
    )
    between: Literal["held", "mean"] = Field(
        default="held", description="inputs between two samples: those of the earlier one, or the mean of both"
    )
    observability: ObservabilityTable | None = None
    course: CourseTable | None = None
    inputs: dict[str, Magnitude] = Field(
        default_factory=dict, description="constant inputs of the class in place of recorded ones"
    )
    source: SourceTable | None = None
    data: DataTable | None = None
    _origins: dict[str, str] = PrivateAttr(default_factory=dict)

    @property
    def origins(self) -> dict[str, str]:
        """Origin of each entry in [model.parameters], as `given in run.toml` or `--set`, by name."""
        return self._origins

    @model_validator(mode="after")
    def _has_one_track_force(self) -> Self:
        if self.course is not None and self.data is not None and "track_force" in self.data.columns:
            raise table_error("has track_force in [data.columns] and [course], which computes it; remove one of them")
        return self

    def source_scenario(self) -> SourceTable:
        """Return the scenario from which the recording is simulated.

        Raises:
            EstimationError: The recording is not simulated.
        """
        if self.source is None:
            raise EstimationError(f"{self.name}: has no [source]; name the trace or file to read with --data FILE.")
        return self.source


LIBRARY = Path(__file__).parent / "library"

DEFAULT = "library default"
"""Origin of a parameter that neither a file nor an option sets."""


def load_specification(path: Path, overrides: Sequence[str] | Mapping[str, Any] = ()) -> Specification:
    """Return the estimation of a TOML file, or of the library by its name, with overrides applied last.

    Args:
        path: Path or name of the file.
        overrides: Strings such as "start.speed=100 km/h", or values by key.

    Raises:
        ScenarioError: The file is missing, not TOML, or not an estimation; one sentence per problem.
    """
    path = locate(path, "estimations")
    tables = _tables_in(path, ())
    files = [(f"given in {name}", table) for name, table in tables.layers]
    tables = tables.overlay(path.name, nest(overrides) if isinstance(overrides, Mapping) else read_overrides(overrides))
    specification = validate_table(
        Specification, tables.table, directory=path.parent, origin=path.name, layers=tables.layers
    )
    # The uppermost layer takes precedence, so it is written last.
    for origin, table in reversed([("--set", tables.layers[0][1]), *files]):
        model = table.get("model")
        given = model.get("parameters") if isinstance(model, Mapping) else None
        specification.origins.update(dict.fromkeys(given, origin) if isinstance(given, Mapping) else {})
    return specification


def _tables_in(path: Path, chain: Sequence[Path]) -> Tables:
    table = read_toml(path)
    require_kind(table, "estimation", path)
    noise = table.get("noise")
    if isinstance(noise, dict) and "file" in noise:
        table = table | {"noise": _noise_elsewhere(path, noise)}
    tables = Tables.of({key: value for key, value in table.items() if key != "extends"}, path.parent, path.name)
    if "extends" not in table:
        return tables
    base = locate(str(table["extends"]), "estimations", path.parent, f"{path.name}: extends: ")
    require_straight(base, (*chain, path), path.name)
    below = _tables_in(base, (*chain, path))
    # A map of columns applies to one recording only.
    inherited = {
        key: value for key, value in below.table.items() if key not in ("data" if "data" in table else "", "name")
    }
    return replace(below, table={"name": path.stem} | inherited).overlay(path.name, tables.table)


def _noise_elsewhere(path: Path, noise: dict[str, Any]) -> object:
    if set(noise) != {"file"} or not isinstance(noise["file"], str):
        raise EstimationError(f"{path.name}: [noise] file replaces the whole table; remove the other keys.")
    other = path.parent / noise["file"]
    table = read_toml(other)
    if "noise" not in table:
        raise EstimationError(f"{other}: has no [noise], which {path.name} takes from there.")
    return table["noise"]


def prediction_for(specification: Specification) -> PredictionInC:
    """Return the prediction of an estimation, its parameters converted to the units of the model.

    Raises:
        ScenarioError: A parameter does not exist, or its unit has another dimension.
    """
    model = specification.model
    return prediction_of(model.class_, parameters_for(specification), model.outputs, model.kind)


def equations_for(specification: Specification) -> CasadiPrediction:
    """Return the prediction as equations, which can be differentiated further and shared by threads.

    Errors are those of `prediction_for`.
    """
    model = specification.model
    return equations_of(model.class_, parameters_for(specification), model.outputs)


def parameters_for(specification: Specification) -> dict[str, float]:
    """Return [model.parameters] of an estimation in the units of the model.

    Raises:
        EstimationError: A parameter does not exist, or its unit has another dimension.
    """
    model = specification.model
    variables = model_of(model.class_).parameters
    units = {variable.name: variable.unit for variable in variables}
    descriptions = {variable.name: variable.description for variable in variables}
    return in_units(f"{specification.name}: [model.parameters]", model.parameters, units, descriptions)


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelParameter:
    """A parameter of the model with the value that the filter uses.

    Attributes:
        name: Name in the model, for an element of an array as `J[1]`.
        value: Value in `unit`.
        unit: Unit in Modelica's notation; "1" for a ratio.
        origin: `given in FILE` or `--set`, else `DEFAULT`.
        description: Description in the model.
    """

    name: str
    value: float
    unit: str
    origin: str
    description: str

    @property
    def is_default(self) -> bool:
        """Whether it is an unchanged default of the library."""
        return self.origin == DEFAULT


def model_parameters(specification: Specification) -> list[ModelParameter]:
    """Return all parameters of the model that affect the estimates; start values come from [start].

    Raises:
        EstimationError: As for `parameters_for`.
    """
    values = parameters_for(specification)
    return [
        ModelParameter(
            name=variable.name,
            value=values.get(variable.name, variable.start),
            unit=variable.unit or "1",
            origin=specification.origins.get(variable.name, "given") if variable.name in values else DEFAULT,
            description=variable.description,
        )
        for variable in model_of(specification.model.class_).parameters
        if not variable.name.partition("[")[0].endswith("start") and not variable.name.startswith("start")
    ]


def settings_for(specification: Specification, period: float) -> Settings:
    """Return the settings of an estimation on a grid of `period` [s].

    Raises:
        ScenarioError: The threshold of the gate has another dimension than its inputs.
    """
    noise, gate = specification.noise, specification.gate
    # Published noises per step depend on the period: half the period means twice the noise per second.
    step = period if noise.kind == "per_step" else 1.0
    return Settings(
        process={name: variance / step for name, variance in noise.process.items()},
        readings=dict(noise.readings),
        start=dict(specification.start.mean),
        start_deviation=dict(specification.start.deviation),
        gate=None if gate is None else _gate(specification, gate),
        outlier_limit=specification.outlier_limit,
        between=specification.between,
    )


def estimate_of(specification: Specification, recording: xarray.Dataset, filters: Sequence[str] = ()) -> xarray.Dataset:
    """Return the estimates of an estimation's filter at every sample of a recording; see `run.estimate`.

    With names of kinds in `filters`, those of several filters; see `several.estimate_several`. The attribute
    `parameters` is JSON: name, value, unit and origin of each parameter of the model.

    Raises:
        EstimationError: The recording does not fit the model.
    """
    parameters = [
        {"name": each.name, "value": each.value, "unit": each.unit, "origin": each.origin}
        for each in model_parameters(specification)
    ]
    prediction, settings = prediction_for(specification), settings_for(specification, period_of(recording))
    units = units_of(specification.model.class_)
    if filters:
        estimates = estimate_several(recording, prediction, settings, filters, units=units)
    else:
        estimates = estimate(recording, prediction, settings, units=units)
    return estimates.assign_attrs(estimation=specification.name, parameters=json.dumps(parameters))


def _gate(specification: Specification, gate: GateTable) -> Gate:
    units = {variable.name: variable.unit for variable in model_of(specification.model.class_).inputs}
    first = gate.inputs[0] if gate.inputs else ""
    where = f"{specification.name}: [gate]"
    if first not in units:
        raise EstimationError(
            f"{where} inputs: the model has no input '{first}'; it has {', '.join(units)}"
            + did_you_mean(first, units, before="; ")
        )
    threshold = in_units(where, {"threshold": gate.threshold}, {"threshold": units[first]})["threshold"]
    return Gate(states=tuple(gate.states), inputs=tuple(gate.inputs), threshold=threshold)
