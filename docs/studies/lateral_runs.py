"""Runs of the wheelset with three filters, their figures over the seeds, and drawings of single runs.

An interval contains the true median over the seeds with 95 %, if they suffice. It is between order statistics, so that
it is valid for any distribution, including filters that diverged (infinity).
"""

import math
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from railgrip.campaign.work import work
from railgrip.estimation.lateral.information import errors_of_run, information
from railgrip.estimation.lateral.run import NAMES, LateralCase, Trace, simulate
from railgrip.estimation.lateral.run_measures import QUANTITIES, adhesion, beliefs_about, measure
from railgrip.estimation.lateral.wheelset import CONDITIONS, PLANTS, TESTS
from railgrip.report import palette, statistics, style
from railgrip.report.baseline import Finding

SPEED = 25.0
"""Speed of the runs [m/s]; Mal et al. do not state theirs."""
TITLES = {
    "reconstruction": "reconstruction",
    "known_track": "well posed, track known",
    "unknown_track": "well posed, track unknown",
    "known_track_stiffness": "stiffness estimated, track known",
    "unknown_track_stiffness": "stiffness estimated, track unknown",
}
PUBLISHED = ("lateral_velocity", "yaw_rate", "creep", "creep_force")
"""Quantities of the paper's figures; on one surface friction is constant, so its size does not scale its error."""
_TESTS = {test.name: test for test in TESTS}
TRANSITION = TESTS[-1].name


def cases_of(test: str, plant: str, seeds: int, duration: float) -> list[LateralCase]:
    """Return a run for each seed from 1 on, of a test compressed to a duration [s]."""
    shortened = _TESTS[test].shorten(duration)
    return [LateralCase(test=shortened, speed=SPEED, plant=plant, seed=seed) for seed in range(1, seeds + 1)]


def measure_case(case: LateralCase) -> dict[str, Any]:
    """Run and measure one case; observability is that of the filters' model, so only on the plant that equals it."""
    return measure(simulate(case), observe=case.plant == "paper")


def over_seeds(function: Any, test: str, plant: str, seeds: int, duration: float) -> list[Any]:
    """Return the results of a function in a run for each seed; see `cases_of`."""
    with work(Path(__file__)) as job:
        return job.map(function, cases_of(test, plant, seeds, duration))


@cache
def _runs(test: str, plant: str, seeds: int, duration: float) -> list[dict[str, Any]]:
    return over_seeds(measure_case, test, plant, seeds, duration)


def interval(values: Iterable[float | None], name: str) -> dict[str, float]:
    """Return the median of values, one for each seed, and the ends of its interval; None and NaN count as infinity.

    With fewer than six seeds the interval is their range.
    """
    found = sorted(math.inf if value is None or math.isnan(value) else value for value in values)
    low, high = statistics.median_interval(found) or (found[0], found[-1])
    return {name: (found[(len(found) - 1) // 2] + found[len(found) // 2]) / 2, f"{name} low": low, f"{name} high": high}


RAILS = {rail.name: f"{rail.name} {rail.mu0:g}" for rail in CONDITIONS}


def measures(test: str, plant: str, seeds: int, duration: float) -> pd.DataFrame:
    """Return a row for each seed and filter, with the RMSE of each quantity; it is infinite for a diverged filter.

    `… constant` and `… size` are the RMSE of the best constant and the rms of the truth. Columns of `RAILS` have the
    rms error of friction, infinite for a filter without an estimate of it. `lost` is when a filter was lost [s],
    `before` and `after` its largest errors of the creep force around the first change of the surface [N].
    """
    rows: list[dict[str, Any]] = []
    for seed, run in enumerate(_runs(test, plant, seeds, duration), start=1):
        sizes = {f"{quantity} {key}": run[key][quantity] for key in ("constant", "size") for quantity in QUANTITIES}
        for name in NAMES:
            levels = run["levels"].get(name, {})
            before, after = run["spike"][name] or (None, None)
            row = {"seed": seed, "filter": TITLES[name], "before": before, "after": after}
            row |= {"lost": run["lost"][name], "NIS": run["nis"][name]}
            row |= {title: levels.get(rail, (None, None))[1] for rail, title in RAILS.items()}
            rows.append(row | sizes | {quantity: run["errors"][name][quantity]["rmse"] for quantity in QUANTITIES})
    errors = [*QUANTITIES, *RAILS.values()]
    return pd.DataFrame(rows).astype(dict.fromkeys(errors, float)).fillna(dict.fromkeys(errors, math.inf))


def by_filter(rows: pd.DataFrame, of: Callable[[pd.DataFrame], Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return a row for each filter: a function of its rows of a frame."""
    return [{"filter": name, **of(part)} for name, part in rows.groupby("filter", sort=False)]


def shares(frame: pd.DataFrame, quantities: Iterable[str], scale: str) -> pd.DataFrame:
    """Return the errors of quantities over `constant` or `size`, a column for each."""
    return pd.DataFrame({each.replace("_", " "): frame[each] / frame[f"{each} {scale}"] for each in quantities})


def skill_rows(test: str, seeds: int, duration: float) -> list[dict[str, Any]]:
    """Return the median RMSE over that of the best constant, by quantity and filter."""
    frame = measures(test, "paper", seeds, duration)
    medians = shares(frame, PUBLISHED, "constant").groupby(frame["filter"], sort=False).median()
    long = medians.melt(var_name="quantity", value_name="ratio", ignore_index=False).reset_index()
    return long[["quantity", "filter", "ratio"]].to_dict("records")


def typical_row(test: str, seeds: int, duration: float) -> dict[str, Any]:
    """Return the seed whose RMSE of the creep force by the reconstruction is the median, the lower of two, and it [N].

    A filter that diverged has an infinite error.
    """
    frame = measures(test, "paper", seeds, duration).groupby("filter").get_group(TITLES["reconstruction"])
    middle = frame.sort_values(["creep_force", "seed"]).iloc[(len(frame) - 1) // 2]
    return {"seed": int(middle["seed"]), "error": middle["creep_force"]}


def spike_rows(test: str, seeds: int, duration: float) -> list[dict[str, Any]]:
    """Return the largest error of the creep force before and after the first change of the surface, by filter [N]."""
    frame = measures(test, "paper", seeds, duration)
    return by_filter(frame, lambda runs: interval(runs["before"], "before") | interval(runs["after"], "after"))


def friction_rows(plant: str, seeds: int, duration: float) -> list[dict[str, Any]]:
    """Return the median rms error of friction by condition in the transition, by filter with a state for friction."""
    frame = measures(TRANSITION, plant, seeds, duration)
    frame = frame[frame["filter"] != TITLES["reconstruction"]]
    return by_filter(frame, lambda runs: runs[[*RAILS.values()]].median().to_dict())


def innovation_rows(plant: str, seeds: int, duration: float) -> list[dict[str, Any]]:
    """Return the number of transitions in which each filter was lost, its NIS, and its friction and a constant's."""
    return by_filter(
        measures(TRANSITION, plant, seeds, duration),
        lambda runs: (
            {"lost": runs["lost"].count(), "first": runs["lost"].min()}
            | interval(runs["NIS"], "NIS")
            | interval(runs["friction"], "friction RMSE")
            | interval(runs["friction constant"], "of the best constant")
        ),
    )


def longitudinal_rows(plant: str, seeds: int, duration: float) -> list[dict[str, Any]]:
    """Return the median errors in the transition relative to the rms of the true values, by filter."""
    frame = measures(TRANSITION, plant, seeds, duration)
    relative = shares(frame, ("lateral_velocity", "creep", "creep_force", "friction"), "size")
    rows = by_filter(
        relative.join(frame[["filter", "lost"]]),
        lambda runs: runs[relative.columns].median().to_dict() | {"lost": runs["lost"].count()},
    )
    return [{"rms creep": 100 * frame["creep size"].median()} | row for row in rows]


def observed_rows(seeds: int, duration: float) -> list[dict[str, Any]]:
    """Return, by condition, median and 90 % quantile of the deviation of each hidden state, over its size [%].

    Short windows of readings in the transition inform on the states; `determined` is the share that determines all.
    """
    states = ["creep", "friction", "force"]
    windows = pd.concat(
        pd.DataFrame(100 * run.short / run.size, columns=states).assign(determined=run.rank == 5, rail=run.condition)
        for run in over_seeds(information, TRANSITION, "paper", seeds, duration)
    )
    return [
        {"condition": CONDITIONS[int(number)].name, "windows": len(part), "determined": 100 * part["determined"].mean()}
        | {f"{state}{end}": part[state].quantile(level) for state in states for end, level in (("", 0.5), (" 90", 0.9))}
        for number, part in windows.groupby("rail")
    ]


def refused_rows(seeds: int, duration: float) -> list[dict[str, Any]]:
    """Return the change of friction and force with the surface, and that which process noise and readings allow."""
    runs = over_seeds(information, TRANSITION, "paper", seeds, duration)
    jump, long = np.median([run.jump for run in runs], axis=0), np.concatenate([run.long for run in runs])
    return [
        {"state": state, "jump": jump[i], "allowed": runs[0].allowed[i], "determined": np.median(long[:, 1 + i])}
        for i, state in enumerate(("friction", "force [N]"))
    ]


def _errors(test: str, plant: str, seeds: int, duration: float) -> pd.DataFrame:
    """Return the errors of each filter and seed, with the titles of filters; see `errors_of_filter`."""
    rows = [row for rows in over_seeds(errors_of_run, test, plant, seeds, duration) for row in rows]
    return pd.DataFrame(rows).replace({"filter": TITLES})


def stiffness_rows(plant: str, seeds: int, duration: float) -> list[dict[str, Any]]:
    """Return the errors in the transition of the filters without and with an estimate of the stiffness."""
    return by_filter(
        _errors(TRANSITION, plant, seeds, duration),
        lambda errors: (
            interval(errors["rmse"], "RMSE of μ0")
            | {"coverage": errors["coverage"].mean(), "friction known": errors["known"].mean()}
            | {"RMSE of stiffness": errors["stiffness"].median(), "its coverage": errors["stiffness_coverage"].mean()}
        ),
    )


def known_rows(rail: str, plant: str, seeds: int, duration: float) -> list[dict[str, Any]]:
    """Return when the filters with an estimate of stiffness know friction; see `errors_of_filter`."""
    columns = {
        "force used": ("used", "mean"), "σ(log μ0)": ("deviation", "median"), "correlation": ("correlation", "median"),
        "friction known": ("known", "mean"), "coverage while known": ("coverage_known", "mean"),
        "while not": ("coverage_unknown", "mean"),
    }  # fmt: skip
    errors = _errors(rail, plant, seeds, duration)
    found = errors[errors["filter"].str.startswith("stiffness")].groupby("filter", sort=False).agg(**columns)
    return found.reset_index().to_dict("records")


def compared_row(seed: int, duration: float) -> dict[str, float]:
    """Return the largest deviation of the track [m], and when the reconstruction has its largest error of the force."""
    trace = simulate(cases_of(TRANSITION, "paper", seed, duration)[-1])
    error = np.abs(beliefs_about(trace, "reconstruction")["creep_force"].mean - trace.truth["creep_force"])
    return {"track": float(np.abs(trace.track).max()), "instant": float(trace.time[np.nanargmax(error)])}


_TOLERANCE = 0.05
"""Relative tolerance of rms errors, for rounding of another machine over half a million steps."""
_HEADLINES = {
    "paper": ("reconstruction", "known_track", "unknown_track"),
    "softer": ("known_track",),
    "slightly_softer": ("known_track",),
    "service": ("known_track", "unknown_track"),
}
"""Filters of the headlines by plant."""


def headlines() -> list[Finding]:
    """Return errors of filters in one transition through all conditions, with softer contacts and other sensors."""
    findings: list[Finding] = []

    def relative(what: str, value: float | None) -> None:
        findings.append(Finding(f"lateral, {what}", value, "1", _TOLERANCE * abs(value or 1)))

    for plant, names in _HEADLINES.items():
        (measures,) = _runs(TRANSITION, plant, 1, 10.0)
        for name in names:
            relative(f"{plant}, {name}: friction RMSE", measures["errors"][name]["friction"]["rmse"])
            if name in measures["detection"]:
                counts = np.array(measures["detection"][name]["confusion"])
                right = float(np.trace(counts) / counts.sum())
                who = f"lateral, {plant}, {name}: condition right, share of time"
                findings.append(Finding(who, right, "1", 0.01))
        relative(f"{plant}, the best constant: friction RMSE", measures["constant"]["friction"])
        if measures["observability"] is not None:
            least = min(value for value in measures["observability"]["service"] if value is not None)
            relative(f"{plant}: least sd of mu0, service sensors", least)
    return findings


FIRST_FIGURES: Mapping[str, int] = {test.name: 4 + 4 * number for number, test in enumerate(TESTS)}
"""Number of the first of the paper's four figures of each test."""
_COLOURS = {"reconstruction": palette.VERMILION, "known_track": palette.BLUE, "unknown_track": palette.SKY}
_LABELS = {
    "lateral_velocity": "lateral\nvelocity [m/s]",
    "yaw_rate": "yaw rate\n[rad/s]",
    "creep": "creep",
    "creep_force": "creep force\n[N]",
    "friction": "friction",
}
_THINNING = 10
"""Recorded instants from one drawn point to the next: 10 ms, for motions of 2 Hz."""
_WINDOW = 100
"""Recorded instants in each rms error: 0.1 s."""


def creep_curves(speed: float) -> Figure:
    """Return adhesion over creep of each condition at a speed [m/s], with the published friction at zero creep."""
    drawing, panel = style.panels(7, 3.4, label="Adhesion over creep in four conditions")
    creep = np.geomspace(1e-5, 0.1, 120)
    lines = ("-", "--", "-.", ":")
    for condition, colour, line in zip(CONDITIONS, palette.lead_to_trail(len(CONDITIONS)), lines, strict=True):
        panel.plot(100 * creep, adhesion(condition, creep, speed), color=colour, linestyle=line, label=condition.name)
        panel.plot(0.0, condition.mu0, "D", color=palette.BLACK, markersize=5, markerfacecolor="none", clip_on=False,
                   label="published u₀" if condition is CONDITIONS[-1] else None)  # fmt: skip
    title = f"Fig. 2, at {speed:g} m/s"
    style.dress(panel, x="creep [%]", y="adhesion coefficient", title=title, xlim=(0, 10), ylim=(0, 0.5))
    style.legend(panel, loc="upper right", ncols=2)
    return drawing


def test_figure(case: LateralCase) -> Figure:
    """Run a case; draw estimates, errors as the paper draws them, and rms errors, a row for each quantity."""
    trace = simulate(case)
    drawing, panels = style.panels(11, 1.35 * len(QUANTITIES) + 0.4, len(QUANTITIES), 3, sharex=True)
    beliefs = {name: beliefs_about(trace, name) for name in NAMES}
    time = trace.time[::_THINNING]
    windows = len(trace.time) // _WINDOW * _WINDOW
    middles = trace.time[:windows].reshape(-1, _WINDOW).mean(axis=1)
    first = FIRST_FIGURES.get(case.test.name) if case.plant == "paper" else None
    for row, ((left, middle, right), quantity) in enumerate(zip(panels, QUANTITIES, strict=True)):
        truth = trace.truth[quantity]
        size = float(np.max(np.abs(truth)))
        largest = 0.0
        for name in NAMES:
            error = beliefs[name][quantity].mean - truth
            left.plot(time, (truth + error)[::_THINNING], color=_COLOURS[name], linewidth=1.2, label=TITLES[name])
            middle.plot(trace.time, error, color=_COLOURS[name], linewidth=0.8)
            # Errors of filters that are lost are cut off.
            largest = max(largest, min(float(np.nanmax(np.abs(error))), 1.5 * size))
            squares = error[:windows].reshape(-1, _WINDOW) ** 2
            right.plot(middles, np.sqrt(squares.mean(axis=1)), color=_COLOURS[name], linewidth=1.0)
        left.plot(time, truth[::_THINNING], color=palette.BLACK, linewidth=0.5, label="true")
        # A curve outside of the panel has an error of more than half of the largest true value.
        bottom = -1.5 * size if np.min(truth) < 0 else -0.1 * size
        # The friction coefficient, which the paper estimates too, is in none of its figures.
        number = f"Fig. {first + row}" if first is not None and quantity != "friction" else ""
        style.dress(left, y=_LABELS[quantity], title=number, ylim=(bottom, 1.5 * size))
        unit = _LABELS[quantity].partition("[")[2]
        for axes, what, limits in (
            (middle, "error", {"ylim": (-1.05 * largest, 1.05 * largest)}),
            (right, "rms error over 0.1 s", {"yscale": "log", "ylim": (1e-6 * size, 1e1 * size)}),
        ):
            style.dress(axes, y=f"error [{unit}" if unit else "error", title=number and f"{number}, {what}", **limits)
        for axes in (left, middle, right):
            for change in trace.changes[1:]:
                axes.axvline(change, color=palette.GREY, linewidth=0.8, linestyle=":")
    for axes in panels[-1]:
        axes.set(xlabel="time [s]", xlim=(0, trace.time[-1]))
    style.legend(drawing, *panels[0, 0].get_legend_handles_labels(), ncols=4, loc="outside lower center")
    title = f"{case.test.name} at {case.speed:g} m/s, {PLANTS[case.plant].title}, seed {case.seed}"
    drawing.suptitle(title, fontsize=10, x=0.02, ha="left")
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
        left.plot(time, force, color=_COLOURS[name], linewidth=1.2, label=TITLES[name])
        right.plot(time, force - truth, color=_COLOURS[name], linewidth=1.0)
        largest = max(largest, min(float(np.nanmax(np.abs(force - truth))), 1.5 * size))
    left.plot(time, truth, color=palette.BLACK, linewidth=0.5, label="true")
    title = f"Fig. 23 around {change:g} s, seed {trace.case.seed}"
    style.dress(left, x="time [s]", y="creep force [kN]", title=title, ylim=(-0.1 * size, 1.5 * size))
    style.dress(right, x="time [s]", y="error [kN]", title="error", ylim=(-1.05 * largest, 1.05 * largest))
    for axes in (left, right):
        axes.axvline(change, color=palette.GREY, linewidth=0.8, linestyle=":")
    style.legend(drawing, *left.get_legend_handles_labels(), ncols=4, loc="outside lower center")
    return drawing


def typical_figure(name: str, seed: int, duration: float) -> Figure:
    """Draw a run of a test on the plant that the filters know, or "spike", the first change of the transition."""
    case = cases_of(TRANSITION if name == "spike" else name, "paper", seed, duration)[-1]
    return spike_figure(simulate(case)) if name == "spike" else test_figure(case)
