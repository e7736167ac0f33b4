"""What `import railgrip` offers; see docs/api.md."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

from pydantic import PrivateAttr

from railgrip.scenario import schema
from railgrip.scenario.file import installed
from railgrip.scenario.load import demand_kind, read_toml, validated
from railgrip.scenario.merge import merged, read_overrides

if TYPE_CHECKING:
    # CasADi and the FMU loader take a second; whoever only reads scenarios does without.
    import xarray

    from railgrip.assemble import OwnParties
    from railgrip.assemble.by_hand import Bench
    from railgrip.campaign.sweep import Sweep
    from railgrip.custom import Controller, Estimator, Plant, Sensors
    from railgrip.trace.stop import Stop


class Scenario(schema.Scenario):
    """Everything that decides a stop."""

    _directory: Path = PrivateAttr(default_factory=Path.cwd)

    @classmethod
    def load(cls, source: str | Path | Mapping[str, Any], changes: Mapping[str, Any] | None = None) -> Self:
        """Return a scenario by its name, such as "trapezoid", from a TOML file, or from its tables.

        Args:
            source: Name, path, or tables; files that tables name are found from the current folder.
            changes: Key → value laid over it, as {"start.speed": "100 km/h"}.

        Raises:
            ScenarioError: Missing, or not a scenario; each problem in one sentence with its key.
        """
        if isinstance(source, Mapping):
            table, directory = dict(source), Path.cwd()
            origin = str(table.get("name", "the scenario"))
        else:
            path = installed(Path(source), "library")
            table, directory, origin = read_toml(path), path.parent, path.name
            demand_kind(table, "scenario", path)
        return cls._of(merged(table, _tree(changes or {})), directory, origin)

    def changed(self, changes: Mapping[str, Any]) -> Self:
        """Return the scenario with other values; see `load`."""
        return self._of(merged(self.resolved(), _tree(changes)), self._directory, self.name)

    def with_plant(self, plant: str | Path | Mapping[str, Any]) -> Self:
        """Return the scenario with a recipe, an .fmu, or keys of [vehicle] for its plant, whatever that was before.

        Paths are from the current folder.
        """
        keys = dict(plant) if isinstance(plant, Mapping) else {"plant": plant}
        for key, value in keys.items():
            if key == "library" or (key == "plant" and str(value).endswith(".fmu")):
                keys[key] = str(Path(value).resolve())
            elif key == "plant":
                keys[key] = str(value)
        table = self.resolved()
        before = {key: value for key, value in table["vehicle"].items() if key not in ("plant", "model", "library")}
        table["vehicle"] = before | keys
        return self._of(table, self._directory, self.name)

    @classmethod
    def _of(cls, table: Mapping[str, Any], directory: Path, origin: str) -> Self:
        scenario = validated(cls, table, directory=directory, origin=origin)
        scenario._directory = directory
        return scenario


_WRITTEN = (str, Path, Mapping)
"""What a plant is that a scenario can name."""

ScenarioLike = schema.Scenario | str | Path | Mapping[str, Any]
"""A scenario, or what `Scenario.load` takes for one."""


def run(
    scenario: ScenarioLike,
    controller: "Controller | type[Controller] | None" = None,
    estimator: "Estimator | type[Estimator] | None" = None,
    sensors: "Sensors | type[Sensors] | None" = None,
    plant: "Plant | type[Plant] | str | Path | Mapping[str, Any] | None" = None,
    *,
    engine: Literal["auto", "python", "compiled"] = "auto",
    import_from: Iterable[str | Path] = (),
) -> "Stop":
    """Run a scenario and return its stop: `.outcome`, `.metrics`, `.trace` (xarray), `.write(folder)`.

    Args:
        scenario: What to run.
        controller: Object or class of one's own in place of the scenario's; likewise estimator and sensors.
        plant: In place of the scenario's a recipe, an .fmu, keys of [vehicle] such as {"model": "MyLib.MyTrain",
            "library": "MyLib/package.mo"}, or an object or class of one's own.
        engine: What steps the parties; the stop is the same to the last bit.
        import_from: Folders of modules that the scenario names as module:Class.

    Raises:
        ScenarioError: The scenario asks for something that its parties cannot do.
        FmuError: An FMU does not fit.
    """
    from railgrip.assemble import run_stop
    from railgrip.campaign.one_stop import with_sources
    from railgrip.engine import Engine

    own = _own(controller, estimator, sensors, plant, import_from)
    return with_sources(run_stop(_scenario_of(scenario, plant), engine=Engine(engine), own=own))


def open(
    scenario: ScenarioLike,
    estimator: "Estimator | type[Estimator] | None" = None,
    sensors: "Sensors | type[Sensors] | None" = None,
    plant: "Plant | type[Plant] | str | Path | Mapping[str, Any] | None" = None,
    *,
    import_from: Iterable[str | Path] = (),
) -> "Bench":
    """Return a bench on which the caller is the controller: `reset()`, `step(pressures)`, `ended`, `stop`."""
    from railgrip.assemble.by_hand import Bench

    return Bench(_scenario_of(scenario, plant), _own(None, estimator, sensors, plant, import_from))


def sweep(
    scenario: ScenarioLike,
    axes: Mapping[str, Iterable[Any]],
    controller: "Controller | type[Controller] | None" = None,
    estimator: "Estimator | type[Estimator] | None" = None,
    sensors: "Sensors | type[Sensors] | None" = None,
    plant: "Plant | type[Plant] | str | Path | Mapping[str, Any] | None" = None,
    *,
    workers: int = 1,
    import_from: Iterable[str | Path] = (),
) -> "Sweep":
    """Run every combination of values, the last axis fastest: `.to_pandas()`, `.to_xarray()`.

    Args:
        scenario: What all have in common.
        axes: Key → values, as {"start.speed": ["80 km/h", "120 km/h"], "seed": range(10)}.
        controller: As for `run`, a copy for each stop; likewise estimator, sensors and plant.
        workers: Processes. Objects whose class a process could not import, of a script or notebook, run in this one.
        import_from: As for `run`.

    Raises:
        ScenarioError: A combination is no scenario; nothing was run.
    """
    from railgrip.campaign.sweep import swept

    base = _scenario_of(scenario, plant)
    whole = base if isinstance(base, Scenario) else Scenario.load(base.resolved())
    values = {key: [_plain(value) for value in choices] for key, choices in axes.items()}
    return swept(whole.name, whole.changed, values, _own(controller, estimator, sensors, plant, import_from), workers)


def estimate(
    recording: "xarray.Dataset | str | Path", model: str | Path = "stop", changes: Mapping[str, Any] | None = None
) -> "xarray.Dataset":
    """Return what a filter believes at every sample of a recording: `mean` and `sd` of its states, innovations, NIS.

    Args:
        recording: A trace, such as `stop.trace`, or a file: trace.nc of a stop, or csv, parquet, mat or mf4 that
            [data] of the model's file describes.
        model: An estimation file: model, noises, start; or the name of one of ours, such as "wagon".
        changes: As for `Scenario.load`.

    Raises:
        ScenarioError: The file is no estimation.
        EstimationError: The recording does not fit it.
    """
    from railgrip.estimation.sources import completed, recording_of_estimation
    from railgrip.estimation.spec import LIBRARY, estimate_of, load_specification

    path = Path(model)
    ours = LIBRARY / f"{path}.toml"
    overrides = [f"{key}={value}" for key, value in (changes or {}).items()]
    specification = load_specification(ours if not path.suffix and ours.is_file() else path, overrides)
    if isinstance(recording, str | Path):
        return estimate_of(specification, recording_of_estimation(specification, data=Path(recording)))
    return estimate_of(specification, completed(specification, recording))


def _scenario_of(scenario: ScenarioLike, plant: Any) -> schema.Scenario:
    base = scenario if isinstance(scenario, schema.Scenario) else Scenario.load(scenario)
    if not isinstance(plant, _WRITTEN):
        return base
    whole = base if isinstance(base, Scenario) else Scenario.load(base.resolved())
    return whole.with_plant(plant)


def _own(controller: Any, estimator: Any, sensors: Any, plant: Any, folders: Iterable[str | Path]) -> "OwnParties":
    from railgrip.assemble import OwnParties

    objects = {"controller": controller, "estimator": estimator, "sensors": sensors}
    objects["plant"] = None if isinstance(plant, _WRITTEN) else plant
    parties: dict[str, Any] = {name: party() if isinstance(party, type) else party for name, party in objects.items()}
    return OwnParties(**parties, folders=tuple(map(Path, folders)))


def _tree(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return dotted keys with their values as one tree of tables."""
    tree: dict[str, Any] = {}
    for key, value in changes.items():
        layer = read_overrides([f"{key}=0"])
        inner = layer
        while isinstance(next(iter(inner.values())), dict):
            inner = next(iter(inner.values()))
        inner[next(iter(inner))] = _plain(value)
        tree = merged(tree, layer)
    return tree


def _plain(value: Any) -> Any:
    """Return a value as files have it: of numpy, of paths and tuples."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    return list(value) if isinstance(value, tuple) else value
