"""The table of braking distances: one row a stop, as JSON for machines and Markdown for people."""

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from harness.record.atomic import write_text
from harness.record.outcome import Outcome
from harness.verdict.compilers import from_elsewhere, makers
from harness.verdict.results import Result, Results

REFERENCE_CONTROLLER = "slip_two_state"
"""The controller that reductions are counted from: the paper's SBC."""

CONTROLLERS = {
    "full_brake": "full brake",
    "slip_two_state": "SBC, two-state",
    "slip_three_state": "SBC, three-state",
    "adhesion_based": "ABC",
    "adhesion_literal": "ABC, the law as printed",
    "ideal_bound": "ideal bound",
    "fmu": "FMU",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A stop in the table.

    Attributes:
        case: What else tells it apart: the variants of axes that the other columns do not show; most often empty.
        distance_m: None unless the train stood at the end.
        reduction_vs_sbc: 1 − distance over that of the two-state SBC in the same conditions; None without either.
        utilisation: Of the adhesion that the ideal bound has; None for a stop that is none.
        paper_distance_m: As published; None for a stop that was not.
        paper_reduction: The published reduction against the published SBC.
        outcome: How the stop ended.
        longest_lock_s: Of any ω-group.
        nis: Median squared innovation of the estimator over its expected one; None without an estimator.
        outside: Largest share of time that a true adhesion or pad friction was outside ±2σ; None without an estimator.
        air_l: Free air used, litres; None for a stop without a brake, such as the ideal bound.
        stop: Name of the stop in the campaign.
    """

    scenario: str
    case: str
    polach: str
    actuation: str
    sensors: str
    controller: str
    estimator: str
    distance_m: float | None
    duration_s: float | None
    reduction_vs_sbc: float | None
    utilisation: float | None
    paper_distance_m: float | None
    paper_reduction: float | None
    outcome: str
    longest_lock_s: float | None
    air_l: float | None
    nis: float | None
    outside: float | None
    stop: str

    @property
    def label(self) -> str:
        """Scenario and case, for people."""
        return f"{self.scenario}, {self.case}" if self.case else self.scenario


def rows_of(results: Results) -> tuple[Row, ...]:
    """Return the rows of a campaign, in its order."""
    sbc = {_conditions(result): result for result in results.stops if _controller(result) == REFERENCE_CONTROLLER}
    hidden = _hidden_axes(results.stops)
    return tuple(_row(result, sbc.get(_conditions(result)), hidden) for result in results.stops)


def write_table(results: Results, directory: Path) -> tuple[Path, Path]:
    """Write NAME.json and NAME.md of a campaign and return their paths."""
    rows = rows_of(results)
    # JSON has no NaN: a figure that does not exist (the air of the ideal bound) is null.
    plain = [{key: None if value != value else value for key, value in asdict(row).items()} for row in rows]
    tools = {stop.name: makers(stop.record.versions) for stop in results.stops}
    content = {"campaign": results.name, "rows": plain, "missing": list(results.missing), "fmus": tools}
    as_json, as_markdown = directory / f"{results.name}.json", directory / f"{results.name}.md"
    write_text(as_json, json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    notes = [f"{sentence}\n" for sentence in from_elsewhere(results.stops)]
    write_text(as_markdown, "\n".join([markdown(results.name, results.description, rows, results.missing), *notes]))
    return as_json, as_markdown


def markdown(name: str, description: str, rows: Sequence[Row], missing: Sequence[str]) -> str:
    """Return the table as Markdown, a section for each set of conditions of actuation, sensors and creep curve."""
    lines = [f"# {name}", "", description, ""]
    settings = dict.fromkeys((row.actuation, row.sensors, row.polach) for row in rows)
    for actuation, sensors, polach in settings:
        here = [row for row in rows if (row.actuation, row.sensors, row.polach) == (actuation, sensors, polach)]
        lines += [
            f"## Actuation {actuation}, sensors {sensors}, creep curve {polach}",
            "",
            "| scenario | controller | estimator | distance | paper | against SBC | paper | duration "
            "| adhesion used | longest lock | air | NIS, 1 expected | outside ±2σ, 5 % expected |",
            "|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|",
            *(_markdown_row(row) for row in here),
            "",
        ]
    if missing:
        lines += [f"Not run: {', '.join(missing)}.", ""]
    return "\n".join(lines)


def _markdown_row(row: Row) -> str:
    distance = f"{row.distance_m:.1f} m" if row.distance_m is not None else f"none: {row.outcome}"
    cells = (
        row.label,
        CONTROLLERS.get(row.controller, row.controller),
        row.estimator,
        distance,
        _cell(row.paper_distance_m, "{:.1f} m"),
        _cell(row.reduction_vs_sbc, "{:+.1%}", negate=True),
        _cell(row.paper_reduction, "{:+.1%}", negate=True),
        _cell(row.duration_s, "{:.1f} s"),
        _cell(row.utilisation, "{:.1%}"),
        _cell(row.longest_lock_s, "{:.2f} s"),
        _cell(row.air_l, "{:.0f} l"),
        _cell(row.nis, "{:.2g}"),
        _cell(row.outside, "{:.0%}"),
    )
    return f"| {' | '.join(cells)} |"


def _cell(value: float | None, form: str, *, negate: bool = False) -> str:
    """Return a number for people; a reduction is shown as the change it is: −12.9 %."""
    if value is None or math.isnan(value):
        return ""
    return form.format(-value if negate else value).replace("-", "−").replace("%", " %")


def _row(result: Result, sbc: Result | None, hidden: Sequence[str]) -> Row:
    record = result.record
    metrics = record.metrics
    stands = record.outcome is Outcome.STANDSTILL
    paper_sbc = sbc.paper_distance if sbc else None
    is_sbc = sbc is result
    return Row(
        scenario=record.scenario["name"],
        case=", ".join(f"{axis} {result.variants[axis]}" for axis in hidden),
        polach=_polach(result),
        actuation=record.scenario["actuation"]["kind"],
        sensors=record.scenario["sensors"]["kind"],
        controller=_controller(result),
        estimator=_estimator(result),
        distance_m=metrics.distance if stands else None,
        duration_s=metrics.duration if stands else None,
        reduction_vs_sbc=None if is_sbc else _reduction(_distance(result), _distance(sbc) if sbc else None),
        utilisation=_number(metrics.utilisation),
        paper_distance_m=result.paper_distance,
        paper_reduction=None if is_sbc else _reduction(result.paper_distance, paper_sbc),
        outcome=record.outcome.value,
        longest_lock_s=_number(max(metrics.longest_lock)),
        air_l=_number(1000 * metrics.air_used),
        nis=metrics.nis_ratio,
        outside=max((*(metrics.adhesion_outside or ()), *(metrics.pad_friction_outside or ())), default=None),
        stop=result.name,
    )


def _shown(result: Result) -> tuple[str, ...]:
    """Return what the columns of a row say about its scenario."""
    scenario = result.record.scenario
    kinds = (scenario["actuation"]["kind"], scenario["sensors"]["kind"])
    return (scenario["name"], _polach(result), *kinds, _controller(result), _estimator(result))


def _hidden_axes(stops: Sequence[Result]) -> tuple[str, ...]:
    """Return the axes in which stops differ that look the same in every column."""
    alike: dict[tuple[str, ...], list[Result]] = {}
    for stop in stops:
        alike.setdefault(_shown(stop), []).append(stop)
    axes = dict.fromkeys(axis for stop in stops for axis in stop.variants)
    return tuple(
        axis for axis in axes if any(len({stop.variants.get(axis) for stop in same}) > 1 for same in alike.values())
    )


def _conditions(result: Result) -> str:
    """Return everything that a stop shares with the one it is compared to: all but the controller and its estimator."""
    own = ("controller", "estimator")
    return json.dumps({key: value for key, value in result.record.scenario.items() if key not in own}, sort_keys=True)


def _controller(result: Result) -> str:
    return result.record.scenario["controller"]["kind"]


def _estimator(result: Result) -> str:
    estimator = result.record.scenario["estimator"]
    return estimator["kind"] if estimator["kind"] == "none" else f"{estimator['model']} ({estimator['kind']})"


def _polach(result: Result) -> str:
    return result.record.scenario["adhesion"]["polach"]["name"]


def _distance(result: Result) -> float | None:
    return result.record.metrics.distance if result.record.outcome is Outcome.STANDSTILL else None


def _number(value: float) -> float | None:
    """Return a figure, or None where it does not exist."""
    return value if math.isfinite(value) else None


def _reduction(distance: float | None, reference: float | None) -> float | None:
    return None if distance is None or reference is None else 1 - distance / reference
