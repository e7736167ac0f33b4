"""The prediction of a train made from its nominal data, for any formation."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from railgrip.assemble.vehicle import GRAVITY
from railgrip.cache import keep
from railgrip.errors import ScenarioError
from railgrip.estimators.consist import Consist, Part
from railgrip.fmus.native import Model, Variable, lower
from railgrip.formation import Formation

_PACKAGE = "RailBraking.Vehicles"
_OF_WHEELSETS = frozenset({"m_unsprung", "dz", "ddz", "deflection"})
_OF_BOGIES = frozenset({"m_frame", "I_frame", "wheelbase", "h_frame", "h_rod", "k_primary", "c_primary"})
_PAD_FRICTION = "mu_b_nominal"


@cache
def _body() -> Model:
    return lower(f"{_PACKAGE}.BodyPrediction")


@cache
def _part_model(groups: int, group_of_wheelset: tuple[int, ...]) -> Model:
    """Return a part of some groups; the wheelsets of its bogies belong to these, counted from one."""
    text = (
        f'block Part "Part of a train"\n  extends {_PACKAGE}.PartPrediction(final n_groups={groups}, '
        f"final n_bogies={len(group_of_wheelset) // 2}"
    )
    if group_of_wheelset:
        text += f", final group_of_wheelset={{{', '.join(map(str, group_of_wheelset))}}}"
    text += ");\nend Part;\n"
    return lower("Part", keep("modelica", sha256(text.encode()).hexdigest(), "Part.mo", text.encode()))


@dataclass(frozen=True, slots=True)
class _Members:
    """Zero-based groups of a part, and its bogies with a suspension and their wheelsets."""

    groups: tuple[int, ...]
    bogies: tuple[int, ...] = ()
    wheelsets: tuple[int, ...] = ()


def units_of_predictions() -> dict[str, str]:
    """Return the unit of every parameter that a prediction has, without indices."""
    models = _body(), _part_model(1, (1, 1))
    units = {v.name.partition("[")[0]: v.unit for model in models for v in model.parameters}
    return {name: unit for name, unit in units.items() if name not in ("m", "m_group")} | {_PAD_FRICTION: "1"}


def data_of(nominal: Mapping[str, float], formation: Formation) -> dict[str, float]:
    """Return what a prediction takes of a train: nominal data, and what the formation knows where they lack it."""
    bases = {name.partition("[")[0] for name in nominal}
    of_brakes = {
        "J": "inertia", "r_wheel": "wheel_radius", "n_units": "units", "r_friction": "friction_radius",
        "A_piston": "piston_area", "i_rigging": "rigging", "F_spring": "spring_force",
    }  # fmt: skip
    each = {
        f"{name}[{g + 1}]": float(getattr(brake, attribute))
        for name, attribute in of_brakes.items()
        if name not in bases
        for g, brake in enumerate(formation.brakes)
    }
    if "i_rigging" not in bases:  # the product with its efficiency
        each["eta_rigging"] = 1.0
    masses = {f"m_wheelset[{i + 1}]": load / GRAVITY for i, load in enumerate(formation.wheelset_load)}
    return dict(nominal) | each | masses


def consist_of(formation: Formation, data: Mapping[str, float]) -> Consist:
    """Return the prediction of a train.

    A bogie of two wheelsets whose frame is known is a part with its suspension; of every other group the load is
    static. Bogies are those of `wheelsets_per_bogie`, else of two wheelsets each where there are half as many frames.

    Args:
        formation: Wheelsets and groups.
        data: Parameter by the names of Modelica, of one group, wheelset or bogie (`J[2]`) or of all (`J`), SI; those
            that are missing are as in the prediction's classes.

    Raises:
        ScenarioError: `wheelsets_per_bogie` has another number of wheelsets.
    """
    parts = [_part(members, formation, data) for members in _members(formation, data)]
    body = _body()
    mass = sum(data[f"m_wheelset[{i + 1}]"] for i in range(formation.wheelsets))
    values = [mass if v.name == "m" else data.get(v.name, v.start) for v in body.parameters]
    return Consist(body=body, body_parameters=np.array(values), parts=parts)


def start_of(consist: Consist, formation: Formation, data: Mapping[str, float], speed: float) -> NDArray[np.float64]:
    """Return the mean at the start: rolling at a speed [m/s], pads as nominal, the rest at zero; shape (n,)."""
    mean = np.zeros(len(consist.states))
    mean[0] = speed
    for g in range(formation.groups):
        mean[consist.states.index(f"w[{g + 1}]")] = speed / radius_of(data, g)
        mean[consist.states.index(f"mu_b[{g + 1}]")] = _value(data, _PAD_FRICTION, g, 0.35)
    return mean


def radius_of(data: Mapping[str, float], group: int) -> float:
    """Return the rolling radius of a group [m]."""
    return _value(data, "r_wheel", group, np.nan)


def release_pressure(data: Mapping[str, float], group: int, pad_force: float) -> float:
    """Return the cylinder pressure [Pa] at which both pads of a unit of a group press with a force [N]."""
    area, rigging, efficiency, spring = (
        _value(data, name, group, np.nan) for name in ("A_piston", "i_rigging", "eta_rigging", "F_spring")
    )
    return (pad_force / (rigging * efficiency) + spring) / area


def _value(data: Mapping[str, float], name: str, index: int, default: float) -> float:
    return data.get(f"{name}[{index + 1}]", data.get(name, default))


def _members(formation: Formation, data: Mapping[str, float]) -> list[_Members]:
    """Return the parts of a train: bogies of two wheelsets with known frames, and the groups of no such bogie."""
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
    names = sorted((name for name in data if name.startswith("wheelsets_per_bogie[")), key=_number)
    if names:
        counts = [int(data[name]) for name in names]
        if sum(counts) != formation.wheelsets:
            raise ScenarioError(
                f"wheelsets_per_bogie has {sum(counts)} wheelsets, {counts}; the vehicle has {formation.wheelsets}"
            )
        return counts
    frames = sum(name.startswith("m_frame[") for name in data)
    return [2] * frames if 2 * frames == formation.wheelsets else []


def _number(name: str) -> int:
    return int(name.partition("[")[2][:-1])


def _part(members: _Members, formation: Formation, data: Mapping[str, float]) -> Part:
    group_of = formation.group_of_wheelset
    model = _part_model(len(members.groups), tuple(members.groups.index(group_of[i]) + 1 for i in members.wheelsets))

    def place(name: str) -> tuple[str, int]:
        base, bracket, _ = name.partition("[")
        of = members.bogies if base in _OF_BOGIES else members.wheelsets if base in _OF_WHEELSETS else members.groups
        return base, of[_number(name) - 1] if bracket else 0

    def parameter(variable: Variable) -> float:
        base, index = place(variable.name)
        if base == "m_group":
            return sum(data[f"m_wheelset[{i + 1}]"] for i in np.flatnonzero(group_of == index))
        return _value(data, base, index, variable.start)

    def whole(variable: Variable) -> str:
        base, index = place(variable.name)
        return f"{base}[{index + 1}]"

    states = tuple(whole(variable) for variable in model.states)
    reading_of = {"w": "wheelset_speed", "dz": "deflection"}
    pairs = ((state.partition("["), state) for state in states)
    return Part(
        model=model,
        parameters=np.array([parameter(variable) for variable in model.parameters]),
        states=states,
        inputs=tuple(whole(variable) for variable in model.inputs[:-1]),
        readings=tuple(
            (f"{reading_of[name]}[{index}", state) for (name, _, index), state in pairs if name in reading_of
        ),
    )
