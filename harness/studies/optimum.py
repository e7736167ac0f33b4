"""How short a stop can be on known rails: the ideal bound, the shortest stop with held slips, and stops of laws.

On the rail that slip cleans, the laws of the type test also stop with valves and sensors in service.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from typer import Option

from railgrip.api import Scenario
from railgrip.base import registry
from railgrip.campaign.work import Work
from railgrip.report.page import Page
from railgrip.report.table import ReportTable, write_tables
from railgrip.scenario.file import merge
from railgrip.scenario.load import scenario_of
from railgrip.simulate.ideal import held_stop
from railgrip.simulate.run import run_stop
from railgrip.studies.papers.creep_curves import CLEAN
from railgrip.studies.study import Study
from railgrip.studies.type_test.entrants import LIBRARY, entrants, train_of
from railgrip.studies.type_test.study import PAGE as PAGE_OF_LAWS

LAWS: Mapping[str, Mapping[str, Any]] = {
    "slip up to 5 %": {"kind": "slip_two_state", "parameters": {"low": 0.035, "high": 0.05}},
    "slip of 20 to 30 %": {"kind": "slip_two_state", "parameters": {"low": 0.20, "high": 0.30}},
    "full brake": {"kind": "full_brake"},
}
"""Laws, one for each maximum and one that locks the wheels."""

PAGE = Path("docs/rail_models.md")
"""From the folder of the project, where the command runs."""

RAILS: Mapping[str, Mapping[str, Any]] = {
    "dry": {"adhesion.mu0": 0.05},
    "dry that slip cleans": {"adhesion.mu0": 0.05, "adhesion.recovery": CLEAN.model_dump()},
    "wet, cleaning and heat": {"adhesion.polach": "wet_two_maxima", "adhesion.mu0": 0.15},
    "leaves, cleaning and heat": {"adhesion.polach": "leaves_two_maxima", "adhesion.mu0": 0.06},
}
"""Changes of the scenario `plain`."""

SLIPS = (0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0)
"""Slips that a group may hold."""

ESTIMATING = ("slope_seeking", "two_maxima")
"""Laws that use the estimates of the scenario."""


def shortest_held(scenario: Scenario, groups: int, held: Sequence[float] = SLIPS) -> tuple[float, Sequence[float]]:
    """Return the distance and the slips of the shortest stop in which each group holds one of some slips.

    From locked wheels on, the slip of one group after the other is chosen, the last one first: its slip matters to no
    other.
    """
    slips = [1.0] * groups
    distance = held_stop(scenario, slips).metrics.distance
    for group in reversed(range(groups)):
        for slip in held:
            changed = [*slips[:group], slip, *slips[group + 1 :]]
            other = held_stop(scenario, changed).metrics.distance
            if other < distance:
                distance, slips = other, changed
    return distance, slips


def _row(rail: str, held: Sequence[float] = SLIPS) -> dict[str, Any]:
    changes = {**RAILS[rail], "limits.alpha_max": 1.0, "limits.horizon": "200 s"}
    without = {**changes, "estimator": {"kind": "none"}}
    bound = run_stop(Scenario.load("plain", {**without, "controller.kind": "ideal_bound"}))
    distance, slips = shortest_held(
        Scenario.load("plain", {**without, "controller.kind": "full_brake"}), bound.trace.sizes["group"], held
    )
    row: dict[str, Any] = {"rail": rail, "ideal bound": bound.metrics.distance, "held slips": distance}
    row["slips held"] = ", ".join(f"{100 * slip:.0f} %" for slip in slips)
    stops = {law: {**without, "controller": dict(table)} for law, table in LAWS.items()}
    stops |= {law.replace("_", " "): {**changes, "controller.kind": law} for law in ESTIMATING}
    return row | {law: run_stop(Scenario.load("plain", each)).metrics.distance for law, each in stops.items()}


CLEANED: Mapping[str, Any] = {
    "name": "cleaned_rail",
    "seed": 5501,
    "start": {"speed": 80 / 3.6},
    "limits": {"horizon": 250.0},
    "adhesion": {"kind": "constant", "polach": "dry", "mu0": 0.05, "recovery": CLEAN.model_dump()},
}
"""The dry rail that slip cleans, for the train of the type test in service."""

JUDGED = "two_maxima"
"""The law that is made for rails that slip cleans."""


def in_service(law: str) -> dict[str, Any]:
    """Return the distance of a law of version 2 of the type test on the cleaned rail [m]; NaN without standstill."""
    tables = merge(merge(train_of(None), CLEANED), entrants(2)[law].tables)
    stop = run_stop(scenario_of(tables, directory=LIBRARY, origin=f"cleaned rail, {law}"))
    return {"law": law, "distance": stop.metrics.distance}


def laws_in_service(rows: Sequence[Mapping[str, Any]]) -> tuple[ReportTable, str]:
    """Return the distances by law over the shortest, shortest first, and a sentence on the law of two maxima."""
    found = sorted(rows, key=lambda row: (math.isnan(row["distance"]), row["distance"]))
    shortest = found[0]["distance"]
    table = [{**row, "over the shortest": row["distance"] / shortest} for row in found]
    forms = {"distance": "{:.1f} m", "over the shortest": "{:.3f}"}
    own = next(row for row in table if row["law"] == JUDGED)
    other = next(row for row in table if row["law"] != JUDGED)
    compared = ", ".join(f"{row['law']} {row['distance']:.1f} m" for row in table if row["law"] in _NAMED)
    sentence = (
        f"On this rail {JUDGED} stops in {own['distance']:.1f} m, {own['distance'] / other['distance']:.3f} of the "
        f"shortest of the other laws, {other['law']}: {compared}."
    )
    return ReportTable(table, forms, ("law",), title="Stops in service on the rail that slip cleans"), sentence


_NO_LAWS = (*registry.ANALYSES, "full_brake")
_NAMED = ("recursive_slope", "slip_three_state_deep", "slope_seeking")


@dataclass(frozen=True)
class ShortestStops(Study, quick="the first rail, and two slips"):
    """Compute bounds of the distance on known rails, also where slip cleans them, and stops of laws."""

    write: Annotated[bool, Option("--write", help=f"Write the tables into {PAGE} and {PAGE_OF_LAWS}.")] = False

    def page(self, work: Work) -> Page:
        """Return the distances of the bound, of held slips and of laws."""
        rails, held = (list(RAILS)[:1], SLIPS[1:5:3]) if self.quick else (list(RAILS), SLIPS)
        rows = work.map(partial(_row, held=held), rails)
        columns = [name for name in rows[0] if name not in ("rail", "slips held")]
        table = ReportTable(rows, dict.fromkeys(columns, "{:.1f} m"), ("rail",), title="Stops from 80 km/h")
        known = entrants(2)
        laws = [name for name in known if known[name].role in ("entrant", "baseline") and name not in _NO_LAWS]
        service, sentence = laws_in_service(work.map(in_service, laws))
        if self.write:
            write_tables(PAGE, {"optimum": table})
            write_tables(PAGE_OF_LAWS, {"cleaned rail": f"{sentence}\n\n{service}"})
        return Page(
            title="Shortest stops on known rails",
            question="How short can a stop be, where the slip of leading wheelsets cleans the rail for those behind?",
            answer="The shortest possible distance is between that of the ideal bound, which no stop is below, and "
            "that of held slips, which a controller that knows the true state can reach.",
            template="studies/optimum.md.jinja",
            values={"table": table, "service": service, "sentence": sentence},
            tables={"optimum.csv": table, "cleaned_rail.csv": service},
            screen=(table, service, sentence),
        )


STUDY = ShortestStops
