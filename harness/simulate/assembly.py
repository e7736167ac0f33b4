"""The parts of a scenario's stop, open and ready for a loop."""

from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from railgrip.base.errors import PlantFailed, ScenarioError
from railgrip.base.programs import versions
from railgrip.controllers.sampled import Sampled
from railgrip.fmi import Description, shared_budget
from railgrip.fmi.plant import SteppedPlant
from railgrip.report.stop import Stop
from railgrip.scenario.adhesion import TabulatedRail
from railgrip.scenario.demand import driver_of
from railgrip.scenario.onboard import KalmanFilter
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario
from railgrip.simulate.bound_plant import fmu_plant, require_python_plant
from railgrip.simulate.controller import (
    ForeignController,
    exceeds_driver,
    law_states,
    open_controller,
    train_level_of,
    valve_logic_of,
)
from railgrip.simulate.estimator import state_estimator
from railgrip.simulate.faults.site import faults_of
from railgrip.simulate.loop.interfaces import Clock, LoopController, Parts, StateEstimator
from railgrip.simulate.loop.loop import Ending, Loop
from railgrip.simulate.loop.plausible import Plausibility
from railgrip.simulate.remarks import remarks_after, remarks_before, remarks_on_use, remarks_on_vehicle, target_of
from railgrip.simulate.user_parts import NO_CUSTOM_PARTS, CustomController, CustomParts, UserParts
from railgrip.simulate.value_checks import DemandLimits
from railgrip.simulate.vehicle_data import Opening, VehicleData
from railgrip.trace.measures import over_the_rail
from railgrip.trace.metrics import measure
from railgrip.trace.recorder import Recorder
from railgrip.vehicle.signals import (
    CONTROLLER_DEMAND,
    DRIVER_DEMAND,
    ESTIMATES,
    REFERENCE,
    TRACTION,
    Signal,
    plant_inputs,
)

_MAXIMUM_UTILISATION = 1.002
"""Used adhesion over that at the peak of the creep curve, beyond which the plant is wrong.

The peak itself is found to 1e-10. Between instants 10 ms apart it is a straight line, which is wrong by as much as one
likes where friction changes in between; beyond the limit it is found at every sample. What remains is the contact of a
plant that solves its equations approximately, or has loads that it does not output.
"""


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
    limits: DemandLimits
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
        stop, remarks = evaluate_stop(self.vehicle, self.recorder, ending, self.fmus), self.remarks
        if stop.outcome is Outcome.STANDSTILL:
            # A stop that ended early has not reached all parts of its scenario.
            scenario, metrics = self.vehicle.scenario, stop.metrics
            late = remarks_after(scenario, metrics.duration, metrics.distance_travelled)
            remarks = [*remarks, *late, *remarks_on_use(scenario, metrics)]
        controller = self.parts.controller
        stepped = (self.parts.plant, controller.fmu if isinstance(controller, ForeignController) else None)
        return replace(
            stop,
            classes=self.classes,
            reason=stop.reason + self.limits.sentence(-(-ending.samples // self.parts.clock.controller)),
            limited_demands=self.limits.limited,
            remarks=tuple(remarks),
            fmu_warnings={
                part.file: part.warnings for part in stepped if isinstance(part, SteppedPlant) and part.warnings
            },
        )


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
    with scenario.name_errors(), shared_budget(), ExitStack() as stack:
        vehicle = VehicleData(scenario)
        formation, layout = vehicle.nominal.formation, vehicle.layout
        radius = tuple(group.wheel_radius for group in formation.brakes)
        clock, user = _clock(scenario), UserParts(objects, scenario, layout)
        vehicle.require_pad_friction()
        vehicle.require_known_forces()
        remarks = [*remarks_before(scenario), *remarks_on_vehicle(vehicle)]
        for sentence in remarks:
            notify(sentence)
        opening, plant = Opening(vehicle, notify, stack), user.plant()
        plant = fmu_plant(opening) if plant is None else require_python_plant(vehicle, plant)
        filter_, estimates = user.estimator(), frozenset[str]()
        if filter_ is not None:
            estimates = frozenset(filter_.provides)
        elif isinstance(scenario.estimator, KalmanFilter):
            filter_ = state_estimator(opening, scenario.estimator)
            estimates = frozenset(signal.name.removeprefix("estimate_") for signal in ESTIMATES)
        law = user.controller()
        is_object = isinstance(law, CustomController)
        controller, commands_valves = (law, False) if is_object else open_controller(opening, estimates, law)
        limits = DemandLimits(formation, law.place if is_object else "The controller")
        is_limited = not commands_valves and not isinstance(controller, Sampled)
        _require_estimates(scenario, controller, estimates)
        states = law_states(controller)
        of_controller = (*(() if commands_valves else CONTROLLER_DEMAND), *(() if states is None else states.signals))
        signals = _signals(vehicle, of_controller, filter_, estimates)
        parts = Parts(
            layout=layout,
            plant=plant,
            rail=_rail(vehicle, controller),
            sensors=user.sensors() or scenario.sensors.open(scenario, layout, radius[0]),
            estimator=filter_,
            controller=controller,
            limits=limits if is_limited else None,
            train_level=train_level_of(vehicle) if is_limited else None,
            valves=None if commands_valves else valve_logic_of(vehicle),
            full=formation.pressure_max,
            driver=None
            if scenario.demand is None
            else driver_of(layout, scenario.demand, clock.period, binding=not exceeds_driver(scenario.controller)),
            faults=faults_of(scenario, layout, vehicle.outputs),
            wheel_radius=radius,
            law=states,
            clock=clock,
            plausibility=Plausibility(layout, clock.period, scenario.start.speed, vehicle.slowing),
            stop_speed=scenario.limits.stop_speed,
            recorder=Recorder(signals, formation, min(capacity or clock.samples + 1, clock.samples + 1)),
        )
        yield StopAssembly(
            vehicle=vehicle, parts=parts, fmus=opening.fmus, classes=user.classes, limits=limits, remarks=remarks
        )


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


def _signals(
    vehicle: VehicleData, of_controller: Sequence[Signal], filter_: object, estimates: Collection[str]
) -> tuple[Signal, ...]:
    layout, scenario = vehicle.layout, vehicle.scenario
    return (
        *layout.signals["output"],
        *plant_inputs(layout, pneumatic=scenario.actuation.kind == "pneumatic"),
        *layout.signals["reading"],
        *of_controller,
        *(DRIVER_DEMAND if scenario.demand is not None else ()),
        *(TRACTION if scenario.has_traction else ()),
        *(REFERENCE if isinstance(filter_, StateEstimator) and filter_.free_wheel else ()),
        *(signal for signal in ESTIMATES if signal.name.removeprefix("estimate_") in estimates),
    )


def _require_estimates(scenario: Scenario, controller: LoopController, estimates: Collection[str]) -> None:
    missing = [name for name in getattr(controller, "needs", ()) if name not in estimates]
    if missing:
        choice = ", ".join(sorted(estimates)) or "nothing"
        raise ScenarioError(
            f"[controller] '{scenario.controller.kind}' needs estimates of {' and '.join(missing)}, [estimator] "
            f"'{scenario.estimator.kind}' provides {choice}"
        )


def evaluate_stop(vehicle: VehicleData, recorder: Recorder, ending: Ending, fmus: Mapping[str, Description]) -> Stop:
    """Return the stop of a run of the loop, with ideal bound and metrics."""
    scenario = vehicle.scenario
    trace = recorder.trace(max(ending.samples, 1), scenario.periods.communication)
    # The bound uses the true data: the plant's own brakes and the scenario's creep curve. A foreign plant without brake
    # outputs has no bound; metrics that require it are empty.
    with suppress(ScenarioError):
        bound = partial(vehicle.bound, trace, contact=vehicle.contact)
        trace = bound()
        if over_the_rail(trace) > _MAXIMUM_UTILISATION:
            trace = bound(stride=0.0)
    share = over_the_rail(trace)
    if ending.outcome is Outcome.STANDSTILL and share > _MAXIMUM_UTILISATION:
        ending = Ending(
            outcome=Outcome.IMPLAUSIBLE,
            reason=f"The plant used {100 * share:.1f} % of the adhesion at the peak of the creep curve, and more than "
            "100 % is impossible: its contact is not that of [adhesion] polach, or it counts a force as adhesion that "
            "does not act between wheel and rail.",
            samples=ending.samples,
        )
    metrics = measure(
        trace,
        outcome=ending.outcome,
        alpha_max=scenario.limits.alpha_max,
        actuation=scenario.actuation.kind,
        target=target_of(scenario),
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
