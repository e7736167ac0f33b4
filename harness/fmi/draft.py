"""A draft of [vehicle.map] for a plant from outside, by names, units, causality and sizes of arrays."""

import re
from collections.abc import Mapping
from contextlib import suppress
from difflib import SequenceMatcher

import numpy as np
from scipy.optimize import linear_sum_assignment

from railgrip.base.errors import FmuError
from railgrip.base.units import unit
from railgrip.fmi.description import Causality, Description, Variable
from railgrip.fmi.mapping import Signal

_ALSO = {
    "pressure_command": "demand brake_demand cylinder_demand pressure_demand",
    "mu0": "rail_grip grip friction rail_friction",
    "track_force": "drag resistance gradient_force",
    "start_speed": "v0 v_start speed_start initial_speed",
    "distance": "odometer position travelled",
    "speed": "velocity v train_speed",
    "acceleration": "retardation deceleration a",
    "wheelset_speed": "axle_speed wheel_speed omega n",
    "slip": "creep slide",
    "adhesion": "used_grip used_adhesion",
    "wheelset_load": "axle_load wheel_load",
    "cylinder_pressure": "cylinder brake_pressure pressure",
    "brake_torque": "brake_moment moment",
    "locked": "blocked",
}
"""Other words for our signals."""
_OPPOSITE = ("retardation", "deceleration", "drag", "resistance")
"""Names that count the other way round than ours."""
_LEAST = 0.6


def drafted(description: Description, signals: Mapping[str, tuple[Signal, Causality]]) -> dict[str, str]:
    """Return our name → variable or pattern of an FMU, best names first, each used once; what fits nothing is left out.

    Args:
        description: Of the FMU.
        signals: Our signals and what the FMU calls such variables.
    """
    arrays = _arrays(description)
    names, theirs = list(signals), list(arrays)
    score = np.array([[_score(*signals[name], pattern, arrays[pattern]) for pattern in theirs] for name in names])
    pairs = zip(*linear_sum_assignment(score, maximize=True), strict=True) if score.size else ()
    return {names[i]: _signed(theirs[j]) for i, j in pairs if score[i, j] >= _LEAST}


def _signed(pattern: str) -> str:
    return f"-{pattern}" if any(word in pattern.lower() for word in _OPPOSITE) else pattern


def _arrays(description: Description) -> dict[str, tuple[Variable, int]]:
    """Return pattern → first variable and number of elements, 0 for a scalar; {i} stands for the one index."""
    arrays: dict[str, tuple[Variable, int]] = {}
    for variable in description.variables.values():
        pattern, indices = re.subn(r"\[(\d+)\]", "[{i}]", variable.name)
        first, count = arrays.get(pattern, (variable, 0))
        arrays[pattern] = (first, count + 1 if indices == 1 else 0)
    return arrays


def _score(signal: Signal, causality: Causality, pattern: str, array: tuple[Variable, int]) -> float:
    """Return how alike the names are, 0 to 1; 0 when size, causality or dimension differ."""
    first, count = array
    fits = first.settable and first.causality != "input" if causality == "parameter" else first.causality == causality
    if not fits or count != signal.size or first.kind == "String":
        return 0.0
    with suppress(FmuError):
        theirs = first.unit or (unit(first.unit_name) if first.unit_name else None)
        if theirs is not None and theirs.exponents != unit(signal.unit).exponents:
            return 0.0
    bare = pattern.replace("[{i}]", "").lower()
    return max(SequenceMatcher(None, bare, name).ratio() for name in (signal.name, *_ALSO.get(signal.name, "").split()))
