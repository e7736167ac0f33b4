"""Figures of what the brake itself spent: air and valve strokes."""

import numpy as np
import xarray


def air_used(trace: xarray.Dataset) -> float:
    """Return the free air taken from the reservoir since the brake demand [m3]."""
    air = trace["air_used"].values
    return float(air[-1] - air[0])


def actuations(trace: xarray.Dataset, actuation: str) -> tuple[int, ...]:
    """Return how often the brake of each group was switched.

    Pneumatic: changes of the commanded valve position (dump, hold, fill; thresholds at ±0.5). Ideal: turns of
    the commanded pressure from rising to falling or back, holds between them left out.
    """
    command = trace["command"].values
    if actuation == "pneumatic":
        position = np.where(command > 0.5, 1, np.where(command < -0.5, -1, 0))
        return tuple(int(np.count_nonzero(np.diff(column))) for column in position.T)
    return tuple(_turns(np.diff(column)) for column in command.T)


def _turns(change: np.ndarray[tuple[int], np.dtype[np.float64]]) -> int:
    directions = np.sign(change[change != 0])
    return int(np.count_nonzero(np.diff(directions)))
