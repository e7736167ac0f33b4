"""Tables of braking distances in docs/ and the figure above them, from the accepted distances so that both agree."""

import itertools
import math
import textwrap
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pandas
from matplotlib.figure import Figure

from railgrip.base.errors import ScenarioError
from railgrip.report.baseline import ACROSS_COMPILERS, AcceptedValue, Baseline, findings_of
from railgrip.report.campaign_figures import overview_figure
from railgrip.report.frame import Frame, StatedDistance
from railgrip.report.reference import label, locked_text, references
from railgrip.report.results import Results, from_elsewhere
from railgrip.report.statistics import median_interval, on_common, rank
from railgrip.report.table import ReportTable, names, percent, text
from railgrip.scenario.campaign import Campaign, PlannedStop
from railgrip.scenario.conditioning import SMOOTH, RepeatedDistances, read_conditioning
from railgrip.scenario.onboard import SampledSensors

_FIRST = "braking distance"

_EQUIPMENT = {"ideal": "ideal, 20 ms lag", "instant": "ideal, 1 ms lag"}
"""Equipment → its name in the table, with the lag of the cylinder pressure; others have the name of the file."""


@dataclass(frozen=True, slots=True)
class Cell:
    """One planned stop with its accepted distance.

    Attributes:
        stop: Planned stop.
        scenario: Resolved scenario of the stop.
        accepted: Accepted distance; None without one.
        paper: Published distance [m]; None without one.
        repeats: Repeats of the stop with the accepted distance; None without any.
    """

    stop: PlannedStop
    scenario: dict[str, Any]
    accepted: AcceptedValue | None
    paper: float | None = None
    repeats: RepeatedDistances | None = None

    @property
    def column(self) -> str:
        """Name of the scenario."""
        return self.stop.variants["scenario"].replace("_", " ")

    @property
    def line(self) -> tuple[str, str]:
        """Equipment and controller."""
        return self.stop.variants["equipment"], self.stop.variants["controller"]

    @property
    def lots(self) -> Sequence[float]:
        """Distances by lot of the sensors [m], the same lots for all stops; empty if sensors have no errors."""
        return self.repeats.lot_distances if self.repeats else ()

    @property
    def stated(self) -> StatedDistance | None:
        """Distances over the lots of sensors, or the accepted distance with its range; None without one."""
        if self.lots:
            return StatedDistance(self.lots, are_lots=True)
        one = self.accepted
        if one is None:
            return None
        if not one.is_range:
            return StatedDistance((one.value,), math.nan if one.longest_lock is None else one.longest_lock)
        locks = self.repeats.figures.get("longest_lock", ()) if self.repeats else ()
        return StatedDistance((one.ends[0], one.value, one.ends[1]), max(locks, default=math.nan))


_Lines = dict[tuple[str, str], dict[str, Cell]]
"""(equipment, controller) → scenario → cell."""


def tables(campaign: Campaign, baseline: Baseline) -> dict[str, ReportTable]:
    """Return the tables of accepted distances of a campaign with scenarios, equipment and controllers, by name.

    `distances` has a row for each equipment and controller, and a column for each scenario. Brackets contain the change
    against the published SBC, followed by the change against the best tuned SBC if there is one. A distance that
    depends on rounding, or on the lot of sensors, is given as median and range, with the longest lock in these runs.
    `runs` has the maximum adhesion, lock and strokes of the runs that were accepted. `orders` compares controllers in
    pairs, lot by lot. `discretisation` has the changes with a shorter communication step.

    Raises:
        ScenarioError: The repeats with other lots of sensors are missing, or belong to another stop.
    """
    cells = cells_of(campaign, baseline)
    of_sensors = [cell for cell in cells if isinstance(cell.stop.scenario.sensors, SampledSensors)]
    if campaign.conditioning and (stale := [cell.stop.name for cell in of_sensors if not cell.lots]):
        raise ScenarioError(
            f"{campaign.name}: there are no repeats with other lots of sensors of {names(stale)} as accepted; run "
            "`make conditioning`"
        )
    compared_with = references(cells, lambda cell: cell.scenario, _metres)
    texts = {
        (cell.line, cell.column): _text(cell, [other for other in others if other is not cell])
        for cell, others in zip(cells, compared_with, strict=True)
    }
    lines = _lines_of(cells)
    columns = list(dict.fromkeys(cell.column for cell in cells))
    rows, maxima = _published_rows(lines.values(), columns), list[dict[str, Any]]()
    for line, stops in lines.items():
        name = f"{_EQUIPMENT.get(line[0], line[0])}: {_name(line, lines)}"
        rows.append({_FIRST: name} | {column: texts.get((line, column), "") for column in columns})
        known = [cell.accepted for cell in stops.values() if cell.accepted]
        maxima.append(
            {"single runs": name}
            | {
                column: max((value for one in known if (value := getattr(one, key)) is not None), default=None)
                for column, key in _MAXIMA.items()
            }
        )
    return {
        "distances": ReportTable(rows, left=(_FIRST,)),
        "runs": ReportTable(maxima, {"greatest adhesion": "{:.3f}", "longest lock": "{:.1f} s"}, left=("single runs",)),
        "orders": _orders(lines, columns),
        "discretisation": steps_table(campaign),
    }


_MAXIMA: Final = {
    "greatest adhesion": "adhesion_peak",
    "longest lock": "longest_lock",
    "valve strokes": "valve_strokes",
}
"""Column → key of an accepted value, the figure of one run, of which a row has the maximum."""


def _lines_of(cells: Iterable[Cell]) -> _Lines:
    lines: _Lines = {}
    for cell in cells:
        lines.setdefault(cell.line, {})[cell.column] = cell
    return lines


def cells_of(campaign: Campaign, baseline: Baseline) -> list[Cell]:
    """Return the stops of a campaign with their accepted distances and, if there are some, repeats with other lots."""
    repeats = read_conditioning(campaign.conditioning).stops if campaign.conditioning else {}
    cells: list[Cell] = []
    for stop in campaign.stops:
        accepted, reference = baseline.accepted.get(stop.name), campaign.reference_for(stop)
        repeated, paper = repeats.get(stop.name), reference.distance if reference else None
        is_own = repeated and accepted and repeated.belongs(stop.scenario.digest(), accepted.value)
        cells.append(Cell(stop, stop.scenario.resolved(), accepted, paper, repeated if is_own else None))
    return cells


def _orders(lines: _Lines, columns: Sequence[str]) -> ReportTable:
    """Return the paired differences between each controller and the next better one, lot by lot, with 95 % intervals.

    A controller is called shorter only if the interval excludes 0.
    """
    known = {
        line: [stops[column].lots for column in columns]
        for line, stops in lines.items()
        if all(column in stops and stops[column].lots for column in columns)
    }
    order = sorted(known, key=lambda line: sum(math.log(float(np.median(lots))) for lots in known[line]))
    rows: list[dict[str, Any]] = []
    for better, other in itertools.pairwise(order):
        row: dict[str, Any] = {"controller": _name(better, lines), "compared with": _name(other, lines)}
        for column, lots, other_lots in zip(columns, known[better], known[other], strict=True):
            row[column] = _difference([a - b for a, b in zip(lots, other_lots, strict=True)])
        rows.append(row)
    return ReportTable(rows, left=("controller", "compared with"))


def _difference(differences: Sequence[float]) -> str:
    """Return the median of paired differences [m] with its interval, and the order that the interval supports."""
    interval = median_interval(differences)
    if interval is None:
        return ""
    low, high = interval
    order = "shorter" if high < 0 else "longer" if low > 0 else "not separated"
    return text(float(np.median(differences)), "{:+.1f} m") + text(low, " [{:+.1f}, ") + text(high, "{:+.1f}] ") + order


def steps_table(campaign: Campaign) -> ReportTable:
    """Return by how much half and a quarter of the communication step move the median of each distance.

    The half width of the 95 % interval of a change without any cause follows; larger changes are bold. Rows without
    repeats at divided steps are left out.
    """
    repeats = read_conditioning(campaign.conditioning).stops if campaign.conditioning else {}
    equipped = (stop for stop in campaign.stops if "equipment" in stop.variants)
    lines = _lines_of(Cell(stop, stop.scenario.resolved(), None) for stop in equipped)
    columns = dict.fromkeys(column for stops in lines.values() for column in stops)
    rows: list[dict[str, str]] = []
    for line, stops in lines.items():
        found = {column: repeats.get(cell.stop.name) for column, cell in stops.items()}
        texts = {column: _moved_by_steps(one) for column, one in found.items() if one is not None and one.steps}
        if texts:
            name = {"half, quarter step": f"{line[0]}: {_name(line, lines)}"}
            rows.append(name | dict.fromkeys(columns, "") | texts)
    return ReportTable(rows, left=("half, quarter step",))


def _moved_by_steps(repeated: RepeatedDistances) -> str:
    texts: list[str] = []
    for divisor in sorted(repeated.steps):
        change, noise = repeated.moved_by_step(divisor), repeated.noise_of_step(divisor)
        shown = text(100 * change, "{:+.2f} %")
        texts.append(f"**{shown}**" if abs(change) > max(noise, _VISIBLE) else shown)
    noise = max(repeated.noise_of_step(divisor) for divisor in repeated.steps)
    return f"{', '.join(texts)} (± {100 * noise:.2f} %)"


CONVERGENCE = "validation.md"
"""Page of docs/ with the table of tolerances of `CONVERGENCE_CAMPAIGNS`."""

CONVERGENCE_CAMPAIGNS = ("convergence", "convergence_trains")


def tolerances_table(*campaigns: Campaign) -> ReportTable:
    """Return the error of each distance over the tolerance of the plant's solver, against the tightest tolerance.

    Errors within the 95 % interval of an error without any cause are not significant; others are bold. The first column
    of errors is that of the plant's own tolerance; the last column is the range of all these stops. Stops without
    repeats at other tolerances are left out.
    """
    rows = [_errors_over_tolerance(stop, repeated) for stop, repeated in _repeated(campaigns, "tolerances")]
    return ReportTable(rows, {"tightest": "{:.2f} m"}, left=("stop",))


def _repeated(campaigns: Iterable[Campaign], key: str) -> Iterator[tuple[PlannedStop, RepeatedDistances]]:
    """Yield stops with their repeats, if these have distances under a key such as `tolerances`."""
    for campaign in campaigns:
        repeats = read_conditioning(campaign.conditioning).stops if campaign.conditioning else {}
        for stop in campaign.stops:
            if (one := repeats.get(stop.name)) is not None and getattr(one, key):
                yield stop, one


def _errors_over_tolerance(stop: PlannedStop, repeated: RepeatedDistances) -> dict[str, Any]:
    loose_to_tight = sorted(repeated.tolerances, reverse=True)
    every = [d or math.inf for each in (repeated.distances, *repeated.tolerances.values()) for d in each]
    errors = {"as in the recipe": repeated.error_at(None)}
    errors |= {f"{tolerance:.0e}": repeated.error_at(tolerance) for tolerance in loose_to_tight[:-1]}
    return (
        {"stop": _name_of(stop)}
        | {"tightest": float(np.median([d or math.inf for d in repeated.tolerances[loose_to_tight[-1]]]))}
        | {
            column: f"**{shown}**" if abs(error) > max(noise, _VISIBLE) else shown
            for column, (error, noise) in errors.items()
            for shown in (f"{text(100 * error, '{:+.2f}')} ± {100 * noise:.2f} %",)
        }
        | {"range": f"{min(every):.1f} – {max(every):.1f} m"}
    )


_VISIBLE = 5e-5
"""Relative change that two decimals of a per cent show."""


def tables_of_cases(campaign: Campaign, baseline: Baseline) -> dict[str, ReportTable]:
    """Return the accepted distances of a campaign with cases: a row for each case, a column for each controller."""
    rows: dict[str, dict[str, str]] = {}
    for stop in baseline.selection(campaign).stops:
        case, scenario = stop.variants["case"].replace("_", " "), stop.scenario.resolved()
        cell = Cell(stop, scenario, baseline.accepted.get(stop.name))
        rows.setdefault(case, {})[label(scenario)] = _text(cell, [])
    columns = dict.fromkeys(column for row in rows.values() for column in row)
    table = [{"case": case} | {column: row.get(column, "") for column in columns} for case, row in rows.items()]
    return {"distances": ReportTable(table, left=("case",))}


def with_distances(baseline: Baseline, results: Results) -> Baseline:
    """Return a baseline with the distances of results with FMUs of OpenModelica; ranges are extended by them.

    Raises:
        ScenarioError: All FMUs of the results are from the built-in compiler.
    """
    if not from_elsewhere(results.stops):
        raise ScenarioError(f"{results.name}: its FMUs are those of the built-in compiler; run `make regress-omc`")
    accepted = dict(baseline.accepted)
    for finding in findings_of(results).values:
        if (one := accepted.get(finding.name)) is not None and finding.value is not None:
            distance = round(finding.value, 3)
            known = (*(one.compilers.get("openmodelica", ()) if one.is_range else ()), distance)
            accepted[finding.name] = one.model_copy(update={"compilers": {"openmodelica": (min(known), max(known))}})
    return baseline.model_copy(update={"accepted": accepted})


def compilers_table(*accepted: tuple[Campaign, Baseline]) -> ReportTable:
    """Return the accepted distance of each stop, and its distances with OpenModelica's FMUs.

    A difference is that between the nearest ends of both ranges; above `ACROSS_COMPILERS` it is bold.
    """
    rows: list[dict[str, Any]] = []
    for campaign, baseline in accepted:
        for stop in baseline.selection(campaign).stops:
            one = baseline.accepted.get(stop.name)
            if one is None or not one.compilers:
                continue
            ours, others = one.ends, one.compilers["openmodelica"]
            rows.append(
                {"stop": _name_of(stop)}
                | {"built-in compiler": _range_text(*ours), "OpenModelica": _range_text(*others)}
                | {"difference": _apart(ours, others, one.value)}
            )
    return ReportTable(rows, left=("stop",))


def medians_table(*campaigns: Campaign) -> ReportTable:
    """Return the medians of repeated stops with the FMUs of both compilers, with their 95 % intervals.

    A difference is that between the nearest ends of both intervals; above `ACROSS_COMPILERS` it is bold.
    """
    rows: list[dict[str, Any]] = []
    for stop, repeated in _repeated(campaigns, "compilers"):
        repeats = repeated.distances, repeated.compilers["openmodelica"]
        distances = [[math.inf if one is None else one for one in each] for each in repeats]
        intervals = [median_interval(each) or (min(each), max(each)) for each in distances]
        shown = [
            f"{np.median(each):.1f} m [{low:.1f}, {high:.1f}]"
            for each, (low, high) in zip(distances, intervals, strict=True)
        ]
        rows.append(
            {"stop": _name_of(stop), "built-in compiler": shown[0], "OpenModelica": shown[1]}
            | {"difference": _apart(intervals[0], intervals[1], repeated.median)}
        )
    return ReportTable(rows, left=("stop",))


def _name_of(stop: PlannedStop) -> str:
    return ", ".join(name.replace("_", " ") for name in stop.variants.values())


def _apart(first: tuple[float, float], second: tuple[float, float], size: float) -> str:
    """Return the gap between two ranges relative to a size, bold above `ACROSS_COMPILERS`."""
    apart = (second[0] - first[1] if second[0] > first[1] else min(second[1] - first[0], 0.0)) / size
    shown = text(100 * apart, "{:+.2f} %")
    return f"**{shown}**" if abs(apart) > ACROSS_COMPILERS else shown


def _range_text(low: float, high: float) -> str:
    return f"{low:.2f} m" if high - low <= SMOOTH else f"{low:.1f} – {high:.1f} m"


TABLES: Mapping[str, tuple[str, Callable[[Campaign, Baseline], dict[str, ReportTable]]]] = {
    "table1": ("validation.md", tables),
    "adverse": ("rail_models.md", tables_of_cases),
}
"""Baseline → page of docs/ that contains its tables, and the function that returns them by name."""


def _published_rows(lines: Collection[Mapping[str, Cell]], columns: Sequence[str]) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = []
    first: dict[str, float] = {}  # the paper's SBC
    for stops in lines:
        distances = {column: cell.paper for column, cell in stops.items() if cell.paper is not None}
        if distances:
            first = first or distances
            changes = {c: None if distances is first else distances[c] / first[c] - 1 for c in columns}
            rows.append(
                {_FIRST: f"*published: {label(next(iter(stops.values())).scenario)}*"}
                | {column: f"{distances[column]:.1f} m" + _brackets([changes[column]]) for column in columns}
            )
    return rows


def _text(cell: Cell, others: Sequence[Cell | None]) -> str:
    """Return distance or median and range, the longest lock, and the changes against other stops."""
    stated = cell.stated
    if stated is None:
        return ""
    range_ = "" if stated.ends is None else ", {:.1f} – {:.1f} m".format(*stated.ends)
    changes = [stated.change_against(other.stated) if other and other.stated else None for other in others]
    return f"{stated.median:.1f} m{range_}{locked_text(stated.lock)}{_brackets(changes)}"


def _brackets(changes: Sequence[float | None]) -> str:
    texts = [percent(change) for change in changes if change is not None]
    return f" ({', '.join(texts)})" if texts else ""


def _name(line: tuple[str, str], lines: Mapping[tuple[str, str], Mapping[str, Cell]]) -> str:
    """Return the name of the controller of a line, with its variant if another line of the equipment has that name."""
    equipment, variant = line
    labels = {
        other: label(next(iter(stops.values())).scenario) for other, stops in lines.items() if other[0] == equipment
    }
    name = labels[line]
    return name if list(labels.values()).count(name) == 1 else f"{name}, {variant.replace('_', ' ')}"


BASELINE: Final = "table1"
"""Baseline whose distances are drawn."""
FILE: Final = "distances.svg"
"""Name of the figure in the folder of the pages."""

_WIDTH: Final = 6.67
"""Width of the figure [inches]: 640 pixels on a page, where 8.5 points are 11 pixels."""
_SHOWN: Final = ("ideal", "service")
"""Equipment in the figure."""
_LAWS: Final = ("adhesion_literal", "adhesion_based", "slope_seeking")
"""Laws of which the figure has the best one."""


def distances_figure(campaign: Campaign, baseline: Baseline) -> tuple[Figure, str]:
    """Return the figure of the accepted distances of a campaign, and its numbers as text.

    It has the SBC of the paper and the best tuned one, the law as published, the other law with the shortest stops in
    service, and the ideal bound, with ideal and service equipment. The title states the changes in service.
    """
    rows = _rows_of_figure(campaign, baseline)
    laws = rows[(rows["origin"] == _SHOWN[-1]) & rows["controller"].isin(_LAWS) & rows["vs_sbc"].notna()]
    keys = ("controller_label", ["place"], "vs_sbc")
    best = laws[laws["controller_label"].isin(rank(on_common(laws, *keys), *keys).index[:1])]
    kept = rows[rows["reference"].notna() | rows["paper"].notna() | (rows["controller"] == "ideal_bound")]
    shown = rows[rows["controller_label"].isin([*kept["controller_label"], *best["controller_label"]])]
    published = shown[shown["paper"].notna()]
    published = published.assign(origin="published", distance=published["paper"])
    tuned = rows.loc[rows["reference"] == "best tuned", "controller_label"]
    plain = {name: f"{name.partition(',')[0]} with tuned thresholds" for name in tuned}
    drawn = pandas.concat([shown, published]).replace({"controller_label": plain})
    drawing = overview_figure(drawn, width=_WIDTH)
    drawing.suptitle(_message(best), x=0.01, ha="left", fontsize=9.5, fontweight="bold")
    # So that a figure in a file can be compared with the accepted distances.
    return drawing, "\n".join(
        f"{one.stop}: {one.distance:.1f} m"
        + ("" if one.stated.ends is None else ", {:.1f} to {:.1f} m".format(*one.stated.ends))
        + ("" if math.isnan(one.paper) else f", paper {one.paper:.1f} m")
        for one in shown.itertuples()
    )


def _rows_of_figure(campaign: Campaign, baseline: Baseline) -> Frame:
    """Return a row for each accepted stop with the equipment of the figure, with the columns of `overview_figure`."""
    cells = [cell for cell in cells_of(campaign, baseline) if cell.line[0] in _SHOWN and cell.stated is not None]
    compared_with = references(cells, lambda cell: cell.scenario, _metres)
    rows = [
        {
            "stop": cell.stop.name, "place": cell.column, "origin": cell.line[0],
            "controller": cell.scenario["controller"]["kind"], "controller_label": label(cell.scenario),
            "stated": stated, "distance": stated.median, "paper": math.nan if cell.paper is None else cell.paper,
            "reference": "published" if sbc is cell else "best tuned" if tuned is cell else None,
        } | {
            name: math.nan if other is None or other.stated is None else stated.change_against(other.stated)
            for name, other in (("vs_sbc", sbc), ("vs_tuned", tuned))
        }
        for cell, (sbc, tuned) in zip(cells, compared_with, strict=True)
        if (stated := cell.stated) is not None
    ]  # fmt: skip
    frame = pandas.DataFrame(rows)
    return frame.assign(place=pandas.Categorical(frame["place"], frame["place"].unique()))


def _metres(cell: Cell) -> float | None:
    return None if cell.stated is None else cell.stated.median


def _message(best: Frame) -> str:
    """Return the changes in service by the best law, in a sentence."""
    if best.empty:
        return ""
    against = {"vs_sbc": "slip-based control as published", "vs_tuned": "tuned slip-based control"}
    parts = []
    for column, name in against.items():
        low, high = (f"{-100 * choose(best[column]):.0f}" for choose in (max, min))
        if best[column].notna().all():
            parts.append(f"{low if low == high else f'{low} to {high}'} % shorter than {name}")
    return textwrap.fill(f"In service {best['controller_label'].iloc[0]} stops {' and '.join(parts)}", 80)
