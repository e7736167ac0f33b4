"""Named parameter sets of the control laws: one per kind of actuation, the same for every scenario."""

import tomllib
from importlib.resources import files

from controllers.adhesion_based import SeekerTuning
from controllers.slip_based import SlipLevels

SLIP_LEVELS = SlipLevels(low=0.10, high=0.15, speed_min=0.5, hold=False)
"""Two-level control as in Schwarz, Posielek, Goetjes (2021), §4."""

SOUGHT = "seeker.toml"
"""File beside this one: what `make tune-control` found, on rails that no result is reported of."""


def _seeker(actuation: str, period: float) -> SeekerTuning:
    """Return what was found, and what is not searched for.

    Ideal sensors tell any slip from none, and 0.3 % lies below all published peaks; 35 % lies beyond those of all
    published curves but the flattest; below 0.5 m/s slip is the ratio of two small numbers. 0.15 is the limit of the
    TSI, which the guard keeps an estimate with an error of 0.003 from passing.
    """
    found = tomllib.loads((files("controllers") / SOUGHT).read_text(encoding="utf-8"))[actuation]
    fixed = {"slip_small": 0.003, "slip_vent": 0.35, "adhesion_small": 0.015, "speed_min": 0.5}
    return SeekerTuning(period=period, adhesion_max=0.15, adhesion_guard=0.003, **(fixed | found))


SEEKER = {"ideal": _seeker("ideal", 1e-3), "pneumatic": _seeker("pneumatic", 10e-3)}
"""Adhesion-based control; `period` and `adhesion_max` are replaced by the scenario's."""

VALVE_BAND = 6e3
"""Half width [Pa] of the band in which valves hold; a pulse of 20 ms fills or vents some 15 kPa at mid pressure."""

VALVE_PULSE_MIN = 20e-3
"""Shortest time [s] a valve stays as it is: valves with 20-40 ms of minimum pulse are in service."""
