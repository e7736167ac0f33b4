"""The recordings: stops of the two-part train, spread evenly over what an estimator may meet.

Estimators of users run over them, too: a class in Python, or a prediction FMU in the extended Kalman filter.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Final, Literal

import numpy as np
import xarray

import railgrip.scenario
from railgrip.base.errors import InputError
from railgrip.base.tables import TomlTable
from railgrip.controllers.observation import Observation
from railgrip.estimation.sources import stop_read
from railgrip.estimators.belief import Array, Vector
from railgrip.recording.samples import with_signals
from railgrip.rolling_stock.modelica import nominal_data
from railgrip.rolling_stock.schema import Train, load_train
from railgrip.scenario.file import NamedFile, locate, merge
from railgrip.scenario.load import read_toml, scenario_of
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Custom
from railgrip.simulate.user_parts import CustomParts, Estimate, Estimator, class_of, part_of
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.studies.type_test.design import Case, cases, ranks
from railgrip.studies.type_test.track_case import TrackCase, track_cases
from railgrip.trace.bound import with_bound
from railgrip.vehicle.formation import Formation

COUNT, TRAINING = 48, 24
"""Number of cases of each set, and of a search of noises."""

SEEDS: Final = MappingProxyType({"training": 31, "test": 32, "sealed": 33})
"""Seeds of the sets: numbers are searched on the first, reported on the second, and the third is for a finished
estimator."""

Sensors = Literal["ideal", "service", "worn"]
SENSORS: Final[tuple[Sensors, ...]] = ("ideal", "service", "worn")

GROUPS: Final = 4
"""Of the two-part train."""
PERIOD: Final = 0.01
"""Of recordings and estimators [s]."""

LENGTH: Final = 30
"""Duration of a recording [s], if the train is not at standstill before; the filters need no more, and cost time."""

_ROOT: Final = Path(railgrip.scenario.__file__).parent
_TABLES: Final = read_toml(Path(__file__).parent / "library" / "recordings.toml")

DEMANDS: Final[TomlTable] = _TABLES["demands"]
"""Demand of the driver → [demand] of the scenario: full brake, service steps, a release in between, and traction with
coasting before the brake."""

WORN: Final[TomlTable] = _TABLES["worn"]
"""[sensors] of worn ones: twice the errors and the latency of equipment/service.toml, and fewer pulses."""

INERTIAS: Final = (1.0, 0.9, 1.1)
"""Inertia of the wheelsets over that of the predictions: wheels wear by some 10 % of it."""

_INERTIA: Final = (222.0, 209.0, 209.0, 222.0)
"""Of the groups in the predictions [kg·m²]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingCase:
    """A stop that is recorded.

    Attributes:
        stop: Rail, train and faults: a case of version 1 or 2 of the type test.
        sensors: Quality of the sensors; with ideal ones the actuation is ideal, else there are valves.
        demand: Key of `DEMANDS`.
        over: Whether friction changes over time or along the track.
        inertia: Inertia of the wheelsets over that of the predictions.
        train: Name of a train or path of a train file; '' for the two-part train.
        digest: SHA-256 of that file, so that stored results of a file that has changed are not used.
    """

    stop: Case | TrackCase
    sensors: Sensors
    demand: str
    over: Literal["time", "distance"]
    inertia: float
    train: str = ""
    digest: str = ""

    @property
    def groups(self) -> int:
        """Number of groups of the train."""
        return len(self.train_file.groups) if self.train else GROUPS

    @property
    def train_file(self) -> Train:
        """Content of the train file."""
        return load_train(Path(self.train))


def recording_cases(count: int, seed: int, train: str = "") -> tuple[RecordingCase, ...]:
    """Return a number of cases of a train, the same ones for the same seed.

    The first half is of version 1 of the type test, the second of version 2. Sensors, demand, dimension of the friction
    and inertia are further axes, each as even as those of the type test; in version 2 the rail decides the dimension.
    The speed at the start does not exceed that of the fastest published stop of the train.

    Args:
        count: Number of cases.
        seed: Seed of the set.
        train: Name of a train or path of a train file; '' for the two-part train.

    Raises:
        ScenarioError: The file is not a train.
    """
    fastest, digest = np.inf, ""
    if train:
        fastest = max((stop.speed for stop in load_train(Path(train)).reference), default=np.inf)
        digest = NamedFile(entry=train, path=locate(train, "trains")).digest()
    choices: list[RecordingCase] = []
    stops = (*cases((count + 1) // 2, seed), *track_cases(count // 2, seed))
    for stop, (first, second, third, fourth) in zip(stops, ranks(count, 4, seed), strict=True):
        choices.append(
            RecordingCase(
                stop=_on_train(stop, fastest),
                sensors=SENSORS[int(first * len(SENSORS))],
                demand=tuple(DEMANDS)[int(second * len(DEMANDS))],
                over="distance" if third > 0.5 else "time",
                inertia=INERTIAS[int(fourth * len(INERTIAS))],
                train=train,
                digest=digest,
            )
        )
    return tuple(choices)


def _on_train(stop: Case | TrackCase, fastest: float) -> Case | TrackCase:
    stop = replace(stop, train="") if isinstance(stop, TrackCase) else stop
    return replace(stop, speed=min(stop.speed, fastest))


@lru_cache(maxsize=16)  # a search of noises repeats the cases of a class of sensors
def recording_of_case(case: RecordingCase) -> xarray.Dataset:
    """Run the stop of a case and return its trace on the grid of the estimators.

    The controller uses no estimate, so that the recording does not depend on an estimator. The force of the track is
    unknown on board, its reading is 0. `peak_adhesion` is the maximum of the creep curve of each group, with the
    friction that its wheelsets meet at their place and instant.
    """
    scenario = scenario_of_case(case)
    trace, vehicle = stop_read(scenario, case.stop.name), VehicleData(scenario)
    bound = with_bound(trace, vehicle.contact, vehicle.true.brakes, scenario.limits.alpha_max)
    trace = trace.assign(peak_adhesion=bound["peak_adhesion"])
    return with_signals(trace, {"track_force": (np.zeros(trace.sizes["time"]), "N")})


def scenario_of_case(case: RecordingCase) -> Scenario:
    """Return the scenario of a case, without an estimator."""
    table = read_toml(_ROOT / "library" / "trapezoid.toml")
    if case.sensors != "ideal":
        table = merge(table, read_toml(_ROOT / "equipment" / "service.toml"))
    tables = case.stop.tables(case.groups)
    if case.train:
        data = nominal_data(case.train_file)
        vehicle, inertias = {"train": case.train}, [data[f"J[{g}]"] for g in range(1, case.groups + 1)]
    else:
        vehicle, inertias = table["vehicle"], list(_INERTIA)
    table |= {
        "adhesion": _along(tables.pop("adhesion"), case),
        "estimator": {"kind": "none"},
        "vehicle": vehicle | {"parameters": {f"J[{g}]": case.inertia * J for g, J in enumerate(inertias, 1)}},
        "controller": {"kind": "slip_three_state"},
        "periods": {"communication": "1 ms", "estimator": "10 ms", "controller": "10 ms", "trace": "10 ms"},
    }
    if case.sensors == "worn":
        table = merge(table, {"sensors": WORN})
    if DEMANDS[case.demand]:
        table["demand"] = DEMANDS[case.demand]
    table = merge(merge(table, tables | {"limits": {"horizon": f"{LENGTH} s"}}), _faults(case))
    return scenario_of(table, directory=_ROOT / "library", origin=case.stop.name)


def _faults(case: RecordingCase) -> TomlTable:
    """Return the tables of the faults; ideal actuation has neither valves nor an air supply that may fail."""
    rows = case.stop.fault_tables(case.groups).get("faults", ())
    kept = [row for row in rows if case.sensors != "ideal" or row["part"] not in ("valve", "supply")]
    return {"faults": kept} if kept else {}


def _along(adhesion: TomlTable, case: RecordingCase) -> TomlTable:
    """Return [adhesion] over time or distance; a second is the distance of half the speed at the start."""
    if case.over == "time" or "over" not in adhesion or isinstance(case.stop, TrackCase):
        return adhesion
    metres = {
        key: f"{float(value.removesuffix(' s')) * case.stop.speed / 2:.1f} m"
        for key, value in adhesion.items()
        if isinstance(value, str) and value.endswith(" s")
    }
    return adhesion | metres | {"over": "distance"}


FAMILIES: Final = ("sensors", "demand", "load", "gradient", "rail", "faults", "inertia")
"""Axes of the cases by which results are summarised."""

_KNOWN_LOAD, _LEVEL = 0.03, 0.002
"""Relative deviation of the load below which it counts as known, and slope below which the track counts as level."""


def family_of(case: RecordingCase, field: str) -> str:
    """Return the value of an axis of `FAMILIES` for a case."""
    match field:
        case "load":
            load = case.stop.tables(case.groups)["truth"]["load"]
            return "load known" if abs(load - 1.0) < _KNOWN_LOAD else "load low" if load < 1.0 else "load high"
        case "gradient":
            return "sloping" if abs(case.stop.slope) > _LEVEL else "level"
        case "rail":
            cleaning = isinstance(case.stop, TrackCase) and case.stop.cleaning != "none"
            return "cleaned" if cleaning else "even" if case.stop.rail == "even" else "varying"
        case "faults":
            return "fault" if _faults(case) else "no fault"
        case "inertia":
            return "inertia known" if case.inertia == 1.0 else "inertia off"
        case _:
            return str(getattr(case, field))


_SPEEDS: Final = ("speed", "wheelset_speed", "slip")
"""Estimates that a controller uses in place of readings."""


def is_class(estimator: str) -> bool:
    """Return whether an argument of `--estimator` is FILE.py:CLASS."""
    return ":" in estimator


def is_fmu(estimator: str) -> bool:
    """Return whether an argument of `--estimator` is the prediction FMU of a user."""
    return Path(estimator).suffix == ".fmu"


def name_of(estimator: str) -> str:
    """Return the name of an estimator in tables: its class, the name of its FMU, or the name itself."""
    return Path(estimator).stem if is_fmu(estimator) else estimator.rpartition(":")[2]


def require_file(estimator: str) -> None:
    """Raise `InputError` unless the file of a user's estimator exists and has a suffix of its kind.

    Raises:
        ScenarioError: The class cannot be imported, or lacks methods.
    """
    file = Path(estimator.rpartition(":")[0] or estimator)
    if is_class(estimator) and file.suffix != ".py":
        raise InputError(f"--estimator {estimator}: expected FILE.py:CLASS, the file of a class in Python.")
    if not file.is_file():
        raise InputError(f"--estimator {estimator}: there is no file {file}.")
    if is_class(estimator):
        class_of(_table_of(estimator), "estimators", (file.resolve().parent,))


def _table_of(estimator: str) -> Custom:
    file, _, name = estimator.rpartition(":")
    return Custom(kind=f"{Path(file).stem}:{name}")


def require_one_of_each_name(estimators: Iterable[str]) -> None:
    """Check that tables can distinguish the estimators, and that Python can import their modules.

    Raises:
        InputError: Two have one name, or two files that are imported have one.
    """
    of_name, of_module = dict[str, str](), dict[str, tuple[str, Path]]()
    for estimator in dict.fromkeys(estimators):
        earlier = of_name.setdefault(name_of(estimator), estimator)
        if earlier != estimator:
            raise InputError(
                f"--estimator {estimator}: would have the name of {earlier} in the tables, {name_of(estimator)}; "
                "rename one."
            )
        if is_class(estimator):
            file = Path(estimator.rpartition(":")[0]).resolve()
            other, path = of_module.setdefault(file.stem, (estimator, file))
            if path != file:
                raise InputError(
                    f"--estimator {estimator}: {file.name} is another file than that of {other}, and Python imports "
                    f"one module named '{file.stem}'; rename one of the files."
                )


def trace_with_class(case: RecordingCase, estimator: str) -> xarray.Dataset:
    """Return the recording of a case with the estimates of a user's class, which runs in the loop of the stop.

    Its speeds do not reach the controller, so that the readings are those of all other estimators.

    Raises:
        ScenarioError: The class cannot be imported, or the estimator fails.
    """
    folder = Path(estimator.rpartition(":")[0]).resolve().parent
    own = _WithoutSpeeds(part_of(_table_of(estimator), "estimators", (folder,)))
    recording = stop_read(scenario_of_case(case), case.stop.name, objects=CustomParts(estimator=own))
    for name, values in own.kept.items():
        if values:
            held = _held(np.array(list(values)), np.array(list(values.values())), recording["time"].values)
            recording[f"estimate_{name}"] = (("time", "group")[: held.ndim], held)
    return recording.assign(peak_adhesion=recording_of_case(case)["peak_adhesion"])


class _WithoutSpeeds:
    """A user's estimator whose speeds are not given to the controller.

    Attributes:
        kept: Speed [m/s] and slip that it has estimated, by time [s].
    """

    def __init__(self, estimator: Estimator) -> None:
        self._estimator = estimator
        self.kept: dict[str, dict[float, Array]] = {"speed": {}, "slip": {}}
        self.provides = tuple(name for name in estimator.provides if name not in _SPEEDS)

    def start(self, first: Observation, formation: Formation) -> None:
        self._estimator.start(first, formation)

    def step(self, observation: Observation) -> Estimate:
        estimate = self._estimator.step(observation)
        for name, values in self.kept.items():
            if (value := getattr(estimate, name)) is not None:
                values[observation.time] = np.array(value, dtype=np.float64)
        return replace(estimate, **dict.fromkeys(_SPEEDS))


def _held(time: Vector, values: Array, at: Vector) -> Array:
    """Return the last of the values at other times, the first one before it."""
    return values[np.maximum(np.searchsorted(time, at + 1e-9, side="right") - 1, 0)]
