"""The prediction model of a train, built from its nominal data for any formation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from railgrip.base.cache import keep
from railgrip.base.errors import ScenarioError
from railgrip.base.names import ElementName
from railgrip.base.system import Variable
from railgrip.estimators.filters.decentralised import Consist, Part
from railgrip.estimators.prediction import with_state_names
from railgrip.fmus.native import Model, lower
from railgrip.vehicle.brake import pressure_of
from railgrip.vehicle.formation import Formation, carried_mass
from railgrip.vehicle.parameters import OF_BRAKES, masses_by_name

CENTRAL = ("ConsistPrediction", "ConsistPredictionDisturbed")
"""Predictions of a whole train: on a known track, and with gradient and bias of the accelerometer as states."""

_PACKAGE = "RailBraking.Vehicles"
_OF_WHEELSETS = frozenset({"m_unsprung", "dz", "ddz", "deflection"})
_OF_BOGIES = frozenset({"m_frame", "I_frame", "wheelbase", "h_frame", "h_rod", "k_primary", "c_primary"})
_PAD_FRICTION = "mu_b_nominal"


@cache
def _body() -> Model:
    return with_state_names(lower(f"{_PACKAGE}.BodyPrediction"))


@cache
def _source(name: str, groups: int, group_of_wheelset: tuple[int, ...]) -> Path:
    """Write the Modelica text of a class of `Vehicles` with its sizes to the cache.

    Groups of wheelsets count from 1.
    """
    sizes = f"final n_groups={groups}, final n_bogies={len(group_of_wheelset) // 2}"
    if group_of_wheelset:
        sizes += f", final group_of_wheelset={{{', '.join(map(str, group_of_wheelset))}}}"
    text = f'block {name} = {_PACKAGE}.{name}({sizes}) "Prediction of a train or of a part";\n'.encode()
    return keep("modelica", sha256(text).hexdigest(), f"{name}.mo", text)


@cache
def _model(name: str, groups: int, group_of_wheelset: tuple[int, ...]) -> Model:
    return with_state_names(lower(name, _source(name, groups, group_of_wheelset)))


@dataclass(frozen=True, slots=True)
class _Members:
    """Zero-based groups of a part or a train, and its bogies with a suspension and their wheelsets."""

    groups: tuple[int, ...]
    bogies: tuple[int, ...] = ()
    wheelsets: tuple[int, ...] = ()

    def sizes(self, formation: Formation) -> tuple[int, tuple[int, ...]]:
        belongs = formation.group_of_wheelset[list(self.wheelsets)] if self.wheelsets else ()
        return len(self.groups), tuple(self.groups.index(group) + 1 for group in belongs)

    def place(self, name: str) -> tuple[str, int]:
        element = ElementName.of(name)
        of_wheelsets = self.wheelsets if element.array in _OF_WHEELSETS else self.groups
        of = self.bogies if element.array in _OF_BOGIES else of_wheelsets
        return element.array, of[element.place] if element.bracket else 0

    def name_in_train(self, name: str) -> str:
        base, index = self.place(name)
        return f"{base}[{index + 1}]" if "[" in name else name

    def parameters(self, model: Model, formation: Formation, data: Mapping[str, float]) -> dict[str, float]:
        def value(variable: Variable) -> float:
            base, index = self.place(variable.name)
            if base == "m_group":
                return sum(_mass(data, i) for i in np.flatnonzero(formation.group_of_wheelset == index).tolist())
            return _value(data, base, index, variable.start)

        return {variable.name: value(variable) for variable in model.parameters}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CentralPrediction:
    """A train as one prediction, for a central filter: a class of `CENTRAL` with sizes and parameters.

    Attributes:
        source: Modelica file of the class, named after it.
        model: The same, translated.
        parameters: Parameters of the model, by name.
        readings: Names of its outputs in the whole train: `deflection` by wheelset, not only those of bogies.
    """

    source: Path
    model: Model
    parameters: Mapping[str, float]
    readings: tuple[str, ...]


def units_of_predictions() -> dict[str, str]:
    """Return the unit of every parameter of a prediction, by name without index."""
    models = _body(), _model("PartPrediction", 1, (1, 1))
    units = {ElementName.of(v.name).array: v.unit for model in models for v in model.parameters}
    parameters = {name: unit for name, unit in units.items() if name not in ("m", "m_group")}
    return parameters | {"m_wheelset": units["m_group"], _PAD_FRICTION: "1"}


def data_of(nominal: Mapping[str, float], formation: Formation) -> dict[str, float]:
    """Return the parameters of a prediction for a train: nominal data, completed by those of the formation."""
    bases = {ElementName.of(name).array for name in nominal}
    # The formation has the product of ratio and efficiency of the rigging, so the efficiency is 1 then.
    each = {
        f"{name}[{g + 1}]": float(getattr(brake, datum))
        for datum, name in {**OF_BRAKES, "rigging": "i_rigging"}.items()
        if name not in bases
        for g, brake in enumerate(formation.brakes)
    }
    if "i_rigging" not in bases:
        each["eta_rigging"] = 1.0
    masses = {} if formation.load is None else masses_by_name(carried_mass(formation.load))
    return dict(nominal) | each | masses


def consist_of(formation: Formation, data: Mapping[str, float]) -> Consist:
    """Return the prediction of a train in parts, for the decentralised filter.

    A bogie of two wheelsets with a known frame is a part with its suspension; all other groups have a static load.
    Bogies are those of `wheelsets_per_bogie`, else of two wheelsets each if there are half as many frames.

    Args:
        formation: Wheelsets and groups.
        data: Parameters by their Modelica names, of one group, wheelset or bogie (`J[2]`) or of all (`J`), SI; missing
            ones have the values of the prediction's classes.

    Raises:
        ScenarioError: The sum of `wheelsets_per_bogie` is not the number of wheelsets.
    """
    parts = [_part(members, formation, data) for members in _members(formation, data)]
    body = _body()
    mass = sum(_mass(data, i) for i in range(formation.wheelsets))
    values = [mass if v.name == "m" else data.get(v.name, v.start) for v in body.parameters]
    return Consist(body=body, body_parameters=np.array(values), parts=parts)


def central_of(
    formation: Formation, data: Mapping[str, float], class_name: str = "ConsistPrediction"
) -> CentralPrediction:
    """Return one prediction for the whole train, of a class of `CENTRAL`.

    Other arguments, bogies and errors are those of `consist_of`.
    """
    parts = [part for part in _members(formation, data) if part.bogies]
    members = _Members(
        tuple(range(formation.groups)),
        tuple(bogie for part in parts for bogie in part.bogies),
        tuple(wheelset for part in parts for wheelset in part.wheelsets),
    )
    sizes = members.sizes(formation)
    model = _model(class_name, *sizes)
    return CentralPrediction(
        source=_source(class_name, *sizes),
        model=model,
        parameters=members.parameters(model, formation, data),
        readings=tuple(members.name_in_train(variable.name) for variable in model.outputs),
    )


def start_of(
    states: Sequence[str], formation: Formation, data: Mapping[str, float], speed: float
) -> NDArray[np.float64]:
    """Return the initial mean: rolling at a speed [m/s], nominal pad friction, all other states zero; shape (n,)."""
    start = {"speed": speed}
    for g in range(formation.groups):
        start[f"wheelset_speed[{g + 1}]"] = speed / radius_of(data, g)
        start[f"pad_friction[{g + 1}]"] = _value(data, _PAD_FRICTION, g, 0.35)
    return np.array([start.get(state, 0.0) for state in states])


def radius_of(data: Mapping[str, float], group: int) -> float:
    """Return the rolling radius of a group [m]."""
    return _value(data, "r_wheel", group, np.nan)


def release_pressure(data: Mapping[str, float], group: int, pad_force: float) -> float:
    """Return the cylinder pressure [Pa] at which both pads of a unit of a group press with a force [N]."""
    area, rigging, efficiency, spring = (
        _value(data, name, group, np.nan) for name in ("A_piston", "i_rigging", "eta_rigging", "F_spring")
    )
    return pressure_of(pad_force, piston_area=area, spring_force=spring, rigging=rigging * efficiency)


def _mass(data: Mapping[str, float], wheelset: int) -> float:
    return _value(data, "m_wheelset", wheelset, np.nan)


def _value(data: Mapping[str, float], name: str, index: int, default: float) -> float:
    return data.get(f"{name}[{index + 1}]", data.get(name, default))


def _members(formation: Formation, data: Mapping[str, float]) -> list[_Members]:
    """Return the parts of a train: bogies of two wheelsets with known frames, and the groups outside such bogies."""
    ends = np.cumsum([0, *_wheelsets_per_bogie(formation, data)]).tolist()
    group_of, per_group = formation.group_of_wheelset.tolist(), formation.wheelsets_per_group
    parts: list[_Members] = []
    for bogie, (first, end) in enumerate(pairwise(ends)):
        groups = tuple(dict.fromkeys(group_of[first:end]))
        has_frames = all(f"{name}[{bogie + 1}]" in data or name in data for name in ("m_frame", "I_frame", "wheelbase"))
        if end - first == 2 and has_frames and sum(per_group[g] for g in groups) == 2:
            parts.append(_Members(groups, (bogie,), (first, first + 1)))
    alone = set(range(formation.groups)).difference(*(members.groups for members in parts))
    parts += [_Members((g,)) for g in alone]
    return sorted(parts, key=lambda members: members.groups)


def _wheelsets_per_bogie(formation: Formation, data: Mapping[str, float]) -> list[int]:
    names = sorted(
        (name for name in data if name.startswith("wheelsets_per_bogie[")), key=lambda name: ElementName.of(name).place
    )
    if names:
        counts = [int(data[name]) for name in names]
        if sum(counts) != formation.wheelsets:
            raise ScenarioError(
                f"wheelsets_per_bogie has {sum(counts)} wheelsets, {counts}; the vehicle has {formation.wheelsets}"
            )
        return counts
    frames = sum(name.startswith("m_frame[") for name in data)
    return [2] * frames if 2 * frames == formation.wheelsets else []


def _part(members: _Members, formation: Formation, data: Mapping[str, float]) -> Part:
    model = _model("PartPrediction", *members.sizes(formation))
    states = tuple(members.name_in_train(variable.name) for variable in model.states)
    return Part(
        model=model,
        parameters=np.array(list(members.parameters(model, formation, data).values())),
        states=states,
        inputs=tuple(members.name_in_train(variable.name) for variable in model.inputs[:-1]),
        readings=tuple(
            (name.replace("dz", "deflection"), name)
            for name in states
            if ElementName.of(name).array in ("wheelset_speed", "dz")
        ),
    )
