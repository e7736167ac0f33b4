"""The six runs of the field test: stops of the scenarios of a campaign."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import xarray

from railgrip.base.errors import EstimationError
from railgrip.campaign.work import Work
from railgrip.estimation.braking import Braking, braking_of
from railgrip.estimation.sources import stop_read
from railgrip.estimation.spec import CourseTable
from railgrip.estimators.belief import Array
from railgrip.scenario.campaign import load_campaign
from railgrip.scenario.schema import Scenario
from railgrip.scenario.track import Plan
from railgrip.simulate.vehicle_data import VehicleData

TUNING = ("c1", "c2", "c3", "c4", "c5")
TEST = "c6"
"""Case that is never used for tuning."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldRun:
    """A run from rest to the stop.

    Attributes:
        recording: The whole run.
        braking: Its part for the filter.
        plan: Plan of the track, with the position at which the run begins.
    """

    recording: xarray.Dataset
    braking: Braking
    plan: Plan

    def plan_geometry(self, distance: Array) -> tuple[Array, Array]:
        """Return slope and curvature [1/m] of the plan in the direction of travel, at distances from the start [m]."""
        track, place = self.plan.alignment(), self.plan.place(distance)
        return self.plan.way * track.slope(place), self.plan.way * track.curvature(place)


def cases(file: Path | None = None) -> dict[str, Scenario]:
    """Return the scenarios of a campaign by their variant of its axis `case`, those of field_test.toml when None.

    Raises:
        ScenarioError: The file is missing or not a campaign.
        EstimationError: It has no such axis, or a scenario has no [track.plan].
    """
    campaign = load_campaign(file or Path("field_test"))
    unlaid = next((stop.name for stop in campaign.stops if stop.scenario.track.plan is None), None)
    if unlaid is not None:
        raise EstimationError(f"{campaign.name}: the field test needs a [track.plan]; {unlaid} has none.")
    if any("case" not in stop.variants for stop in campaign.stops):
        raise EstimationError(f"{campaign.name}: the field test needs its cases as [axes.case.NAME].")
    return {stop.variants["case"]: stop.scenario for stop in campaign.stops}


def run(case: tuple[str, Scenario], import_from: Sequence[Path] = ()) -> FieldRun:
    """Return the run of a case by its name; classes that its scenario names are imported from `import_from`.

    Raises:
        EstimationError: See `braking_of`.
        ScenarioError: The stop fails.
    """
    name, scenario = case
    track = scenario.track
    assert track.plan is not None  # of every scenario of `cases`
    recording = stop_read(scenario, f"{scenario.name} {name}", import_from)
    return FieldRun(
        recording=recording,
        braking=braking_of(recording, CourseTable(mass=VehicleData(scenario).mass, curve_law=track.curve_law)),
        plan=track.plan,
    )


def runs(
    scenarios: Mapping[str, Scenario], names: Sequence[str], work: Work, import_from: Sequence[Path] = ()
) -> dict[str, FieldRun]:
    """Return the run of each case; `import_from` as for `run`.

    Raises:
        EstimationError: The case does not exist; see also `run`.
    """
    missing = [name for name in names if name not in scenarios]
    if missing:
        raise EstimationError(f"the field test needs the cases {', '.join(names)}; there is no {', '.join(missing)}.")
    one_run = partial(run, import_from=tuple(import_from))
    return dict(
        zip(names, work.map(one_run, [(name, scenarios[name]) for name in names], keep=not import_from), strict=True)
    )
