"""The stops of a campaign as one table, from which tables, distributions and paired changes are selected."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, isinf, nan
from statistics import median
from typing import Any, Final, Self

import pandas

from railgrip.base.groups import gather
from railgrip.base.tables import JsonObject
from railgrip.report.limits import limits_of
from railgrip.report.reference import controller_of, label, references, setting_of
from railgrip.report.results import Results
from railgrip.report.statistics import endless, relative_change
from railgrip.report.stop import Stop
from railgrip.scenario.campaign import DRAW
from railgrip.scenario.conditioning import SMOOTH, RepeatedDistances
from railgrip.scenario.outcome import Outcome
from railgrip.trace.metrics import FIGURES

Frame = Any
"""A `pandas.DataFrame` or series: pandas has no types that follow a selection or group, so that none are checked."""

SETTING: Final = ("actuation", "sensors", "polach")
PLACE: Final = ("scenario", "case", *SETTING)
"""Columns that are equal for stops whose controllers are compared."""
CONDITIONS: Final = (
    "scenario",
    "case",
    "polach",
    "actuation",
    "sensors",
    "controller",
    "controller_label",
    "estimator",
)

STALE: Final = "stale: other repeats"

VALVES: Final = "pneumatic"
"""Kind of actuation with valves; with the ideal one, reversals of the pressure command are counted."""

IN_TABLES: Final = {name: figure for name, figure in FIGURES.items() if figure.column}
"""Figures that tables of many stops have."""

_COLUMNS: Final = (
    "label", *CONDITIONS, "friction", "draw", "reference", "distance", "repeated", "stated", "other_repeats",
    "duration", "reduction_vs_sbc", "reduction_vs_tuned",
    "stated_vs_sbc", "stated_vs_tuned", "fitted", "utilisation", "paper_distance", "paper_reduction", "outcome",
    "breaks", "adhesion_peak", "longest_lock", "flat_length", "actuations", "air_used", "nis_ratio", "outside", "stop",
)  # fmt: skip

_PLAIN: Final = {
    "stated": "repeats", "distance": "distance_m", "duration": "duration_s", "paper_distance": "paper_distance_m",
    "longest_lock": "longest_lock_s", "flat_length": "flat_length_m", "actuations": "valve_strokes",
    "air_used": "air_l", "nis_ratio": "nis",
}  # fmt: skip
"""Column → its key in JSON, where that differs."""


@dataclass(frozen=True, slots=True)
class StatedDistance:
    """The distance that is stated for a stop next to others: of its only run, or the median of its repeats.

    Attributes:
        distances: Of each run [m], infinite without standstill.
        lock: Longest lock of a wheelset in these runs [s]; NaN if unknown.
        are_lots: Whether runs are of lots of sensors, the same ones for all controllers.
    """

    distances: Sequence[float]
    lock: float = nan
    are_lots: bool = False

    @classmethod
    def of(cls, stop: Stop) -> Self:
        """Return the distance over lots of sensors if there are any, else over repeats that depend on rounding."""
        repeats = stop.own_repeats
        if repeats is None or not (repeats.lots or repeats.spreads):
            return cls((endless(stop.braking_distance),), max(stop.metrics.longest_lock))
        if repeats.lots:
            return cls(repeats.lots, are_lots=True)
        return cls(repeats.distances, max(repeats.figures.get("longest_lock", ()), default=nan))

    @property
    def median(self) -> float:
        """Median distance [m]."""
        return median(self.distances)

    @property
    def ends(self) -> tuple[float, float] | None:
        """The shortest and the longest distance [m]; None of a single run."""
        return (min(self.distances), max(self.distances)) if len(self.distances) > 1 else None

    def change_against(self, other: "StatedDistance") -> float:
        """Return the relative change of the distance, over the same lots the median of the changes in each lot."""
        if self.are_lots and other.are_lots and len(self.distances) == len(other.distances):
            return median(map(relative_change, self.distances, other.distances))
        return relative_change(self.median, other.median)


def frame_of(results: Results) -> Frame:
    """Return a row for each stop of a campaign, in its order; numbers that do not exist are NaN.

    Columns:

    - `CONDITIONS`: scenario; variants of the axes that have no column, usually empty; names of the creep curves; kinds
      of actuation and sensors; kind of the law; name of the controller for readers, with thresholds; estimator.
      `label` is scenario and case.
    - `friction`: maximum friction of a constant rail and of its patches, as text; empty for other rails.
    - `draw`: seed of a stop that is one draw of a distribution, else None.
    - `reference`: "published" or "best tuned" for the stop with this SBC, with which others are compared, else None.
    - `repeated`, `other_repeats`: text with median and range of the distance under perturbations of the plant's
      parameters in the seventh digit, and with the distances with FMUs of other compilers, and with other lots of
      sensors; `stated`: the `StatedDistance`, which one of these or the run itself gives.
    - `stated_vs_sbc`, `stated_vs_tuned`: change of the stated distance against that with the published, or the best
      tuned, SBC in the same conditions; infinite without standstill. All other numbers of a row are of one run.
    - `fitted`: whether the friction of the rail is fitted to published distances.
    - `reduction_vs_sbc`, `reduction_vs_tuned`: 1 − distance over that of the published, or the best tuned, SBC in the
      same conditions; −∞ without standstill.
    - `paper_distance`, `paper_reduction`: published distance [m], and its reduction against the published SBC.
    - `outcome`, `breaks`, `stop`: outcome, clauses that the stop breaks, and name in the campaign.
    - `outside`: maximum share of time in which a true adhesion or pad friction was outside ±2σ of the estimate.
    - `IN_TABLES`: each of these figures as one number of the train, in SI units. The distance exists for a standstill
      alone, as does the duration; strokes of valves exist with valves, and air used except with ideal actuation.
    """
    axes = _hidden_axes(results.stops)
    compared_with = references(results.stops, lambda stop: stop.inputs, lambda stop: stop.braking_distance)
    limits = limits_of()
    records = [
        _record(stop, published, tuned, axes) | {"breaks": limits.find_violations(stop)}
        for stop, (published, tuned) in zip(results.stops, compared_with, strict=True)
    ]
    return pandas.DataFrame(records, columns=list(dict.fromkeys((*_COLUMNS, *IN_TABLES)))).astype({"draw": object})


def groups_of(frame: Frame, columns: Sequence[str]) -> Iterator[tuple[Any, Frame]]:
    """Yield the values of columns, and the rows that have them, in the order of the rows."""
    if len(frame):
        yield from frame.groupby(list(columns), sort=False, dropna=False)


def single_stops(frame: Frame) -> Frame:
    """Return the stops that are not one draw of a distribution."""
    return frame[frame["draw"].isna()]


def plain_rows(frame: Frame) -> list[JsonObject]:
    """Return the rows as JSON values; None for numbers that do not exist."""
    shown = frame.drop(columns=["label", "fitted", "stated_vs_sbc", "stated_vs_tuned"], errors="ignore")
    repeats = [one.ends and (one.median, *one.ends) for one in frame["stated"]]
    rows = plain(shown.assign(stated=repeats).rename(columns=_PLAIN))
    for row in rows:
        row["air_l"] = None if row["air_l"] is None else 1000 * row["air_l"]
        row["valve_strokes"] = None if row["valve_strokes"] is None else round(row["valve_strokes"])
    return rows


def plain(frame: Frame) -> list[JsonObject]:
    """Return the rows of a frame; None for NaN and infinity."""
    return [
        {name: None if isinstance(value, float) and not isfinite(value) else value for name, value in row.items()}
        for row in frame.to_dict("records")
    ]


def short_names(frame: Frame) -> tuple[str, dict[str, str]]:
    """Return the names of the axes that distinguish cases, and label of a row → its variants on these axes, one per
    line.

    Scenario and axes that are equal in all rows are omitted, unless there is only one case.
    """
    cases = frame[["label", "scenario", "case"]].drop_duplicates().itertuples(index=False)
    parts = {row.label: [f"scenario {row.scenario}", *filter(None, row.case.split(", "))] for row in cases}
    columns = list(zip(*parts.values(), strict=False))
    if len({len(each) for each in parts.values()}) > 1 or any(len(_axes(column)) > 1 for column in columns):
        return "", {label: label.replace("_", " ").replace(", ", "\n") for label in parts}
    kept = [number for number, column in enumerate(columns) if len(set(column)) > 1] or [0]
    title = ", ".join(axis for number in kept for axis in _axes(columns[number]))
    return title.replace("_", " "), {
        label: "\n".join(each[number].partition(" ")[2].replace("_", " ") for number in kept)
        for label, each in parts.items()
    }


def _axes(column: Iterable[str]) -> set[str]:
    return {part.partition(" ")[0] for part in column}


def _record(stop: Stop, sbc: Stop | None, tuned: Stop | None, axes: Sequence[str]) -> dict[str, object]:
    scenario, metrics, distance = stop.inputs, stop.figures, stop.braking_distance
    actuation, sensors, polach = setting_of(scenario)
    case = ", ".join(f"{axis} {stop.variants[axis]}" for axis in axes)
    repeats, is_standstill, stated = stop.own_repeats, stop.outcome is Outcome.STANDSTILL, StatedDistance.of(stop)
    figures = {name: metrics.of_train(name) for name in IN_TABLES}
    if actuation != VALVES:
        figures["actuations"] = nan
    figures |= {} if is_standstill else {"distance": nan, "duration": nan}
    published = sbc.paper_distance if sbc is not None and sbc is not stop else None
    return {
        "label": f"{scenario['name']}, {case}" if case else scenario["name"],
        "scenario": scenario["name"],
        "case": case,
        "polach": polach,
        "actuation": actuation,
        "sensors": sensors,
        "controller": controller_of(scenario),
        "controller_label": label(scenario),
        "estimator": _estimator(scenario),
        "friction": _friction(scenario["adhesion"]),
        "draw": int(stop.variants[DRAW]) if DRAW in stop.variants else None,
        "reference": "published" if sbc is stop else "best tuned" if tuned is stop else None,
        "repeated": range_text(stop.conditioning, stop.digest, distance),
        "stated": stated,
        "other_repeats": _other_repeats(repeats),
        "reduction_vs_sbc": _reduction(distance, sbc, stop),
        "reduction_vs_tuned": _reduction(distance, tuned, stop),
        "stated_vs_sbc": _stated_change(stated, sbc, stop),
        "stated_vs_tuned": _stated_change(stated, tuned, stop),
        "fitted": scenario["adhesion"]["polach"]["name"] in scenario["adhesion"].get("calibrated", {}),
        "paper_distance": nan if stop.paper_distance is None else stop.paper_distance,
        "paper_reduction": 1 - stop.paper_distance / published if published and stop.paper_distance else nan,
        "outcome": stop.outcome.value,
        "outside": max((*(metrics.adhesion_outside or ()), *(metrics.pad_friction_outside or ())), default=nan),
        "stop": stop.name,
        **figures,
    }


def range_text(conditioning: RepeatedDistances | None, digest: str, distance: float | None) -> str:
    """Return median and range of the repeats of a stop, or `STALE` if they are the repeats of another stop.

    Args:
        digest: Digest of the scenario of the stop.
        distance: Distance of the stop [m], None without standstill.
    """
    if conditioning is None:
        return ""
    if not conditioning.belongs(digest, distance):
        return STALE
    return f"{conditioning.median:.1f} m ({conditioning.lowest:.1f} – {conditioning.highest:.1f})"


def _other_repeats(repeats: RepeatedDistances | None) -> str:
    if repeats is None:
        return ""
    texts: list[str] = []
    for compiler in repeats.compilers:
        shortest, longest = repeats.ends_of(compiler)
        texts.append(f"{compiler} {shortest:.1f} m" + (f" – {longest:.1f} m" if longest - shortest > SMOOTH else ""))
    texts += [f"{len(repeats.lots)} lots of sensors {repeats.lots_text}"] if repeats.lots else []
    return "; ".join(texts)


def _hidden_axes(stops: Sequence[Stop]) -> tuple[str, ...]:
    """Return the axes along which stops differ although all columns are equal; draws have a separate column."""
    pairs = ((stop.inputs, stop) for stop in stops)
    alike = gather(((of["name"], *setting_of(of), label(of), _estimator(of)), stop) for of, stop in pairs)
    axes = dict.fromkeys(axis for stop in stops for axis in stop.variants if axis != DRAW)
    return tuple(
        axis for axis in axes if any(len({stop.variants.get(axis) for stop in same}) > 1 for same in alike.values())
    )


def _friction(adhesion: Mapping[str, Any]) -> str:
    if adhesion["kind"] != "constant":
        return ""
    patches = sorted({value for patch in adhesion.get("patch", ()) for value in patch["mu0"]})
    rail, places = (", ".join(f"{value:g}" for value in values) for values in (adhesion["mu0"], patches))
    return f"{rail}, in patches {places}" if places else rail


def _estimator(scenario: Mapping[str, Any]) -> str:
    estimator = scenario["estimator"]
    return estimator["kind"] if estimator["kind"] == "none" else f"{estimator['model']} ({estimator['kind']})"


def _reduction(distance: float | None, reference: Stop | None, own: Stop) -> float:
    """Return 1 − distance over that of the reference, −∞ without standstill; NaN if there is no reference."""
    before = reference.braking_distance if reference is not None and reference is not own else None
    return nan if before is None else 1 - endless(distance) / before


def _stated_change(stated: StatedDistance, reference: Stop | None, own: Stop) -> float:
    """Return the change of a stated distance; NaN without a reference that comes to a standstill."""
    before = StatedDistance.of(reference) if reference is not None and reference is not own else None
    return nan if before is None or isinf(before.median) else stated.change_against(before)
