"""The parts of a scenario's stop, open and ready for a loop."""

from collections.abc import Callable, Collection, Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from railgrip.base.errors import PlantFailed, ScenarioError
from railgrip.base.programs import versions
from railgrip.base.registry import Role
from railgrip.controllers.sampled import Sampled
from railgrip.fmi import Description, shared_budget
from railgrip.fmi.plant import SteppedPlant
from railgrip.report.stop import Stop
from railgrip.scenario.adhesion import TabulatedRail
from railgrip.scenario.demand import Driver, phases_of
from railgrip.scenario.kinds import Custom
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.parts import CustomLaw, KalmanFilter
from railgrip.scenario.schema import Scenario
from railgrip.scenario.seed import generator
from railgrip.scenario.sensors import OwnSensors
from railgrip.scenario.vehicle import PythonClass, Vehicle
from railgrip.simulate import custom
from railgrip.simulate.controller import exceeds_driver, law_states, open_controller, train_level_of, valve_logic_of
from railgrip.simulate.estimator import state_estimator
from railgrip.simulate.faults.site import faults_of
from railgrip.simulate.foreign_controller import ForeignController
from railgrip.simulate.importing import origin_of, part_of, table_of
from railgrip.simulate.loop.loop import Ending, Loop
from railgrip.simulate.loop.parts import (
    Clock,
    LoopController,
    LoopPlant,
    LoopSensors,
    Parts,
    SensorsInC,
    StateEstimator,
)
from railgrip.simulate.loop.plausible import Plausibility
from railgrip.simulate.plant import fmu_plant, python_plant
from railgrip.simulate.remarks import remarks_after, remarks_before, remarks_on_pressures
from railgrip.simulate.vehicle import VehicleData
from railgrip.trace.bound import with_bound
from railgrip.trace.measures import over_the_rail
from railgrip.trace.metrics import measure
from railgrip.trace.recorder import Recorder
from railgrip.vehicle.signals import DEMANDED, DRIVEN, ESTIMATES, REFERENCE, TRACTION, Signal, plant_inputs

_MAXIMUM_UTILISATION = 1.005
"""Used adhesion over that at the peak of the creep curve; the peak is found to 1e-5, and 10 ms apart."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CustomParts:
    """User-defined objects that replace parts of a scenario; see `railgrip.simulate.custom`.

    Attributes:
        controller, estimator, sensors, plant: None keeps the part of the scenario.
        folders: Folders that are searched for modules of a scenario, in addition to the installed environment.
    """

    controller: custom.Controller | None = None
    estimator: custom.Estimator | None = None
    sensors: custom.Sensors | None = None
    plant: custom.Plant | None = None
    folders: tuple[Path, ...] = ()

    def declare_in(self, scenario: Scenario) -> Scenario:
        """Return the scenario with these objects' classes in its tables, which results of a stop must name."""
        tables: dict[str, Any] = {}
        if self.controller is not None:
            over = {name: getattr(scenario.controller, name) for name in ("redistribute", "shared_valve")}
            tables["controller"] = table_of(self.controller, CustomLaw, **over)
        if self.estimator is not None:
            tables["estimator"] = table_of(self.estimator)
        if self.sensors is not None:
            tables["sensors"] = table_of(self.sensors, OwnSensors)
        if self.plant is not None:
            vehicle = {"plant": table_of(self.plant).kind, "formation": scenario.vehicle.formation}
            tables["vehicle"] = Vehicle.model_validate(vehicle)
        return scenario.model_copy(update=tables)


NO_CUSTOM_PARTS = CustomParts()
"""Only the parts that the scenario names."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StopAssembly:
    """The opened parts of a stop.

    Attributes:
        vehicle: Data of the scenario's vehicle.
        parts: Parts for the loop.
        fmus: FMUs of the stop, by name.
        classes: Origin of user-defined classes, by part; see `origin_of`.
        limits: Limits on the demands of a controller that is not built-in.
        remarks: Sentences on unusual values; see `railgrip.simulate.remarks`.
    """

    vehicle: VehicleData
    parts: Parts
    fmus: Mapping[str, Description]
    classes: Mapping[str, Mapping[str, Any]]
    limits: custom.DemandLimits
    remarks: Sequence[str]

    @property
    def recorder(self) -> Recorder:
        """Recorder that the loop writes to."""
        return self.parts.recorder

    def run(self, progress: Callable[[float], None] | None = None) -> Ending:
        """Run the stop to its end, once.

        Args:
            progress: Called with the train speed [m/s] at intervals.
        """
        try:
            return Loop(self.parts, progress).run()
        except PlantFailed as problem:
            return self.failed(problem)

    def failed(self, problem: PlantFailed) -> Ending:
        """Return the end of a run whose plant failed."""
        return Ending(outcome=Outcome.PLANT_FAILED, reason=str(problem), samples=self.recorder.written)

    def stop(self, ending: Ending) -> Stop:
        """Return the stop of a run of the loop."""
        # A plant that fails to start leaves one row, which must not show the old contents of the memory.
        self.recorder.rows[self.recorder.written : 1] = np.nan
        stop = evaluate_stop(self.vehicle, self.recorder, ending, self.fmus)
        return replace(
            stop,
            classes=self.classes,
            reason=stop.reason + self.limits.sentence(-(-ending.samples // self.parts.clock.controller)),
            limited_demands=self.limits.limited,
            remarks=self.remarks_on(stop),
            fmu_warnings={fmu.file: fmu.warnings for fmu in self._steppers() if fmu.warnings},
        )

    def remarks_on(self, stop: Stop) -> tuple[str, ...]:
        """Return the remarks on the scenario, and those on parts of it that a complete stop did not reach."""
        if stop.outcome is not Outcome.STANDSTILL:
            return tuple(self.remarks)
        metrics = stop.metrics
        return *self.remarks, *remarks_after(self.vehicle.scenario, metrics.duration, metrics.distance_travelled)

    def _steppers(self) -> Iterator[SteppedPlant]:
        """Yield the FMUs that are stepped."""
        controller = self.parts.controller
        for part in (self.parts.plant, controller.fmu if isinstance(controller, ForeignController) else None):
            if isinstance(part, SteppedPlant):
                yield part


@contextmanager
def assemble(
    scenario: Scenario,
    notify: Callable[[str], None] = lambda sentence: None,
    objects: CustomParts = NO_CUSTOM_PARTS,
    capacity: int | None = None,
) -> Generator[StopAssembly]:
    """Open the parts of a scenario's stop; they are closed when the block ends.

    Args:
        notify: Called with sentences for the user, such as that a foreign FMU runs in a separate process.
        objects: Objects that replace parts of the scenario.
        capacity: Rows of the recorder; None for all samples.

    Raises:
        ScenarioError: The scenario requires something that its parts cannot do.
        FmuError: An FMU does not fit.
    """
    scenario = objects.declare_in(scenario)
    vehicle = VehicleData(scenario)
    fmus = {} if isinstance(scenario.vehicle.source, PythonClass) else {vehicle.file.file.name: vehicle.file}
    formation, layout = vehicle.nominal.formation, vehicle.layout
    radius = tuple(group.wheel_radius for group in formation.brakes)
    clock, user_objects = _clock(scenario), _UserObjects(objects)
    vehicle.require_pad_friction()
    remarks = [*remarks_before(scenario), *remarks_on_pressures(vehicle)]
    for sentence in remarks:
        notify(sentence)
    with shared_budget(), ExitStack() as stack:
        plant = _plant(vehicle, user_objects, stack, notify)
        filter_, estimates = _estimator(vehicle, user_objects, fmus, stack, notify)
        if (law := user_objects.part("controllers", scenario.controller, objects.controller)) is not None:
            controller, commands_valves = custom.CustomController(law, formation), False
        else:
            controller, commands_valves = open_controller(vehicle, estimates, fmus, notify, stack)
        place = controller.place if isinstance(controller, custom.CustomController) else "The controller"
        limits = custom.DemandLimits(formation, place)
        is_limited = not commands_valves and not isinstance(controller, Sampled)
        _require_estimates(scenario, controller, estimates)
        _require_demand(scenario, commands_valves=commands_valves)
        law = law_states(controller)
        of_controller = (*(() if commands_valves else DEMANDED), *(() if law is None else law.signals))
        signals = _signals(vehicle, of_controller, filter_, estimates)
        parts = Parts(
            layout=layout,
            plant=plant,
            rail=_rail(vehicle, controller),
            sensors=_sensors(vehicle, user_objects, radius[0]),
            estimator=filter_,
            controller=controller,
            limits=limits if is_limited else None,
            train_level=train_level_of(vehicle) if is_limited else None,
            valves=None if commands_valves else valve_logic_of(vehicle),
            driver=_driver(vehicle),
            faults=faults_of(
                scenario,
                layout,
                formation.brakes,
                outputs=vehicle.outputs,
                valves=scenario.actuation.kind == "pneumatic",
            ),
            wheel_radius=radius,
            law=law,
            clock=clock,
            plausibility=Plausibility(layout, clock.period, scenario.start.speed, vehicle.slowing),
            stop_speed=scenario.limits.stop_speed,
            recorder=Recorder(signals, formation, min(capacity or clock.samples + 1, clock.samples + 1)),
        )
        yield StopAssembly(
            vehicle=vehicle, parts=parts, fmus=fmus, classes=user_objects.classes, limits=limits, remarks=remarks
        )


@dataclass(frozen=True, slots=True)
class _UserObjects:
    """The user-defined objects among the parts of a stop.

    Attributes:
        objects: Objects that the caller provided.
        classes: Origin of each, by part; see `origin_of`.
    """

    objects: CustomParts
    classes: dict[str, dict[str, Any]] = field(default_factory=dict[str, dict[str, Any]])

    def part(self, role: Role, table: object, instance: object) -> Any:
        if not isinstance(table, Custom):
            return None
        user_object = part_of(table, role, self.objects.folders) if instance is None else instance
        self.classes[role if role == "sensors" else role.removesuffix("s")] = origin_of(user_object, table.parameters)
        return user_object


def _clock(scenario: Scenario) -> Clock:
    period = scenario.periods.communication
    return Clock(
        period=period,
        estimator=scenario.periods.steps_of("estimator"),
        controller=scenario.periods.steps_of("controller"),
        samples=round(scenario.horizon / period),
        sensors=scenario.sensors.sampled_every(period),
    )


def _rail(vehicle: VehicleData, controller: LoopController) -> TabulatedRail:
    """Return the rail of a scenario; a law that demands sand switches the sanders on it."""
    rail = vehicle.rail()
    demand = controller.visible_state("sand") if isinstance(controller, Sampled) else None
    if rail.sand is not None and demand is not None:
        rail.sand.follow(demand)
    return rail


def _plant(
    vehicle: VehicleData, user_objects: _UserObjects, stack: ExitStack, notify: Callable[[str], None]
) -> LoopPlant:
    source, plant = vehicle.scenario.vehicle.source, user_objects.objects.plant
    if not isinstance(source, PythonClass):
        return fmu_plant(vehicle, notify, stack)
    arguments = {key: value.entry for key, value in vehicle.scenario.vehicle.parameters.items()}
    table = Custom(kind=source.name, parameters=arguments) if plant is None else table_of(plant)
    return python_plant(vehicle, user_objects.part("plants", table, plant))


def _estimator(
    vehicle: VehicleData,
    user_objects: _UserObjects,
    fmus: dict[str, Description],
    stack: ExitStack,
    notify: Callable[[str], None],
) -> tuple[StateEstimator | custom.CustomEstimator | None, frozenset[str]]:
    scenario = vehicle.scenario
    if (estimator := user_objects.part("estimators", scenario.estimator, user_objects.objects.estimator)) is not None:
        custom_estimator = custom.CustomEstimator(estimator, vehicle.nominal.formation)
        return custom_estimator, frozenset(custom_estimator.provides)
    if isinstance(scenario.estimator, KalmanFilter):
        filter_ = state_estimator(vehicle, scenario.estimator, fmus, stack, notify)
        return filter_, frozenset(signal.name.removeprefix("estimate_") for signal in ESTIMATES)
    return None, frozenset()


def _sensors(vehicle: VehicleData, user_objects: _UserObjects, radius: float) -> LoopSensors | SensorsInC:
    """Return the sensors of a stop; `radius` is that of the leading wheels [m]."""
    scenario = vehicle.scenario
    if (instruments := user_objects.part("sensors", scenario.sensors, user_objects.objects.sensors)) is None:
        return scenario.sensors.open(scenario, vehicle.layout, radius)
    noise = generator(scenario.seed, "sensors.custom")
    period = scenario.periods.communication
    return custom.CustomSensors(instruments, vehicle.layout, vehicle.nominal.formation, period, noise)


def _driver(vehicle: VehicleData) -> Driver:
    """Return the driver of a scenario, who uses the nominal data of the brakes; errors are those of `phases_of`."""
    scenario, layout = vehicle.scenario, vehicle.layout
    brakes, demand = layout.formation.brakes, scenario.demand
    full = np.array([brake.pressure_max for brake in brakes])
    return Driver(
        layout, scenario.periods.communication, full=full,
        release_pressure=np.array([brake.pressure_of(0.0) for brake in brakes]),
        phases=None if demand is None else phases_of(layout, demand, full.tolist(), scenario.name),
        binding=not exceeds_driver(scenario),
    )  # fmt: skip


def _signals(
    vehicle: VehicleData, of_controller: Sequence[Signal], filter_: object, estimates: Collection[str]
) -> tuple[Signal, ...]:
    layout, demand = vehicle.layout, vehicle.scenario.demand
    return (
        *layout.signals["output"],
        *plant_inputs(layout, pneumatic=vehicle.scenario.actuation.kind == "pneumatic"),
        *layout.signals["reading"],
        *of_controller,
        *(DRIVEN if demand is not None else ()),
        *(TRACTION if demand is not None and demand.has_traction else ()),
        *(REFERENCE if isinstance(filter_, StateEstimator) and filter_.free_wheel else ()),
        *(signal for signal in ESTIMATES if signal.name.removeprefix("estimate_") in estimates),
    )


def _require_demand(scenario: Scenario, *, commands_valves: bool) -> None:
    if commands_valves and scenario.demand is not None:
        raise ScenarioError(
            f"{scenario.name}: [demand] limits the pressures that a controller demands, but that of [controller] "
            "commands the valves; leave out [demand], or let it give demand [Pa]"
        )


def _require_estimates(scenario: Scenario, controller: LoopController, estimates: Collection[str]) -> None:
    missing = [name for name in getattr(controller, "needs", ()) if name not in estimates]
    if missing:
        choice = ", ".join(sorted(estimates)) or "nothing"
        raise ScenarioError(
            f"{scenario.name}: [controller] '{scenario.controller.kind}' needs estimates of {' and '.join(missing)}, "
            f"[estimator] '{scenario.estimator.kind}' provides {choice}"
        )


def evaluate_stop(vehicle: VehicleData, recorder: Recorder, ending: Ending, fmus: Mapping[str, Description]) -> Stop:
    """Return the stop of a run of the loop, with ideal bound and metrics."""
    scenario = vehicle.scenario
    trace = recorder.trace(max(ending.samples, 1), scenario.periods.communication)
    # The bound uses the true data: the plant's own brakes and the scenario's creep curve. A foreign plant without brake
    # outputs has no bound; metrics that require it are empty.
    with suppress(ScenarioError):
        trace = with_bound(
            trace, vehicle.contact, vehicle.true.brakes, scenario.limits.alpha_max, vehicle.resistance_lever
        )
    share = over_the_rail(trace)
    if ending.outcome is Outcome.STANDSTILL and share > _MAXIMUM_UTILISATION:
        ending = Ending(
            outcome=Outcome.IMPLAUSIBLE,
            reason=f"The plant used {100 * share:.1f} % of the adhesion at the peak of the creep curve; more than "
            "100 % cannot be: its contact is not that of [adhesion] polach.",
            samples=ending.samples,
        )
    metrics = measure(
        trace, outcome=ending.outcome, alpha_max=scenario.limits.alpha_max, actuation=scenario.actuation.kind
    )
    since = (
        "" if scenario.demand is None else f" {metrics.distance_travelled:.2f} m of that since the first brake demand."
    )
    return Stop.of(
        scenario,
        trace,
        outcome=ending.outcome,
        reason=ending.reason + since,
        metrics=metrics,
        versions=versions() | {name: description.generator for name, description in fmus.items()},
        fmus={name: description.digest for name, description in fmus.items()},
    )
