"""The result of a type test as files: JSON, CSV, and a page that can be sent on."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.figure import Figure
from scipy.ndimage import median_filter

from railgrip.files import write_text
from railgrip.report import style
from railgrip.report.page import image, write_page
from railgrip.report.results import Results
from railgrip.report.table import Table, names, percent, share
from railgrip.studies.type_test.entrants import Entrant
from railgrip.studies.type_test.judge import JUDGED, Judged, Limits, Summary, judgements, summaries

FILE: Final = "type_test.json"
_WORST: Final = 10
_SAME: Final = 0.002
"""Relative; stops that differ by less are the same: what moved parameters of the plant do to a stop."""

_JSON: Final = ("case", "controller", "tuned", "outcome", "distance_m", "bound_m", "longest_lock_s", "air_l", "strokes")
"""What is said first of each case; the rest follows."""


def write_report(
    results: Results, taking_part: Mapping[str, Entrant], limits: Limits, directory: Path, again: str = ""
) -> Path:
    """Write type_test.json, cases.csv and index.html with its figures into a folder; return the page.

    Args:
        results: Of the test; who has none is left out.
        taking_part: By name.
        limits: What stops are judged by.
        directory: The folder.
        again: Options of the command line that run a case of it again, beside controller and case.
    """
    stops = judgements(results.stops, taking_part, limits)
    board = summaries(stops, taking_part)
    content = {
        "cases": [{name: plain[name] for name in _JSON} | plain for plain in (stop.to_plain() for stop in stops)],
        "summary": {one.controller: asdict(one) for one in board},
        "limits": limits.model_dump(mode="json"),
    }
    write_text(directory / FILE, json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    table_of(stops).write_csv(directory / "cases.csv")
    present = {result.variants["controller"] for result in results.stops}
    figures: dict[str, str] = {}
    for name, caption, draw in (
        ("ratios", "Distance over that of the best tuned baseline in the same case", _ratios),
        ("utilisation", "Use of the adhesion there was, by creep curve", _by_curve),
        ("friction", "Distance over the ideal bound against friction", _over_friction),
    ):
        if stops:
            figures[caption] = image(style.save(draw(stops, board), directory / "figures" / f"{name}.png"))
    cases = {stop.case: stop.variants for stop in stops}
    return write_page(
        directory / "index.html",
        "studies/type_test/type_test.html.jinja",
        board=leaderboard(board),
        clauses=clauses(board, limits),
        count=len(cases),
        figures=figures,
        rankings={case: (variants, ranking(stops, case)) for case, variants in cases.items()},
        worst=[(one, worst(stops, one.controller, again)) for one in board],
        missing=names([name for name in results.missing if name.rpartition("-")[2] in present]),
        supply=limits.supply,
    )


def table_of(stops: Sequence[Judged]) -> Table:
    """Return every stop as a row of a table."""
    rows: list[dict[str, object]] = []
    for stop in stops:
        plain = stop.to_plain()
        verdicts, variants = plain.pop("verdicts"), plain.pop("variants")
        rows.append(plain | variants | {f"keeps_{clause}": verdict for clause, verdict in verdicts.items()})
    return Table(rows)


def leaderboard_of(directory: Path) -> Table:
    """Return the leaderboard that stands in a folder's type_test.json."""
    content = json.loads((directory / FILE).read_text(encoding="utf-8"))
    return leaderboard([Summary(**one) for one in content["summary"].values()])


def compared(directory: Path, against: str) -> Table:
    """Return how much longer than one controller the others of a folder's type_test.json stop in the same cases.

    Figures are of the cases in which both come to a stand; differences are positive where a stop is longer.
    """
    content = json.loads((directory / FILE).read_text(encoding="utf-8"))
    distances: dict[str, dict[str, float | None]] = {}
    for row in content["cases"]:
        distances.setdefault(row["controller"], {})[row["case"]] = row["distance_m"]
    rows: list[dict[str, object]] = []
    own = distances.pop(against, {})
    for name, others in distances.items():
        pairs = np.array([(d, own[case]) for case, d in others.items() if d and own.get(case)])
        if not pairs.size:
            continue
        ratios, metres = pairs[:, 0] / pairs[:, 1], pairs[:, 0] - pairs[:, 1]
        rows.append(
            {
                "controller": name,
                "both stop": len(pairs),
                "shorter": int(np.sum(ratios < 1 - _SAME)),
                "longer": int(np.sum(ratios > 1 + _SAME)),
                "least": ratios.min(),
                "median": np.median(ratios),
                "mean": ratios.mean(),
                "most": ratios.max(),
                "shortened most": metres.min(),
                "in the mean": metres.mean(),
                "lengthened most": metres.max(),
            }
        )
    relative, metric = ("least", "median", "mean", "most"), ("shortened most", "in the mean", "lengthened most")
    forms = {column: "{:.3f}" if column in relative else "{:+.1f} m" for column in (*relative, *metric)}
    return Table(rows, forms, ("controller",), f"Distance over that of {against}, case by case")


def leaderboard(board: Sequence[Summary]) -> Table:
    """Return the controllers, shortest first."""
    rows = [
        {
            "controller": one.description,
            "tuned": "yes" if one.tuned else "",
            "cases": one.cases,
            "stops": one.stops,
            "median": one.median,
            "95 %": _or_endless(one.p95, one.median),
            "worst": _or_endless(one.worst, one.median),
            "over bound": one.over_bound,
            "utilisation": one.utilisation,
            "longest lock": one.longest_lock_s,
            "air": one.air,
            "strokes": one.strokes,
            "NEES (10 – 90 %)": ""
            if one.nees is None
            else f"{one.nees:.2g} ({one.nees_low:.2g} – {one.nees_high:.2g})",
            "K_wet (10 %)": ""
            if one.k_wet is None
            else f"{one.k_wet:.2f}"
            + ("" if one.k_wet_low is None else f" [{one.k_wet_low:.2f}, {one.k_wet_high:.2f}]"),
        }
        for one in board
    ]
    forms = dict.fromkeys(("median", "95 %", "worst", "over bound", "air", "strokes"), "{:.3f}")
    return Table(rows, forms | {"stops": share, "utilisation": "{:.2f}", "longest lock": "{:.2f} s"}, ("controller",))


def _or_endless(value: float | None, median: float | None) -> float | str | None:
    return "no stop" if value is None and median is not None else value


def clauses(board: Sequence[Summary], limits: Limits) -> Table:
    """Return the share of cases in which each controller keeps each clause."""
    rows = [
        {
            "clause": getattr(limits, clause).clause,
            "limit": getattr(limits, clause).limit,
            **{one.controller: one.kept[clause] for one in board},
        }
        for clause in JUDGED
    ]
    return Table(rows, {"limit": "{:g}"} | {one.controller: share for one in board}, ("clause",))


def ranking(stops: Sequence[Judged], case: str) -> Table:
    """Return who stopped a case in what distance, shortest first."""
    own = [stop for stop in stops if stop.case == case]
    own.sort(key=lambda stop: math.inf if stop.distance_m is None else stop.distance_m)
    rows = [
        {
            "controller": stop.controller,
            "distance": stop.outcome if stop.distance_m is None else stop.distance_m,
            "over bound": None if stop.over_bound is None else stop.over_bound - 1,
            "extension": stop.extension,
            "lock": stop.longest_lock_s,
            "locked": stop.locked_distance_m,
            "air": stop.air_l,
            "reservoir": stop.reservoir_bar,
            "strokes": stop.strokes,
            "tread": stop.tread_energy_mj,
            "utilisation": stop.utilisation,
            "fails": ", ".join(clause for clause in JUDGED if stop.verdicts[clause] is False),
        }
        for stop in own
    ]
    forms = {
        "distance": "{:.1f} m", "over bound": percent, "extension": percent, "lock": "{:.2f} s", "locked": "{:.1f} m",
        "air": "{:.0f} l", "reservoir": "{:.1f} bar", "tread": "{:.2f} MJ", "utilisation": "{:.2f}",
    }  # fmt: skip
    return Table(rows, forms, ("controller", "fails"))


def worst(stops: Sequence[Judged], controller: str, again: str) -> Table:
    """Return the cases in which a controller is farthest behind the best tuned baseline, and how to run them again."""
    own = [stop for stop in stops if stop.controller == controller]
    own.sort(key=lambda stop: -(stop.over_best or math.inf) if stop.best_m or stop.distance_m is None else 0.0)
    rows = [
        {
            "case": stop.case,
            "distance": stop.outcome if stop.distance_m is None else stop.distance_m,
            "over best": None if stop.over_best is None else stop.over_best - 1,
            **stop.variants,
            "again": f"railgrip type-test --controller {controller} --case {stop.case}{again}",
        }
        for stop in own[:_WORST]
    ]
    return Table(rows, {"distance": "{:.1f} m", "over best": percent}, ("case", *own[0].variants, "again"))


def _colours(board: Sequence[Summary]) -> dict[str, tuple[str, str]]:
    colours = (style.BLUE, style.ORANGE, style.GREEN, style.VERMILION, style.PURPLE, style.SKY, style.BLACK)
    return {
        one.controller: (colours[n % len(colours)], "-" if n < len(colours) else "--") for n, one in enumerate(board)
    }


def _ratios(stops: Sequence[Judged], board: Sequence[Summary]) -> Figure:
    """Draw for each controller the share of cases that it stops within a multiple of the best tuned baseline."""
    figure = style.figure(8.0, 4.5)
    axes = figure.subplots()
    for name, (colour, dash) in _colours(board).items():
        own = [stop for stop in stops if stop.controller == name and stop.best_m]
        ratios = np.sort([stop.over_best for stop in own if stop.over_best is not None])
        if ratios.size:
            axes.step(ratios, (1 + np.arange(ratios.size)) / len(own), dash, where="post", color=colour, label=name)
    axes.axvline(1.0, color=style.GREY, linewidth=0.8)
    axes.set_xscale("log")
    axes.set_xticks([0.8, 0.9, 1.0, 1.2, 1.5, 2.0, 3.0], ["0.8", "0.9", "1", "1.2", "1.5", "2", "3"])
    axes.set_xticks([], minor=True)
    style.dress(axes, x="distance over that of the best tuned baseline", y="share of the cases")
    if axes.lines[1:]:
        axes.legend(fontsize=7, loc="lower right")
    return figure


def _by_curve(stops: Sequence[Judged], board: Sequence[Summary]) -> Figure:
    """Draw the median use of adhesion of each controller under each creep curve."""
    curves = sorted({stop.variants["curve"] for stop in stops})
    values = [
        [
            np.median([s.utilisation for s in stops if s.controller == one.controller and s.variants["curve"] == curve
                       and s.utilisation is not None] or [np.nan])
            for curve in curves
        ]
        for one in board
    ]  # fmt: skip
    figure = style.figure(8.0, 1.2 + 0.32 * len(board))
    axes = figure.subplots()
    axes.imshow(values, vmin=0.4, vmax=1.0, cmap="RdYlGn", aspect="auto")
    for row, line in enumerate(values):
        for column, value in enumerate(line):
            if np.isfinite(value):
                axes.text(column, row, f"{value:.2f}", ha="center", va="center", fontsize=8)
    axes.set_xticks(range(len(curves)), [curve.replace("_", "\n") for curve in curves], fontsize=8)
    axes.set_yticks(range(len(board)), [one.controller for one in board], fontsize=8)
    return figure


def _over_friction(stops: Sequence[Judged], board: Sequence[Summary]) -> Figure:
    """Draw distances over the ideal bound against mean friction, and their median over a tenth of the cases."""
    figure = style.figure(8.0, 4.5)
    axes = figure.subplots()
    bounds = {one.controller for one in board if one.role == "bound"}
    for name, (colour, dash) in _colours(board).items():
        own = [(float(s.variants["friction"]), s.over_bound) for s in stops if s.controller == name and s.over_bound]
        if own and name not in bounds:
            friction, ratios = zip(*sorted(own), strict=True)
            axes.plot(friction, ratios, "o" if dash == "-" else "x", color=colour, markersize=2.5, alpha=0.25)
            median = median_filter(ratios, size=1 + len(own) // 10, mode="nearest")
            axes.plot(friction, median, dash, color=colour, label=name)
    axes.set_xscale("log")
    axes.set_xticks([0.02, 0.03, 0.05, 0.08, 0.15], ["0.02", "0.03", "0.05", "0.08", "0.15"])
    axes.set_xticks([], minor=True)
    axes.set_ylim(0.95, 2.5)
    style.dress(axes, x="mean of the maximum friction", y="distance over the ideal bound")
    if axes.lines:
        axes.legend(fontsize=7, loc="upper right")
    return figure
