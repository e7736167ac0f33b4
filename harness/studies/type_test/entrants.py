"""Entrants: built-in controllers or a user's, on a built-in train or a user's, and the digest of a controller.

The sealed set of cases of a controller is drawn from the digest of its source and parameters.
"""

import ast
import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, get_args

from pydantic import ConfigDict, Field, StrictBool, StrictInt

from railgrip.base import registry
from railgrip.base.errors import InputError, ScenarioError
from railgrip.base.files import LARGEST_TABLE, read_bytes
from railgrip.base.names import did_you_mean
from railgrip.base.tables import TomlTable
from railgrip.base.units import cut
from railgrip.fmus.recipe import read_recipes
from railgrip.scenario.campaign import Campaign, PlannedStop
from railgrip.scenario.file import OtherFileString, merge
from railgrip.scenario.load import read_scenario, read_toml, scenario_of, validate_table
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Table
from railgrip.simulate.named_models import has_contacts_of_library
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.studies.type_test.case_set import VERSIONS, AnyCase

LIBRARY = Path(__file__).parent / "library"
_SCENARIOS = Path(__file__).parents[2] / "scenario"
_ANY_TRAIN = {"free_wheels": True, "load_deviation": 0.1}
"""Radars fail, and the mass of passengers, a fifth of a railcar's mass, is unknown."""
_FILTER = {"model": "TrainPredictionDisturbed", **_ANY_TRAIN}
"""Estimator of the built-in train for all entrants with estimates; it does not know the gradient."""
_OF_THE_TRAIN = ("vehicle", "sensors", "actuation", "estimator", "periods", "limits")


Role = Literal["reference", "bound", "baseline", "entrant"]


class Entrant(Table):
    """An entrant; other keys are tables that override those of each case."""

    model_config = ConfigDict(frozen=True, extra="allow")

    description: str
    role: Role
    tuned: StrictBool = Field(default=False, description="whether its parameters were searched on the training rails")
    since: StrictInt = Field(default=1, description="first version of the type test with it")
    hand_trials: StrictInt | None = Field(default=None, description="sets tried by hand; not counted without it")

    @property
    def tables(self) -> TomlTable:
        """Tables that override those of a case."""
        return dict(self.model_extra or {})


def entrants(version: int = 1) -> dict[str, Entrant]:
    """Return the built-in entrants in a version of the type test by name: references first, then baselines."""
    tables = read_toml(LIBRARY / "entrants.toml")
    all_of_them = {
        name: validate_table(Entrant, _table_in(version, **table), directory=LIBRARY, origin=f"entrants: {name}")
        for name, table in tables.items()
        if table.get("since", 1) <= version
    }
    return dict(sorted(all_of_them.items(), key=lambda item: get_args(Role).index(item[1].role)))


def _table_in(version: int, *, version_2: TomlTable | None = None, **table: Any) -> TomlTable:
    """Return the table of an entrant with those that override it in a version."""
    return merge(table, version_2 or {}) if version == 2 else table


def entrants_named(arguments: Sequence[str], ours: Mapping[str, Entrant]) -> dict[str, Entrant]:
    """Return the entrants that a user names: built-in ones, [controller] and [estimator] of a scenario, an FMU,
    module:Class.

    An FMU and a class get the estimates of the train's filter, unless a scenario specifies another estimator.

    Raises:
        ScenarioError: The entrant does not exist.
    """
    selection: dict[str, Entrant] = {}
    for argument in arguments:
        if argument in ours:
            selection[argument] = ours[argument]
            continue
        name, entrant = _entrant_of_user(argument, ours)
        if name in ours or name in selection:
            raise ScenarioError(
                f"--controller {cut(argument)}: would take part as '{name}', as another controller does; rename it"
            )
        selection[name] = entrant
    return selection


def _entrant_of_user(argument: str, ours: Mapping[str, Entrant]) -> tuple[str, Entrant]:
    path = Path(argument)
    if path.suffix == ".toml" or argument in registry.shelf("scenarios"):
        table, name = _read(path), cut(path.name)
        if "controller" not in table:
            raise ScenarioError(f"{name}: has no [controller], which is what takes part in a type test")
        tables = {key: table[key] for key in ("controller", "estimator") if key in table}
        for key, content in tables.items():
            kind = content.get("kind") if isinstance(content, dict) else None
            if not isinstance(kind, str):
                found = content if kind is None else kind
                raise ScenarioError(
                    f"{name}: [{key}] is a table whose kind is a text, got {cut(repr(found))}; write [{key}] and below "
                    f'it kind = "..."'
                )
        return path.stem, _entrant_of(f"[controller] of {name}", tables)
    if path.suffix == ".fmu":
        return path.stem, _entrant_of(path.name, {"controller": {"kind": "fmu", "file": str(path.resolve())}})
    if ":" in argument:
        return argument.rpartition(":")[2], _entrant_of(argument, {"controller": {"kind": argument}})
    if argument in registry.installed_names("controllers"):
        return argument, _entrant_of(argument, {"controller": {"kind": argument}})
    question = did_you_mean(argument, ours, quote="")
    raise ScenarioError(
        f"--controller {cut(argument)}: {f'{question} It ' if question else ''}is neither one of "
        f"{', '.join(ours)} nor a scenario, an .fmu or module:Class"
    )


def _read(path: Path) -> TomlTable:
    tables = read_scenario(path)
    return OtherFileString.within(tables.table, tables.directory.resolve())


def _entrant_of(description: str, tables: TomlTable) -> Entrant:
    return Entrant.model_validate({"description": description, "role": "entrant", **tables})


def train_of(argument: str | None) -> TomlTable:
    """Return the tables of a train with valves and service sensors.

    The train is built-in, a recipe, an FMU, that of a scenario, or one in a train file, for the decentralised filter.

    Raises:
        ScenarioError: The train does not exist.
    """
    table = merge(
        read_toml(_SCENARIOS / "library" / "plain.toml"), read_toml(_SCENARIOS / "equipment" / "service.toml")
    )
    table = merge(table, {"estimator": _FILTER})
    if argument is None:
        return table
    is_ours = argument in registry.shelf("trains")
    path = (registry.shelf("scenarios") | registry.shelf("trains")).get(argument, Path(argument))
    if path.suffix == ".toml":
        content = read_toml(path)
        if "cars" in content:
            own_file = argument if is_ours else str(path.resolve())
            filtering = {"kind": "decentralised", "noise": "service", **_ANY_TRAIN}
            return table | {"vehicle": {"train": own_file}, "estimator": filtering}
        content = _read(path)
        return table | {"vehicle": {}} | {key: content[key] for key in _OF_THE_TRAIN if key in content}
    if path.suffix == ".fmu":
        return table | {"vehicle": {"plant": str(path.resolve())}}
    if argument in read_recipes().recipes:
        return table | {"vehicle": {"plant": argument}}
    raise ScenarioError(
        f"--train {cut(argument)}: is neither a scenario, a train, an .fmu nor a recipe; "
        "`railgrip list` shows the names"
    )


def task_of(path: Path) -> TomlTable:
    """Return the tables of a scenario that override those of every case: [demand], and the cleaning of the rail.

    Raises:
        ScenarioError: It has neither.
    """
    table = read_scenario(path).table
    task = {"demand": table["demand"]} if "demand" in table else {}
    adhesion = table.get("adhesion")
    if isinstance(adhesion, dict) and "conditioning" in adhesion:
        task["adhesion"] = {"conditioning": adhesion["conditioning"]}
    if not task:
        raise ScenarioError(
            f"{cut(path.name)}: has neither [demand] nor [adhesion.conditioning]; a task is one or both"
        )
    return task


_TRAINING_SPEED = 60 / 3.6
"""Maximum initial speed of training stops [m/s]: a short stop is sufficient to evaluate a law."""


def training_cases(count: int, version: int = 1) -> list[AnyCase]:
    """Return a number of short cases of the training set, with those of its further parts."""
    cases = VERSIONS[version].design(count, VERSIONS[version].training)
    return [replace(case, speed=min(case.speed, _TRAINING_SPEED)) for case in cases]


def trains_of(design: Iterable[AnyCase]) -> dict[str, TomlTable]:
    """Return the tables of the trains of the library that cases name, by name."""
    return {name: train_of(name) for name in sorted({case.train for case in design} - {""})}


def training(count: int, version: int = 1) -> tuple[PlannedStop, ...]:
    """Return a number of stops to tune controllers on, from a separate set of cases of a version.

    The axis `rail` names the case.
    """
    tuned = {"tuned": _entrant_of("what is tuned", {"controller": {"kind": "full_brake"}})}
    design = training_cases(count, version)
    return tuple(
        replace(
            stop, variants={"rail": ", ".join(value for key, value in stop.variants.items() if key != "controller")}
        )
        for stop in campaign_of(design, tuned, train_of(None), trains=trains_of(design)).stops
    )


def campaign_of(
    design: Iterable[AnyCase],
    taking_part: Mapping[str, Entrant],
    train: TomlTable,
    *,
    trains: Mapping[str, TomlTable] = MappingProxyType({}),
    task: TomlTable | None = None,
    keep_traces: bool = False,
) -> Campaign:
    """Return the stops of a type test: each case with each entrant.

    Args:
        design: The cases.
        taking_part: Entrants by name.
        train: Tables of the train, `train_of`.
        trains: Tables of the trains of single cases by name; cases of other trains have `train`.
        task: Tables that override those of every case, `task_of`; full brake without it.
        keep_traces: Whether each stop leaves its trace.

    Raises:
        ScenarioError: A combination is not a valid scenario.
    """
    known = {
        name: scenario_of(merge(table, {"name": "train"}), directory=LIBRARY, origin="--train")
        for name, table in {**trains, "": train}.items()
    }
    groups = {name: _groups(scenario) for name, scenario in known.items()}
    stops: list[PlannedStop] = []
    for case in design:
        of_train = case.train if case.train in trains else ""
        tables = {"name": "type-test"} | case.tables(groups[of_train])
        of_case = merge(trains.get(of_train, train), tables)
        of_case = merge(of_case, case.fault_tables(groups[of_train]))
        if not has_contacts_of_library(known[of_train].vehicle.source):
            of_case["truth"].pop("mechanics", None)
        for name, entrant in taking_part.items():
            if not case.has_bound and entrant.tables["controller"]["kind"] in registry.ANALYSES:
                continue
            task_table = dict(task or {})
            if entrant.role == "bound":
                task_table.pop("demand", None)  # it always brakes fully, independent of the demand
            scenario = scenario_of(
                merge(merge(of_case, task_table), entrant.tables),
                directory=LIBRARY,
                origin=f"type test, case {case.name}, {name}",
            )
            stops.append(
                PlannedStop(
                    name=f"{case.name}-{name}",
                    variants={**case.variants(), "controller": name},
                    scenario=scenario,
                    keep_trace=keep_traces,
                )
            )
    return Campaign(name="type_test", description="", stops=tuple(stops), references=(), panels="none")


def _groups(train: Scenario) -> int:
    if train.vehicle.train is None:
        return VehicleData(train).formation.groups
    # The plant of a train file takes seconds to translate, and stops that come with the package need none. Imported
    # here, because few type tests have a train file, whose schema takes as long to load as numpy.
    from railgrip.rolling_stock.check import checked_train

    return len(checked_train(train.vehicle.train.path).groups)


def controller_digest(entrant: Entrant, folders: Sequence[Path] = ()) -> str:
    """Return a SHA-256 of the tables of an entrant, its parameters and its source.

    Comments, docstrings and the layout of a source do not count: they do not change the stops. Of a user's class it is
    the module of the class, without the modules that it imports; of an FMU the file.

    Args:
        entrant: The controller.
        folders: Folders in which modules of users are found.

    Raises:
        ScenarioError: The source does not exist.
    """
    table = entrant.tables["controller"]
    kind = str(table["kind"])
    digest = hashlib.sha256(json.dumps(entrant.tables, sort_keys=True, default=str).encode())
    if kind in registry.modules(registry.LAWS):
        for content in _of_law(kind):
            digest.update(content)
    elif kind == "fmu":
        digest.update(_bytes(Path(str(table["file"]))))
    elif ":" in kind:
        digest.update(_meaning(_module_file(kind.partition(":")[0], folders)))
    return digest.hexdigest()


def _of_law(kind: str) -> Iterable[bytes]:
    """Yield the sources of a law and of the laws that it imports, and all its sets of parameters."""
    found, waiting = set[str](), [kind]
    while waiting:
        name = waiting.pop()
        if name in found:
            continue
        found.add(name)
        path = _module_file(f"{registry.LAWS}.{name}", ())
        yield _meaning(path)
        tree = ast.parse(path.read_text(encoding="utf-8"))
        imports = [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
        waiting += [module.rpartition(".")[2] for module in imports if module.startswith(f"{registry.LAWS}.")]
    for name, file in sorted(registry.files(registry.LAWS).items()):
        if name.partition(".")[0] in found:
            yield name.encode() + file.read_bytes()


def _module_file(module: str, folders: Sequence[Path]) -> Path:
    relative = Path(*module.split("."))
    for folder in folders:
        for file in (folder / relative.with_suffix(".py"), folder / relative / "__init__.py"):
            if file.is_file():
                return file
    spec = find_spec(module)
    if spec is None:
        raise ScenarioError(f"--controller: there is no module {module}; correct the name, or add --import-from")
    if not spec.has_location or spec.origin is None or Path(spec.origin).suffix != ".py":
        raise ScenarioError(
            f"--controller: the module {module} is part of Python or compiled, and has no source in Python; a "
            "controller is a class of your own, module:Class"
        )
    return Path(spec.origin)


def _meaning(path: Path) -> bytes:
    """Return the syntax tree of a source without docstrings, as text."""
    try:
        tree = ast.parse(_bytes(path))
    except (SyntaxError, ValueError, RecursionError) as problem:
        raise ScenarioError(f"{path.name}: is not a module in Python: {problem}") from problem
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and ast.get_docstring(
            node, clean=False
        ):
            node.body = node.body[1:]
    return ast.dump(tree).encode()


def _bytes(path: Path) -> bytes:
    try:
        return read_bytes(path, LARGEST_TABLE)
    except InputError as problem:
        raise ScenarioError(f"--controller: {problem}") from problem
