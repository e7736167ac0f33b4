"""Adhesion over slip on rails that stay as they lie, and on rails that slip cleans: figure 1 of the paper."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from railgrip.report import palette, style
from railgrip.scenario.adhesion import FrictionTable
from railgrip.scenario.load import load
from railgrip.scenario.profile import Recovery
from railgrip.scenario.track.table import Track, track_force_of
from railgrip.simulate.loop.rail import Field, TabulatedRail
from railgrip.simulate.vehicle import VehicleData
from railgrip.vehicle.signals import layout_of

Vector = NDArray[np.float64]

CLEAN = Recovery(mu0=0.3, A=0.4, B=0.6, rate=1.9e-4)
"""A clean dry rail, and how fast slip uncovers it: Allotta, Meli, Ridolfi and Rindi (2014)."""
LOAD = 137e3
"""Of a wheelset [N]."""
STRIDE = 0.05
"""Between two places of the wheelsets [m]."""
SPEED = 80 / 3.6
"""Of the train [m/s], at the start of the test scenarios."""
SLIPS = np.concatenate([[0.0], np.geomspace(2e-3, 1.0, 80)])


def curves(name: str, mu0: float, slips: Vector = SLIPS) -> tuple[Vector, Vector]:
    """Return adhesion at slips [1] on a rail that stays as it lies, (slips,), and on one that slip cleans.

    The latter, shape (slips, wheelsets), is that of each wheelset once all of them have slid far enough with a slip.
    """
    scenario = load(Path("plain"), [f"adhesion.polach={name}"])
    vehicle = VehicleData(scenario)
    same = np.ones(slips.size)
    as_it_lies = vehicle.contact(slips, SPEED * same, LOAD * same, mu0 * same)
    formation = vehicle.formation
    layout, count = layout_of(formation), formation.wheelsets
    profile = FrictionTable(over_time=True, step=1.0, mu0_at=np.full((1, count), mu0))
    way = formation.wheelset_position[-1] + 1.0
    cleaned = np.empty((slips.size, count))
    for slip, row in zip(slips, cleaned, strict=True):
        field = Field(layout, CLEAN, scenario.adhesion.polach, way)
        rail = TabulatedRail(layout, profile, track_force_of(Track(), mass=0.0), field)
        plant_outputs = np.zeros(layout.outputs)
        plant_outputs[layout.output["speed"]], plant_outputs[layout.output["slip"]] = SPEED, slip
        plant_outputs[layout.output["wheelset_load"]] = LOAD
        for place in np.arange(round(way / STRIDE)) * STRIDE:
            row[:] = vehicle.contact(np.full(count, slip), np.full(count, SPEED), np.full(count, LOAD), rail.mu0)
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


WET, LOW = ("wet", 0.15), ("low", 0.06)
"""Creep curve and maximum friction of both rails of figure 1."""


def figure_1_curves() -> list[CreepCurve]:
    """Return a wet rail, and a rail of low adhesion as it lies and as the first wheelset cleans it by its slip."""
    wet, _ = curves(*WET)
    low, cleaned = curves(*LOW)
    titles = [f"{name}, μ0 = {mu0:g}" for name, mu0 in (WET, LOW)]
    return [
        CreepCurve(label=f"{titles[0]}, rail as it lies", adhesion=wet, color=palette.BLUE, linestyle="--"),
        CreepCurve(label=f"{titles[1]}, rail as it lies", adhesion=low, color=palette.GREY, linestyle=":"),
        CreepCurve(label=f"{titles[1]}, cleaned by slip", adhesion=cleaned[:, 0], color=palette.BLACK, linestyle="-"),
    ]


def figure_1(lines: Sequence[CreepCurve]) -> Figure:
    """Draw adhesion over slip with a mark at each maximum, and the slip that the paper's slip-based control holds."""
    drawing, panel = style.panels(8, 3.8)
    panel.axvspan(
        10, 15, color=palette.ORANGE, alpha=0.25, linewidth=0, label="published: slip-based control holds 10 to 15 %"
    )
    for line in lines:
        panel.plot(100 * SLIPS, line.adhesion, color=line.color, linestyle=line.linestyle, label=line.label)
        for slip, adhesion in line.maxima:
            # Labels below the curve where another curve is above it, and where the axis ends.
            below = line.color == palette.GREY or slip == 1.0
            panel.plot(100 * slip, adhesion, "o", color=line.color, clip_on=False)
            panel.annotate(
                f"{100 * slip:.1f} %", (100 * slip, adhesion), xytext=(-2 if slip == 1.0 else 4, -20 if below else 6),
                textcoords="offset points", fontsize=8, color=line.color, ha="right" if slip == 1.0 else "left",
            )  # fmt: skip
    style.dress(panel, x="slip [%]", y="adhesion", title=f"creep curves at {SPEED * style.KMH:.0f} km/h, wheelset 1")
    panel.set_xlim(0, 100)
    panel.set_ylim(0, 0.14)
    style.legend(panel, loc="upper right")
    return drawing
