"""One stop in a table of braking distances."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True, kw_only=True)
class Conditions:
    """Under which a stop was made, and by whom.

    Attributes:
        case: What else tells it apart: the variants of axes that the other columns do not show; most often empty.
        controller: Kind of the law.
        controller_label: What people call it, thresholds included.
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
        """Scenario and case, for people."""
        return f"{self.scenario}, {self.case}" if self.case else self.scenario

    @property
    def place(self) -> tuple[str, str, str, str, str]:
        """Scenario, case, creep curve, actuation and sensors: what controllers are compared on."""
        return self.scenario, self.case, self.polach, self.actuation, self.sensors


@dataclass(frozen=True, slots=True, kw_only=True)
class Row(Conditions):
    """A stop in the table.

    Attributes:
        draw: Seed of a stop that is one draw of a distribution.
        reference: Whether other stops are compared with it: with the published SBC, or with the best tuned one.
        distance_m: None unless the train stood at the end.
        repeated: Median and range of the distance when the plant's parameters move in the seventh digit, for people.
        reduction_vs_sbc: 1 − distance over that of the published SBC in the same conditions; None without either.
        reduction_vs_tuned: The same against the SBC with searched thresholds that stops shortest.
        utilisation: Of the adhesion that the ideal bound has; None for a stop that is none.
        paper_distance_m: As published; None for a stop that was not.
        paper_reduction: The published reduction against the published SBC.
        outcome: How the stop ended.
        longest_lock_s: Of any ω-group.
        valve_strokes: Of all groups; None without valves.
        air_l: Free air used, litres; None for a stop without a brake, such as the ideal bound.
        nis: Median squared innovation of the estimator over its expected one; None without an estimator.
        outside: Largest share of time that a true adhesion or pad friction was outside ±2σ; None without an estimator.
        stop: Name of the stop in the campaign.
    """

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
    longest_lock_s: float | None
    valve_strokes: int | None
    air_l: float | None
    nis: float | None
    outside: float | None
    stop: str
