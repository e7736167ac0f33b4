"""What crosses the edge of the plant, and where it stands in the vectors that do."""

from types import MappingProxyType

from harness.record.signals import GROUPS, PLANT, WHEELSETS

COMMAND = slice(0, GROUPS)
FRICTION = slice(GROUPS, GROUPS + WHEELSETS)
FORCE = GROUPS + WHEELSETS
INPUTS = FORCE + 1
"""The plant's inputs: a command for each group, mu0 of each wheelset, the force of the track."""


def _columns() -> dict[str, slice]:
    columns: dict[str, slice] = {}
    first = 0
    for signal in PLANT:
        columns[signal.name] = slice(first, first + signal.width)
        first += signal.width
    return columns


OUTPUT = MappingProxyType(_columns())
"""Name of a plant output → its place in the vector of outputs."""

OUTPUTS = sum(signal.width for signal in PLANT)
"""Length of the vector of outputs."""
