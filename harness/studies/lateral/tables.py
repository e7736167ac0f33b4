"""The tables of the lateral study: medians over seeds with intervals, as Markdown and CSV."""

import csv
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np
from scipy.stats import binom

from railgrip.record.atomic import replacing
from railgrip.studies.lateral.filters import NAMES
from railgrip.studies.lateral.judge import QUANTITIES
from railgrip.studies.lateral.study import Result
from railgrip.twins.lateral import CONDITIONS

FIGURES: Final = {"rmse": "RMSE", "bias": "bias", "nees": "NEES", "settling": "settling [s]", "peak": "peak error"}
LEVEL_TOLERANCE: Final = 0.05
"""Half of the distance between the two lowest levels: a filter that is this far off cannot name the condition."""
PLANT_TITLES: Final = {
    "paper": "plant as the filters know it",
    "twisting": "plant with a twisting axle",
    "softer": "plant with a contact 5 % softer",
    "slightly_softer": "plant with a contact 1 % softer",
    "service": "plant as the filters know it, service sensors",
}
TITLES: Final = {
    "literal": "literal",
    "known_track": "well posed, track known",
    "unknown_track": "well posed, track unknown",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """A figure over the seeds: median, and an interval that holds the true median with at least 95 %.

    The interval is between order statistics, so it holds for any distribution, diverged runs (infinity) among them.
    """

    median: float
    low: float
    high: float
    confidence: float

    def __str__(self) -> str:
        """Return the median with its interval in brackets."""
        return f"{_digits(self.median)} [{_digits(self.low)}, {_digits(self.high)}]"


def spread(values: Iterable[float | None]) -> Spread:
    """Return median and interval of values, one for each seed; None is infinity: not finite, or never settled."""
    found = np.sort([math.inf if value is None else value for value in values])
    low, confidence = _rank(len(found))
    with np.errstate(invalid="ignore"):
        median = float(np.median(found))
    # The mean of a number and infinity is infinity, of two infinities NaN in numpy's arithmetic.
    return Spread(
        median=math.inf if math.isnan(median) else median,
        low=float(found[low]),
        high=float(found[len(found) - 1 - low]),
        confidence=confidence,
    )


@cache
def _rank(n: int) -> tuple[int, float]:
    """Return the largest k such that order statistics k and n−1−k hold the median with 95 %, and with how much.

    With fewer than six values the whole range holds it with less; then that is what is returned.
    """
    best = (0, float(1 - 2 * binom.cdf(0, n, 0.5)))
    for k in range(1, n // 2):
        held = float(1 - 2 * binom.cdf(k, n, 0.5))
        if held < 0.95:
            break
        best = (k, held)
    return best


def _digits(value: float) -> str:
    return "∞" if math.isinf(value) else f"{value:.2g}"


def groups(results: Sequence[Result]) -> dict[tuple[str, float, str], list[Result]]:
    """Return the results of all seeds by (plant, speed, test)."""
    found: dict[tuple[str, float, str], list[Result]] = {}
    for result in results:
        case = result.case
        found.setdefault((case.plant, case.speed, case.test.name), []).append(result)
    return found


def error_rows(results: Sequence[Result]) -> list[dict[str, Any]]:
    """Return one row for each plant, speed, test, filter and quantity, with a `Spread` for each figure."""
    return [
        {
            "plant": plant,
            "speed": speed,
            "test": test,
            "filter": name,
            "quantity": quantity,
            "unit": unit,
            "seeds": len(runs),
            **{f: spread(run.measures["errors"][name][quantity][f] for run in runs) for f in FIGURES},
        }
        for (plant, speed, test), runs in groups(results).items()
        for name in NAMES
        for quantity, unit in QUANTITIES.items()
    ]


def write_csv(rows: Sequence[dict[str, Any]], path: Path) -> Path:
    """Write error rows with median, low and high in columns of their own."""
    flat = [
        {
            key: value
            for name, cell in row.items()
            for key, value in (
                ((name, cell.median), (f"{name}_low", cell.low), (f"{name}_high", cell.high))
                if isinstance(cell, Spread)
                else ((name, cell),)
            )
        }
        for row in rows
    ]
    with replacing(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(flat[0]))
        writer.writeheader()
        writer.writerows(flat)
    return path


def error_tables(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Return Markdown lines: for each plant and speed one table of every test, filter and quantity."""
    lines: list[str] = []
    for plant, speed in dict.fromkeys((row["plant"], row["speed"]) for row in rows):
        lines += [f"### {speed:g} m/s, {PLANT_TITLES[plant]}", ""]
        lines += _header(["test", "quantity", "filter", *FIGURES.values()])
        for row in rows:
            if (row["plant"], row["speed"]) == (plant, speed):
                unit = "" if row["unit"] == "1" else f" [{row['unit']}]"
                what = f"{row['quantity'].replace('_', ' ')}{unit}"
                lines.append(_line([row["test"], what, TITLES[row["filter"]], *(str(row[f]) for f in FIGURES)]))
        lines.append("")
    return lines


def innovation_lines(results: Sequence[Result]) -> list[str]:
    """Return Markdown: how many runs each filter was lost in, its NIS, and its friction against the best constant."""
    lines = _header(
        ["plant", "speed [m/s]", "test", "filter", "lost, of runs", "first [s]", "NIS", "friction RMSE",
         "of the best constant"]
    )  # fmt: skip
    for (plant, speed, test), runs in groups(results).items():
        constant = spread(run.measures["constant"]["friction"] for run in runs)
        for name in NAMES:
            instants = [run.measures["lost"][name] for run in runs]
            lost = [instant for instant in instants if instant is not None]
            lines.append(
                _line([PLANT_TITLES[plant], f"{speed:g}", test, TITLES[name], f"{len(lost)} of {len(runs)}",
                       f"{min(lost):.2g}" if lost else "–", str(spread(run.measures["nis"][name] for run in runs)),
                       str(spread(run.measures["errors"][name]["friction"]["rmse"] for run in runs)), str(constant)])
            )  # fmt: skip
    return [*lines, ""]


def observability_lines(results: Sequence[Result]) -> list[str]:
    """Return Markdown: to what standard deviation windows of readings tell mu0, by speed and condition."""
    lines = _header(
        ["speed [m/s]", "condition", "windows", "σ(μ0), paper's sensors", "σ(μ0), service sensors: median [10 %, 90 %]",
         "σ < 0.02", "σ < 0.05"]
    )  # fmt: skip
    found: dict[tuple[float, int], list[tuple[float, float]]] = {}
    for result in results:
        seen = result.measures["observability"]
        if seen is None:
            continue
        for number, paper, service in zip(seen["condition"], seen["paper"], seen["service"], strict=True):
            found.setdefault((result.case.speed, number), []).append(
                (math.inf if paper is None else paper, math.inf if service is None else service)
            )
    for (speed, number), pairs in sorted(found.items()):
        paper, service = np.array(pairs).T
        low, high = np.quantile(service, (0.1, 0.9), method="nearest")
        lines.append(
            _line([f"{speed:g}", CONDITIONS[number].name, str(len(pairs)), f"{np.median(paper):.1e}",
                   f"{np.median(service):.2g} [{low:.2g}, {high:.2g}]", f"{np.mean(service < 0.02):.0%}",
                   f"{np.mean(service < 0.05):.0%}"])
        )  # fmt: skip
    return [*lines, ""]


def detection_lines(results: Sequence[Result]) -> list[str]:
    """Return Markdown: confusion matrices of the condition detector in shares of time, and its delays."""
    lines: list[str] = []
    for plant, title in PLANT_TITLES.items():
        runs = [result for result in results if result.case.plant == plant]
        for name in [name for name in NAMES if runs and name in runs[0].measures["detection"]]:
            counts = np.sum([run.measures["detection"][name]["confusion"] for run in runs], axis=0)
            lines += [f"**{TITLES[name]}, {title}**: share of time of each true condition (rows)", ""]
            lines += _header(["true", *(c.name for c in CONDITIONS), "undecided"])
            for condition, row in zip(CONDITIONS, counts, strict=True):
                share = row / max(row.sum(), 1)
                lines.append(_line([condition.name, *(f"{value:.1%}" for value in share)]))
            lines += ["", *_delay_lines(runs, name), ""]
    return lines


def level_lines(results: Sequence[Result]) -> list[str]:
    """Return Markdown: what each well-posed filter believes of mu0 in runs of several conditions, with a sentence."""
    lines: list[str] = []
    for plant, title in PLANT_TITLES.items():
        several = [run for run in results if run.case.plant == plant and len(run.case.test.changes) > 1]
        speeds = sorted({run.case.speed for run in several})
        runs = [run for run in several if run.case.speed == speeds[len(speeds) // 2]]
        for name in [name for name in NAMES if runs and name in runs[0].measures["levels"]]:
            lines += [
                f"**{TITLES[name]}, {title}**",
                "",
                *_level_table([run.measures["levels"][name] for run in runs]),
                "",
            ]
    return lines


def _level_table(levels: Sequence[dict[str, tuple[float | None, float | None]]]) -> list[str]:
    conditions = [condition for condition in CONDITIONS if condition.name in levels[0]]
    believed = {c: [spread(level[c.name][k] for level in levels) for k in (0, 1)] for c in conditions}
    lines = _header(["condition", "true μ0", "believed: median [interval]", "rms error"])
    lines += [_line([c.name, f"{c.mu0:g}", *map(str, believed[c])]) for c in conditions]
    right = [c.name for c in conditions if believed[c][1].median < LEVEL_TOLERANCE]
    far = [
        f"takes {c.name}, {c.mu0:g}, for {_digits(mean.median)}" if mean.median <= 1 else f"is lost in {c.name}"
        for c, (mean, error) in believed.items()
        if error.median >= LEVEL_TOLERANCE
    ]
    told = f"Tells μ0 within {LEVEL_TOLERANCE:g} rms in {', '.join(right) or 'no condition'}"
    return [*lines, "", f"{told}; {'; '.join(far)}." if far else f"{told}."]


def _delay_lines(runs: Sequence[Result], name: str) -> list[str]:
    changes: dict[str, list[float | None]] = {}
    for run in runs:
        conditions = [condition.name for _, condition in run.case.test.changes]
        from_to = [
            "start → " + conditions[0],
            *(f"{a} → {b}" for a, b in pairwise(conditions)),
        ]
        for change, delay in zip(from_to, run.measures["detection"][name]["delays"], strict=True):
            changes.setdefault(change, []).append(delay)
    lines = _header(["change", "number", "detected", "delay: median [interval] s", "longest detected [s]"])
    for change, delays in changes.items():
        known = [delay for delay in delays if delay is not None]
        lines.append(
            _line(
                [change, str(len(delays)), str(len(known)), str(spread(delays)), _digits(max(known, default=math.inf))]
            )
        )
    return lines


def _header(names: Sequence[str]) -> list[str]:
    return [_line(names), "|" + "---|" * len(names)]


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
