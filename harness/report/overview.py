"""The answer of a campaign that repeats published stops: published distances next to its own, on one screen."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from railgrip.report.row import Row, short_names
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


@dataclass(frozen=True, slots=True, kw_only=True)
class OverviewLine:
    """The distances of a controller, published or of this campaign.

    Attributes:
        name: Name of the controller, with its origin.
        kind: Kind of its law.
        distances: Case → distance [m]; None without standstill.
        changes: Case → change against slip-based control of the same origin.
        ranges: Case → lowest and highest distance of repeats [m]; empty if all repeats agree or are published.
        locks: Case → longest lock of a wheelset [s]; empty if none is long.
    """

    name: str
    kind: str
    distances: Mapping[str, float | None]
    changes: Mapping[str, float | None]
    ranges: Mapping[str, tuple[float, float]]
    locks: Mapping[str, float]

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


def overview_of(rows: Sequence[Row]) -> Overview | None:
    """Return the overview of a campaign; None if it has no published distances, or too many cases for a screen."""
    places = {row.place for row in rows if row.paper_distance_m is not None}
    here = [row for row in rows if row.place in places and row.draw is None]
    if not here:
        return None
    _, names = short_names(here)
    names = {label: name.replace("\n", ", ") for label, name in names.items()}
    cases = tuple(dict.fromkeys(names[row.label] for row in here))
    if len(cases) < len(places) or len(cases) > _CASES:
        return None
    stops: dict[str, dict[str, Row]] = {}
    for row in here:
        stops.setdefault(row.controller_label, {})[names[row.label]] = row
    sbc = {names[row.label]: row for row in here if row.reference == "published"}
    lines: list[OverviewLine] = []
    for label, by_case in stops.items():
        published = {case: row.paper_distance_m for case, row in by_case.items() if row.paper_distance_m is not None}
        if published:
            changes = {case: by_case[case].paper_reduction for case in published}
            changes = {case: None if reduction is None else -reduction for case, reduction in changes.items()}
            lines.append(_line(f"{label}{_PUBLISHED}", by_case, published, changes))
        if published or next(iter(by_case.values())).controller in _OWN:
            distances = {case: _median(row) for case, row in by_case.items()}
            changes = {case: _change(row, sbc.get(case)) for case, row in by_case.items()}
            name = f"{label}{_SIMULATED}" if published else label
            lines.append(_line(name, by_case, distances, changes, is_own=True))
    return Overview(cases=cases, lines=tuple(lines))


def _line(
    name: str,
    rows: Mapping[str, Row],
    distances: Mapping[str, float | None],
    changes: Mapping[str, float | None],
    *,
    is_own: bool = False,
) -> OverviewLine:
    ranges = {case: row.repeats[1:] for case, row in rows.items() if row.repeats is not None} if is_own else {}
    locks = {case: row.longest_lock_s for case, row in rows.items() if row.longest_lock_s is not None}
    return OverviewLine(
        name=name,
        kind=next(iter(rows.values())).controller,
        distances=distances,
        changes=changes,
        ranges=ranges,
        locks=locks if is_own and max(locks.values(), default=0.0) > _LOCKED else {},
    )


def _median(row: Row) -> float | None:
    """Return the median over repeats of a distance that depends on rounding, else the distance."""
    return row.distance_m if row.repeats is None else row.repeats[0]


def _change(row: Row, sbc: Row | None) -> float | None:
    before, after = None if sbc is None or sbc is row else _median(sbc), _median(row)
    return None if before is None or after is None else after / before - 1


def _distance(line: OverviewLine, case: str) -> str:
    if case not in line.distances:
        return ""
    distance, difference = line.distances[case], line.changes.get(case)
    metres = "no stop" if distance is None else f"{distance:.1f} m"
    return metres if difference is None else f"{metres} {percent(difference)}"


def _range(ends: tuple[float, float] | None) -> str:
    return "" if ends is None else f"{ends[0]:.1f} – {ends[1]:.1f} m"
