"""A vehicle by the parameters of its plant: which there are, and what masses, brakes and valves follow from them.

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
"""Parameters of an FMU that only describe it, which are keys of [vehicle.formation], too; their units."""

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

_OF_RIGGING = {
    "i_rigging": ("1", "lever ratio of both pads"),
    "eta_rigging": ("1", "efficiency of the rigging"),
}
_OF_GROUPS = {parameter: BRAKE[datum][0] for datum, parameter in OF_BRAKES.items()} | dict.fromkeys(_OF_RIGGING, "1")
_MASS = "m_wheelset"


@dataclass(frozen=True, eq=False)
class VehicleParameters:
    """A vehicle by its parameters: nominal, as controller and estimator assume it, or true, as it runs.

    Attributes:
        wheelsets: Which there are and where, without loads and brakes.
        parameters: Numeric ones of the plant.
        isolated: Zero-based groups whose brake is isolated.
        required: Data of its brakes that a part of the stop uses; others may be missing from the formation.
    """

    wheelsets: Formation
    parameters: Mapping[str, float]
    isolated: tuple[int, ...] = ()
    required: frozenset[str] = frozenset(BRAKE)

    @cached_property
    def formation(self) -> Formation:
        """The same with loads and brakes.

        Raises:
            ScenarioError: Parameters are missing, all of them in one sentence, or make no brake.
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
        """The brake of each group; None for one that is isolated, or whose spring holds the pistons back.

        Raises:
            ScenarioError: A parameter is missing.
        """

        def works(group: int, data: Mapping[str, float]) -> bool:
            pressed = data["pressure_max"] * data["piston_area"] > data["spring_force"]
            return pressed and data["units"] > 0 and group not in self.isolated

        # Not every plant declares its masses, and the load on its wheels is not needed of a true brake.
        load = np.full(self.wheelsets.groups, np.inf) if self.mass is None else self.wheelsets.sum_by_group(self.load)
        return tuple(
            Brake(load=float(load[group]), **data) if works(group, data) else None
            for group, data in enumerate(self._brake_data(missing=None))
        )

    @cached_property
    def masses(self) -> NDArray[np.float64]:
        """Mass that each wheelset carries on the rail [kg]; a mass of the vehicle is shared alike.

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
        """Of the vehicle [kg]; None if the parameters do not define it."""
        with suppress(ScenarioError):
            return float(self.masses.sum())
        return None

    @cached_property
    def valves(self) -> dict[str, float]:
        """Times of the valves by the names of `VALVES`, means over groups that differ [s]; those that are known."""
        each = {name: array_of(self.parameters, name) for name in VALVES}
        means = {name: sum(times) / len(times) for name, times in each.items() if times}
        return means | {name: self.parameters[name] for name in VALVES if name in self.parameters}

    def _require_data(self) -> None:
        """Refuse a vehicle of which data are missing that somebody asks for.

        Raises:
            ScenarioError: All that is missing, each with its key, unit and meaning.
        """
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
                "the plant does not say: write them there, a value for all or a list; `railgrip map` prints the lines "
                "of an FMU"
            )

    def _has(self, name: str, count: int) -> bool:
        return name in self.parameters or all(f"{name}[{i + 1}]" in self.parameters for i in range(count))

    def _brake_data(self, missing: float | None = nan) -> list[dict[str, float]]:
        """Data of `Brake` for each group, without its load; `missing` replaces missing values; None refuses them."""
        groups = self.wheelsets.groups
        data = {datum: self._elements(parameter, groups, missing) for datum, parameter in OF_BRAKES.items()}
        ratio, efficiency = (self._elements(parameter, groups, missing) for parameter in _OF_RIGGING)
        data["rigging"] = ratio * efficiency
        return [{datum: float(values[group]) for datum, values in data.items()} for group in range(groups)]

    def _elements(self, name: str, count: int, missing: float | None = None) -> NDArray[np.float64]:
        """Return the elements of an array of parameters, or one value for all; see `_brake_data`."""
        if name in self.parameters:
            return np.full(count, self.parameters[name])
        elements = [f"{name}[{i + 1}]" for i in range(count)]
        lacking = next((element for element in elements if element not in self.parameters), None)
        if lacking is not None and missing is None:
            raise ScenarioError(f"[vehicle.formation] lacks '{lacking}', and the plant does not offer it")
        return np.array([self.parameters.get(element, missing) for element in elements], dtype=np.float64)


def meanings_of_brakes(data: Collection[str] = frozenset(BRAKE)) -> dict[str, str]:
    """Return parameter → meaning with unit, "rolling radius [m]", of these data of a `Brake`, its load left out."""
    parameters = {OF_BRAKES[datum]: BRAKE[datum] for datum in OF_BRAKES if datum in data}
    if "rigging" in data:
        parameters |= _OF_RIGGING
    return {name: meaning if unit == "1" else f"{meaning} [{unit}]" for name, (unit, meaning) in parameters.items()}


def array_of(parameters: Mapping[str, float], name: str) -> tuple[float, ...]:
    """Return the elements of an array of parameters; empty without such an array."""
    names = (f"{name}[{i}]" for i in count(1))
    return tuple(parameters[element] for element in takewhile(parameters.__contains__, names))


def counts_of(parameters: Mapping[str, float]) -> tuple[int, ...]:
    """Return the number of wheelsets of each group that an FMU says it has; empty where it does not."""
    return tuple(map(int, array_of(parameters, COUNTS)))


def masses_by_name(masses: NDArray[np.float64]) -> dict[str, float]:
    """Return the masses on the wheelsets [kg] by the names of their parameters."""
    return {f"{_MASS}[{i + 1}]": mass for i, mass in enumerate(masses.tolist())}


def units_of_nominal_data(formation: Formation) -> dict[str, str]:
    """Return parameter name → unit of all nominal data of a vehicle; a bare name is one value for all."""
    masses = {_MASS: "kg", "m": "kg"} | {f"{_MASS}[{i + 1}]": "kg" for i in range(formation.wheelsets)}
    return units_of_brakes(formation) | masses


def units_of_brakes(formation: Formation) -> dict[str, str]:
    """Return the same of its brakes and what turns with them."""
    each = {f"{name}[{g + 1}]": unit for name, unit in _OF_GROUPS.items() for g in range(formation.groups)}
    return {**_OF_GROUPS, **each, **VALVES}


def with_each(parameters: Mapping[str, float], formation: Formation) -> dict[str, float]:
    """Return nominal data, with a common value for each group or wheelset without an individual one."""
    counts = dict.fromkeys(_OF_GROUPS, formation.groups) | {_MASS: formation.wheelsets}
    each = {f"{name}[{i + 1}]": parameters[name] for name, n in counts.items() if name in parameters for i in range(n)}
    return each | {name: value for name, value in parameters.items() if name not in counts}
