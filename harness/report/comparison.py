"""Compare two or more results: differences of the scenarios, of the figures, and along the track."""

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from string import ascii_uppercase
from typing import TYPE_CHECKING, Any

import pandas

from railgrip.base.errors import RecordError
from railgrip.base.files import path_of
from railgrip.base.names import ElementName
from railgrip.base.tables import JsonObject
from railgrip.base.units import cut, short
from railgrip.report.distribution import change_text
from railgrip.report.frame import Frame
from railgrip.report.page import Page
from railgrip.report.results import provenance, read_results
from railgrip.report.statistics import relative_change
from railgrip.report.stop import STOP_FILE, Stop, is_campaign, read_stop, require_no_result
from railgrip.report.table import ReportTable, percent, percent_or_endless, text
from railgrip.scenario.keys import units_of_keys
from railgrip.scenario.outcome import Outcome
from railgrip.trace.measures import Loss, course_of, loss
from railgrip.trace.metrics import FIGURES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KMH = 3.6
_SEVERAL = "several"
_MISSING = "–"
_LONGEST_TEXT = 40
_MAX_DIGESTS = 20
"""Maximum number of stops of campaigns whose digests the page lists."""
_FIGURE = "figures/comparison.png"

Stops = Mapping[str, Stop]
"""Letter → stop; A is the first one, with which the others are compared."""


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
        distances: Distances [m] of the stops of campaigns that can be compared, which are its rows, with a column for
            each letter.
        provenance: Seeds, digests and versions of each letter.
    """

    names: Sequence[str]
    headlines: Sequence[str]
    question: ReportTable
    answer: ReportTable
    overview: ReportTable
    along: Mapping[str, Loss] = field(default_factory=dict[str, Loss])
    sentences: Sequence[str] = ()
    distances: Frame = field(default_factory=pandas.DataFrame)
    provenance: Mapping[str, str] = field(default_factory=dict[str, str])

    @property
    def letters(self) -> str:
        """A letter for each result."""
        return ascii_uppercase[: len(self.names)]

    @property
    def sections(self) -> dict[str, ReportTable]:
        """Letter → table of the distance lost in each section of the track."""
        return {letter: _sections(letter, lost) for letter, lost in self.along.items()}

    @property
    def results(self) -> ReportTable:
        """Letter, name and outcome of each result."""
        rows = zip(self.letters, self.names, self.headlines, strict=True)
        return ReportTable.of(("", "result", "outcome"), rows, left=3)

    def to_plain(self) -> JsonObject:
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
        return "\n".join([*(": ".join(row.values()) for row in self.results.rows), *self.sentences])

    def _repr_html_(self) -> str:
        parts = (self.question, self.overview, *self.sections.values())
        return f"<pre>{self!r}</pre>" + "".join(part.__html__() for part in parts if part)

    def plot(self) -> "Figure":
        """Return a figure of speeds and of the distance lost along the track.

        For campaigns the figure has the distances of the stops, and their differences.
        """
        # matplotlib takes half a second to load.
        from railgrip.report.campaign_figures import stops_figure
        from railgrip.report.figures import track_figure

        return track_figure(self.along) if self.along else stops_figure(self.distances)

    def page(self) -> Page:
        """Return the page of the comparison."""
        results = self.results
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
            figures={_FIGURE: self.plot()} if self.along or len(self.distances) else {},
            data={"comparison.json": self.to_plain()},
            screen=[results, self.question, self.overview, *self.sections.values(), *self.sentences],
        )

    def write(self, folder: Path | str) -> Path:
        """Write index.html and comparison.json to a folder; return the path of the page.

        Raises:
            RecordError: The folder is that of a stop or campaign.
        """
        require_no_result(directory := path_of(folder, "folder"))
        return self.page().write(directory)


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
        return _compare_campaigns([str(result) for result in results])
    stops = [result if isinstance(result, Stop) else read_stop(_folder(result)) for result in results]
    names = [result.scenario.name if isinstance(result, Stop) else str(_folder(result)) for result in results]
    return _compare_stops(names, dict(zip(ascii_uppercase, stops, strict=False)))


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


def question_of(stop: Stop) -> dict[str, object]:
    """Return all inputs of a stop by key: scenario, versions, FMUs and classes."""
    return flat(stop.inputs) | flat({"versions": stop.versions, "fmus": stop.fmus, "classes": stop.classes})


def _is_campaign(result: Any) -> bool:
    if isinstance(result, Stop):
        return False
    if not isinstance(result, str | Path):
        raise RecordError(f"compare: {short(result)} is neither a stop nor the folder of a result")
    return Path(result).name != STOP_FILE and is_campaign(Path(result))


def _folder(result: str | Path) -> Path:
    return Path(result).parent if Path(result).name == STOP_FILE else Path(result)


def _with_differences(values: Frame, unit: str = "") -> Frame:
    """Return numbers in columns A, B …, followed by the differences from A, absolute and in percent of a positive A.

    Args:
        values: Numbers; NaN where one is missing.
        unit: Text behind the names of the columns, as " [m]".
    """
    columns = {f"{letter}{unit}": values[letter] for letter in values}
    for letter in values.columns[1:]:
        columns[f"{letter} − A{unit}"] = values[letter] - values["A"]
        columns[f"{letter} − A [%]"] = 100 * (values[letter] / values["A"].where(values["A"] > 0) - 1)
    return pandas.DataFrame(columns)


# ---- stops ------------------------------------------------------------------------------------------------------


def _compare_stops(names: Sequence[str], stops: Stops) -> Comparison:
    along: dict[str, Loss] = {}
    if stops["A"].has_trace:
        first, *others = (
            (letter, course_of(stop.trace, is_standstill=stop.outcome is Outcome.STANDSTILL))
            for letter, stop in stops.items()
            if stop.has_trace
        )
        along = {letter: loss(first[1], course) for letter, course in others}
    sentences = [_distance_sentence(letter, stops["A"], stop) for letter, stop in stops.items() if letter != "A"]
    sentences += [sentence for letter, lost in along.items() for sentence in _where(letter, lost)]
    if without := [name for name, stop in zip(names, stops.values(), strict=True) if not stop.has_trace]:
        sentences.append(f"Where along the track is not known: no samples were kept of {', '.join(without)}.")
    figures = {letter: stop.figures.flat() for letter, stop in stops.items()}
    return Comparison(
        names=names,
        headlines=[
            f"{stop.outcome.value}, {stop.metrics.distance_travelled:.2f} m in {stop.metrics.duration:.2f} s"
            for stop in stops.values()
        ],
        question=_question(
            {letter: question_of(stop) | {"scenario digest": stop.digest} for letter, stop in stops.items()}
        ),
        answer=_answer(stops, figures, "Figures of each group and wheelset"),
        overview=_answer(stops, _means(figures), "Differences of the results"),
        along=along,
        sentences=sentences,
        provenance={
            f"{letter}, {key}": value for letter, stop in stops.items() for key, value in provenance(stop).items()
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
    sentences: list[str] = []
    if abs(lost.at_start) >= 0.005:
        sentences.append(f"{letter} saves {-lost.at_start:.2f} m because it starts more slowly than A.")
    sections = lost.sections[lost.sections["lost"].abs() >= 0.005]
    for section in sections.sort_values("lost", key=lambda lost: -abs(lost), kind="stable").head(3).itertuples():
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
    columns = (
        *("from [m]", "to [m]", "at [s]", "speed [km/h]", "lost [m]", "so far [m]"),
        *(f"deceleration {letter} [m/s²]", "of A at the same speeds [m/s²]"),
    )
    forms = (form for form in ("{:.0f}", "{:.1f}", "{:+.2f}", "{:.3f}") for _ in range(2))
    rows = lost.sections.assign(speed=KMH * lost.sections["speed"]).itertuples(index=False)
    title = f"Distance that {letter} loses against A"
    return ReportTable.of(dict(zip(columns, forms, strict=True)), rows, left=0, title=title)


def _question(questions: Mapping[str, Mapping[str, Any]]) -> ReportTable:
    """Return the keys that differ; `questions` has all keys and values by letter."""
    keys = dict.fromkeys(key for question in questions.values() for key in question)
    rows = [
        {"key": key, **{letter: _value(of.get(key)) for letter, of in questions.items()}, "unit": unit_of(key)}
        for key in keys
        if any(of.get(key) != questions["A"].get(key) for of in questions.values())
    ]
    return ReportTable(rows, left=("key", *questions, "unit"), title="Differences of the scenarios")


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


def _answer(stops: Stops, by_letter: Mapping[str, Mapping[str, float]], title: str) -> ReportTable:
    """Return the figures that differ with their units, and the outcomes if they do; `by_letter` has those of stops."""
    names = dict.fromkeys(name for figures in by_letter.values() for name in figures)
    figures = pandas.DataFrame(by_letter, index=list(names), dtype=float)
    table = _with_differences(figures[figures.nunique(axis=1, dropna=False) > 1])
    forms = {name: "{:+.4g}" if name.endswith(" − A") else "{:+.1f}" if "%" in name else "{:.5g}" for name in table}
    table["unit"] = [FIGURES[re.split(r"\[|, ", name)[0]].unit_text for name in table.index]
    outcomes = {letter: stop.outcome.value for letter, stop in stops.items()}
    if len(set(outcomes.values())) > 1:
        first = pandas.DataFrame({**outcomes, "unit": ""}, index=["outcome"], columns=table.columns)
        table = pandas.concat([first, table.astype(object)])
    rows = table.rename_axis("figure").reset_index().to_dict("records")
    return ReportTable(rows, forms, ("figure", "unit"), title)


def _means(figures: Mapping[str, Mapping[str, float]]) -> dict[str, dict[str, float]]:
    """Return figure → value of each stop, by letter; of an array the mean of the elements that all stops have.

    Its label says how many these are. An element is missing (NaN) where it does not exist, as the utilisation of
    isolated wheelsets. A stop that has no element of a figure at all is not considered. Histograms are omitted, as
    their mean has no meaning.
    """
    series = {
        letter: pandas.Series(
            {name: value for name, value in values.items() if name.count("[") < 2}, dtype=float
        ).groupby(lambda name: ElementName.of(str(name)).array, sort=False)
        for letter, values in figures.items()
    }
    missing = {
        name
        for by_figure in series.values()
        for _, of in by_figure
        if of.notna().any()
        for name, value in of.items()
        if math.isnan(value)
    }

    def mean(name: str, of: pandas.Series) -> tuple[str, float]:
        if len(of) == 1:
            return name, float(of.iloc[0])
        common = of[~of.index.isin(missing)]
        count = f"{len(of)}" if len(common) == len(of) else f"{len(common)} of {len(of)}"
        return f"{name}, mean of {count}", float(common.mean())

    return {letter: dict(mean(str(name), of) for name, of in by_figure) for letter, by_figure in series.items()}


# ---- campaigns --------------------------------------------------------------------------------------------------


def _compare_campaigns(names: Sequence[str]) -> Comparison:
    results = dict(zip(ascii_uppercase, [read_results(Path(name)) for name in names], strict=False))
    stops = {letter: {stop.name: stop for stop in result.stops} for letter, result in results.items()}
    common = [name for name in stops["A"] if all(name in of for of in stops.values())]
    if not common:
        raise RecordError(f"compare: {' and '.join(names)} have no stop of the same name")
    pairs = {name: {letter: of[name] for letter, of in stops.items()} for name in common}
    distances = pandas.DataFrame(
        {letter: [of[name].braking_distance for name in common] for letter, of in stops.items()}, common, dtype=float
    )
    only = [
        f"Only {letter} has {len(lacking)} stops, {', '.join(lacking[:3])}{' …' if len(lacking) > 3 else ''}."
        for letter, of in stops.items()
        if (lacking := [name for name in of if name not in pairs])
    ]
    table = _distances(distances, pairs)
    return Comparison(
        names=names,
        headlines=[f"campaign {result.name}, {len(result.stops)} stops" for result in results.values()],
        question=_common_question(pairs),
        answer=table,
        overview=table,
        sentences=[*_change_sentences(distances, pairs), *only],
        distances=distances[distances["A"].notna() & (distances.count(axis=1) > 1)],
        provenance={
            f"{letter}, result of {name}": of[name].digest
            for letter, of in stops.items()
            for name in common[:_MAX_DIGESTS]
        },
    )


def _distances(distances: Frame, pairs: Mapping[str, Stops]) -> ReportTable:
    table = _with_differences(distances, " [m]").astype(object)
    for letter in distances:
        outcomes = [pair[letter].outcome.value for pair in pairs.values()]
        table[f"{letter} [m]"] = table[f"{letter} [m]"].where(distances[letter].notna(), outcomes)
    forms = {name: "{:+.1f}" if "%" in name else "{:+.2f}" if "−" in name else "{:.2f}" for name in table}
    rows = table.rename_axis("stop").reset_index().to_dict("records")
    return ReportTable(rows, forms, ("stop",), "Braking distances")


def _change_sentences(distances: Frame, pairs: Mapping[str, Stops]) -> list[str]:
    """Return a sentence for each further campaign on the differences of all distances; without standstill, infinite."""
    sentences: list[str] = []
    for letter in distances.columns[1:]:
        if (distances[letter] + distances["A"]).isna().all():
            sentences.append(f"{letter} against A: no stop came to a standstill in both.")
            continue
        both = distances[[letter, "A"]].fillna(math.inf).itertuples(index=False)
        changes = pandas.Series([relative_change(*pair) for pair in both], distances.index)
        changes = changes.sort_index().sort_values(kind="stable")
        sentences.append(
            f"{letter} against A over {len(changes)} stops: {(changes > 0).sum()} longer, {(changes < 0).sum()} "
            f"shorter, from {percent_or_endless(changes.iloc[0])} ({changes.index[0]}) to "
            f"{percent_or_endless(changes.iloc[-1])} ({changes.index[-1]}), median {change_text(changes.tolist())}."
        )
        different = [name for name, pair in pairs.items() if pair["A"].outcome is not pair[letter].outcome]
        if different:
            sentences.append(f"Other outcomes in {letter}: {', '.join(different[:8])}.")
    return sentences


def _common_question(pairs: Mapping[str, Stops]) -> ReportTable:
    """Return the keys that differ in some of the stops, with their number, and the values that all of these share."""
    rows, counts = dict[str, dict[str, str]](), Counter[str]()
    letters = next(iter(pairs.values())).keys()
    for pair in pairs.values():
        for row in _question({letter: question_of(stop) for letter, stop in pair.items()}).rows:
            known = rows.setdefault(row["key"], dict(row))
            known |= {letter: _SEVERAL for letter in letters if known[letter] != row[letter]}
            counts[row["key"]] += 1
    found = [row | {"stops": counts[key]} for key, row in rows.items()]
    return ReportTable(found, left=("key", *letters, "unit"), title="Differences of the scenarios")
