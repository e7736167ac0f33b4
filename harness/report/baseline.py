"""Accepted numbers, distances of a campaign or figures of a study, and the comparison of results with them.

A baseline file gives, for each stop or figure, the accepted value, its tolerance, and the reason for the value:

    campaign = "../../harness/scenario/campaigns/table1.toml"

    [accepted.trapezoid-ideal-slip_two_state]
    value = 382.61
    tolerance = 0.39
    unit = "m"
    reason = "First calibration."

For a long campaign the file may select stops by patterns, `stops = ["*-slope_seeking"]`. The name of a study, `study =
"etcs"`, replaces the campaign file if the numbers are those of a study, and a Python file, `module = "mine.py"`, if
its function `headlines()` returns them as a list of `Finding`.

A distance that depends on rounding (see `railgrip.scenario.conditioning`) is accepted as a range: `value` is the median
of the repeats, `lowest` and `highest` are the ends of the range, and `tolerance` is the permitted excess beyond an end.
The distances that the repeats have with the FMUs of another compiler, from the shortest to the longest, are added:

    compilers = { openmodelica = [316.21, 318.27] }

Further figures of a stop reveal changes that its distance does not, such as another noise of the filter:

    figures.adhesion_rmse = { value = 0.00074, tolerance = 7.4e-8 }

These are the figures of `Metrics.compared` that vary by less than `railgrip.scenario.conditioning.LOOSEST` over
the repeats, or by less than `LOOSEST_OF_SCATTER` for a stop without such figures. The greatest adhesion and
the longest lock of any group [s] and the strokes of all valves at the last `make accept` are for information; they are
compared only if they are among the figures.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from fnmatch import fnmatch
from itertools import takewhile
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, StrictInt, TypeAdapter, ValidationError

from railgrip.base.errors import RecordError, ScenarioError
from railgrip.base.files import read_text, write_json, write_text
from railgrip.base.records import claim, read_json_value, words_of
from railgrip.base.tables import JsonObject
from railgrip.report import table
from railgrip.report.frame import frame_of, plain_rows
from railgrip.report.results import Results, from_elsewhere
from railgrip.scenario.campaign import Campaign
from railgrip.scenario.conditioning import CERTAINTY, LOOSEST, SMOOTH, RepeatedDistances
from railgrip.scenario.load import read_toml, validate_table
from railgrip.scenario.quantity import Number, UnitRange
from railgrip.scenario.table import Table, table_error

FINDINGS_FILE = "figures.json"

TOLERANCE = 1e-3
"""Relative tolerance of a new distance.

Twice the change with half the communication step (0.05 %), so that the arithmetic of another machine passes and a
changed law does not.
"""

CERTAINTY_OF_SCATTER, LOOSEST_OF_SCATTER = 0.9999, 0.06
"""Certainty and limit for the figures of a stop without any within `LOOSEST`: they reveal a change of a tenth.

On another machine each such stop is one more repeat: with `CERTAINTY` one in a hundred of these figures would fail.
"""

ACROSS_COMPILERS = 5e-3
"""Relative tolerance of a distance with FMUs of another compiler: its solver uses other steps, which shifts strokes of
the valves.

A wrong model changes the distance by more.
"""


class AcceptedFigure(Table):
    """Accepted value of a further figure of a stop, in the unit of `railgrip.trace.metrics`."""

    value: Number
    tolerance: Annotated[Number, Field(gt=0.0)]


class AcceptedValue(Table):
    """Accepted value of one stop or one figure."""

    value: Number
    tolerance: Annotated[Number, Field(gt=0.0)]
    unit: str
    lowest: Number | None = None
    highest: Number | None = None
    adhesion_peak: Number | None = None
    longest_lock: Annotated[float, UnitRange("s", at_least=0)] | None = None
    valve_strokes: Annotated[StrictInt, Field(ge=0)] | None = None
    reason: Annotated[str, Field(min_length=1)]
    compilers: dict[str, tuple[Number, Number]] = Field(
        default={}, description="other compiler → lowest and highest value with its FMUs"
    )
    figures: dict[str, AcceptedFigure] = Field(default={}, description="further figure → accepted value")

    def _check(self) -> None:
        if (self.lowest is None) != (self.highest is None):
            raise table_error("has one end of a range; give both lowest and highest, or neither")
        if not self.ends[0] <= self.value <= self.ends[1]:
            raise table_error(f"value {self.value:g} is not within lowest and highest")

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the range; both are the value where it is a single number."""
        return (
            self.value if self.lowest is None else self.lowest,
            self.value if self.highest is None else self.highest,
        )

    @property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest permitted value."""
        return self.ends[0] - self.tolerance, self.ends[1] + self.tolerance

    @property
    def is_range(self) -> bool:
        """Whether the value depends on rounding, and is therefore a range."""
        return self.lowest is not None


class Baseline(Table):
    """A baseline file."""

    campaign: str | None = Field(default=None, description="campaign file, relative to the folder of this file")
    stops: tuple[str, ...] = Field(default=(), description="patterns of the stops of the campaign; all without it")
    study: str | None = Field(default=None, description="name of a study of railgrip.studies")
    module: str | None = Field(
        default=None, description="Python file with headlines(), likewise relative, in a folder of --import-from"
    )
    accepted: dict[str, AcceptedValue] = Field(default={}, description="name of a stop or figure → accepted value")

    def _check(self) -> None:
        if [self.campaign, self.study, self.module].count(None) != 2:
            raise table_error("must have either campaign, the file of one, or study, the name of one, or module")

    def selection(self, campaign: Campaign) -> Campaign:
        """Return the campaign with the stops that the baseline covers."""
        return campaign.only(lambda stop: not self.stops or any(fnmatch(stop.name, name) for name in self.stops))

    def across_compilers(self) -> Self:
        """Return the baseline for FMUs of another compiler.

        A stop may have a distance within `ACROSS_COMPILERS` of the accepted one. If the compilers are known to differ
        by more, or its distance depends on rounding, it may have any distance between those known, and
        `ACROSS_COMPILERS` beyond; the latter may also exceed the range by a quarter, as in another run of one compiler.
        Figures are not compared: their tolerances apply to the built-in compiler's plant.
        """
        wide: dict[str, AcceptedValue] = {}
        for name, accepted in self.accepted.items():
            known = accepted.ends + tuple(
                end
                for ends in accepted.compilers.values()
                for end in ends
                if accepted.is_range or abs(end - accepted.value) > ACROSS_COMPILERS * accepted.value
            )
            low, high = min(known), max(known)
            middle, half = (low + high) / 2, (high - low) / 2
            beyond = max(ACROSS_COMPILERS * high, half / 2 if accepted.is_range else 0.0)
            wide[name] = accepted.model_copy(update={"value": middle, "tolerance": half + beyond, "figures": {}})
        return self.model_copy(update={"accepted": wide})


@dataclass(frozen=True, slots=True)
class Finding:
    """One number of a result.

    Attributes:
        name: Name of the stop or figure.
        value: Number found; None if it does not exist, as after a stop without standstill or without the alarm.
        unit: Unit of the value.
        tolerance: Tolerance to accept the value with; None for the relative tolerance of the previously accepted value,
            or for `TOLERANCE`.
        repeated: Repeats of the stop, if its distance depends on rounding.
        adhesion_peak: Greatest adhesion of any group; None for a figure.
        longest_lock: Longest lock of any group [s]; None for a figure.
        valve_strokes: Strokes of all valves; None without valves.
        figures: Name of a further figure → value.
    """

    name: str
    value: float | None
    unit: str
    tolerance: float | None = None
    repeated: RepeatedDistances | None = None
    adhesion_peak: float | None = None
    longest_lock: float | None = None
    valve_strokes: int | None = None
    figures: Mapping[str, float] = field(default_factory=dict[str, float])


def mean(name: str, value: float, unit: str = "1") -> Finding:
    """Return a figure that is a mean, with a tolerance of 2 % for the arithmetic of another machine."""
    return Finding(name, value, unit, 0.02 * abs(value))


def extreme(name: str, value: float) -> Finding:
    """Return a dimensionless figure that is an extreme of many values, with a tolerance of 10 %."""
    return Finding(name, value, "1", 0.1 * abs(value))


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """The numbers of a result, and the names of planned stops without a result."""

    values: tuple[Finding, ...]
    missing: tuple[str, ...] = ()


State = Literal["kept", "moved", "new", "gone", "no value"]


@dataclass(frozen=True, slots=True, kw_only=True)
class BaselineComparison:
    """One number and its baseline.

    Attributes:
        name: Name of the stop or figure.
        state: `kept` if it and its further figures are within the tolerance, else `moved`; `new` without a baseline;
            `gone` without a result, also of a stop that has no baseline yet; `no value` for a stop without standstill
            or a figure that does not exist.
        accepted: Baseline; None for a new number.
        current: Number found, or None.
        moved_figures: Further figures that are missing or outside their tolerance, with accepted value and value found.
    """

    name: str
    state: State
    accepted: AcceptedValue | None
    current: Finding | None
    moved_figures: tuple[str, ...] = ()

    @property
    def value(self) -> float | None:
        """Number found, or None."""
        return None if self.current is None else self.current.value

    @property
    def change(self) -> float | None:
        """Value found minus accepted value."""
        return None if self.accepted is None or self.value is None else self.value - self.accepted.value

    @property
    def unit(self) -> str:
        """Unit of the number."""
        return self.accepted.unit if self.accepted else self.current.unit if self.current else ""

    @property
    def sentence(self) -> str:
        """Deviation from the baseline, with the number before and after and its limits; empty if it is kept."""
        if self.state == "kept":
            return ""
        form = ("{:.2f}" if self.unit == "m" else "{:.4g}") + f" {self.unit}".removesuffix(" 1").rstrip()
        if self.value is None:
            found = "no result" if self.state == "gone" else "no standstill" if self.unit == "m" else "no value"
        else:
            found = form.format(self.value)
        if self.accepted is None:
            return f"{self.name}: {found}; it has no baseline"
        accepted, lowest, highest = map(form.format, (self.accepted.value, *self.accepted.limits))
        change = "" if self.change is None else f" ({form.replace(':', ':+').format(self.change)})"
        moved = f"{self.name}: {accepted} → {found}{change}; permitted is {lowest} to {highest}"
        return "; ".join([moved, *self.moved_figures])

    def to_plain(self) -> JsonObject:
        """Return the comparison as JSON values."""
        limits = (None,) * 3 if self.accepted is None else (self.accepted.value, *self.accepted.limits)
        names = ("name", "state", "value", "change", "unit", "sentence")
        return {name: getattr(self, name) for name in names} | dict(
            zip(("accepted", "lowest", "highest"), limits, strict=True)
        )


def load_baseline(path: Path) -> Baseline:
    """Return a baseline file.

    Raises:
        ScenarioError: The file is missing, or is not a baseline.
    """
    return validate_table(Baseline, read_toml(path), directory=path.parent, origin=path.name)


def findings_of(results: Results) -> Findings:
    """Return the distances of a campaign; a stop without standstill has no distance."""
    return Findings(
        values=tuple(
            Finding(
                name=result.name,
                value=row["distance_m"],
                unit="m",
                repeated=result.own_repeats,
                adhesion_peak=row["adhesion_peak"],
                longest_lock=row["longest_lock_s"],
                valve_strokes=row["valve_strokes"],
                figures=result.metrics.compared(),
            )
            for result, row in zip(results.stops, plain_rows(frame_of(results)), strict=True)
        ),
        missing=results.missing,
    )


def baseline_deviations(results: Results, path: Path) -> list[str]:
    """Return a sentence for each distance with FMUs of other compilers that differs by more than `ACROSS_COMPILERS`.

    The list is empty if all FMUs are from the built-in compiler, whose distances `railgrip maintain regress` compares,
    or if the baseline file does not exist.
    """
    if not from_elsewhere(results.stops) or not path.is_file():
        return []
    baseline = load_baseline(path)
    known = [stop for stop in results.stops if stop.name in baseline.accepted and from_elsewhere([stop])]
    findings = findings_of(replace(results, stops=tuple(known)))
    return [
        f"{comparison.name}: {comparison.value:.2f} m by FMUs of another compiler, {accepted.value:.2f} m is accepted, "
        f"{100 * (comparison.value / accepted.value - 1):+.1f} %."
        for comparison in compare(baseline.across_compilers(), findings)
        if comparison.state == "moved" and comparison.value is not None
        for accepted in (baseline.accepted[comparison.name],)
    ]


def write_findings(findings: Findings, directory: Path) -> None:
    """Write the figures of a study into a folder, for `read_findings`."""
    claim(directory, FINDINGS_FILE)
    write_json(directory / FINDINGS_FILE, [asdict(finding) for finding in findings.values])


def read_findings(directory: Path) -> Findings:
    """Return the figures of a study that were last written into a folder.

    Raises:
        RecordError: The figures are missing, or cannot be read.
    """
    path = directory / FINDINGS_FILE
    try:
        values = TypeAdapter(tuple[Finding, ...]).validate_python(read_json_value(directory, FINDINGS_FILE))
    except FileNotFoundError as problem:
        raise RecordError(f"{path}: there is no such file; `railgrip maintain regress` makes one") from problem
    except ValidationError as problem:
        raise RecordError(f"{path}: does not contain the figures of a study ({words_of(problem)})") from problem
    return Findings(values=values)


def compare(baseline: Baseline, findings: Findings) -> tuple[BaselineComparison, ...]:
    """Return every number of baseline and findings, starting with those that require attention."""
    current = {finding.name: finding for finding in findings.values}
    names = dict.fromkeys([*current, *baseline.accepted, *findings.missing])
    comparisons = [_compare(name, baseline.accepted.get(name), current.get(name)) for name in names]
    return tuple(sorted(comparisons, key=lambda comparison: comparison.state == "kept"))


def accept(baseline: Baseline, findings: Findings, reason: str) -> Baseline:
    """Return the baseline with new, moved and removed numbers updated, for a reason.

    Numbers within their tolerance keep value and reason, ranges only if the repeats have not changed. A distance that
    does not vary over the repeats gets their tolerance, and its further figures are those found.

    Raises:
        ScenarioError: The reason is empty, or a stop or figure has no value to accept.
    """
    if not reason.strip():
        raise ScenarioError("accept: --reason is empty; say what changed and why the new numbers are right")
    after: dict[str, AcceptedValue] = {}
    for comparison in compare(baseline, findings):
        name, before, finding = comparison.name, comparison.accepted, comparison.current
        if finding is None:
            if name in findings.missing:
                raise ScenarioError(f"accept: {name} has no result; run the campaign first")
            continue
        if finding.value is None:
            raise ScenarioError(f"accept: {name} has no value (no standstill, no alarm); a baseline must be a number")
        anew = _accept_finding(finding, finding.value, before, reason.strip())
        # A range is always that of the present repeats, which tables and pages show.
        is_of_repeats = before is not None and (
            finding.repeated is None
            or (not before.is_range and not finding.repeated.spreads)
            or (before.value, *before.ends) == (anew.value, *anew.ends)
        )
        if before is None or comparison.state != "kept" or not is_of_repeats:
            before = anew
        shown = {"adhesion_peak": finding.adhesion_peak, "longest_lock": finding.longest_lock}
        update: dict[str, object] = {key: None if value is None else round(value, 3) for key, value in shown.items()}
        update["valve_strokes"] = finding.valve_strokes
        # The tolerance of figures comes from repeats; without repeats, keep the figures accepted before.
        if finding.repeated is not None and finding.repeated.figures:
            update["figures"] = _other_figures(finding, finding.repeated)
        if finding.repeated is not None and finding.repeated.is_smooth and abs(finding.value - before.value) <= SMOOTH:
            update["tolerance"] = min(before.tolerance, SMOOTH)
        if finding.repeated is not None:
            ends = {other: finding.repeated.ends_of(other) for other in finding.repeated.compilers}
            update["compilers"] = before.compilers | {
                other: pair for other, pair in ends.items() if math.isfinite(pair[1])
            }
        after[name] = before.model_copy(update=update)
    return baseline.model_copy(update={"accepted": after})


def _other_figures(finding: Finding, repeated: RepeatedDistances) -> dict[str, AcceptedFigure]:
    """Return the figures that the repeats determine well; else those that they determine less well."""
    tolerances: dict[str, float | None] = {}
    for certainty, loosest in ((CERTAINTY, LOOSEST), (CERTAINTY_OF_SCATTER, LOOSEST_OF_SCATTER)):
        tolerances = {
            name: repeated.tolerance_of(name, value, certainty, loosest) for name, value in finding.figures.items()
        }
        # Zeros, as for a wheel that never locks, agree in all repeats and do not count.
        if any(tolerance is not None and finding.figures[name] for name, tolerance in tolerances.items()):
            break
    return {
        name: AcceptedFigure(value=value, tolerance=float(f"{tolerance:.2g}"))
        for name, value in finding.figures.items()
        if (tolerance := tolerances[name]) is not None
    }


def _accept_finding(finding: Finding, value: float, before: AcceptedValue | None, reason: str) -> AcceptedValue:
    lowest = highest = None
    if finding.repeated is not None and finding.repeated.spreads:
        value, tolerance = finding.repeated.median, finding.repeated.margin
        lowest, highest = finding.repeated.lowest, finding.repeated.highest
    elif finding.tolerance is not None:
        tolerance = finding.tolerance
    else:
        scales = before is not None and not before.is_range and before.value != 0.0
        tolerance = abs(value) * (before.tolerance / abs(before.value) if before and scales else TOLERANCE)
    return AcceptedValue(
        # Distances are rounded to the millimetre, small figures to a hundredth of their tolerance.
        value=round(value, max(3, 2 - _magnitude(tolerance))),
        tolerance=round(tolerance, 1 - _magnitude(tolerance)),
        unit=finding.unit,
        lowest=lowest,
        highest=highest,
        reason=reason,
        compilers=before.compilers if before else {},
    )


def write_baseline(baseline: Baseline, path: Path) -> None:
    """Write a baseline file, with its numbers in the order of their names; comments at its beginning stay."""
    keys = ("campaign", "stops", "study")
    before = read_text(path).splitlines() if path.exists() else []
    lines = list(takewhile(lambda line: line.startswith("#"), before))
    lines += [f"{key} = {json.dumps(value)}" for key in keys if (value := getattr(baseline, key))]
    for name, accepted in sorted(baseline.accepted.items()):
        numbers = accepted.model_dump(exclude={"unit", "reason", "compilers", "figures"}, exclude_none=True)
        lines += [
            "",
            f"[accepted.{json.dumps(name, ensure_ascii=False)}]",
            *(f"{key} = {number!r}" for key, number in numbers.items()),
            *(f"{key} = {json.dumps(getattr(accepted, key), ensure_ascii=False)}" for key in ("unit", "reason")),
        ]
        if accepted.compilers:
            values = ", ".join(f"{json.dumps(name)} = {list(ends)!r}" for name, ends in accepted.compilers.items())
            lines.append(f"compilers = {{ {values} }}")
        lines += [
            f"figures.{figure} = {{ value = {each.value!r}, tolerance = {each.tolerance!r} }}"
            for figure, each in sorted(accepted.figures.items())
        ]
    write_text(path, "\n".join(lines) + "\n")


def comparison_table(comparisons: Sequence[BaselineComparison], title: str = "") -> table.ReportTable:
    """Return the comparison; in metres if all numbers are distances, otherwise with a column of units."""
    are_metres = {comparison.unit for comparison in comparisons} <= {"m"}
    form, change, behind = ("{:.2f}", "{:+.3f}", " [m]") if are_metres else ("{:.4g}", "{:+.2g}", "")
    rows = [
        {
            "stop" if are_metres else "figure": comparison.name,
            "state": comparison.state,
            f"accepted{behind}": _value_and_range(comparison.accepted, form),
            f"found{behind}": comparison.value,
            f"change{behind}": comparison.change,
            f"tolerance{behind}": comparison.accepted.tolerance if comparison.accepted else None,
        }
        | ({"figures": "; ".join(comparison.moved_figures)} if are_metres else {"unit": comparison.unit})
        for comparison in comparisons
    ]
    forms = {f"found{behind}": form, f"tolerance{behind}": form, f"change{behind}": change}
    return table.ReportTable(rows, forms, title=title)


def _value_and_range(before: AcceptedValue | None, form: str) -> str:
    if before is None:
        return ""
    ends = f" ({form.format(before.lowest)} – {form.format(before.highest)})" if before.is_range else ""
    return form.format(before.value) + ends


def _compare(name: str, before: AcceptedValue | None, finding: Finding | None) -> BaselineComparison:
    moved: list[str] = []
    if before is not None and finding is not None:
        moved = [
            f"{figure} {accepted.value:.6g} → {finding.figures.get(figure, math.nan):.6g}, ±{accepted.tolerance:.2g}"
            for figure, accepted in before.figures.items()
            if not abs(finding.figures.get(figure, math.nan) - accepted.value) <= accepted.tolerance
        ]
    if finding is None:
        state = "gone"
    elif finding.value is None:
        state = "no value"
    elif before is None:
        state = "new"
    else:
        lowest, highest = before.limits
        state = "kept" if lowest <= finding.value <= highest and not moved else "moved"
    return BaselineComparison(name=name, state=state, accepted=before, current=finding, moved_figures=tuple(moved))


def _magnitude(number: float) -> int:
    return math.floor(math.log10(abs(number))) if number else 0
