"""Which motions of the wheelsets an estimator listens to."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from scipy.signal import butter, lfilter, sosfilt

from railgrip.estimators.belief import Array

Motion = Literal["longitudinal", "lateral", "yaw", "left", "right"]

COMBINATIONS: Final[Mapping[str, tuple[Motion, ...]]] = {
    "longitudinal, lateral, yaw": ("longitudinal", "lateral", "yaw"),
    "longitudinal, lateral": ("longitudinal", "lateral"),
    "longitudinal, yaw": ("longitudinal", "yaw"),
    "lateral, yaw": ("lateral", "yaw"),
    "left, right": ("left", "right"),
    "longitudinal": ("longitudinal",),
    "lateral": ("lateral",),
    "yaw": ("yaw",),
}
"""The eight combinations of Abduraxman et al. (2024), each over all wheelsets; `longitudinal` is the one they chose."""


def motions(left: Array, right: Array, lateral: Array, combination: str) -> Array:
    """Return the channels of a combination, m/s², shape (n, 4 to 12): motion by motion, wheelset by wheelset.

    Longitudinal is the mean of both axle boxes; yaw is right minus left, which is the yaw acceleration times the
    distance of the boxes.

    Args:
        left, right: Longitudinal accelerations of the axle boxes, m/s², shape (n, wheelsets).
        lateral: m/s², shape (n, wheelsets).
        combination: Key of `COMBINATIONS`.
    """
    parts: dict[Motion, Array] = {
        "longitudinal": (left + right) / 2,
        "lateral": lateral,
        "yaw": right - left,
        "left": left,
        "right": right,
    }
    return np.hstack([parts[motion] for motion in COMBINATIONS[combination]])


def forwards(lateral: Array, yaw: Array, *, backwards: bool) -> tuple[Array, Array]:
    """Return lateral and yaw acceleration, each of shape (n, 4), in axes that point forwards, wheelset 1 leading.

    Run backwards, the car is turned by half a turn: the fourth wheelset leads, left is right, and yaw stays yaw.
    """
    return (-lateral[:, ::-1], yaw[:, ::-1]) if backwards else (lateral, yaw)


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
