"""The plant of a scenario, bound to the vectors of the loop."""

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, ExitStack, nullcontext, suppress
from functools import partial
from math import inf

import numpy as np
from numpy.typing import NDArray

from railgrip.base.errors import PlantFailed, ScenarioError
from railgrip.base.units import GRAVITY
from railgrip.fmi import Binding, Description, Signal, bind, open_plant
from railgrip.scenario.seed import generator
from railgrip.scenario.track.table import STEEPEST
from railgrip.scenario.vehicle import CompiledHere, Nudge, OfOurParts, Recipe, TrainFile
from railgrip.simulate import custom
from railgrip.simulate.files import is_trusted, parameters_of
from railgrip.simulate.loop.parts import Plant
from railgrip.simulate.readback import V_SMALL, probed, require_curve, require_radius
from railgrip.simulate.trial import findings, on_both_rails
from railgrip.simulate.vehicle import VehicleData
from railgrip.vehicle.parameters import COUNTS, DESCRIPTIVE
from railgrip.vehicle.signals import Layout, sent

Vector = NDArray[np.float64]

NEEDED = frozenset({"distance", "speed", "acceleration", "wheelset_speed", "cylinder_pressure"})
"""Outputs no plant can do without; others, such as true adhesion, stay empty in the trace where a plant lacks them."""


def plant_signals(
    layout: Layout, *, pneumatic: bool, track_force: bool
) -> tuple[tuple[Signal, ...], tuple[Signal, ...], Signal]:
    """Return what a plant is given, what it shows, and the parameter that its speed at the start is.

    Args:
        pneumatic: It takes positions of valves, else pressures.
        track_force: It has to take a force of the track.
    """
    formation, command = layout.formation, "valve_command" if pneumatic else "pressure_command"
    # In the order of the loop's vector, so that each value arrives at the variable of its name.
    inputs = tuple(
        Signal(
            name=command if s.name == "command" else s.name,
            unit=s.unit,
            size=0 if s.extent == "train" else formation.width(s.extent),
            needed=s.name != "track_force" or track_force,
        )
        for s in sent(layout, pneumatic=pneumatic)
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
    return inputs, outputs, Signal(name="start_speed", unit="m/s", size=0, needed=True)


def binding_of(vehicle: VehicleData) -> Binding:
    """Return how the plant's FMU is bound to the vectors of the loop.

    Raises:
        FmuError: It does not fit.
    """
    scenario = vehicle.scenario
    inputs, outputs, start = plant_signals(
        vehicle.layout,
        pneumatic=scenario.actuation.kind == "pneumatic",
        track_force=bool(np.any(vehicle.track_force.forces))
        or (scenario.demand is not None and scenario.demand.has_traction),
    )
    return bind(
        vehicle.file,
        inputs=inputs,
        outputs=outputs,
        parameters=(start,),
        table=scenario.vehicle.map,
        where=f"{scenario.name}: [vehicle.map]",
    )


def values_of(vehicle: VehicleData, binding: Binding) -> dict[str, float]:
    """Return the parameters of the plant's FMU that the scenario sets, in its names and units, before any nudge."""
    scenario, variables = vehicle.scenario, vehicle.file.variables
    surface, is_recipe = scenario.adhesion.polach.plant_parameters(), isinstance(scenario.vehicle.source, Recipe)
    shape = {name: value for name, value in surface.items() if is_recipe or name in variables}
    return binding.translate({"start_speed": scenario.start.speed}) | shape | vehicle.changes


def fmu_plant(vehicle: VehicleData, notify: Callable[[str], None], stack: ExitStack) -> Plant:
    """Open the plant of a scenario that is an FMU; one from outside makes two short runs before.

    Raises:
        ScenarioError: The short run shows what no train is, or the track is none for this one.
        FmuError: It does not fit.
    """
    scenario, description = vehicle.scenario, vehicle.file
    table = scenario.vehicle
    _refuse_steep_track(vehicle)
    source, binding = table.source, binding_of(vehicle)
    values = values_of(vehicle, binding)
    opening = partial(
        open_plant,
        description,
        binding,
        period=scenario.periods.communication,
        begin=scenario.plant_begin,
        parameters=values if table.nudge is None else values | nudged(values, description, table.nudge),
        trusted=is_trusted(scenario),
        limits=scenario.limits.fmu,
    )
    # A train file's class is of our parts; what a distributor does by speed or a long pipe late is no mistake of a map.
    if not isinstance(source, OfOurParts) or (isinstance(source, TrainFile) and table.map):
        # The stop itself will say how it failed.
        with suppress(PlantFailed):
            quiet = partial(opening, notify=lambda sentence: None)
            _refuse_unfit(f"[vehicle.map] does not fit {description.file.name}", vehicle, quiet)
    key = (description.digest, scenario.actuation.kind, *values.items(), *vehicle.curves[0])
    if (
        isinstance(source, CompiledHere)
        and not {"slip", "adhesion"} & set(binding.outputs.absent)
        and key not in _read_back
    ):
        with suppress(PlantFailed), opening(notify=lambda sentence: None) as first:
            _require_compiled_parameters(vehicle, first, parameters_of(description) | values)
            _read_back.add(key)
    return stack.enter_context(opening(notify=notify))


_read_back: set[tuple[object, ...]] = set()
"""FMUs with parameters that were read back in this process."""


def _require_compiled_parameters(vehicle: VehicleData, plant: Plant, parameters: Mapping[str, float]) -> None:
    """Compare wheel radius and creep curve that the contacts of a plant have with those it was given.

    The contact law of a class of the user's own may be another one: its curve is not compared.

    Raises:
        FmuError: They differ.
    """
    scenario, layout, file = vehicle.scenario, vehicle.layout, vehicle.file.file.name
    groups = layout.formation.groups
    ideal = scenario.actuation.kind == "ideal"
    brake = tuple(group.pressure_max if ideal else 1.0 for group in vehicle.nominal.formation.brakes)
    curve = dict(zip(scenario.adhesion.polach.plant_parameters(), vehicle.curves[0].tolist(), strict=True))
    rows = probed(plant, layout, period=scenario.periods.communication, brake=brake, curve=curve)
    radii = [parameters.get(f"r_wheel[{g + 1}]", parameters.get("r_wheel")) for g in range(groups)]
    known = tuple(radius for radius in radii if radius is not None)
    if len(known) < groups:
        return
    require_radius(file, layout, rows, known, parameters.get("v_small", V_SMALL))
    if isinstance(scenario.vehicle.source, OfOurParts):
        # A wheel on a roller touches it as a smaller one touches a rail: their curvatures add.
        bend = 1.0 / parameters["r_roller"] if "r_roller" in parameters else 0.0
        contacts = tuple(
            vehicle.contact_with({**parameters, **curve, "r_wheel": radius / (1.0 + radius * bend)}) for radius in known
        )
        require_curve(file, layout, rows, contacts, curve)


def python_plant(vehicle: VehicleData, part: custom.Plant) -> Plant:
    """Return a plant in Python, after two short runs of it.

    Raises:
        ScenarioError: It is no plant, or the short run shows what no train is.
    """
    scenario, layout = vehicle.scenario, vehicle.layout
    _refuse_steep_track(vehicle)
    command = "valve_command" if scenario.actuation.kind == "pneumatic" else "pressure_command"
    speed, period = scenario.start.speed, scenario.periods.communication
    plant = custom.CustomPlant(part, layout, speed=speed, period=period, required=NEEDED, command=command)
    with suppress(PlantFailed):  # the stop itself will say how it failed
        _refuse_unfit(f"{scenario.name}: the plant {type(part).__name__} is none", vehicle, lambda: nullcontext(plant))
    return plant


def _refuse_steep_track(vehicle: VehicleData) -> None:
    """Refuse a track that no train of this mass could run on; the mass of a plant from outside may be unknown."""
    mass = vehicle.mass
    most, force = STEEPEST * GRAVITY * mass, max(vehicle.track_force.forces, key=abs)
    if mass and abs(force) > most:
        raise ScenarioError(
            f"[track] puts {force:.6g} N on a train of {mass:.6g} kg, but a gradient of {100 * STEEPEST:.0f} % only "
            f"{most:.6g} N; correct [track] force, gradient or curve."
        )


def nudged(values: Mapping[str, float], description: Description, nudge: Nudge) -> dict[str, float]:
    """Return all real parameters of a plant, each moved by a uniform share within ±`nudge.relative` of its own.

    One at the end of what it may be stays there where it would be moved beyond. What only describes the vehicle is not
    drawn for; the counts of groups, which are as little to the plant, keep their place among the draws of old results.
    """
    idle = DESCRIPTIVE.keys() - {COUNTS}
    real = [
        v
        for v in description.variables.values()
        if v.causality == "parameter" and v.kind == "Real" and v.name.partition("[")[0] not in idle
    ]
    shares = generator(nudge.seed, "plant parameters").uniform(-nudge.relative, nudge.relative, len(real))
    nudges: dict[str, float] = {}
    for variable, share in zip(real, shares, strict=True):
        value = values.get(variable.name, variable.start)
        if value is not None:
            least, most = variable.minimum, variable.maximum
            free = float(value) * (1.0 + float(share))
            nudges[variable.name] = min(max(free, -inf if least is None else least), inf if most is None else most)
    return nudges


def _refuse_unfit(who: str, vehicle: VehicleData, opening: Callable[[], AbstractContextManager[Plant]]) -> None:
    """Refuse a plant from outside that is no train in short runs before its stop, on a good rail and on a poor one."""
    scenario, brakes = vehicle.scenario, vehicle.nominal.formation.brakes
    pressure, radius = tuple(g.pressure_max for g in brakes), tuple(g.wheel_radius for g in brakes)
    ideal = scenario.actuation.kind == "ideal"
    vent, fill = -1.0, 1.0
    trials = on_both_rails(
        opening,
        vehicle.layout,
        period=scenario.periods.communication,
        release=(0.0 if ideal else vent,) * len(brakes),
        brake=pressure if ideal else (fill,) * len(brakes),
    )
    speed, slowing = scenario.start.speed, vehicle.slowing
    results = findings(*trials, speed=speed, radius=radius, pressure=pressure, slowing=slowing)
    wrong = [f"'{finding.signal}' {finding.sentence}" for finding in results if not finding.good]
    if wrong:
        raise ScenarioError(f"{who}: in a short run before the stop {'; '.join(wrong[:4])}.")
