"""Nominal data of a vehicle as controllers and figures take them.

They come from the plant's Modelica class through its FMU; a scenario changes them for the controller in
[controller.parameters] and for the plant in [vehicle.parameters], so that the two may differ on purpose.
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from railgrip.controllers.brake import BrakeGroup
from railgrip.errors import ScenarioError
from railgrip.formation import Formation
from railgrip.trace.bound import Brake

GRAVITY = 9.81  # m/s2, as in RailBraking.Types

_OF_GROUPS = MappingProxyType(
    {
        "p_max": "Pa", "n_units": "1", "r_friction": "m", "r_wheel": "m", "J": "kg.m2",
        "A_piston": "m2", "i_rigging": "1", "eta_rigging": "1", "F_spring": "N",
    }
)  # fmt: skip
_MASS = "m_wheelset"


def units_of_nominal_data(formation: Formation) -> dict[str, str]:
    """Return parameter name → unit of all nominal data of a vehicle; a bare name is one value for all."""
    masses = {_MASS: "kg", "m": "kg"} | {f"{_MASS}[{i + 1}]": "kg" for i in range(formation.wheelsets)}
    return units_of_brakes(formation) | masses


def units_of_brakes(formation: Formation) -> dict[str, str]:
    """Return the same of its brakes and what turns with them."""
    each = {f"{name}[{g + 1}]": unit for name, unit in _OF_GROUPS.items() for g in range(formation.groups)}
    return {**_OF_GROUPS, **each}


def spread(parameters: Mapping[str, float], formation: Formation) -> dict[str, float]:
    """Return nominal data with one value for all given to each group or wheelset that has none of its own."""
    counts = dict.fromkeys(_OF_GROUPS, formation.groups) | {_MASS: formation.wheelsets}
    each = {f"{name}[{i + 1}]": parameters[name] for name, n in counts.items() if name in parameters for i in range(n)}
    return each | {name: value for name, value in parameters.items() if name not in counts}


def masses_of(parameters: Mapping[str, float], formation: Formation) -> NDArray[np.float64]:
    """Return the mass that each wheelset carries on the rail [kg]; a mass of the vehicle is shared alike.

    Raises:
        ScenarioError: A parameter is missing.
    """
    if "m" in parameters and f"{_MASS}[1]" not in parameters:
        return np.full(formation.wheelsets, parameters["m"] / formation.wheelsets)
    return _each(parameters, _MASS, formation.wheelsets)


def brake_of(parameters: Mapping[str, float], formation: Formation) -> Brake:
    """Return the brake equipment for the ideal bound.

    Raises:
        ScenarioError: A parameter is missing.
    """
    return Brake(**{name: _each(parameters, name, formation.groups) for name in _OF_GROUPS})


def brake_groups_of(parameters: Mapping[str, float], formation: Formation) -> tuple[BrakeGroup, ...]:
    """Return the brake equipment as a controller knows it, leading group first.

    Raises:
        ScenarioError: A parameter is missing or makes no brake.
    """
    brake = brake_of(parameters, formation)
    loads = formation.summed(masses_of(parameters, formation) * GRAVITY)
    try:
        return tuple(
            BrakeGroup(
                load=float(loads[g]),
                inertia=float(brake.J[g]),
                wheel_radius=float(brake.r_wheel[g]),
                units=float(brake.n_units[g]),
                friction_radius=float(brake.r_friction[g]),
                piston_area=float(brake.A_piston[g]),
                rigging=float(brake.i_rigging[g] * brake.eta_rigging[g]),
                spring_force=float(brake.F_spring[g]),
                pressure_max=float(brake.p_max[g]),
            )
            for g in range(formation.groups)
        )
    except ValueError as problem:
        raise ScenarioError(f"[controller.parameters]: {problem}") from problem


def _each(parameters: Mapping[str, float], name: str, count: int) -> NDArray[np.float64]:
    """Return the elements of an array of parameters, or one value for all."""
    if name in parameters:
        return np.full(count, parameters[name])
    return np.array([_value(parameters, f"{name}[{i + 1}]") for i in range(count)])


def _value(parameters: Mapping[str, float], name: str) -> float:
    try:
        return parameters[name]
    except KeyError:
        raise ScenarioError(
            f"[controller.parameters] lacks '{name}', and the plant does not offer it: give its value there."
        ) from None
