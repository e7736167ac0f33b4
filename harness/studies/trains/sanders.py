"""The trial of sanders: the density of sand is fitted on one of its five distances.

The other four are not a blind prediction: further assumptions of the trial were chosen with all five known.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, StrictBool, model_validator
from scipy.optimize import root_scalar

from railgrip.rolling_stock.schema import load_train
from railgrip.rolling_stock.stopping import by_hand
from railgrip.scenario.file import merge
from railgrip.scenario.load import read_toml, scenario_of, validate_table
from railgrip.scenario.quantity import UnitRange
from railgrip.scenario.schema import Scenario
from railgrip.scenario.table import Friction, Speed, Table, table_error
from railgrip.simulate.run import braking_distance
from railgrip.studies.trains.stops import LIBRARY

_FRICTION = 0.02  # of the untreated rail in the trial
_HORIZON = 200.0  # s
_CLOSE = 0.005  # of the density, relative: some metres

Metres = Annotated[float, UnitRange("m", above=0, at_most=1e5)]
Density = Annotated[float, UnitRange("kg/m", above=0, at_most=1)]


class SanderDistance(Table):
    """One of the distances of a trial."""

    sanders: str
    measured: Metres
    at_least: StrictBool = Field(default=False, description="whether the trial only states that it was longer")
    laid: tuple[dict[str, Any], ...]


class SandLaw(Table):
    """Assumptions on sand, and bounds of the search for its density."""

    mu0: Friction
    left: Annotated[float, UnitRange("1", at_least=0, at_most=1)]
    density: tuple[Density, Density]


class SanderTrial(Table):
    """A trial of sanders, `library/sanders.toml`."""

    speed: Speed
    demanded: Annotated[float, UnitRange("m/s2", above=0, at_most=5)]
    train: str
    fitted: str
    source: str
    law: SandLaw
    rows: tuple[SanderDistance, ...]

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.fitted not in {row.sanders for row in self.rows}:
            raise table_error(f"fitted is '{self.fitted}', which no row is called")
        return self


Comparison = Mapping[str, Any]
"""A distance of the trial and the simulated one, as in sanders.json: `sanders`; `distance_m`, None for a train that did
not stop within the horizon; `measured_m`; `fitted`, whether the density of sand was fitted to it; `at_least`, true
where the trial gives only a bound."""


def trial_of() -> SanderTrial:
    """Return the trial to compare with."""
    path = LIBRARY / "sanders.toml"
    return validate_table(SanderTrial, read_toml(path), directory=path.parent, origin=path.name)


def scenario_tables(trial: SanderTrial) -> dict[str, Any]:
    """Return the tables that all stops of a trial have in common: its train, demand, rail and protection."""
    train = load_train(Path(trial.train))
    # Pad force, and with it the deceleration, is even in the pressure beyond that of the spring.
    share = min(trial.demanded / by_hand(train, trial.speed).deceleration, 1.0)
    brakes = [train.bogie_of(group).brake for group in range(len(train.groups))]
    springs = [brake.spring_force / brake.piston_area for brake in brakes]
    pressure = [spring + share * (brake.pressure_max - spring) for brake, spring in zip(brakes, springs, strict=True)]
    return merge(
        read_toml(LIBRARY / "dry.toml"),
        {
            "name": "sanders",
            "vehicle": {"train": trial.train},
            "start": {"speed": trial.speed},
            "adhesion": {"polach": "wet", "mu0": _FRICTION},
            "controller": {"kind": "slip_three_state"},
            "demand": {"phases": [{"pressure": pressure}]},
            "limits": {"horizon": _HORIZON},
        },
    )


def scenario_of_row(trial: SanderTrial, row: SanderDistance, density: float, tables: dict[str, Any]) -> Scenario:
    """Return the stop of a row with a density of sand."""
    changes: dict[str, Any] = {}
    if row.laid:
        law = {"mu0": trial.law.mu0, "left": trial.law.left, "density": density}
        changes = {"adhesion": {"sand": law}, "sanders": [dict(sander) for sander in row.laid]}
    return scenario_of(merge(tables, changes), directory=LIBRARY, origin="sanders.toml")


def compare(trial: SanderTrial) -> tuple[float, list[Comparison]]:
    """Fit the density of sand on one distance; return it [kg/m] and all distances."""
    tables = scenario_tables(trial)
    fitted = next(row for row in trial.rows if row.sanders == trial.fitted)

    def excess(density: float) -> float:
        distance = braking_distance(scenario_of_row(trial, fitted, density, tables))
        return (trial.speed * _HORIZON if distance is None else distance) - fitted.measured

    density = float(root_scalar(excess, bracket=trial.law.density, rtol=_CLOSE).root)
    return density, [
        {
            "sanders": row.sanders,
            "distance_m": braking_distance(scenario_of_row(trial, row, density, tables)),
            "measured_m": row.measured,
            "fitted": row is fitted,
        }
        | ({"at_least": True} if row.at_least else {})
        for row in trial.rows
    ]
