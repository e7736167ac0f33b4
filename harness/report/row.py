"""One stop in a table of braking distances."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True, kw_only=True)
class Conditions:
    """Scenario, equipment and controller of a stop.

    Attributes:
        case: Variants of the axes that have no column; usually empty.
        polach: Names of the creep curves.
        controller: Kind of the law.
        controller_label: Name of the controller for readers, with thresholds.
    """

    scenario: str
    case: str
    polach: str
    actuation: str
    sensors: str
    controller: str
    controller_label: str
    estimator: str

    @property
    def label(self) -> str:
        """Scenario and case, for readers."""
        return f"{self.scenario}, {self.case}" if self.case else self.scenario

    @property
    def setting(self) -> tuple[str, str, str]:
        """Actuation, sensors and creep curves."""
        return self.actuation, self.sensors, self.polach

    @property
    def place(self) -> tuple[str, str, str, str, str]:
        """Scenario, case and setting: controllers are compared where these are equal."""
        return self.scenario, self.case, *self.setting


@dataclass(frozen=True, slots=True, kw_only=True)
class Row(Conditions):
    """A stop in the table.

    Attributes:
        friction: Maximum friction of a constant rail and of its patches, as text; empty for other rails.
        draw: Seed of a stop that is one draw of a distribution.
        reference: Whether the stop is that of the published or of the best tuned SBC, with which others are compared.
        distance_m: Braking distance; None without standstill.
        repeated: Text with median and range of the distance under perturbations of the plant's parameters in the
            seventh digit, and with other lots of sensors.
        range_m: Shortest and longest of the perturbed distances; None if they hardly differ, or without such repeats.
        reduction_vs_sbc: 1 − distance over that of the published SBC in the same conditions; None if one is missing.
        reduction_vs_tuned: The same against the best tuned SBC.
        utilisation: Share of the ideal bound's adhesion that the stop uses; None without the bound.
        paper_distance_m: Published distance; None without one.
        paper_reduction: Published reduction against the published SBC.
        outcome: Outcome of the stop.
        breaks: Clauses that the stop breaks; see `railgrip.report.limits`.
        adhesion_peak: Greatest adhesion of any group.
        longest_lock_s: Longest lock of any ω-group.
        valve_strokes: Strokes of all valves; None without valves.
        air_l: Free air used, litres; None with ideal actuation and for a stop without a brake.
        nis: Median squared innovation of the estimator over the expected one; None without an estimator.
        outside: Maximum share of time in which a true adhesion or pad friction was outside ±2σ of the estimate; None
            without an estimator.
        stop: Name of the stop in the campaign.
    """

    friction: str
    draw: int | None
    reference: Literal["published", "best tuned"] | None
    distance_m: float | None
    repeated: str
    duration_s: float | None
    reduction_vs_sbc: float | None
    reduction_vs_tuned: float | None
    utilisation: float | None
    paper_distance_m: float | None
    paper_reduction: float | None
    outcome: str
    breaks: tuple[str, ...]
    adhesion_peak: float | None
    longest_lock_s: float | None
    valve_strokes: int | None
    air_l: float | None
    nis: float | None
    outside: float | None
    stop: str
    range_m: tuple[float, float] | None = None


def short_names(rows: Iterable[Row]) -> tuple[str, dict[str, str]]:
    """Return the names of the axes that distinguish cases, and label of a row → its variants on these axes, one per
    line.

    Scenario and axes that are equal in all rows are omitted, unless there is only one case.
    """
    parts = {row.label: [f"scenario {row.scenario}", *filter(None, row.case.split(", "))] for row in rows}
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
