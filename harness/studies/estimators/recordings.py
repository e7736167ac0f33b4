"""The recordings: stops of the two-part train, spread evenly over what an estimator may meet."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, Literal

import numpy as np
import xarray

import railgrip.scenario
from railgrip.estimation.sources import stop_read
from railgrip.recording.samples import with_signals
from railgrip.scenario.load import read_toml, scenario_of
from railgrip.scenario.merge import merge
from railgrip.studies.type_test.design import FAULTS, Case, cases, ranks

COUNT, QUICK = 48, 4
"""Number of cases of each set, and of a quick run."""

SEEDS: Final = MappingProxyType({"training": 31, "test": 32, "sealed": 33})
"""Seeds of the sets: numbers are searched on the first, reported on the second, and the third is for a finished
estimator."""

Sensors = Literal["ideal", "service", "worn"]
SENSORS: Final[tuple[Sensors, ...]] = ("ideal", "service", "worn")

GROUPS: Final = 4
PERIOD: Final = 0.01
"""Of recordings and estimators [s]."""

LENGTH: Final = 30
"""Duration of a recording [s], if the train is not at standstill before; the filters need no more, and cost time."""

DEMANDS: Final[Mapping[str, Any]] = MappingProxyType(
    {
        "full": {},
        "steps": {
            "phases": [
                {"pressure": "1.0 bar", "until": {"duration": "4 s"}},
                {"pressure": "2.0 bar", "until": {"duration": "4 s"}},
                {"pressure": "full"},
            ]
        },
        "release": {
            "phases": [
                {"pressure": "full", "until": {"duration": "4 s"}},
                {"pressure": 0, "until": {"duration": "3 s"}},
                {"pressure": "full"},
            ]
        },
        "traction": {
            "phases": [
                {
                    "pressure": 0,
                    "traction": {"force": "60 kN", "power": "800 kW", "rate": "30 kN/s"},
                    "until": {"duration": "4 s"},
                },
                {"pressure": 0, "until": {"duration": "3 s"}},
                {"pressure": "full"},
            ]
        },
    }
)
"""Demand of the driver → [demand] of the scenario: full brake, service steps, a release in between, and traction with
coasting before the brake."""

WORN: Final[Mapping[str, Any]] = MappingProxyType(
    {
        "wheel": {"pitch_error": "0.6 %"},
        "speed": {"noise": "0.2 m/s", "scale_error": "0.6 %"},
        "acceleration": {"noise": "0.06 m/s**2", "bias": "0.1 m/s**2"},
        "deflection": {"noise": "0.4 mm"},
        "pressure": {"error": "1 %"},
    }
)
"""Noise, scale, pitch and bias errors of worn sensors, twice those of equipment/service.toml."""

_ROOT = Path(railgrip.scenario.__file__).parent


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingCase:
    """A stop that is recorded.

    Attributes:
        stop: Rail, train and fault, a case of the type test with other speeds and seeds.
        sensors: Quality of the sensors; with ideal ones the actuation is ideal, else there are valves.
        demand: Key of `DEMANDS`.
        over: Whether friction changes over time or along the track.
    """

    stop: Case
    sensors: Sensors
    demand: str
    over: Literal["time", "distance"]


def recording_cases(count: int, seed: int) -> tuple[RecordingCase, ...]:
    """Return a number of cases, the same ones for the same seed.

    Sensors, demand and dimension of the friction are further axes, each as even as those of the type test.
    """
    choices: list[RecordingCase] = []
    for stop, (first, second, third) in zip(cases(count, seed), ranks(count, 3, seed), strict=True):
        choices.append(
            RecordingCase(
                stop=stop,
                sensors=SENSORS[int(first * len(SENSORS))],
                demand=tuple(DEMANDS)[int(second * len(DEMANDS))],
                over="distance" if third > 0.5 else "time",
            )
        )
    return tuple(choices)


@lru_cache(maxsize=2)
def recording_of_case(case: RecordingCase) -> xarray.Dataset:
    """Run the stop of a case and return its trace on the grid of the estimators.

    The controller uses no estimate, so that the recording does not depend on an estimator. The force of the track is
    unknown on board, its reading is 0.
    """
    table = read_toml(_ROOT / "library" / "trapezoid.toml")
    if case.sensors != "ideal":
        table = merge(table, read_toml(_ROOT / "equipment" / "service.toml"))
    tables = case.stop.tables(GROUPS)
    table |= {
        "adhesion": _along(tables.pop("adhesion"), case),
        "estimator": {"kind": "none"},
        "controller": {"kind": "slip_three_state"},
        "periods": {"communication": "1 ms", "estimator": "10 ms", "controller": "10 ms", "trace": "10 ms"},
    }
    if case.sensors == "worn":
        table = merge(table, {"sensors": WORN})
    if DEMANDS[case.demand]:
        table["demand"] = DEMANDS[case.demand]
    table = merge(merge(table, tables | {"limits": {"horizon": f"{LENGTH} s"}}), FAULTS[_fault(case)])
    trace = stop_read(scenario_of(table, directory=_ROOT / "library", origin=case.stop.name), case.stop.name)
    return with_signals(trace, {"track_force": (np.zeros(trace.sizes["time"]), "N")})


def _fault(case: RecordingCase) -> str:
    """Return the fault of a case; ideal actuation has neither valves nor an air supply that may fail."""
    needs_valves = case.stop.fault in {"valve held", "valve slow", "supply sagging"}
    return "none" if needs_valves and case.sensors == "ideal" else case.stop.fault


def _along(adhesion: dict[str, Any], case: RecordingCase) -> dict[str, Any]:
    """Return [adhesion] over time or distance; a second is the distance of half the speed at the start."""
    if case.over == "time" or "over" not in adhesion:
        return adhesion
    metres = {
        key: f"{float(value.removesuffix(' s')) * case.stop.speed / 2:.1f} m"
        for key, value in adhesion.items()
        if isinstance(value, str) and value.endswith(" s")
    }
    return adhesion | metres | {"over": "distance"}
