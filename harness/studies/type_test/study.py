"""The type test: its options, its page, JSON and CSV, and headline numbers."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
from matplotlib.figure import Figure
from scipy.ndimage import median_filter
from typer import Option

from railgrip.base.errors import ScenarioError
from railgrip.campaign.run import CampaignRun, write_description
from railgrip.campaign.work import Work
from railgrip.report import palette, style
from railgrip.report.baseline import Finding, mean
from railgrip.report.index import write_report as write_panels
from railgrip.report.marked import write_tables
from railgrip.report.page import Page
from railgrip.report.results import Results, read_results
from railgrip.report.table import Table, names, percent, share
from railgrip.scenario.outcome import Outcome
from railgrip.scenario.schema import Scenario
from railgrip.simulate.parts import CustomParts
from railgrip.simulate.run import run_stop
from railgrip.studies.study import Study
from railgrip.studies.type_test.design import CASES, QUICK, SEED, VALIDATION_SEED, case_named, cases
from railgrip.studies.type_test.entrants import (
    Entrant,
    campaign_of,
    entrants,
    entrants_named,
    task_of,
    train_of,
    training_cases,
)
from railgrip.studies.type_test.judge import (
    JUDGED,
    Judged,
    Limits,
    Summary,
    judgements,
    keeps_lock,
    limits_of,
    summaries,
)

PAGE: Final = Path("docs/type_test.md")
"""From the folder of the project, where the command runs."""

_HIDDEN: Final = ("tuned", "cases", "compared", "K_wet (10 %)")
"""Columns of the leaderboard that are left out there."""

_WORST: Final = 10
_SAME: Final = 0.002
"""Relative; stops that differ by less are the same: what moved parameters of the plant do to a stop."""

_JSON: Final = ("case", "controller", "tuned", "outcome", "distance_m", "bound_m", "longest_lock_s", "air_l", "strokes")
"""What is said first of each case; the rest follows."""


@dataclass(frozen=True)
class TypeTest(Study):
    """Stop a train in hundreds of cases under each controller, judge every stop, and rank them."""

    controller: Annotated[
        list[str] | None,
        Option(help="One of ours, a scenario, an .fmu or module:Class; all of ours without it. Repeatable."),
    ] = None
    train: Annotated[
        str | None, Option(help="A scenario whose train it is, a train, an .fmu or a recipe; ours without it.")
    ] = None
    task: Annotated[
        Path | None, Option(help="A scenario whose demand and [adhesion.conditioning] hold in every case.")
    ] = None
    against: Annotated[
        str | None, Option(help="A controller of the test: distances of the others over its own, case by case.")
    ] = None
    quick: Annotated[bool, Option(help="A tenth of the cases: shows where a controller stands.")] = False
    validation: Annotated[bool, Option(help="Other cases, for a finished controller: do not tune on them.")] = False
    count: Annotated[int | None, Option("--cases", min=1, max=10000, help="Number of cases.")] = None
    case: Annotated[list[str] | None, Option(help="Only this one, with trace and panels. Repeatable.")] = None
    limits: Annotated[Path | None, Option(help="File of limits in place of ours.")] = None
    write: Annotated[bool, Option("--write", help="Write the leaderboard into docs/type_test.md.")] = False
    import_from: list[Path] | None = None

    @property
    def place(self) -> str:
        """A folder for each train, task, and for single cases."""
        names = [Path(file).stem for file in (self.train, self.task) if file is not None]
        return "/".join([*names, "cases"] if self.case else names)

    def page(self, work: Work) -> Page:
        """Run what is missing, judge it with what was there, and rank the controllers."""
        judging, ours = limits_of(self.limits), entrants()
        candidates = ours if self.controller is None else entrants_named(self.controller, ours)
        taking_part = ours | candidates
        if self.against is not None and self.against not in taking_part:
            raise ScenarioError(f"--against {self.against}: is none of {', '.join(taking_part)}")
        # What others are measured with is run, too; what they are compared with comes from earlier runs.
        running = {name for name, entrant in ours.items() if entrant.role in {"reference", "bound"}} | candidates.keys()
        if self.case:
            design = tuple(case_named(name) for name in self.case)
        else:
            count = self.count or (QUICK if self.quick else CASES)
            design = cases(count, VALIDATION_SEED if self.validation else SEED)
        task = None if self.task is None else task_of(self.task)
        campaign = campaign_of(design, taking_part, train_of(self.train), task=task, keep_traces=bool(self.case))
        stops = campaign.only(lambda stop: stop.variants["controller"] in running)
        runner = partial(run_stop, objects=CustomParts(folders=tuple(self.import_from or ())))
        exit_code = work.stops([CampaignRun(stops, work.folder)], runner, is_any_outcome=True)
        write_description(campaign, work.folder)
        page = page_of(read_results(work.folder), taking_part, judging, against=self.against, again=self._again)
        if self.write:
            write_tables(PAGE, {"leaderboard": _written(page, len(design), self.validation)})
        panels = [
            str(write_panels(work.folder / stop.name))
            for stop in (stops.stops if self.case else ())
            if stop.variants["controller"] in candidates and (work.folder / stop.name / "trace.nc").exists()
        ]
        return replace(page, screen=(*page.screen, *panels), exit_code=exit_code)

    @property
    def _again(self) -> str:
        """Options of the command line that run a case again, beside controller and case."""
        options = (("train", self.train), ("task", self.task))
        return "".join(f" --{name} {value}" for name, value in options if value is not None)

    def headlines(self, work: Work) -> list[Finding]:
        """Return quantiles of the distance over the best tuned baseline's, in six short cases of the training set.

        As in the leaderboard, a baseline that does not stop or does not keep the lock clause does not count.
        """
        taking_part = {name: entrants()[name] for name in ("constant_slip", "extremum_seeking", "slope_seeking")}
        stops = campaign_of(training_cases(6), taking_part, train_of(None)).stops
        results = work.map(_distance_and_lock, [stop.scenario for stop in stops])
        distances, keeps_lock_clause = np.array(results).reshape(-1, len(taking_part), 2).transpose(2, 0, 1)
        baselines = np.where(keeps_lock_clause, distances, math.inf)[:, :-1].min(axis=1)
        is_compared = np.isfinite(baselines)
        ratios, count = distances[is_compared, -1] / baselines[is_compared], int(is_compared.sum())
        who = "slope seeking, distance over that of the better tuned baseline"
        return [
            mean(f"{who}: median of {count}", float(np.median(ratios))),
            mean(f"{who}: worst of {count}", float(max(ratios))),
        ]


STUDY = TypeTest


def _distance_and_lock(scenario: Scenario) -> tuple[float, bool]:
    """Return the braking distance [m], infinite without a standstill, and whether the stop keeps the lock clause."""
    stop = run_stop(scenario)
    distance = stop.metrics.distance if stop.outcome is Outcome.STANDSTILL else math.inf
    return distance, keeps_lock(stop.metrics, limits_of())


def page_of(
    results: Results, taking_part: Mapping[str, Entrant], limits: Limits, *, against: str | None = None, again: str = ""
) -> Page:
    """Return the page of a type test.

    Args:
        results: Of the test; who has none is left out.
        taking_part: By name.
        limits: What stops are judged by.
        against: Whom the others are compared with case by case, on the screen.
        again: Options of the command line that run a case of it again, beside controller and case.
    """
    stops = judgements(results.stops, taking_part, limits)
    board = summaries(stops, taking_part)
    plain = [{name: row[name] for name in _JSON} | row for row in (stop.to_plain() for stop in stops)]
    present = {result.variants["controller"] for result in results.stops}
    drawings = (
        (
            "ratios",
            "Distance over that of the best tuned baseline in the same case that keeps the lock clause",
            _ratios,
        ),
        ("utilisation", "Use of the adhesion there was, by creep curve", _by_curve),
        ("friction", "Distance over the ideal bound against friction", _over_friction),
    )
    variants_of = {stop.case: stop.variants for stop in stops}
    leaders = leaderboard(board)
    return Page(
        title="Type test of wheel-slide protection",
        question="Which controller stops the train shortest in cases that it was not tuned on, and does it keep the "
        "clauses of a type test?",
        answer=answer(board, len(variants_of)),
        template="studies/type_test/type_test.md.jinja",
        values={
            "board": leaders,
            "clauses": clauses(board, limits),
            "failed_by_bound": failed_by_bound(board, limits),
            "count": len(variants_of),
            "is_validation": any(case.endswith(f"-{VALIDATION_SEED}") for case in variants_of),
            "captions": {f"figures/{name}.png": caption for name, caption, _ in drawings},
            "rankings": {case: (variants, ranking(stops, case)) for case, variants in variants_of.items()},
            "worst": [(summary, worst(stops, summary.controller, again)) for summary in board],
            "missing": names([name for name in results.missing if name.rpartition("-")[2] in present]),
            "supply": limits.supply,
        },
        figures={f"figures/{name}.png": draw(stops, board) for name, _, draw in drawings if stops},
        tables={"cases.csv": table_of(stops)},
        data={
            "type_test.json": {
                "cases": plain,
                "summary": {summary.controller: asdict(summary) for summary in board},
                "limits": limits.model_dump(mode="json"),
            }
        },
        screen=(leaders,) if against is None else (leaders, compared(plain, against)),
    )


def table_of(stops: Sequence[Judged]) -> Table:
    """Return every stop as a row of a table."""
    rows: list[dict[str, object]] = []
    for stop in stops:
        plain = stop.to_plain()
        verdicts, variants = plain.pop("verdicts"), plain.pop("variants")
        rows.append(plain | variants | {f"keeps_{clause}": verdict for clause, verdict in verdicts.items()})
    return Table(rows)


def compared(cases: Sequence[Mapping[str, Any]], against: str) -> Table:
    """Return how much longer than one controller the others stop in the same cases, which are as in type_test.json.

    Figures are of the cases in which both come to a stand; differences are positive where a stop is longer.
    """
    distances: dict[str, dict[str, float | None]] = {}
    for row in cases:
        distances.setdefault(row["controller"], {})[row["case"]] = row["distance_m"]
    rows: list[dict[str, object]] = []
    reference = distances.pop(against, {})
    for name, others in distances.items():
        pairs = np.array([(d, reference[case]) for case, d in others.items() if d and reference.get(case)])
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
            "controller": summary.description,
            "tuned": "yes" if summary.tuned else "",
            "cases": summary.cases,
            "stops": summary.stops,
            "compared": summary.compared,
            "median": _with_interval(summary.median, summary.median_interval),
            "95 %": _with_interval(_or_endless(summary.p95, summary.median), summary.p95_interval),
            "worst": _or_endless(summary.worst, summary.median),
            "over bound": summary.over_bound,
            "utilisation": summary.utilisation,
            "longest lock": summary.longest_lock_s,
            "air": summary.air,
            "strokes": summary.strokes,
            "NEES (10 – 90 %)": ""
            if summary.nees is None
            else f"{summary.nees:.2g} ({summary.nees_low:.2g} – {summary.nees_high:.2g})",
            "K_wet (10 %)": ""
            if summary.k_wet is None
            else f"{summary.k_wet:.2f}"
            + ("" if summary.k_wet_low is None else f" [{summary.k_wet_low:.2f}, {summary.k_wet_high:.2f}]"),
        }
        for summary in board
    ]
    forms = dict.fromkeys(("worst", "over bound", "air", "strokes"), "{:.3f}")
    return Table(rows, forms | {"stops": share, "utilisation": "{:.2f}", "longest lock": "{:.2f} s"}, ("controller",))


def _written(page: Page, cases: int, is_validation: bool) -> str:
    """Return the leaderboard for the documentation, with the cases and the version it is of."""
    of = "the validation set" if is_validation else "the test set"
    return f"{cases} cases of {of}, railgrip {version('railgrip')}:\n\n{page.values['board'].without(_HIDDEN)}"


def _or_endless(value: float | None, median: float | None) -> float | str | None:
    return "no stop" if value is None and median is not None else value


def _with_interval(value: float | str | None, interval: tuple[float | None, float | None]) -> str:
    """Return a value with its interval in brackets, of which an endless end is no stop."""
    text = "" if value is None else value if isinstance(value, str) else f"{value:.3f}"
    low, high = interval
    if low is None:
        return text
    return f"{text} [{low:.3f}, {'no stop' if high is None else f'{high:.3f}'}]"


def clauses(board: Sequence[Summary], limits: Limits) -> Table:
    """Return the share of cases in which each controller keeps each clause."""
    rows = [
        {
            "clause": getattr(limits, clause).clause,
            "limit": _limit(clause, getattr(limits, clause).limit),
            **{summary.controller: summary.kept[clause] for summary in board},
        }
        for clause in JUDGED
    ]
    return Table(rows, {summary.controller: share for summary in board}, ("clause", "limit"))


_LIMITS: Final[Mapping[str, tuple[str, float, str]]] = {
    "extension": ("≤", 100, "%"),
    "lock": ("≤", 1, "s"),
    "locked_distance": ("≤", 1, "m"),
    "reservoir": ("≥", 1e-5, "bar"),
    "utilisation": ("≥", 100, "%"),
}
"""Clause → sense of its limit, and factor and unit in which it is shown."""


def _limit(clause: str, limit: float | None) -> str:
    if limit is None:
        return "not judged" if clause in _LIMITS else ""
    sense, factor, unit = _LIMITS[clause]
    return f"{sense} {factor * limit:g} {unit}"


def failed_by_bound(board: Sequence[Summary], limits: Limits) -> list[str]:
    """Return a sentence for each clause that the ideal bound does not keep in all cases."""
    return [
        f"“{getattr(limits, clause).clause}” is kept by {summary.description} in {share(kept)} of the cases only. "
        "In the others the rail has too little adhesion for any controller to keep it."
        for summary in board
        if summary.role == "bound"
        for clause in JUDGED
        if (kept := summary.kept[clause]) is not None and kept < 1
    ]


def answer(board: Sequence[Summary], count: int) -> str:
    """Return who stops shortest in the median, beside the ideal bound, and who keeps all clauses most often."""
    ranked = [summary for summary in board if summary.role != "bound" and summary.median is not None]
    if not ranked:
        return f"No controller was compared in {count} cases."
    best = min(ranked, key=lambda summary: summary.median or math.inf)
    over = "" if best.over_bound is None else f" and {best.over_bound:.3f} of the ideal bound"
    kept = "; ".join(
        f"{clause.replace('_', ' ')} {share(value)}" for clause, value in best.kept.items() if value is not None
    )
    return (
        f"Over {count} cases {best.description} stops shortest: its median distance is {best.median:.3f} of that of "
        f"the best tuned baseline{over}. It keeps the clauses in these shares of the cases: {kept}."
    )


def ranking(stops: Sequence[Judged], case: str) -> Table:
    """Return who stopped a case in what distance, shortest first."""
    stops_of_case = [stop for stop in stops if stop.case == case]
    stops_of_case.sort(key=lambda stop: math.inf if stop.distance_m is None else stop.distance_m)
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
        for stop in stops_of_case
    ]
    forms = {
        "distance": "{:.1f} m", "over bound": percent, "extension": percent, "lock": "{:.2f} s", "locked": "{:.1f} m",
        "air": "{:.0f} l", "reservoir": "{:.1f} bar", "tread": "{:.2f} MJ", "utilisation": "{:.2f}",
    }  # fmt: skip
    return Table(rows, forms, ("controller", "fails"))


def worst(stops: Sequence[Judged], controller: str, again: str) -> Table:
    """Return the cases in which a controller is farthest behind the best tuned baseline, and how to run them again."""
    stops_of = [stop for stop in stops if stop.controller == controller]
    stops_of.sort(key=lambda stop: -(stop.over_best or math.inf) if stop.best_m or stop.distance_m is None else 0.0)
    rows = [
        {
            "case": stop.case,
            "distance": stop.outcome if stop.distance_m is None else stop.distance_m,
            "over best": None if stop.over_best is None else stop.over_best - 1,
            **stop.variants,
            "again": f"railgrip study type_test --controller {controller} --case {stop.case}{again}",
        }
        for stop in stops_of[:_WORST]
    ]
    return Table(rows, {"distance": "{:.1f} m", "over best": percent}, ("case", *stops_of[0].variants, "again"))


def _colours(board: Sequence[Summary]) -> dict[str, tuple[str, str]]:
    colours = palette.LINES
    return {
        summary.controller: (colours[n % len(colours)], "-" if n < len(colours) else "--")
        for n, summary in enumerate(board)
    }


def _ratios(stops: Sequence[Judged], board: Sequence[Summary]) -> Figure:
    """Draw for each controller the share of cases that it stops within a multiple of the best tuned baseline."""
    figure = style.figure(8.0, 4.5)
    axes = figure.subplots()
    for name, (colour, dash) in _colours(board).items():
        stops_of = [stop for stop in stops if stop.controller == name and stop.best_m]
        ratios = np.sort([stop.over_best for stop in stops_of if stop.over_best is not None])
        if ratios.size:
            axes.step(
                ratios, (1 + np.arange(ratios.size)) / len(stops_of), dash, where="post", color=colour, label=name
            )
    axes.axvline(1.0, color=palette.GREY, linewidth=0.8)
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
            np.median([
                stop.utilisation for stop in stops
                if (stop.controller, stop.variants["curve"]) == (summary.controller, curve)
                and stop.utilisation is not None
            ] or [np.nan])
            for curve in curves
        ]
        for summary in board
    ]  # fmt: skip
    figure = style.figure(8.0, 1.2 + 0.32 * len(board))
    axes = figure.subplots()
    axes.imshow(values, vmin=0.4, vmax=1.0, cmap="viridis", aspect="auto")
    for row, line in enumerate(values):
        for column, value in enumerate(line):
            if np.isfinite(value):
                colour = "white" if value < 0.7 else "black"
                axes.text(column, row, f"{value:.2f}", ha="center", va="center", fontsize=8, color=colour)
    axes.set_xticks(range(len(curves)), [curve.replace("_", "\n") for curve in curves], fontsize=8)
    axes.set_yticks(range(len(board)), [summary.controller for summary in board], fontsize=8)
    return figure


def _over_friction(stops: Sequence[Judged], board: Sequence[Summary]) -> Figure:
    """Draw distances over the ideal bound against mean friction, and their median over a tenth of the cases."""
    figure = style.figure(8.0, 4.5)
    axes = figure.subplots()
    bounds = {summary.controller for summary in board if summary.role == "bound"}
    for name, (colour, dash) in _colours(board).items():
        points = [(float(s.variants["friction"]), s.over_bound) for s in stops if s.controller == name and s.over_bound]
        if points and name not in bounds:
            friction, ratios = zip(*sorted(points), strict=True)
            axes.plot(friction, ratios, "o" if dash == "-" else "x", color=colour, markersize=2.5, alpha=0.25)
            median = median_filter(ratios, size=1 + len(points) // 10, mode="nearest")
            axes.plot(friction, median, dash, color=colour, label=name)
    axes.set_xscale("log")
    axes.set_xticks([0.02, 0.03, 0.05, 0.08, 0.15], ["0.02", "0.03", "0.05", "0.08", "0.15"])
    axes.set_xticks([], minor=True)
    axes.set_ylim(0.95, 2.5)
    style.dress(axes, x="mean of the maximum friction", y="distance over the ideal bound")
    if axes.lines:
        axes.legend(fontsize=7, loc="upper right")
    return figure
