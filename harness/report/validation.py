"""Tables of braking distances in docs/ and the figure above them, from the accepted distances so that both agree."""

import itertools
import math
import textwrap
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from railgrip.base.errors import ScenarioError
from railgrip.report import palette, style
from railgrip.report.baseline import ACROSS_COMPILERS, AcceptedValue, Baseline
from railgrip.report.reference import label, locked_text, references
from railgrip.report.statistics import median_interval
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
        lots: Distances by lot of the sensors [m], the same lots for all stops; empty if sensors have no errors.
    """

    stop: PlannedStop
    scenario: dict[str, Any]
    accepted: AcceptedValue | None
    paper: float | None = None
    lots: Sequence[float] = ()

    @property
    def column(self) -> str:
        """Name of the scenario."""
        return self.stop.variants["scenario"].replace("_", " ")

    @property
    def line(self) -> tuple[str, str]:
        """Equipment and controller."""
        return self.stop.variants["equipment"], self.stop.variants["controller"]

    @property
    def distance(self) -> float | None:
        """Median over the lots of sensors, or the accepted distance [m]."""
        if self.lots:
            return float(np.median(self.lots))
        return self.accepted.value if self.accepted else None

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the range over the lots of sensors, or over perturbed plants [m]."""
        if self.lots:
            return min(self.lots), max(self.lots)
        return self.accepted.ends if self.accepted else (math.nan, math.nan)

    def change_against(self, other: "Cell") -> float | None:
        """Return the relative change of the distance, over lots the median of the changes in each lot."""
        if self.lots and other.lots:
            return float(np.median([own / reference - 1 for own, reference in zip(self.lots, other.lots, strict=True)]))
        return self.distance / other.distance - 1 if self.distance and other.distance else None


_Lines = dict[tuple[str, str], dict[str, Cell]]
"""(equipment, controller) → scenario → cell."""


def tables(campaign: Campaign, baseline: Baseline) -> dict[str, ReportTable]:
    """Return the tables of accepted distances of a campaign with scenarios, equipment and controllers, by name.

    `distances` has a row for each equipment and controller, and a column for each scenario. Brackets contain the change
    against the published SBC, followed by the change against the best tuned SBC if there is one. A distance that
    depends on rounding, or on the lot of sensors, is given as median and range. Adhesion, lock and strokes are the
    maximum of the row. `orders` compares controllers in pairs, lot by lot. `discretisation` has the changes with a
    shorter communication step.

    Raises:
        ScenarioError: The repeats with other lots of sensors are missing, or belong to another stop.
    """
    cells = cells_of(campaign, baseline)
    of_sensors = [cell for cell in cells if isinstance(cell.stop.scenario.sensors, SampledSensors)]
    if campaign.conditioning and (stale := [cell.stop.name for cell in of_sensors if not cell.lots]):
        raise ScenarioError(
            f"{campaign.name}: there are no repeats with other lots of sensors of {names(stale)} as accepted; run "
            "`railgrip maintain conditioning`"
        )
    compared_with = references(cells, lambda cell: cell.scenario, lambda cell: cell.distance)
    texts = {
        (cell.line, cell.column): _text(cell, [other for other in others if other is not cell])
        for cell, others in zip(cells, compared_with, strict=True)
    }
    lines = _lines_of(cells)
    columns = list(dict.fromkeys(cell.column for cell in cells))
    rows = _published_rows(lines.values(), columns)
    for line, stops in lines.items():
        known = [cell.accepted for cell in stops.values() if cell.accepted]
        rows.append(
            {_FIRST: f"{_EQUIPMENT.get(line[0], line[0])}: {_name(line, lines)}"}
            | {column: texts.get((line, column), "") for column in columns}
            | {
                column: max((value for one in known if (value := getattr(one, key)) is not None), default=None)
                for column, key in _MAXIMA.items()
            }
        )
    distances = ReportTable(rows, {"greatest adhesion": "{:.3f}", "longest lock": "{:.1f} s"}, left=(_FIRST,))
    return {"distances": distances, "orders": _orders(lines, columns), "discretisation": steps_table(campaign)}


_MAXIMA: Final = {
    "greatest adhesion": "adhesion_peak",
    "longest lock": "longest_lock",
    "valve strokes": "valve_strokes",
}
"""Column → key of an accepted value, of which a row has the maximum."""


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
        repeated = repeats.get(stop.name)
        lots: Sequence[float] = ()
        if isinstance(stop.scenario.sensors, SampledSensors) and accepted and repeated and repeated.lots:
            lots = repeated.lot_distances if repeated.belongs(stop.scenario.digest(), accepted.value) else ()
        paper = reference.distance if reference else None
        cells.append(Cell(stop, stop.scenario.resolved(), accepted, paper, lots))
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
    rows = [
        _errors_over_tolerance(stop, repeated)
        for campaign in campaigns
        for repeats in (read_conditioning(campaign.conditioning).stops if campaign.conditioning else {},)
        for stop in campaign.stops
        if (repeated := repeats.get(stop.name)) is not None and repeated.tolerances
    ]
    return ReportTable(rows, {"tightest": "{:.2f} m"}, left=("stop",))


def _errors_over_tolerance(stop: PlannedStop, repeated: RepeatedDistances) -> dict[str, Any]:
    loose_to_tight = sorted(repeated.tolerances, reverse=True)
    every = [d or math.inf for each in (repeated.distances, *repeated.tolerances.values()) for d in each]
    errors = {"as in the recipe": repeated.error_at(None)}
    errors |= {f"{tolerance:.0e}": repeated.error_at(tolerance) for tolerance in loose_to_tight[:-1]}
    return (
        {"stop": ", ".join(name.replace("_", " ") for name in stop.variants.values())}
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
            (low, high), (lowest, highest) = one.ends, one.compilers["openmodelica"]
            apart = (lowest - high if lowest > high else min(highest - low, 0.0)) / one.value
            shown = text(100 * apart, "{:+.2f} %")
            rows.append(
                {"stop": ", ".join(name.replace("_", " ") for name in stop.variants.values())}
                | {"built-in compiler": _range_text(low, high), "OpenModelica": _range_text(lowest, highest)}
                | {"difference": f"**{shown}**" if abs(apart) > ACROSS_COMPILERS else shown}
            )
    return ReportTable(rows, left=("stop",))


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
                | dict.fromkeys(_MAXIMA, "")
            )
    return rows


def _text(cell: Cell, others: Sequence[Cell | None]) -> str:
    """Return distance or median and range, the longest lock, and the changes against other stops."""
    if cell.accepted is None or cell.distance is None:
        return ""
    accepted, range_ = cell.accepted, ""
    if cell.lots:
        range_ = f", {min(cell.lots):.1f} – {max(cell.lots):.1f} m"
    elif accepted.is_range:
        range_ = f", {accepted.lowest:.1f} – {accepted.highest:.1f} m"
    changes = [cell.change_against(other) if other else None for other in others]
    return f"{cell.distance:.1f} m{range_}{locked_text(accepted.longest_lock)}{_brackets(changes)}"


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

# Shape and filling distinguish equipment in print, too.
_MARKS: Final[tuple[dict[str, Any], ...]] = (
    {"marker": "o", "markerfacecolor": "white", "color": palette.BLUE, "markersize": 6},
    {"marker": "s", "markerfacecolor": palette.VERMILION, "color": palette.VERMILION, "markersize": 5},
    {"marker": "^", "markerfacecolor": palette.GREEN, "color": palette.GREEN, "markersize": 6},
)
_COLUMN: Final = 32.0
"""Width of a column of numbers [pt]."""
_BEYOND: Final = "full_brake"
"""Kind of controller that does not extend the scale: a train that slides stops far behind the others."""


def distances_figure(campaign: Campaign, baseline: Baseline) -> tuple[Figure, str]:
    """Return the figure of a campaign with scenarios, equipment and controllers, and its numbers as text.

    A panel for each scenario has a row for each controller and a mark for each equipment, with the range over lots of
    sensors, or over perturbed plants. Without repeats with other lots the accepted distance is drawn. Published
    distances are vertical lines.
    """
    cells = [cell for cell in cells_of(campaign, baseline) if cell.distance is not None]
    scenarios = list(dict.fromkeys(cell.column for cell in cells))
    controllers = list(dict.fromkeys(label(cell.scenario) for cell in cells))
    equipment = list(dict.fromkeys(cell.line[0] for cell in cells))
    drawing, panels = style.panels(12, 0.37 * len(controllers) + 1.3, 1, len(scenarios), sharey=True, squeeze=False)
    drawing.set_layout_engine("constrained", rect=(0.0, 0.0, 0.985, 1.0), w_pad=0.12)
    for panel, scenario in zip(panels[0], scenarios, strict=True):
        here = [cell for cell in cells if cell.column == scenario]
        style.dress(panel, x="braking distance [m]")
        panel.set_title(scenario, loc="left", fontsize=11, fontweight="bold", pad=36)
        panel.grid(visible=False, axis="y")
        for row in range(0, len(controllers), 2):
            panel.axhspan(row - 0.5, row + 0.5, color="#F1F1F1", linewidth=0, zorder=0)
        low, high = _scale(here)
        panel.set_xlim(low, high)
        _draw_published(panel, here)
        for cell in here:
            # A distance beyond the scale is an arrow at its end.
            row, number = controllers.index(label(cell.scenario)), equipment.index(cell.line[0])
            distance = cell.distance or 0.0
            y, mark = row + 0.3 * (number - (len(equipment) - 1) / 2), _mark(number)
            if distance > high:
                mark.update(marker=">", clip_on=False)
            else:
                panel.plot(cell.ends, [y, y], "-|", color=mark["color"], linewidth=1.6, markersize=5, zorder=3)
            panel.plot([min(distance, high)], [y], zorder=4, **mark)
            _write(panel, number, f"{distance:.0f}", (1.0, row), panel.get_yaxis_transform(), va="center")
        for number, name in enumerate(equipment):
            _write(panel, number, name, (1.0, 1.01), "axes fraction", va="bottom")
    panels[0, 0].set_yticks(range(len(controllers)), [textwrap.fill(name, 26) for name in controllers], fontsize=8.5)
    panels[0, 0].set_ylim(len(controllers) - 0.5, -0.5)
    for panel in panels[0]:
        panel.tick_params(axis="y", length=0)
    handles = [panels[0, 0].plot([], [], linestyle="-", **_mark(number))[0] for number in range(len(equipment))]
    drawing.legend(
        handles,
        [f"{name} equipment, line: range" for name in equipment],
        loc="outside lower center",
        ncols=len(equipment),
        fontsize=9,
        frameon=False,
    )
    # So that a figure in a file can be compared with the accepted distances.
    return drawing, "\n".join(
        f"{cell.stop.name}: {cell.distance:.1f} m, {cell.ends[0]:.1f} to {cell.ends[1]:.1f} m"
        + ("" if cell.paper is None else f", paper {cell.paper:.1f} m")
        for cell in cells
    )


def _mark(number: int) -> dict[str, Any]:
    return {"markeredgewidth": 1.5, "linewidth": 1.6, **_MARKS[number % len(_MARKS)]}


def _write(panel: Axes, number: int, text: str, place: tuple[float, float], coordinates: Any, **options: Any) -> None:
    """Write into a column to the right of a panel, at the height of a place on the panel's edge."""
    panel.annotate(
        text,
        place,
        xycoords=coordinates,
        xytext=(_COLUMN * (number + 1), 0),
        textcoords="offset points",
        ha="right",
        fontsize=8,
        color=_MARKS[number % len(_MARKS)]["color"],
        annotation_clip=False,
        **options,
    )


def _scale(cells: Sequence[Cell]) -> tuple[float, float]:
    """Return the ends of the scale [m], which holds all distances but those of `_BEYOND`."""
    shown = [cell for cell in cells if cell.scenario["controller"]["kind"] != _BEYOND] or cells
    ends = [end for cell in shown for end in (*cell.ends, cell.paper) if end is not None and isfinite(end)]
    margin = 0.06 * (max(ends) - min(ends)) or 1.0
    return min(ends) - margin, max(ends) + margin


def _draw_published(panel: Axes, cells: Sequence[Cell]) -> None:
    for cell in cells:
        if cell.paper is not None:
            panel.axvline(cell.paper, color=palette.BLACK, linestyle=(0, (4, 3)), linewidth=1.0, zorder=1)
            panel.text(
                *(cell.paper, 1.01),
                f"published,\n{label(cell.scenario).partition(',')[0]}\n{cell.paper:.1f}",
                transform=panel.get_xaxis_transform(),
                ha="center",
                va="bottom",
                fontsize=7.5,
            )
