"""Distances of many cases: a panel for each family of equal equipment and creep curve, and a line for each case."""

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator

from railgrip.report import palette, style
from railgrip.report.row import Row

MAX_CASES = 60
"""Maximum number of lines in a figure."""

_MARKERS = "osD^v<>P*X"
_EDGE: Mapping[str, Any] = {"markeredgecolor": palette.BLACK, "markeredgewidth": 0.5}
_LINE, _HEADING = 0.27, 0.42  # inches
_TICKS = (100, 150, 200, 300, 500, 700, 1000, 1500, 2000, 3000)  # m


def cases_figure(rows: Sequence[Row], colours: Mapping[str, str]) -> Figure:
    """Return a figure of the distances of each case with its friction, and their change against published SBC.

    Args:
        rows: Stops; one without standstill is a cross at the right edge of both panels.
        colours: Name of a controller → colour.
    """
    has_one_scenario = len({row.scenario for row in rows}) == 1
    families: dict[tuple[str, str, str], dict[str, list[Row]]] = {}
    for row in rows:
        name = _name(row.case if has_one_scenario and row.case else row.label, row.friction)
        families.setdefault(row.setting, {}).setdefault(name, []).append(row)
    heights = [_HEADING / _LINE + len(cases) for cases in families.values()]
    drawing = style.figure(12, 1.4 + _LINE * sum(heights))
    grid = drawing.subplots(len(families), 2, sharex="col", squeeze=False, height_ratios=heights, width_ratios=(3, 2))
    looks: dict[str, dict[str, Any]] = {
        name: {"color": colour, "marker": _MARKERS[number % len(_MARKERS)], "markersize": 6.5, "linestyle": ""}
        for number, (name, colour) in enumerate(colours.items())
    }
    before = ("", "")
    for (metres, changes), ((actuation, sensors, polach), cases) in zip(grid, families.items(), strict=True):
        equipment = f", actuation {actuation}, sensors {sensors}" if before != (actuation, sensors) else ""
        before = (actuation, sensors)
        style.dress(metres, title=f"creep curve {polach.replace('_', ' ')}{equipment}")
        style.dress(changes)
        changes.axvline(0.0, color=palette.BLACK, linewidth=0.9)
        for panel, names in ((metres, list(cases)), (changes, [""] * len(cases))):
            panel.set_ylim(len(cases) - 0.5, -0.5)
            panel.set_yticks(range(len(cases)), names, fontsize=9)
        for line, row in ((line, row) for line, case in enumerate(cases.values()) for row in case):
            _draw(row, line, metres, changes, looks[row.controller_label])
    metres, changes = grid[-1]
    metres.set_xscale("log")
    metres.set_xticks(_TICKS, [f"{tick}" for tick in _TICKS])
    metres.xaxis.set_minor_locator(NullLocator())
    distances = [row.distance_m for row in rows if row.distance_m is not None]
    metres.set_xlim(0.95 * min(distances), 1.05 * max(distances))
    metres.set_xlabel("braking distance [m]")
    changes.set_xlabel("change against the published SBC [%]")
    marks = [Line2D([], [], **look, **_EDGE) for look in looks.values()]
    marks.append(Line2D([], [], color=palette.BLACK, marker="x", linestyle=""))
    drawing.legend(marks, [*colours, "no standstill"], ncols=3, fontsize=9, loc="outside upper left", frameon=False)
    return drawing


def _draw(row: Row, line: int, metres: Axes, changes: Axes, look: Mapping[str, Any]) -> None:
    if row.distance_m is None:
        for panel in (metres, changes):
            cross: dict[str, Any] = {**look, "transform": panel.get_yaxis_transform(), "marker": "x"}
            panel.plot(1.0, line, clip_on=False, **cross)
        return
    metres.plot(row.distance_m, line, **look, **_EDGE)
    if row.reduction_vs_sbc is not None:
        changes.plot(-100 * row.reduction_vs_sbc, line, **look, **_EDGE)


def _name(case: str, friction: str) -> str:
    name = case.replace("_", " ")
    return f"{name}, $\\mu_0$ {friction}" if friction else name
