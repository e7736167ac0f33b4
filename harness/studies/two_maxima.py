"""Stops on rails with two maxima of adhesion over slip, and the flash temperature against numerical integration."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from matplotlib.figure import Figure
from typer import Option

from railgrip.api import Scenario
from railgrip.base.arrays import Vector
from railgrip.campaign.work import Work
from railgrip.report import palette, style
from railgrip.report.page import Page
from railgrip.report.stop import Stop
from railgrip.report.table import ReportTable, percent, write_tables
from railgrip.scenario.surface import named_set
from railgrip.simulate.run import run_stop
from railgrip.studies.papers.creep_curves import OWN_WAY, RAILS, SLIPS, SPEED, curves, maxima
from railgrip.studies.study import Study

PAGE = Path("docs/rail_models.md")
"""From the folder of the project, where the command runs."""

CAUSES = {"film alone": (), "heat": ("temperature_loss",), "cleaning": ("recovery",),
          "cleaning and heat": ("temperature_loss", "recovery")}  # fmt: skip
"""Keys of the creep curve that are switched on."""

LAWS: Mapping[str, Mapping[str, Any]] = {
    "slip up to 5 %": {"kind": "slip_two_state", "parameters": {"low": 0.035, "high": 0.05}},
    "slip of 20 to 30 %": {"kind": "slip_two_state", "parameters": {"low": 0.20, "high": 0.30}},
    "full brake": {"kind": "full_brake"},
}
"""Laws, one for each maximum and one that locks the wheels."""

PECLETS = (0.0, 1.0, 3.0, 10.0, 30.0)
"""Péclet numbers V a/(2 κ) of the contact's motion; a rolling wheel has some thousands."""

Case = tuple[str, str, str]
"""Rail, causes, law."""


def scenario_of(case: Case) -> Scenario:
    """Return the stop of a rail with the causes that are switched on, under a law."""
    rail, causes, law = case
    name, mu0 = RAILS[rail]
    polach = {
        key: value
        for key, value in named_set(name).items()
        if key not in ("temperature_loss", "recovery") or key in CAUSES[causes]
    }
    changes = {"adhesion.polach": polach, "adhesion.mu0": mu0, "controller": LAWS[law], "estimator": {"kind": "none"},
               "limits.horizon": "200 s", "periods.trace": "1 ms"}  # fmt: skip
    return Scenario.load("plain", changes)


def energy_error(stop: Stop) -> float:
    """Return the largest deviation of the energy from that at the start, relative to it."""
    parts = ("kinetic_energy", "contact_heat", "pad_heat", "resistance_work")
    energy = np.sum([stop.trace[name].values for name in parts], axis=0)
    return float(np.abs(energy / energy[0] - 1.0).max())


def first_slide(stop: Stop) -> tuple[Vector, Vector]:
    """Return slip and adhesion of wheelset 1 from the start until it locks, or until its slip falls."""
    slip, adhesion = stop.trace["slip"].values[:, 0], stop.trace["adhesion"].values[:, 0]
    end = int(np.argmax(slip >= 0.995)) or len(slip)
    return slip[:end], adhesion[:end]


def _stop_row(case: Case) -> dict[str, Any]:
    stop = run_stop(scenario_of(case))
    return {
        "case": case,
        "distance": stop.metrics.distance,
        "outcome": stop.outcome.value,
        "energy": energy_error(stop),
        "slide": first_slide(stop),
    }


def maxima_of_slide(slip: Vector, adhesion: Vector) -> list[tuple[float, float]]:
    """Return slip and adhesion at the maxima of a slide, on a grid of slips that is coarser than the samples."""
    rising = np.maximum.accumulate(slip)
    grid = np.geomspace(5e-3, min(rising[-1], 0.98), 60)
    sampled = np.interp(grid, rising, adhesion)
    return [(float(grid[place]), float(sampled[place])) for place in maxima(sampled) if place < grid.size - 1]


def stops_table(rows: list[dict[str, Any]]) -> ReportTable:
    """Return distances by law, maxima in the slide of a full brake, and the error of the energy."""
    found = {row["case"]: row for row in rows}
    table: list[dict[str, Any]] = []
    for rail, causes in dict.fromkeys((rail, causes) for rail, causes, _ in found):
        here = {law: found[rail, causes, law] for law in LAWS}
        peaks = maxima_of_slide(*here["full brake"]["slide"])
        table.append(
            {"rail": rail, "switched on": causes}
            | {law: row["distance"] for law, row in here.items()}
            | {
                "maxima in the slide of wheelset 1": ", ".join(f"{100 * slip:.0f} %" for slip, _ in peaks),
                "energy error": f"{max(row['energy'] for row in here.values()):.0e}",
            }
        )
    return ReportTable(table, dict.fromkeys(LAWS, "{:.1f} m"), ("rail", "switched on"), title="Stops from 80 km/h")


def mean_rise(peclet: float, cells: int = 128) -> float:
    """Return the mean temperature rise under a moving circle of uniform heat, times k/(q a), by quadrature.

    The kernel is Rosenthal's moving point source on a half-space, e^(−Pe (R + ξ))/(2 π R), where ξ is the distance
    ahead of the source. Its pole is integrated over its cell.
    """
    width = 2.0 / cells
    axis = width * (np.arange(cells) - (cells - 1) / 2)
    inside = np.add.outer(axis**2, axis**2) <= 1.0
    offset = width * np.arange(1 - cells, cells)
    ahead, across = np.meshgrid(offset, offset, indexing="ij")
    distance = np.hypot(ahead, across)
    pole = distance == 0.0
    distance[pole] = 1.0
    kernel = np.exp(-peclet * (distance + ahead)) / (2 * np.pi * distance) * width**2
    kernel[pole] = 4 * width * np.log(1 + np.sqrt(2)) / (2 * np.pi)
    shape = [2 * cells + cells - 2] * 2
    rise = np.fft.irfft2(np.fft.rfft2(kernel, shape) * np.fft.rfft2(inside.astype(float), shape), shape)
    return float(rise[cells - 1 : 2 * cells - 1, cells - 1 : 2 * cells - 1][inside].mean())


def interpolated_rise(peclet: float) -> float:
    """Return the same by `RailBraking.Contact.flashResistance`."""
    return 1.2204 / np.sqrt(np.pi * (0.658 + peclet))


def flash_table() -> ReportTable:
    """Return the mean temperature under a moving circle: formula, quadrature and their difference."""
    rises = [(f"{peclet:g}", interpolated_rise(peclet), mean_rise(peclet)) for peclet in PECLETS]
    columns = {"Péclet number": "", "formula": "{:.4f}", "quadrature": "{:.4f}", "deviation": percent}
    return ReportTable.of(columns, [(number, formula, mean, formula / mean - 1) for number, formula, mean in rises])


def slide_figure(rows: list[dict[str, Any]]) -> Figure:
    """Draw adhesion over slip in the slide of a full brake on the curve of steady slip."""
    drawing, panel = style.panels(8, 3.8)
    for rail, color in (("wet", palette.BLUE), ("leaves", palette.BLACK)):
        _, steady = curves(*RAILS[rail], way=OWN_WAY)
        slip, adhesion = next(r["slide"] for r in rows if r["case"] == (rail, "cleaning and heat", "full brake"))
        panel.plot(100 * SLIPS, steady[:, 0], color=color, label=f"{rail}, steady at {SPEED * style.KMH:.0f} km/h")
        panel.plot(100 * slip, adhesion, color=color, linestyle="--", label=f"{rail}, until wheelset 1 locks")
    style.dress(panel, x="slip [%]", y="adhesion", title="full brake, wheelset 1")
    panel.set_xlim(0, 100)
    panel.set_ylim(0, None)
    style.legend(panel, loc="upper right")
    return drawing


@dataclass(frozen=True)
class MaximaOfAdhesion(Study, quick="without heat or cleaning alone"):
    """Stop on a wet rail and on leaves, with cleaning and heat of the contact switched on and off."""

    write: Annotated[bool, Option("--write", help="Write the tables into docs/rail_models.md.")] = False

    def page(self, work: Work) -> Page:
        """Return distances by cause and law, and the deviation of the flash temperature."""
        combined = [causes for causes in CAUSES if not self.quick or len(CAUSES[causes]) != 1]
        cases = [(rail, causes, law) for rail in RAILS for causes in combined for law in LAWS]
        rows = work.map(_stop_row, cases)
        stops, flash = stops_table(rows), flash_table()
        if self.write:
            write_tables(PAGE, {"causes": stops, "flash": flash})
        return Page(
            title="Two maxima of adhesion over slip",
            question="Which slip stops a train earlier, where slip cleans and heats the contact?",
            answer="On the wet rail and on leaves, adhesion has one maximum with the film alone, rises until the "
            "wheel locks with cleaning alone, and has two maxima with cleaning and heat. The table shows which of "
            "them a law should hold.",
            template="studies/two_maxima.md.jinja",
            values={"stops": stops, "flash": flash},
            figures={"two_maxima.png": slide_figure(rows)},
            tables={"stops.csv": stops, "flash.csv": flash},
            screen=(stops, flash),
        )


STUDY = MaximaOfAdhesion
