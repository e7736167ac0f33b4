"""Tables of the lateral study, medians over seeds with intervals, and figures 2 and 4 to 23 of Mal et al. (2020)."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from operator import attrgetter
from typing import Any, Final

import numpy as np
import pandas
from matplotlib.figure import Figure
from scipy.stats import binom

from railgrip.report import palette, statistics, style
from railgrip.report.frame import Frame, groups_of
from railgrip.report.table import ReportTable, share
from railgrip.studies.lateral.judge import QUANTITIES, SPIKE, adhesion, beliefs_about
from railgrip.studies.lateral.run import NAMES, LateralCase, Trace, simulate
from railgrip.studies.lateral.wheelset import CONDITIONS, PLANTS, ROLLING, TESTS, Condition
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
    frame = pandas.json_normalize(
        [
            {"plant": case.plant, "speed": case.speed, "test": case.test.name, "seed": case.seed, "case": case}
            | dict(measures)
            for case, measures in runs
        ]
    )
    return frame.where(frame.notna(), math.nan)  # a column without any number would keep None


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
    return frame[frame["case"].map(lambda case: len(case.test.changes) > 1).astype(bool)]


def _level(runs: Frame, name: str, rail: Condition, place: int) -> list[float]:
    """Return mean (0) or rms error (1) of the estimated friction of a rail in each run; NaN without a finite one."""
    levels = f"levels.{name}.{rail.name}"
    pairs: list[Any] = list(runs[levels]) if levels in runs else [math.nan] * len(runs)
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
    if "observability.condition" not in frame:  # no run on the plant of the paper
        return ReportTable([])
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


FIRST_FIGURES: Final[Mapping[str, int]] = {test.name: 4 + 4 * number for number, test in enumerate(TESTS)}
"""Number of the first of the paper's four figures of each test."""
COLOURS: Final = {"reconstruction": palette.VERMILION, "known_track": palette.BLUE, "unknown_track": palette.SKY}
LABELS: Final = {
    "lateral_velocity": "lateral\nvelocity [m/s]",
    "yaw_rate": "yaw rate\n[rad/s]",
    "creep": "creep",
    "creep_force": "creep force\n[N]",
    "friction": "friction",
}
THINNING: Final = 10
"""Recorded instants from one drawn point to the next: 10 ms, for motions of 2 Hz."""
WINDOW: Final = 100
"""Recorded instants in each rms error: 0.1 s."""


def creep_curves(speed: float) -> Figure:
    """Return adhesion over creep of each condition at a speed [m/s], with the published friction at zero creep."""
    drawing, panel = style.panels(7, 3.4)
    creep = np.geomspace(1e-5, 0.1, 120)
    lines = ("-", "--", "-.", ":")
    for condition, colour, line in zip(CONDITIONS, palette.lead_to_trail(len(CONDITIONS)), lines, strict=True):
        panel.plot(100 * creep, adhesion(condition, creep, speed), color=colour, linestyle=line, label=condition.name)
        panel.plot(0.0, condition.mu0, "D", color=palette.BLACK, markersize=5, markerfacecolor="none", clip_on=False,
                   label="published u₀" if condition is CONDITIONS[-1] else None)  # fmt: skip
    style.dress(panel, x="creep [%]", y="adhesion coefficient", title=f"Fig. 2, at {speed:g} m/s")
    panel.set_xlim(0, 10)
    panel.set_ylim(0, 0.5)
    style.legend(panel, loc="upper right", ncols=2)
    return drawing


def test_figure(case: LateralCase) -> Figure:
    """Run a case; draw estimates, errors as the paper draws them, and rms errors, a row for each quantity."""
    trace = simulate(case)
    drawing, panels = style.panels(11, 1.35 * len(QUANTITIES) + 0.4, len(QUANTITIES), 3, sharex=True)
    beliefs = {name: beliefs_about(trace, name) for name in NAMES}
    time = trace.time[::THINNING]
    windows = len(trace.time) // WINDOW * WINDOW
    middles = trace.time[:windows].reshape(-1, WINDOW).mean(axis=1)
    first = FIRST_FIGURES.get(case.test.name) if case.plant == "paper" else None
    for row, ((left, middle, right), quantity) in enumerate(zip(panels, QUANTITIES, strict=True)):
        truth = trace.truth[quantity]
        size = float(np.max(np.abs(truth)))
        largest = 0.0
        for name in NAMES:
            error = beliefs[name][quantity].mean - truth
            left.plot(time, (truth + error)[::THINNING], color=COLOURS[name], linewidth=1.2, label=TITLES[name])
            middle.plot(trace.time, error, color=COLOURS[name], linewidth=0.8)
            # Errors of filters that are lost are cut off.
            largest = max(largest, min(float(np.nanmax(np.abs(error))), 1.5 * size))
            squares = error[:windows].reshape(-1, WINDOW) ** 2
            right.plot(middles, np.sqrt(squares.mean(axis=1)), color=COLOURS[name], linewidth=1.0)
        middle.set_ylim(-1.05 * largest, 1.05 * largest)
        left.plot(time, truth[::THINNING], color=palette.BLACK, linewidth=0.5, label="true")
        # A curve outside of the panel has an error of more than half of the largest true value.
        bottom = -1.5 * size if np.min(truth) < 0 else -0.1 * size
        left.set_ylim(bottom, 1.5 * size)
        # The friction coefficient, which the paper estimates too, is in none of its figures.
        number = f"Fig. {first + row}" if first is not None and quantity != "friction" else ""
        style.dress(left, y=LABELS[quantity], title=number)
        right.set_yscale("log")
        right.set_ylim(1e-6 * size, 1e1 * size)
        unit = LABELS[quantity].partition("[")[2]
        for axes, what in ((middle, "error"), (right, "rms error over 0.1 s")):
            style.dress(axes, y=f"error [{unit}" if unit else "error", title=number and f"{number}, {what}")
        for axes in (left, middle, right):
            for change in trace.changes[1:]:
                axes.axvline(change, color=palette.GREY, linewidth=0.8, linestyle=":")
    for axes in panels[-1]:
        axes.set_xlabel("time [s]")
        axes.set_xlim(0, trace.time[-1])
    drawing.legend(*panels[0, 0].get_legend_handles_labels(), ncols=4, fontsize=8, frameon=False,
                   loc="outside lower center")  # fmt: skip
    drawing.suptitle(
        f"{case.test.name} at {case.speed:g} m/s, {PLANTS[case.plant].title}, seed {case.seed}",
        fontsize=10,
        x=0.02,
        ha="left",
    )
    return drawing


def spike_figure(trace: Trace) -> Figure:
    """Draw creep force and its error around the first change of the surface of a run."""
    drawing, (left, right) = style.panels(8, 2.8, 1, 2)
    change = trace.changes[1]
    part = (trace.time > change - 0.2) & (trace.time <= change + 0.5)
    time, truth = trace.time[part], 1e-3 * trace.truth["creep_force"][part]
    size, largest = float(np.max(truth)), 0.0
    for name in NAMES:
        force = 1e-3 * beliefs_about(trace, name)["creep_force"].mean[part]
        left.plot(time, force, color=COLOURS[name], linewidth=1.2, label=TITLES[name])
        right.plot(time, force - truth, color=COLOURS[name], linewidth=1.0)
        largest = max(largest, min(float(np.nanmax(np.abs(force - truth))), 1.5 * size))
    left.plot(time, truth, color=palette.BLACK, linewidth=0.5, label="true")
    left.set_ylim(-0.1 * size, 1.5 * size)
    right.set_ylim(-1.05 * largest, 1.05 * largest)
    style.dress(left, x="time [s]", y="creep force [kN]", title=f"Fig. 23 around {change:g} s, seed {trace.case.seed}")
    style.dress(right, x="time [s]", y="error [kN]", title="error")
    for axes in (left, right):
        axes.axvline(change, color=palette.GREY, linewidth=0.8, linestyle=":")
    drawing.legend(*left.get_legend_handles_labels(), ncols=4, fontsize=8, frameon=False, loc="outside lower center")
    return drawing
