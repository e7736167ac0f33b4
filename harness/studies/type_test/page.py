"""The page of a type test: leaderboard, clauses, rankings, worst cases and figures, as views of the judged stops."""

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any, Final

import numpy as np
import pandas
from matplotlib.figure import Figure
from scipy.ndimage import median_filter

from railgrip.base import registry
from railgrip.report import palette, style
from railgrip.report.frame import Frame
from railgrip.report.limits import AssessmentLimits
from railgrip.report.page import Page
from railgrip.report.statistics import on_common
from railgrip.report.table import Form, ReportTable, names, percent, share
from railgrip.studies.type_test.design import VALIDATION_SEED
from railgrip.studies.type_test.entrants import Entrant
from railgrip.studies.type_test.family import (
    by_axis,
    families,
    losses,
    recommendation,
    table_of_controller,
    table_of_families,
    verdict,
    with_interval,
)
from railgrip.studies.type_test.stop_frames import EQUAL, JUDGED, judgements, over_best, plain_rows, summaries

_ON_PAGE_ONLY: Final = ("compared", "K_wet (10 %)")
"""Columns of the leaderboard that are omitted there and on the screen."""
_NOT_OF_STOPS: Final = ("NEES (10 – 90 %)", "K_wet (10 %)")
"""Columns of the leaderboard that are in a separate table on the page."""

_WORST: Final = 10
_JSON: Final = ("case", "controller", "tuned", "outcome", "distance_m", "bound_m", "longest_lock_s", "air_l", "strokes")
"""Columns that come first in the table of cases."""


def page_of(
    found: Frame,
    taking_part: Mapping[str, Entrant],
    limits: AssessmentLimits,
    *,
    packaged: Frame | None = None,
    notes: Sequence[str] = (),
    candidates: Sequence[str] = (),
    missing: Sequence[str] = (),
    against: str | None = None,
    again: Mapping[str, str],
    looks: ReportTable | None = None,
    version: int = 1,
) -> Page:
    """Return the page of a type test.

    Args:
        found: Stops that were run; a controller without a stop is omitted.
        taking_part: Entrants by name.
        limits: Limits of the clauses.
        packaged: Packaged stops of controllers that were not run.
        notes: Sentences on the packaged stops.
        candidates: Controllers that the page is about; all if empty.
        missing: Names of stops without a result.
        against: Controller with which the others are compared case by case on the screen.
        again: Controller → command line that runs a case of it again, without the name of the case.
        looks: How often sets of cases were looked at.
        version: Version of the type test.
    """
    stops, shipped = found, set[str]()
    if packaged is not None and len(packaged):
        run = set(zip(found["case"], found["controller"], strict=True))
        is_run = [pair in run for pair in zip(packaged["case"], packaged["controller"], strict=True)]
        others = packaged[~np.array(is_run)]
        stops, shipped = pandas.concat([found, others] if len(found) else [others]), set(others["controller"])
    stops = judgements(stops, taking_part, limits, only_tuned=version == 1)
    board, unranked = ranked(stops, taking_part, candidates)
    of_ranked = stops[stops["controller"].isin(board["controller"])]
    lines, variants_of = _lines(board, candidates), dict(zip(stops["case"], stops["variants"], strict=True))
    drawings = {
        "figures/ratios.png": (
            "Distance over that of the best tuned baseline in the same case that keeps the lock clause",
            _ratios(stops, lines),
        ),
        "figures/utilisation.png": ("Use of the adhesion there was, by creep curve", _by_curve(stops, list(lines))),
        "figures/friction.png": ("Distance over the ideal bound against friction", _over_friction(stops, lines)),
    }
    leaders, rows = leaderboard(board), families(stops if version > 1 else stops.head(0))
    laws = board[~board["controller"].isin(list(registry.ANALYSES))]
    return Page(
        title="Type test of wheel-slide protection",
        question=f"{f'How does {names(candidates)} compare with' if candidates else 'Which is the shortest of'} the "
        "stops of railgrip's controllers in cases that none was tuned on, and which clauses of a type test are kept?",
        answer=answer(board, stops["case"].nunique(), limits, candidates),
        template="studies/type_test/type_test.md.jinja",
        values={
            "leaders": leaders,
            "board": leaders.without(_NOT_OF_STOPS),
            "estimates": leaders.without([name for name in leaders.columns[1:] if name not in _NOT_OF_STOPS]),
            "clauses": clauses(board, limits),
            "failed_by_bound": failed_by_bound(board, limits),
            "texts": {_heading(clause, limits): getattr(limits, clause).clause for clause in JUDGED},
            "count": len(variants_of),
            "is_validation": any(case.endswith(f"-{VALIDATION_SEED}") for case in variants_of),
            "rankings": {case: (variants, ranking(stops, case)) for case, variants in variants_of.items()},
            "supply": limits.supply,
            "losses": losses(rows, laws),
            "families": by_axis(rows, board),
            "of_controller": {one.controller: table_of_controller(rows, one) for one in board.itertuples()},
            "verdict": verdict(of_ranked) if version > 1 else "",
            "recommendation": recommendation(of_ranked) if version > 1 else None,
            "version": version,
            "looks": looks,
            "controllers": _controllers(board, shipped, taking_part, version),
            "captions": {name: caption for name, (caption, _) in drawings.items()},
            "worst": [
                (summary, worst(stops, summary.controller, again[summary.controller]))
                for summary in board.itertuples()
                if not candidates or summary.controller in candidates
            ],
            "missing": names(missing),
            "notes": [*notes, *unranked],
            "unranked": unranked,
        },
        figures={name: drawing for name, (_, drawing) in drawings.items() if len(stops) and drawing},
        tables={"cases.csv": table_of(stops)} | ({"families.csv": table_of_families(rows)} if len(rows) else {}),
        data={
            "type_test.json": {
                "cases": [{name: row[name] for name in _JSON} | row for row in plain_rows(stops)],
                "summary": {row["controller"]: row for row in board.to_dict("records")},
                "limits": limits.model_dump(mode="json"),
            }
        },
        screen=(
            leaders.without(_ON_PAGE_ONLY),
            *notes,
            *unranked,
            *([compare_controllers(stops, against)] if against else ()),
        ),
    )


def ranked(stops: Frame, taking_part: Mapping[str, Entrant], candidates: Collection[str]) -> tuple[Frame, list[str]]:
    """Return the leaderboard over the cases that all of its controllers have, and sentences on what it leaves out.

    Controllers that were run in fewer than half of the cases are left out, except candidates. Those that know the true
    state, which have no stop in many cases, are listed over the cases that they have.
    """
    counts = stops.groupby("controller", sort=False)["case"].nunique()
    most = max(counts, default=0)
    few = counts[(2 * counts < most) & ~counts.index.isin([*candidates, *registry.ANALYSES])]
    sentences = [f"{name} was run in {count} of {most} cases and is not ranked." for name, count in few.items()]
    kept = stops[~stops["controller"].isin(few.index)].assign(endless=stops["distance_m"].fillna(math.inf))
    laws = on_common(kept[~kept["controller"].isin(list(registry.ANALYSES))], "controller", ["case"], "endless")
    common = laws["case"].unique()
    if 0 < len(common) < most:
        sentences.append(f"Controllers are compared in the {len(common)} of {most} cases that all of them have.")
    return summaries(kept[kept["case"].isin(common)], taking_part), sentences


def table_of(stops: Frame) -> ReportTable:
    """Return every stop as a row of a table."""
    rows: list[dict[str, object]] = []
    for plain in plain_rows(stops):
        verdicts, variants = plain.pop("verdicts"), plain.pop("variants")
        rows.append(plain | variants | {f"keeps_{clause}": verdict for clause, verdict in verdicts.items()})
    return ReportTable(rows)


def compare_controllers(stops: Frame, against: str) -> ReportTable:
    """Return the additional distance of the others in comparison with one controller in the same cases.

    Only cases in which both stop are compared; differences are positive if a stop is longer.
    """
    distances = stops.pivot(index="case", columns="controller", values="distance_m")[stops["controller"].unique()]
    reference = distances.pop(against) if against in distances else pandas.Series(dtype=float)
    ratios, metres = distances.div(reference, axis=0), distances.sub(reference, axis=0)
    table = pandas.DataFrame(
        {
            "both stop": ratios.count(),
            "shorter": (ratios < 1 - EQUAL).sum(),
            "longer": (ratios > 1 + EQUAL).sum(),
            "least": ratios.min(),
            "median": ratios.median(),
            "mean": ratios.mean(),
            "most": ratios.max(),
            "shortened most": metres.min(),
            "in the mean": metres.mean(),
            "lengthened most": metres.max(),
        }
    )
    table = table[table["both stop"] > 0].rename_axis("controller").reset_index()
    forms: dict[str, Form] = dict.fromkeys(("least", "median", "mean", "most"), "{:.3f}")
    forms |= dict.fromkeys(("shortened most", "in the mean", "lengthened most"), "{:+.1f} m")
    return ReportTable.of_frame(table, forms, title=f"Distance over that of {against}, case by case")


def leaderboard(board: Frame) -> ReportTable:
    """Return the controllers, shortest first."""
    rows = [
        (
            summary.controller,
            summary.stops,
            f"{summary.compared} of {summary.cases}",
            with_interval(summary.median, summary.median_interval, ""),
            with_interval(summary.p95, summary.p95_interval, "" if summary.median is None else "no stop"),
            "no stop" if summary.worst is None and summary.median is not None else summary.worst,
            summary.over_bound,
            summary.utilisation,
            summary.longest_lock_s,
            summary.air,
            summary.strokes,
            "" if summary.nees is None else f"{summary.nees:.2g} ({summary.nees_low:.2g} – {summary.nees_high:.2g})",
            with_interval(summary.k_wet, (summary.k_wet_low, summary.k_wet_high), "", "{:.2f}"),
        )
        for summary in board.itertuples()
    ]
    return ReportTable.of(_LEADERBOARD, rows)


_LEADERBOARD: Final[Mapping[str, Form]] = {
    "controller": "", "stops": share, "compared": "", "median": "", "95 %": "", "worst": "{:.3f}",
    "over bound": "{:.3f}", "utilisation": "{:.2f}", "longest lock": "{:.2f} s", "air": "{:.3f}", "strokes": "{:.3f}",
    "NEES (10 – 90 %)": "", "K_wet (10 %)": "",
}  # fmt: skip
"""Column of the leaderboard → its form."""


def _controllers(
    board: Frame, from_package: Collection[str], taking_part: Mapping[str, Entrant], version: int
) -> ReportTable:
    """Return a description of each controller, and whether its stops were run or come with the package."""

    def trials(name: str) -> int | str:
        count = taking_part[name].hand_trials
        return count if count is not None else "" if name in registry.ANALYSES else "not counted"

    rows = [
        (
            summary.controller,
            summary.description,
            "yes" if summary.tuned else "",
            trials(summary.controller),
            "shipped" if summary.controller in from_package else "run here",
        )
        for summary in board.itertuples()
    ]
    by_hand, left = "sets tried by hand", ("controller", "description", "parameters searched", "results")
    table = ReportTable.of((*left[:3], by_hand, left[3]), rows, left=left)
    return table if version > 1 else table.without([by_hand])


def clauses(board: Frame, limits: AssessmentLimits) -> ReportTable:
    """Return the share of cases in which each controller keeps each clause."""
    rows = [(summary.controller, *(summary.kept[clause] for clause in JUDGED)) for summary in board.itertuples()]
    return ReportTable.of({"controller": ""} | {_heading(clause, limits): share for clause in JUDGED}, rows)


_LIMITS: Final[Mapping[str, tuple[str, float, str]]] = {
    "extension": ("≤", 100, "%"),
    "lock": ("≤", 1, "s"),
    "locked_distance": ("≤", 1, "m"),
    "reservoir": ("≥", 1e-5, "bar"),
    "utilisation": ("≥", 100, "%"),
}
"""Clause → direction of its limit, and factor and unit of its representation."""


def _heading(clause: str, limits: AssessmentLimits) -> str:
    name, limit = clause.replace("_", " "), getattr(limits, clause).limit
    if clause not in _LIMITS:
        return name
    if limit is None:
        return f"{name}, not judged"
    sense, factor, unit = _LIMITS[clause]
    return f"{name} {sense} {factor * limit:g} {unit}"


def failed_by_bound(board: Frame, limits: AssessmentLimits) -> list[str]:
    """Return a sentence for each clause that the ideal bound does not keep in all cases."""
    return [
        f"“{getattr(limits, clause).clause}” is kept by {summary.controller} in {share(kept)} of the cases in which it "
        "is judged. In the others adhesion, gradient and brakes leave no controller enough deceleration to keep it."
        for summary in board.itertuples()
        if summary.role == "bound"
        for clause in JUDGED
        if (kept := summary.kept[clause]) is not None and kept < 1
    ]


def answer(board: Frame, count: int, limits: AssessmentLimits, candidates: Sequence[str] = ()) -> str:
    """Return a sentence comparing the best candidate with the others and the ideal bound, with its weakest clause.

    Without candidates all controllers are compared, except those that know the true state.
    """
    laws = [one for one in board.itertuples() if one.controller not in registry.ANALYSES and one.median is not None]
    best = next((one for one in laws if not candidates or one.controller in candidates), None)
    if best is None:
        return f"In {count} cases no distance can be compared with that of a tuned baseline."
    place = laws.index(best) + 1
    stands = "stops shortest" if place == 1 else f"is number {place}"
    over = "" if best.over_bound is None else f" and {best.over_bound:.3f} of the ideal bound"
    return (
        f"{best.controller} ({best.description}) {stands} of {len(laws)} controllers in {count} cases: its median "
        f"distance is {best.median:.3f} of that of the best tuned baseline{over}. {_weakest(best, board, limits)}"
    )


def _weakest(summary: Any, board: Frame, limits: AssessmentLimits) -> str:
    bound: Mapping[str, float | None] = next((one.kept for one in board.itertuples() if one.role == "bound"), {})
    possible = {clause: 1.0 if kept is None else kept for clause, kept in bound.items()}
    behind = {clause: possible.get(clause, 1.0) - kept for clause, kept in summary.kept.items() if kept is not None}
    weakest = max(behind, key=lambda clause: behind[clause])
    if behind[weakest] <= 0:
        return "It keeps each clause wherever the ideal bound keeps it."
    clause = getattr(limits, weakest).clause
    return f"Its weakest clause is “{clause}”, kept in {share(summary.kept[weakest] or 0.0)} of the cases."


def ranking(stops: Frame, case: str) -> ReportTable:
    """Return the distance of each controller in a case, shortest first."""
    own = stops[stops["case"] == case].sort_values("distance_m", kind="stable")
    columns = {
        "controller": "controller", "distance": "distance_m", "over bound": "over_bound", "extension": "extension",
        "lock": "longest_lock_s", "locked": "locked_distance_m", "air": "air_l", "reservoir": "reservoir_bar",
        "strokes": "strokes", "tread": "tread_energy_mj", "utilisation": "utilisation",
    }  # fmt: skip
    table = pandas.DataFrame({name: own[column] for name, column in columns.items()}).assign(
        **{"distance": _distance_or_outcome(own), "over bound": own["over_bound"] - 1},
        fails=[", ".join(clause for clause in JUDGED if verdicts[clause] is False) for verdicts in own["verdicts"]],
    )
    forms = {
        "distance": "{:.1f} m", "over bound": percent, "extension": percent, "lock": "{:.2f} s", "locked": "{:.1f} m",
        "air": "{:.0f} l", "reservoir": "{:.1f} bar", "strokes": "{:.0f}", "tread": "{:.2f} MJ",
        "utilisation": "{:.2f}",
    }  # fmt: skip
    return ReportTable.of_frame(table, forms, ("controller", "fails"))


def worst(stops: Frame, controller: str, again: str) -> ReportTable:
    """Return the cases in which a controller is worst relative to the best tuned baseline, with a command for each."""
    own = stops[stops["controller"] == controller]
    # Without a standstill it is worst of all; without a baseline last.
    ratio = own["over_best"].fillna(math.inf).where(own["best_m"].notna() | own["distance_m"].isna(), 0.0)
    own = own.loc[ratio.sort_values(ascending=False, kind="stable").index].head(_WORST)
    rows = [
        {
            "case": stop.case,
            "distance": distance,
            "over best": stop.over_best - 1,
            **stop.variants,
            "again": f"{again} {stop.case}",
        }
        for stop, distance in zip(own.itertuples(), _distance_or_outcome(own), strict=True)
    ]
    return ReportTable(
        rows, {"distance": "{:.1f} m", "over best": percent}, ("case", *own["variants"].iloc[0], "again")
    )


def _distance_or_outcome(stops: Frame) -> Frame:
    return stops["distance_m"].astype(object).where(stops["distance_m"].notna(), stops["outcome"])


def _lines(board: Frame, candidates: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return controller → look of its line."""
    colours, dashes = [colour for colour in palette.LINES if colour != palette.BLACK], ("-", "--", ":")
    lines: dict[str, dict[str, Any]] = {}
    for n, name in enumerate(board["controller"]):
        colour, dash = colours[n % len(colours)], dashes[n // len(colours) % 3]
        colour, dash, width = (palette.BLACK, "-", 3.0) if name in candidates else (colour, dash, 1.2)
        lines[name] = {"color": colour, "linestyle": dash, "linewidth": width, "label": name}
    return lines


def _ratios(stops: Frame, lines: Mapping[str, Mapping[str, Any]]) -> Figure | None:
    if not stops["over_best"].count():
        return None
    figure = style.figure(9.5, 4.5)
    axes = figure.subplots()
    for name, line in lines.items():
        of_controller = over_best(stops[stops["controller"] == name])
        ratios = np.sort(of_controller[np.isfinite(of_controller)])
        if ratios.size:
            axes.step(ratios, (1 + np.arange(ratios.size)) / len(of_controller), where="post", **line)
    axes.axvline(1.0, color=palette.GREY, linewidth=0.8)
    axes.set_xscale("log")
    axes.set_xticks([0.8, 0.9, 1.0, 1.2, 1.5, 2.0, 3.0], ["0.8", "0.9", "1", "1.2", "1.5", "2", "3"])
    axes.set_xticks([], minor=True)
    style.dress(axes, x="distance over that of the best tuned baseline", y="share of the cases")
    style.legend(axes, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def _by_curve(stops: Frame, controllers: Sequence[str]) -> Figure:
    stops = on_common(stops[stops["controller"].isin(controllers)], "controller", ["case"], "utilisation")
    curve = pandas.Series([variants["curve"] for variants in stops["variants"]], stops.index, dtype=object)
    medians = stops.groupby([stops["controller"], curve])["utilisation"].median().unstack()
    medians = medians.reindex(controllers)
    curves, values = list(medians.columns), medians.to_numpy()
    figure = style.figure(8.0, 1.2 + 0.32 * len(controllers))
    axes = figure.subplots()
    axes.imshow(values, vmin=0.4, vmax=1.0, cmap="viridis", aspect="auto")
    for row, line in enumerate(values):
        for column, value in enumerate(line):
            if np.isfinite(value):
                colour = "white" if value < 0.7 else "black"
                axes.text(column, row, f"{value:.2f}", ha="center", va="center", fontsize=8, color=colour)
    axes.set_xticks(range(len(curves)), [curve.replace("_", "\n") for curve in curves], fontsize=8)
    axes.set_yticks(range(len(controllers)), controllers, fontsize=8)
    return figure


def _over_friction(stops: Frame, lines: Mapping[str, Mapping[str, Any]]) -> Figure | None:
    # Distances over the ideal bound against mean friction, and their median over a tenth of the cases.
    compared = stops[stops["over_bound"].notna() & (stops["controller"] != "ideal_bound")]
    if compared.empty:
        return None
    figure = style.figure(9.5, 4.5)
    axes = figure.subplots()
    for name, line in lines.items():
        own = compared[compared["controller"] == name]
        points = [(float(one.variants["friction"]), one.over_bound) for one in own.itertuples()]
        if points:
            friction, ratios = zip(*sorted(points), strict=True)
            axes.plot(friction, ratios, "o", color=line["color"], markersize=2.5, alpha=0.25)
            axes.plot(friction, median_filter(ratios, size=1 + len(points) // 10, mode="nearest"), **line)
    axes.set_xscale("log")
    axes.set_xticks([0.02, 0.03, 0.05, 0.08, 0.15], ["0.02", "0.03", "0.05", "0.08", "0.15"])
    axes.set_xticks([], minor=True)
    axes.set_ylim(0.95, max(2.5, 1.1 * compared["over_bound"].min()))  # at least the best is to be seen
    style.dress(axes, x="mean of the maximum friction", y="distance over the ideal bound")
    style.legend(axes, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure
