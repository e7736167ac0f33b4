"""Where every random draw of a stop comes from."""

import hashlib
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray


def generator(seed: int, purpose: str) -> np.random.Generator:
    """Return the stream of random numbers for one purpose of one scenario.

    Each purpose ("adhesion", "sensors.wheel" …) has its own stream, so that a sensor more leaves the rail as
    it was.
    """
    purpose_number = int.from_bytes(hashlib.sha256(purpose.encode()).digest()[:8], "big")
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, purpose_number])))


def markov(white: NDArray[np.float64], persistence: float) -> NDArray[np.float64]:
    """Return first-order Gauss–Markov noise of unit variance made of white noise w.

    x[k+1] = ρ x[k] + √(1 − ρ²) w[k+1] from x[0] = w[0] on, with ρ the persistence.
    """
    fresh = np.sqrt(1.0 - persistence**2) * white
    fresh[0] = white[0]
    # In plain Python: SciPy's filter takes half a second to load, this a tenth of a microsecond a value.
    values = accumulate(fresh.tolist(), lambda before, new: new + persistence * before)
    return np.fromiter(values, np.float64, fresh.size)
