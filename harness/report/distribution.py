"""Distances of controllers and variants over many draws or cases: median, range, and change against others in pairs.

`railgrip.report.statistics` defines how controllers are compared.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Final, Self

import numpy as np
import pandas

from railgrip.base.errors import InputError
from railgrip.base.groups import gather
from railgrip.base.tables import JsonObject
from railgrip.report.frame import CONDITIONS, IN_TABLES, PLACE, Frame, groups_of
from railgrip.report.limits import SUBJECTS
from railgrip.report.statistics import (
    median_interval,
    on_common,
    order_interval,
    quantile,
    relative_change,
    share_interval,
)
from railgrip.report.stop import Stop
from railgrip.report.table import Link, ReportTable, percent_or_endless, text, with_interval
from railgrip.scenario.campaign import DRAW


@dataclass(frozen=True, slots=True, kw_only=True)
class PairedComparison:
    """A controller compared with another on the same draws.

    Attributes:
        label: Name of the other controller.
        draws: Number of draws in which both were run.
        shorter: Share of the draws in which this controller stops shorter.
        shorter_interval: Interval of that share.
        change: Median over the draws of the distance over that of the other controller, minus 1.
        change_interval: Interval of that median; None with too few draws.
        changes: Changes in the order of the draws; infinite if only the other controller came to a standstill.
    """

    label: str
    draws: int
    shorter: float
    shorter_interval: tuple[float, float]
    change: float
    change_interval: tuple[float, float] | None
    changes: tuple[float, ...]


def distributions_of(frame: Frame) -> Frame:
    """Return a row for each controller and conditions with draws, in the order of the stops.

    Controllers under the same conditions have the same draws: a draw that one of them lacks is left out.

    Columns: `CONDITIONS`, `label`; the numbers of `draws` and of those that `stood`; `distances`, a series by draw,
    infinite without standstill; `median`, 5 % quantile `low` and 95 % quantile `high` of the distance [m], infinite if
    too many draws have no standstill; the longest distance `worst` [m] and its seed `worst_draw`; `vs_sbc` and
    `vs_tuned`, the comparison with the published and with the best tuned slip-based control or None; and the median of
    each figure that has one over draws.
    """
    drawn = frame[frame["draw"].notna()].drop_duplicates([*PLACE, "controller_label", "estimator", "draw"], keep="last")
    drawn = drawn.assign(endless=drawn["distance"].fillna(math.inf), law=drawn["controller_label"] + drawn["estimator"])
    places = [on_common(here, "law", ["draw"], "endless") for _, here in groups_of(drawn, PLACE)]
    drawn = pandas.concat([drawn.head(0), *places]).sort_index()
    groups = [of for _, of in groups_of(drawn, (*PLACE, "controller_label", "estimator"))]
    references = {(*(of[name].iloc[0] for name in PLACE), of["reference"].iloc[0]): of for of in groups}
    return pandas.DataFrame([_distribution(of, references) for of in groups], columns=list(_COLUMNS))


def plain_distributions(distributions: Frame) -> list[JsonObject]:
    """Return the rows as JSON values."""
    shown = distributions.drop(columns="label", errors="ignore").rename(
        columns={name: f"{name}_m" for name in ("distances", "median", "low", "high", "worst")}
        | {"longest_lock": "longest_lock_s", "flat_length": "flat_length_m"}
    )
    return [
        row
        | {name: row[name] and asdict(row[name]) for name in ("vs_sbc", "vs_tuned")}
        | {"distances_m": row["distances_m"].to_dict()}
        for row in shown.to_dict("records")
    ]


def over_cases(frame: Frame) -> Frame:
    """Return the stops of a scenario with many cases as if each case were a draw."""
    cases = pandas.factorize(frame["case"])[0] + 1
    return frame.assign(case="", label=frame["scenario"], draw=cases.astype(object))


def distribution_table(distributions: Frame) -> ReportTable:
    """Return a row for each distribution."""
    rows = [
        {
            **_question(one),
            "draws": str(one.draws) if one.stood == one.draws else f"{one.draws}, {one.draws - one.stood} without stop",
            "median": _metres(one.median),
            "5–95 %": f"{_metres(one.low, '')} – {_metres(one.high)}",
            "worst (draw)": f"{_metres(one.worst)} ({one.worst_draw})",
            **{f"{figure.column}, median": getattr(one, name) for name, figure in _OVER_DRAWS.items()},
            **paired_texts("SBC 10/15 %", one.vs_sbc),
            **paired_texts("best tuned SBC", one.vs_tuned),
        }
        for one in distributions.itertuples()
    ]
    return ReportTable(rows, {f"{figure.column}, median": figure.text for figure in _OVER_DRAWS.values()})


def _question(one: Any) -> dict[str, str]:
    return {
        "scenario": one.label,
        "actuation": one.actuation,
        "sensors": one.sensors,
        "creep curve": one.polach,
        "controller": one.controller_label,
    }


_OVER_DRAWS: Final = {name: figure for name, figure in IN_TABLES.items() if figure.over_draws}
"""Figures with a median over draws."""

_COLUMNS: Final = (
    "label", *CONDITIONS, "draws", "stood", "distances", "median", "low", "high", "worst", "worst_draw", *_OVER_DRAWS,
    "vs_sbc", "vs_tuned",
)  # fmt: skip

QUANTILES = (0.5, 0.95, 0.99)
"""Quantiles of the distance in tables: the median, and distances that are rarely and hardly ever exceeded."""


def quantile_table(distributions: Frame, permitted: float | None) -> ReportTable:
    """Return P50, P95 and P99 of each distribution with their intervals, and how often a distance [m] is exceeded.

    Draws without standstill exceed every distance. An interval requires enough draws, that of P99 nearly 400.
    """
    rows: list[dict[str, str | int]] = []
    for one in distributions.itertuples():
        values = one.distances.tolist()
        row: dict[str, str | int] = {**_question(one), "draws": len(values)}
        for level in QUANTILES:
            interval = order_interval(values, level)
            ends = "" if interval is None else f" [{_metres(interval[0], '')}, {_metres(interval[1], '')}]"
            row[f"P{100 * level:.0f}"] = _metres(quantile(values, level)) + ends
        if permitted is not None:
            count = sum(value > permitted for value in values)
            low, high = share_interval(count, len(values))
            row[f"over {permitted:g} m"] = f"{100 * count / len(values):.2f} % [{100 * low:.2f}, {100 * high:.2f}]"
        rows.append(row)
    return ReportTable(rows, title="Quantiles of the braking distance, with intervals of 95 %")


def worst_table(frame: Frame, pages: Mapping[str, str], count: int = 10) -> ReportTable:
    """Return the longest stops of all draws, starting with those without standstill, linked to their pages."""
    drawn = frame[frame["draw"].notna() & (frame["controller"] != "ideal_bound")]
    cells = [
        {
            "stop": Link(row.stop, pages[row.stop]) if row.stop in pages else row.stop,
            "controller": row.controller_label,
            "seed": row.draw,
            "distance": f"none: {row.outcome}" if math.isnan(row.distance) else row.distance,
            "adhesion used": row.utilisation,
            "longest lock": row.longest_lock,
        }
        for row in drawn.sort_values("distance", ascending=False, na_position="first", kind="stable")
        .head(count)
        .itertuples()
    ]
    return ReportTable(cells, {figure.column: figure.text for figure in IN_TABLES.values()})


def change_text(changes: Sequence[float]) -> str:
    """Return the median of changes with its interval in brackets, if there are enough for one."""
    return with_interval(float(np.median(changes)), median_interval(changes), percent_or_endless, without=0.0)


def paired_texts(name: str, paired: PairedComparison | None) -> dict[str, str]:
    """Return the columns of a table that compare with another controller or variant of this name."""
    change = shorter = ""
    if paired is not None:
        change = change_text(paired.changes)
        shorter = text(100 * paired.shorter, "{:.0f} %")
        shorter += f" [{', '.join(text(100 * end, '{:.0f}') for end in paired.shorter_interval)}]"
    return {f"change vs {name}": change, f"shorter than {name}": shorter}


def _metres(distance: float, unit: str = " m") -> str:
    return f"{distance:.1f}{unit}" if math.isfinite(distance) else "no stop"


def _distribution(of: Frame, references: Mapping[tuple[Any, ...], Frame]) -> dict[str, object]:
    first, distances = of.iloc[0], by_draw(of)
    others = (references.get((*(first[name] for name in PLACE), kind)) for kind in ("published", "best tuned"))
    vs_sbc, vs_tuned = (None if other is None or other is of else compare_pairs(distances, other) for other in others)
    return {
        "label": first["label"],
        **{name: first[name] for name in CONDITIONS},
        "draws": len(distances),
        "stood": int(np.isfinite(distances).sum()),
        "distances": distances,
        "median": float(np.median(distances)),
        "low": quantile(distances, 0.05),
        "high": quantile(distances, 0.95),
        "worst": float(distances.max()),
        "worst_draw": distances.idxmax(),
        **{name: of[name].median() for name in _OVER_DRAWS},
        "vs_sbc": vs_sbc,
        "vs_tuned": vs_tuned,
    }


def compare_pairs(own: Frame, other: Frame) -> PairedComparison | None:
    """Return the comparison of distances [m] by draw with the stops of another controller; None without a common draw.

    Args:
        own: Distances by draw, infinite without standstill.
        other: Stops of the other controller.
    """
    pairs = pandas.concat([own, by_draw(other)], axis=1, join="inner").to_numpy()
    if not len(pairs):
        return None
    changes = tuple(relative_change(distance, reference) for distance, reference in pairs)
    count = int(np.sum(pairs[:, 0] < pairs[:, 1]))
    return PairedComparison(
        label=other["controller_label"].iloc[0],
        draws=len(pairs),
        shorter=count / len(pairs),
        shorter_interval=share_interval(count, len(pairs)),
        change=float(np.median(changes)),
        change_interval=median_interval(changes),
        changes=changes,
    )


def by_draw(frame: Frame) -> Frame:
    """Return the distance [m] of each draw, infinite without standstill."""
    return frame.drop_duplicates("draw", keep="last").set_index("draw")["distance"].fillna(math.inf)


_POOLED = ("scenario", "seed", DRAW)
"""Axes over which pairs are pooled; a campaign without draws has scenarios and seeds instead."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceVariant:
    """The variant that the others of its axis are compared with."""

    axis: str
    variant: str

    @classmethod
    def find(cls, text: str, stops: Sequence[Mapping[str, str]]) -> Self:
        """Find a variant by its name, or by `AXIS=VARIANT` if several axes have one of that name.

        Args:
            text: Name as the user writes it.
            stops: Axis → variant of each stop of a campaign.

        Raises:
            InputError: No stop has the variant, several axes have it, or its axis has no other variant.
        """
        pairs = dict.fromkeys(pair for stop in stops for pair in stop.items())
        axes = gather(pair for pair in pairs if pair[0] != DRAW)
        found = [(axis, name) for axis, names in axes.items() for name in names if text in (name, f"{axis}={name}")]
        if len(found) != 1:
            several = ", ".join(f"{axis}={name}" for axis, name in found)
            everything = "; ".join(f"{axis}: {', '.join(variants)}" for axis, variants in axes.items())
            raise InputError(
                f"--against {text}: several axes have a variant of this name; choose one of {several}."
                if found
                else f"--against {text}: the campaign has no such variant; it has {everything or 'none'}."
            )
        ((axis, variant),) = found
        if len(axes[axis]) == 1:
            raise InputError(f"--against {text}: the axis '{axis}' has no other variant to compare with it.")
        return cls(axis=axis, variant=variant)


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """A variant against the reference, over all pairs under the same conditions.

    Attributes:
        conditions: Axis → variant, for the axes that are equal in all of these pairs.
        variant: Variant on the axis of the reference.
        paired: The comparison; `label` is the variant of the reference.
        stops: All stops of the variant under these conditions, numbered by case in `draw`.
        by_case: Number of each case that has a pair → change.
    """

    conditions: Mapping[str, str]
    variant: str
    paired: PairedComparison
    stops: Frame
    by_case: Mapping[int, float]


def changes_against(reference: ReferenceVariant, stops: Sequence[Stop], frame: Frame) -> tuple[Change, ...]:
    """Compare all other variants of an axis with the reference, in the order of the campaign.

    Two stops are a pair if they differ only along this axis. Pairs are pooled over the draws or, without draws, over
    scenarios and seeds.

    Args:
        reference: Variant to compare with.
        stops: Stops of a campaign.
        frame: Rows of the same stops.
    """
    cases: dict[tuple[tuple[str, str], ...], int] = {}
    groups: dict[tuple[tuple[str, str], ...], dict[str, list[int]]] = {}
    # The number of a case serves as draw: stops of the same case are a pair.
    draws: list[int | None] = [None] * len(stops)
    for number, stop in enumerate(stops):
        if reference.axis not in stop.variants:
            continue
        others = {axis: variant for axis, variant in stop.variants.items() if axis != reference.axis}
        draws[number] = cases.setdefault(tuple(others.items()), len(cases))
        pooled = (DRAW,) if DRAW in others else _POOLED
        conditions = tuple((axis, variant) for axis, variant in others.items() if axis not in pooled)
        groups.setdefault(conditions, {}).setdefault(stop.variants[reference.axis], []).append(number)
    paired = frame.assign(draw=np.array(draws, dtype=object))
    changes: list[Change] = []
    for conditions, variants in groups.items():
        base = paired.iloc[variants.pop(reference.variant, [])]
        for variant, numbers in variants.items():
            own = paired.iloc[numbers]
            if (pairs := compare_pairs(by_draw(own), base)) is not None:
                by_case = dict(zip(by_draw(own).index.intersection(by_draw(base).index), pairs.changes, strict=True))
                compared = replace(pairs, label=reference.variant)
                changes.append(
                    Change(conditions=dict(conditions), variant=variant, paired=compared, stops=own, by_case=by_case)
                )
    return tuple(changes)


def change_table(reference: ReferenceVariant, changes: Sequence[Change]) -> ReportTable:
    """Return a row for each variant and set of conditions."""
    rows = [
        {
            **change.conditions,
            reference.axis: change.variant,
            "pairs": change.paired.draws,
            **paired_texts(reference.variant, change.paired),
            "breaks": ", ".join(SUBJECTS[clause] for clause in change.stops["breaks"].explode().dropna().unique()),
        }
        for change in changes
    ]
    axes = {axis for change in changes for axis in change.conditions}
    return ReportTable(
        rows, left=(*axes, reference.axis), title=f"Pairs of stops that differ in {reference.axis} only"
    ).drop_empty_columns()
