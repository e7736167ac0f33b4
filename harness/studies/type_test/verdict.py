"""Which law is best, and on which rail: a law is called best only if no other law is clearly shorter in any family."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from railgrip.base import registry
from railgrip.report.frame import Frame, groups_of
from railgrip.report.statistics import quantile
from railgrip.report.table import ReportTable, names
from railgrip.studies.type_test.family import AXES, FEWEST
from railgrip.studies.type_test.judge import over_best
from railgrip.studies.type_test.track_case import BY_THE_CURVE, TABLE_1

LIMIT: Final = 0.03
"""Relative loss against another law in the cases of a family, in the median, from which a law is beaten there."""

_LISTED: Final = 3
"""Number of laws that are listed for a kind of rail."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FamilyLoss:
    """A family in which a law is beaten.

    Attributes:
        family: Axis and value.
        other: The law with the shortest stops there.
        ratio: Median of the distance over that of the other law in the same case; infinite if it does not stop.
        cases: Number of cases with both.
    """

    family: str
    other: str
    ratio: float
    cases: int


def _rows_of_laws(stops: Frame) -> Frame:
    """Return the stops without those of controllers that know the true state and of full brake.

    Locked wheels may stop shortest where slip cleans the rail, but full brake is no wheel-slide protection.
    """
    return stops[~stops["controller"].isin([*registry.ANALYSES, "full_brake"])]


def _laws(stops: Frame) -> dict[str, dict[str, Any]]:
    """Return law → case → row of its judged stop."""
    laws = groups_of(_rows_of_laws(stops), ("controller",))
    return {law: {row.case: row for row in own.itertuples()} for (law,), own in laws}


def _families(stops: Mapping[str, Any]) -> dict[str, list[str]]:
    """Return the cases of each family that has `FEWEST` cases or is that of Table 1."""
    families: dict[str, list[str]] = {}
    for axis in AXES:
        for name, stop in stops.items():
            if axis in stop.variants:
                families.setdefault(f"{axis}: {stop.variants[axis]}", []).append(name)
    return {family: cases for family, cases in families.items() if _counts(family, len(cases))}


def _counts(family: str, cases: int) -> bool:
    return cases >= FEWEST or family == f"rail: {TABLE_1}"


def _ratio(one: Any, other: Any) -> float:
    if math.isnan(one.distance_m):
        return 1.0 if math.isnan(other.distance_m) else math.inf
    return 0.0 if math.isnan(other.distance_m) else one.distance_m / other.distance_m


def losses_of(law: str, stops: Frame) -> list[FamilyLoss]:
    """Return the families in which a law is beaten, with the law that beats it by most, in the order of the axes.

    Laws are compared in the cases that both were run in.
    """
    laws = _laws(stops)
    own = laws[law]
    found: list[FamilyLoss] = []
    for family, cases in _families(own).items():
        worst: FamilyLoss | None = None
        for other, of_other in laws.items():
            ratios = [_ratio(own[case], of_other[case]) for case in cases if case in of_other]
            if other == law or not _counts(family, len(ratios)):
                continue
            ratio = quantile(ratios, 0.5)
            if ratio > 1.0 + LIMIT and (worst is None or ratio > worst.ratio):
                worst = FamilyLoss(family=family, other=other, ratio=ratio, cases=len(ratios))
        if worst is not None:
            found.append(worst)
    return found


def _by_median(stops: Frame) -> tuple[list[str], int]:
    """Return the laws by their median over the cases in which all were run, smallest first, and the number of these."""
    laws = _laws(stops)
    common = set[str].intersection(*(set(of_law) for of_law in laws.values())) if laws else set[str]()
    compared = over_best(stops[stops["case"].isin(common)])
    controllers = stops["controller"].loc[compared.index]
    medians = {law: quantile(compared[controllers == law].tolist(), 0.5) for law in laws}
    count = int((controllers == next(iter(laws), "")).sum())
    return sorted(laws, key=lambda law: medians[law]) if count else [], count


def verdict(stops: Frame) -> str:
    """Return whether the law with the smallest median is best, or where it loses.

    Args:
        stops: Judged stops.
    """
    laws = _laws(stops)
    order, count = _by_median(stops)
    if not order:
        return "There is no case in which all laws were run and a baseline stops: none can be called best."
    first, limit = order[0], f"{100 * LIMIT:.0f} %"
    cases_of = {law: _families(of_law).keys() for law, of_law in laws.items()}
    every = set[str]().union(*cases_of.values())
    absent = [f"*{family}*" for family in sorted(every - cases_of[first])]
    found = losses_of(first, stops)
    if not found and not absent:
        return (
            f"{first} is the best law: its median over the {count} cases in which all laws were run is the smallest, "
            f"and no other law is shorter by more than {limit} in any family of cases."
        )
    reasons = [
        *([f"loses on {names([f'*{loss.family}* ({_text(loss)})' for loss in found])}"] if found else []),
        *([f"has too few results on {names(absent)}"] if absent else []),
    ]
    unbeaten = [law for law in order[1:] if every <= cases_of[law] and not losses_of(law, stops)]
    rest = (
        f" Not beaten by more than {limit} in any family: {names(unbeaten)}."
        if unbeaten
        else f" No law with results in every family is unbeaten by {limit} in all of them."
    )
    return (
        f"{first} is best in the median over the {count} cases in which all laws were run, but "
        f"{' and '.join(reasons)}.{rest}"
    )


def _text(loss: FamilyLoss) -> str:
    ratio = "does not stop" if math.isinf(loss.ratio) else f"{loss.ratio:.3f}"
    return f"{ratio} of {loss.other} in {loss.cases} cases"


def rail_of(variants: Mapping[str, str]) -> str:
    """Return the kind of rail of a case: who or what cleans it."""
    if variants["rail"] == TABLE_1:
        return f"rails of {TABLE_1}"
    slip = {"none": "", "weak": "slip weakly", "strong": "slip strongly", BY_THE_CURVE: "slip, which heats the contact"}
    who = [*(["passing wheels"] if variants["passage"] != "none" else []), slip[variants["cleaning"]]]
    causes = [cause for cause in who if cause]
    return f"cleaned by {' and '.join(causes)}" if causes else "cleaned by nothing"


def recommendation(stops: Frame) -> ReportTable:
    """Return the laws with the smallest medians on each kind of rail, of those that were run in all its cases.

    Values are the median, the 95 % quantile and the maximum of the distance over that of the best baseline.
    """
    compared = _rows_of_laws(stops[stops["best_m"].notna()])
    compared = compared.assign(rail=[rail_of(variants) for variants in compared["variants"]])
    rows: list[dict[str, object]] = []
    for (kind,), of_kind in groups_of(compared, ("rail",)):
        count = of_kind["case"].nunique()
        ratios: list[tuple[float, str, str]] = []
        for (law,), own in groups_of(of_kind, ("controller",)):
            if len(own) == count:
                values = over_best(own).tolist()
                median, high, most = (quantile(values, share) for share in (0.5, 0.95, 1.0))
                text = " / ".join("no stop" if math.isinf(value) else f"{value:.3f}" for value in (median, high, most))
                ratios.append((median, law, text))
        row: dict[str, object] = {"rail": kind, "cases": count, "laws": len(ratios)}
        for place, (_, law, text) in zip(("shortest", "second", "third")[:_LISTED], sorted(ratios), strict=False):
            row[place] = f"{law}: {text}"
        rows.append(row)
    rows.sort(key=lambda row: (TABLE_1 in str(row["rail"]), str(row["rail"])))
    columns = ("rail", "cases", "laws", "shortest", "second", "third")
    return ReportTable([{name: row.get(name, "") for name in columns} for row in rows], left=columns[:1] + columns[3:])
