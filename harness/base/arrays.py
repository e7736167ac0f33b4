"""Types of arrays, and random numbers in them; docstrings state the shapes."""

import hashlib
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Array = NDArray[np.float64]
"""An array of any shape."""
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]


def generator(seed: int, purpose: str) -> np.random.Generator:
    """Return the stream of random numbers for one purpose of one scenario.

    Each purpose ("adhesion", "sensors.wheel" …) has a separate stream, so that an additional sensor does not change the
    rail.
    """
    purpose_number = int.from_bytes(hashlib.sha256(purpose.encode()).digest()[:8], "big")
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, purpose_number])))


def markov(white: NDArray[np.float64], persistence: float) -> NDArray[np.float64]:
    """Return first-order Gauss–Markov noise of unit variance from white noise w.

    x[k+1] = ρ x[k] + √(1 − ρ²) w[k+1], starting at x[0] = w[0], with ρ the persistence.
    """
    fresh = np.sqrt(1.0 - persistence**2) * white
    fresh[0] = white[0]
    # In plain Python: SciPy's filter takes half a second to import, this a tenth of a microsecond per value.
    values = accumulate(fresh.tolist(), lambda before, new: new + persistence * before)
    return np.fromiter(values, np.float64, fresh.size)
