"""Schwarz, Posielek and Goetjes (2021): their table and figure 4 with the law as printed, beside ours."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from railgrip.api import Scenario
from railgrip.report import palette, style
from railgrip.report.table import Table
from railgrip.simulate.run import run_stop
from railgrip.studies.papers.table1 import ABC, BOUNDS, DEFAULT, EQUAL, SBC, SCENARIOS, Fitted, stop_of
from railgrip.trace.stop import Stop

LIBRARY = Path(__file__).parent / "library"
FITS, IDENTIFIED = LIBRARY / "table1_fits.csv", LIBRARY / "table1_identified.csv"

LIMIT = 0.15
"""Adhesion that the paper allows, after the TSI."""


def distances(identified: Fitted) -> Table:
    """Return the six distances: published, identified, and their differences."""
    rows = [
        (f"{title}, {who}", *(f"{value:.1f} m" for value in values))
        for title, paper, own in (
            ("slip-based control", SBC, identified.sbc),
            ("adhesion-based control as printed", ABC, identified.abc),
        )
        for who, values in (("paper", paper.values()), ("identified", own.values()))
    ]
    errors = identified.errors
    rows += [
        (f"difference, {title}", *(f"{100 * error:+.1f} %".replace("-", "−") for error in part))
        for title, part in (("slip-based", errors[:3]), ("adhesion-based", errors[3:]))
    ]
    return Table.of(("", *(name.replace("_", " ") for name in SCENARIOS)), rows)


def parameters(identified: Fitted) -> Table:
    """Return what was identified, beside the published shape that the scenarios have and the bounds of the search."""
    rows: list[tuple[str, str, str, str]] = []
    for name, (low, high) in BOUNDS.items():
        own, default = (_value(one, name) for one in (identified, Fitted(candidate=DEFAULT, levels={}, sbc={}, abc={})))
        rows.append((name, f"{own:.3g}", f"{default:.3g}", f"{low:g} – {high:g}"))
    for name in SCENARIOS:
        rows.append((f"level, {name.replace('_', ' ')}", f"{identified.levels[name]:.3f}", "", "0.5 – 2.5"))
    return Table.of(("number", "identified", "dry", "bounds"), rows)


def profile(fits: Sequence[Fitted]) -> Table:
    """Return, for quarters of the bounds of each number, the least of the largest errors of all fits in them.

    Quarters whose errors are alike are those that six distances do not tell apart.
    """
    rows: list[tuple[str, ...]] = []
    for name, (low, high) in BOUNDS.items():
        edges = np.geomspace(low, high, 5) if name != "A" else np.linspace(low, high, 5)
        cells: list[str] = []
        for begin, end in pairwise(edges):
            # Values are rounded to four digits, so that one at a bound may lie beyond it.
            inside = [one.largest for one in fits if begin * 0.999 <= _value(one, name) <= end * 1.001]
            cells.append(f"{begin:.2g} – {end:.2g}: {100 * min(inside):.1f} %" if inside else "none tried")
        rows.append((name, *cells))
    return Table.of(("number", "lowest quarter", "second", "third", "highest quarter"), rows)


def equal_fits(fits: Sequence[Fitted], most: float = 2 * EQUAL, apart: float = 0.25) -> list[Fitted]:
    """Return fits with errors up to `most`, the best first, that differ in some number by `apart` of its bounds."""
    chosen: list[Fitted] = []
    for one in sorted(fits, key=lambda fit: fit.largest):
        if one.largest <= most and all(_apart(one, other) >= apart for other in chosen):
            chosen.append(one)
    return chosen


def alternatives(fits: Sequence[Fitted]) -> Table:
    """Return `equal_fits` as a table."""
    rows = [
        (*(f"{_value(one, name):.3g}" for name in BOUNDS), f"{100 * one.largest:.1f} %",
         " / ".join(f"{distance:.0f}" for distance in one.abc.values()))
        for one in equal_fits(fits)
    ]  # fmt: skip
    return Table.of((*BOUNDS, "largest error", "adhesion-based [m]"), rows, left=0)


def profile_figure(fits: Sequence[Fitted]) -> Figure:
    """Draw the largest error of every fit over each number."""
    drawing, panels = style.panels(10, 5.6, 2, 3, sharey=True)
    for panel, name in zip(panels.flat, BOUNDS, strict=True):
        shown = [one for one in fits if np.isfinite(one.largest)]
        panel.plot([_value(one, name) for one in shown], [100 * one.largest for one in shown], ".", color=palette.BLUE)
        panel.axhline(100 * EQUAL, color=palette.GREY, linestyle="--", linewidth=1)
        style.dress(panel, x=name, y="largest error of six [%]" if panel in panels[:, 0] else "")
        panel.set_yscale("log")
        panel.set_xscale("linear" if name == "A" else "log")
    return drawing


def stops_of(identified: Fitted) -> dict[str, Stop]:
    """Return the stops of figure 4: the identified pair, and our law on the scenario as it is."""
    level = identified.levels["trapezoid"]
    return {
        "SBC": run_stop(stop_of("trapezoid", identified.candidate, level, "sbc")),
        "ABC, as printed": run_stop(stop_of("trapezoid", identified.candidate, level, "abc")),
        "ABC, ours": run_stop(
            Scenario.load("trapezoid", {"adhesion.polach": identified.candidate.polach, "adhesion.level": level})
        ),
    }


def adhesion_figure(stops: Mapping[str, Stop]) -> Figure:
    """Draw adhesion of the first wheelset and the greatest possible in both stops, for each law (figure 4)."""
    sbc = stops["SBC"]
    laws = [name for name in stops if name != "SBC"]
    drawing, panels = style.panels(10, 3.4 * len(laws), len(laws), 1, sharex=True, sharey=True)
    end = max(float(stop.trace["time"].values[-1]) for stop in stops.values())
    for panel, law in zip(panels, laws, strict=True):
        for name, stop, colour in (("SBC", sbc, palette.BLUE), (law, stops[law], palette.ORANGE)):
            time = stop.trace["time"].values
            panel.plot(time, stop.trace["adhesion"].values[:, 0], color=colour, linewidth=0.7, alpha=0.8, label=name)
            colour = palette.BLACK if name == law else palette.GREY
            panel.plot(time, stop.trace["peak_adhesion"].values[:, 0], color=colour, linewidth=1.3,
                       label=f"greatest possible, {name}")  # fmt: skip
        panel.axhline(LIMIT, color=palette.VERMILION, linewidth=1, linestyle="--", label=f"limit {LIMIT:g}")
        style.dress(panel, y="adhesion of wheelset 1", title=f"{law}: {_metres(stops[law])}; SBC: {_metres(sbc)}")
        panel.set_xlim(0, end)
        panel.set_ylim(0, 0.25)
        style.legend(panel, ncols=3, loc="upper left")
    panels[-1].set_xlabel("time since the brake demand [s]")
    return drawing


def _metres(stop: Stop) -> str:
    return f"{stop.metrics.distance:.1f} m"


def _value(one: Fitted, name: str) -> float:
    return one.candidate.k_S / one.candidate.k_A if name == "k_S/k_A" else float(getattr(one.candidate, name))


def _apart(one: Fitted, other: Fitted) -> float:
    """Return the greatest distance of two fits in a number, as a share of its bounds."""
    shares: list[float] = []
    for name, (low, high) in BOUNDS.items():
        first, second = _value(one, name), _value(other, name)
        shares.append(
            abs(first - second) / (high - low) if name == "A" else abs(np.log(first / second) / np.log(high / low))
        )
    return max(shares)
