"""The accepted distances of a campaign, and whether results keep to them.

A baseline file says for each stop the distance, how far it may move, and why it is what it is:

    campaign = "../../harness/scenario/campaigns/table1.toml"

    [stops.trapezoid-ideal-slip_two_state]
    distance = 382.61    # m
    tolerance = 0.39     # m
    reason = "First calibration."
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from harness.record.atomic import write_text
from harness.record.outcome import Outcome
from harness.scenario.error import ScenarioError
from harness.scenario.load import read_toml, validated
from harness.scenario.quantity import Unit
from harness.scenario.table import Table
from harness.verdict.results import Results

TOLERANCE = 1e-3
"""Of a new baseline, relative: twice what the distance may move when the communication step is halved (0.05 %), so that
another machine's arithmetic passes and a changed law does not."""


class Accepted(Table):
    """One stop of a baseline."""

    distance: Annotated[float, Unit("m", above=0)]
    tolerance: Annotated[float, Unit("m", above=0)]
    reason: Annotated[str, Field(min_length=1)]


class Baseline(Table):
    """A baseline file."""

    campaign: str = Field(description="campaign file, from this one's folder")
    stops: dict[str, Accepted] = Field(default={}, description="name of a stop → what is accepted")


State = Literal["kept", "moved", "new", "gone", "no standstill"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """One stop against its baseline.

    Attributes:
        stop: Name.
        state: `kept` inside the tolerance; `moved` outside; `new` without baseline; `gone` without result;
            `no standstill` ended otherwise.
        accepted: The baseline, None for a new stop.
        distance: Found [m], None unless the train stood.
    """

    stop: str
    state: State
    accepted: Accepted | None
    distance: float | None

    @property
    def change(self) -> float | None:
        """Found minus accepted distance [m]."""
        return None if self.accepted is None or self.distance is None else self.distance - self.accepted.distance


def load_baseline(path: Path) -> Baseline:
    """Return a baseline file.

    Raises:
        ScenarioError: Missing, or not a baseline.
    """
    return validated(Baseline, read_toml(path), directory=path.parent, origin=path.name)


def compare(baseline: Baseline, results: Results) -> tuple[Comparison, ...]:
    """Return every stop of baseline and results, those that need attention first."""
    found = {result.name: result.record for result in results.stops}
    comparisons: list[Comparison] = []
    for name in dict.fromkeys([*found, *baseline.stops]):
        accepted, record = baseline.stops.get(name), found.get(name)
        distance = record.metrics.distance if record and record.outcome is Outcome.STANDSTILL else None
        comparisons.append(
            Comparison(
                stop=name, state=_state(accepted, record is not None, distance), accepted=accepted, distance=distance
            )
        )
    return tuple(sorted(comparisons, key=lambda comparison: comparison.state == "kept"))


def accepted(baseline: Baseline, results: Results, reason: str) -> Baseline:
    """Return the baseline with what moved, appeared or went brought up to date, for a reason.

    Stops inside their tolerance keep value and reason. The tolerance of a moved stop scales with its distance.

    Raises:
        ScenarioError: No reason is given, or a stop has no standstill, which nobody can accept.
    """
    if not reason.strip():
        raise ScenarioError("accept: --reason is empty; say what changed and why the distances are right")
    stops: dict[str, Accepted] = {}
    for comparison in compare(baseline, results):
        if comparison.state == "gone":
            if comparison.stop in results.missing:
                raise ScenarioError(f"accept: {comparison.stop} has no result; run the campaign first")
            continue
        if comparison.distance is None:
            raise ScenarioError(f"accept: {comparison.stop} did not come to a standstill; a baseline is a distance")
        before = comparison.accepted
        if comparison.state == "kept" and before is not None:
            stops[comparison.stop] = before
            continue
        relative = before.tolerance / before.distance if before else TOLERANCE
        stops[comparison.stop] = Accepted(
            distance=round(comparison.distance, 3),
            tolerance=_two_digits(relative * comparison.distance),
            reason=reason.strip(),
        )
    return Baseline(campaign=baseline.campaign, stops=stops)


def write_baseline(baseline: Baseline, path: Path) -> None:
    """Write a baseline file, stops in the order of their names."""
    lines = [f"campaign = {json.dumps(baseline.campaign)}"]
    for name, stop in sorted(baseline.stops.items()):
        lines += [
            "",
            f"[stops.{json.dumps(name)}]",
            f"distance = {stop.distance!r}  # m",
            f"tolerance = {stop.tolerance!r}  # m",
            f"reason = {json.dumps(stop.reason, ensure_ascii=False)}",
        ]
    write_text(path, "\n".join(lines) + "\n")


def comparison_rows(comparisons: tuple[Comparison, ...]) -> list[Mapping[str, str]]:
    """Return the comparison as texts, column → cell."""

    def metres(value: float | None, form: str = "{:.2f}") -> str:
        return "" if value is None else form.format(value)

    return [
        {
            "stop": comparison.stop,
            "state": comparison.state,
            "accepted [m]": metres(comparison.accepted.distance if comparison.accepted else None),
            "found [m]": metres(comparison.distance),
            "change [m]": metres(comparison.change, "{:+.3f}"),
            "tolerance [m]": metres(comparison.accepted.tolerance if comparison.accepted else None),
        }
        for comparison in comparisons
    ]


def _state(accepted: Accepted | None, has_result: bool, distance: float | None) -> State:
    if not has_result:
        return "gone"
    if distance is None:
        return "no standstill"
    if accepted is None:
        return "new"
    return "kept" if abs(distance - accepted.distance) <= accepted.tolerance else "moved"


def _two_digits(value: float) -> float:
    return round(value, 1 - math.floor(math.log10(value)))
