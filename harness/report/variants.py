"""Compare two variants of an axis of a campaign by pairs of stops that differ only along that axis."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from railgrip.base.errors import InputError
from railgrip.report.distribution import PairedComparison, by_draw, compare_pairs, paired_texts
from railgrip.report.frame import Frame
from railgrip.report.limits import SUBJECTS
from railgrip.report.stop import Stop
from railgrip.report.table import ReportTable
from railgrip.scenario.campaign import DRAW

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
        axes: dict[str, list[str]] = {}
        for stop in stops:
            for axis, variant in stop.items():
                if axis != DRAW and variant not in (known := axes.setdefault(axis, [])):
                    known.append(variant)
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
        stops: All stops of the variant under these conditions.
    """

    conditions: Mapping[str, str]
    variant: str
    paired: PairedComparison
    stops: Frame


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
                compared = replace(pairs, label=reference.variant)
                changes.append(Change(conditions=dict(conditions), variant=variant, paired=compared, stops=own))
    return tuple(changes)


def change_table(reference: ReferenceVariant, changes: Sequence[Change]) -> ReportTable:
    """Return a row for each variant and set of conditions."""
    rows: list[dict[str, Any]] = [
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
