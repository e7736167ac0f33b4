"""The tables of the lateral study: medians over seeds with intervals, as tables and CSV."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np
from scipy.stats import binom

from railgrip.report import statistics
from railgrip.report.table import ReportTable, share
from railgrip.studies.lateral.judge import QUANTITIES, SPIKE, adhesion, beliefs_about
from railgrip.studies.lateral.run import NAMES, LateralCase, Trace
from railgrip.studies.lateral.wheelset import CONDITIONS, PLANTS, ROLLING
from railgrip.studies.papers.pages import PaperRow, comparison

FIGURES: Final = {"rmse": "RMSE", "bias": "bias", "nees": "NEES", "settling": "settling [s]", "peak": "peak error"}
LEVEL_TOLERANCE: Final = 0.05
"""Half of the distance between the two lowest levels; with a larger error the condition cannot be identified."""
PUBLISHED: Final = ("lateral_velocity", "yaw_rate", "creep", "creep_force")
"""Quantities of the paper's figures; on one surface friction is constant, so its size does not scale its error."""
TITLES: Final = {
    "reconstruction": "reconstruction",
    "known_track": "well posed, track known",
    "unknown_track": "well posed, track unknown",
    "known_track_stiffness": "stiffness estimated, track known",
    "unknown_track_stiffness": "stiffness estimated, track unknown",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class LateralResult:
    """Case of one run, and its measures by `judge.measure`."""

    case: LateralCase
    measures: dict[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class MedianInterval:
    """Median of a figure over the seeds, with an interval that contains the true median with 95 %, if seeds suffice.

    The interval is between order statistics, so it is valid for any distribution, including diverged runs (infinity).
    """

    median: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{_digits(self.median)} [{_digits(self.low)}, {_digits(self.high)}]"


def median_interval(values: Iterable[float | None]) -> MedianInterval:
    """Return median and interval of values, one for each seed; None (not finite, never settled) counts as infinity.

    With fewer than six seeds the interval is their range.
    """
    found = sorted(math.inf if value is None else value for value in values)
    low, high = statistics.median_interval(found) or (found[0], found[-1])
    return MedianInterval(median=(found[(len(found) - 1) // 2] + found[len(found) // 2]) / 2, low=low, high=high)


def confidence_of(seeds: int) -> float:
    """Return the probability with which the interval of that number of seeds contains the median."""
    rank = max(int(binom.ppf(0.025, seeds, 0.5)) - 1, 0)
    return float(1 - 2 * binom.cdf(rank, seeds, 0.5))


def _digits(value: float) -> str:
    return "∞" if math.isinf(value) else f"{value:.2g}"


def groups(results: Sequence[LateralResult]) -> dict[tuple[str, float, str], list[LateralResult]]:
    """Return the results of all seeds by (plant, speed, test)."""
    by_case: dict[tuple[str, float, str], list[LateralResult]] = {}
    for result in results:
        case = result.case
        by_case.setdefault((case.plant, case.speed, case.test.name), []).append(result)
    return by_case


def typical(results: Sequence[LateralResult], plant: str, speed: float, test: str) -> LateralResult:
    """Return the run whose RMSE of the creep force by the reconstruction is the median over the seeds.

    With an even number of seeds it is the lower of the two middle ones; a filter that diverged has an infinite error.
    """
    runs = sorted(groups(results)[plant, speed, test], key=_force_error)
    return runs[(len(runs) - 1) // 2]


def _force_error(result: LateralResult) -> float:
    error = result.measures["errors"]["reconstruction"]["creep_force"]["rmse"]
    return math.inf if error is None else error


def typical_table(runs: Sequence[LateralResult]) -> ReportTable:
    """Return test, seed and RMSE of the creep force of each run of `typical`."""
    columns = ("test", "seed", "RMSE of the creep force, reconstruction [N]")
    return ReportTable.of(columns, [(r.case.test.name, str(r.case.seed), _digits(_force_error(r))) for r in runs], str)


def spikes(runs: Sequence[LateralResult]) -> ReportTable:
    """Return the largest error of the creep force of each filter before and after the first change of the surface.

    Args:
        runs: All seeds of one test with changes of the surface.
    """
    columns = ("filter", f"largest error in {SPIKE:g} s before [N]", f"largest error in {SPIKE:g} s after [N]")
    pairs = {name: [run.measures["spike"][name] for run in runs] for name in NAMES}
    rows = [(TITLES[name], *(median_interval(pair[k] for pair in pairs[name]) for k in (0, 1))) for name in NAMES]
    return ReportTable.of(columns, rows, str)


def longitudinal(results: Sequence[LateralResult], speed: float) -> ReportTable:
    """Return errors relative to the rms of the true values with and without motor torque, medians over the seeds."""
    rows: list[dict[str, Any]] = []
    for (plant, of_speed, _), runs in groups(results).items():
        for name in NAMES if plant in ROLLING and of_speed == speed else ():
            creep = median_interval(run.measures["size"]["creep"] for run in runs).median
            lost = sum(run.measures["lost"][name] is not None for run in runs)
            row = {"plant": PLANTS[plant].title, "rms creep": f"{100 * creep:.2g} %", "filter": TITLES[name]}
            for quantity in ("lateral_velocity", "creep", "creep_force", "friction"):
                errors = ((run.measures["errors"][name][quantity]["rmse"], run.measures["size"]) for run in runs)
                shares = (None if error is None else error / size[quantity] for error, size in errors)
                row[f"{quantity.replace('_', ' ')}"] = _digits(median_interval(shares).median)
            rows.append({**row, "lost, of runs": f"{lost} of {len(runs)}"})
    return ReportTable(rows, left=("plant", "filter"))


def error_rows(results: Sequence[LateralResult]) -> list[dict[str, Any]]:
    """Return one row for each plant, speed, test, filter and quantity, with a `MedianInterval` for each figure."""
    return [
        {
            "plant": plant,
            "speed": speed,
            "test": test,
            "filter": name,
            "quantity": quantity,
            "unit": unit,
            "seeds": len(runs),
            **{f: median_interval(run.measures["errors"][name][quantity][f] for run in runs) for f in FIGURES},
        }
        for (plant, speed, test), runs in groups(results).items()
        for name in NAMES
        for quantity, unit in QUANTITIES.items()
    ]


def flat(rows: Sequence[Mapping[str, Any]]) -> ReportTable:
    """Return error rows with median, low and high in separate columns."""
    return ReportTable(
        [
            {
                key: value
                for name, cell in row.items()
                for key, value in (
                    ((name, cell.median), (f"{name}_low", cell.low), (f"{name}_high", cell.high))
                    if isinstance(cell, MedianInterval)
                    else ((name, cell),)
                )
            }
            for row in rows
        ]
    )


def error_tables(rows: Sequence[Mapping[str, Any]]) -> dict[str, ReportTable]:
    """Return plant and speed → table of every test, quantity and filter."""
    tables: dict[str, list[tuple[Any, ...]]] = {}
    for row in rows:
        unit = "" if row["unit"] == "1" else f" [{row['unit']}]"
        what = f"{row['quantity'].replace('_', ' ')}{unit}"
        tables.setdefault(f"{row['speed']:g} m/s, {PLANTS[row['plant']].title}", []).append(
            (row["test"], what, TITLES[row["filter"]], *(row[figure] for figure in FIGURES))
        )
    columns = ("test", "quantity", "filter", *FIGURES.values())
    return {title: ReportTable.of(columns, table, str, left=3) for title, table in tables.items()}


def compare_with_paper(trace: Trace) -> ReportTable:
    """Return the statements of the paper about its figures next to a run of the transition; see `comparison`.

    Args:
        trace: Run with all three filters.
    """
    creep = np.geomspace(1e-5, 0.1, 400)
    error = np.abs(beliefs_about(trace, "reconstruction")["creep_force"].mean - trace.truth["creep_force"])
    instant = float(trace.time[np.nanargmax(error)])
    changes = f"{', '.join(f'{at:g}' for at in trace.changes[1:])} s"
    rails = ", ".join(rail.name for rail in CONDITIONS)
    peaks = [float(adhesion(rail, creep, trace.case.speed).max()) for rail in CONDITIONS]
    rows = [
        PaperRow("Table 3", f"friction u0 at zero creep velocity: {rails}", "0.46, 0.3, 0.2, 0.1",
                 ", ".join(f"{rail.mu0:g}" for rail in CONDITIONS), is_chosen=True),
        PaperRow("Fig. 2", f"largest adhesion at {trace.case.speed:g} m/s: {rails}", "not given",
                 ", ".join(f"{peak:.3f}" for peak in peaks)),
        PaperRow("Fig. 4 to 23", "largest deviation of the track", 7.0, 1e3 * float(np.abs(trace.track).max()),
                 "{:.1f} mm", is_chosen=True),
        PaperRow("Fig. 20 to 23", "changes of the surface", "2, 4, 6 and 8 s", changes, is_chosen=True),
        PaperRow("Fig. 23", "largest error of the creep force, reconstruction", 2.0, instant, "at {:.1f} s",
                 f"{instant - 2.0:+.1f} s".replace("-", "−")),
    ]  # fmt: skip
    return comparison(rows)


def skill(results: Sequence[LateralResult], speed: float) -> ReportTable:
    """Return RMSE over that of the best constant, medians over seeds, by test, quantity and filter.

    Args:
        speed: Speed of the runs [m/s], on the plant that the filters know.
    """
    rows: list[dict[str, Any]] = []
    for (plant, of_speed, test), runs in groups(results).items():
        if plant != "paper" or of_speed != speed:
            continue
        for quantity in PUBLISHED:
            row: dict[str, Any] = {"test": test, "quantity": quantity.replace("_", " ")}
            for name in NAMES:
                errors = ((run.measures["errors"][name][quantity]["rmse"], run.measures["constant"]) for run in runs)
                shares = [None if error is None else error / constant[quantity] for error, constant in errors]
                row[TITLES[name]] = _digits(median_interval(shares).median)
            rows.append(row)
    return ReportTable(rows, left=("test", "quantity"))


def friction_errors(results: Sequence[LateralResult], speed: float) -> ReportTable:
    """Return rms errors of mu0 by condition in runs of several, medians over seeds, by plant and filter."""
    rows: list[dict[str, Any]] = []
    for (plant, of_speed, _), runs in groups(results).items():
        for name in NAMES if of_speed == speed and len(runs[0].case.test.changes) > 1 else ():
            if name in runs[0].measures["levels"]:
                row = {"plant": PLANTS[plant].title, "filter": TITLES[name]}
                for rail in CONDITIONS:
                    errors = [run.measures["levels"][name].get(rail.name, (None, None))[1] for run in runs]
                    row[f"{rail.name} {rail.mu0:g}"] = _digits(median_interval(errors).median)
                rows.append(row)
    return ReportTable(rows, left=("plant", "filter"))


def innovation_table(results: Sequence[LateralResult]) -> ReportTable:
    """Return the number of runs in which each filter was lost, its NIS, and its friction against the best constant."""
    rows: list[dict[str, Any]] = []
    for (plant, speed, test), runs in groups(results).items():
        for name in NAMES:
            instants = [instant for run in runs if (instant := run.measures["lost"][name]) is not None]
            rows.append(
                {
                    "plant": PLANTS[plant].title,
                    "speed [m/s]": speed,
                    "test": test,
                    "filter": TITLES[name],
                    "lost, of runs": f"{len(instants)} of {len(runs)}",
                    "first [s]": f"{min(instants):.2g}" if instants else "–",
                    "NIS": median_interval(run.measures["nis"][name] for run in runs),
                    "friction RMSE": median_interval(run.measures["errors"][name]["friction"]["rmse"] for run in runs),
                    "of the best constant": median_interval(run.measures["constant"]["friction"] for run in runs),
                }
            )
    return ReportTable(
        rows, {"speed [m/s]": "{:g}", **dict.fromkeys(list(rows[0])[6:], str)}, ("plant", "test", "filter")
    )


def observability_table(results: Sequence[LateralResult]) -> ReportTable:
    """Return the standard deviation of mu0 given windows of readings, by speed and condition."""
    ranks: dict[tuple[float, int], list[tuple[float, float]]] = {}
    for result in results:
        windows = result.measures["observability"]
        if windows is not None:
            for number, *deviations in zip(windows["condition"], windows["paper"], windows["service"], strict=True):
                paper, service = (math.inf if deviation is None else deviation for deviation in deviations)
                ranks.setdefault((result.case.speed, number), []).append((paper, service))
    rows: list[dict[str, Any]] = []
    for (speed, number), pairs in sorted(ranks.items()):
        paper, service = np.array(pairs).T
        low, high = np.quantile(service, (0.1, 0.9), method="nearest")
        rows.append(
            {
                "speed [m/s]": speed,
                "condition": CONDITIONS[number].name,
                "windows": len(pairs),
                "σ(μ0), paper's sensors": f"{np.median(paper):.1e}",
                "σ(μ0), service sensors: median [10 %, 90 %]": f"{np.median(service):.2g} [{low:.2g}, {high:.2g}]",
                "σ < 0.02": f"{100 * np.mean(service < 0.02):.0f} %",
                "σ < 0.05": f"{100 * np.mean(service < 0.05):.0f} %",
            }
        )
    return ReportTable(rows, {"speed [m/s]": "{:g}"}, ("condition",))


def detections(results: Sequence[LateralResult]) -> list[tuple[str, ReportTable, ReportTable]]:
    """Return filter and plant, confusion matrix of the condition detector in shares of time, and its delays."""
    tables: list[tuple[str, ReportTable, ReportTable]] = []
    for plant, variant in PLANTS.items():
        runs = [result for result in results if result.case.plant == plant]
        for name in [name for name in NAMES if runs and name in runs[0].measures["detection"]]:
            counts = np.sum([run.measures["detection"][name]["confusion"] for run in runs], axis=0)
            shares = [
                (condition.name, *(row / max(row.sum(), 1))) for condition, row in zip(CONDITIONS, counts, strict=True)
            ]
            confusion = ReportTable.of(("true", *(c.name for c in CONDITIONS), "undecided"), shares, share)
            tables.append((f"{TITLES[name]}, {variant.title}", confusion, _delays(runs, name)))
    return tables


def levels(results: Sequence[LateralResult]) -> list[tuple[str, ReportTable, str]]:
    """Return filter and plant, the estimates of mu0 in runs of several conditions, and a sentence about them."""
    tables: list[tuple[str, ReportTable, str]] = []
    for plant, variant in PLANTS.items():
        several = [run for run in results if run.case.plant == plant and len(run.case.test.changes) > 1]
        speeds = sorted({run.case.speed for run in several})
        runs = [run for run in several if run.case.speed == speeds[len(speeds) // 2]]
        for name in [name for name in NAMES if runs and name in runs[0].measures["levels"]]:
            tables.append((f"{TITLES[name]}, {variant.title}", *_level([run.measures["levels"][name] for run in runs])))
    return tables


def _level(runs: Sequence[dict[str, tuple[float | None, float | None]]]) -> tuple[ReportTable, str]:
    conditions = [condition for condition in CONDITIONS if condition.name in runs[0]]
    spreads = {c: [median_interval(run[c.name][k] for run in runs) for k in (0, 1)] for c in conditions}
    columns = ("condition", "true μ0", "estimated: median [interval]", "rms error")
    table = ReportTable.of(columns, [(c.name, f"{c.mu0:g}", *spreads[c]) for c in conditions], str)
    right = [c.name for c in conditions if spreads[c][1].median < LEVEL_TOLERANCE]
    far = [
        f"takes {c.name}, {c.mu0:g}, for {_digits(mean.median)}" if mean.median <= 1 else f"is lost in {c.name}"
        for c, (mean, error) in spreads.items()
        if error.median >= LEVEL_TOLERANCE
    ]
    within = f"Tells μ0 within {LEVEL_TOLERANCE:g} rms in {', '.join(right) or 'no condition'}"
    return table, f"{'; '.join((within, *far))}."


def _delays(runs: Sequence[LateralResult], name: str) -> ReportTable:
    changes: dict[str, list[float | None]] = {}
    for run in runs:
        conditions = ["start", *(condition.name for _, condition in run.case.test.changes)]
        for (before, after), delay in zip(pairwise(conditions), run.measures["detection"][name]["delays"], strict=True):
            changes.setdefault(f"{before} → {after}", []).append(delay)
    rows: list[dict[str, Any]] = []
    for change, delays in changes.items():
        finite = [delay for delay in delays if delay is not None]
        rows.append(
            {
                "change": change,
                "number": len(delays),
                "detected": len(finite),
                "delay: median [interval] s": str(median_interval(delays)),
                "longest detected [s]": _digits(max(finite, default=math.inf)),
            }
        )
    return ReportTable(rows, left=("change",))
