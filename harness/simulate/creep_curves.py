"""Adhesion over slip on rails of constant condition, and on rails that slip cleans."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from railgrip.base.arrays import Vector
from railgrip.scenario.adhesion import FrictionTable, TabulatedRail
from railgrip.scenario.load import load
from railgrip.scenario.surface import Recovery, SlipEnergy
from railgrip.scenario.track import Track, track_force_of
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.vehicle.signals import layout_of

CLEAN = Recovery(mu0=0.3, A=0.4, B=0.6, rate=1.9e-4)
"""A clean dry rail, and how fast slip uncovers it: Allotta, Meli, Ridolfi and Rindi (2014)."""
LOAD = 137e3
"""Of a wheelset [N]."""
STRIDE = 0.05
"""Between two places of the wheelsets [m]."""
SPEED = 80 / 3.6
"""Of the train [m/s], at the start of the test scenarios."""
SLIPS = np.concatenate([[0.0], np.geomspace(2e-3, 1.0, 80)])


def curves(
    polach: str | Mapping[str, Any], mu0: float, slips: Vector = SLIPS, *, speed: float = SPEED, way: float = 35.0
) -> tuple[Vector, Vector]:
    """Return adhesion at slips [1] on a rail of constant condition, (slips,), and on one that slip cleans.

    The latter, shape (slips, wheelsets), is the adhesion of each wheelset after all have slid over `way` with a slip.
    The cleaning is that of the creep curve, otherwise `CLEAN`.

    Args:
        polach: Name or numbers of the creep curve.
        mu0: Maximum friction of the rail before it is cleaned.
        slips: Slips [1].
        speed: Speed of the train [m/s].
        way: Distance that the wheelsets slide [m]; it must be the length of the train for the last ones to run on rail
            cleaned by the first ones.
    """
    plain = load(Path("plain"))
    adhesion = plain.tables()["adhesion"] | {"polach": polach if isinstance(polach, str) else dict(polach)}
    scenario = plain.replaced({"adhesion": adhesion})
    falling = scenario.adhesion.polach.A, scenario.adhesion.polach.B
    vehicle, same = VehicleData(scenario), np.ones(slips.size)
    as_it_lies = vehicle.contact(slips, speed * same, LOAD * same, mu0 * same)
    layout, count = layout_of(vehicle.formation), vehicle.formation.wheelsets
    profile = FrictionTable(over_time=True, step=1.0, mu0_at=np.full((1, count), mu0))
    cleaned = np.empty((slips.size, count))
    for slip, row in zip(slips, cleaned, strict=True):
        field = SlipEnergy(layout, scenario.adhesion.cleaning or CLEAN, falling, way)
        rail = TabulatedRail(layout, profile, track_force_of(Track(), mass=0.0), field)
        plant_outputs = np.zeros(layout.outputs)
        plant_outputs[layout.output["speed"]], plant_outputs[layout.output["slip"]] = speed, slip
        plant_outputs[layout.output["wheelset_load"]] = LOAD
        for place in np.arange(round(way / STRIDE)) * STRIDE:
            row[:] = vehicle.contact(np.full(count, slip), np.full(count, speed), np.full(count, LOAD), rail.mu0)
            plant_outputs[layout.output["distance"]], plant_outputs[layout.output["adhesion"]] = place, row
            rail.advance(0.0, plant_outputs)
    return as_it_lies, cleaned


def maxima(adhesion: Vector) -> list[int]:
    """Return the places at which a curve over slip stops rising: to fall, or at the locked wheel."""
    rising = np.append(np.diff(adhesion) > 0, False)
    return [int(place) for place in np.flatnonzero(rising[:-1] & ~rising[1:]) + 1]
