"""The rail of a scenario with its sand, and the driver."""

from collections.abc import Sequence

import numpy as np

from railgrip.base.errors import ScenarioError
from railgrip.base.units import GRAVITY
from railgrip.rolling_stock.schema import load_train
from railgrip.scenario.adhesion import position_of, profile_of, reach_of
from railgrip.scenario.profile import FromTable, Points
from railgrip.scenario.schema import Scenario
from railgrip.scenario.surface import Sander
from railgrip.scenario.vehicle import TrainFile
from railgrip.simulate.loop.driver import Driver, phases_of
from railgrip.simulate.loop.rail import SandedRail, SlipEnergy, TabulatedRail
from railgrip.simulate.vehicle import VehicleData
from railgrip.vehicle.formation import Formation


def rail_of(vehicle: VehicleData) -> TabulatedRail:
    """Return the rail of a scenario, before any wheel has passed.

    Raises:
        ScenarioError: The positions of the wheelsets are not given, or a sander is at a wheelset that does not exist.
    """
    scenario, layout = vehicle.scenario, vehicle.layout
    adhesion, formation = scenario.adhesion, layout.formation
    slip_energy = None
    if adhesion.cleaning is not None:
        position_of(scenario, formation)
        *_, share, decay = vehicle.curves[0].tolist()
        falling = adhesion.polach.model_copy(update={"A": share, "B": decay})
        slip_energy = SlipEnergy(layout, adhesion.cleaning, falling, reach_of(scenario))
    sand = None
    if adhesion.sand is not None and (sanders := _sanders(scenario, formation)):
        position_of(scenario, formation)
        sand = SandedRail(layout, sanders, reach_of(scenario), adhesion.sand)
    return TabulatedRail(
        layout, profile_of(scenario, formation), vehicle.track_force, slip_energy, sand, vehicle.curves
    )


def _sanders(scenario: Scenario, formation: Formation) -> Sequence[Sander]:
    sanders, source = scenario.sanders, scenario.vehicle.source
    if not sanders and isinstance(source, TrainFile):
        sanders = load_train(source.file.path).sanders
    for number, sander in enumerate(sanders, start=1):
        if sander.wheelset > formation.wheelsets:
            raise ScenarioError(
                f"{scenario.name}: [sanders[{number}]] is at wheelset {sander.wheelset}, the vehicle has "
                f"{formation.wheelsets}"
            )
    return sanders


def doubts(scenario: Scenario) -> list[str]:
    """Return a sentence for each file of a scenario whose axis appears to have another unit than declared."""
    adhesion, demand, speed = scenario.adhesion, scenario.demand, scenario.start.speed
    has_traction = demand is not None and demand.has_traction
    sentences: list[str] = []
    if isinstance(adhesion, FromTable):
        columns = adhesion.curve.columns
        strongest = GRAVITY * adhesion.factor * float(columns.values.max())
        if adhesion.over == "distance":
            sentences += _late_begin(f"[adhesion] file {adhesion.file.entry}", float(columns.points[0]))
            doubt = columns.doubt(speed**2 / (2.0 * strongest), reach_of(scenario))
        else:
            doubt = columns.doubt(speed / strongest, scenario.horizon)
        sentences += [f"[adhesion] file {adhesion.file.entry} {doubt}"] if doubt else []
    if isinstance(adhesion, Points) and adhesion.over == "distance":
        sentences += _late_begin("[adhesion] points", adhesion.places[0])
    if demand is not None and demand.file is not None:
        doubt = demand.profile().doubt(0.0 if has_traction else speed / GRAVITY, scenario.horizon)
        sentences += [f"[demand] file {demand.file.entry} {doubt}"] if doubt else []
    return [f"{scenario.name}: {sentence}." for sentence in sentences]


def _late_begin(what: str, begin: float) -> list[str]:
    """Return a sentence if a profile over distance begins after the brake demand [m]."""
    if begin <= 0.0:
        return []
    return [f"{what} begins {begin:g} m after the brake demand; until there, the friction of its first point applies"]


def driver_of(vehicle: VehicleData) -> Driver:
    """Return the driver of a scenario, who uses the nominal data of the brakes.

    Raises:
        ScenarioError: [demand] gives pressures for another number of groups, or above the maximum of a brake.
    """
    scenario, layout = vehicle.scenario, vehicle.layout
    brakes, demand = layout.formation.brakes, scenario.demand
    full = np.array([brake.pressure_max for brake in brakes])
    release_pressure = np.array([brake.pressure_of(0.0) for brake in brakes])
    phases = None if demand is None else phases_of(layout, demand, full.tolist(), scenario.name)
    binding = not getattr(scenario.controller, "redistribute", False)
    return Driver(
        layout, scenario.periods.communication, full=full, release_pressure=release_pressure, phases=phases,
        binding=binding,
    )  # fmt: skip
