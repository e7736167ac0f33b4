"""The edge of a train plant as signals to bind: what every plant is sent and may answer."""

from collections.abc import Collection
from typing import Final, Literal

from harness.fmu.failure import FmuError
from harness.fmu.mapping import Signal
from harness.record.signals import GROUPS, PLANT, WHEELSETS

COMMANDS: Final = {"ideal": ("pressure_command", "Pa"), "pneumatic": ("valve_command", "1")}
"""Actuation → the command's name at the edge, and its unit; valves take −1 dump, 0 hold, +1 fill."""

LOOP_NEEDS: Final = frozenset({"speed", "distance", "acceleration", "wheelset_speed", "cylinder_pressure"})
"""Outputs without which no stop can be run: sensors read them, or the loop ends by them."""


def sent(actuation: Literal["ideal", "pneumatic"], *, graded: bool) -> tuple[Signal, ...]:
    """Return the inputs of a train plant, in the order of the loop.

    Args:
        actuation: What a command means.
        graded: The track has gradients or curves, so that a plant must take their force.
    """
    name, unit = COMMANDS[actuation]
    return (
        Signal(name=name, unit=unit, size=GROUPS, needed=True),
        Signal(name="mu0", unit="1", size=WHEELSETS, needed=True),
        Signal(name="track_force", unit="N", size=0, needed=graded),
    )


def answered(needed: Collection[str]) -> tuple[Signal, ...]:
    """Return the outputs of a train plant, in the order of the loop.

    Args:
        needed: Names of those without which this stop cannot be run, beyond `LOOP_NEEDS`: an estimator with
            suspension needs `deflection`.

    Raises:
        FmuError: A name that is no output of a train plant.
    """
    known = {s.name for s in PLANT}
    for name in needed:
        if name not in known:
            raise FmuError(f"no plant has an output '{name}'; a plant may have {', '.join(sorted(known))}.")
    wanted = LOOP_NEEDS | set(needed)
    return tuple(
        Signal(name=s.name, unit=s.unit, size=0 if s.extent == "train" else s.width, needed=s.name in wanted)
        for s in PLANT
    )
