"""The vehicle of a scenario, as its controller knows it and as it is simulated.

Nominal data come from the plant's Modelica class through its FMU; a scenario changes them for the controller in
[controller.parameters] and for the plant in [vehicle.parameters], so that the two may differ on purpose.
"""

from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import isclose

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip.base import registry
from railgrip.base.errors import ScenarioError
from railgrip.base.names import ElementName
from railgrip.base.units import unit
from railgrip.controllers.law import FULL_PRESSURE, GroupLaw
from railgrip.fmi import Description
from railgrip.fmus.native import Model
from railgrip.rolling_stock.schema import Train, load_train
from railgrip.scenario.adhesion import TabulatedRail, rail_of
from railgrip.scenario.faults import TRUTH_KEYS
from railgrip.scenario.onboard import BuiltInLaw as LawTable
from railgrip.scenario.onboard import ControllerFmu, KalmanFilter
from railgrip.scenario.quantity import in_units
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Custom
from railgrip.scenario.track import TrackForce, force_along, track_force_of
from railgrip.scenario.vehicle_table import (
    FormationTable,
    LibraryClass,
    LibraryPlant,
    ModelicaPlant,
    PythonClass,
    RecipePlant,
    TrainFile,
)
from railgrip.simulate.contact import compiled_contact
from railgrip.simulate.faults.brake import isolated_groups, isolated_units
from railgrip.simulate.loop.plausible import UNBOUNDED, Slowing, slowing_of
from railgrip.simulate.named_models import (
    COMPILED_IN,
    compile_class,
    description_of,
    parameters_of,
    plant_description,
    recipe_file,
    require_plant,
    units_of,
)
from railgrip.trace.bound import Contact, DynamicLimit, with_bound
from railgrip.vehicle.brake import (
    BRAKE,
    LOWEST_PAD_FRICTION,
    PRESSURE_OF_FORCE,
    Brake,
    air_resistance,
    lowest_friction,
    resistance_lever,
)
from railgrip.vehicle.formation import Formation, carried_mass
from railgrip.vehicle.parameters import (
    COUNTS,
    DESCRIPTIVE,
    VALVES,
    VehicleParameters,
    array_of,
    counts_of,
    masses_by_name,
    units_of_brakes,
    units_of_nominal_data,
    with_each,
)
from railgrip.vehicle.signals import (
    BRAKE_DEMAND,
    CAR_TRACK_FORCE,
    CURVE,
    EXTRA,
    MAGNETS,
    PLANT,
    PLANT_INPUTS,
    READINGS,
    Layout,
    Signal,
    layout_of,
)

CATALOGUE = "TwoPartTrain"
"""Recipe whose parameters are the nominal data of a plant of the same formation that declares none."""

CATALOGUE_WITH_VALVES = "TwoPartTrainPneumatic"

_MASS_TOLERANCE = 0.2
"""Maximum relative difference of two statements of the same mass: rotating parts and load explain some 10 %."""


class VehicleData:
    """Vehicle data from FMU, [vehicle], [controller.parameters], [truth] and [[faults]]; each item is computed once.

    Attributes:
        scenario: Scenario of the vehicle.
        file: Description of the plant's FMU; an empty one for a plant in Python, which has no FMU.
        fmu_parameters: Numeric parameters of that FMU.
    """

    def __init__(self, scenario: Scenario) -> None:
        """Read the description of the plant.

        Raises:
            ScenarioError: [vehicle] train names a file that is not a train file.
            FmuError: The plant is not an FMU, or an FMU that is not a plant for this scenario.
        """
        self.scenario = scenario
        with scenario.name_errors():
            self.file = plant_description(scenario)
            require_plant(scenario.vehicle, scenario.actuation.kind, self.file)
        self.fmu_parameters = parameters_of(self.file)

    @cached_property
    def formation(self) -> Formation:
        """Formation that the FMU declares, else [vehicle.formation]; without brakes, and with loads of the FMU only.

        If neither gives the number of wheelsets, the plant is assumed to be like the catalogue train; its arrays
        contradict if it is not.

        Raises:
            ScenarioError: FMU and table disagree, or either of them contradicts itself.
        """
        origin, file = f"{self.scenario.name}: [vehicle.formation]", self.file
        table = self.scenario.vehicle.formation or FormationTable()
        values: dict[str, tuple[float, ...]] = {}
        for name, descriptive_unit in DESCRIPTIVE.items():
            declared, entry = array_of(self.fmu_parameters, name), getattr(table, name)
            if declared and file.variables[f"{name}[1]"].unit not in (descriptive_unit, ""):
                raise ScenarioError(
                    f"{file.file.name}: its parameter {name} is in '{file.variables[f'{name}[1]'].unit}'; by that "
                    f"name the harness takes '{descriptive_unit}'"
                )
            if declared and entry and declared != tuple(entry):
                raise ScenarioError(
                    f"{origin} {name} is {list(entry)}, {file.file.name} has "
                    f"{[float(f'{value:g}') for value in declared]}; leave it out"
                )
            values[name] = declared or entry
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
    def declared(self) -> dict[str, float]:
        """Parameters that all parts know: those that the plant declares, else those of [vehicle.formation].

        A foreign FMU has different names. Missing values default to the catalogue train if the formation matches, else
        they are left to [controller.parameters].

        Raises:
            ScenarioError: Plant and [vehicle.formation] disagree.
        """
        formation, where = self.formation, f"{self.scenario.name}: [vehicle.formation]"
        vehicle = self.scenario.vehicle
        table = vehicle.formation or FormationTable()
        entries = in_units(f"{where} brakes", table.brakes, units_of_brakes(formation))
        if formation.load is not None:
            entries |= masses_by_name(carried_mass(formation.load))
        entries = with_each(entries, formation)
        is_compiled_here = isinstance(vehicle.source, ModelicaPlant)
        values = with_each(self.fmu_parameters, formation) if is_compiled_here else self._arrays_named_alike(entries)
        if is_compiled_here:
            with suppress(ScenarioError):
                values |= masses_by_name(VehicleParameters(formation, self.fmu_parameters).masses)
        for name, value in values.items():
            if name in entries and not isclose(entries[name], value, rel_tol=1e-3):
                key = "wheelset_load" if name.startswith("m_wheelset") else f"brakes {name}"
                raise ScenarioError(
                    f"{where} {key} says {name} = {entries[name]:g}, {self.file.file.name} has {value:g}; leave it "
                    "out, or change [vehicle.parameters] or [controller.parameters]"
                )
        if is_compiled_here:
            return self.fmu_parameters | entries
        catalogue = _catalogue()
        return (catalogue if formation.wheelsets_per_group == counts_of(catalogue) else {}) | entries

    def _arrays_named_alike(self, entries: Mapping[str, float]) -> dict[str, float]:
        """Return in SI units the array elements of a foreign FMU that have the name and dimension of an entry.

        Scalars are ignored, since they may mean something else: the J of a car body, or the m of a frame.
        """
        units = units_of_nominal_data(self.formation)
        values: dict[str, float] = {}
        for name in entries.keys() & self.fmu_parameters.keys():
            of_fmu = self.file.variables[name].defined_unit
            if "[" in name and of_fmu is not None and of_fmu.exponents == unit(units[name]).exponents:
                values[name] = of_fmu.factor * self.fmu_parameters[name] + of_fmu.offset
        return values

    @cached_property
    def nominal(self) -> VehicleParameters:
        """Nominal vehicle of controller, estimator and driver: as declared, with [controller.parameters].

        Raises:
            ScenarioError: Plant and [vehicle.formation] disagree, or a parameter is wrong.
        """
        formation, nominal, controller = self.formation, self.declared, self.scenario.controller
        if isinstance(controller, ControllerFmu | Custom):
            return VehicleParameters(formation, self._with_valves(nominal), required=self._required)
        units = units_of_nominal_data(formation)
        entries = {name: value for name, value in controller.parameters.items() if name in units}
        entries = in_units("[controller.parameters]", entries, units)
        nominal = with_each(nominal, formation)
        known = nominal | {"m": VehicleParameters(formation, nominal).mass or 0.0}
        for name, value in with_each(entries, formation).items():
            is_off = value and known.get(name) and not 0.1 <= value / known[name] <= 10.0
            if is_off:
                raise ScenarioError(
                    f"{self.scenario.name}: [controller.parameters] {name} is {value:g} {units[name]}, but the vehicle "
                    f"has {known[name]:g}; they may differ by a factor of 10. Correct the value or its unit."
                )
        nominal |= with_each(entries, formation)
        if "m" in entries and not any(name.startswith("m_wheelset") for name in entries):
            nominal |= masses_by_name(np.full(formation.wheelsets, entries["m"] / formation.wheelsets))
        return VehicleParameters(formation, self._with_valves(nominal), required=self._required)

    @property
    def _required(self) -> frozenset[str]:
        """Brake data that controller, estimator and driver use.

        A controller FMU gets no brake data. A user's class gets all that are known, and an error if it reads others;
        see `railgrip.simulate.user_parts`.
        """
        scenario, table = self.scenario, self.scenario.controller
        if isinstance(scenario.estimator, KalmanFilter) or table.redistribute:
            return frozenset(BRAKE)
        driver = PRESSURE_OF_FORCE if scenario.demand is not None and scenario.demand.has_target else frozenset[str]()
        if not isinstance(table, LawTable):
            return FULL_PRESSURE | driver
        law = law_named(table.kind)
        return frozenset(BRAKE) if law is None else law.brake_data | driver

    @cached_property
    def true(self) -> VehicleParameters:
        """The simulated vehicle. A foreign plant's valve times are the nominal ones.

        Raises:
            ScenarioError: A change of the plant's parameters is wrong.
        """
        vehicle, parameters = self.scenario.vehicle, self.fmu_parameters | self.changes
        if not isinstance(vehicle.source, ModelicaPlant):
            parameters |= self.nominal.valves
        with self.scenario.name_errors():
            isolated = isolated_groups(self.scenario.faults, self.formation)
        return VehicleParameters(self.formation, self._with_valves(parameters), tuple(isolated))

    def require_pad_friction(self) -> None:
        """Check that the law of pad friction of a built-in plant holds at the speeds and forces of the stop.

        Raises:
            ScenarioError: Friction falls below `LOWEST_PAD_FRICTION`.
        """
        known, names = self.true.parameters, ("speed_effect", "force_effect", "temperature_effect")
        if not isinstance(self.scenario.vehicle.source, RecipePlant) or not set(names) <= known.keys():
            return
        effects = {name: known[name] for name in names}
        effects |= {"speed_nominal": known["pad_speed_nominal"], "force_nominal": known["pad_force_nominal"]}
        for nominal, brake in zip(array_of(known, "mu_b_nominal"), self.true.brakes, strict=False):
            if brake is None:
                continue
            speed = self.scenario.start.speed * brake.friction_radius / brake.wheel_radius
            friction, v, force = lowest_friction(
                nominal, effects=effects, speed=speed, force=float(brake.pad_force(brake.pressure_max))
            )
            if friction <= LOWEST_PAD_FRICTION:
                raise ScenarioError(
                    f"{self.scenario.name}: [vehicle.parameters] speed_effect, force_effect, temperature_effect: pad "
                    f"friction falls to {friction:.3f} at {v:.3g} m/s of the pads and {force / 1e3:.3g} kN; the linear "
                    f"law holds only where friction is above {LOWEST_PAD_FRICTION:g}; reduce the effects"
                )

    @cached_property
    def train(self) -> Train | None:
        """Train of the train file of the scenario; None for other plants."""
        source = self.scenario.vehicle.source
        return load_train(source.file.path) if isinstance(source, TrainFile) else None

    @cached_property
    def dynamic_limits(self) -> Mapping[int, DynamicLimit]:
        """Dynamic brakes of the axles of a train file, by zero-based group."""
        train = self.train
        return {
            each.group: DynamicLimit(
                force=each.force_at,
                nominal_friction=0.0 if each.brake.blending == "added" else train.bogie_of(each.group).pad_friction,
                across=each.brake.blending == "train",
            )
            for each in (() if train is None else train.dynamic_groups)
            if train is not None
        }

    def require_known_forces(self) -> None:
        """Check that all parts know the brakes of the train.

        Raises:
            ScenarioError: Dynamic brakes are unknown to the estimator, or to the demand of the driver.
        """
        if not self.dynamic_limits:
            return
        name, scenario = self.scenario.name, self.scenario
        if isinstance(scenario.estimator, KalmanFilter):
            raise ScenarioError(
                f"{name}: [estimator] kind '{scenario.estimator.kind}' assumes that pressure alone brakes the axles, "
                "but [dynamic_brakes] of the train file do so, too: its adhesion would be too low; use [estimator] "
                "kind = 'none' with a controller that needs no estimates, or a filter of your own"
            )
        has_valves = scenario.actuation.kind == "pneumatic"
        if has_valves and scenario.demand is not None and BRAKE_DEMAND[0] not in self._demanded:
            raise ScenarioError(
                f"{name}: [demand] with [actuation] kind = 'pneumatic' acts through the dump valves, which "
                "[dynamic_brakes] of the train file do not know: they would brake for a full demand; use 'ideal', or "
                "give the train a [command]"
            )

    def _with_valves(self, parameters: dict[str, float]) -> dict[str, float]:
        """Return parameters with all valve times, if the plant has valves; missing ones are those of the catalogue
        train.

        Args:
            parameters: Parameters of the plant.
        """
        known = VehicleParameters(self.formation, parameters).valves
        if self.scenario.actuation.kind == "ideal" or known.keys() == VALVES.keys():
            return parameters
        catalogue = parameters_of(description_of(recipe_file(CATALOGUE_WITH_VALVES)))
        return {name: catalogue[name] for name in VALVES if name not in known} | parameters

    @cached_property
    def changes(self) -> dict[str, float]:
        """Changes of the FMU's parameters by [vehicle.parameters], [truth] and isolated brake units, in its units.

        These changes are unknown to controller, estimator and driver.

        Raises:
            ScenarioError: A parameter does not exist, its unit has another dimension, or it only describes the plant.
        """
        scenario, factors = self.scenario, self.scenario.truth.factors()
        vehicle = scenario.vehicle
        if isinstance(vehicle.source, PythonClass):  # [vehicle.parameters] are arguments of the class
            if factors:
                key = TRUTH_KEYS.get(next(iter(factors)), "creep")
                raise ScenarioError(
                    f"{scenario.name}: [truth] {key} changes parameters of an FMU; the plant is a class of Python"
                )
            return {}
        fixed = next((name for name in vehicle.parameters if ElementName.of(name).array in DESCRIPTIVE), None)
        if fixed is not None:
            raise ScenarioError(
                f"[vehicle.parameters] {fixed} says how {self.file.file.name} is made and cannot be set; name another "
                "one"
            )
        others = COMPILED_IN if isinstance(vehicle.source, LibraryClass) else ""
        changes = in_units("[vehicle.parameters]", vehicle.parameters, units_of(self.file), others=others)
        if not factors and not scenario.faults:
            return changes
        base = self.fmu_parameters | scenario.adhesion.polach.plant_parameters() | changes
        for name, each in factors.items():
            elements = [name] if name in base else [f"{name}[{i + 1}]" for i in range(len(array_of(base, name)))]
            where = f"{scenario.name}: [truth] {TRUTH_KEYS.get(name, f'creep.{name}')}"
            if not elements:
                raise ScenarioError(f"{where} changes the parameter {name}, which the plant does not have")
            if len(each) not in (1, len(elements)):
                raise ScenarioError(f"{where} has {len(each)} factors, the plant has {len(elements)} of {name}")
            changes |= {element: base[element] * each[i % len(each)] for i, element in enumerate(elements)}
        with scenario.name_errors():
            return changes | isolated_units(scenario.faults, self.formation, base)

    @cached_property
    def slowing(self) -> Slowing:
        """Bounds of the simulated vehicle's deceleration by other causes than adhesion.

        A foreign plant may hide its mass, or use its name otherwise; the controller's value is used instead.

        Raises:
            ScenarioError: `[vehicle.formation] track_brakes` contradicts the train file.
        """
        if "drive_torque" in self.outputs:
            return UNBOUNDED
        vehicle = self.scenario.vehicle
        known = self.true.mass if isinstance(vehicle.source, LibraryPlant) else None
        brakes = 0.0 if vehicle.formation is None else vehicle.formation.track_brakes
        if self.train is not None:
            of_train = self.train.track_brake_force
            if brakes and not isclose(brakes, of_train, rel_tol=1e-3):
                raise ScenarioError(
                    f"{self.scenario.name}: [vehicle.formation] track_brakes is {brakes:g} N, but the train file has "
                    f"{of_train:g} N; leave it out."
                )
            brakes = of_train
        if known is None:
            believed = carried_mass(sum(self.nominal.formation.wheelset_load))
            return slowing_of(believed, is_known=False, track_brakes=brakes)
        return slowing_of(known, is_known=True, drag=air_resistance(self.true.parameters), track_brakes=brakes)

    @property
    def resistance_lever(self) -> float:
        """Torque of bearings and rolling on a wheelset over its load [m], 0 if the plant does not model it."""
        return resistance_lever(self.true.parameters)

    @cached_property
    def mass(self) -> float:
        """Mass of the simulated vehicle [kg], on which gradients and curves act; 0 on a level, straight track.

        The mass of a foreign plant is that of `[vehicle.formation] wheelset_load`, else of its parameters, else of
        `[track] train_mass`.

        Raises:
            ScenarioError: The mass is not given, or `[track] train_mass` contradicts it.
        """
        scenario, track = self.scenario, self.scenario.track
        known, origin = self.true.mass, "the plant has"
        if self.formation.load is not None and not isinstance(scenario.vehicle.source, ModelicaPlant):
            known, origin = carried_mass(float(self.formation.load.sum())), "[vehicle.formation] wheelset_load gives"
        given = track.train_mass
        if given is not None and known is not None and abs(given / known - 1.0) > _MASS_TOLERANCE:
            raise ScenarioError(
                f"{scenario.name}: [track] train_mass is {given:g} kg, but {origin} {known:g} kg; they may differ by "
                f"{100 * _MASS_TOLERANCE:g} %. Leave out train_mass, or correct the mass of the vehicle."
            )
        if given is None and known is None and (track.is_inclined_or_curved or scenario.truth.gradient):
            raise ScenarioError(
                f"{scenario.name}: gradient, curve or plan act on the mass of the vehicle, which the plant does not "
                "give; write [vehicle.formation] wheelset_load or [track] train_mass"
            )
        return given or known or 0.0

    @cached_property
    def track_force(self) -> TrackForce:
        """Force of the track, including that of the gradient which the nominal data lack.

        Raises:
            ScenarioError: As for `mass`.
        """
        force, slope = track_force_of(self.scenario.track, self.mass), self.scenario.truth.gradient
        force = replace(force, forces=force.forces + force_along(slope, 0.0, self.mass))
        behind, masses = self.formation.position, self.formation.load
        if behind is None:
            return force
        if isinstance(self.scenario.vehicle.source, ModelicaPlant) and self.true.mass is not None:
            masses = self.true.masses
        masses = np.ones(behind.size) if masses is None else masses
        return replace(force, behind=behind, shares=masses / masses.sum())

    def rail(self) -> TabulatedRail:
        """Return the rail, before any wheel has passed; errors are those of `rail_of`.

        Sanders are those of the scenario, else those of its train file.
        """
        sanders = self.scenario.sanders or (() if self.train is None else self.train.sanders)
        return rail_of(self.scenario, self.layout, self.track_force, self.curves, sanders)

    @cached_property
    def outputs(self) -> frozenset[str]:
        """Names of the plant's outputs."""
        table = set(self.scenario.vehicle.map)
        available = {ElementName.of(name).array for name in self.file.variables} | table
        extra = table | (available & {ElementName.of(name).array for name in self.file.names("output")})
        return frozenset(
            {"slip"} | {s.name for s in PLANT if s.name in available} | {s.name for s in EXTRA if s.name in extra}
        )

    @cached_property
    def layout(self) -> Layout:
        """Layout of the vectors of plant and sensors.

        Raises:
            ScenarioError: The sensors require outputs that the plant lacks.
        """
        extra = tuple(s for s in EXTRA if s.name in self.outputs)
        several = len(self.scenario.adhesion.curves) > 1
        with self.scenario.name_errors():
            readings = (*READINGS, *self.scenario.sensors.extra_readings(self.outputs))
        has_cars = any(ElementName.of(name).array == "car_track_force" for name in self.file.names("input"))
        cars = CAR_TRACK_FORCE if has_cars and not self.track_force.is_even else ()
        sent = (*PLANT_INPUTS, *cars, *(CURVE if several else ()), *self._demanded)
        return layout_of(self.nominal.formation, output=(*PLANT, *extra), reading=readings, input=sent)

    @property
    def _demanded(self) -> tuple[Signal, ...]:
        """Inputs of the plant for demands; without [demand] and a law with one of its own it is an emergency brake."""
        has_demand = self.scenario.demand is not None
        exceeds_driver = law_exceeds_driver(self.scenario.controller.kind)
        possible = (*(MAGNETS if has_demand or exceeds_driver else ()),
                    *(BRAKE_DEMAND if has_demand and not exceeds_driver else ()))  # fmt: skip
        return tuple(signal for signal in possible if signal.name in self.file.names("input"))

    @cached_property
    def curves(self) -> NDArray[np.float64]:
        """Polach's k_A, k_S, A and B [s/m] of the rail's true creep curves, shape (curves, 4).

        They are those of the scenario, changed by [truth] and, if there is only one, by [vehicle.parameters].

        Raises:
            ScenarioError: There are several curves, and [vehicle.parameters] sets a single one.
        """
        curves = [curve.plant_parameters() for curve in self.scenario.adhesion.curves]
        if len(curves) == 1:
            return np.array([[self.changes.get(name, value) for name, value in curves[0].items()]])
        for name in curves[0].keys() & self.scenario.vehicle.parameters.keys():
            raise ScenarioError(
                f"{self.scenario.name}: [vehicle.parameters] {name} is for one creep curve, [adhesion] has several; "
                "leave it out, or change all of them by [truth] creep"
            )
        factors = self.scenario.truth.factors()
        return np.array([[value * factors.get(name, (1.0,))[0] for name, value in curve.items()] for curve in curves])

    @cached_property
    def contact(self) -> Contact:
        """Adhesion as a function of slip, speed, load and mu0, with the first creep curve as the default.

        Where friction falls with temperature, treads are as cold as the rail.
        """
        return compiled_contact(*self.contact_arguments())

    @property
    def bound(self) -> "partial[xarray.Dataset]":
        """`railgrip.trace.bound.with_bound` with the true brakes and limits; it takes a trace and `contact`."""
        return partial(
            with_bound,
            brakes=self.true.brakes,
            alpha_max=self.scenario.limits.alpha_max,
            resistance_lever=self.resistance_lever,
            dynamics=self.dynamic_limits,
        )

    def contact_arguments(
        self, parameters: Mapping[str, float] | None = None
    ) -> tuple[Model, dict[str, float], dict[str, float]]:
        """Return the arguments of `railgrip.simulate.contact.compiled_contact`.

        Args:
            parameters: Parameters of the plant, of which the contact has some; None for those of the scenario.
        """
        polach, detailed = self.scenario.adhesion.polach, self.scenario.truth.mechanics == "detailed"
        if parameters is None:
            curve = dict(zip(polach.plant_parameters(), self.curves[0].tolist(), strict=True))
            parameters = polach.contact_parameters() | self.changes | curve
        law = "Heated" if polach.temperature_loss else "Simplified" if detailed else ""
        model, shape = compile_class(f"RailBraking.FMUs.{law}ContactPoint"), polach.plant_parameters()
        names = {variable.name for variable in model.parameters} - shape.keys()
        of_wheel_and_rail = {name: value for name, value in parameters.items() if name in names}
        return model, of_wheel_and_rail, {name: parameters[name] for name in shape}


@dataclass(frozen=True, slots=True)
class Opening:
    """A stop whose parts are being opened.

    Attributes:
        vehicle: Vehicle of the stop.
        notify: Called with sentences for the user.
        stack: Closes the parts.
        fmus: Description of each FMU by a unique name, added when it is opened.
    """

    vehicle: VehicleData
    notify: Callable[[str], None]
    stack: ExitStack
    fmus: dict[str, Description] = field(default_factory=dict[str, Description])

    def add_fmu(self, description: Description, role: str) -> None:
        """Add an FMU; a name that is taken gets the role in front."""
        name = description.file.name
        self.fmus[f"{role}: {name}" if name in self.fmus else name] = description


def law_named(kind: str) -> type[GroupLaw] | None:
    """Return the built-in law of a kind; None if it is not one."""
    return registry.part(registry.LAWS, kind, GroupLaw) if kind in registry.modules(registry.LAWS) else None


def law_exceeds_driver(kind: str) -> bool:
    """Return whether a kind is a built-in law that forms demands from the driver's, and may exceed them."""
    law = law_named(kind)
    return law is not None and law.exceeds_driver


def catalogue_counts() -> tuple[int, ...]:
    """Return the number of wheelsets of each group of the catalogue train."""
    return counts_of(_catalogue())


def catalogue_brakes(groups: int) -> tuple[Brake, ...]:
    """Return the brakes of the catalogue train for a plant with `groups` groups that declares none; they repeat."""
    brakes = VehicleParameters(Formation(catalogue_counts()), _catalogue()).formation.brakes
    return tuple(brakes[g % len(brakes)] for g in range(groups))


def _catalogue() -> dict[str, float]:
    return parameters_of(description_of(recipe_file(CATALOGUE)))
