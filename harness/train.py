"""The catalogue train: nominal data of the vehicle as controllers and figures take them.

They come from the plant's Modelica class through its FMU; a scenario changes them for the controller in
[controller.parameters] and for the plant in [vehicle.parameters], so that the two may differ on purpose.
"""

from collections.abc import Mapping
from dataclasses import fields

import numpy as np

from controllers.brake import BrakeGroup
from harness.record.bound import Brake
from harness.record.signals import GROUPS
from harness.scenario.adhesion import GROUP_OF_WHEELSET
from harness.scenario.error import ScenarioError

GRAVITY = 9.81  # m/s2, as in RailBraking.Types


def brake_of(parameters: Mapping[str, float]) -> Brake:
    """Return the brake equipment for the ideal bound.

    Raises:
        ScenarioError: A parameter is missing.
    """
    scalars = ("A_piston", "i_rigging", "eta_rigging", "F_spring")
    values: dict[str, object] = {name: _value(parameters, name) for name in scalars}
    values |= {field.name: _each(parameters, field.name) for field in fields(Brake) if field.name not in scalars}
    return Brake(**values)  # pyright: ignore[reportArgumentType]  (floats and arrays by name, as the fields say)


def brake_groups_of(parameters: Mapping[str, float]) -> tuple[BrakeGroup, ...]:
    """Return the brake equipment as a controller knows it, leading group first.

    Raises:
        ScenarioError: A parameter is missing or makes no brake.
    """
    brake = brake_of(parameters)
    masses = np.array([_value(parameters, f"m_wheelset[{i + 1}]") for i in range(len(GROUP_OF_WHEELSET))])
    loads = np.bincount(np.array(GROUP_OF_WHEELSET), weights=masses * GRAVITY)
    try:
        return tuple(
            BrakeGroup(
                load=float(loads[g]),
                inertia=float(brake.J[g]),
                wheel_radius=float(brake.r_wheel[g]),
                units=float(brake.n_units[g]),
                friction_radius=float(brake.r_friction[g]),
                piston_area=brake.A_piston,
                rigging=brake.i_rigging * brake.eta_rigging,
                spring_force=brake.F_spring,
                pressure_max=float(brake.p_max[g]),
            )
            for g in range(GROUPS)
        )
    except ValueError as problem:
        raise ScenarioError(f"[controller.parameters]: {problem}") from problem


def _each(parameters: Mapping[str, float], name: str) -> np.ndarray:
    return np.array([_value(parameters, f"{name}[{g + 1}]") for g in range(GROUPS)])


def _value(parameters: Mapping[str, float], name: str) -> float:
    try:
        return parameters[name]
    except KeyError:
        raise ScenarioError(
            f"[controller.parameters] lacks '{name}', and the plant does not offer it: give its value there."
        ) from None
