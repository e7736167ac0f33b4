"""What was accepted, distances of a campaign or figures of a study, and whether results keep to it.

A baseline file says for each stop the distance, how far it may move, and why it is what it is:

    campaign = "../../harness/scenario/campaigns/table1.toml"

    [stops.trapezoid-ideal-slip_two_state]
    distance = 382.61    # m
    tolerance = 0.39     # m
    reason = "First calibration."

A stop whose distance rounding decides (see `railgrip.scenario.conditioning`) has a range: `distance` is the median of
its repeats, `lowest` and `highest` are theirs, and `tolerance` is what it may lie beyond them. Where another compiler's
plant, the same but for rounding, stops elsewhere, its distance stands there as it does among the repeats:

    compilers = { openmodelica = 318.27 }  # m

Beside the distances stand the longest lock of any group [s] and the strokes of all valves, as of the last `make
accept`: shown, not compared.

The same for the figures of a study of `railgrip.studies`:

    study = "estimate"

    [figures."rig slide, own filter: pad friction, RMSE"]
    value = 0.0071
    tolerance = 0.00014
    unit = "1"
    reason = "First figures."
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, NonNegativeInt, model_validator

from railgrip.errors import RecordError, ScenarioError
from railgrip.files import write_json, write_text
from railgrip.report import table
from railgrip.report.distances import rows_of
from railgrip.report.results import Result, Results, from_elsewhere
from railgrip.report.row import Row
from railgrip.scenario.conditioning import Repeated
from railgrip.scenario.load import read_toml, validated
from railgrip.scenario.quantity import Unit
from railgrip.scenario.table import Table, broken

FINDINGS_FILE = "figures.json"

TOLERANCE = 1e-3
"""Of a new baseline, relative: twice what the distance may move when the communication step is halved (0.05 %), so that
another machine's arithmetic passes and a changed law does not."""


ACROSS_COMPILERS = 5e-3
"""How far a distance may move with FMUs of another compiler, relative: the steps of another solver end elsewhere, which
puts strokes of the valves apart. A wrong model moves it further."""

Distance = Annotated[float, Unit("m", above=0)]


class Accepted(Table):
    """One stop of a baseline."""

    distance: Distance
    tolerance: Distance
    lowest: Distance | None = None
    highest: Distance | None = None
    longest_lock: Annotated[float, Unit("s", at_least=0)] | None = None
    valve_strokes: NonNegativeInt | None = None
    reason: Annotated[str, Field(min_length=1)]
    compilers: dict[str, Distance] = Field(
        default={}, description="compiler → distance with its plant, where it differs"
    )

    @model_validator(mode="after")
    def _whole_range(self) -> Self:
        if (self.lowest is None) != (self.highest is None):
            raise broken("has one end of a range; it wants both lowest and highest, or neither")
        if not self.ends[0] <= self.distance <= self.ends[1]:
            raise broken(f"distance {self.distance:g} m is not within lowest and highest")
        return self

    @property
    def ends(self) -> tuple[float, float]:
        """The range [m]; twice the distance where it is a number."""
        return self.lowest or self.distance, self.highest or self.distance

    @property
    def is_range(self) -> bool:
        """Whether rounding decides the distance."""
        return self.lowest is not None

    @property
    def value(self) -> float:
        """The distance [m]."""
        return self.distance

    @property
    def unit(self) -> str:
        """Of the distance."""
        return "m"


class AcceptedFigure(Table):
    """One figure of a study."""

    value: Annotated[float, Field(allow_inf_nan=False)]
    tolerance: Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
    unit: str
    reason: Annotated[str, Field(min_length=1)]

    @property
    def ends(self) -> tuple[float, float]:
        """Twice the value: a figure is a number, no range."""
        return self.value, self.value


class Baseline(Table):
    """A baseline file."""

    campaign: str | None = Field(default=None, description="campaign file, from this one's folder")
    study: str | None = Field(default=None, description="name of a study of railgrip.studies")
    stops: dict[str, Accepted] = Field(default={}, description="name of a stop → what is accepted")
    figures: dict[str, AcceptedFigure] = Field(default={}, description="name of a figure → what is accepted")

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        if (self.campaign is None) == (self.study is None):
            raise broken("wants either campaign, the file of one, or study, the name of one")
        if self.stops and self.study is not None:
            raise broken("has [stops], which belong to a campaign; a study has [figures]")
        if self.figures and self.campaign is not None:
            raise broken("has [figures], which belong to a study; a campaign has [stops]")
        return self

    def across_compilers(self) -> Self:
        """Return the baseline that FMUs of another compiler have to keep to.

        A stop that another compiler's plant is known to end elsewhere may end anywhere between.
        """
        stops: dict[str, Accepted] = {}
        for name, stop in self.stops.items():
            low, high = (choose((*stop.ends, *stop.compilers.values())) for choose in (min, max))
            middle, half = (low + high) / 2, (high - low) / 2
            stops[name] = stop.model_copy(update={"distance": middle, "tolerance": half + ACROSS_COMPILERS * high})
        return self.model_copy(update={"stops": stops})

    @property
    def accepted(self) -> Mapping[str, Accepted | AcceptedFigure]:
        """What is accepted, whatever it is of."""
        return self.figures if self.campaign is None else self.stops


@dataclass(frozen=True, slots=True)
class Finding:
    """One number of a result.

    Attributes:
        name: Of the stop or figure.
        value: Found, None where there is none: no standstill, no alarm.
        unit: Of it.
        tolerance: How far it may move once it is accepted, for a reason of its own; None for `TOLERANCE` of it.
        repeated: Repeats of the stop, where rounding decides its distance.
        longest_lock: Of any group [s]; None for a figure.
        valve_strokes: Of all groups; None without valves.
    """

    name: str
    value: float | None
    unit: str
    tolerance: float | None = None
    repeated: Repeated | None = None
    longest_lock: float | None = None
    valve_strokes: int | None = None


def mean(name: str, value: float, unit: str = "1") -> Finding:
    """Return a figure that is a mean: another machine's arithmetic moves it by no more than 2 %."""
    return Finding(name, value, unit, 0.02 * abs(value))


def extreme(name: str, value: float, unit: str = "1") -> Finding:
    """Return a figure that is the largest of many: it may move by 10 %."""
    return Finding(name, value, unit, 0.1 * abs(value))


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """The numbers of a result, and the names of those that it should have and has not."""

    values: tuple[Finding, ...]
    missing: tuple[str, ...] = ()


State = Literal["kept", "moved", "new", "gone", "no standstill", "no value"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """One number against its baseline.

    Attributes:
        name: Of the stop or figure.
        state: `kept` inside the tolerance; `moved` outside; `new` without baseline; `gone` without result;
            `no standstill` of a stop that ended otherwise, `no value` of a figure that there is none of.
        accepted: The baseline, None for a new one.
        current: The number, None when gone.
    """

    name: str
    state: State
    accepted: Accepted | AcceptedFigure | None
    current: Finding | None

    @property
    def value(self) -> float | None:
        """Found, if there is such a number."""
        return None if self.current is None else self.current.value

    @property
    def change(self) -> float | None:
        """Found minus accepted."""
        return None if self.accepted is None or self.value is None else self.value - self.accepted.value


def load_baseline(path: Path) -> Baseline:
    """Return a baseline file.

    Raises:
        ScenarioError: Missing, or not a baseline.
    """
    return validated(Baseline, read_toml(path), directory=path.parent, origin=path.name)


def findings_of(results: Results) -> Findings:
    """Return the distances of a campaign; none of a stop that did not end in a standstill."""
    return Findings(values=tuple(map(_finding, results.stops, rows_of(results))), missing=results.missing)


def _finding(result: Result, row: Row) -> Finding:
    conditioning = result.conditioning
    return Finding(
        name=result.name,
        value=row.distance_m,
        unit="m",
        repeated=conditioning if conditioning and conditioning.belongs(result.record.digest, row.distance_m) else None,
        longest_lock=row.longest_lock_s,
        valve_strokes=row.valve_strokes,
    )


def beyond_accepted(results: Results, path: Path) -> list[str]:
    """Return a sentence for each distance with other compilers' FMUs that differs by more than `ACROSS_COMPILERS`.

    None where all FMUs are ours, whose distances `railgrip regress` compares, or there is no such baseline file.
    """
    if not from_elsewhere(results.stops) or not path.is_file():
        return []
    baseline = load_baseline(path)
    known = [stop for stop in results.stops if stop.name in baseline.stops and from_elsewhere([stop])]
    findings = findings_of(replace(results, stops=tuple(known)))
    return [
        f"{one.name}: {one.value:.2f} m by FMUs of another compiler, {baseline.stops[one.name].distance:.2f} m is "
        f"accepted, {one.value / baseline.stops[one.name].distance - 1:+.1%}."
        for one in compare(baseline.across_compilers(), findings)
        if one.state == "moved" and one.value is not None
    ]


def write_findings(findings: Findings, directory: Path) -> None:
    """Keep the figures of a study where `read_findings` finds them."""
    write_json(directory / FINDINGS_FILE, [asdict(finding) for finding in findings.values])


def read_findings(directory: Path) -> Findings:
    """Return the figures of the last study that was written into a folder.

    Raises:
        RecordError: There are none, or they cannot be read.
    """
    path = directory / FINDINGS_FILE
    try:
        return Findings(values=tuple(Finding(**finding) for finding in json.loads(path.read_text(encoding="utf-8"))))
    except FileNotFoundError as problem:
        raise RecordError(f"{path}: there is no such file; `railgrip regress` makes one") from problem
    except (OSError, ValueError, TypeError) as problem:
        raise RecordError(f"{path}: is not the figures of a study ({problem})") from problem


def compare(baseline: Baseline, findings: Findings) -> tuple[Comparison, ...]:
    """Return every number of baseline and findings, those that need attention first."""
    current = {finding.name: finding for finding in findings.values}
    comparisons = [
        Comparison(
            name=name,
            state=_state(baseline.accepted.get(name), current.get(name), of_stops=baseline.campaign is not None),
            accepted=baseline.accepted.get(name),
            current=current.get(name),
        )
        for name in dict.fromkeys([*current, *baseline.accepted])
    ]
    return tuple(sorted(comparisons, key=lambda comparison: comparison.state == "kept"))


def accepted(baseline: Baseline, findings: Findings, reason: str) -> Baseline:
    """Return the baseline with what moved, appeared or went brought up to date, for a reason.

    Numbers inside their tolerance keep value and reason. The tolerance of one that moved scales with it, unless it has
    one of its own.

    Raises:
        ScenarioError: No reason is given, or there is no number, which nobody can accept.
    """
    if not reason.strip():
        raise ScenarioError("accept: --reason is empty; say what changed and why the new numbers are right")
    stops: dict[str, Accepted] = {}
    figures: dict[str, AcceptedFigure] = {}
    for comparison in compare(baseline, findings):
        name, before, finding = comparison.name, comparison.accepted, comparison.current
        if finding is None:
            if name in findings.missing:
                raise ScenarioError(f"accept: {name} has no result; run the campaign first")
            continue
        if finding.value is None:
            if baseline.campaign is not None:
                raise ScenarioError(f"accept: {name} did not come to a standstill; a baseline is a distance")
            raise ScenarioError(f"accept: {name} has no value; a baseline is a number")
        old = before if comparison.state == "kept" else None
        if baseline.campaign is not None:
            # A number that turns out to be a range, or no longer to be one, is accepted anew.
            spreads = finding.repeated is not None and finding.repeated.spreads
            stop = (
                old
                if isinstance(old, Accepted) and (old.is_range == spreads or finding.repeated is None)
                else _accepted_stop(finding, finding.value, before, reason)
            )
            beside = {
                "longest_lock": None if finding.longest_lock is None else round(finding.longest_lock, 3),
                "valve_strokes": finding.valve_strokes,
            }
            stops[name] = stop.model_copy(update=beside)
        else:
            tolerance = finding.tolerance or TOLERANCE * abs(finding.value)
            figures[name] = (
                old
                if isinstance(old, AcceptedFigure)
                else AcceptedFigure(
                    value=_digits(finding.value, 4),
                    tolerance=_digits(tolerance, 2),
                    unit=finding.unit,
                    reason=reason.strip(),
                )
            )
    return baseline.model_copy(update={"stops": stops, "figures": figures})


def _accepted_stop(
    finding: Finding, distance: float, before: Accepted | AcceptedFigure | None, reason: str
) -> Accepted:
    compilers = before.compilers if isinstance(before, Accepted) else {}
    if finding.repeated is not None and finding.repeated.spreads:
        return Accepted(
            distance=round(finding.repeated.median, 3),
            tolerance=_digits(finding.repeated.margin, 2),
            lowest=finding.repeated.lowest,
            highest=finding.repeated.highest,
            reason=reason.strip(),
            compilers=compilers,
        )
    is_number = before is not None and before.ends[0] == before.ends[1]
    relative = before.tolerance / before.value if before and is_number else TOLERANCE
    return Accepted(
        distance=round(distance, 3),
        tolerance=_digits(relative * distance, 2),
        reason=reason.strip(),
        compilers=compilers,
    )


_BESIDE = {"lowest", "highest", "longest_lock", "valve_strokes"}


def write_baseline(baseline: Baseline, path: Path) -> None:
    """Write a baseline file, its numbers in the order of their names."""
    if baseline.campaign is not None:
        lines = [f"campaign = {json.dumps(baseline.campaign)}"]
    else:
        lines = [f"study = {json.dumps(baseline.study)}"]
    for name, stop in sorted(baseline.stops.items()):
        lines += [
            "",
            f"[stops.{json.dumps(name)}]",
            f"distance = {stop.distance!r}  # m",
            f"tolerance = {stop.tolerance!r}  # m",
            *(f"{name} = {value!r}" for name, value in stop.model_dump(include=_BESIDE, exclude_none=True).items()),
            f"reason = {json.dumps(stop.reason, ensure_ascii=False)}",
            *([f"compilers = {_inline(stop.compilers)}  # m"] if stop.compilers else []),
        ]
    for name, figure in sorted(baseline.figures.items()):
        lines += [
            "",
            f"[figures.{json.dumps(name, ensure_ascii=False)}]",
            f"value = {figure.value!r}",
            f"tolerance = {figure.tolerance!r}",
            f"unit = {json.dumps(figure.unit, ensure_ascii=False)}",
            f"reason = {json.dumps(figure.reason, ensure_ascii=False)}",
        ]
    write_text(path, "\n".join(lines) + "\n")


def comparison_table(comparisons: Sequence[Comparison], title: str = "") -> table.Table:
    """Return the comparison; in metres where all are distances, else with a column of units."""
    units = [(c.accepted or c.current).unit for c in comparisons if c.accepted or c.current]  # pyright: ignore[reportOptionalMemberAccess]
    metres = set(units) <= {"m"}
    form, behind = ("{:.2f}", " [m]") if metres else ("{:.4g}", "")
    rows = [
        {
            "stop" if metres else "figure": one.name,
            "state": one.state,
            f"accepted{behind}": _value_and_range(one.accepted, form),
            f"found{behind}": one.value,
            f"change{behind}": one.change,
            f"tolerance{behind}": one.accepted.tolerance if one.accepted else None,
        }
        | ({} if metres else {"unit": unit})
        for one, unit in zip(comparisons, units, strict=True)
    ]
    forms = {f"found{behind}": form, f"tolerance{behind}": form, f"change{behind}": "{:+.3f}" if metres else "{:+.2g}"}
    return table.Table(rows, forms, title=title)


def _value_and_range(before: Accepted | AcceptedFigure | None, form: str) -> str:
    """Return what is accepted, with its range where it has one."""
    if before is None:
        return ""
    lowest, highest = before.ends
    range_ = "" if lowest == highest else f" ({form.format(lowest)} – {form.format(highest)})"
    return form.format(before.value) + range_


def _state(before: Accepted | AcceptedFigure | None, finding: Finding | None, *, of_stops: bool) -> State:
    if finding is None:
        return "gone"
    if finding.value is None:
        return "no standstill" if of_stops else "no value"
    if before is None:
        return "new"
    lowest, highest = before.ends
    return "kept" if lowest - before.tolerance <= finding.value <= highest + before.tolerance else "moved"


def _inline(table: Mapping[str, float]) -> str:
    return f"{{ {', '.join(f'{json.dumps(key)} = {value!r}' for key, value in table.items())} }}"


def _digits(value: float, count: int) -> float:
    """Return a number with so many digits that count."""
    return round(value, count - 1 - math.floor(math.log10(abs(value)))) if value else 0.0
