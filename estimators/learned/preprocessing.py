"""The paper's data processing: high-pass, low-pass, absolute value, block means, scaling to [−1, 1].

Source: Abduraxman et al. (2024), section "Data processing". Choices it leaves open, made here: both filters run
forwards only, in double precision; the high-pass is of first order and starts with its state at the first sample; the
low-pass is a Butterworth of second order that starts at rest; blocks that are not full at the end are dropped.
"""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from scipy.signal import butter, lfilter, sosfilt

from railgrip.estimators.belief import Array


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


Start = Literal["first sample", "first second"]

BLOCKS: Final = {60: 50, 40: 100, 26: 150, 16: 200}
"""Samples averaged, by speed in mph."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """The filters in front of a network.

    Attributes:
        rate: Samples a second that go in.
        block: Samples that are averaged into one that comes out.
        high_pass, low_pass: Corner frequencies, Hz.
        order: Of the low-pass.
        start: What the high-pass takes for zero: the first sample, vibration included, or the mean of the first second.
            The second is not causal within that second; it is there to show what the first one does to a network.
    """

    rate: int
    block: int
    high_pass: float = 1e-4
    low_pass: float = 1.0
    order: int = 2
    start: Start = "first sample"

    @property
    def remembers(self) -> float:
        """Share of its value that the high-pass keeps from sample to sample (bilinear transform)."""
        return (1 - self._warped) / (1 + self._warped)

    @property
    def _warped(self) -> float:
        return float(np.tan(np.pi * self.high_pass / self.rate))

    @property
    def sections(self) -> Array:
        """The low-pass as second-order sections, shape (sections, 6)."""
        return np.asarray(butter(self.order, self.low_pass, fs=self.rate, output="sos"), dtype=np.float64)

    def filtered(self, raw: Array) -> Array:
        """Return high- and low-passed accelerations at the full rate, shape of `raw` (n, channels)."""
        zero = raw[0] if self.start == "first sample" else raw[: self.rate].mean(axis=0)
        gain = 1 / (1 + self._warped)
        high = lfilter([gain, -gain], [1, -self.remembers], raw - zero, axis=0)
        return np.asarray(sosfilt(self.sections, high, axis=0), dtype=np.float64)

    def process(self, raw: Array) -> Array:
        """Return what goes into the scaling: absolute values, averaged, shape (n // block, channels)."""
        size = np.abs(self.filtered(raw))
        count = len(size) // self.block
        return size[: count * self.block].reshape(count, self.block, -1).mean(axis=1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Scale:
    """Maps each channel to [−1, 1] over the data it was made from.

    Attributes:
        lowest, highest: Shape (channels,).
    """

    lowest: Array
    highest: Array

    @classmethod
    def over(cls, data: Array) -> "Scale":
        """Return the scale of data, shape (n, channels)."""
        return cls(lowest=data.min(axis=0), highest=data.max(axis=0))

    def __call__(self, data: Array) -> Array:
        """Return scaled data; what lies outside the data of the scale comes out beyond ±1."""
        return 2 * (data - self.lowest) / (self.highest - self.lowest) - 1
