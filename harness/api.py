"""The public interface of `import railgrip`; see docs/api.md."""

import copy
import warnings
from collections.abc import Callable, Collection, Iterable, Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

from pydantic import PrivateAttr

from railgrip.base.errors import (
    ControllerFailed,
    EstimateWarning,
    EstimationError,
    EstimatorFailed,
    FilterDiverged,
    FmuError,
    InputError,
    PlantFailed,
    RailgripError,
    ScenarioError,
    SensorsFailed,
)
from railgrip.base.files import path_of
from railgrip.base.tables import TomlTable
from railgrip.base.units import cut, place, short
from railgrip.controllers.observation import Observation
from railgrip.scenario import schema
from railgrip.scenario.file import is_folder, nest, parts_of, with_another_plant
from railgrip.scenario.load import Tables, extend_tables, read_scenario
from railgrip.scenario.onboard import TrainLevelTable
from railgrip.scenario.outcome import Outcome
from railgrip.simulate.user_parts import Controller, Estimate, Estimator, Plant, Sensors, call_user_code
from railgrip.vehicle.formation import Formation

if TYPE_CHECKING:
    # CasADi and the FMU loader take a second to import, which reading scenarios does not need.
    import pandas
    import xarray

    from railgrip.campaign.evaluate import Rows
    from railgrip.campaign.sweep import Sweep
    from railgrip.estimation.inspection import Inspection
    from railgrip.report.comparison import Comparison
    from railgrip.report.estimates import Estimates
    from railgrip.report.stop import Stop
    from railgrip.report.table import Form, ReportTable
    from railgrip.simulate.run import Bench
    from railgrip.simulate.user_parts import CustomParts
    from railgrip.supervision.results import BrakingCurves


__all__ = [
    "Controller",
    "ControllerFailed",
    "Estimate",
    "EstimateWarning",
    "EstimationError",
    "Estimator",
    "EstimatorFailed",
    "FilterDiverged",
    "FmuError",
    "Formation",
    "InputError",
    "Observation",
    "Outcome",
    "Plant",
    "PlantFailed",
    "RailgripError",
    "Scenario",
    "ScenarioError",
    "Sensors",
    "SensorsFailed",
    "Stop",
    "compare",
    "estimate",
    "etcs",
    "evaluate",
    "inspect",
    "learn_friction",
    "load",
    "open",
    "run",
    "sweep",
    "table",
]


def __getattr__(name: str) -> Any:
    """Import a name on first use if its module loads xarray and CasADi."""
    if name == "Stop":
        return import_module("railgrip.report.stop").Stop
    raise AttributeError(f"module 'railgrip.api' has no attribute '{name}'")


class Scenario(schema.Scenario):
    """All inputs of a stop."""

    _directory: Path = PrivateAttr(default_factory=Path.cwd)

    @classmethod
    def load(cls, source: str | Path | Mapping[str, Any], changes: Mapping[str, Any] | None = None) -> Self:
        """Return a scenario by its name, such as "trapezoid", from a TOML file, or from its tables.

        Args:
            source: Name, path, or tables; files named in tables are relative to the current folder.
            changes: Key → value that overrides the scenario's, such as {"start.speed": "100 km/h"}.

        Raises:
            ScenarioError: The file is missing or not a scenario; the message has a sentence for each problem, with its
                key.

        Example:
            >>> Scenario.load("trapezoid", {"start.speed": "100 km/h", "controller.kind": "adhesion_based"})
        """
        if isinstance(source, Mapping):
            table = _plain(source, "scenario")
            origin = cut(table["name"]) if isinstance(table.get("name"), str) else "the scenario"
            tables = extend_tables(table, Path.cwd(), origin)
        else:
            tables = read_scenario(path_of(source, "scenario"))
        return cls._of(tables.overlay(tables.origin, nest(_changes(changes))))

    def changed(self, changes: Mapping[str, Any]) -> Self:
        """Return the scenario with other values: key → value, as for `load`."""
        return self.revised(nest(_changes(changes)))

    def replaced(self, tables: Mapping[str, Any]) -> Self:
        """Return the scenario with whole tables in place of its own, of which no key remains.

        Raises:
            ScenarioError: A key is invalid; the message has a sentence for each problem.
        """
        return self._of(Tables.of(self.tables() | _changes(tables), self._directory, self.name))

    def with_plant(self, plant: str | Path | Mapping[str, Any]) -> Self:
        """Return the scenario with another plant.

        Args:
            plant: Name of a recipe, path of an .fmu, or keys of [vehicle]. Paths are relative to the current folder.

        Raises:
            ScenarioError: The plant does not exist, or a key is invalid.
        """
        keys = _plain(plant, "plant") if isinstance(plant, Mapping) else {"plant": str(path_of(plant, "plant"))}
        for key, value in keys.items():
            if isinstance(value, str) and (key == "library" or (key == "plant" and value.endswith(".fmu"))):
                keys[key] = str(Path.cwd() / value)
        table = self.tables()
        table["vehicle"] = with_another_plant(table["vehicle"], keys)
        return self._of(Tables.of(table, self._directory, self.name))

    @classmethod
    def _of(cls, tables: Tables) -> Self:
        scenario = tables.value(cls)
        scenario._directory = tables.directory
        return scenario


_WRITTEN = (str, Path, Mapping)
"""Types of plants that a scenario can name."""

ScenarioLike = schema.Scenario | str | Path | Mapping[str, Any]
"""A scenario, or a valid argument of `Scenario.load`."""


def run(
    scenario: ScenarioLike,
    controller: "Controller | type[Controller] | str | Mapping[str, Any] | None" = None,
    estimator: "Estimator | type[Estimator] | str | Mapping[str, Any] | None" = None,
    sensors: "Sensors | type[Sensors] | str | Mapping[str, Any] | None" = None,
    plant: "Plant | type[Plant] | str | Path | Mapping[str, Any] | None" = None,
    *,
    import_from: Iterable[str | Path] = (),
) -> "Stop":
    """Run a scenario and return its stop: `.outcome`, `.metrics`, `.trace` (xarray), `.to_pandas()`, `.write(folder)`.

    A stop that ends badly, for example without standstill, is a result: see `.outcome`.

    Args:
        scenario: Scenario to run.
        controller: Replaces the scenario's: a name such as "slip_two_state", keys of [controller], or an object or
            class with the methods of `Controller`.
        estimator: Replaces the scenario's: a name, keys of [estimator], or an object or class with the methods of
            `Estimator`.
        sensors: Replaces the scenario's: a name, keys of [sensors], or an object or class with the methods of
            `Sensors`.
        plant: Replaces the scenario's: a recipe, an .fmu, keys of [vehicle] such as {"model": "MyLib.MyTrain",
            "library": "MyLib/package.mo"}, or an object or class with the methods of `Plant`.
        import_from: Folders of modules that the scenario names as module:Class.

    Raises:
        ScenarioError: The scenario requires something that its parts cannot do.
        FmuError: An FMU cannot be used in this scenario.

    Example:
        >>> stop = run("trapezoid", controller="slip_two_state")
        >>> stop.metrics.distance  # [m]
    """
    from railgrip.campaign.run import add_versions
    from railgrip.simulate.run import run_stop

    changed, objects = _with_parts(scenario, controller=controller, estimator=estimator, sensors=sensors, plant=plant)
    return add_versions(run_stop(changed, objects=_parts(import_from, **objects)))


def open(
    scenario: ScenarioLike,
    estimator: "Estimator | type[Estimator] | str | Mapping[str, Any] | None" = None,
    sensors: "Sensors | type[Sensors] | str | Mapping[str, Any] | None" = None,
    plant: "Plant | type[Plant] | str | Path | Mapping[str, Any] | None" = None,
    *,
    import_from: Iterable[str | Path] = (),
) -> "Bench":
    """Return a bench on which the caller acts as the controller: `reset()`, `step(pressures)`, `ended`, `stop`.

    Arguments and errors are those of `run`.

    Example:
        >>> with open("trapezoid") as bench:
        ...     observation = bench.reset()
        ...     while not bench.ended:
        ...         observation = bench.step(observation.driver_demand)
        >>> bench.stop.metrics.distance  # [m]
    """
    from railgrip.simulate.run import Bench

    changed, objects = _with_parts(scenario, estimator=estimator, sensors=sensors, plant=plant)
    return Bench(changed, _parts(import_from, **objects))


def sweep(
    scenario: ScenarioLike,
    axes: Mapping[str, Iterable[Any]],
    controller: "Controller | type[Controller] | str | Mapping[str, Any] | None" = None,
    estimator: "Estimator | type[Estimator] | str | Mapping[str, Any] | None" = None,
    sensors: "Sensors | type[Sensors] | str | Mapping[str, Any] | None" = None,
    plant: "Plant | type[Plant] | str | Path | Mapping[str, Any] | None" = None,
    *,
    workers: int = 1,
    import_from: Iterable[str | Path] = (),
) -> "Sweep":
    """Run every combination of values, the last axis fastest; the result has `.to_pandas()` and `.to_xarray()`.

    Args:
        scenario: Scenario whose values are replaced.
        axes: Key → values, such as {"start.speed": ["80 km/h", "120 km/h"], "seed": range(10)}.
            "controller.parameters.X" is the argument X of a class given as `controller`, and likewise for estimator,
            sensors and vehicle.
        controller: As for `run`; each stop gets a copy of an object, or a new object of a class.
        estimator: Likewise.
        sensors: Likewise.
        plant: Likewise.
        workers: Number of processes. Objects whose class cannot be imported, such as those of a script or notebook, run
            in this process.
        import_from: As for `run`.

    Raises:
        ScenarioError: A combination is not a valid scenario, or a class does not accept it; nothing was run.
    """
    from railgrip.campaign.sweep import swept

    base, parts = _with_parts(scenario, controller=controller, estimator=estimator, sensors=sensors, plant=plant)
    handed_over = [name for name, part in parts.items() if part is not None]

    def variant(values: Mapping[str, Any]) -> "tuple[Scenario, CustomParts]":
        rest, parameters = _split(values, handed_over)
        return base.changed(rest), _parts(import_from, parameters, **{n: _copy(n, p) for n, p in parts.items()})

    return swept(base.name, variant, {key: _choices(key, axis) for key, axis in _axes(axes)}, workers)


def evaluate(
    function: "Callable[..., Rows]",
    cases: Iterable[Mapping[str, Any]],
    file: str | Path | None = None,
    *,
    workers: int = 2,
) -> "pandas.DataFrame":
    """Return the results of a function in many cases, such as figures of stops, with case and results in a row.

    Results are cached by the sources of railgrip and of the function's module, so that an interrupted call continues.

    Args:
        function: Function of a module, which is called with a case as its arguments and returns a mapping, or several
            for several rows. A function of a script or notebook runs in this process, and its results are not cached.
        cases: Arguments by name: numbers and texts.
        file: CSV file next to the study that keeps the results. If it has these cases, it is read and nothing is run;
            otherwise it is written. Remove it to run the cases again.
        workers: Number of processes; 0 runs one case after the other in this process and caches nothing, for durations.

    Raises:
        InputError: There are no cases.
        RailgripError: A case failed; results of the others are kept in the cache.

    Example:
        >>> evaluate(errors_of, [{"load": load, "seed": seed} for load in (0.8, 1.0) for seed in (1, 2)], "errors.csv")
    """
    from railgrip.campaign.evaluate import evaluate as evaluated

    return evaluated(function, cases, None if file is None else path_of(file, "file"), workers)


def table(
    frame: "pandas.DataFrame", forms: "Mapping[str, Form] | None" = None, left: Collection[str] | None = None
) -> "ReportTable":
    """Return a frame without its index as a table for a page: `str` of it is Markdown, and a notebook displays it.

    Args:
        frame: Rows and columns.
        forms: Column → format of its values, such as "{:.1f} m", or a function that returns their text.
        left: Columns that are aligned on the left; those of texts unless given.
    """
    from railgrip.report.table import ReportTable

    texts = set(frame.columns) - set(frame.select_dtypes("number").columns)
    return ReportTable.of_frame(frame, forms or {}, texts if left is None else left)


def compare(a: "Stop | str | Path", b: "Stop | str | Path", *more: "Stop | str | Path") -> "Comparison":
    """Return the differences of results to the first: scenarios, figures, and the distance lost along the track.

    Args:
        a: A stop, or the folder of a run, of a stop in a campaign, or of a campaign.
        b: Result to compare with `a`.
        more: Further results.

    Raises:
        RecordError: A folder has no result, or the arguments are both stops and campaigns.
    """
    from railgrip.report.comparison import compare as compared

    return compared(a, b, *more)


def load(folder: str | Path) -> "Stop | Sweep":
    """Return the results in a folder in the form of `run` and `sweep`: the stop of a run, or the stops of a campaign.

    Both have `.to_pandas()`. The axes of a campaign correspond to those of a sweep.

    Args:
        folder: Folder of a run, of a stop in a campaign, or of a campaign.

    Raises:
        RecordError: The folder has no result, or a result is unreadable.
        ScenarioError: A file that the scenario of the stop names is missing.
    """
    from railgrip.campaign.sweep import load_results

    return load_results(path_of(folder, "folder"))


def estimate(
    recording: "xarray.Dataset | str | Path",
    model: str | Path = "stop",
    changes: Mapping[str, Any] | None = None,
    *,
    filters: Iterable[str] = (),
) -> "Estimates":
    """Return the estimates of a filter at every sample of a recording: `mean` and `sd` of its states, innovations, NIS.

    The result is an xarray dataset; `.plot()` draws it. Its attributes `repairs`, `warnings` and `problems` have the
    sentences that the command prints, a line each. Where the command ends with exit code 3, because the filter is lost
    or no vehicle has these signals or estimates, `problems` is not empty and an `EstimateWarning` is issued.

    Args:
        recording: A trace, such as `stop.trace`, or a file: trace.nc of a stop, or csv, parquet, mat or mf4 that [data]
            of the model's file describes.
        model: Estimation file with model, noises and start, or the name of one in the library, such as "wagon".
        changes: As for `Scenario.load`.
        filters: Kinds of filters, such as `["fmu", "unscented"]`, for estimates next to each other with the dimension
            `filter`; empty for the extended Kalman filter without it.

    Raises:
        ScenarioError: The file is not an estimation.
        EstimationError: The recording lacks signals that the model requires, or its signals contradict each other.
    """
    from railgrip.estimation.sources import recording_of_estimation, recording_of_trace, require_consistent
    from railgrip.estimation.spec import estimate_of, load_specification

    specification = load_specification(path_of(model, "model"), _changes(changes))
    kinds = () if isinstance(filters, str) else tuple(call_user_code(lambda: list(filters), _unreadable("filters")))
    if isinstance(filters, str) or any(type(kind) is not str for kind in kinds):
        raise EstimationError(f"filters are {short(filters)}; expected are kinds, as ['fmu', 'unscented']")
    if isinstance(recording, str | Path):
        recording_file = recording_of_estimation(specification, data=Path(recording))
        return _announced(estimate_of(specification, recording_file, kinds))
    if not _is_over_time(recording):
        raise EstimationError(
            f"recording is {short(recording)}; expected is a trace over time, such as stop.trace, or the path of a file"
        )
    require_consistent(specification)
    return _announced(estimate_of(specification, recording_of_trace(specification, recording)[1], kinds))


def learn_friction(file: str | Path, out: str | Path, *, workers: int = 2) -> "pandas.DataFrame":
    """Learn friction from labelled axle-box accelerations, and return the errors of friction on runs left out.

    The trained estimators are written into a folder as JSON, which `railgrip ride` runs, and as FMUs: one for all
    speeds, and a network of Abduraxman et al. (2024) for each class of speed with two runs or more. The attribute
    `repairs` of the frame has a sentence for each correction of the recordings.

    Args:
        file: TOML file with the folder of the recordings, their labels, and columns; see "Use recorded data".
        out: Folder of the estimators.
        workers: Number of processes.

    Raises:
        ScenarioError: The file is invalid.
        EstimationError: Recordings or labels cannot be used, or are fewer than four.
        RecordError: The folder has files with these names that railgrip did not write.
    """
    from pandas import DataFrame

    from railgrip.base.records import make_folder
    from railgrip.campaign.work import call, work
    from railgrip.estimation.axle_box.recordings import judge_recordings, read_folder, read_recordings_file
    from railgrip.estimation.axle_box.training import export

    path, folder = path_of(file, "file"), path_of(out, "out")
    inputs = read_recordings_file(path)
    make_folder(folder)
    runs, repairs = read_folder(path.parent / inputs.runs.folder, path.parent / inputs.runs.labels, inputs.data)
    with work("learn_friction", folder, workers=workers) as job:
        scores, trained = judge_recordings(runs, inputs.network.recipe(), lambda tasks: job.map(call, tasks))
    export(trained, folder)
    frame = DataFrame(scores)
    frame.attrs["repairs"] = repairs
    return frame


def _announced(estimates: "xarray.Dataset") -> "Estimates":
    from railgrip.report.estimates import as_estimates

    if estimates.attrs["problems"]:
        warnings.warn(f"{estimates.attrs['estimation']}: {estimates.attrs['problems']}", EstimateWarning, stacklevel=3)
    return as_estimates(estimates)


def etcs(train: str | Path, national: str | Path | None = None, line: str | Path | None = None) -> "BrakingCurves":
    """Return braking curves and supervision limits of ETCS: `.to_pandas()`, `.table`, `.stops`, `.figure()`.

    Args:
        train: Train file, or name of a train such as "emu387"; or a file of brake curves or of a brake percentage.
        national: File of national values; the defaults of SUBSET-026, A.3.2, unless given.
        line: File of the line, with gradients and targets; level, with EoA and SvL at 0 m, unless given.

    Raises:
        InputError: Files are wrong, each problem in a sentence; or the brake does not slow the train down.

    Example:
        >>> curves = etcs("emu387")
        >>> curves.table  # distances of EBD, EBI, SBI, W, P and I to the targets
    """
    from railgrip.supervision.results import braking_curves

    values = None if national is None else path_of(national, "national")
    return braking_curves(path_of(train, "train"), values, None if line is None else path_of(line, "line"))


def inspect(
    recording: str | Path,
    model: str | Path = "field",
    time: str | None = None,
    decimal: Literal[".", ","] | None = None,
    train: str | Path | None = None,
    order: Literal["day first", "month first"] | None = None,
) -> "Inspection":
    """Return the content of a recording: `findings` by column, `signals` recognised, a `proposal` for reading it.

    `parameters` are the vehicle data that the model needs.

    Args:
        recording: File: csv, parquet, mat or mf4.
        model: Estimation that will read it, a file or a name.
        time: Column of time; None to recognise it.
        decimal: Decimal sign of a csv file; None to detect it.
        train: Train of the prediction, a name or a train file; None for that of the estimation.
        order: Order of dates such as 04/01/2025; None to recognise it.

    Raises:
        ScenarioError: The estimation cannot be read.
        EstimationError: The recording cannot be read.
    """
    from railgrip.estimation.inspection import inspect_recording

    if decimal not in (None, ".", ","):
        raise EstimationError(f"decimal is {short(decimal)}; expected is '.' or ','")
    if order not in (None, "day first", "month first"):
        raise EstimationError(f"order is {short(order)}; expected is 'day first' or 'month first'")
    train_name = None if train is None else str(path_of(train, "train"))
    return inspect_recording(path_of(recording, "recording"), path_of(model, "model"), time, decimal, train_name, order)


def _with_parts(scenario: ScenarioLike, *, plant: Any, **parts: Any) -> tuple[Scenario, dict[str, Any]]:
    given_scenario = scenario if isinstance(scenario, schema.Scenario) else Scenario.load(scenario)
    resolved = given_scenario if isinstance(given_scenario, Scenario) else Scenario.load(given_scenario.tables())
    if isinstance(plant, _WRITTEN):
        resolved, plant = resolved.with_plant(plant), None
    written = {name: part for name, part in parts.items() if isinstance(part, str | Mapping)}
    if written:
        resolved = resolved.changed(
            {name: {"kind": part} if isinstance(part, str) else part for name, part in written.items()}
        )
    return resolved, {name: None if name in written else part for name, part in parts.items()} | {"plant": plant}


_TABLES = {"controller": "controller", "estimator": "estimator", "sensors": "sensors", "plant": "vehicle"}
"""Argument → table of the scenario that an object replaces."""

_OF_EVERY_PART = frozenset({("vehicle", "formation"), *(("controller", name) for name in TrainLevelTable.model_fields)})
"""Keys of these tables that also apply to an object; see `CustomParts.declare_in`."""


def _parts(folders: Any, parameters: Mapping[str, Mapping[str, Any]] | None = None, /, **parts: Any) -> "CustomParts":
    from railgrip.simulate.user_parts import CustomParts, instance_of

    objects: dict[str, Any] = {}
    for name, part in parts.items():
        table = _TABLES[name]
        arguments = (parameters or {}).get(table, {})
        if isinstance(part, type):
            part = instance_of(part, arguments, f"{name}:")
        elif arguments:
            raise ScenarioError(
                f"'{table}.parameters.{next(iter(arguments))}' is a parameter of a class, but {name} is an object "
                f"already; pass the class {type(part).__name__} instead"
            )
        objects[name] = part
    return CustomParts(**objects, folders=_folders(folders))


def _folders(folders: Any) -> tuple[Path, ...]:
    # Other processes may have another current folder.
    several = [folders] if isinstance(folders, str | Path) else folders
    if not isinstance(several, Iterable):
        raise ScenarioError(f"import_from is {short(folders)}; expected are paths of folders")
    entries = call_user_code(lambda: list(several), _unreadable("import_from"))
    paths = [Path.cwd() / path_of(entry, "import_from") for entry in entries]
    for path in paths:
        if not is_folder(path):
            raise ScenarioError(f"import_from: there is no folder {place(path)}")
    return tuple(paths)


def _split(values: Mapping[str, Any], handed_over: Collection[str]) -> tuple[TomlTable, dict[str, TomlTable]]:
    rest: TomlTable = {}
    parameters: dict[str, TomlTable] = {}
    tables = {_TABLES[name]: name for name in handed_over}
    for key, value in values.items():
        table, *path = parts_of(key)
        if table not in tables or (path and (table, path[0]) in _OF_EVERY_PART):
            rest[key] = value
        elif len(path) == 2 and path[0] == "parameters":
            parameters.setdefault(table, {})[path[1]] = value
        else:
            raise ScenarioError(
                f"'{key}' has no effect: {tables[table]}= replaces [{table}]; sweep "
                f"'{table}.parameters.NAME', an argument of its class, or omit one of the two"
            )
    return rest, parameters


def _copy(name: str, part: Any) -> Any:
    return call_user_code(
        lambda: copy.deepcopy(part),
        lambda problem: ScenarioError(
            f"{name}: each stop of a sweep needs its own copy of the object: {problem}; pass its class"
        ),
    )


def _axes(axes: Any) -> list[tuple[str, Any]]:
    if not isinstance(axes, Mapping):
        raise ScenarioError(f'axes are {short(axes)}; expected is key → values, as {{"start.speed": ["80 km/h"]}}')
    return list(call_user_code(axes.items, _unreadable("axes")))


def _choices(key: Any, choices: Any) -> list[Any]:
    if not isinstance(choices, Iterable) or isinstance(choices, str | bytes | Mapping):
        raise ScenarioError(f"sweep: the axis {short(key)} is {short(choices)}; expected is a list of values")
    return [_plain(value, "axes") for value in call_user_code(lambda: list(choices), _unreadable("axes"))]


def _is_over_time(recording: Any) -> bool:
    import xarray

    return isinstance(recording, xarray.Dataset) and "time" in recording.indexes


def _changes(changes: Any) -> TomlTable:
    if changes is None:
        return {}
    if not isinstance(changes, Mapping):
        raise ScenarioError(f'changes are {short(changes)}; expected is key → value, as {{"start.speed": "100 km/h"}}')
    return _plain(changes, "changes")


def _unreadable(name: str) -> Callable[[str], ScenarioError]:
    return lambda problem: ScenarioError(f"{name} cannot be read: {problem}")


def _plain(value: Any, name: str) -> Any:
    return call_user_code(lambda: _as_in_files(value), _unreadable(name))


def _as_in_files(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Mapping):
        return {key: _as_in_files(inner) for key, inner in value.items()}
    return [_as_in_files(inner) for inner in value] if isinstance(value, list | tuple) else value
