"""The answer of a campaign that repeats published stops: published distances next to its own, on one screen."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isnan
from typing import Final

from railgrip.report.frame import PLACE, Frame, short_names, single_stops
from railgrip.report.table import ReportTable, percent, text

_OWN: Final = ("adhesion_literal", "adhesion_based", "ideal_bound")
"""Controllers next to those with a published distance: the laws of the published kind, and the bound."""

_LOCKED: Final = 2.0
"""Lock of a wheelset above which it is given next to the distances of a controller [s]."""

_CASES: Final = 4
"""Maximum number of columns."""

FIRST: Final = "braking distance"
"""Heading of the column with the controllers."""


OVERVIEW_MEANING: Final = (
    "published and simulated braking distances, with the change against slip-based control (SBC) of the same origin; "
    "medians where the distance of repeated stops depends on rounding."
)


@dataclass(frozen=True, slots=True)
class OverviewLine:
    """The distances of a controller, published or of this campaign.

    Attributes:
        name: Name of the controller, with its origin.
        kind: Kind of its law.
        distances: Case → distance [m]; NaN without standstill.
        changes: Case → change against slip-based control of the same origin; NaN for that itself.
        ranges: Case → lowest and highest distance of repeats [m]; empty if all repeats agree or are published.
        locks: Case → longest lock of a wheelset [s]; empty if none is long.
    """

    name: str
    kind: str
    distances: Mapping[str, float]
    changes: Mapping[str, float]
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict[str, tuple[float, float]])
    locks: Mapping[str, float] = field(default_factory=dict[str, float])

    @property
    def is_published(self) -> bool:
        """Whether the distances are those of the publication."""
        return self.name.endswith(_PUBLISHED)


_PUBLISHED: Final = ", published"
_SIMULATED: Final = ", simulated"


@dataclass(frozen=True, slots=True, kw_only=True)
class Overview:
    """Published distances and those of a campaign.

    Attributes:
        cases: Names of the columns.
        lines: Controllers, the published distances before its own.
    """

    cases: tuple[str, ...]
    lines: tuple[OverviewLine, ...]

    def table(self) -> ReportTable:
        """Return a row for each controller, and rows for ranges and locks where they matter."""
        rows: list[dict[str, str]] = []
        for line in self.lines:
            rows.append({FIRST: line.name} | {case: _distance(line, case) for case in self.cases})
            if line.ranges:
                texts = {case: _range(line.ranges.get(case)) for case in self.cases}
                rows.append({FIRST: "– range of repeated stops"} | texts)
            if line.locks:
                texts = {case: text(line.locks.get(case), "{:.1f} s") for case in self.cases}
                rows.append({FIRST: "– longest lock of a wheelset"} | texts)
        return ReportTable(rows, left=(FIRST,))


def overview_of(frame: Frame) -> Overview | None:
    """Return the overview of a campaign; None if it has no published distances, or too many cases for a screen."""
    published = frame[frame["paper_distance"].notna()]
    here = single_stops(frame).merge(published[list(PLACE)].drop_duplicates())
    if here.empty:
        return None
    _, names = short_names(here)
    here["name"] = [names[label].replace("\n", ", ") for label in here["label"]]
    cases = tuple(here["name"].unique())
    if len(cases) < len(here[list(PLACE)].drop_duplicates()) or len(cases) > _CASES:
        return None
    # The median over repeats of a distance that depends on rounding, else the distance.
    here["middle"] = [row.distance if row.repeats is None else row.repeats[0] for row in here.itertuples()]
    sbc = here[here["reference"] == "published"].drop_duplicates("name", keep="last").set_index("name")["middle"]
    here["change"] = (here["middle"] / here["name"].map(sbc) - 1).where(here["reference"] != "published")
    lines: list[OverviewLine] = []
    for label, stops in here.groupby("controller_label", sort=False):
        kind, by_case = stops["controller"].iloc[0], stops.drop_duplicates("name", keep="last").set_index("name")
        known = by_case[by_case["paper_distance"].notna()]
        if len(known):
            changes = (-known["paper_reduction"]).to_dict()
            line = OverviewLine(f"{label}{_PUBLISHED}", kind, known["paper_distance"].to_dict(), changes)
            lines.append(line)
        if len(known) or kind in _OWN:
            locks = by_case["longest_lock"].dropna().to_dict()
            lines.append(
                OverviewLine(
                    f"{label}{_SIMULATED}" if len(known) else str(label),
                    kind,
                    by_case["middle"].to_dict(),
                    by_case["change"].to_dict(),
                    ranges={case: ends[1:] for case, ends in by_case["repeats"].dropna().items()},
                    locks=locks if max(locks.values(), default=0.0) > _LOCKED else {},
                )
            )
    return Overview(cases=cases, lines=tuple(lines))


def _distance(line: OverviewLine, case: str) -> str:
    if case not in line.distances:
        return ""
    distance = line.distances[case]
    metres = "no stop" if isnan(distance) else f"{distance:.1f} m"
    return f"{metres} {percent(line.changes[case])}".rstrip()


def _range(ends: tuple[float, float] | None) -> str:
    return "" if ends is None else f"{ends[0]:.1f} – {ends[1]:.1f} m"
