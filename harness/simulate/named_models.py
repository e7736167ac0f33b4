"""The FMUs and Modelica classes that a scenario names, found or built, and the roles that FMUs can have in it."""

import math
from collections.abc import Mapping
from functools import cache, lru_cache
from hashlib import sha256
from pathlib import Path
from types import MappingProxyType
from typing import Final, Literal, NamedTuple

from railgrip.base import registry
from railgrip.base.cache import keep
from railgrip.base.errors import FmuError, ScenarioError
from railgrip.base.limits import FmuLimits
from railgrip.base.names import ElementName
from railgrip.base.registry import shelf
from railgrip.base.units import Unit
from railgrip.estimators.prediction import with_state_names
from railgrip.fmi import Description, describe
from railgrip.fmi.draft import OTHER_NAMES, arrays_of, likeness
from railgrip.fmus.build import build_class, fmu
from railgrip.fmus.native import Model, lower
from railgrip.fmus.native.library import LIBRARY, library_of
from railgrip.fmus.recipe import FmiType, read_recipes
from railgrip.scenario.file import NamedFile
from railgrip.scenario.quantity import BOOLEAN
from railgrip.scenario.schema import Scenario
from railgrip.scenario.vehicle_table import (
    FmuFile,
    LibraryClass,
    ModelicaPlant,
    PythonClass,
    RecipePlant,
    Source,
    TrainFile,
    Vehicle,
)
from railgrip.vehicle.signals import CURVE

description_of = cache(describe)
"""Return the description of an FMU in the user's cache, read once: its path has the digest of its content.

The time of its last change does not identify it, because every process that uses the FMU sets it.
"""


def description_of_file(path: Path, limits: FmuLimits) -> Description:
    """Return the description of a user's FMU, read once for each version of the file."""
    status = path.stat() if path.exists() else None
    return _describe(path, (status.st_mtime_ns, status.st_size) if status else (0, 0), limits)


@lru_cache(maxsize=64)  # there may be a new version for each stop
def _describe(path: Path, stamp: tuple[int, int], limits: FmuLimits) -> Description:  # pyright: ignore[reportUnusedParameter]
    return describe(path, limits)


recipe_file = cache(fmu)
"""Return the FMU of a recipe, built if it is out of date; cached in the process."""


@cache
def _class_file(class_name: str, library: Path, digest: str, interface: FmiType) -> Path:  # pyright: ignore[reportUnusedParameter]
    return build_class(class_name, library, interface).path


@cache
def _train_file(path: Path, digest: str, pneumatic: bool, rail: "_Rail") -> Path:  # pyright: ignore[reportUnusedParameter]
    # Imported here: the schema of a train file takes as long to load as numpy, and few scenarios use one.
    from railgrip.rolling_stock.check import checked_train
    from railgrip.rolling_stock.modelica import class_name, class_text

    train = checked_train(path)
    name, text = class_name(train, pneumatic=pneumatic), class_text(train, pneumatic=pneumatic)
    rigging = "redeclare block TrainRigging = RailBraking.Pneumatics.HystereticRigging"
    return _build(*_on_rail(name, text, len(train.axles), rail._replace(hysteresis=rigging, uneven=True)))


@cache
def _recipe_on_rail(recipe: str, rail: "_Rail") -> Path:
    """Return the FMU of a recipe's class on a rail; the plain one if the class cannot have what the rail requires."""
    entry = read_recipes().recipes[recipe]
    if not entry.curve:
        return recipe_file(recipe)
    variables = description_of(recipe_file(recipe)).variables
    wheelsets = sum(name.startswith("mu0[") for name in variables)
    rail = rail._replace(
        # The default of HystereticRigging, which train files get as a class.
        hysteresis="hysteresis=0.06" if "hysteresis" in variables else "",
        uneven="deflection[1]" in variables,
    )
    return _build(*_on_rail(entry.class_name, "", wheelsets, rail))


class _Rail(NamedTuple):
    """What a train's class has besides that of the library.

    Attributes:
        curved: Inputs for the creep curve at each wheelset, as the rail has several.
        temperature_loss: Share of friction that contacts lose a kelvin [1/K]; 0 for contacts that do not heat up.
        detailed: Contact forces by the simplified theory where contacts do not heat up, and elastic shafts; also what
            follows.
        hysteresis: Modification that gives the brake rigging its hysteresis; empty if the class cannot have it.
        uneven: Whether the class has a primary suspension, on which it runs on an uneven rail.
    """

    curved: bool
    temperature_loss: float
    detailed: bool
    hysteresis: str = ""
    uneven: bool = False


def _on_rail(name: str, text: str, wheelsets: int, rail: _Rail) -> tuple[str, str]:
    """Return the name of a train's class on a rail, and its Modelica text after that of the classes it extends.

    Args:
        name: Name of the train's class.
        text: Modelica text of that class; empty if it is in the library.
        wheelsets: Number of wheelsets.
        rail: What the class has besides that of the library.
    """
    if rail.detailed:
        name, more = _class_with_details(name, rail)
        text += more
    if rail.temperature_loss:
        name, more = _class_with_heat(name, rail.temperature_loss)
        text += more
    if rail.curved:
        name, more = _class_with_curves(name, wheelsets)
        text += more
    return name, text


def _class_with_details(name: str, rail: _Rail) -> tuple[str, str]:
    """Return name and Modelica text of a train's class with contacts, shafts, rigging and rail in more detail."""
    class_name = f"{name.rpartition('.')[2]}_detailed"
    changes = ["redeclare block TrainShaft = RailBraking.Components.ElasticShaft"]
    if not rail.temperature_loss:
        changes.append("redeclare block TrainContact = RailBraking.Contact.SimplifiedContact")
    if rail.uneven:
        changes.append("redeclare block TrainRail = RailBraking.Tracks.UnevenRail")
    if rail.hysteresis:
        changes.append(rail.hysteresis)
    return class_name, (
        f'block {class_name} "{name} in more detail"\n  extends {name}(\n    '
        + ",\n    ".join(changes)
        + f");\nend {class_name};\n"
    )


def _class_with_heat(name: str, temperature_loss: float) -> tuple[str, str]:
    """Return name and Modelica text of a train's class whose friction falls with the temperature of the contacts."""
    class_name = f"{name.rpartition('.')[2]}_heated"
    # The contact is a separate class: rumoca loses the modifiers of a class that is redeclared.
    return class_name, (
        f'block {class_name}_contact "Contact whose friction falls with its temperature"\n'
        f"  extends RailBraking.Contact.HeatedContact(temperature_loss={temperature_loss!r});\n"
        f"end {class_name}_contact;\n"
        f'block {class_name} "{name} whose friction falls with the temperature of the contacts"\n'
        f"  extends {name}(redeclare block TrainContact = {class_name}_contact);\n"
        f"  parameter RailBraking.Types.TemperatureCoefficient temperature_loss(min=0) = {temperature_loss!r}\n"
        f'    "Share of friction lost a kelvin, that of the contacts";\nend {class_name};\n'
    )


def _class_with_curves(name: str, wheelsets: int) -> tuple[str, str]:
    """Return name and Modelica text of a train's class that takes the creep curve at each wheelset from inputs."""
    class_name = f"{name.rpartition('.')[2]}_on_curves"
    shape = ", ".join(f"{signal.name.removeprefix('curve_')}={signal.name}[i]" for signal in CURVE)
    inputs = "".join(
        f"  RailBraking.Interfaces.RealInput {signal.name}[{wheelsets}]"
        f'(each final unit="{signal.unit}", each start=0) "{signal.meaning}";\n'
        for signal in CURVE
    )
    return class_name, (
        f'block {class_name} "{name} with the creep curve at each wheelset as an input"\n'
        f"  extends {name}(curve={{RailBraking.Data.CreepCurve({shape}) for i in 1:{wheelsets}}});\n"
        f"{inputs}end {class_name};\n"
    )


def _build(name: str, text: str) -> Path:
    source = keep("modelica", sha256(text.encode()).hexdigest(), f"{name}.mo", text.encode())
    return build_class(name, source).path


def remarks_on_train(scenario: Scenario) -> list[str]:
    """Return a sentence for each unusual value of the train file of a scenario.

    Raises:
        ScenarioError: The law of pad friction does not hold at the speeds of the stop.
    """
    source = scenario.vehicle.source
    if not isinstance(source, TrainFile):
        return []
    remarks, wrong = _remarks_on_train(source.file.path, source.file.digest(), scenario.start.speed)
    if wrong:
        raise ScenarioError("\n".join(f"{scenario.name}: {sentence}" for sentence in wrong))
    return [f"{scenario.name}: {sentence}" for sentence in remarks]


@cache
def _remarks_on_train(path: Path, digest: str, speed: float) -> tuple[list[str], list[str]]:  # pyright: ignore[reportUnusedParameter]
    from railgrip.rolling_stock.check import checked_train, fastest_stop, findings, friction_findings

    train = checked_train(path)
    # A train that starts from rest accelerates to a speed that is not known here.
    wrong = friction_findings(train, speed or fastest_stop(train))
    return [f"{path.name}: {remark}" for remark in findings(train)], [f"{path.name}: {remark}" for remark in wrong]


compile_class = cache(lower)
"""Return a Modelica class as CasADi functions; compiled once in a process."""


def plant_description(scenario: Scenario) -> Description:
    """Return the description of a scenario's plant FMU; an empty one for a plant in Python, which has no FMU.

    Raises:
        ScenarioError: [vehicle] train is not a train file, or [truth] mechanics does not fit the plant.
    """
    adhesion, detailed = scenario.adhesion, scenario.truth.mechanics == "detailed"
    rail = _Rail(curved=len(adhesion.curves) > 1, temperature_loss=adhesion.polach.temperature_loss, detailed=detailed)
    if detailed and not has_contacts_of_library(scenario.vehicle.source):
        raise ScenarioError(
            "[truth] mechanics = 'detailed' needs the two-part train, the wagon or a train file; leave it out"
        )
    match scenario.vehicle.source:
        case RecipePlant(name) if name in shelf("trains"):
            raise ScenarioError(f"[vehicle] plant '{name}' is a train file of this package; write train = '{name}'")
        case RecipePlant(name):
            return description_of(_recipe_on_rail(name, rail) if any(rail) else recipe_file(name))
        case TrainFile(file):
            is_pneumatic = scenario.actuation.kind == "pneumatic"
            return description_of(_train_file(file.path, file.digest(), is_pneumatic, rail))
        case LibraryClass(name, library):
            return description_of(_class_file(name, library.path, library.digest(), "cs"))
        case FmuFile(file):
            return description_of_file(file.path, scenario.limits.fmu)
        case PythonClass(name):
            return Description(
                file=Path(name), fmi=2, digest="", model=name, guid="", generator="", variables={}, states=(),
                derivatives=(), dependencies={}, event_indicators=0, log_categories=(), co_simulation=None,
                model_exchange=None, blemishes="",
            )  # fmt: skip


def has_contacts_of_library(source: Source) -> bool:
    """Return whether contacts and shafts of a plant are built-in and can be replaced."""
    if isinstance(source, RecipePlant):
        return source.name in shelf("trains") or read_recipes().recipes[source.name].curve
    return isinstance(source, TrainFile)


def prediction_model(model: str, library: NamedFile | None = None) -> Model:
    """Return a prediction as CasADi functions, compiled once in a process.

    Args:
        model: A class of RailBraking.Predictions, or the full name of a class.
        library: A user's library that has the class; None for RailBraking.
    """
    if library is None:
        return _prediction_model(_full_name(model), LIBRARY, "")
    return _prediction_model(model, library_of(library.path), library.digest())


@cache
def _prediction_model(class_name: str, library: Path, digest: str) -> Model:  # pyright: ignore[reportUnusedParameter]
    return with_state_names(lower(class_name, library))


def prediction_description(model: str, library: NamedFile | None = None, interface: FmiType = "me") -> Description:
    """Return the description of the FMU of a prediction, built if it is out of date; see `prediction_model`."""
    if library is not None:
        return description_of(_class_file(model, library.path, library.digest(), interface))
    class_name, name = _full_name(model), model.rpartition(".")[2]
    recipe = read_recipes().recipes.get(name)
    if interface == "me" and recipe is not None and recipe.class_name == class_name:
        return description_of(recipe_file(name))
    return description_of(_class_file(class_name, LIBRARY, "", interface))


def _full_name(model: str) -> str:
    return model if "." in model else f"RailBraking.Predictions.{model}"


def consist_description(source: Path, interface: FmiType = "me") -> Description:
    """Return the description of the prediction FMU of a train, from `CentralPrediction.source`."""
    return description_of(_class_file(source.stem, source, source.parent.name, interface))


def is_trusted(vehicle: Vehicle) -> bool:
    """Return whether the plant may be loaded into this process: it was compiled here, or the scenario declares trust.

    Modelica sources that a user names are compiled on this machine, by either compiler; only a prebuilt binary is code
    from elsewhere.
    """
    return isinstance(vehicle.source, ModelicaPlant) or vehicle.trust


def parameters_of(description: Description) -> dict[str, float]:
    """Return the start values of an FMU's numeric parameters."""
    return {
        variable.name: variable.start
        for variable in description.variables.values()
        if variable.causality == "parameter" and variable.kind in ("Real", "Integer") and not math.isnan(variable.start)
    }


COMPILED_IN: Final = (
    " Integer, Boolean and enumeration parameters of a class are compiled in; for other values name a class that "
    "extends it."
)
"""Sentence for those who set a parameter that the FMU of their class does not have."""


def units_of(description: Description) -> dict[str, Unit | str]:
    """Return the units of an FMU's parameters, `BOOLEAN` for booleans."""
    return {
        v.name: BOOLEAN if v.kind == "Boolean" else v.defined_unit or v.unit
        for v in description.variables.values()
        if v.causality == "parameter"
    }


Role = Literal["onboard", "sensors", "estimator", "track", "plant", "controller", "prediction"]

_SIMILAR: Final = 0.85
"""Similarity above which a name counts as one of the usual names.

Plurals match, and a driver's demand does not match that of a cylinder.
"""
_READINGS: Final = ("reading_speed", "reading_wheelset_speed", "reading_acceleration")
_COMMANDS: Final = ("pressure_command", "valve_command")
_DECISIONS: Final = ("demand", "command", *_COMMANDS)
_MARKS: Final[Mapping[Role, tuple[tuple[Literal["input", "output"], tuple[str, ...]], ...]]] = MappingProxyType(
    {
        "onboard": (("input", _READINGS), ("output", _DECISIONS)),
        "sensors": (("output", _READINGS),),
        "estimator": (("input", _READINGS),),
        "track": (("input", ("distance",)), ("output", ("mu0",))),
        "plant": (("input", _COMMANDS), ("output", ("speed",)), ("output", ("wheelset_speed",))),
        "controller": (("input", ("speed", "wheelset_speed", "slip")), ("output", _DECISIONS)),
        "prediction": (("input", ("cylinder_pressure", "pad_force")), ("output", ("wheelset_speed",))),
    }
)
"""Role → signals that identify it, one of each row; an FMU has the first role whose rows all match."""
_USES: Final[Mapping[Role, tuple[str, str]]] = MappingProxyType(
    {
        "plant": ("a plant", "name it in [vehicle] plant"),
        "controller": ("a controller", 'name it in [controller] kind = "fmu", file'),
        "prediction": ("the prediction of an estimator", 'name it in [estimator] kind = "fmu", file'),
        "onboard": (
            "estimator and controller in one, for other tools",
            "a scenario names its [estimator] and its [controller] instead",
        ),
        "sensors": ("sensors for other tools", "a scenario names the kind of its [sensors] instead"),
        "estimator": ("an estimator for other tools", "a scenario names the kind of its [estimator] instead"),
        "track": ("rail and driver for other tools", "a scenario has [track], [adhesion] and [demand] instead"),
    }
)
"""Role → noun for such an FMU, and advice on its use."""


def role_of(description: Description) -> Role | None:
    """Return the role of an FMU by the names of its inputs and outputs; None if they fit no role."""
    names = {
        causality: {
            part
            for array in arrays_of(description)
            if array.variables[0].causality == causality
            for part in (array.name, array.name.rpartition(".")[2])
        }
        for causality in ("input", "output")
    }

    def has(causality: str, signals: tuple[str, ...]) -> bool:
        words = [word for signal in signals for word in (signal, *OTHER_NAMES.get(signal, "").split())]
        return any(likeness(name, words) >= _SIMILAR for name in names[causality])

    return next((role for role, marks in _MARKS.items() if all(has(*mark) for mark in marks)), None)


def require_role(description: Description, expected: Role, where: str) -> None:
    """Raise an error for an FMU that has another role than the key that names it.

    Args:
        description: Description of the FMU.
        expected: Role for the key.
        where: File and key, the opening words of the message.

    Raises:
        FmuError: The FMU has another role; the message names the key for it.
    """
    role = role_of(description)
    if role is not None and role != expected:
        what, remedy = _USES[role]
        raise FmuError(
            f"{where}: {description.file.name} is {what} by its inputs and outputs, not {_USES[expected][0]}; {remedy}."
        )


def require_plant(vehicle: Vehicle, kind: Literal["ideal", "pneumatic"], description: Description) -> None:
    """Raise an error for an FMU that is not a plant, or is one for another kind of actuation; a map overrides names.

    Args:
        vehicle: Table that names the FMU.
        kind: Kind of actuation.
        description: Description of the FMU.

    Raises:
        FmuError: The FMU does not fit; the message names the key of the scenario to change.
    """
    source, file, where = vehicle.source, description.file.name, "[vehicle] plant"
    names = {ElementName.of(name).array for name in description.names("input")}
    sent, other = _COMMANDS if kind == "ideal" else _COMMANDS[::-1]
    if isinstance(source, PythonClass) or vehicle.map or sent in names:
        return
    if other in names:
        remedy = "ideal" if kind == "pneumatic" else "pneumatic"
        raise FmuError(
            f"{where}: {file} takes {other}, but [actuation] kind is '{kind}', which sends {sent}; set actuation.kind "
            f"= '{remedy}', or name a plant that takes {sent}."
        )
    require_role(description, "plant", where)
    if isinstance(source, ModelicaPlant) and role_of(description) is None:
        others = ""
        if isinstance(source, RecipePlant):
            others = f", or a train of `railgrip list trains` in [vehicle] train: {', '.join(registry.names('trains'))}"
        raise FmuError(
            f"{where}: {file} is not a train: it has neither pressure_command nor valve_command among its inputs; name "
            f"TwoPartTrain or TwoPartTrainPneumatic{others}."
        )
