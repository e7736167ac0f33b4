"""Compare two or more results: differences of the scenarios, of the figures, and along the track."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from string import ascii_uppercase
from typing import TYPE_CHECKING, Any, Self

import xarray

from railgrip.base.errors import RecordError
from railgrip.base.names import ElementName
from railgrip.base.units import cut, short
from railgrip.report.page import Page
from railgrip.report.results import Results, provenance, read_results
from railgrip.report.stop import (
    CAMPAIGN_FILE,
    STOP_FILE,
    Stop,
    others_like,
    read_stop,
    require_no_result,
)
from railgrip.report.table import Form, ReportTable, percent, text
from railgrip.scenario.keys import units_of_keys
from railgrip.scenario.outcome import Outcome
from railgrip.trace.loss import Loss, SectionLoss, course_of, loss
from railgrip.trace.metrics import FIGURES, Metrics

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KMH = 3.6
_ALIKE = "several"
_MISSING = "–"
_LONGEST_TEXT = 40
_MAX_DIGESTS = 20
"""Maximum number of stops of campaigns whose digests the page lists."""
_FIGURE = "figures/comparison.png"


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonSide:
    """A stop to compare.

    Attributes:
        name: Folder of its result, or the name of its scenario.
        trace: Samples, or None if they were not kept.
    """

    name: str
    stop: Stop
    trace: xarray.Dataset | None

    @classmethod
    def of(cls, stop: Stop, name: str) -> Self:
        """Return a stop as a side; its trace is read if it was kept."""
        return cls(name=name, stop=stop, trace=stop.trace if stop.has_trace else None)

    @property
    def question(self) -> dict[str, Any]:
        """All inputs of the stop by key: scenario, versions, FMUs and classes."""
        return question_of(self.stop) | {"scenario digest": self.stop.digest}

    @property
    def headline(self) -> str:
        """Outcome and distance, for readers."""
        metrics = self.stop.metrics
        return f"{self.stop.outcome.value}, {metrics.distance_travelled:.2f} m in {metrics.duration:.2f} s"


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Comparison:
    """Differences between results.

    Attributes:
        names: Names of the results, in the order of their letters A, B …
        headlines: Outcome of each result, for readers.
        question: Keys that differ, with a column for each letter.
        answer: Figures that differ or, for campaigns, their stops, with the differences to A.
        overview: As `answer`, with the mean over all groups, wheelsets or classes of a figure in one row.
        along: Letter → distance that this stop loses against A along the track.
        sentences: Summary.
        differences: Name of a stop of campaigns → difference of its distances [m].
        provenance: Seeds, digests and versions of each letter.
    """

    names: Sequence[str]
    headlines: Sequence[str]
    question: ReportTable
    answer: ReportTable
    overview: ReportTable
    along: Mapping[str, Loss] = field(default_factory=dict[str, Loss])
    sentences: Sequence[str] = ()
    differences: Mapping[str, float] = field(default_factory=dict[str, float])
    provenance: Mapping[str, str] = field(default_factory=dict[str, str])

    @property
    def letters(self) -> str:
        """A letter for each result."""
        return ascii_uppercase[: len(self.names)]

    @property
    def sections(self) -> dict[str, ReportTable]:
        """Letter → table of the distance lost in each section of the track."""
        return {letter: _sections(letter, lost) for letter, lost in self.along.items()}

    def to_plain(self) -> dict[str, Any]:
        """Return everything as JSON values."""
        return {
            "results": dict(zip(self.letters, self.names, strict=True)),
            "headlines": dict(zip(self.letters, self.headlines, strict=True)),
            "sentences": list(self.sentences),
            "question": list(self.question.rows),
            "answer": list(self.answer.rows),
            "track": {letter: list(table.rows) for letter, table in self.sections.items()},
        }

    def __repr__(self) -> str:
        results = (f"{letter}: {name}: {line}" for letter, name, line in self._results())
        return "\n".join([*results, *self.sentences])

    def _repr_html_(self) -> str:
        parts = (self.question, self.overview, *self.sections.values())
        return f"<pre>{self!r}</pre>" + "".join(part.__html__() for part in parts if part)

    def _results(self) -> list[tuple[str, str, str]]:
        return list(zip(self.letters, self.names, self.headlines, strict=True))

    def plot(self) -> "Figure":
        """Return a figure of speeds and of the distance lost along the track.

        For campaigns the figure has the differences of the stops.
        """
        from railgrip.report.comparison_figure import stops_figure, track_figure  # matplotlib takes half a second

        return track_figure(self.along) if self.along else stops_figure(self.differences)

    def page(self) -> Page:
        """Return the page of the comparison."""
        rows = zip(self.letters, self.names, self.headlines, strict=True)
        results = ReportTable.of(("", "result", "outcome"), rows, left=3)
        names = [Path(name).name for name in self.names]
        if len(set(names)) < len(names):
            names = list(self.names)
        return Page(
            title=f"Comparison of {', '.join(names[:-1])} and {names[-1]}",
            question="In what do these results differ, and where along the track does the difference arise?",
            answer=" ".join(self.sentences[:2]) or "They do not differ.",
            template="report/comparison.md.jinja",
            provenance=self.provenance,
            values={
                "results": results,
                "sentences": self.sentences[2:],
                "question": self.question,
                "overview": self.overview,
                "answer": None if self.answer is self.overview else self.answer,
                "sections": self.sections,
            },
            figures={_FIGURE: self.plot()} if self.along or self.differences else {},
            data={"comparison.json": self.to_plain()},
            screen=[results, self.question, self.overview, *self.sections.values(), *self.sentences],
        )

    def write(self, folder: Path | str) -> Path:
        """Write index.html and comparison.json to a folder; return the path of the page.

        Raises:
            RecordError: The folder is that of a stop or campaign.
        """
        require_no_result(Path(folder))
        return self.page().write(Path(folder))


Comparable = Stop | str | Path
"""A stop, or the folder of a run, of a stop in a campaign, or of a campaign."""


def compare(*results: Comparable) -> Comparison:
    """Compare results with the first of them.

    Raises:
        RecordError: There are fewer than two or more than 26 results, a folder without one, or both stops and
            campaigns.
    """
    if not 2 <= len(results) <= len(ascii_uppercase):
        raise RecordError(
            f"compare: expects two to {len(ascii_uppercase)} results, got {len(results)}; name their folders"
        )
    campaigns = [_is_campaign(result) for result in results]
    if any(campaigns) and not all(campaigns):
        stop = results[campaigns.index(False)]
        campaign = results[campaigns.index(True)]
        raise RecordError(
            f"compare: {campaign} holds a campaign and {stop if not isinstance(stop, Stop) else 'another is'} a stop; "
            f"name a stop of the campaign, as {campaign}/NAME"
        )
    if all(campaigns):
        return _of_campaigns(
            [str(result) for result in results], [read_results(Path(str(result))) for result in results]
        )
    return _of_stops([_side(result) for result in results])


def flat(table: Mapping[str, Any], path: str = "") -> dict[str, Any]:
    """Return the values of nested tables by dotted keys; elements of a list of tables are counted from 1."""
    keys: dict[str, Any] = {}
    for name, value in table.items():
        if isinstance(value, Mapping):
            keys |= flat(value, f"{path}{name}.")
        elif isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
            for number, item in enumerate(value, start=1):
                keys |= flat(item, f"{path}{name}[{number}].")
        elif value is not None:
            keys[f"{path}{name}"] = value
    return keys


def question_of(stop: Stop) -> dict[str, Any]:
    """Return all inputs of a stop by key: scenario, versions, FMUs and classes."""
    return flat(stop.inputs) | flat({"versions": stop.versions, "fmus": stop.fmus, "classes": stop.classes})


def _is_campaign(result: Any) -> bool:
    if isinstance(result, Stop):
        return False
    if not isinstance(result, str | Path):
        raise RecordError(f"compare: {short(result)} is neither a stop nor the folder of a result")
    folder = Path(result)
    if (folder / CAMPAIGN_FILE).exists():
        return True
    if folder.name != STOP_FILE and not (folder / STOP_FILE).exists():
        like = others_like(folder) or "; name the folder of a run, of a stop in a campaign, or of a campaign"
        raise RecordError(f"{folder}: has neither {STOP_FILE} nor {CAMPAIGN_FILE}{like}")
    return False


def _side(result: Comparable) -> ComparisonSide:
    if isinstance(result, Stop):
        return ComparisonSide.of(result, result.scenario.name)
    folder = Path(result)
    folder = folder.parent if folder.name == STOP_FILE else folder
    return ComparisonSide.of(read_stop(folder), str(folder))


# ---- stops ------------------------------------------------------------------------------------------------------


def _of_stops(sides: Sequence[ComparisonSide]) -> Comparison:
    letters = ascii_uppercase[: len(sides)]
    along: dict[str, Loss] = {}
    without = [side.name for side in sides if side.trace is None]
    if sides[0].trace is not None:
        courses = {
            letter: course_of(side.trace, is_standstill=side.stop.outcome is Outcome.STANDSTILL)
            for letter, side in zip(letters, sides, strict=True)
            if side.trace is not None
        }
        along = {letter: loss(courses["A"], courses[letter]) for letter in courses if letter != "A"}
    stops = [side.stop for side in sides]
    sentences = [_distance_sentence(letters[i], stops[0], stops[i]) for i in range(1, len(stops))]
    sentences += [sentence for letter, lost in along.items() for sentence in _where(letter, lost)]
    if without:
        sentences.append(f"Where along the track is not known: no samples were kept of {', '.join(without)}.")
    return Comparison(
        names=[side.name for side in sides],
        headlines=[side.headline for side in sides],
        question=_question([side.question for side in sides]),
        answer=_answer(sides, Metrics.flat, "Figures of each group and wheelset"),
        overview=_answer(sides, _means, "Differences of the results"),
        along=along,
        sentences=sentences,
        provenance={
            f"{letter}, {key}": value
            for letter, stop in zip(letters, stops, strict=True)
            for key, value in provenance(stop).items()
        },
    )


def _distance_sentence(letter: str, first: Stop, other: Stop) -> str:
    before, after = first.braking_distance, other.braking_distance
    if before is None or after is None:
        missing = ", ".join(
            f"{name} ended with {result.outcome.value}"
            for name, result in (("A", first), (letter, other))
            if result.braking_distance is None
        )
        return f"{letter} against A: no difference of braking distances, for {missing}."
    change = f"{text(after - before, '{:+.2f} m')}, {percent(after / before - 1)}"
    return f"{letter} stops in {after:.2f} m, A in {before:.2f} m: {change}."


def _where(letter: str, lost: Loss) -> list[str]:
    sections = sorted(lost.sections, key=lambda section: -abs(section.lost))
    sentences: list[str] = []
    if abs(lost.at_start) >= 0.005:
        sentences.append(f"{letter} saves {-lost.at_start:.2f} m because it starts more slowly than A.")
    for section in sections[:3]:
        if abs(section.lost) < 0.005:
            break
        other = section.deceleration_of_first
        slows = (
            "is faster than A ever was"
            if math.isnan(other)
            else f"slows by {section.deceleration:.2f} m/s², A by {other:.2f} m/s² at the same speeds"
        )
        sentences.append(
            f"{letter} {'loses' if section.lost > 0 else 'gains'} {abs(section.lost):.2f} m from {section.begin:.0f} m "
            f"to {section.end:.0f} m (entered at {section.time:.1f} s, {KMH * section.speed:.0f} km/h): it {slows}."
        )
    return sentences


def _sections(letter: str, lost: Loss) -> ReportTable:
    def row(section: SectionLoss) -> dict[str, Any]:
        return {
            "from [m]": section.begin,
            "to [m]": section.end,
            "at [s]": section.time,
            "speed [km/h]": KMH * section.speed,
            "lost [m]": section.lost,
            "so far [m]": section.so_far,
            f"deceleration {letter} [m/s²]": section.deceleration,
            "of A at the same speeds [m/s²]": section.deceleration_of_first,
        }

    forms = dict.fromkeys(("from [m]", "to [m]"), "{:.0f}") | dict.fromkeys(("at [s]", "speed [km/h]"), "{:.1f}")
    forms |= dict.fromkeys(("lost [m]", "so far [m]"), "{:+.2f}")
    forms |= dict.fromkeys((f"deceleration {letter} [m/s²]", "of A at the same speeds [m/s²]"), "{:.3f}")
    return ReportTable(
        [row(section) for section in lost.sections], forms, (), f"Distance that {letter} loses against A"
    )


def _question(questions: Sequence[Mapping[str, Any]]) -> ReportTable:
    letters = ascii_uppercase[: len(questions)]
    keys = dict.fromkeys(key for question in questions for key in question)
    rows = [
        {
            "key": key,
            **{letter: _value(question.get(key)) for letter, question in zip(letters, questions, strict=True)},
            "unit": unit,
        }
        for key in keys
        if any(question.get(key) != questions[0].get(key) for question in questions)
        for unit in [unit_of(key)]
    ]
    return ReportTable(rows, left=("key", *letters, "unit"), title="Differences of the scenarios")


def unit_of(key: str) -> str:
    """Return the SI unit of a key of a scenario, as `flat` writes it; empty for a ratio or text."""
    unit = units_of_keys().get(without_numbers(key), "")
    return "" if unit == "1" else unit


def without_numbers(key: str) -> str:
    """Return a key of a scenario, as `flat` writes it, without the numbers of tables in lists."""
    return re.sub(r"\[[^\]]*\]", "", key)


def _value(value: Any) -> str:
    if value is None:
        return _MISSING
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return cut(", ".join(_value(item) for item in value), _LONGEST_TEXT)
    text_ = str(value)
    return f"{text_[:8]}…" if len(text_) == 64 and text_.isalnum() else cut(text_, 80)


def _answer(
    sides: Sequence[ComparisonSide], figures_of: Callable[[Metrics], Mapping[str, float]], title: str
) -> ReportTable:
    letters = ascii_uppercase[: len(sides)]
    figures = [figures_of(side.stop.figures) for side in sides]
    rows: list[dict[str, Any]] = []
    if len({side.stop.outcome for side in sides}) > 1:
        rows.append(_row("outcome", [side.stop.outcome.value for side in sides], "", letters))
    for name in dict.fromkeys(name for figure in figures for name in figure):
        unit = FIGURES[re.split(r"\[|, ", name)[0]].unit_text
        values = [float(figure.get(name, math.nan)) for figure in figures]
        if any(value != values[0] and not (math.isnan(value) and math.isnan(values[0])) for value in values):
            rows.append(_row(name, values, unit, letters))
    numbers = [column for column in (rows[0] if rows else ()) if column not in ("figure", "unit")]
    forms: dict[str, Form] = {
        column: "{:+.4g}" if column.endswith(" − A") else "{:+.1f}" if "%" in column else "{:.5g}" for column in numbers
    }
    return ReportTable(rows, forms, ("figure", "unit"), title)


def _row(name: str, values: Sequence[Any], unit: str, letters: str) -> dict[str, Any]:
    row: dict[str, Any] = {"figure": name} | dict(zip(letters, values, strict=True))
    for letter, value in zip(letters[1:], values[1:], strict=True):
        is_number = not isinstance(value, str)
        row[f"{letter} − A"] = value - values[0] if is_number else math.nan
        row[f"{letter} − A [%]"] = 100 * (value / values[0] - 1) if is_number and values[0] > 0 else math.nan
    return row | {"unit": unit}


def _means(metrics: Metrics) -> dict[str, float]:
    """Return figure → value, for arrays the mean; histograms are omitted, as their mean has no meaning."""
    elements: dict[str, list[float]] = {}
    for name, value in metrics.flat().items():
        if name.count("[") < 2:
            elements.setdefault(ElementName.of(name).array, []).append(value)
    figures: dict[str, float] = {}
    for name, values in elements.items():
        known = [value for value in values if not math.isnan(value)]
        called = name if len(values) == 1 else f"{name}, mean of {len(values)}"
        figures[called] = sum(known) / len(known) if known else math.nan
    return figures


# ---- campaigns --------------------------------------------------------------------------------------------------


def _of_campaigns(names: Sequence[str], results: Sequence[Results]) -> Comparison:
    letters = ascii_uppercase[: len(names)]
    stops = [{stop.name: stop for stop in result.stops} for result in results]
    common = [name for name in stops[0] if all(name in stop for stop in stops)]
    if not common:
        raise RecordError(f"compare: {' and '.join(names)} have no stop of the same name")
    differences = {
        name: b - a
        for name in common
        if (a := stops[0][name].braking_distance) is not None and (b := stops[1][name].braking_distance) is not None
    }
    only = [
        f"Only {letter} has {len(lacking)} stops, {', '.join(lacking[:3])}{' …' if len(lacking) > 3 else ''}."
        for letter, stop in zip(letters, stops, strict=True)
        if (lacking := [name for name in stop if name not in common])
    ]
    distances = _distances(common, stops)
    return Comparison(
        names=names,
        headlines=[f"campaign {result.name}, {len(result.stops)} stops" for result in results],
        question=_common_question([[stop[name] for stop in stops] for name in common]),
        answer=distances,
        overview=distances,
        sentences=[*_change_sentences(letters, common, stops), *only],
        differences=differences,
        provenance={
            f"{letter}, result of {name}": provenance(stop[name])["scenario digest"]
            for letter, stop in zip(letters, stops, strict=True)
            for name in common[:_MAX_DIGESTS]
        },
    )


def _distances(common: Sequence[str], stops: Sequence[Mapping[str, Stop]]) -> ReportTable:
    letters = ascii_uppercase[: len(stops)]
    rows: list[dict[str, Any]] = []
    for name in common:
        compared = [stop[name] for stop in stops]
        first = compared[0].braking_distance
        row: dict[str, Any] = {"stop": name}
        row |= {
            f"{letter} [m]": stop.outcome.value if stop.braking_distance is None else stop.braking_distance
            for letter, stop in zip(letters, compared, strict=True)
        }
        for letter, stop in zip(letters[1:], compared[1:], strict=True):
            other, difference, share = stop.braking_distance, math.nan, math.nan
            if first is not None and other is not None:
                difference, share = other - first, 100 * (other / first - 1)
            row |= {f"{letter} − A [m]": difference, f"{letter} − A [%]": share}
        rows.append(row)
    forms = {f"{letter} [m]": "{:.2f}" for letter in letters}
    forms |= {f"{letter} − A [m]": "{:+.2f}" for letter in letters[1:]}
    forms |= {f"{letter} − A [%]": "{:+.1f}" for letter in letters[1:]}
    return ReportTable(rows, forms, ("stop",), "Braking distances")


def _change_sentences(letters: str, common: Sequence[str], stops: Sequence[Mapping[str, Stop]]) -> list[str]:
    """Return a sentence for each further campaign on the differences of all distances."""
    sentences: list[str] = []
    for letter, stop in zip(letters[1:], stops[1:], strict=True):
        pairs = {name: (stops[0][name].braking_distance, stop[name].braking_distance) for name in common}
        changes = sorted((b / a - 1, name) for name, (a, b) in pairs.items() if a is not None and b is not None)
        if not changes:
            sentences.append(f"{letter} against A: no stop came to a standstill in both.")
            continue
        longer = sum(change > 0 for change, _ in changes)
        shorter = sum(change < 0 for change, _ in changes)
        (least, best), (median, _), (most, worst) = changes[0], changes[len(changes) // 2], changes[-1]
        sentences.append(
            f"{letter} against A over {len(changes)} stops: {longer} longer, {shorter} shorter, median "
            f"{percent(median)}, from {percent(least)} ({best}) to {percent(most)} ({worst})."
        )
        different = [name for name in common if stops[0][name].outcome is not stop[name].outcome]
        if different:
            sentences.append(f"Other outcomes in {letter}: {', '.join(different[:8])}.")
    return sentences


def _common_question(pairs: Sequence[Sequence[Stop]]) -> ReportTable:
    """Return the keys that differ in some of the stops, with their number, and the values that all of these share."""
    letters = ascii_uppercase[: len(pairs[0])]
    rows: dict[str, dict[str, Any]] = {}
    for pair in pairs:
        for row in _question([question_of(stop) for stop in pair]).rows:
            known = rows.setdefault(row["key"], dict(row) | {"stops": 0})
            known["stops"] += 1
            for letter in letters:
                if known[letter] != row[letter]:
                    known[letter] = _ALIKE
    return ReportTable(list(rows.values()), left=("key", *letters, "unit"), title="Differences of the scenarios")
