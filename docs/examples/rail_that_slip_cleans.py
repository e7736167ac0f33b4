"""Draws adhesion over slip where slip cleans the rail: python docs/examples/rail_that_slip_cleans.py FILE.png."""

import sys
from pathlib import Path

import numpy as np

from railgrip.report.palette import BLUE, GREEN, VERMILION
from railgrip.report.style import figure
from railgrip.scenario.adhesion import Profile
from railgrip.scenario.load import load
from railgrip.scenario.polach import Polach
from railgrip.scenario.profile import Recovery
from railgrip.scenario.track.table import Track, track_force_of
from railgrip.simulate.loop.rail import Field, TabulatedRail
from railgrip.simulate.vehicle import VehicleData
from railgrip.trace.contact import Contact
from railgrip.vehicle.formation import Formation
from railgrip.vehicle.signals import layout_of

CLEAN = Recovery(mu0=0.3, A=0.4, B=0.6, rate=1.9e-4)
LOAD = 137e3  # N, of a wheelset
STRIDE = 0.05  # m


def adhesion_over_slip(
    formation: Formation, contact: Contact, curve: Polach, mu0: float, slips: np.ndarray, speed: float, clean: Recovery
) -> np.ndarray:
    """Return the adhesion of each wheelset once all of them have slid far enough with a slip, (slips, wheelsets)."""
    layout, count = layout_of(formation), formation.wheelsets
    profile = Profile(over_time=True, step=1.0, mu0_at=np.full((1, count), mu0))
    way = formation.wheelset_position[-1] + 1.0
    alpha = np.empty((slips.size, count))
    for slip, row in zip(slips, alpha, strict=True):
        rail = TabulatedRail(layout, profile, track_force_of(Track()), Field(layout, clean, curve, way))
        plant_outputs = np.zeros(layout.outputs)
        plant_outputs[layout.output["speed"]], plant_outputs[layout.output["slip"]] = speed, slip
        plant_outputs[layout.output["wheelset_load"]] = LOAD
        for place in np.arange(round(way / STRIDE)) * STRIDE:
            row[:] = contact(np.full(count, slip), np.full(count, speed), np.full(count, LOAD), rail.mu0)
            plant_outputs[layout.output["distance"]], plant_outputs[layout.output["adhesion"]] = place, row
            rail.advance(0.0, plant_outputs)
    return alpha


def curves(name: str, mu0: float, slips: np.ndarray, speed: float = 80 / 3.6) -> tuple[np.ndarray, np.ndarray]:
    """Return adhesion on a rail that stays as it lies, (slips,), and where slip cleans it, (slips, wheelsets)."""
    scenario = load(Path("plain"), [f"adhesion.polach={name}"])
    vehicle = VehicleData(scenario)
    contact, curve = vehicle.contact, scenario.adhesion.polach
    same = np.ones(slips.size)
    as_it_lies = contact(slips, speed * same, LOAD * same, mu0 * same)
    cleaned = adhesion_over_slip(vehicle.formation, contact, curve, mu0, slips, speed, CLEAN)
    return as_it_lies, cleaned


def main(path: str) -> None:
    """Draw two published low-adhesion curves."""
    drawing = figure(9, 3.6)
    slips = np.concatenate([[0.0], np.geomspace(2e-3, 1.0, 60)])
    for axes, (name, mu0) in zip(drawing.subplots(1, 2, sharey=True), {"low": 0.06, "leaf": 0.05}.items(), strict=True):
        as_it_lies, cleaned = curves(name, mu0, slips)
        axes.plot(slips, as_it_lies, "k--", label="rail as it lies")
        for wheelset, color in ((0, BLUE), (1, GREEN), (5, VERMILION)):
            axes.plot(slips, cleaned[:, wheelset], color=color, label=f"wheelset {wheelset + 1}")
        axes.set(
            title=f"{name}, mu0 = {mu0:g}, 80 km/h", xlabel="slip of all wheelsets [1]", xlim=(0, 1), ylim=(0, None)
        )
    drawing.axes[0].set_ylabel("adhesion [1]")
    drawing.legend(*drawing.axes[0].get_legend_handles_labels(), loc="outside right upper", frameon=False)
    drawing.savefig(path, dpi=120)


if __name__ == "__main__":
    main(sys.argv[1])
