"""A vehicle by the parameters of its plant: their names, and the masses, brakes and valves that follow from them.

Names are those of Modelica: `J[2]` is of one group or wheelset, `J` of all of them.
"""

from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import count, takewhile
from math import nan
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import ScenarioError
from railgrip.vehicle.brake import BRAKE, Brake
from railgrip.vehicle.formation import Formation, axle_load

COUNTS = "wheelsets_per_group"
DESCRIPTIVE = MappingProxyType(
    {COUNTS: "1", "wheelsets_per_car": "1", "wheelset_position": "m", "groups_per_valve": "1"}
)
"""Descriptive parameters of an FMU, which are also keys of [vehicle.formation], and their units."""

VALVES = MappingProxyType({"T_fill": "s", "T_vent": "s", "dead_fill": "s", "dead_vent": "s"})
"""Parameters of a plant with valves: time constants and dead times of filling and venting; their units."""

OF_BRAKES = MappingProxyType(
    {
        "pressure_max": "p_max",
        "units": "n_units",
        "friction_radius": "r_friction",
        "wheel_radius": "r_wheel",
        "inertia": "J",
        "piston_area": "A_piston",
        "spring_force": "F_spring",
    }
)
"""Datum of a `Brake` → parameter of the plant. `rigging` is the product of the two in `_OF_RIGGING`."""

_OF_RIGGING = {"i_rigging": ("1", "lever ratio of both pads"), "eta_rigging": ("1", "efficiency of the rigging")}
_OF_GROUPS = {parameter: BRAKE[datum][0] for datum, parameter in OF_BRAKES.items()} | dict.fromkeys(_OF_RIGGING, "1")
_MASS = "m_wheelset"


@dataclass(frozen=True, eq=False)
class VehicleParameters:
    """A vehicle by its parameters: nominal, as controller and estimator assume, or true, as simulated.

    Attributes:
        wheelsets: Groups and positions of the wheelsets, without loads and brakes.
        parameters: Numeric parameters of the plant.
        isolated: Zero-based indices of groups whose brake is isolated.
        required: Brake data that a part of the stop uses; others may be missing from the formation.
    """

    wheelsets: Formation
    parameters: Mapping[str, float]
    isolated: tuple[int, ...] = ()
    required: frozenset[str] = frozenset(BRAKE)

    @cached_property
    def formation(self) -> Formation:
        """Formation with loads and brakes.

        Raises:
            ScenarioError: Parameters are missing (the message lists all of them), or invalid for a brake.
        """
        self._require_data()
        try:
            load = self.wheelsets.sum_by_group(self.load).tolist()
            brakes = tuple(Brake(load=load[group], **data) for group, data in enumerate(self._brake_data()))
        except ValueError as problem:
            raise ScenarioError(f"[controller.parameters]: {problem}") from problem
        return replace(self.wheelsets, wheelset_load=tuple(self.load.tolist()), brakes=brakes)

    @cached_property
    def brakes(self) -> tuple[Brake | None, ...]:
        """Brake of each group; None if it is isolated, or if its spring holds the pistons back at full pressure.

        Raises:
            ScenarioError: A parameter is missing.
        """

        def works(group: int, data: Mapping[str, float]) -> bool:
            pressed = data["pressure_max"] * data["piston_area"] > data["spring_force"]
            return pressed and data["units"] > 0 and group not in self.isolated

        # Some plants do not declare their masses, and the true brake does not depend on the load.
        load = np.full(self.wheelsets.groups, np.inf) if self.mass is None else self.wheelsets.sum_by_group(self.load)
        return tuple(
            Brake(load=float(load[group]), **data) if works(group, data) else None
            for group, data in enumerate(self._brake_data(missing=None))
        )

    @cached_property
    def masses(self) -> NDArray[np.float64]:
        """Mass carried by each wheelset [kg]; a mass of the vehicle is divided equally.

        Raises:
            ScenarioError: A parameter is missing.
        """
        if "m" in self.parameters and f"{_MASS}[1]" not in self.parameters:
            return np.full(self.wheelsets.wheelsets, self.parameters["m"] / self.wheelsets.wheelsets)
        return self._elements(_MASS, self.wheelsets.wheelsets)

    @cached_property
    def load(self) -> NDArray[np.float64]:
        """Static force of each wheelset on the rail [N].

        Raises:
            ScenarioError: A parameter is missing.
        """
        return axle_load(self.masses)

    @cached_property
    def mass(self) -> float | None:
        """Mass of the vehicle [kg]; None if the parameters do not define it."""
        with suppress(ScenarioError):
            return float(self.masses.sum())
        return None

    @cached_property
    def valves(self) -> dict[str, float]:
        """Known times of the valves by the names of `VALVES` [s]; means if groups differ."""
        each = {name: array_of(self.parameters, name) for name in VALVES}
        means = {name: sum(times) / len(times) for name, times in each.items() if times}
        return means | {name: self.parameters[name] for name in VALVES if name in self.parameters}

    def _require_data(self) -> None:
        lacking: list[str] = []
        if "m" not in self.parameters and not self._has(_MASS, self.wheelsets.wheelsets):
            lacking.append("wheelset_load (static force of each wheelset on the rail [N])")
        brakes = [
            f"{name} ({meaning})"
            for name, meaning in meanings_of_brakes(self.required).items()
            if not self._has(name, self.wheelsets.groups)
        ]
        if brakes:
            lacking.append(f"brakes = {{ {', '.join(brakes)} }}")
        if lacking:
            raise ScenarioError(
                f"[vehicle.formation] lacks {' and '.join(lacking)}, which controller, estimator or driver need and "
                "the plant does not declare: give them there, one value or a list; `railgrip map` prints the lines "
                "of an FMU"
            )

    def _has(self, name: str, count: int) -> bool:
        return name in self.parameters or all(f"{name}[{i + 1}]" in self.parameters for i in range(count))

    def _brake_data(self, missing: float | None = nan) -> list[dict[str, float]]:
        groups = self.wheelsets.groups
        data = {datum: self._elements(parameter, groups, missing) for datum, parameter in OF_BRAKES.items()}
        ratio, efficiency = (self._elements(parameter, groups, missing) for parameter in _OF_RIGGING)
        data["rigging"] = ratio * efficiency
        return [{datum: float(values[group]) for datum, values in data.items()} for group in range(groups)]

    def _elements(self, name: str, count: int, missing: float | None = None) -> NDArray[np.float64]:
        if name in self.parameters:
            return np.full(count, self.parameters[name])
        elements = [f"{name}[{i + 1}]" for i in range(count)]
        lacking = next((element for element in elements if element not in self.parameters), None)
        if lacking is not None and missing is None:
            raise ScenarioError(f"[vehicle.formation] lacks '{lacking}', and the plant does not offer it")
        return np.array([self.parameters.get(element, missing) for element in elements], dtype=np.float64)


def meanings_of_brakes(data: Collection[str] = frozenset(BRAKE)) -> dict[str, str]:
    """Return parameter → meaning with unit, such as "rolling radius [m]", of data of a `Brake` except its load."""
    parameters = {OF_BRAKES[datum]: BRAKE[datum] for datum in OF_BRAKES if datum in data}
    if "rigging" in data:
        parameters |= _OF_RIGGING
    return {name: meaning if unit == "1" else f"{meaning} [{unit}]" for name, (unit, meaning) in parameters.items()}


def array_of(parameters: Mapping[str, float], name: str) -> tuple[float, ...]:
    """Return the elements of an array of parameters; empty without such an array."""
    names = (f"{name}[{i}]" for i in count(1))
    return tuple(parameters[element] for element in takewhile(parameters.__contains__, names))


def counts_of(parameters: Mapping[str, float]) -> tuple[int, ...]:
    """Return the number of wheelsets of each group that an FMU declares; empty if it does not."""
    return tuple(map(int, array_of(parameters, COUNTS)))


def masses_by_name(masses: NDArray[np.float64]) -> dict[str, float]:
    """Return the masses on the wheelsets [kg] by the names of their parameters."""
    return {f"{_MASS}[{i + 1}]": mass for i, mass in enumerate(masses.tolist())}


def units_of_nominal_data(formation: Formation) -> dict[str, str]:
    """Return parameter name → unit of all nominal data of a vehicle; a bare name is one value for all."""
    masses = {_MASS: "kg", "m": "kg"} | {f"{_MASS}[{i + 1}]": "kg" for i in range(formation.wheelsets)}
    return units_of_brakes(formation) | masses


def units_of_brakes(formation: Formation) -> dict[str, str]:
    """Return parameter name → unit of the nominal data of brakes and wheelsets."""
    each = {f"{name}[{g + 1}]": unit for name, unit in _OF_GROUPS.items() for g in range(formation.groups)}
    return {**_OF_GROUPS, **each, **VALVES}


def with_each(parameters: Mapping[str, float], formation: Formation) -> dict[str, float]:
    """Return nominal data, with a common value for each group or wheelset without an individual one."""
    counts = dict.fromkeys(_OF_GROUPS, formation.groups) | {_MASS: formation.wheelsets}
    each = {f"{name}[{i + 1}]": parameters[name] for name, n in counts.items() if name in parameters for i in range(n)}
    return each | {name: value for name, value in parameters.items() if name not in counts}
