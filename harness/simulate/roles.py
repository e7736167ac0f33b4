"""Roles of FMUs, identified by the names of their inputs and outputs, and the key of a scenario for each role."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, Literal

from railgrip.base import registry
from railgrip.base.errors import FmuError
from railgrip.fmi import Description
from railgrip.fmi.draft import OTHER_NAMES, arrays_of, likeness
from railgrip.scenario.schema import Scenario
from railgrip.scenario.vehicle import ModelicaPlant, PythonClass, RecipePlant

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
    if role not in (expected, None):
        what, remedy = _USES[role]
        raise FmuError(
            f"{where}: {description.file.name} is {what} by its inputs and outputs, not {_USES[expected][0]}; {remedy}."
        )


def require_plant(scenario: Scenario, description: Description) -> None:
    """Raise an error for an FMU that is not a plant, or is one for another kind of actuation; a map overrides names.

    Raises:
        FmuError: The FMU does not fit; the message names the key of the scenario to change.
    """
    source, kind, file = scenario.vehicle.source, scenario.actuation.kind, description.file.name
    where, names = f"{scenario.name}: [vehicle] plant", {name.partition("[")[0] for name in description.names("input")}
    sent, other = _COMMANDS if kind == "ideal" else _COMMANDS[::-1]
    if isinstance(source, PythonClass) or scenario.vehicle.map or sent in names:
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
