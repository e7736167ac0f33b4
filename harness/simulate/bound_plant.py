"""The plant of a scenario, bound to the vectors of the loop.

Wheel radius and creep curve of a compiled plant are read back from its outputs. A compiler that drops a modifier leaves
parameters at their defaults without an error: the FMU has the parameter, but its contacts have another value. That
value follows from relations between outputs: slip is (v - r w)/sqrt(v² + v_small²), and adhesion that of the contact
law at slip, speed, load and mu0.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from functools import partial
from math import inf, isnan

import numpy as np

from railgrip.base.arrays import Matrix, generator
from railgrip.base.errors import FmuError, PlantFailed, ScenarioError
from railgrip.base.names import ElementName
from railgrip.base.units import GRAVITY
from railgrip.fmi import Binding, Description, Port, bind, foreign_code, open_plant
from railgrip.scenario.track import STEEPEST
from railgrip.scenario.vehicle_table import (
    FmuFile,
    LibraryPlant,
    ModelicaPlant,
    Nudge,
    PythonClass,
    RecipePlant,
    TrainFile,
)
from railgrip.simulate.contact import compiled_contact
from railgrip.simulate.loop.interfaces import LoopPlant
from railgrip.simulate.named_models import is_trusted, parameters_of
from railgrip.simulate.plant_trial import (
    LONGEST_TRIAL,
    SignalCheck,
    TrialPlant,
    Trials,
    findings,
    order_findings,
    reacts,
)
from railgrip.simulate.user_parts import NEEDED, CustomPlant
from railgrip.simulate.vehicle_data import Opening, VehicleData
from railgrip.vehicle.formation import carried_mass
from railgrip.vehicle.parameters import COUNTS, DESCRIPTIVE
from railgrip.vehicle.signals import CURVE, Layout, Signal, plant_inputs


def plant_signals(
    layout: Layout, *, pneumatic: bool, track_force: bool
) -> tuple[tuple[Port, ...], tuple[Port, ...], Port]:
    """Return inputs and outputs of a plant, and the parameter for its initial speed.

    Args:
        pneumatic: Whether the plant takes valve positions; else it takes pressures.
        track_force: Whether the plant must have the input for the track force.
    """
    names = {"command": "valve_command" if pneumatic else "pressure_command"}

    def port(signal: Signal, *, needed: bool) -> Port:
        size = 0 if signal.extent == "train" else layout.formation.width(signal.extent)
        return Port(name=names.get(signal.name, signal.name), unit=signal.unit, size=size, needed=needed)

    # In the order of the loop's vector, so that each value arrives at the variable of its name.
    sent = plant_inputs(layout, pneumatic=pneumatic)
    inputs = tuple(port(signal, needed=signal.name != "track_force" or track_force) for signal in sent)
    outputs = tuple(port(signal, needed=signal.name in NEEDED) for signal in layout.signals["output"])
    return inputs, outputs, Port(name="start_speed", unit="m/s", size=0, needed=True)


def binding_of(vehicle: VehicleData) -> Binding:
    """Return the binding of the plant's FMU to the vectors of the loop.

    Raises:
        FmuError: The FMU does not fit.
    """
    scenario = vehicle.scenario
    inputs, outputs, start = plant_signals(
        vehicle.layout, pneumatic=scenario.actuation.kind == "pneumatic", track_force=_needs_force(vehicle)
    )
    return bind(
        vehicle.file,
        inputs=inputs,
        outputs=outputs,
        parameters=(start,),
        table=scenario.vehicle.map,
        where=f"{scenario.name}: [vehicle.map]",
    )


def _needs_force(vehicle: VehicleData) -> bool:
    """Return whether a force other than zero acts along the track in the stop."""
    return bool(np.any(vehicle.track_force.forces)) or vehicle.scenario.has_traction


def values_of(vehicle: VehicleData, binding: Binding) -> dict[str, float]:
    """Return the parameters of the plant's FMU that the scenario sets, in its names and units, before any nudge.

    Raises:
        ScenarioError: Friction falls with temperature on this rail, and not in the contacts of this plant.
    """
    scenario, variables = vehicle.scenario, vehicle.file.variables
    surface, is_recipe = scenario.adhesion.polach.contact_parameters(), isinstance(scenario.vehicle.source, RecipePlant)
    if "temperature_loss" in surface.keys() - variables.keys():
        raise ScenarioError(
            f"{scenario.name}: [adhesion] polach has temperature_loss, which the contacts of {vehicle.file.file.name} "
            "lack; use the two-part train, the wagon or a train file, or leave temperature_loss out"
        )
    shape = {name: value for name, value in surface.items() if is_recipe or name in variables}
    return binding.translate({"start_speed": scenario.start.speed}) | shape | vehicle.changes


def fmu_plant(stop: Opening) -> LoopPlant:
    """Open the plant FMU of a scenario; a foreign one makes two short runs first.

    Raises:
        ScenarioError: The short run contradicts physics, or the track is too steep for the train.
        FmuError: The FMU does not fit.
    """
    vehicle, scenario, description = stop.vehicle, stop.vehicle.scenario, stop.vehicle.file
    table = scenario.vehicle
    _refuse_steep_track(vehicle)
    source, binding = table.source, binding_of(vehicle)
    values = values_of(vehicle, binding)
    opening = partial(
        open_plant,
        description,
        binding,
        period=scenario.periods.communication,
        span=(scenario.plant_begin, scenario.horizon),
        parameters=values if table.nudge is None else values | perturb_parameters(values, description, table.nudge),
        trusted=is_trusted(scenario.vehicle),
        limits=scenario.limits.fmu,
    )
    if isinstance(source, FmuFile) and table.trust:
        stop.stack.enter_context(foreign_code(description.file.name))
    # The class of a train file consists of built-in parts; delays by a distributor or a long pipe would fail the trial.
    if not isinstance(source, LibraryPlant) or (isinstance(source, TrainFile) and table.map):
        # The stop will report the failure.
        with suppress(PlantFailed):
            quiet = partial(opening, notify=lambda sentence: None, span=(scenario.plant_begin, LONGEST_TRIAL))
            _refuse_unfit(f"[vehicle.map] does not fit {description.file.name}", vehicle, quiet)
    key = (description.digest, scenario.actuation.kind, *values.items(), *vehicle.curves[0])
    if (
        isinstance(source, ModelicaPlant)
        and not {"slip", "adhesion"} & set(binding.outputs.absent)
        and key not in _read_back
    ):
        with suppress(PlantFailed), opening(notify=lambda sentence: None) as first:
            _require_compiled_parameters(vehicle, first, parameters_of(description) | values)
            _read_back.add(key)
    stop.add_fmu(description, "plant")
    return stop.stack.enter_context(opening(notify=stop.notify))


_read_back: set[tuple[object, ...]] = set()
"""FMUs with the parameters for which the read-back has been done in this process."""


def _require_compiled_parameters(vehicle: VehicleData, plant: LoopPlant, parameters: Mapping[str, float]) -> None:
    """Compare wheel radius and creep curve of a plant's contacts with its parameters.

    The contact law of a user's class may differ, so its curve is not compared.

    Raises:
        FmuError: Radius or curve differ.
    """
    scenario, layout = vehicle.scenario, vehicle.layout
    groups = layout.formation.groups
    ideal = scenario.actuation.kind == "ideal"
    brake = tuple(group.pressure_max if ideal else 1.0 for group in vehicle.nominal.formation.brakes)
    curve = dict(zip(scenario.adhesion.polach.plant_parameters(), vehicle.curves[0].tolist(), strict=True))
    rows = probe_outputs(plant, layout, period=scenario.periods.communication, brake=brake, curve=curve)
    radii = [parameters.get(f"r_wheel[{g + 1}]", parameters.get("r_wheel")) for g in range(groups)]
    known = [radius for radius in radii if radius is not None]
    if len(known) < groups:
        return
    _require_radius(vehicle, rows, known, parameters.get("v_small", V_SMALL))
    if isinstance(scenario.vehicle.source, LibraryPlant):
        _require_curve(vehicle, rows, known, {**parameters, **curve})


def require_python_plant(vehicle: VehicleData, plant: CustomPlant) -> CustomPlant:
    """Return a plant in Python, after two short runs of it.

    Raises:
        ScenarioError: The short run contradicts physics, or the track is too steep for the train.
    """
    _refuse_steep_track(vehicle)
    with suppress(PlantFailed):  # the stop will report the failure
        _refuse_unfit(f"{vehicle.scenario.name}: {plant.name} is not a plant", vehicle, lambda: nullcontext(plant))
    return plant


def _refuse_steep_track(vehicle: VehicleData) -> None:
    """Raise an error for a track that is too steep for a train of this mass; a foreign plant's mass may be unknown."""
    mass = vehicle.mass
    most, force = STEEPEST * GRAVITY * mass, float(max(vehicle.track_force.forces, key=np.abs))
    if mass and abs(force) > most:
        raise ScenarioError(
            f"[track] puts {force:.6g} N on a train of {mass:.6g} kg, but a gradient of {100 * STEEPEST:.0f} % only "
            f"{most:.6g} N; correct [track] force, gradient or curve."
        )


def perturb_parameters(values: Mapping[str, float], description: Description, nudge: Nudge) -> dict[str, float]:
    """Return all real parameters of a plant, each multiplied by a random factor, uniform within 1 ± `nudge.relative`.

    A parameter at its bound stays there if it would be moved beyond. Parameters that only describe the vehicle get no
    draw; the counts of groups, which do not affect the plant either, keep their draws so that old results stay
    reproducible.
    """
    idle = DESCRIPTIVE.keys() - {COUNTS}
    real = [
        v
        for v in description.variables.values()
        if v.causality == "parameter" and v.kind == "Real" and ElementName.of(v.name).array not in idle
    ]
    shares = generator(nudge.seed, "plant parameters").uniform(-nudge.relative, nudge.relative, len(real))
    nudges: dict[str, float] = {}
    for variable, share in zip(real, shares, strict=True):
        value = values.get(variable.name, variable.start)
        if not isnan(value):
            least, most = variable.minimum, variable.maximum
            free = value * (1.0 + float(share))
            nudges[variable.name] = min(max(free, -inf if least is None else least), inf if most is None else most)
    return nudges


def _refuse_unfit(who: str, vehicle: VehicleData, opening: Callable[[], AbstractContextManager[LoopPlant]]) -> None:
    """Raise an error for a foreign plant that contradicts physics in short runs, on a good rail and on a poor one."""
    scenario, brakes = vehicle.scenario, vehicle.nominal.formation.brakes
    pressure, radius = tuple(g.pressure_max for g in brakes), tuple(g.wheel_radius for g in brakes)
    is_ideal, speed = scenario.actuation.kind == "ideal", scenario.start.speed
    plant = TrialPlant(
        opening=opening,
        layout=vehicle.layout,
        period=scenario.periods.communication,
        release=(0.0 if is_ideal else -1.0,) * len(brakes),
        brake=pressure if is_ideal else (1.0,) * len(brakes),
    )
    trials = plant.trials()
    results = findings(*trials, speed=speed, radius=radius, pressure=pressure, slowing=vehicle.slowing)
    wrong = [f"'{finding.signal}' {finding.sentence}" for finding in results if not finding.good]
    if not wrong:
        # Differences between groups are only clear in a plant that brakes and slides as a whole.
        wrong = [f"'{f.signal}' {f.sentence}" for f in _further_findings(vehicle, trials, plant) if not f.good]
    if wrong:
        raise ScenarioError(f"{who}: in a short run before the stop {'; '.join(wrong[:4])}.")


def _further_findings(vehicle: VehicleData, trials: Trials, plant: TrialPlant) -> Iterator[SignalCheck]:
    """Yield the findings of runs in which groups differ, and of one with a force on the train."""
    for run in plant.orders():
        yield from order_findings(run, reacts=reacts(*trials))
    # A plant in Python may ignore a force that is always zero.
    takes_force = (
        _needs_force(vehicle)
        if isinstance(vehicle.scenario.vehicle.source, PythonClass)
        else "track_force" not in binding_of(vehicle).inputs.absent
    )
    if takes_force:
        load = trials[0].output("wheelset_load")[trials[0].coasting - 1]
        known = vehicle.mass or (carried_mass(float(load.sum())) if np.isfinite(load).all() else 0.0)
        guess = carried_mass(sum(vehicle.nominal.formation.wheelset_load))
        yield plant.force_finding(known or guess, is_known=bool(known))


RADIUS_TOLERANCE = 1e-3
"""Relative tolerance of the radius.

A solver's slip is accurate to 1e-6 or better, and half a millimetre is the smallest wear that users set.
"""
ADHESION_TOLERANCE = 1e-3
"""Relative to mu0: the same, and the load is rounded by the square of 50 N over it.

Published creep curves differ a hundred times as much somewhere below `_SLIDING`.
"""
_SLIDING = 0.1
_WALKING = 2.0  # m/s; twenty times the speed below which slip is regularised
_MAX_FILLING_TIME = (
    4.0  # s; passenger trains fill cylinders in 3 to 5 s (UIC 540), on this rail wheels slide before that
)
_RAIL = 0.06
_ADVICE = "the compiler lost a modifier: report it with the compiler's version, or use the other compiler."
V_SMALL = 0.1  # m/s, of a plant that does not declare it: RailBraking.Components.Wheelsets


def probe_outputs(
    plant: LoopPlant, layout: Layout, *, period: float, brake: tuple[float, ...], curve: Mapping[str, float]
) -> Matrix:
    """Return the outputs of a plant that brakes on a poor rail until its wheels slide, one row per sample.

    Args:
        plant: Plant that has not been started.
        layout: Layout of its vectors.
        period: Its communication period [s].
        brake: Full brake command of each group.
        curve: Polach's four numbers, for a plant with inputs for them.

    Raises:
        PlantFailed: The plant refused a step.
    """
    inputs = np.zeros(layout.inputs)
    inputs[layout.input["command"]], inputs[layout.input["mu0"]] = brake, _RAIL
    for signal, value in zip(CURVE, curve.values(), strict=True):
        if signal.name in layout.input:
            inputs[layout.input[signal.name]] = value
    rows = [plant.start(inputs).copy()]
    slip, speed = layout.output["slip"], layout.output["speed"].start
    for _ in range(round(_MAX_FILLING_TIME / period)):
        rows.append(plant.step(inputs).copy())
        if np.nanmin(rows[-1][slip]) > _SLIDING or rows[-1][speed] < 0.5 * rows[0][speed]:
            break
    return np.array(rows)


def _require_radius(vehicle: VehicleData, rows: Matrix, expected: Sequence[float], v_small: float) -> None:
    """Compare the radius of each group's contacts with the expected one [m].

    Args:
        vehicle: Vehicle of the plant.
        rows: Outputs of the plant, one row per sample.
        expected: Expected radius of each group [m].
        v_small: Speed below which slip is regularised [m/s].

    Raises:
        FmuError: A radius differs.
    """
    v, w, slip = (rows[0, vehicle.layout.output[name]] for name in ("speed", "wheelset_speed", "slip"))
    if not np.all(w > 0.0):
        return  # at rest no speed reveals a radius; the same FMU is checked when it starts moving
    found = (v - slip * np.sqrt(v**2 + v_small**2)) / w
    for g, (here, there) in enumerate(zip(found.tolist(), expected, strict=True)):
        if abs(here / there - 1.0) > RADIUS_TOLERANCE:
            raise FmuError(
                f"{vehicle.file.file.name}: the contacts of group {g + 1} have a wheel radius of {here:.6g} m by "
                f"slip[{g + 1}], speed and wheelset_speed[{g + 1}], its parameter r_wheel is {there:.6g} m; {_ADVICE}"
            )


def _require_curve(vehicle: VehicleData, rows: Matrix, radii: Sequence[float], parameters: Mapping[str, float]) -> None:
    """Compare the adhesion of each wheelset with that of the expected creep curve.

    Args:
        vehicle: Vehicle of the plant.
        rows: Outputs of the plant on the rail of the probe, one row per sample.
        radii: Radius of each group [m].
        parameters: Parameters of the plant, with the expected curve.

    Raises:
        FmuError: The curve differs.
    """
    layout = vehicle.layout
    # A wheel on a roller contacts it like a smaller wheel on a rail: their curvatures add.
    bend = 1.0 / parameters["r_roller"] if "r_roller" in parameters else 0.0
    contacts = [
        compiled_contact(*vehicle.contact_arguments({**parameters, "r_wheel": radius / (1.0 + radius * bend)}))
        for radius in radii
    ]
    speed = rows[:, layout.output["speed"]][:, 0]
    slip, adhesion, load = (rows[:, layout.output[name]] for name in ("slip", "adhesion", "wheelset_load"))
    # In a long train the front brakes before the rear, and each car has its own speed, by its wheels unless they lock.
    rolling = slip < 0.5
    of_car = rows[:, layout.output["wheelset_speed"]] * np.array(radii) / (1.0 - np.where(rolling, slip, 0.0))
    of_car = np.where(rolling, of_car, speed[:, np.newaxis])
    for i, g in enumerate(layout.formation.group_of_wheelset):
        rail = np.full(len(rows), _RAIL)
        expected = contacts[g](slip[:, g], of_car[:, g], load[:, i], rail)
        # At walking pace the regularisation of the slip matters, and a probe from there does not reveal the curve.
        error = np.where(speed > _WALKING, np.abs(adhesion[:, i] - expected), 0.0)
        worst = int(np.argmax(error))
        if error[worst] > ADHESION_TOLERANCE * _RAIL:
            names = vehicle.scenario.adhesion.polach.plant_parameters()
            values = ", ".join(f"{name} = {parameters[name]:g}" for name in names)
            raise FmuError(
                f"{vehicle.file.file.name}: adhesion[{i + 1}] is {adhesion[worst, i]:.6g} at slip {slip[worst, g]:.4g} "
                f"and mu0 {_RAIL:g}, by the creep curve of the scenario ({values}) it is {expected[worst]:.6g}; "
                f"{_ADVICE}"
            )
