"""Preprocessing for the estimators: motions of the wheelsets, filters, block means, scaling to [−1, 1].

Source: Abduraxman et al. (2024), section "Data processing". The paper does not specify the following, which is chosen
here: both filters run forwards only, in double precision; the high-pass is of first order and starts at the first
sample; the low-pass is a second-order Butterworth filter and starts at rest; an incomplete last block is dropped.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal

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
"""The eight combinations of Abduraxman et al. (2024), each for all wheelsets; the paper selects `longitudinal`."""


BOXES: Final = tuple(f"{side}[{k}]" for side in ("left", "right", "lateral") for k in range(1, 5))
"""Accelerations of the axle boxes: longitudinal left and right, lateral."""


def motions(boxes: Any, combination: str) -> list[Any]:
    """Return the 4 to 12 channels of a combination [m/s²], ordered by motion and then by wheelset.

    Longitudinal is the mean of both axle boxes; yaw is right minus left, the yaw acceleration times the distance
    between the boxes.

    Args:
        boxes: Accelerations in the order of `BOXES` along the first axis [m/s²]: an array of shape (12, n), or a CasADi
            vector.
        combination: Key of `COMBINATIONS`.
    """
    left, right, lateral = boxes[:4], boxes[4:8], boxes[8:]
    parts = {
        "longitudinal": (left + right) / 2,
        "lateral": lateral,
        "yaw": right - left,
        "left": left,
        "right": right,
    }
    return [parts[motion][k] for motion in COMBINATIONS[combination] for k in range(4)]


@dataclass(frozen=True, slots=True, kw_only=True)
class AntiAlias:
    """A causal low-pass with decimation.

    Attributes:
        rate: Sampling rate of the input [Hz].
        keep: Number of input samples for each output sample.
    """

    rate: int
    keep: int

    @property
    def slow_rate(self) -> float:
        """Sampling rate of the output [Hz]."""
        return self.rate / self.keep

    @property
    def sections(self) -> Array:
        """Fourth-order Butterworth filter at 0.3 of the slow rate, as second-order sections."""
        return np.asarray(butter(4, 0.3 * self.slow_rate, fs=self.rate, output="sos"), dtype=np.float64)

    def __call__(self, raw: Array) -> Array:
        """Return the slow signal, shape (n // keep, channels), relative to the first sample."""
        return self.every(np.asarray(sosfilt(self.sections, raw - raw[0], axis=0), dtype=np.float64))

    def every(self, raw: Array) -> Array:
        """Return the samples that are kept, unfiltered, shape (n // keep, …)."""
        return np.asarray(raw[self.keep - 1 :: self.keep], dtype=np.float64)


def lateral_and_yaw(slow: AntiAlias, boxes: Array, *, backwards: bool) -> tuple[Array, Array]:
    """Return slow lateral and yaw acceleration [m/s²], each of shape (n // keep, 4), with the leading wheelset first.

    If wheelset 4 leads, the car is turned by half a turn: left and right are exchanged, and the sign of yaw remains.

    Args:
        slow: Low-pass with decimation.
        boxes: Accelerations in the order of `BOXES`, in axes of the car [m/s²], shape (n, 12).
        backwards: Whether wheelset 4 leads.
    """
    motion = slow(np.hstack([boxes[:, 8:], boxes[:, 4:8] - boxes[:, :4]]))
    lateral, yaw = motion[:, :4], motion[:, 4:]
    return (-lateral[:, ::-1], yaw[:, ::-1]) if backwards else (lateral, yaw)


Start = Literal["first sample", "first second"]

BLOCKS: Final = {60: 50, 40: 100, 26: 150, 16: 200}
"""Number of samples in a block by speed [mph]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """Filters before a network.

    Attributes:
        rate: Sampling rate of the input [Hz].
        block: Number of input samples averaged into one output sample.
        high_pass, low_pass: Corner frequencies [Hz].
        order: Order of the low-pass.
        start: Zero of the high-pass: the first sample, vibration included, or the mean of the first second. The latter
            is not causal within that second; it serves to measure the effect of the former on a network.
    """

    rate: int
    block: int
    high_pass: float = 1e-4
    low_pass: float = 1.0
    order: int = 2
    start: Start = "first sample"

    @property
    def remembers(self) -> float:
        """Pole of the high-pass (bilinear transform)."""
        return (1 - self._warped) / (1 + self._warped)

    @property
    def _warped(self) -> float:
        return float(np.tan(np.pi * self.high_pass / self.rate))

    @property
    def sections(self) -> Array:
        """The low-pass as second-order sections, shape (sections, 6)."""
        return np.asarray(butter(self.order, self.low_pass, fs=self.rate, output="sos"), dtype=np.float64)

    def filter(self, raw: Array) -> Array:
        """Return high- and low-passed accelerations at the full rate, shape of `raw` (n, channels)."""
        zero = raw[0] if self.start == "first sample" else raw[: self.rate].mean(axis=0)
        gain = 1 / (1 + self._warped)
        high = lfilter([gain, -gain], [1, -self.remembers], raw - zero, axis=0)
        return np.asarray(sosfilt(self.sections, high, axis=0), dtype=np.float64)

    def process(self, raw: Array) -> Array:
        """Return the input of the scaling: averaged absolute values, shape (n // block, channels)."""
        size = np.abs(self.filter(raw))
        count = len(size) // self.block
        return size[: count * self.block].reshape(count, self.block, -1).mean(axis=1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Scale:
    """A map of each channel to [−1, 1] over given data.

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
        """Return scaled data; values outside the data of the scale are beyond ±1."""
        return 2 * (data - self.lowest) / (self.highest - self.lowest) - 1
