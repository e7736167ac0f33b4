"""Adhesion over slip on rails of constant condition, and on rails that slip cleans and heats: figure 1 of the paper."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from railgrip.api import Scenario
from railgrip.base.arrays import Vector
from railgrip.report import palette, style
from railgrip.scenario.adhesion import FrictionTable, TabulatedRail
from railgrip.scenario.surface import Recovery, SlipEnergy, named_set
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
    scenario = Scenario.load("plain", {"adhesion.polach": polach})
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


@dataclass(frozen=True, slots=True, kw_only=True)
class CreepCurve:
    """A line of figure 1: its name, adhesion at `SLIPS`, colour and line style."""

    label: str
    adhesion: Vector
    color: str
    linestyle: str

    @property
    def maxima(self) -> list[tuple[float, float]]:
        """Slip and adhesion at each maximum."""
        return [(float(SLIPS[place]), float(self.adhesion[place])) for place in maxima(self.adhesion)]


RAILS = {"wet": ("wet_two_maxima", 0.15), "leaves": ("leaves_two_maxima", 0.06)}
"""Creep curve and maximum friction of both rails of figure 1."""
SPEEDS = {40: ":", 80: "-", 120: "--"}
"""Line style by speed [km/h]."""
OWN_WAY = 10.0
"""Distance over which the friction of the first wheelset settles with its own slip [m], which takes 200 strides."""


def causes() -> list[CreepCurve]:
    """Return the rail with leaves at `SPEED`: heated by slip, cleaned by it, and both."""
    name, mu0 = RAILS["leaves"]
    cold = {key: value for key, value in named_set(name).items() if key != "temperature_loss"}
    heated, both = curves(name, mu0, way=OWN_WAY)
    _, cleaned = curves(cold, mu0, way=OWN_WAY)
    return [
        CreepCurve(label="leaves, heat alone", adhesion=heated, color=palette.GREY, linestyle=":"),
        CreepCurve(label="leaves, cleaning alone", adhesion=cleaned[:, 0], color=palette.GREEN, linestyle="--"),
        CreepCurve(label="leaves, cleaning and heat", adhesion=both[:, 0], color=palette.BLACK, linestyle="-"),
    ]


def rails() -> list[CreepCurve]:
    """Return both rails of figure 1, cleaned and heated by slip, at `SPEEDS`."""
    return [
        CreepCurve(
            label=f"{rail}, {speed} km/h",
            adhesion=curves(*RAILS[rail], speed=speed / 3.6, way=OWN_WAY)[1][:, 0],
            color=color,
            linestyle=linestyle,
        )
        for rail, color in (("wet", palette.BLUE), ("leaves", palette.BLACK))
        for speed, linestyle in SPEEDS.items()
    ]


def figure_1(of_causes: Sequence[CreepCurve], of_rails: Sequence[CreepCurve]) -> Figure:
    """Draw adhesion over slip with a mark at each maximum, and the slip that the paper's slip-based control holds."""
    drawing, panels = style.panels(10, 4.2, 1, 2, sharey=True)
    for panel, lines in zip(panels, (of_causes, of_rails), strict=True):
        panel.axvspan(10, 15, color=palette.ORANGE, alpha=0.25, linewidth=0, label="held by slip-based control")
        for line in lines:
            panel.plot(100 * SLIPS, line.adhesion, color=line.color, linestyle=line.linestyle, label=line.label)
            for slip, adhesion in line.maxima:
                panel.plot(100 * slip, adhesion, "o", markersize=4, color=line.color, clip_on=False)
        style.legend(panel, loc="upper left")
        panel.set_xlim(0, 100)
    style.dress(panels[0], x="slip [%]", y="adhesion", title=f"causes, {SPEED * style.KMH:.0f} km/h, wheelset 1")
    style.dress(panels[1], x="slip [%]", title="wet rail and leaves, wheelset 1")
    panels[0].set_ylim(0, 0.26)
    return drawing
