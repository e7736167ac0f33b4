"""Named parameter sets of the control laws: one per kind of actuation, the same for every scenario.

They were chosen on the three scenarios of Schwarz, Posielek, Goetjes (2021) together, over several shapes of the
adhesion curve, for short distances on all of them; no set is fitted to one scenario.
"""

from controllers.adhesion_based import SeekerTuning
from controllers.slip_based import SlipLevels

SLIP_LEVELS = SlipLevels(low=0.10, high=0.15, speed_min=0.5, hold=False)
"""Two-level control as in Schwarz, Posielek, Goetjes (2021), §4."""

SEEKER = {
    "ideal": SeekerTuning(
        period=1e-3,
        filter_time=10e-3,
        margin=0.02,
        rise=0.15,
        fall=0.25,
        slip_rate_max=8.0,
        slip_rate_min=0.1,
        dwell=0.03,
        slip_small=0.003,
        slip_vent=0.35,
        adhesion_small=0.015,
        adhesion_max=0.15,
        adhesion_guard=0.003,
        speed_min=0.5,
    ),
    "pneumatic": SeekerTuning(
        period=10e-3,
        filter_time=0.1,
        margin=0.02,
        rise=0.10,
        fall=0.25,
        slip_rate_max=3.0,
        slip_rate_min=0.3,
        dwell=0.2,
        slip_small=0.003,
        slip_vent=0.35,
        adhesion_small=0.015,
        adhesion_max=0.15,
        adhesion_guard=0.003,
        speed_min=0.5,
    ),
}
"""Adhesion-based control; `period` and `adhesion_max` are replaced by the scenario's."""

VALVE_BAND = 6e3
"""Half width [Pa] of the band in which valves hold; a pulse of 20 ms fills or vents some 15 kPa at mid pressure."""

VALVE_PULSE_MIN = 20e-3
"""Shortest time [s] a valve stays as it is: valves with 20-40 ms of minimum pulse are in service."""
