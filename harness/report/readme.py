"""The table of braking distances in README.md, written from the accepted ones, so that it cannot say anything else."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from railgrip.errors import RecordError
from railgrip.files import write_text
from railgrip.report.baseline import Accepted, Baseline
from railgrip.report.reference import best, is_published, is_tuned, label, law_of
from railgrip.report.table import Table, percent
from railgrip.scenario.campaign import Campaign, PlannedStop

BEGIN = "<!-- distances: written by `make readme` -->"
END = "<!-- end of distances -->"

_FIRST = "braking distance"


def table(campaign: Campaign, baseline: Baseline) -> str:
    """Return the table: a line for each equipment and controller, a column for each scenario.

    In brackets stands the change against the published SBC, and behind it that against the best SBC with other
    thresholds where there is one. A distance that rounding decides is its median with its range. Lock and strokes are
    the worst of the line's scenarios.
    """
    scenarios = list(dict.fromkeys(stop.variants["scenario"] for stop in campaign.stops))
    lines: dict[tuple[str, str], dict[str, PlannedStop]] = {}
    for stop in campaign.stops:
        line = lines.setdefault((stop.variants["equipment"], stop.variants["controller"]), {})
        line[stop.variants["scenario"]] = stop
    published = _references(campaign.stops, [stop for stop in campaign.stops if is_published(_law(stop))])
    tuned = _references(campaign.stops, _best_tuned(campaign.stops, baseline))
    rows = [
        *_published_rows(campaign, lines, scenarios),
        *(
            {_FIRST: f"{equipment}: {_name(stops, lines, equipment)}"}
            | {
                name.replace("_", " "): _cell(stops.get(name), baseline, published, tuned) if name in stops else ""
                for name in scenarios
            }
            | _worst([baseline.stops[stop.name] for stop in stops.values() if stop.name in baseline.stops])
            for (equipment, _), stops in lines.items()
        ),
    ]
    return str(Table(rows, {"longest lock": "{:.1f} s"}, left=(_FIRST,)))


def write_readme(path: Path, campaign: Campaign, baseline: Baseline) -> None:
    """Write the table between its two marks.

    Raises:
        RecordError: The file cannot be read, or has not the two marks.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as problem:
        raise RecordError(f"{path}: cannot be read: {problem.strerror}") from problem
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise RecordError(f"{path}: has not the two lines between which the table belongs, '{BEGIN}' and '{END}'")
    write_text(path, f"{before}{BEGIN}\n{table(campaign, baseline)}\n{END}{after}")


def _published_rows(
    campaign: Campaign, lines: Mapping[tuple[str, str], Mapping[str, PlannedStop]], scenarios: Sequence[str]
) -> list[Mapping[str, str]]:
    """Return what the paper says, a row for each controller that it has."""
    rows: list[Mapping[str, str]] = []
    before: dict[str, float] = {}
    for stops in lines.values():
        references = {name: campaign.reference_for(stop) for name, stop in stops.items()}
        distances = {name: reference.distance for name, reference in references.items() if reference is not None}
        if distances:
            before = before or distances  # the first is the paper's SBC
            row = {_FIRST: f"*paper: {_label(next(iter(stops.values())))}*"}
            for name in scenarios:
                change = None if distances is before else distances[name] / before[name] - 1
                row[name.replace("_", " ")] = f"{distances[name]:.1f} m" + _brackets([change])
            rows.append(row | {"longest lock": "", "valve strokes": ""})
    return rows


def _cell(stop: PlannedStop | None, baseline: Baseline, published: Mapping[str, str], tuned: Mapping[str, str]) -> str:
    if stop is None or stop.name not in baseline.stops:
        return ""
    own = baseline.stops[stop.name]
    changes = [
        None if other is None or other == stop.name else own.distance / baseline.stops[other].distance - 1
        for other in (references.get(stop.name) for references in (published, tuned))
        if other is None or other in baseline.stops
    ]
    lowest, highest = own.ends
    distance = f"{own.distance:.1f} m" + (f", {lowest:.1f} – {highest:.1f} m" if own.is_range else "")
    return distance + _brackets(changes)


def _brackets(changes: Sequence[float | None]) -> str:
    texts = [percent(change) for change in changes if change is not None]
    return f" ({', '.join(texts)})" if texts else ""


def _worst(stops: Sequence[Accepted]) -> dict[str, float | None]:
    locks = [stop.longest_lock for stop in stops if stop.longest_lock is not None]
    strokes = [stop.valve_strokes for stop in stops if stop.valve_strokes is not None]
    return {
        "longest lock": max(locks, default=None),
        "valve strokes": max(strokes, default=None),
    }


def _name(
    stops: Mapping[str, PlannedStop], lines: Mapping[tuple[str, str], Mapping[str, PlannedStop]], equipment: str
) -> str:
    """Return what the controller of a line is called; with its variant where another one is called the same."""
    labels = [_label(next(iter(other.values()))) for (where, _), other in lines.items() if where == equipment]
    first = next(iter(stops.values()))
    own = _label(first)
    return own if labels.count(own) == 1 else f"{own}, {first.variants['controller'].replace('_', ' ')}"


def _references(stops: Sequence[PlannedStop], selection: Sequence[PlannedStop]) -> dict[str, str]:
    """Return name of each stop → name of the chosen one in the same scenario and equipment."""
    at = {(stop.variants["scenario"], stop.variants["equipment"]): stop.name for stop in selection}
    places = {stop.name: (stop.variants["scenario"], stop.variants["equipment"]) for stop in stops}
    return {name: at[place] for name, place in places.items() if place in at}


def _best_tuned(stops: Sequence[PlannedStop], baseline: Baseline) -> list[PlannedStop]:
    """Return the stops of the best tuned SBC of each equipment."""

    def distance(stop: PlannedStop) -> float | None:
        accepted = baseline.stops.get(stop.name)
        return None if accepted is None else accepted.distance

    tuned = [stop for stop in stops if is_tuned(_law(stop))]
    return [
        stop
        for equipment in dict.fromkeys(stop.variants["equipment"] for stop in tuned)
        for stop in best(
            [stop for stop in tuned if stop.variants["equipment"] == equipment],
            lambda stop: law_of(stop.scenario.resolved()),
            distance,
        )
    ]


def _label(stop: PlannedStop) -> str:
    return label(stop.scenario.resolved())


def _law(stop: PlannedStop) -> Mapping[str, object]:
    return stop.scenario.resolved()["controller"]
