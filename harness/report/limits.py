"""Limits that a stop is judged by: clauses of standards on locked wheels, air and use of the adhesion."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Final

import numpy as np
from pydantic import Field

from railgrip.report.statistics import finite
from railgrip.report.stop import Stop
from railgrip.scenario.load import read_toml, validate_table
from railgrip.scenario.quantity import Number, UnitRange
from railgrip.scenario.table import Table
from railgrip.trace.metrics import FIGURES

_FILE: Final = Path(__file__).parent / "library" / "limits.toml"
_AMBIENT: Final = 101325.0  # Pa


class LimitClause(Table):
    """One line of the verdict: a figure, its limit, and its name in the standard."""

    clause: str
    limit: Number | None = Field(default=None, description="in SI units; without one the figure is not judged")
    adhesion: tuple[Number, Number] | None = Field(
        default=None, description="lowest and highest adhesion at the first slide for which the clause is quoted"
    )


class Supply(Table):
    """Air supply of the brakes for plants without a reservoir."""

    volume: Annotated[float, UnitRange("m3", above=0, at_most=100)]
    pressure: Annotated[float, UnitRange("Pa", above=0, at_most=2e6)] = Field(description="when the stop begins, gauge")
    delivery: Annotated[float, UnitRange("m3/s", between=(0, 1))] = Field(description="free air of the compressor")

    def remaining(self, air: float, duration: float) -> float:
        """Return the pressure at the end [Pa], for free air used [m3] in a time [s], at constant temperature."""
        drained = air - self.delivery * duration
        return float(np.clip(self.pressure - _AMBIENT * drained / self.volume, 0.0, self.pressure))


class BuildUp(Table):
    """How a deceleration distance is formed."""

    time: Annotated[float, UnitRange("s", between=(0, 60))]


class AssessmentLimits(Table):
    """The limits of a type test and of a campaign's page; see library/limits.toml."""

    stops: LimitClause
    extension: LimitClause
    lock: LimitClause
    locked_distance: LimitClause
    reservoir: LimitClause
    utilisation: LimitClause
    supply: Supply
    build_up: BuildUp

    def verdicts(self, values: Mapping[str, float | None], adhesion: float | None = None) -> dict[str, bool | None]:
        """Return for each clause whether its value keeps the limit; None where the clause is not judged.

        Args:
            values: Clause → value in SI units, or None if it is missing.
            adhesion: At the first slide; without it, clauses that are quoted for a range of adhesion are not judged.
        """
        verdicts: dict[str, bool | None] = {}
        for name, value in values.items():
            clause: LimitClause = getattr(self, name)
            is_quoted = clause.adhesion is None or (
                adhesion is not None and clause.adhesion[0] <= adhesion <= clause.adhesion[1]
            )
            if clause.limit is None or value is None or not is_quoted:
                verdicts[name] = None
            else:
                verdicts[name] = value >= clause.limit if name in _MINIMA else value <= clause.limit
        return verdicts

    def find_violations(self, stop: Stop) -> tuple[str, ...]:
        """Return the clauses that a stop breaks by itself, without another stop to compare with."""
        figures = stop.figures
        values = {figure.clause: finite(figures.of_train(name)) for name, figure in FIGURES.items() if figure.clause}
        if (air := values["reservoir"]) is not None:
            values["reservoir"] = self.supply.remaining(air, figures.duration)
        verdicts = {"stops": stop.braking_distance is not None} | self.verdicts(values)
        return tuple(name for name in SUBJECTS if verdicts.get(name) is False)


SUBJECTS: Final = {
    "stops": "standstill",
    "extension": "extension",
    "lock": "locked wheels",
    "locked_distance": "locked distance",
    "reservoir": "air in the reservoir",
    "utilisation": "use of the adhesion",
}
"""Clause → name of the limited quantity for readers."""

_UNITS: Final = {figure.clause: figure.unit_text for figure in FIGURES.values() if figure.clause} | {"reservoir": "Pa"}
"""Clause of a figure → unit of its limit; the air used limits the pressure that remains in the reservoir."""

_MINIMA: Final = {figure.clause for figure in FIGURES.values() if figure.better == "more"} | {"reservoir"}
"""Clauses whose limit is a minimum; the limits of the others are maxima."""


def limits_of(path: Path | None = None) -> AssessmentLimits:
    """Return the limits of a file, or those that come with this package.

    Raises:
        ScenarioError: The file is missing or does not hold limits.
    """
    file = path or _FILE
    return validate_table(AssessmentLimits, read_toml(file), directory=file.parent, origin=file.name)


def describe_clauses(limits: AssessmentLimits) -> str:
    """Return the clauses that a stop can break by itself with their limits, in SI units."""
    texts = [
        f"{subject}, {'minimum' if name in _MINIMA else 'maximum'} {f'{clause.limit:g} {_UNITS[name]}'.strip()}"
        for name, subject in SUBJECTS.items()
        if name in _UNITS and (clause := getattr(limits, name)).limit is not None
    ]
    return "; ".join(["standstill", *texts])
