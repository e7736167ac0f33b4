"""The vehicle of a scenario, as its controller knows it and as it is.

Nominal data come from the plant's Modelica class through its FMU; a scenario changes them for the controller in
[controller.parameters] and for the plant in [vehicle.parameters], so that the two may differ on purpose.
"""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from itertools import count, takewhile
from math import isclose
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from railgrip.assemble.contact import compiled_contact
from railgrip.assemble.files import description_of, lowered, parameters_of, plant_description, recipe_file, units_of
from railgrip.assemble.sensors import readings_of
from railgrip.controllers.brake import BrakeGroup
from railgrip.errors import ScenarioError
from railgrip.faults.brake import isolated_groups, isolated_units
from railgrip.formation import Formation
from railgrip.loop.plausible import UNBOUNDED, Slowing, slowing_of
from railgrip.rolling_stock.files import load_train
from railgrip.scenario.faults import TRUTH_KEYS
from railgrip.scenario.file import NamedFile
from railgrip.scenario.kinds import Custom
from railgrip.scenario.parties import ControllerFmu
from railgrip.scenario.quantity import in_units
from railgrip.scenario.schema import Scenario
from railgrip.scenario.track import TrackForce, force_along, track_force_of
from railgrip.scenario.vehicle import FormationTable
from railgrip.signals import CURVE, EXTRA, PLANT, SENT, Layout, layout_of
from railgrip.trace.bound import Brake
from railgrip.trace.contact import Contact

GRAVITY = 9.81  # m/s2, as in RailBraking.Types

CATALOGUE = "TwoPartTrain"
"""The recipe whose parameters are the nominal data of a plant of the same formation that does not say its own."""

CATALOGUE_WITH_VALVES = "TwoPartTrainPneumatic"

VALVES = MappingProxyType({"T_fill": "s", "T_vent": "s", "dead_fill": "s", "dead_vent": "s"})
"""Parameters of a plant with valves: time constants and dead times of filling and venting; their units."""

COUNTS = "wheelsets_per_group"
DESCRIPTIVE = MappingProxyType(
    {COUNTS: "1", "wheelsets_per_car": "1", "wheelset_position": "m", "groups_per_valve": "1"}
)
"""Parameters of an FMU that only describe it, which are keys of [vehicle.formation], too; their units."""


class VehicleData:
    """What FMU, [vehicle], [controller.parameters], [truth] and [[faults]] say of a vehicle; each worked out once.

    Attributes:
        scenario: Whose vehicle it is.
        file: Description of the plant's FMU; of a plant in Python, which has none, an empty one.
        own: Numeric parameters of that FMU.
    """

    def __init__(self, scenario: Scenario) -> None:
        """Find the plant.

        Raises:
            ScenarioError: [vehicle] train names a file that is no train.
            FmuError: The plant is no FMU.
        """
        self.scenario, self.file = scenario, plant_description(scenario)
        self.own = parameters_of(self.file)

    @cached_property
    def formation(self) -> Formation:
        """What the FMU says of itself, else [vehicle.formation]; without brakes, and loads that only the FMU says.

        Where neither says how many wheelsets there are, the plant is taken for one like the catalogue train; its arrays
        tell if it is not.

        Raises:
            ScenarioError: FMU and table disagree, or either does with itself.
        """
        origin, file = f"{self.scenario.name}: [vehicle.formation]", self.file
        table = self.scenario.vehicle.formation or FormationTable()
        values: dict[str, tuple[float, ...]] = {}
        for name, unit in DESCRIPTIVE.items():
            own, entry = _array_of(self.own, name), getattr(table, name)
            if own and file.variables[f"{name}[1]"].unit_name not in (unit, ""):
                raise ScenarioError(
                    f"{file.file.name}: its parameter {name} is in '{file.variables[f'{name}[1]'].unit_name}'; by that "
                    f"name the harness takes '{unit}'"
                )
            if own and entry and own != tuple(entry):
                raise ScenarioError(
                    f"{origin} {name} is {list(entry)}, {file.file.name} has "
                    f"{[float(f'{value:g}') for value in own]}; leave it out"
                )
            values[name] = own or entry
        try:
            return Formation(
                tuple(map(int, values[COUNTS])) or catalogue_counts(),
                tuple(map(int, values["wheelsets_per_car"])),
                values["wheelset_position"],
                table.wheelset_load,
                groups_per_valve=tuple(map(int, values["groups_per_valve"])),
            )
        except ValueError as problem:
            raise ScenarioError(f"{origin if table.model_fields_set else file.file.name}: {problem}") from problem

    @cached_property
    def nominal(self) -> dict[str, float]:
        """Data that a controller may know: the plant's own, else those of [vehicle.formation].

        An FMU from outside has names of its own. What neither says is that of the catalogue train if the plant is
        alike, else left to [controller.parameters].

        Raises:
            ScenarioError: Plant and [vehicle.formation] disagree.
        """
        formation, where = self.formation, f"{self.scenario.name}: [vehicle.formation]"
        vehicle = self.scenario.vehicle
        table = vehicle.formation or FormationTable()
        entries = in_units(f"{where} brakes", table.brakes, units_of_brakes(formation))
        entries |= {f"m_wheelset[{i + 1}]": load / GRAVITY for i, load in enumerate(formation.wheelset_load)}
        entries = spread(entries, formation)
        if isinstance(vehicle.plant, NamedFile) or vehicle.own_class:
            catalogue = _catalogue()
            alike = formation.wheelsets_per_group == counts_of(catalogue)
            return (catalogue if alike else {}) | entries
        own = spread(self.own, formation)
        with suppress(ScenarioError):
            own |= {f"m_wheelset[{i + 1}]": mass for i, mass in enumerate(masses_of(self.own, formation).tolist())}
        for name, value in own.items():
            if name in entries and not isclose(entries[name], value, rel_tol=1e-3):
                key = "wheelset_load" if name.startswith("m_wheelset") else f"brakes {name}"
                raise ScenarioError(
                    f"{where} {key} says {name} = {entries[name]:g}, {self.file.file.name} has {value:g}; leave it "
                    "out, or change [vehicle.parameters] or [controller.parameters]"
                )
        return self.own | entries

    @cached_property
    def known(self) -> dict[str, float]:
        """Data as the controller knows them: `nominal`, changed by [controller.parameters].

        Raises:
            ScenarioError: Plant and [vehicle.formation] disagree, or a parameter is wrong.
        """
        formation, nominal, controller = self.formation, self.nominal, self.scenario.controller
        if isinstance(controller, ControllerFmu | Custom):
            return nominal
        units = units_of_nominal_data(formation)
        entries = {name: value for name, value in controller.parameters.items() if name in units}
        entries = in_units("[controller.parameters]", entries, units)
        nominal = spread(nominal, formation) | spread(entries, formation)
        if "m" in entries and not any(name.startswith("m_wheelset") for name in entries):
            each = entries["m"] / formation.wheelsets
            nominal |= {f"m_wheelset[{i + 1}]": each for i in range(formation.wheelsets)}
        return nominal

    @cached_property
    def valves(self) -> dict[str, float]:
        """Times of the valves as the controller knows them, by the names of `VALVES` [s].

        What neither the plant nor the file says is that of the catalogue train.
        """
        return _valves_of(self.known)

    @cached_property
    def true_valves(self) -> dict[str, float]:
        """The same as they are."""
        vehicle = self.scenario.vehicle
        foreign = isinstance(vehicle.plant, NamedFile) or vehicle.own_class
        return self.valves if foreign else _valves_of(self.true_parameters)

    @cached_property
    def controlled(self) -> Formation:
        """The vehicle as the controller knows it, whole: `formation` and `known`.

        Raises:
            ScenarioError: Something of it is missing, or FMU and file disagree.
        """
        formation, nominal = self.formation, self.known
        return replace(
            formation,
            wheelset_load=tuple(mass * GRAVITY for mass in masses_of(nominal, formation).tolist()),
            brakes=brake_groups_of(nominal, formation),
        )

    @cached_property
    def changes(self) -> dict[str, float]:
        """What [vehicle.parameters], [truth] and isolated brake units change of the FMU, in its units.

        None of them changes what controller, estimator and driver know.

        Raises:
            ScenarioError: There is no such parameter, its unit has another dimension, or it only describes the plant.
        """
        scenario, factors = self.scenario, self.scenario.truth.factors()
        vehicle = scenario.vehicle
        if vehicle.own_class:  # [vehicle.parameters] are arguments of the class
            if factors:
                key = TRUTH_KEYS.get(next(iter(factors)), "creep")
                raise ScenarioError(
                    f"{scenario.name}: [truth] {key} changes parameters of an FMU; the plant is a class of Python"
                )
            return {}
        fixed = next((name for name in vehicle.parameters if name.partition("[")[0] in DESCRIPTIVE), None)
        if fixed is not None:
            raise ScenarioError(
                f"[vehicle.parameters] {fixed} says how {self.file.file.name} is made and cannot be set; name another "
                "one"
            )
        changes = in_units("[vehicle.parameters]", vehicle.parameters, units_of(self.file))
        if not factors and not scenario.faults:
            return changes
        base = self.own | scenario.adhesion.polach.plant_parameters() | changes
        for name, each in factors.items():
            elements = [name] if name in base else [f"{name}[{i + 1}]" for i in range(len(_array_of(base, name)))]
            where = f"{scenario.name}: [truth] {TRUTH_KEYS.get(name, f'creep.{name}')}"
            if not elements:
                raise ScenarioError(f"{where} changes the parameter {name}, which the plant does not have")
            if len(each) not in (1, len(elements)):
                raise ScenarioError(f"{where} has {len(each)} factors, the plant has {len(elements)} of {name}")
            changes |= {element: base[element] * each[i % len(each)] for i, element in enumerate(elements)}
        return changes | isolated_units(scenario, self.formation, base)

    @cached_property
    def true_parameters(self) -> dict[str, float]:
        """All numeric parameters of the plant as it is."""
        return self.own | self.changes

    @cached_property
    def brake(self) -> Brake:
        """The brakes as they are, for the bound: those of a group that is isolated do nothing.

        Raises:
            ScenarioError: The plant does not show them.
        """
        brake = brake_of(self.true_parameters, self.formation)
        units = brake.n_units.copy()
        units[isolated_groups(self.scenario, self.formation)] = 0.0
        return replace(brake, n_units=units)

    @cached_property
    def mass(self) -> float | None:
        """Of the vehicle as it is [kg]; None where the plant does not say it."""
        with suppress(ScenarioError):
            return float(masses_of(self.true_parameters, self.formation).sum())
        return None

    @cached_property
    def slowing(self) -> Slowing:
        """Bounds of what slows the vehicle as it is, beside adhesion.

        A plant from outside may hide its mass, or call something else so; that of the controller stands for it.
        """
        if "drive_torque" in self.shown:
            return UNBOUNDED
        vehicle, own = self.scenario.vehicle, self.true_parameters
        known = self.mass if vehicle.recipe or vehicle.train else None
        brakes = 0.0 if vehicle.formation is None else vehicle.formation.track_brakes
        if vehicle.train is not None:
            brakes += load_train(vehicle.train.path).track_brake_force
        if known is None:
            believed = sum(self.controlled.wheelset_load) / GRAVITY
            return slowing_of(believed, is_known=False, track_brakes=brakes)
        drag = 0.5 * own.get("rho_air", 0.0) * own.get("c_drag", 0.0) * own.get("A_drag", 0.0)
        return slowing_of(known, is_known=True, drag=drag, track_brakes=brakes)

    @cached_property
    def track_force(self) -> TrackForce:
        """Force of the track, and of the gradient that nobody was told.

        Raises:
            ScenarioError: There is such a gradient, and the plant does not say its mass.
        """
        force, slope = track_force_of(self.scenario.track), self.scenario.truth.gradient
        if not slope:
            return force
        if self.mass is None:
            raise ScenarioError(
                f"{self.scenario.name}: [truth] gradient wants the mass of the plant, which does not say it; write "
                "[track] gradient with train_mass"
            )
        more = float(force_along(slope, 0.0, self.mass))
        return replace(force, forces=tuple(one + more for one in force.forces))

    @cached_property
    def shown(self) -> frozenset[str]:
        """Names of what the plant shows."""
        table = set(self.scenario.vehicle.map)
        available = {name.partition("[")[0] for name in self.file.variables} | table
        extra = table | (available & {name.partition("[")[0] for name in self.file.names("output")})
        return frozenset(
            {"slip"} | {s.name for s in PLANT if s.name in available} | {s.name for s in EXTRA if s.name in extra}
        )

    @cached_property
    def layout(self) -> Layout:
        """Of the vectors that the plant and the sensors exchange.

        Raises:
            ScenarioError: The sensors are to read what the plant does not show.
        """
        extra = tuple(s for s in EXTRA if s.name in self.shown)
        several = len(self.scenario.adhesion.curves) > 1
        readings = readings_of(self.scenario, self.shown)
        return layout_of(self.controlled, (*PLANT, *extra), readings, (*SENT, *CURVE) if several else SENT)

    @cached_property
    def curves(self) -> NDArray[np.float64]:
        """Polach's k_A, k_S, A and B [s/m] of the rail's creep curves as they are, shape (curves, 4).

        They are the scenario's, but for what [truth] says, and [vehicle.parameters] where there is one.

        Raises:
            ScenarioError: There are several, and [vehicle.parameters] gives another one for all of them.
        """
        curves = [curve.plant_parameters() for curve in self.scenario.adhesion.curves]
        if len(curves) == 1:
            return np.array([[self.changes.get(name, value) for name, value in curves[0].items()]])
        for name in curves[0].keys() & self.scenario.vehicle.parameters.keys():
            raise ScenarioError(
                f"{self.scenario.name}: [vehicle.parameters] {name} is of one creep curve, [adhesion] lays several; "
                "leave it out, or change all of them by [truth] creep"
            )
        factors = self.scenario.truth.factors()
        return np.array([[value * factors.get(name, (1.0,))[0] for name, value in curve.items()] for curve in curves])

    @cached_property
    def contact(self) -> Contact:
        """Adhesion as a function of slip, speed, load and mu0, with the first of the creep curves or others."""
        curve = dict(zip(self.scenario.adhesion.polach.plant_parameters(), self.curves[0].tolist(), strict=True))
        return self.contact_with(self.changes | curve)

    def contact_with(self, parameters: Mapping[str, float]) -> Contact:
        """Return the contact with parameters of the plant, of which those that the contact has are taken."""
        model = lowered("RailBraking.FMUs.ContactPoint")
        shape = self.scenario.adhesion.polach.plant_parameters()
        names = {variable.name for variable in model.parameters} - shape.keys()
        return compiled_contact(
            model,
            {name: value for name, value in parameters.items() if name in names},
            {name: parameters[name] for name in shape},
        )


def counts_of(parameters: Mapping[str, float]) -> tuple[int, ...]:
    """Return the number of wheelsets of each group that an FMU says it has; empty where it does not."""
    return tuple(map(int, _array_of(parameters, COUNTS)))


def catalogue_counts() -> tuple[int, ...]:
    """Return the number of wheelsets of each group of the catalogue train."""
    return counts_of(_catalogue())


def catalogue_brakes(groups: int) -> tuple[BrakeGroup, ...]:
    """Return brakes as the catalogue train has them, for a plant of so many groups that says nothing of its own."""
    nominal = _catalogue()
    brakes = brake_groups_of(nominal, Formation(counts_of(nominal)))
    return tuple(brakes[g % len(brakes)] for g in range(groups))


def _valves_of(parameters: Mapping[str, float]) -> dict[str, float]:
    """Return the times of the valves among parameters, means over groups that differ, else the catalogue train's."""
    own = {name: _array_of(parameters, name) for name in VALVES}
    times = {name: sum(each) / len(each) for name, each in own.items() if each}
    times |= {name: parameters[name] for name in VALVES if name in parameters}
    if times.keys() == VALVES.keys():
        return times
    catalogue = parameters_of(description_of(recipe_file(CATALOGUE_WITH_VALVES)))
    return {name: catalogue[name] for name in VALVES} | times


def _catalogue() -> dict[str, float]:
    return parameters_of(description_of(recipe_file(CATALOGUE)))


def _array_of(parameters: Mapping[str, float], name: str) -> tuple[float, ...]:
    names = (f"{name}[{i}]" for i in count(1))
    return tuple(parameters[element] for element in takewhile(parameters.__contains__, names))


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
    return {**_OF_GROUPS, **each, **VALVES}


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
    return _elements(parameters, _MASS, formation.wheelsets)


def brake_of(parameters: Mapping[str, float], formation: Formation) -> Brake:
    """Return the brake equipment for the ideal bound.

    Raises:
        ScenarioError: A parameter is missing.
    """
    return Brake(**{name: _elements(parameters, name, formation.groups) for name in _OF_GROUPS})


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


def _elements(parameters: Mapping[str, float], name: str, count: int) -> NDArray[np.float64]:
    """Return the elements of an array of parameters, or one value for all."""
    if name in parameters:
        return np.full(count, parameters[name])
    elements = [f"{name}[{i + 1}]" for i in range(count)]
    missing = next((element for element in elements if element not in parameters), None)
    if missing is not None:
        raise ScenarioError(
            f"[controller.parameters] lacks '{missing}', and the plant does not offer it: give its value there."
        )
    return np.array([parameters[element] for element in elements])
