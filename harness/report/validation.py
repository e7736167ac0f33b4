"""Tables of braking distances in docs/, written from the accepted distances so that both agree."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from railgrip.report.baseline import Accepted, Baseline
from railgrip.report.reference import label, references
from railgrip.report.table import Table, percent
from railgrip.scenario.campaign import Campaign, PlannedStop

_FIRST = "braking distance"

_EQUIPMENT = {"ideal": "ideal, 20 ms lag", "instant": "ideal, 1 ms lag"}
"""Equipment → its name in the table, with the lag of the cylinder pressure; others have the name of the file."""


@dataclass(frozen=True, slots=True)
class _Cell:
    """One planned stop with its accepted distance and those of the references."""

    stop: PlannedStop
    scenario: dict[str, Any]
    accepted: Accepted | None
    paper: float | None

    @property
    def column(self) -> str:
        return self.stop.variants["scenario"].replace("_", " ")

    @property
    def line(self) -> tuple[str, str]:
        """Equipment and controller."""
        return self.stop.variants["equipment"], self.stop.variants["controller"]

    @property
    def distance(self) -> float | None:
        return self.accepted.value if self.accepted else None


def table(campaign: Campaign, baseline: Baseline) -> str:
    """Return the table: a line for each equipment and controller, a column for each scenario.

    Brackets hold the change against the published SBC, followed by that against the best tuned SBC where there is one.
    A distance that rounding decides is given as median and range. Adhesion, lock and strokes are the largest of the
    line.
    """
    cells: list[_Cell] = []
    for stop in campaign.stops:
        reference = campaign.reference_for(stop)
        paper = reference.distance if reference else None
        cells.append(_Cell(stop, stop.scenario.resolved(), baseline.accepted.get(stop.name), paper))
    compared_with = references(cells, lambda cell: cell.scenario, lambda cell: cell.distance)
    lines: dict[tuple[str, str], dict[str, _Cell]] = {}
    texts: dict[tuple[str, str], dict[str, str]] = {}
    for cell, others in zip(cells, compared_with, strict=True):
        lines.setdefault(cell.line, {})[cell.column] = cell
        texts.setdefault(cell.line, {})[cell.column] = _text(cell, [other for other in others if other is not cell])
    columns = list(dict.fromkeys(cell.column for cell in cells))
    rows = _published_rows(lines.values(), columns)
    for line, stops in lines.items():
        known = [cell.accepted for cell in stops.values() if cell.accepted]
        peaks = [accepted.adhesion_peak for accepted in known if accepted.adhesion_peak is not None]
        locks = [accepted.longest_lock for accepted in known if accepted.longest_lock is not None]
        strokes = [accepted.valve_strokes for accepted in known if accepted.valve_strokes is not None]
        rows.append(
            {_FIRST: f"{_EQUIPMENT.get(line[0], line[0])}: {_name(line, lines)}"}
            | {column: texts[line].get(column, "") for column in columns}
            | {"greatest adhesion": max(peaks, default=None)}
            | {"longest lock": max(locks, default=None), "valve strokes": max(strokes, default=None)}
        )
    return str(Table(rows, {"greatest adhesion": "{:.3f}", "longest lock": "{:.1f} s"}, left=(_FIRST,)))


def cases_table(campaign: Campaign, baseline: Baseline) -> str:
    """Return the accepted distances of a campaign with cases: a row for each case, a column for each controller."""
    rows: dict[str, dict[str, str]] = {}
    for stop in baseline.selection(campaign).stops:
        case, scenario = stop.variants["case"].replace("_", " "), stop.scenario.resolved()
        cell = _Cell(stop, scenario, baseline.accepted.get(stop.name), None)
        rows.setdefault(case, {})[label(scenario)] = _text(cell, [])
    columns = dict.fromkeys(column for row in rows.values() for column in row)
    table = [{"case": case} | {column: row.get(column, "") for column in columns} for case, row in rows.items()]
    return str(Table(table, left=("case",)))


TABLES: Mapping[str, tuple[str, Callable[[Campaign, Baseline], str]]] = {
    "table1": ("validation.md", table),
    "adverse": ("rail_models.md", cases_table),
}
"""Baseline → page of docs/ that shows it, and the table."""


def _published_rows(lines: Collection[Mapping[str, _Cell]], columns: Sequence[str]) -> list[dict[str, Any]]:
    """Return the published distances, a row for each controller of the paper."""
    rows: list[dict[str, Any]] = []
    first: dict[str, float] = {}  # the paper's SBC
    for stops in lines:
        distances = {column: cell.paper for column, cell in stops.items() if cell.paper is not None}
        if distances:
            first = first or distances
            changes = {c: None if distances is first else distances[c] / first[c] - 1 for c in columns}
            rows.append(
                {_FIRST: f"*paper: {label(next(iter(stops.values())).scenario)}*"}
                | {column: f"{distances[column]:.1f} m" + _brackets([changes[column]]) for column in columns}
                | {"greatest adhesion": "", "longest lock": "", "valve strokes": ""}
            )
    return rows


def _text(cell: _Cell, others: Sequence[_Cell | None]) -> str:
    """Return distance or median and range, with the changes against other stops."""
    if cell.accepted is None:
        return ""
    accepted = cell.accepted
    range_ = f", {accepted.lowest:.1f} – {accepted.highest:.1f} m" if accepted.is_range else ""
    changes = [accepted.value / other.distance - 1 if other and other.distance else None for other in others]
    return f"{accepted.value:.1f} m{range_}{_brackets(changes)}"


def _brackets(changes: Sequence[float | None]) -> str:
    texts = [percent(change) for change in changes if change is not None]
    return f" ({', '.join(texts)})" if texts else ""


def _name(line: tuple[str, str], lines: Mapping[tuple[str, str], Mapping[str, _Cell]]) -> str:
    """Return the name of the controller of a line, with its variant if another line of the equipment has that name."""
    equipment, variant = line
    labels = {
        other: label(next(iter(stops.values())).scenario) for other, stops in lines.items() if other[0] == equipment
    }
    name = labels[line]
    return name if list(labels.values()).count(name) == 1 else f"{name}, {variant.replace('_', ' ')}"
