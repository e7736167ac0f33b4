"""Where every random draw of a stop comes from."""

import hashlib

import numpy as np


def generator(seed: int, purpose: str) -> np.random.Generator:
    """Return the stream of random numbers for one purpose of one scenario.

    Each purpose ("adhesion", "sensors.wheel" …) has its own stream, so that a sensor more leaves the rail as
    it was.
    """
    purpose_number = int.from_bytes(hashlib.sha256(purpose.encode()).digest()[:8], "big")
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, purpose_number])))
