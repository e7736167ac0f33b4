"""Share of the samples of the type test in which the slip of a released wheelset is certified to stay bounded."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from typer import Option

from railgrip.campaign.work import Work
from railgrip.report.marked import write_tables
from railgrip.report.page import Page
from railgrip.report.stop import Stop
from railgrip.report.table import ReportTable, share
from railgrip.scenario.campaign import PlannedStop
from railgrip.scenario.schema import Scenario
from railgrip.simulate.run import run_stop
from railgrip.simulate.vehicle_data import VehicleData
from railgrip.studies.study import Study
from railgrip.studies.type_test.case_set import VERSIONS
from railgrip.studies.type_test.entrants import campaign_of, entrants, train_of, trains_of
from railgrip.studies.type_test.family import AXES
from railgrip.trace.certificate import with_certificate
from railgrip.trace.measures import FAST

PAGE = Path("docs/papers/adhesion_based.md")
"""From the folder of the project, where the command runs."""

LAWS = ("adhesion_based", "slope_seeking")
SLIDING = 0.01
"""Slip above which a sample counts; errors of wheel radius and speed are up to half of it in most cases."""
TOLERANCE = 2e-3
"""Slip by which a bound may be exceeded: friction between two samples is not known to it."""
WINDOW = 0.2
"""Time over which the tuned adhesion-based law keeps a direction (its `dwell`) [s]."""
CHOKED = 15e5
"""Rate of pressure through a choked vent valve, where a plant does not set it [Pa/s]."""


def count_of(stop: Stop) -> dict[str, int]:
    """Return counts of the sliding samples of a stop above 15 km/h, of all groups with brakes.

    `sliding`; `inside`, with a bound; `released`, inside with venting valves; `exceeded`, of these with more slip than
    the bound; `slope visible`, in which slip changes adhesion by more than the rail does; `slope significant`, in which
    it does so by more than the rail and the deviation that the filter claims together.
    """
    vehicle = VehicleData(stop.scenario)
    true = vehicle.true
    choked = true.parameters.get("rate_choked", CHOKED)
    found = with_certificate(stop.trace, vehicle.contact, true.brakes, true.valves, choked=choked, window=WINDOW)
    rows = stop.trace.sel(time=found["time"])
    has_brake = np.array([brake is not None for brake in true.brakes])
    sliding = (found["slip"].values > SLIDING) & (rows["speed"].values > FAST)[:, None] & has_brake
    bound, reached = found["slip_bound"].values, found["slip_reached"].values
    inside = sliding & np.isfinite(bound)
    released = inside & np.isfinite(reached)
    by_slip, by_rail = np.abs(found["adhesion_by_slip"].values), np.abs(found["adhesion_by_rail"].values)
    masks = {
        "sliding": sliding,
        "inside": inside,
        "released": released,
        "exceeded": released & (reached > bound + TOLERANCE),
        "slope visible": sliding & (by_slip > by_rail),
        "slope significant": sliding & (by_slip > by_rail + rows["estimate_adhesion_sd"].values),
    }
    return {name: int(np.count_nonzero(mask)) for name, mask in masks.items()}


def _counted(scenario: Scenario) -> dict[str, int]:
    return count_of(run_stop(scenario))


def table_of(stops: Sequence[PlannedStop], counts: Sequence[Mapping[str, int]]) -> ReportTable:
    """Return shares of the sliding samples by family of cases."""
    families: dict[str, list[int]] = {"all cases": list(range(len(stops)))}
    for axis in AXES[1:]:
        if axis == "passage":  # none of these cases is on a rail that passing wheels clean
            continue
        for number in sorted(families["all cases"], key=lambda number: stops[number].variants[axis]):
            families.setdefault(f"{axis}: {stops[number].variants[axis]}", []).append(number)
    rows: list[dict[str, Any]] = []
    for family, members in families.items():
        row: dict[str, Any] = {"family": family, "cases": len(members) // len(LAWS)}
        for law in LAWS:
            of_law = [counts[number] for number in members if stops[number].variants["controller"] == law]
            total = {name: sum(count[name] for count in of_law) for name in counts[0]}
            sliding = max(total["sliding"], 1)
            row[f"inside, {law}"] = share(total["inside"] / sliding)
            row[f"exceeded, {law}"] = f"{total['exceeded']} of {total['released']}"
            if law == LAWS[0]:
                row |= {name: share(total[name] / sliding) for name in ("slope visible", "slope significant")}
        rows.append(row)
    return ReportTable(rows, left=("family",))


@dataclass(frozen=True)
class Certificate(Study):
    """Certify bounded slip in the samples of the type test under laws that seek the maximum of adhesion."""

    cases: Annotated[int | None, Option(min=1, help="Number of cases; those of the quick set unless given.")] = None
    write: Annotated[bool, Option("--write", help=f"Write the table into {PAGE}.")] = False

    def page(self, work: Work) -> Page:
        """Run the cases of version 2 of the type test, and return the shares of their samples."""
        design = VERSIONS[2].draw(self.cases or VERSIONS[2].quick, VERSIONS[2].test)
        laws = {name: entrants(2)[name] for name in LAWS}
        stops = campaign_of(design, laws, train_of(None), trains=trains_of(design)).stops
        counts = work.map(_counted, [stop.scenario for stop in stops])
        table = table_of(stops, counts)
        if self.write:
            write_tables(PAGE, {"certificate": table})
        released, exceeded = (sum(count[name] for count in counts) for name in ("released", "exceeded"))
        return Page(
            title="Certificate of bounded slip",
            question="In which states of a stop does a release of the brake keep the slip of a wheelset bounded?",
            answer=f"Of {released} samples with a bound in which the brake was released, {exceeded} had more slip.",
            template="studies/certificate.md.jinja",
            values={"table": table},
            tables={"certificate.csv": table},
            screen=(table,),
        )


STUDY = Certificate
