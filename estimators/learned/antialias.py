"""From the loggers' rate down to one at which wheelsets move."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfilt

from railgrip.estimators.arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class AntiAlias:
    """A causal low-pass, of which one sample in so many is kept.

    Attributes:
        rate: Samples a second that go in.
        keep: One of so many comes out.
    """

    rate: int
    keep: int

    @property
    def slow_rate(self) -> float:
        """Samples a second that come out."""
        return self.rate / self.keep

    @property
    def sections(self) -> Array:
        """Butterworth of fourth order at 0.3 of the slow rate, as second-order sections."""
        return np.asarray(butter(4, 0.3 * self.slow_rate, fs=self.rate, output="sos"), dtype=np.float64)

    def __call__(self, raw: Array) -> Array:
        """Return the slow signal, shape (n // keep, channels), relative to the first sample."""
        return self.every(np.asarray(sosfilt(self.sections, raw - raw[0], axis=0), dtype=np.float64))

    def every(self, raw: Array) -> Array:
        """Return the samples that are kept, as they are, shape (n // keep, …)."""
        return np.asarray(raw[self.keep - 1 :: self.keep], dtype=np.float64)
