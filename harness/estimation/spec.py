"""An estimation as a TOML file: model, noises, start, gate and source of the recording.

extends = "rig_own"                         # optional: keys that are missing here come from that estimation
name = "rig-slide"

[model]
class = "RollerRigPrediction"               # or train = "emu387", a train file; or class and library, your own Modelica
kind = "fmu"                                # or "compiled": its equations in the filter, the same to rounding
parameters = { load = "98.1 kN" }           # the others keep their defaults; SI or with a unit
outputs = ["wheelset_speed", "speed"]       # compared with readings; all unless given

[noise]                                     # or { file = "tuned.toml" }, whose [noise] is taken
kind = "density"                            # or "per_step": covariance added in one step of a discrete filter
process = { speed = 1e-6, wheelset_speed = 1e-4, pad_friction = 2.5e-5, group_adhesion = 1e-2 }
readings = { wheelset_speed = 1e-6, speed = 1e-8 }     # variances

[start]
mean = { pad_friction = 0.35, group_adhesion = 0.0 }   # states that are read directly may be left out
deviation = { speed = 0.1, wheelset_speed = 0.3, pad_friction = 0.04, group_adhesion = 0.02 }

[gate]                                      # optional: hold states constant while inputs are small
states = ["pad_friction"]
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
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal, cast

import xarray
from pydantic import Field, PrivateAttr, StrictBool

from railgrip.base.errors import EstimationError
from railgrip.base.names import ElementName, known_names, state_name
from railgrip.base.tables import TomlTable
from railgrip.estimation.judgement import check_estimates, check_signals
from railgrip.estimation.models import DEFAULT, READ_STATES, Kind, PredictionModel, of_class, of_train, units_of
from railgrip.estimation.run import Settings, estimate, estimate_several
from railgrip.estimators.design import Gate
from railgrip.estimators.prediction import CasadiPrediction, PredictionInC
from railgrip.recording.samples import period_of
from railgrip.recording.table import DataTable
from railgrip.scenario.file import NamedFile, OtherFileString, locate, nest, read_overrides
from railgrip.scenario.load import Tables, read_toml, require_kind, require_straight, validate_table
from railgrip.scenario.quantity import Magnitude, NotNegative, Number, UnitRange, in_units
from railgrip.scenario.table import Duration, Length, Mass, Name, Parameters, Seed, Table, optional, table_error
from railgrip.scenario.track import CurveLaw
from railgrip.scenario.vehicle_table import TrainName
from railgrip.simulate.train_prediction import CENTRAL

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

    class_: str | None = Field(
        default=None,
        alias="class",
        pattern=r"^[A-Za-z][A-Za-z0-9_.]*$",
        description="Modelica class of the prediction, of those of `railgrip build --list`; with a train "
        + " or ".join(CENTRAL),
    )
    library: NamedFile | None = Field(
        default=None, description="for a user-defined class: the package.mo of its library, or its .mo file"
    )
    train: TrainName = Field(
        default=None, description="a train of this project, such as emu387, or the path of a train file"
    )
    kind: Kind = Field(
        default="fmu", description="the class as an FMU, stepped through FMI 2.0, or its equations in the filter's C"
    )
    parameters: Parameters = Field(default={}, description="of the class; the others keep their defaults")
    outputs: list[str] | None = Field(default=None, description="outputs compared with readings; all unless given")

    def _check(self) -> None:
        if self.class_ is None and self.train is None:
            raise table_error("names no model: give class = '…', or train = '…'")
        if self.train is not None and (self.library is not None or self.class_ not in (None, *CENTRAL)):
            raise table_error(
                f"has a train and the class {self.class_}, which is not for all trains; leave out class and library, "
                f"or name {' or '.join(CENTRAL)}"
            )

    @property
    def prediction(self) -> PredictionModel:
        """The prediction model, from a train file, a user's library or the library of this project.

        Raises:
            EstimationError: The class does not exist.
            ScenarioError: The file is not a train.
        """
        if self.train is not None:
            return of_train(self.train, self.class_ or CENTRAL[0])
        assert self.class_ is not None  # `_check` rejects a table without both
        return of_class(self.class_, self.library)


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
    steady: StrictBool = Field(
        default=False,
        description="whether a recording that begins inside a braking starts from the adhesion and deflections of a "
        "steady braking; otherwise from those of released brakes",
    )


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
    wheelset_position: tuple[Length, ...] = optional(
        "distance of each wheelset behind the place that GNSS reads, which the whole train is at without it",
        default=(),
    )
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
    _older_names: list[str] = PrivateAttr(default_factory=list)

    @property
    def older_names(self) -> list[str]:
        """A sentence for each table of a file or option that has symbols of equations for names of states."""
        return self._older_names

    @property
    def origins(self) -> dict[str, str]:
        """Origin of each entry, as `given in run.toml` or `--set`, by its key, such as `noise.process.speed`."""
        return self._origins

    def _check(self) -> None:
        if self.course is not None and self.data is not None and "track_force" in self.data.columns:
            raise table_error("has track_force in [data.columns] and [course], which computes it; remove one of them")

    def source_scenario(self) -> SourceTable:
        """Return the scenario from which the recording is simulated.

        Raises:
            EstimationError: The recording is not simulated.
        """
        if self.source is None:
            raise EstimationError(f"{self.name}: has no [source]; name the trace or file to read with --data FILE.")
        return self.source


LIBRARY = Path(__file__).parent / "library"


def load_specification(path: Path, overrides: Sequence[str] | Mapping[str, Any] = ()) -> Specification:
    """Return the estimation of a TOML file, or of the library by its name, with overrides applied last.

    Args:
        path: Path or name of the file.
        overrides: Strings such as "start.speed=100 km/h", or values by key.

    Raises:
        ScenarioError: The file is missing, not TOML, or not an estimation; one sentence per problem.
    """
    path, files, older = locate(path, "estimations"), list[Path](), list[str]()
    tables = _tables_in(path, files, older)
    own = [DEFAULT if file.parent == LIBRARY else f"given in {file.name}" for file in files]
    changes = (
        OtherFileString.within(nest(overrides), Path.cwd())
        if isinstance(overrides, Mapping)
        else read_overrides(overrides)
    )
    tables = tables.overlay(path.name, _with_state_names(changes, "--set", older))
    specification = validate_table(
        Specification, tables.table, directory=path.parent, origin=path.name, layers=tables.layers
    )
    # The uppermost layer takes precedence, so it is written last.
    for origin, (_, table) in reversed(list(zip(("--set", *own), tables.layers, strict=True))):
        specification.origins.update(dict.fromkeys(_keys(table), origin))
    specification.older_names.extend(older)
    return specification


def _with_state_names(tables: Mapping[str, Any], origin: str, older: list[str]) -> TomlTable:
    """Return the tables of a file or of options with names of states in place of symbols such as `mu_b`.

    Sentences on symbols are added to `older`.

    Raises:
        EstimationError: A table has a state by its name and by its symbol.
    """
    result = dict(tables)
    for table, key in (
        ("noise", "process"), ("start", "mean"), ("start", "deviation"), ("gate", "states"), ("observability", "scale"),
    ):  # fmt: skip
        values = result[table].get(key) if isinstance(result.get(table), Mapping) else None
        if not isinstance(values, Mapping | list) or not all(isinstance(name, str) for name in values):
            continue
        old = [name for name in values if state_name(name) != name]
        if twice := [name for name in old if state_name(name) in values]:
            raise EstimationError(
                f"{origin}: [{table}] {key} has {twice[0]} and {state_name(twice[0])}, which are the same state; keep "
                "the latter"
            )
        if old:
            names = ", ".join(f"{state_name(name)} ({name})" for name in old)
            older.append(f"{origin}: [{table}] {key} has symbols of equations; the states are now called {names}")
            renamed: Any = list(map(state_name, values))
            if isinstance(values, Mapping):
                renamed = dict(zip(renamed, values.values(), strict=True))
            result[table] = {**result[table], key: renamed}
    return result


def _keys(table: Mapping[str, Any], within: str = "") -> Iterator[str]:
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _keys(cast("Mapping[str, Any]", value), f"{within}{key}.")
        else:
            yield f"{within}{key}"


def _tables_in(path: Path, chain: list[Path], older: list[str]) -> Tables:
    """Return the tables of a file, which is added to the chain of files that extend each other."""
    table = read_toml(path)
    chain.append(path)
    require_kind(table, "estimation", path)
    noise = table.get("noise")
    if isinstance(noise, dict) and "file" in noise:
        table = table | {"noise": _noise_elsewhere(path, noise)}
    table = _with_state_names(table, path.name, older)
    tables = Tables.of({key: value for key, value in table.items() if key != "extends"}, path.parent, path.name)
    if "extends" not in table:
        return tables
    base = locate(str(table["extends"]), "estimations", path.parent, f"{path.name}: extends: ")
    require_straight(base, chain, path.name)
    below = _tables_in(base, chain, older)
    # A map of columns applies to one recording only.
    inherited = {
        key: value
        for key, value in OtherFileString.within(below.table, below.directory).items()
        if key not in ("data" if "data" in table else "", "name")
    }
    return replace(below, table={"name": path.stem} | inherited).overlay(path.name, tables.table)


def _noise_elsewhere(path: Path, noise: TomlTable) -> object:
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
    return model.prediction.prediction(parameters_for(specification), model.outputs, model.kind)


def equations_for(specification: Specification) -> CasadiPrediction:
    """Return the prediction as equations, which can be differentiated further and shared by threads.

    Errors are those of `prediction_for`.
    """
    model = specification.model
    return model.prediction.equations(parameters_for(specification), model.outputs)


def parameters_for(specification: Specification) -> dict[str, float]:
    """Return [model.parameters] of an estimation in the units of the model.

    Raises:
        EstimationError: A parameter does not exist, or its unit has another dimension.
    """
    model = specification.model.prediction
    descriptions = {variable.name: variable.description for variable in model.parameters}
    where = f"{specification.name}: [model.parameters]"
    return in_units(where, specification.model.parameters, model.units, descriptions)


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelParameter:
    """A parameter of the model or a setting of the filter, with the value that was used.

    Attributes:
        name: Name in the model, for an element of an array as `J[1]`; of a setting its key in the file.
        value: Value in `unit`.
        unit: Unit in Modelica's notation; "1" for a ratio.
        origin: `train file NAME`, `given in FILE`, `--set` or `recording`, else `DEFAULT`.
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
    model, given = specification.model.prediction, parameters_for(specification)
    values = model.values(given)

    has_default_train = specification.origins.get("model.train", DEFAULT) == DEFAULT

    def origin(name: str) -> str:
        base = ElementName.of(name).array
        if name not in given and base not in given:
            return DEFAULT if has_default_train else model.origins.get(name, DEFAULT)
        return _origin(specification, "model.parameters", name) or "given"

    return [
        ModelParameter(
            name=variable.name,
            value=values[variable.name],
            unit=variable.unit or "1",
            origin=origin(variable.name),
            description=variable.description,
        )
        for variable in model.parameters
        if not ElementName.of(variable.name).array.endswith("start") and not variable.name.startswith("start")
    ]


def _origin(specification: Specification, table: str, name: str) -> str:
    """Return the origin of an entry under its name or that without index; empty if no file or option has it."""
    origins = specification.origins
    return origins.get(f"{table}.{name}") or origins.get(f"{table}.{name.partition('[')[0]}", "")


def settings_with_origins(specification: Specification, estimates: xarray.Dataset) -> list[ModelParameter]:
    """Return noises, start, gate, outlier limit and constant inputs that estimates result from.

    The mean at the start is that of the estimates: states that are read start with the recording.
    """
    model, settings = specification.model.prediction, settings_for(specification, estimates.attrs["period"])
    units = units_of(model.model)
    of_parameters = {parameter.name: parameter.origin for parameter in model_parameters(specification)}
    rows: list[ModelParameter] = []

    def add(table: str, name: str, value: float, unit: str, origin: str = "") -> None:
        key = f"{table}.{name}" if table else name
        origin = origin or _origin(specification, table, name) if table else specification.origins.get(name, DEFAULT)
        rows.append(ModelParameter(name=key, value=value, unit=unit, origin=origin or DEFAULT, description=""))

    def unit(name: str) -> str:
        return units.get(name, units.get(f"{name}[1]", "")) or "1"

    for name, value in settings.process.items():
        add("noise.process", name, value, f"({unit(name)})2/s")
    for name, value in settings.readings.items():
        add("noise.readings", name, value, f"({unit(name)})2")
    for name, value in settings.start_deviation.items():
        add("start.deviation", name, value, unit(name))
    first = estimates["mean"].isel(time=0)
    first = first.isel(filter=0) if "filter" in first.dims else first
    for state, value in zip(map(str, first["state"].values), first.values.tolist(), strict=True):
        given = _origin(specification, "start.mean", state)
        of_train = (
            of_parameters.get(state.replace("pad_friction[", "mu_b_nominal["), DEFAULT) if model.start({}) else ""
        )
        is_read = ElementName.of(state).array in READ_STATES
        add("start.mean", state, value, unit(state), given or ("recording" if is_read else of_train))
    for name, constant in specification.inputs.items():
        add("inputs", name, constant.si(units[name]), unit(name))
    if settings.gate is not None:
        add("gate", "threshold", settings.gate.threshold, unit(settings.gate.inputs[0]))
    if settings.outlier_limit is not None:
        add("", "outlier_limit", settings.outlier_limit, "1")
    return rows


def settings_for(specification: Specification, period: float) -> Settings:
    """Return the settings of an estimation on a grid of `period` [s].

    Raises:
        ScenarioError: The threshold of the gate has another dimension than its inputs.
    """
    noise, gate, model = specification.noise, specification.gate, specification.model.prediction
    bases = {ElementName.of(variable.name).array for variable in (*model.model.states, *model.model.outputs)}
    absent = model.optional - bases

    def present(values: Mapping[str, float]) -> dict[str, float]:
        return {name: value for name, value in values.items() if ElementName.of(name).array not in absent}

    # Published noises per step depend on the period: half the period means twice the noise per second.
    step = period if noise.kind == "per_step" else 1.0
    mean = present(specification.start.mean)
    of_train = model.start(parameters_for(specification))
    return Settings(
        process={name: variance / step for name, variance in present(noise.process).items()},
        readings=present(noise.readings),
        start={name: value for name, value in of_train.items() if ElementName.of(name).array not in mean} | mean,
        start_deviation=present(specification.start.deviation),
        gate=None if gate is None else _gate(specification, gate),
        steady=specification.start.steady,
        outlier_limit=specification.outlier_limit,
        between=specification.between,
    )


def estimate_of(specification: Specification, recording: xarray.Dataset, filters: Sequence[str] = ()) -> xarray.Dataset:
    """Return the estimates of an estimation's filter at every sample of a recording; see `run.estimate`.

    With names of kinds in `filters`, those of several filters; see `run.estimate_several`. The attributes
    `parameters` and `settings` are JSON: name, value, unit and origin of each parameter of the model, and of noises,
    start, gate and constant inputs. `problems` has a line for each reason for which the estimates are not to be used:
    signals or estimates that no vehicle has, and a filter that is lost. It is empty for valid estimates.

    Raises:
        EstimationError: The recording does not fit the model.
    """
    prediction, settings = prediction_for(specification), settings_for(specification, period_of(recording))
    units = units_of(specification.model.prediction.model)
    if filters:
        estimates = estimate_several(recording, prediction, settings, filters, units=units)
    else:
        estimates = estimate(recording, prediction, settings, units=units)
    lists = {
        "parameters": model_parameters(specification),
        "settings": settings_with_origins(specification, estimates),
    }
    texts = {
        key: json.dumps([{name: getattr(each, name) for name in ("name", "value", "unit", "origin")} for each in rows])
        for key, rows in lists.items()
    }
    warnings = [*str(estimates.attrs.get("warnings", "")).splitlines(), *specification.model.prediction.limits]
    warnings += specification.older_names
    problems = check_signals(recording, (*prediction.inputs, *prediction.outputs))
    for kind in filters or ("",):
        of_one = estimates.sel(filter=kind) if kind else estimates
        ended = str(of_one["ended"].item()) if kind else str(estimates.attrs["ended"])
        sentences = [*check_estimates(of_one), *([ended] if ended else [])]
        problems += [f"{kind}: {sentence}" if kind else sentence for sentence in sentences]
    return estimates.assign_attrs(
        estimation=specification.name, warnings="\n".join(warnings), problems="\n".join(problems), **texts
    )


def _gate(specification: Specification, gate: GateTable) -> Gate:
    """Return the gate of a filter; a name without index selects all elements, a force means the pressure that causes
    it in the cylinders.
    """
    model, where = specification.model.prediction, f"{specification.name}: [gate]"
    units = {variable.name: variable.unit for variable in model.model.inputs}
    states, inputs = (
        tuple(each for name in names for each in elements_of(name, [variable.name for variable in known]))
        for names, known in ((gate.states, model.model.states), (gate.inputs, model.model.inputs))
    )
    first = inputs[0] if inputs else ""
    if first not in units:
        raise EstimationError(f"{where} inputs: the model has no input '{first}'; it has {known_names(units, first)}")
    if units[first] == "Pa" and gate.threshold.has_dimension_of("N"):
        threshold = model.release_pressure(parameters_for(specification), gate.threshold.si("N"))
    else:
        threshold = in_units(where, {"threshold": gate.threshold}, {"threshold": units[first]})["threshold"]
    return Gate(states=states, inputs=inputs, threshold=threshold)


def elements_of(name: str, known: Sequence[str]) -> Sequence[str]:
    """Return the elements of an array in `known`; the name itself if it has an index or is unknown."""
    return [each for each in known if ElementName.of(each).array == name] or [name]
