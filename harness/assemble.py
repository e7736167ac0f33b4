"""From a scenario to the parties of its stop: the only place that names concrete classes."""

import platform
from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from hashlib import sha256
from importlib.metadata import version
from itertools import count, takewhile
from math import inf, isclose
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
import xarray
from numpy.typing import NDArray

from railgrip import custom
from railgrip.cache import keep
from railgrip.contact import compiled_contact
from railgrip.controllers import tuning
from railgrip.controllers.adhesion_based import AdhesionBased, LiteralAdhesionBased
from railgrip.controllers.brake import BrakeGroup
from railgrip.controllers.constant_slip import ConstantSlip, ConstantSlipTuning
from railgrip.controllers.extremum_seeking import ExtremumSeeking, ExtremumSeekingTuning
from railgrip.controllers.free_wheel import FreeWheel
from railgrip.controllers.full_brake import FullBrake
from railgrip.controllers.law import Law, Tuning
from railgrip.controllers.sampled import Sampled
from railgrip.controllers.slip_based import SlipBased
from railgrip.controllers.slope_seeking import SlopeSeeking
from railgrip.controllers.train_level import with_redistribution, with_shared_valves
from railgrip.controllers.valves import ValveLogic, ValveModel
from railgrip.controllers.wheel_reference import WheelReference, WheelReferenceTuning
from railgrip.engine import Engine
from railgrip.errors import PlantFailed, ScenarioError
from railgrip.estimators.compiled import CompiledFilter
from railgrip.estimators.decentralised import DecentralisedFilter
from railgrip.estimators.ekf import ExtendedKalmanFilter
from railgrip.estimators.gate import Gate
from railgrip.estimators.prediction import CasadiPrediction
from railgrip.estimators.running import Running
from railgrip.estimators.tuning import NOISE_SETS, NoiseSet, pad_gate
from railgrip.faults import faults_of, isolated_groups, isolated_units
from railgrip.fmu import Description, FmuPrediction, Signal, bind, describe, open_plant
from railgrip.fmus.build import build_class, choose, fmu
from railgrip.fmus.native import Model, lower
from railgrip.fmus.native.library import library_of
from railgrip.foreign_controller import foreign_controller
from railgrip.formation import Formation
from railgrip.importing import Origin, origin_of, party_of, table_of
from railgrip.instruments import readings_of, sensors_of
from railgrip.limits import FMU_LIMITS, FmuLimits
from railgrip.loop import compiled_cycle, cycle
from railgrip.loop.actuation import Direct
from railgrip.loop.driver import Driver
from railgrip.loop.ended import Clock, Ended, implausible
from railgrip.loop.ports import Actuation, Controller, Filter, LawStates, Plant
from railgrip.loop.rail import Field, SandedRail, Sander, TabulatedRail
from railgrip.loop.watch import StateEstimator
from railgrip.prediction import consist_of, data_of, radius_of, release_pressure, start_of, units_of_predictions
from railgrip.rolling_stock.files import load_train
from railgrip.rolling_stock.modelica import class_name, class_text
from railgrip.scenario.adhesion import position_of, profile_of, reach_of
from railgrip.scenario.custom import Custom, Role
from railgrip.scenario.demand import phases_of
from railgrip.scenario.faults import TRUTH_KEYS
from railgrip.scenario.file import NamedFile
from railgrip.scenario.parties import ControllerFmu, KalmanFilter, SlipLaw
from railgrip.scenario.parties import Law as ParametricLaw
from railgrip.scenario.quantity import in_units
from railgrip.scenario.schema import Scenario
from railgrip.scenario.seed import generator
from railgrip.scenario.sensors import ServiceSensors, sampled_every
from railgrip.scenario.track import STEEPEST, TrackForce, force_along, track_force_of
from railgrip.scenario.vehicle import FormationTable, Nudge, Vehicle
from railgrip.signals import (
    DEMANDED,
    DRIVEN,
    ESTIMATES,
    EXTRA,
    PLANT,
    REFERENCE,
    TRACTION,
    Layout,
    layout_of,
    of_law,
    sent,
)
from railgrip.trace.adhesion_use import over_the_rail
from railgrip.trace.bound import Brake, with_bound
from railgrip.trace.contact import Contact
from railgrip.trace.metrics import measure
from railgrip.trace.motion import braking_distance as distance_of
from railgrip.trace.motion import since_brake_demand
from railgrip.trace.outcome import Outcome
from railgrip.trace.recorder import Recorder
from railgrip.trace.stop import Stop
from railgrip.train import GRAVITY, brake_groups_of, brake_of, masses_of, spread, units_of_brakes, units_of_nominal_data
from railgrip.trial import Finding, findings, tried
from railgrip.units import Unit

Vector = NDArray[np.float64]

CATALOGUE = "TwoPartTrain"
"""The recipe whose parameters are the nominal data of a plant of the same formation that does not say its own."""

NEEDED = frozenset({"distance", "speed", "acceleration", "wheelset_speed", "cylinder_pressure"})
"""Outputs no plant can do without; others, such as true adhesion, stay empty in the trace where a plant lacks them."""

_MOST_OF_THE_RAIL = 1.005
"""Used adhesion over that at the peak of the creep curve; the peak is found to 1e-5, and 10 ms apart."""

_COUNTS = "wheelsets_per_group"
_FORMATION = MappingProxyType(
    {_COUNTS: "1", "wheelsets_per_car": "1", "wheelset_position": "m", "groups_per_valve": "1"}
)
"""Parameters of an FMU that only describe it, which are keys of [vehicle.formation], too; their units."""

_PACKAGES = ("railgrip", "casadi", "fmpy", "numpy", "rumoca", "scipy", "xarray")


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnParties:
    """Objects of the user's own that take the place of what a scenario names; see `railgrip.custom`.

    Attributes:
        controller, estimator, sensors, plant: None leaves it to the scenario.
        folders: Where modules that a scenario names are looked for, beside the installed environment.
    """

    controller: custom.Controller | None = None
    estimator: custom.Estimator | None = None
    sensors: custom.Sensors | None = None
    plant: custom.Plant | None = None
    folders: tuple[Path, ...] = ()

    def standing_for(self, scenario: Scenario) -> Scenario:
        """Return the scenario that names these objects' classes, as the results of a stop with them must."""
        given = {"controller": self.controller, "estimator": self.estimator, "sensors": self.sensors}
        tables: dict[str, Any] = {name: table_of(own) for name, own in given.items() if own is not None}
        if self.plant is not None:
            vehicle = {"plant": table_of(self.plant).kind, "formation": scenario.vehicle.formation}
            tables["vehicle"] = Vehicle.model_validate(vehicle)
        return scenario.model_copy(update=tables)


SCENARIOS_OWN = OwnParties()
"""None but those that the scenario names."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Assembled:
    """The parties of a stop, open.

    Attributes:
        parties: Arguments of the loops, but for the controller.
        controller: Of the scenario.
        obstacle: Why C cannot run it; None if it can.
    """

    scenario: Scenario
    parties: Mapping[str, Any]
    controller: Controller
    obstacle: str | None
    plant_file: Description
    fmus: Mapping[str, Description]
    classes: Mapping[str, Origin]

    @property
    def recorder(self) -> Recorder:
        """What the loop writes into."""
        return self.parties["recorder"]

    def failed(self, problem: PlantFailed) -> Ended:
        """Return the end of a run whose plant failed."""
        return Ended(outcome=Outcome.PLANT_FAILED, reason=str(problem), samples=self.recorder.written)

    def stop(self, ended: Ended) -> Stop:
        """Return the stop that a run of the loop gave."""
        # A plant that does not even start leaves one row without a number: rows are memory as it was found.
        self.recorder.rows[self.recorder.written : 1] = np.nan
        stop = judged(self.scenario, self.recorder, ended, self.plant_file, self.fmus)
        return replace(stop, classes={name: origin.to_plain() for name, origin in self.classes.items()})


def run_stop(
    scenario: Scenario,
    progress: Callable[[float], None] | None = None,
    tell: Callable[[str], None] = lambda sentence: None,
    engine: Engine = Engine.AUTO,
    own: OwnParties = SCENARIOS_OWN,
) -> Stop:
    """Run a scenario and return its stop.

    Args:
        scenario: What to run.
        progress: Called with the train speed [m/s] now and then.
        tell: Gets sentences for the user, such as that a foreign FMU runs in a process of its own.
        engine: What steps the parties; the stop is the same.
        own: Objects in place of what the scenario names.

    Raises:
        ScenarioError: The scenario asks for something that its parties cannot do.
        FmuError: An FMU does not fit; nothing was run.
    """
    if scenario.controller.kind in ("ideal_bound", "ideal_tracking") and own.controller is None and own.plant is None:
        from railgrip.ideal import ideal_stop, tracking_stop  # it needs this module to run its stops

        return (ideal_stop if scenario.controller.kind == "ideal_bound" else tracking_stop)(scenario, progress)
    with assembled(scenario, tell, own) as parts:
        ended = _run(parts, progress, engine)
    return parts.stop(ended)


def braking_distance(scenario: Scenario) -> float | None:
    """Return only the distance [m], None where the train does not come to stand: for searches over many stops."""
    ended, trace = _unjudged(scenario)
    return distance_of(since_brake_demand(trace)) if ended.outcome is Outcome.STANDSTILL else None


def trace_of(scenario: Scenario) -> xarray.Dataset:
    """Return only what happened, without the ideal bound: for studies of many stops, three times as fast.

    Raises:
        ScenarioError: The run ended with a failure.
    """
    ended, trace = _unjudged(scenario)
    if ended.outcome not in (Outcome.STANDSTILL, Outcome.HORIZON):
        raise ScenarioError(f"{scenario.name}: ended with {ended.outcome.value}: {ended.reason}")
    return trace


def _unjudged(scenario: Scenario) -> tuple[Ended, xarray.Dataset]:
    with assembled(scenario) as parts:
        ended = _run(parts, None, Engine.AUTO)
    return ended, parts.recorder.trace(max(ended.samples, 1), scenario.periods.communication)


def _run(parts: Assembled, progress: Callable[[float], None] | None, engine: Engine) -> Ended:
    if parts.obstacle and engine is Engine.COMPILED:
        raise ScenarioError(f"{parts.scenario.name}: the compiled engine cannot run it: {parts.obstacle}; take 'auto'.")
    loop = cycle.run if parts.obstacle or engine is Engine.PYTHON else compiled_cycle.run
    try:
        return loop(controller=parts.controller, progress=progress, **parts.parties)
    except PlantFailed as failed:
        return parts.failed(failed)


@contextmanager
def assembled(
    scenario: Scenario, tell: Callable[[str], None] = lambda sentence: None, own: OwnParties = SCENARIOS_OWN
) -> Generator[Assembled]:
    """Open the parties of a scenario's stop; they are closed when the block ends.

    Raises:
        ScenarioError: The scenario asks for something that its parties cannot do.
        FmuError: An FMU does not fit.
    """
    scenario = own.standing_for(scenario)
    plant_file = plant_description(scenario)
    fmus = {} if scenario.vehicle.own_class else {plant_file.file.name: plant_file}
    formation = controlled_formation(scenario)
    layout, groups = layout_of_plant(scenario, plant_file, formation), formation.brakes
    radius = tuple(group.wheel_radius for group in groups)
    classes: dict[str, Origin] = {}

    def party(role: Role, table: object, given: object) -> Any:
        """Return the object of the user's own that plays a part, if one does."""
        if not isinstance(table, Custom):
            return None
        found = party_of(table, role, own.folders) if given is None else given
        classes[role if role == "sensors" else role.removesuffix("s")] = origin_of(found, table.parameters)
        return found

    with ExitStack() as stack:
        if (named := scenario.vehicle.own_class) is not None:
            arguments = {name: value.written for name, value in scenario.vehicle.parameters.items()}
            table = Custom(kind=named, parameters=arguments) if own.plant is None else table_of(own.plant)
            plant = _own_plant(scenario, party("plants", table, own.plant), layout, radius)
        else:
            plant = stack.enter_context(_plant(scenario, plant_file, layout, radius, tell))
        state_estimator: StateEstimator | custom.CustomEstimator | None = None
        if (estimator := party("estimators", scenario.estimator, own.estimator)) is not None:
            state_estimator = custom.CustomEstimator(estimator, formation)
        elif scenario.estimator.kind != "none":
            state_estimator = stack.enter_context(_state_estimator(scenario, layout, fmus))
            if isinstance(scenario.estimator, KalmanFilter) and scenario.estimator.free_wheels:
                state_estimator = replace(state_estimator, free_wheel=FreeWheel(groups, scenario.periods.estimator))
        estimates = _estimates(state_estimator)
        if (instruments := party("sensors", scenario.sensors, own.sensors)) is not None:
            noise = generator(scenario.seed, "sensors.custom")
            sensors = custom.CustomSensors(instruments, layout, formation, scenario.periods.communication, noise)
        else:
            sensors = sensors_of(scenario, layout, radius[0])
        if (law := party("controllers", scenario.controller, own.controller)) is not None:
            controller, actuation, commands_valves = (
                custom.CustomController(law, formation),
                actuation_of(scenario, groups),
                False,
            )
        else:
            controller, actuation, commands_valves = stack.enter_context(
                _controlling(scenario, groups, estimates, fmus, tell)
            )
        _demand_estimates(scenario, controller, estimates)
        if commands_valves and scenario.demand is not None:
            raise ScenarioError(
                f"{scenario.name}: [demand] limits the pressures that a controller demands, but that of [controller] "
                "commands the valves; leave out [demand], or let it give demand [Pa]"
            )
        law_states = _law_states(controller)
        signals = (
            *layout.plant_signals,
            *sent(pneumatic=scenario.actuation.kind == "pneumatic"),
            *layout.reading_signals,
            *(() if commands_valves else DEMANDED),
            *(() if law_states is None else law_states.signals),
            *(DRIVEN if scenario.demand is not None else ()),
            *(TRACTION if scenario.demand is not None and scenario.demand.has_traction else ()),
            *(REFERENCE if isinstance(state_estimator, StateEstimator) and state_estimator.free_wheel else ()),
            *(signal for signal in ESTIMATES if signal.name.removeprefix("estimate_") in estimates),
        )
        yield Assembled(
            scenario=scenario,
            parties={
                "layout": layout,
                "plant": plant,
                "rail": _rail(scenario, plant_file, layout),
                "sensors": sensors,
                "state_estimator": state_estimator,
                "actuation": actuation,
                "driver": _driver(scenario, layout, groups),
                "faults": faults_of(
                    scenario,
                    layout,
                    groups,
                    shown=shown_by(scenario, plant_file),
                    valves=scenario.actuation.kind == "pneumatic",
                ),
                "wheel_radius": radius,
                "law": law_states,
                "clock": Clock(
                    period=scenario.periods.communication,
                    estimator=scenario.periods.every("estimator"),
                    controller=scenario.periods.every("controller"),
                    samples=_samples(scenario),
                    sensors=sampled_every(scenario.sensors, scenario.periods.communication),
                ),
                "start_speed": scenario.start.speed,
                "stop_speed": scenario.limits.stop_speed,
                "recorder": Recorder(signals, formation, _samples(scenario) + 1),
            },
            controller=controller,
            obstacle=compiled_cycle.obstacle(layout, plant, sensors, state_estimator, controller, actuation),
            plant_file=plant_file,
            fmus=fmus,
            classes=classes,
        )


def _law_states(controller: Controller) -> LawStates | None:
    """Return what a controller shows of its states; None where it shows none."""
    shown = controller.shown if isinstance(controller, Sampled) else ()
    if not shown:
        return None
    places = np.array([place for place, _ in shown], dtype=np.longlong)
    columns = of_law((quantity.name, quantity.unit, quantity.description) for _, quantity in shown)
    return LawStates(columns, controller.state, places)


def _rail(scenario: Scenario, plant_file: Description, layout: Layout) -> TabulatedRail:
    """Return the rail of a scenario, before any wheel has passed."""
    adhesion, formation = scenario.adhesion, layout.formation
    field = None
    if adhesion.recovery is not None:
        changed = plant_parameters(scenario, plant_file)
        laid = {key: changed[f"{key}_falling"] for key in ("A", "B") if f"{key}_falling" in changed}
        position_of(scenario, formation)
        field = Field(formation, adhesion.recovery, adhesion.polach.model_copy(update=laid), reach_of(scenario))
    sand = None
    if adhesion.sand is not None and (sanders := _sanders(scenario, formation)):
        position_of(scenario, formation)
        sand = SandedRail(formation, sanders, reach_of(scenario), **dict(adhesion.sand))
    return TabulatedRail(layout, profile_of(scenario, formation), force_on(scenario, plant_file), field, sand)


def _sanders(scenario: Scenario, formation: Formation) -> list[Sander]:
    """Return the sanders of a scenario, or those of its train."""
    sanders = scenario.sanders
    if not sanders and scenario.vehicle.train is not None:
        sanders = load_train(scenario.vehicle.train.path).sanders
    for number, sander in enumerate(sanders, start=1):
        if sander.wheelset > formation.wheelsets:
            raise ScenarioError(
                f"{scenario.name}: [sanders[{number}]] is at wheelset {sander.wheelset}, the vehicle has "
                f"{formation.wheelsets}"
            )
    return [
        Sander(
            rate=sander.rate,
            density=inf if sander.density is None else sander.density,
            begin=sander.begin + sander.delay,
            end=inf if sander.end is None else sander.end + sander.delay,
            wheelset=sander.wheelset - 1,
        )
        for sander in sanders
    ]


def _driver(scenario: Scenario, layout: Layout, groups: Sequence[BrakeGroup]) -> Driver:
    """Return the driver of a scenario, who knows the brakes by their nominal data."""
    full = np.array([group.pressure_max for group in groups])
    touching = np.array([group.spring_force / group.piston_area for group in groups])
    demand = scenario.demand
    phases = () if demand is None else phases_of(demand, full.tolist(), scenario.name)
    binding = not getattr(scenario.controller, "redistribute", False)
    return Driver(layout, scenario.periods.communication, full=full, touching=touching, phases=phases, binding=binding)


def _estimates(state_estimator: StateEstimator | custom.CustomEstimator | None) -> frozenset[str]:
    """Return what an estimator provides, by the names of `ESTIMATES` without their prefix."""
    if state_estimator is None:
        return frozenset()
    if isinstance(state_estimator, custom.CustomEstimator):
        return frozenset(state_estimator.provides)
    return frozenset(signal.name.removeprefix("estimate_") for signal in ESTIMATES)


def _demand_estimates(scenario: Scenario, controller: Controller, estimates: Collection[str]) -> None:
    """Refuse a law that needs what nobody estimates.

    Raises:
        ScenarioError: It says what is missing.
    """
    missing = [name for name in getattr(controller, "needs", ()) if name not in estimates]
    if missing:
        provided = ", ".join(sorted(estimates)) or "nothing"
        raise ScenarioError(
            f"{scenario.name}: [controller] '{scenario.controller.kind}' needs estimates of {' and '.join(missing)}, "
            f"[estimator] '{scenario.estimator.kind}' provides {provided}"
        )


def judged(
    scenario: Scenario, recorder: Recorder, ended: Ended, plant_file: Description, fmus: Mapping[str, Description]
) -> Stop:
    """Return the stop that a run of the loop gave, with bound and figures."""
    trace = recorder.trace(max(ended.samples, 1), scenario.periods.communication)
    # The bound is that of the simulated truth: the plant's own brakes and the scenario's creep curve. A foreign plant
    # that does not show its brakes has none; the figures that need it are empty.
    with suppress(ScenarioError):
        trace = with_bound(
            trace,
            contact_of(scenario, plant_file),
            true_brake(scenario, plant_file),
            scenario.limits.alpha_max,
        )
    share = over_the_rail(trace)
    if ended.outcome is Outcome.STANDSTILL and share > _MOST_OF_THE_RAIL:
        ended = implausible(
            f"The plant used {share:.1%} of the adhesion at the peak of the creep curve; more than 100 % cannot be: "
            "its contact is not that of [adhesion] polach.",
            ended.samples,
        )
    metrics = measure(trace, alpha_max=scenario.limits.alpha_max, actuation=scenario.actuation.kind)
    since = "" if scenario.demand is None else f" {metrics.distance:.2f} m of that since the first brake demand."
    return Stop(
        scenario=scenario,
        outcome=ended.outcome,
        reason=ended.reason + since,
        trace=trace,
        metrics=metrics,
        versions=versions() | {name: description.generator for name, description in fmus.items()},
        fmus={name: description.digest for name, description in fmus.items()},
    )


@cache
def versions() -> dict[str, str]:
    """Return the versions of what takes part in a stop."""
    return {"python": platform.python_version()} | {name: version(name) for name in _PACKAGES}


def _samples(scenario: Scenario) -> int:
    return round(scenario.limits.horizon / scenario.periods.communication)


# ---- the train's nominal data -----------------------------------------------------------------------------------


@cache
def _described(path: Path, stamp: tuple[int, int], limits: FmuLimits) -> Description:
    return describe(path, limits)


def description_of(path: Path, limits: FmuLimits = FMU_LIMITS) -> Description:
    """Return the description of an FMU, read once for each version of the file."""
    status = path.stat() if path.exists() else None
    return _described(path, (status.st_mtime_ns, status.st_size) if status else (0, 0), limits)


@cache
def recipe_file(name: str) -> Path:
    """Return the FMU of a recipe, built when it is not up to date; asked once in a process."""
    return fmu(name)


@cache
def _class_file(class_name: str, library: Path, digest: str, interface: Literal["me", "cs"]) -> Path:  # pyright: ignore[reportUnusedParameter]
    return build_class(class_name, library, interface).path


def class_file(class_name: str, library: NamedFile, interface: Literal["me", "cs"]) -> Path:
    """Return the FMU of a class of the user's own, built when it is not up to date."""
    return _class_file(class_name, library.path, library.digest(), interface)


@cache
def _train_file(path: Path, digest: str, pneumatic: bool) -> Path:  # pyright: ignore[reportUnusedParameter]
    train = load_train(path)
    name, text = class_name(train, pneumatic=pneumatic), class_text(train, pneumatic=pneumatic).encode()
    source = keep("modelica", sha256(text).hexdigest(), f"{name}.mo", text)
    return build_class(name, source).path


def train_file(train: NamedFile, *, pneumatic: bool) -> Path:
    """Return the FMU of a train file, built when it is not up to date.

    Raises:
        ScenarioError: The file is no train.
    """
    return _train_file(train.path, train.digest(), pneumatic)


def plant_description(scenario: Scenario) -> Description:
    """Return the description of the plant FMU of a scenario; of a plant in Python, which has none, an empty one."""
    vehicle = scenario.vehicle
    if vehicle.own_class is not None:
        return Description(
            file=Path(vehicle.own_class), digest="", model=vehicle.own_class, guid="", generator="", variables={},
            states=(), derivatives=(), event_indicators=0, log_categories=(), co_simulation=None, model_exchange=None,
            blemishes="",
        )  # fmt: skip
    if vehicle.model is not None and vehicle.library is not None:
        return description_of(class_file(vehicle.model, vehicle.library, "cs"))
    if vehicle.train is not None:
        return description_of(train_file(vehicle.train, pneumatic=scenario.actuation.kind == "pneumatic"))
    if isinstance(vehicle.plant, NamedFile):
        return description_of(vehicle.plant.path, scenario.limits.fmu.limits())
    assert vehicle.plant is not None  # or there is a model
    return description_of(recipe_file(vehicle.plant))


def is_trusted(scenario: Scenario) -> bool:
    """Say whether the plant may be loaded into this process.

    What the built-in compiler makes calls nothing from outside, for it refuses external functions; what OpenModelica
    makes may.
    """
    vehicle = scenario.vehicle
    compiled = vehicle.model is not None or vehicle.train is not None
    return vehicle.recipe is not None or (compiled and choose("auto") == "native") or vehicle.trust


def parameters_of(description: Description) -> dict[str, float]:
    """Return the start values of an FMU's numeric parameters."""
    found: dict[str, float] = {}
    for variable in description.variables.values():
        if variable.causality == "parameter" and variable.kind in ("Real", "Integer") and variable.start is not None:
            found[variable.name] = float(variable.start)
    return found


def catalogue_brakes(groups: int) -> tuple[BrakeGroup, ...]:
    """Return brakes as the catalogue train has them, for a plant of so many groups that says nothing of its own."""
    nominal = parameters_of(description_of(recipe_file(CATALOGUE)))
    known = brake_groups_of(nominal, Formation(counts_of(nominal)))
    return tuple(known[g % len(known)] for g in range(groups))


def catalogue_counts() -> tuple[int, ...]:
    """Return the number of wheelsets of each group of the catalogue train."""
    return counts_of(parameters_of(description_of(recipe_file(CATALOGUE))))


def controlled_formation(scenario: Scenario) -> Formation:
    """Return the vehicle as the controller knows it, whole: nominal data of the plant and [controller.parameters].

    Raises:
        ScenarioError: Something of it is missing, or FMU and file disagree.
    """
    plant = plant_description(scenario)
    formation = formation_of(scenario, plant)
    nominal = nominal_parameters(scenario, plant)
    if not isinstance(scenario.controller, ControllerFmu | Custom):
        units = units_of_nominal_data(formation)
        written = {name: value for name, value in scenario.controller.parameters.items() if name in units}
        written = in_units("[controller.parameters]", written, units)
        nominal = spread(nominal, formation) | spread(written, formation)
        if "m" in written and not any(name.startswith("m_wheelset") for name in written):
            nominal |= {f"m_wheelset[{i + 1}]": written["m"] / formation.wheelsets for i in range(formation.wheelsets)}
    masses = masses_of(nominal, formation).tolist()
    return replace(
        formation,
        wheelset_load=tuple(mass * GRAVITY for mass in masses),
        brakes=brake_groups_of(nominal, formation),
    )


def formation_of(scenario: Scenario, plant: Description) -> Formation:
    """Return the formation of a scenario's plant: what the FMU says of itself, else [vehicle.formation].

    Where neither says how many wheelsets there are, the plant is taken for one like the catalogue train; its arrays
    tell if it is not. Brakes are left out, loads where only the FMU says them: see `controlled_formation`.

    Raises:
        ScenarioError: FMU and table disagree, or either does with itself.
    """
    table, parameters = scenario.vehicle.formation or FormationTable(), parameters_of(plant)
    values: dict[str, tuple[float, ...]] = {}
    for name, unit in _FORMATION.items():
        own, written = _array_of(parameters, name), getattr(table, name)
        if own and plant.variables[f"{name}[1]"].unit_name not in (unit, ""):
            raise ScenarioError(
                f"{plant.file.name}: its parameter {name} is in '{plant.variables[f'{name}[1]'].unit_name}'; by that "
                f"name the harness takes '{unit}'"
            )
        if own and written and own != tuple(written):
            raise ScenarioError(
                f"{scenario.name}: [vehicle.formation] {name} is {list(written)}, {plant.file.name} has "
                f"{[float(f'{value:g}') for value in own]}; leave it out"
            )
        values[name] = own or written
    counts = tuple(map(int, values[_COUNTS])) or catalogue_counts()
    try:
        return Formation(
            counts,
            tuple(map(int, values["wheelsets_per_car"])),
            values["wheelset_position"],
            table.wheelset_load,
            groups_per_valve=tuple(map(int, values["groups_per_valve"])),
        )
    except ValueError as problem:
        where = f"{scenario.name}: [vehicle.formation]" if table.model_fields_set else plant.file.name
        raise ScenarioError(f"{where}: {problem}") from problem


def counts_of(parameters: Mapping[str, float]) -> tuple[int, ...]:
    """Return the number of wheelsets of each group that an FMU says it has; empty where it does not."""
    return tuple(map(int, _array_of(parameters, _COUNTS)))


def _array_of(parameters: Mapping[str, float], name: str) -> tuple[float, ...]:
    names = (f"{name}[{i}]" for i in count(1))
    return tuple(parameters[element] for element in takewhile(parameters.__contains__, names))


def nominal_parameters(scenario: Scenario, plant: Description) -> dict[str, float]:
    """Return the data that a controller may know of a plant: its own, else those of [vehicle.formation].

    An FMU from outside has names of its own. What neither says is that of the catalogue train if the plant is alike,
    else left to [controller.parameters].

    Raises:
        ScenarioError: Plant and [vehicle.formation] disagree.
    """
    formation, where = formation_of(scenario, plant), f"{scenario.name}: [vehicle.formation]"
    table = scenario.vehicle.formation or FormationTable()
    written = in_units(f"{where} brakes", table.brakes, units_of_brakes(formation))
    written |= {f"m_wheelset[{i + 1}]": load / GRAVITY for i, load in enumerate(formation.wheelset_load)}
    written = spread(written, formation)
    if isinstance(scenario.vehicle.plant, NamedFile) or scenario.vehicle.own_class:
        catalogue = parameters_of(description_of(recipe_file(CATALOGUE)))
        alike = formation.wheelsets_per_group == counts_of(catalogue)
        return (catalogue if alike else {}) | written
    own = parameters_of(plant)
    known = spread(own, formation)
    with suppress(ScenarioError):
        known |= {f"m_wheelset[{i + 1}]": mass for i, mass in enumerate(masses_of(own, formation).tolist())}
    for name, value in known.items():
        if name in written and not isclose(written[name], value, rel_tol=1e-3):
            key = "wheelset_load" if name.startswith("m_wheelset") else f"brakes {name}"
            raise ScenarioError(
                f"{where} {key} says {name} = {written[name]:g}, {plant.file.name} has {value:g}; leave it out, or "
                "change [vehicle.parameters] or [controller.parameters]"
            )
    return own | written


def _units_of(description: Description) -> dict[str, Unit | str]:
    return {v.name: v.unit or v.unit_name for v in description.variables.values() if v.causality == "parameter"}


# ---- plant ------------------------------------------------------------------------------------------------------


def plant_parameters(scenario: Scenario, description: Description) -> dict[str, float]:
    """Return what [vehicle.parameters], [truth] and isolated brake units change of a plant FMU, in its units.

    None of them changes what controller, estimator and driver are told.

    Raises:
        ScenarioError: There is no such parameter, its unit has another dimension, or it only describes the plant.
    """
    factors = scenario.truth.factors()
    if scenario.vehicle.own_class:  # [vehicle.parameters] are arguments of the class
        if factors:
            key = TRUTH_KEYS.get(next(iter(factors)), "creep")
            raise ScenarioError(
                f"{scenario.name}: [truth] {key} changes parameters of an FMU; the plant is a class of Python"
            )
        return {}
    fixed = next((name for name in scenario.vehicle.parameters if name.partition("[")[0] in _FORMATION), None)
    if fixed is not None:
        raise ScenarioError(
            f"[vehicle.parameters] {fixed} says how {description.file.name} is made and cannot be set; name another one"
        )
    written = in_units("[vehicle.parameters]", scenario.vehicle.parameters, _units_of(description))
    if not factors and not scenario.faults:
        return written
    base = parameters_of(description) | scenario.adhesion.polach.plant_parameters() | written
    changed = written | _true_parameters(scenario.name, factors, base)
    return changed | isolated_units(scenario, formation_of(scenario, description), base)


def _true_parameters(
    origin: str, factors: Mapping[str, Sequence[float]], base: Mapping[str, float]
) -> dict[str, float]:
    """Return the parameters of a plant that factors change, one for all elements of an array or one for each.

    Raises:
        ScenarioError: The plant has no such parameter, or another number of elements.
    """
    changed: dict[str, float] = {}
    for name, each in factors.items():
        found = [name] if name in base else [f"{name}[{i + 1}]" for i in range(len(_array_of(base, name)))]
        where = f"{origin}: [truth] {TRUTH_KEYS.get(name, f'creep.{name}')}"
        if not found:
            raise ScenarioError(f"{where} changes the parameter {name}, which the plant does not have")
        if len(each) not in (1, len(found)):
            raise ScenarioError(f"{where} has {len(each)} factors, the plant has {len(found)} of {name}")
        changed |= {element: base[element] * each[i % len(each)] for i, element in enumerate(found)}
    return changed


def true_brake(scenario: Scenario, description: Description) -> Brake:
    """Return the brakes as they are, for the bound: those of a group that is isolated do nothing.

    Raises:
        ScenarioError: The plant does not show them.
    """
    formation = formation_of(scenario, description)
    brake = brake_of(parameters_of(description) | plant_parameters(scenario, description), formation)
    units = brake.n_units.copy()
    units[isolated_groups(scenario, formation)] = 0.0
    return replace(brake, n_units=units)


def force_on(scenario: Scenario, description: Description) -> TrackForce:
    """Return the force of the track of a scenario and of the gradient that nobody was told.

    Raises:
        ScenarioError: There is such a gradient, and the plant does not say its mass.
    """
    force, slope = track_force_of(scenario.track), scenario.truth.gradient
    if not slope:
        return force
    truth, formation = (
        parameters_of(description) | plant_parameters(scenario, description),
        formation_of(scenario, description),
    )
    try:
        mass = float(masses_of(truth, formation).sum())
    except ScenarioError as problem:
        raise ScenarioError(
            f"{scenario.name}: [truth] gradient wants the mass of the plant, which does not say it; write [track] "
            "gradient with train_mass"
        ) from problem
    more = float(force_along(slope, 0.0, mass))
    return replace(force, forces=tuple(one + more for one in force.forces))


def layout_of_plant(scenario: Scenario, description: Description, formation: Formation) -> Layout:
    """Return the layout of the vectors that a plant and the sensors of a scenario exchange.

    Raises:
        ScenarioError: The sensors are to read what the plant does not show.
    """
    shown = shown_by(scenario, description)
    extra = tuple(s for s in EXTRA if s.name in shown)
    return layout_of(formation, (*PLANT, *extra), readings_of(scenario, shown))


def shown_by(scenario: Scenario, description: Description) -> frozenset[str]:
    """Return the names of what a plant shows."""
    mapped = set(scenario.vehicle.map)
    offered = {name.partition("[")[0] for name in description.variables} | mapped
    extra = mapped | (offered & _outputs(description))
    return frozenset(
        {"slip"} | {s.name for s in PLANT if s.name in offered} | {s.name for s in EXTRA if s.name in extra}
    )


def _outputs(description: Description) -> set[str]:
    return {name.partition("[")[0] for name in description.named("output")}


def plant_signals(
    layout: Layout, *, pneumatic: bool, track_force: bool
) -> tuple[tuple[Signal, ...], tuple[Signal, ...], Signal]:
    """Return what a plant is given, what it shows, and the parameter that its speed at the start is.

    Args:
        layout: Of the vectors that it exchanges.
        pneumatic: It takes positions of valves, else pressures.
        track_force: It has to take a force of the track.
    """
    formation = layout.formation
    name, unit = ("valve_command", "1") if pneumatic else ("pressure_command", "Pa")
    inputs = (
        Signal(name=name, unit=unit, size=formation.groups, needed=True),
        Signal(name="mu0", unit="1", size=formation.wheelsets, needed=True),
        Signal(name="track_force", unit="N", size=0, needed=track_force),
    )
    outputs = tuple(
        Signal(
            name=s.name,
            unit=s.unit,
            size=0 if s.extent == "train" else formation.width(s.extent),
            needed=s.name in NEEDED,
        )
        for s in layout.plant_signals
    )
    return inputs, outputs, Signal(name="speed_start", unit="m/s", size=0, needed=True)


def _track_fits(scenario: Scenario, description: Description, formation: Formation) -> None:
    """Refuse a track that no train of this mass could run on; a foreign plant may not say its mass.

    Raises:
        ScenarioError: The force is more than that of the steepest gradient.
    """
    truth = parameters_of(description) | plant_parameters(scenario, description)
    mass = 0.0
    with suppress(ScenarioError):
        mass = float(masses_of(truth, formation).sum())
    most, force = STEEPEST * GRAVITY * mass, max(force_on(scenario, description).forces, key=abs)
    if mass and abs(force) > most:
        raise ScenarioError(
            f"[track] puts {force:.6g} N on a train of {mass:.6g} kg, but a gradient of {STEEPEST:.0%} only "
            f"{most:.6g} N; correct force, gradient, curve or train_mass."
        )


def _nudged(values: Mapping[str, float], description: Description, nudge: Nudge) -> dict[str, float]:
    """Return all real parameters of a plant, each moved by a uniform share within ±`nudge.relative` of its own.

    One at the end of what it may be stays there where it would be moved beyond. What only describes the vehicle is not
    drawn for; the counts of groups, which are as little to the plant, keep their place among the draws of old results.
    """
    idle = _FORMATION.keys() - {_COUNTS}
    real = [
        v
        for v in description.variables.values()
        if v.causality == "parameter" and v.kind == "Real" and v.name.partition("[")[0] not in idle
    ]
    shares = generator(nudge.seed, "plant parameters").uniform(-nudge.relative, nudge.relative, len(real))
    moved: dict[str, float] = {}
    for variable, share in zip(real, shares, strict=True):
        value = values.get(variable.name, variable.start)
        if value is not None:
            least, most = variable.minimum, variable.maximum
            free = float(value) * (1.0 + float(share))
            moved[variable.name] = min(max(free, -inf if least is None else least), inf if most is None else most)
    return moved


@contextmanager
def _plant(
    scenario: Scenario,
    description: Description,
    layout: Layout,
    radius: tuple[float, ...],
    tell: Callable[[str], None],
) -> Generator[Plant]:
    """Open the plant of a scenario, bound to the vectors of the loop."""
    vehicle, formation = scenario.vehicle, layout.formation
    _track_fits(scenario, description, formation)
    own = vehicle.recipe is not None
    inputs, outputs, start = plant_signals(
        layout,
        pneumatic=scenario.actuation.kind == "pneumatic",
        track_force=bool(np.any(force_on(scenario, description).forces))
        or (scenario.demand is not None and scenario.demand.has_traction),
    )
    binding = bind(
        description,
        inputs=inputs,
        outputs=outputs,
        parameters=(start,),
        table=vehicle.map,
        where=f"{scenario.name}: [vehicle.map]",
    )
    surface = scenario.adhesion.polach.plant_parameters()
    shaped = {name: value for name, value in surface.items() if own or name in description.variables}
    values = (
        binding.translated({"speed_start": scenario.start.speed}) | shaped | plant_parameters(scenario, description)
    )
    opening = partial(
        open_plant,
        description,
        binding,
        period=scenario.periods.communication,
        parameters=values if vehicle.nudge is None else values | _nudged(values, description, vehicle.nudge),
        trusted=is_trusted(scenario),
        limits=scenario.limits.fmu.limits(),
    )
    if not own:
        with (
            suppress(PlantFailed),
            opening(tell=lambda sentence: None) as first,
        ):  # the stop itself will say how it failed
            who = f"[vehicle.map] does not fit {description.file.name}"
            _refuse_unfit(who, _trial_of(scenario, layout, first))
    with opening(tell=tell) as opened:
        yield _WithSlip(opened, layout, radius) if "slip" in binding.outputs.absent else opened


def _own_plant(scenario: Scenario, own: custom.Plant, layout: Layout, radius: tuple[float, ...]) -> Plant:
    """Return a plant in Python, bound to the vectors of the loop."""
    _track_fits(scenario, plant_description(scenario), layout.formation)
    plant = _WithSlip(
        custom.CustomPlant(
            own,
            layout,
            speed=scenario.start.speed,
            period=scenario.periods.communication,
            needed=NEEDED,
            command="valve_command" if scenario.actuation.kind == "pneumatic" else "pressure_command",
        ),
        layout,
        radius,
    )
    with suppress(PlantFailed):  # the stop itself will say how it failed
        who = f"{scenario.name}: the plant {type(own).__name__} is none"
        _refuse_unfit(who, _trial_of(scenario, layout, plant))
    return plant


def _trial_of(scenario: Scenario, layout: Layout, plant: Plant) -> tuple[Finding, ...]:
    """Return what a short run of a plant from outside shows, before its stop."""
    groups = controlled_formation(scenario).brakes
    pressure, radius = tuple(g.pressure_max for g in groups), tuple(g.wheel_radius for g in groups)
    ideal = scenario.actuation.kind == "ideal"
    vent, fill = -1.0, 1.0
    trial = tried(
        layout,
        plant,
        period=scenario.periods.communication,
        release=(0.0 if ideal else vent,) * len(groups),
        brake=pressure if ideal else (fill,) * len(groups),
    )
    return findings(trial, speed=scenario.start.speed, radius=radius, pressure=pressure)


def _refuse_unfit(who: str, found: tuple[Finding, ...]) -> None:
    wrong = [f"'{finding.signal}' {finding.sentence}" for finding in found if not finding.good]
    if wrong:
        raise ScenarioError(f"{who}: in a short run before the stop {'; '.join(wrong[:4])}.")


class _WithSlip:
    """A plant that may not show slip: it follows from the speeds it shows and the nominal radii."""

    def __init__(self, plant: Plant, layout: Layout, radius: tuple[float, ...]) -> None:
        self._plant, self._at = plant, layout.output
        self._radius = np.array(radius)

    def start(self, inputs: Vector) -> Vector:
        return self._whole(self._plant.start(inputs))

    def step(self, inputs: Vector) -> Vector:
        return self._whole(self._plant.step(inputs))

    def _whole(self, truth: Vector) -> Vector:
        if np.isnan(truth[self._at["slip"]]).any():
            speed = max(float(truth[self._at["speed"]][0]), 1e-3)
            truth[self._at["slip"]] = 1.0 - self._radius * truth[self._at["wheelset_speed"]] / speed
        return truth


# ---- estimator --------------------------------------------------------------------------------------------------


@cache
def lowered(class_name: str) -> Model:
    """Return a class as CasADi functions; compiled once in a process."""
    return lower(class_name)


def _predicted(table: KalmanFilter, name: str, layout: Layout) -> Model:
    """Return the model inside a filter, one of ours or of the user's own.

    Raises:
        ScenarioError: It is for another vehicle, or lacks what the loop asks of every prediction.
    """
    own = table.library
    model = lowered(f"RailBraking.FMUs.{name}") if own is None else lower(name, library_of(own.path))
    where = f"[estimator] model '{name}'"
    states, groups = [variable.name for variable in model.states], layout.formation.groups
    predicted = sum(name.startswith("w[") for name in states)
    if predicted != groups:
        raise ScenarioError(f"{where} is for {predicted} groups, the vehicle has {groups}")
    each = [f"{name}[{g + 1}]" for name in ("w", "mu_b", "alpha") for g in range(groups)]
    wanted = {
        "state": (["v", *each], states),
        "parameter": (
            [*_PREDICTION_DATA, *(f"{name}_start[{g + 1}]" for name in ("mu_b", "alpha") for g in range(groups))],
            [variable.name for variable in model.parameters],
        ),
    }
    for kind, (names, offered) in wanted.items():
        if missing := [name for name in names if name not in offered]:
            raise ScenarioError(f"{where} has no {kind} {', '.join(missing[:4])}; it has {', '.join(offered)}")
    pressures, inputs = [f"cylinder_pressure[{g + 1}]" for g in range(groups)], [v.name for v in model.inputs]
    if inputs[:groups] != pressures:
        raise ScenarioError(f"{where} must have {', '.join(pressures)} as first inputs; it has {', '.join(inputs)}")
    if unread := [variable.name for variable in model.outputs if variable.name.partition("[")[0] not in layout.reading]:
        raise ScenarioError(
            f"{where} has an output {unread[0]}, which no sensor reads; they read {', '.join(sorted(layout.reading))}"
        )
    return model


RELEASED_PADS = 1500.0
"""Normal force of both pads of a unit [N] below which nothing is learned of their friction; see `pad_gate`."""

_PREDICTION_DATA = ("r_wheel", "A_piston", "i_rigging", "eta_rigging", "F_spring")
_NOISE_PREFIX = {
    "TrainPrediction": "train",
    "TrainPredictionDisturbed": "disturbed",
    "TrainPredictionReduced": "reduced",
}


@contextmanager
def _state_estimator(scenario: Scenario, layout: Layout, fmus: dict[str, Description]) -> Generator[StateEstimator]:
    """Make the estimator of a scenario; an FMU that takes part adds itself to `fmus`."""
    table = scenario.estimator
    assert isinstance(table, KalmanFilter)
    noise = _noise(table)
    period = scenario.periods.estimator
    if table.model is None:
        yield _own_estimator(scenario, table, noise, layout)
        return
    model = _predicted(table, table.model, layout)
    groups = layout.formation.groups
    changed = in_units("[estimator.parameters]", table.parameters, {v.name: v.unit for v in model.parameters})
    parameters = {v.name: v.start for v in model.parameters} | changed
    with ExitStack() as stack:
        if table.kind == "fmu":
            own = table.library
            description = description_of(
                recipe_file(table.model) if own is None else class_file(table.model, own, "me")
            )
            fmus[description.file.name] = description
            prediction = stack.enter_context(
                FmuPrediction(
                    description,
                    parameters=parameters,
                    states=[v.name for v in model.states],
                    inputs=[v.name for v in model.inputs],
                    outputs=[v.name for v in model.outputs],
                )
            )
        else:
            prediction = CasadiPrediction(model, parameters)
        gate = pad_gate(
            pad_force=RELEASED_PADS,
            A_piston=parameters["A_piston"],
            i_rigging=parameters["i_rigging"],
            eta_rigging=parameters["eta_rigging"],
            F_spring=parameters["F_spring"],
            groups=groups,
        )
        states, outputs = prediction.states, prediction.outputs
        noises = noise.process_noise(states), noise.reading_noise(outputs)
        radius = parameters["r_wheel"]
        mean = np.zeros(len(states))
        at = {name: states.index(f"{name}[1]") for name in ("w", "mu_b", "alpha")}
        every = np.arange(groups)
        mean[states.index("v")] = scenario.start.speed
        mean[at["w"] + every] = scenario.start.speed / radius
        mean[at["mu_b"] + every] = [parameters[f"mu_b_start[{g + 1}]"] for g in every]
        mean[at["alpha"] + every] = [parameters[f"alpha_start[{g + 1}]"] for g in every]
        first = mean, noise.start_covariance(states)
        filter_ = _central(table, prediction, *noises, period, gate, first)
        seen = [layout.reading[name.partition("[")[0]].start + _element(name) for name in outputs]
        yield StateEstimator(
            filter=filter_,
            seen=np.array(seen, dtype=np.intp),
            speed=states.index("v"),
            wheelset_speed=at["w"] + every,
            adhesion=at["alpha"] + every,
            pad_friction=at["mu_b"] + every,
            wheel_radius=(radius,) * groups,
        )


def _own_estimator(scenario: Scenario, table: KalmanFilter, noise: NoiseSet, layout: Layout) -> StateEstimator:
    """Return the estimator whose prediction is made from the vehicle's nominal data."""
    formation = controlled_formation(scenario)
    groups, wheelsets = range(1, formation.groups + 1), range(1, formation.wheelsets + 1)
    units = units_of_predictions()
    each = {f"{name}[{i}]": unit for name, unit in units.items() for i in wheelsets}
    changed = in_units("[estimator.parameters]", table.parameters, units | each)
    data = data_of(nominal_parameters(scenario, plant_description(scenario)), formation)
    data = {name: value for name, value in data.items() if name.partition("[")[0] not in changed} | changed
    consist = consist_of(formation, data)
    gate = Gate(
        states=tuple(f"mu_b[{g}]" for g in groups),
        inputs=tuple(f"cylinder_pressure[{g}]" for g in groups),
        threshold=max(release_pressure(data, g - 1, RELEASED_PADS) for g in groups),
    )
    noises = noise.process_noise(consist.states), noise.reading_noise(consist.outputs)
    first = start_of(consist, formation, data, scenario.start.speed), noise.start_covariance(consist.states)
    if table.kind == "decentralised":
        if table.outlier_limit:
            raise ScenarioError(
                "[estimator] outlier_limit is for kind compiled, python or fmu; decentralised uses every reading"
            )
        filter_ = DecentralisedFilter(consist, *noises, scenario.periods.estimator, gate)
        filter_.start(*first)
    else:
        filter_ = _central(table, consist.prediction, *noises, scenario.periods.estimator, gate, first)

    def places(name: str) -> NDArray[np.intp]:
        return np.array([consist.states.index(f"{name}[{g}]") for g in groups])

    seen = [layout.reading[name.partition("[")[0]].start + _element(name) for name in consist.outputs]
    return StateEstimator(
        filter=filter_,
        seen=np.array(seen, dtype=np.intp),
        speed=0,
        wheelset_speed=places("w"),
        adhesion=places("alpha"),
        pad_friction=places("mu_b"),
        wheel_radius=tuple(radius_of(data, g - 1) for g in groups),
    )


def _central(
    table: KalmanFilter,
    prediction: CasadiPrediction | FmuPrediction,
    process: Vector,
    reading: Vector,
    period: float,
    gate: Gate,
    first: tuple[Vector, Vector],
) -> Filter:
    """Return a filter of all states together that holds its first belief."""
    limits = _outlier_limits(table, prediction.outputs)
    if isinstance(prediction, CasadiPrediction) and table.kind == "compiled":
        compiled = CompiledFilter(prediction, process, reading, period, gate, limits)
        compiled.start(*first)
        return compiled
    plain = ExtendedKalmanFilter(prediction, process, reading, period, gate, limits)
    return Running(plain, plain.start(*first), inputs=len(prediction.inputs), outputs=len(prediction.outputs))


def _outlier_limits(table: KalmanFilter, outputs: Sequence[str]) -> list[float]:
    """Return from how many standard deviations on each reading of a filter is left out.

    Raises:
        ScenarioError: The filter has no such reading.
    """
    read = [name.partition("[")[0] for name in outputs]
    if other := sorted(table.outlier_limit.keys() - read):
        known = ", ".join(dict.fromkeys(read))
        raise ScenarioError(f"[estimator] outlier_limit: the filter has no reading '{other[0]}'; it has {known}")
    return [table.outlier_limit.get(name, inf) for name in read]


def _element(name: str) -> int:
    """Return the zero-based index of `name[i]`, 0 for a scalar."""
    index = name.partition("[")[2]
    return int(index[:-1]) - 1 if index else 0


def _noise(table: KalmanFilter) -> NoiseSet:
    model = table.model or "TrainPrediction"
    prefix = "" if table.library is not None else f"{_NOISE_PREFIX.get(model, model)}_"
    wanted = f"{prefix}{table.noise}"
    if wanted not in NOISE_SETS:
        raise ScenarioError(
            f"[estimator] has no noise set '{table.noise}' for model '{model}'; there are "
            + ", ".join(sorted(NOISE_SETS))
            + " (model_noise)."
        )
    return NOISE_SETS[wanted]


# ---- controller and actuation -----------------------------------------------------------------------------------


@contextmanager
def _controlling(
    scenario: Scenario,
    groups: tuple[BrakeGroup, ...],
    estimates: Collection[str],
    fmus: dict[str, Description],
    tell: Callable[[str], None],
) -> Generator[tuple[Controller, Actuation, bool]]:
    """Open controller and actuation of a scenario; yield also whether the controller commands valves itself.

    An FMU that takes part adds itself to `fmus`.
    """
    table = scenario.controller
    if not isinstance(table, ControllerFmu):
        yield controller_of(scenario, groups), actuation_of(scenario, groups), False
        return
    description = description_of(table.file.path, scenario.limits.fmu.limits())
    name = description.file.name
    fmus[f"controller: {name}" if name in fmus else name] = description
    values = in_units("[controller.parameters]", table.parameters, _units_of(description))
    opened = foreign_controller(scenario, table, description, values, len(groups), estimates, tell)
    with opened as (controller, commands_valves):
        yield controller, Direct() if commands_valves else actuation_of(scenario, groups), commands_valves


def controller_of(scenario: Scenario, groups: tuple[BrakeGroup, ...]) -> Controller:
    """Return the control law of a scenario with what is decided for the whole train.

    Raises:
        ScenarioError: A parameter is wrong, or the controller is no law of ours.
    """
    law, table = _group_law(scenario, groups), scenario.controller
    assert isinstance(table, ParametricLaw | SlipLaw)
    valves = formation_of(scenario, plant_description(scenario)).groups_per_valve
    if table.redistribute:
        if valves and max(valves) > 1:
            raise ScenarioError(
                f"{scenario.name}: [controller] redistribute asks single groups for more, groups_per_valve is "
                f"{list(valves)}: a valve gives all its groups the same; leave out redistribute"
            )
        if scenario.demand is None:
            raise ScenarioError(
                f"{scenario.name}: [controller] redistribute has nothing to give where full brake is asked of every "
                "group; write a [demand] below it"
            )
        law = with_redistribution(
            law, groups, period=scenario.periods.controller, adhesion_max=scenario.limits.alpha_max
        )
    return with_shared_valves(law, groups, valves, table.shared_valve) if valves and max(valves) > 1 else law


def _group_law(scenario: Scenario, groups: tuple[BrakeGroup, ...]) -> Law:
    """Return the law for single groups, its named set changed by [controller.parameters].

    Raises:
        ScenarioError: A parameter is wrong, or the controller is no law of ours.
    """
    table = scenario.controller
    if isinstance(table, ControllerFmu | Custom) or table.kind in ("ideal_bound", "ideal_tracking"):
        raise ScenarioError(f"{scenario.name}: [controller] kind '{table.kind}' is no law of this project")
    train = units_of_nominal_data(formation_of(scenario, plant_description(scenario)))
    own = {name: value for name, value in table.parameters.items() if name not in train}
    where = "[controller.parameters]"
    if table.kind == "full_brake":
        in_units(where, own, {})
        return FullBrake(groups)
    if isinstance(table, SlipLaw):
        values = in_units(where, own, {"low": "1", "high": "1", "speed_min": "m/s"})
        levels = replace(tuning.PAPER_LEVELS, hold=table.kind == "slip_three_state")
        if table.tuning == "searched":
            slip = "estimated" if isinstance(scenario.estimator, KalmanFilter) else "read"
            levels = replace(levels, **tuning.searched(table.kind, scenario.actuation.kind, slip))
        try:
            return SlipBased(groups, replace(levels, **values))
        except ValueError as problem:
            raise ScenarioError(f"{where}: {problem}") from problem
    law, base, given = _law_of(scenario, table.kind)
    values = in_units(where, own, type(base).units())
    try:
        return law(groups, replace(base, **given, **values))
    except ValueError as problem:
        raise ScenarioError(f"{where}: {problem}") from problem


def _law_of(
    scenario: Scenario, kind: str
) -> tuple[Callable[[Sequence[BrakeGroup], Any], Law], Tuning, dict[str, float]]:
    """Return a law, its parameters, and those of them that other tables of a scenario set."""
    actuation, period = scenario.actuation.kind, {"period": scenario.periods.controller}
    if kind in ("adhesion_based", "adhesion_literal"):
        seeker = AdhesionBased if kind == "adhesion_based" else LiteralAdhesionBased
        return seeker, tuning.PEAK_SEEKING[actuation], period | {"adhesion_max": scenario.limits.alpha_max}
    if kind == "slope_seeking":
        lag = scenario.sensors.pressure.lag if isinstance(scenario.sensors, ServiceSensors) else 0.0
        return SlopeSeeking, tuning.SLOPE, period | {"adhesion_max": scenario.limits.alpha_max, "pressure_lag": lag}
    law, parameters = {
        "wheel_reference": (WheelReference, WheelReferenceTuning),
        "constant_slip": (ConstantSlip, ConstantSlipTuning),
        "extremum_seeking": (ExtremumSeeking, ExtremumSeekingTuning),
    }[kind]
    slip = "estimated" if isinstance(scenario.estimator, KalmanFilter) else "read"
    return law, parameters(**period, **tuning.of(kind, actuation, slip)), period


def actuation_of(scenario: Scenario, groups: tuple[BrakeGroup, ...]) -> Actuation:
    """Return what turns demanded pressures into what the plant takes."""
    if scenario.actuation.kind == "ideal":
        return Direct()
    nominal = parameters_of(description_of(recipe_file("TwoPartTrainPneumatic")))
    return ValveLogic(
        [group.pressure_max for group in groups],
        ValveModel(
            period=scenario.periods.controller,
            dead_time=0.5 * (nominal["dead_fill"] + nominal["dead_vent"]),
            fill_time=nominal["T_fill"],
            vent_time=nominal["T_vent"],
            band=tuning.VALVE_BANDS.get(scenario.controller.kind, tuning.VALVE_BAND),
            pulse_min=tuning.VALVE_PULSE_MIN,
        ),
    )


# ---- contact ----------------------------------------------------------------------------------------------------


def contact_of(scenario: Scenario, plant_file: Description) -> Contact:
    """Return adhesion as a function of slip, speed, load and mu0, with the creep curve that the plant has.

    That is the scenario's, but for what [vehicle.parameters] says otherwise.
    """
    model = lowered("RailBraking.FMUs.ContactPoint")
    shape = scenario.adhesion.polach.plant_parameters() | plant_parameters(scenario, plant_file)
    names = {variable.name for variable in model.parameters}
    return compiled_contact(model, {name: value for name, value in shape.items() if name in names})
