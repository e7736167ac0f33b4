"""Summarise a campaign in a few sentences; a controller or variant that breaks a clause is not recommended."""

from collections.abc import Sequence
from dataclasses import dataclass

from railgrip.report.distribution import change_text
from railgrip.report.frame import Frame
from railgrip.report.limits import SUBJECTS
from railgrip.report.statistics import endless
from railgrip.report.table import change, percent
from railgrip.report.variants import Change, ReferenceVariant


@dataclass(frozen=True, slots=True, kw_only=True)
class _Contender:
    """A controller, or a variant under some conditions.

    Attributes:
        name: Name for the sentence.
        change: Median of its distance over that of the reference, minus 1.
        text: The change with its range or interval, and the number of stops.
        stops: Its stops.
    """

    name: str
    change: float
    text: str
    stops: Frame

    @property
    def violations(self) -> dict[str, int]:
        clauses = self.stops["breaks"].explode().dropna()
        return {clause: int((clauses == clause).sum()) for clause in clauses.unique()}


def headline(frame: Frame, reference: ReferenceVariant | None = None, changes: Sequence[Change] = ()) -> str:
    """Return a summary with the controller, or variant, that shortens the distance most without breaking a clause.

    Args:
        frame: Stops of a campaign.
        reference: The variant that others are compared with; without it, controllers are compared with the published
            slip-based control.
        changes: Changes of the other variants.
    """
    count = f"{frame['distance'].count()} of {len(frame)} stops come to a standstill."
    candidates = _controllers(frame) if reference is None else _variants(changes)
    if not candidates:
        return count
    against = "slip-based control with 10 and 15 %" if reference is None else f"{reference.axis} {reference.variant}"
    kinds = "controllers" if reference is None else "variants"
    shortest = min(candidates, key=lambda candidate: candidate.change)
    allowed = [candidate for candidate in candidates if not candidate.violations]
    if not allowed:
        none = f"none of the {len(candidates)} {kinds} keeps all clauses" if len(candidates) > 1 else ""
        breaks = f"{shortest.name} breaks {_breaks(shortest)}"
        what = f"{none}: {breaks}" if none else breaks
        return f"Against {against}, {what}. It changes the distance by {shortest.text} and is not recommended. {count}"
    best = min(allowed, key=lambda candidate: candidate.change)
    others = ""
    if len(allowed) == 1 < len(candidates):
        others = f"; of {len(candidates)} {kinds} it is the only one that keeps all clauses"
    elif len(allowed) > 1 and best.change < 0:
        others = f", the largest reduction of the {len(allowed)} of {len(candidates)} {kinds} that keep all clauses"
    more = (
        f" {shortest.name} changes it by {percent(shortest.change)}, but breaks {_breaks(shortest)}."
        if shortest is not best
        else ""
    )
    return f"Against {against}, {best.name} changes the distance by {best.text}{others}.{more} {count}"


def _controllers(frame: Frame) -> list[_Contender]:
    compared = frame[frame["controller"] != "ideal_bound"]
    candidates: list[_Contender] = []
    for name, own in compared.groupby("controller_label", sort=False):
        shares = own["reduction_vs_sbc"].dropna()
        if len(shares):
            median, smallest, largest = map(change, (shares.median(), shares.max(), shares.min()))
            text = f"{median} in the median of {len(shares)} stops, from {smallest} to {largest}"
            text = text if len(shares) > 1 else f"{median} in one stop"
            candidates.append(_Contender(name=str(name), change=-shares.median(), text=text, stops=own))
    return candidates


def _variants(changes: Sequence[Change]) -> list[_Contender]:
    """Return the variants other than the reference; several conditions of one variant are several candidates."""
    differ = {pair for change in changes for pair in change.conditions.items()}
    differ -= {pair for pair in differ if all(pair in change.conditions.items() for change in changes)}

    def name(change: Change) -> str:
        under = ", ".join(" ".join(pair) for pair in change.conditions.items() if pair in differ)
        return f"{change.variant} (with {under})" if under else change.variant

    return [
        _Contender(
            name=name(change),
            change=endless(change.paired.change),
            text=f"{change_text(change.paired)} in the median of {change.paired.draws} pairs",
            stops=change.stops,
        )
        for change in changes
        if change.stops["controller"].iloc[0] != "ideal_bound"
    ]


def _breaks(candidate: _Contender) -> str:
    count = len(candidate.stops)
    return ", ".join(
        f"the limit on {SUBJECTS[clause]} in {broken} of {count} stops"
        for clause, broken in candidate.violations.items()
    )
