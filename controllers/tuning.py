"""Named parameter sets of the control laws: one per kind of actuation, the same for every scenario.

What `railgrip tune-control` searches lies in a file for each law beside this one, with a table for each kind of
actuation and each way to know the slip; a law of `TWICE` has a second one, `<law>.type_test.toml`. What is not searched
is physics, or a limit that somebody else set, and says so here.
"""

import tomllib
from collections.abc import Mapping
from importlib.resources import files
from typing import Literal

from railgrip.controllers.adhesion_based import PeakSeekingTuning
from railgrip.controllers.slip_based import SlipLevels
from railgrip.controllers.slope_seeking import SlopeTuning

SlipSource = Literal["read", "estimated"]
"""How a law knows the slip: from readings alone, or from an estimator."""


TWICE = frozenset({"slip_two_state", "slip_three_state", "adhesion_based"})
"""Laws searched on the campaign `training`, which the tables of the papers hang on, and once more on the training
cases of the type test. The others have one set for valves, searched on those cases."""


def file_of(law: str, *, type_test: bool) -> str:
    """Return the name of the file with a law's parameters: for the type test, or for everything else."""
    return f"{law}.type_test.toml" if type_test and law in TWICE else f"{law}.toml"


def _sets(file: str) -> Mapping[str, Mapping[str, Mapping[str, float]]]:
    return tomllib.loads((files("railgrip.controllers") / file).read_text(encoding="utf-8"))


def searched(law: str, actuation: str, slip: SlipSource, *, type_test: bool = False) -> Mapping[str, float]:
    """Return what was found for a law, on rails that no result is reported of.

    Raises:
        ValueError: The law was not searched for that, or not with this actuation and this way to know the slip.
    """
    if type_test and law not in TWICE:
        raise ValueError(f"{law} has no set of its own for the type test; there is one of {', '.join(sorted(TWICE))}")
    sets = _sets(file_of(law, type_test=type_test))
    if slip not in sets.get(actuation, {}):
        known = ", ".join(f"{one} actuation and {source} slip" for one, of_one in sets.items() for source in of_one)
        raise ValueError(f"{law} has no set for {actuation} actuation and {slip} slip; there is {known}")
    return sets[actuation][slip]


FIXED: Mapping[str, Mapping[str, float]] = {
    # Criteria of slip are searched; an axle may be vented for 5 to 10 s before it has to brake again, and the last
    # kilometres per hour are left to the brake.
    "wheel_reference": {"filter_time": 0.03, "test_time": 0.6, "vent_max": 7.0, "apply_time": 1.0, "speed_min": 1.4},
    "constant_slip": {"speed_min": 0.5},
    # Peaks lie between these slips; wheels that hardly brake say nothing about the rail.
    "extremum_seeking": {"slip_least": 0.005, "slip_most": 0.3, "adhesion_small": 0.01, "speed_min": 0.5},
    # Filters and bounds of rates are slower than valves and quicker than the rail; the limit of adhesion is the TSI's.
    "slope_seeking": {
        "period": 10e-3,
        "filter_time": 0.03,
        "pressure_lag": 0.0,
        "correlation_time": 0.1,
        "log_slip_noise": 0.03,
        "rise_rate": 0.8,
        "fall_rate": 0.8,
        "slip_most": 0.42,
        "gain": 5.0,
        "share_added": 0.3,
        "slip_small": 0.006,
        "slip_vent": 0.45,
        "adhesion_max": 0.15,
        "adhesion_guard": 0.003,
        "speed_min": 0.5,
    },
}
"""What is not searched of the laws that have no set of their own below."""


def of(law: str, actuation: str, slip: SlipSource) -> dict[str, float]:
    """Return all parameters of a law of `FIXED`, but for its period.

    What its slip comes from matters to a law that looks at it; one with a single way to know it has a single set.
    """
    sets = _sets(f"{law}.toml")[actuation]
    return {**FIXED[law], **sets.get(slip, next(iter(sets.values())))}


PAPER_LEVELS = SlipLevels(low=0.10, high=0.15, speed_min=0.5, hold=False)
"""Two-level control as in Schwarz, Posielek, Goetjes (2021), §4."""


def _peak_seeking(actuation: str, period: float) -> PeakSeekingTuning:
    """Return what was found, and what is not searched for.

    Ideal sensors tell any slip from none, and 0.3 % lies below all published peaks; below 0.5 m/s slip is the ratio of
    two small numbers. 0.15 is the limit of the TSI, which the guard keeps an estimate with an error of 0.003 from
    passing.
    """
    fixed = {"slip_small": 0.003, "creep_small": 0.0, "adhesion_guard": 0.003, "speed_min": 0.5}
    values = searched("adhesion_based", actuation, "estimated")
    return PeakSeekingTuning(period=period, adhesion_max=0.15, **(fixed | dict(values)))


PEAK_SEEKING = {"ideal": _peak_seeking("ideal", 1e-3), "pneumatic": _peak_seeking("pneumatic", 10e-3)}
"""Adhesion-based control; `period` and `adhesion_max` are replaced by the scenario's."""

SLOPE = SlopeTuning(**of("slope_seeking", "pneumatic", "estimated"))
"""Slope-seeking control, one set for every actuation; `period`, `pressure_lag`, `adhesion_max` are the scenario's."""

VALVE_BANDS = {"slope_seeking": 20e3}
"""Half width [Pa] of the valves' band under laws that want another than `VALVE_BAND`.

A set point that moves all the time asks for a pulse at every decision; with 20 instead of 6 kPa a slide costs half the
strokes, and no distance."""

VALVE_BAND = 6e3
"""Half width [Pa] of the band in which valves hold: the shortest pulse, 20 ms, fills or vents some 15 kPa at mid
pressure, and a band narrower than half of that would be jumped over. On the training rails 3 to 12 kPa move the mean
distance of adhesion-based control by 0.2 %."""

VALVE_PULSE_MIN = 20e-3
"""Shortest time [s] a valve stays as it is: valves with 20-40 ms of minimum pulse are in service."""
