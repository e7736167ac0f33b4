"""The tables of the lateral study: medians over seeds with intervals, as tables and CSV."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from operator import attrgetter
from typing import Any, Final

import numpy as np
import pandas
from scipy.stats import binom

from railgrip.report import statistics
from railgrip.report.frame import Frame, groups_of
from railgrip.report.table import ReportTable, share
from railgrip.studies.lateral.judge import QUANTITIES, SPIKE, adhesion, beliefs_about
from railgrip.studies.lateral.run import NAMES, LateralCase, Trace
from railgrip.studies.lateral.wheelset import CONDITIONS, PLANTS, ROLLING, Condition
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
GROUP: Final = ("plant", "speed", "test")
"""Columns that are equal for all seeds of a group of runs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MedianInterval:
    """Median of a figure over the seeds, with an interval that contains the true median with 95 %, if seeds suffice.

    The interval is between order statistics, so it is valid for any distribution, including diverged runs (infinity).
    """

    median: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{digits(self.median)} [{digits(self.low)}, {digits(self.high)}]"


def frame_of(runs: Iterable[tuple[LateralCase, Mapping[str, Any]]]) -> Frame:
    """Return a row for each run: `plant`, `speed` [m/s], `test`, `seed`, `case`, and its measures by `judge.measure`.

    Nested names of measures are joined by a dot, as in `errors.known_track.friction.rmse`; figures without a value are
    NaN.
    """
    return pandas.json_normalize(
        [
            {"plant": case.plant, "speed": case.speed, "test": case.test.name, "seed": case.seed, "case": case}
            | dict(measures)
            for case, measures in runs
        ]
    )


def median_interval(values: Iterable[float]) -> MedianInterval:
    """Return median and interval of values, one for each seed; NaN (not finite, never settled) counts as infinity.

    With fewer than six seeds the interval is their range.
    """
    found = sorted(math.inf if math.isnan(value) else value for value in values)
    low, high = statistics.median_interval(found) or (found[0], found[-1])
    return MedianInterval(median=(found[(len(found) - 1) // 2] + found[len(found) // 2]) / 2, low=low, high=high)


def confidence_of(seeds: int) -> float:
    """Return the probability with which the interval of that number of seeds contains the median."""
    rank = max(int(binom.ppf(0.025, seeds, 0.5)) - 1, 0)
    return float(1 - 2 * binom.cdf(rank, seeds, 0.5))


def digits(value: float) -> str:
    """Return a number of two digits, ∞ for infinity."""
    return "∞" if math.isinf(value) else f"{value:.2g}"


def _median(values: Iterable[float]) -> str:
    return digits(median_interval(values).median)


_FORCE_ERROR: Final = "errors.reconstruction.creep_force.rmse"


def typical(runs: Frame) -> Any:
    """Return the run of a group whose RMSE of the creep force by the reconstruction is the median over the seeds.

    With an even number of seeds it is the lower of the two middle ones; a filter that diverged has an infinite error.
    """
    ranked = runs.sort_values(_FORCE_ERROR, kind="stable")
    return ranked.iloc[(len(ranked) - 1) // 2]


def typical_table(runs: Sequence[Any]) -> ReportTable:
    """Return test, seed and RMSE of the creep force of each run of `typical`."""
    columns = ("test", "seed", "RMSE of the creep force, reconstruction [N]")
    return ReportTable.of(columns, [(run.test, str(run.seed), _median([run[_FORCE_ERROR]])) for run in runs], str)


def spikes(runs: Frame) -> ReportTable:
    """Return the largest error of the creep force of each filter before and after the first change of the surface.

    Args:
        runs: All seeds of one test with changes of the surface.
    """
    columns = ("filter", f"largest error in {SPIKE:g} s before [N]", f"largest error in {SPIKE:g} s after [N]")
    pairs = {name: np.array(runs[f"spike.{name}"].tolist(), dtype=np.float64) for name in NAMES}
    return ReportTable.of(columns, [(TITLES[name], *map(median_interval, pairs[name].T)) for name in NAMES], str)


def longitudinal(frame: Frame, speed: float) -> ReportTable:
    """Return errors relative to the rms of the true values with and without motor torque, medians over the seeds."""
    rows: list[dict[str, Any]] = []
    for (plant, *_), runs in groups_of(frame[frame["plant"].isin(ROLLING) & (frame["speed"] == speed)], GROUP):
        creep = median_interval(runs["size.creep"]).median
        for name in NAMES:
            shares = {
                quantity.replace("_", " "): _median(runs[f"errors.{name}.{quantity}.rmse"] / runs[f"size.{quantity}"])
                for quantity in ("lateral_velocity", "creep", "creep_force", "friction")
            }
            about = {"plant": PLANTS[plant].title, "rms creep": f"{100 * creep:.2g} %", "filter": TITLES[name]}
            rows.append(about | shares | {"lost, of runs": f"{runs[f'lost.{name}'].count()} of {len(runs)}"})
    return ReportTable(rows, left=("plant", "filter"))


def error_rows(frame: Frame) -> Frame:
    """Return a row for each plant, speed, test, filter and quantity, with a `MedianInterval` for each figure."""
    return pandas.DataFrame(
        {"plant": plant, "speed": speed, "test": test, "filter": name, "quantity": quantity, "unit": unit}
        | {"seeds": len(runs)}
        | {figure: median_interval(runs[f"errors.{name}.{quantity}.{figure}"]) for figure in FIGURES}
        for (plant, speed, test), runs in groups_of(frame, GROUP)
        for name in NAMES
        for quantity, unit in QUANTITIES.items()
    )


def flat(errors: Frame) -> ReportTable:
    """Return `error_rows` with median, low and high in separate columns."""
    table = errors.drop(columns=list(FIGURES))
    for figure in FIGURES:
        for end, attribute in (("", "median"), ("_low", "low"), ("_high", "high")):
            table[f"{figure}{end}"] = errors[figure].map(attrgetter(attribute))
    return ReportTable(table.to_dict("records"))


def error_tables(errors: Frame) -> dict[str, ReportTable]:
    """Return plant and speed → table of every test, quantity and filter."""
    units = errors["unit"].map(lambda unit: "" if unit == "1" else f" [{unit}]")
    errors = errors.rename(columns=FIGURES).assign(
        quantity=errors["quantity"].str.replace("_", " ") + units, filter=errors["filter"].map(TITLES)
    )
    columns = ["test", "quantity", "filter", *FIGURES.values()]
    return {
        f"{speed:g} m/s, {PLANTS[plant].title}": ReportTable(
            rows[columns].to_dict("records"), dict.fromkeys(columns, str), columns[:3]
        )
        for (speed, plant), rows in groups_of(errors, ("speed", "plant"))
    }


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


def skill(frame: Frame, speed: float) -> ReportTable:
    """Return RMSE over that of the best constant, medians over seeds, by test, quantity and filter.

    Args:
        frame: Runs; see `frame_of`.
        speed: Speed of the runs [m/s], on the plant that the filters know.
    """
    part = frame[(frame["plant"] == "paper") & (frame["speed"] == speed)]
    rows = [
        {"test": test, "quantity": quantity.replace("_", " ")}
        | {
            TITLES[name]: _median(runs[f"errors.{name}.{quantity}.rmse"] / runs[f"constant.{quantity}"])
            for name in NAMES
        }
        for (test,), runs in groups_of(part, ["test"])
        for quantity in PUBLISHED
    ]
    return ReportTable(rows, left=("test", "quantity"))


def _with_changes(frame: Frame) -> Frame:
    return frame[[len(case.test.changes) > 1 for case in frame["case"]]]


def _level(runs: Frame, name: str, rail: Condition, place: int) -> list[float]:
    """Return mean (0) or rms error (1) of the estimated friction of a rail in each run; NaN without a finite one."""
    levels = f"levels.{name}.{rail.name}"
    pairs = runs[levels] if levels in runs else [math.nan] * len(runs)
    return [math.nan if isinstance(pair, float) or pair[place] is None else pair[place] for pair in pairs]


def _estimating(frame: Frame, measure: str) -> list[str]:
    """Return the filters that have a measure of `judge.measure`."""
    return [name for name in NAMES if any(column.startswith(f"{measure}.{name}.") for column in frame)]


def friction_errors(frame: Frame, speed: float) -> ReportTable:
    """Return rms errors of mu0 by condition in runs of several, medians over seeds, by plant and filter."""
    rows = [
        {"plant": PLANTS[plant].title, "filter": TITLES[name]}
        | {f"{rail.name} {rail.mu0:g}": _median(_level(runs, name, rail, 1)) for rail in CONDITIONS}
        for (plant, *_), runs in groups_of(_with_changes(frame[frame["speed"] == speed]), GROUP)
        for name in _estimating(frame, "levels")
    ]
    return ReportTable(rows, left=("plant", "filter"))


def innovation_table(frame: Frame) -> ReportTable:
    """Return the number of runs in which each filter was lost, its NIS, and its friction against the best constant."""
    rows: list[dict[str, Any]] = []
    for (plant, speed, test), runs in groups_of(frame, GROUP):
        for name in NAMES:
            lost = runs[f"lost.{name}"]
            rows.append(
                {
                    "plant": PLANTS[plant].title,
                    "speed [m/s]": speed,
                    "test": test,
                    "filter": TITLES[name],
                    "lost, of runs": f"{lost.count()} of {len(runs)}",
                    "first [s]": f"{lost.min():.2g}" if lost.count() else "–",
                    "NIS": median_interval(runs[f"nis.{name}"]),
                    "friction RMSE": median_interval(runs[f"errors.{name}.friction.rmse"]),
                    "of the best constant": median_interval(runs["constant.friction"]),
                }
            )
    return ReportTable(
        rows, {"speed [m/s]": "{:g}", **dict.fromkeys(list(rows[0])[6:], str)}, ("plant", "test", "filter")
    )


def observability_table(frame: Frame) -> ReportTable:
    """Return the standard deviation of mu0 given windows of readings, by speed and condition."""
    columns = ["condition", "paper", "service"]
    runs = frame.dropna(subset="observability.condition").rename(columns=lambda name: name.split("observability.")[-1])
    windows = runs[["speed", *columns]].explode(columns)
    rows: list[dict[str, Any]] = []
    for (speed, number), part in windows.groupby(["speed", "condition"]):
        paper, service = (part[name].astype(float).fillna(math.inf).to_numpy() for name in ("paper", "service"))
        low, high = np.quantile(service, (0.1, 0.9), method="nearest")
        rows.append(
            {
                "speed [m/s]": speed,
                "condition": CONDITIONS[number].name,
                "windows": len(part),
                "σ(μ0), paper's sensors": f"{np.median(paper):.1e}",
                "σ(μ0), service sensors: median [10 %, 90 %]": f"{np.median(service):.2g} [{low:.2g}, {high:.2g}]",
                "σ < 0.02": f"{100 * np.mean(service < 0.02):.0f} %",
                "σ < 0.05": f"{100 * np.mean(service < 0.05):.0f} %",
            }
        )
    return ReportTable(rows, {"speed [m/s]": "{:g}"}, ("condition",))


def detections(frame: Frame) -> list[tuple[str, ReportTable, ReportTable]]:
    """Return filter and plant, confusion matrix of the condition detector in shares of time, and its delays."""
    tables: list[tuple[str, ReportTable, ReportTable]] = []
    for plant, variant in PLANTS.items():
        runs = frame[frame["plant"] == plant]
        for name in _estimating(frame, "detection") if len(runs) else ():
            counts = np.sum(runs[f"detection.{name}.confusion"].tolist(), axis=0)
            shares = [
                (condition.name, *(row / max(row.sum(), 1))) for condition, row in zip(CONDITIONS, counts, strict=True)
            ]
            confusion = ReportTable.of(("true", *(c.name for c in CONDITIONS), "undecided"), shares, share)
            tables.append((f"{TITLES[name]}, {variant.title}", confusion, _delays(runs, name)))
    return tables


def levels(frame: Frame) -> list[tuple[str, ReportTable, str]]:
    """Return filter and plant, the estimates of mu0 in runs of several conditions, and a sentence about them."""
    tables: list[tuple[str, ReportTable, str]] = []
    for plant, variant in PLANTS.items():
        several = _with_changes(frame[frame["plant"] == plant])
        speeds = sorted(several["speed"].unique())
        runs = several[several["speed"] == speeds[len(speeds) // 2]] if speeds else several
        tables += [
            (f"{TITLES[name]}, {variant.title}", *_levels(runs, name))
            for name in _estimating(frame, "levels")
            if speeds
        ]
    return tables


def _levels(runs: Frame, name: str) -> tuple[ReportTable, str]:
    conditions = [rail for rail in CONDITIONS if f"levels.{name}.{rail.name}" in runs]
    spreads = {rail: [median_interval(_level(runs, name, rail, k)) for k in (0, 1)] for rail in conditions}
    columns = ("condition", "true μ0", "estimated: median [interval]", "rms error")
    table = ReportTable.of(columns, [(c.name, f"{c.mu0:g}", *spreads[c]) for c in conditions], str)
    right = [c.name for c in conditions if spreads[c][1].median < LEVEL_TOLERANCE]
    far = [
        f"takes {c.name}, {c.mu0:g}, for {digits(mean.median)}" if mean.median <= 1 else f"is lost in {c.name}"
        for c, (mean, error) in spreads.items()
        if error.median >= LEVEL_TOLERANCE
    ]
    within = f"Tells μ0 within {LEVEL_TOLERANCE:g} rms in {', '.join(right) or 'no condition'}"
    return table, f"{'; '.join((within, *far))}."


def _delays(runs: Frame, name: str) -> ReportTable:
    changes: dict[str, list[float]] = {}
    for case, delays in zip(runs["case"], runs[f"detection.{name}.delays"], strict=True):
        conditions = ["start", *(condition.name for _, condition in case.test.changes)]
        for (before, after), delay in zip(pairwise(conditions), delays, strict=True):
            changes.setdefault(f"{before} → {after}", []).append(math.nan if delay is None else delay)
    rows = [
        {
            "change": change,
            "number": len(delays),
            "detected": int(np.isfinite(delays).sum()),
            "delay: median [interval] s": str(median_interval(delays)),
            "longest detected [s]": digits(float(np.fmax.reduce(delays)) if np.isfinite(delays).any() else math.inf),
        }
        for change, delays in changes.items()
    ]
    return ReportTable(rows, left=("change",))
