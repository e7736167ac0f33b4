"""What the train reads of itself at a sample, and where it stands in the vector of a reading.

The outputs of the larger prediction model and, behind them, the brake cylinder pressures. An entry is NaN where the
sensor has nothing new at that sample.
"""

from types import MappingProxyType

from harness.record.signals import GROUPS, WHEELSETS

READING = MappingProxyType(
    {
        "speed": slice(0, 1),
        "wheelset_speed": slice(1, 1 + GROUPS),
        "deflection": slice(1 + GROUPS, 1 + GROUPS + WHEELSETS),
        "acceleration": slice(1 + GROUPS + WHEELSETS, 2 + GROUPS + WHEELSETS),
        "cylinder_pressure": slice(2 + GROUPS + WHEELSETS, 2 + 2 * GROUPS + WHEELSETS),
    }
)
"""Name → its place in a reading."""

READINGS = 2 + 2 * GROUPS + WHEELSETS
"""Length of a reading."""
