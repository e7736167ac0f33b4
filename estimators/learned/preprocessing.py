"""Preprocessing for the estimators: motions of the wheelsets, filters, block means, scaling to [−1, 1], and features.

Source of the first: Abduraxman et al. (2024), section "Data processing". The paper does not specify the following,
which is chosen here: both filters run forwards only, in double precision; the high-pass is of first order and starts at
the first sample; the low-pass is a second-order Butterworth filter and starts at rest; an incomplete last block is
dropped.

Features depend on friction, but not on the roughness of the track. Uneven rails move a wheelset laterally and in yaw,
and creep forces couple both motions: the slope of the creep curve and its saturation change the ratio and the phase of
lateral and yaw acceleration. Ratios and phases do not depend on the roughness of the track; levels, which determine the
saturation of the contact, are additional features. All steps are causal: band filters with two outputs a quarter of a
period apart, products of them, and their mean over the last metres travelled, weighted exponentially.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Final, Literal

import numpy as np
from pydantic import PlainValidator
from scipy.signal import butter, cont2discrete, lfilter, sosfilt

from railgrip.estimators.belief import Array

StoredArray = Annotated[Array, PlainValidator(np.array)]
"""An array that is a list, or a list of lists, in the file of a trained estimator."""

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


Start = Literal["first sample", "first second", "offset"]

BLOCKS: Final = {60: 50, 40: 100, 26: 150, 16: 200}
"""Number of samples in a block by speed [mph]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """Filters before a network.

    Attributes:
        rate: Sampling rate of the input [Hz].
        block: Number of input samples averaged into one output sample.
        high_pass, low_pass: Corner frequencies [Hz]; a high-pass of 0 is none.
        order: Order of the low-pass.
        start: Zero of the high-pass: the first sample, vibration included; the mean of the first second; or 0, so that
            the offset of the sensor remains. The second is not causal within that second; the last two serve to
            measure the effect of the first on a network.
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
        zeros = {"first sample": raw[0], "first second": raw[: self.rate].mean(axis=0), "offset": 0.0}
        gain = 1 / (1 + self._warped)
        high = lfilter([gain, -gain], [1, -self.remembers], raw - zeros[self.start], axis=0)
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

    lowest: StoredArray
    highest: StoredArray

    @classmethod
    def over(cls, data: Array) -> "Scale":
        """Return the scale of data, shape (n, channels)."""
        return cls(lowest=data.min(axis=0), highest=data.max(axis=0))

    def __call__(self, data: Array) -> Array:
        """Return scaled data; values outside the data of the scale are beyond ±1."""
        return 2 * (data - self.lowest) / (self.highest - self.lowest) - 1


Pair = tuple[Any, Any]

PRODUCTS: Final = 10
"""Number of means per band and bogie."""
SLOWEST: Final = 1.0
"""Speed below which the feature log(speed) is constant [m/s]."""
TINY: Final = 1e-12
"""Added to powers, so that the logarithm of a silent channel is finite [m²/s⁴]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Spectral:
    """The filters behind the features.

    Attributes:
        rate: Sampling rate of the input [Hz].
        centres: Centre frequencies of the bands [Hz].
        quality: Quality factor of the band filters.
        metres: Distance over which products are averaged [m].
        settling: Time at the start that is not averaged [s], while the step to the first sample decays in the filters:
            in the slowest band to a thousandth after 3 s.
    """

    rate: float
    centres: tuple[float, ...] = (1.0, 2.0, 4.0, 8.0, 16.0)
    quality: float = 1.4
    metres: float = 100.0
    settling: float = 3.0

    def band(self, centre: float) -> tuple[Array, Array, Array, Array]:
        """Return A, B, C, D of a band filter at `rate`; its outputs are the band and its integral times ω."""
        w = 2 * np.pi * centre
        a = np.array([[0.0, 1.0], [-(w**2), -w / self.quality]])
        b = np.array([[0.0], [1.0]])
        c = np.array([[0.0, w / self.quality], [w**2 / self.quality, 0.0]])
        result: Any = cont2discrete((a, b, c, np.zeros((2, 1))), 1 / self.rate, method="bilinear")
        return result[0], result[1], result[2], result[3]

    def weight(self, speed: Any, library: Any) -> Any:
        """Return the weight of a new sample at a speed [m/s]; `library` is `numpy` or `casadi`."""
        return 1 - library.exp(-library.fabs(speed) / (self.metres * self.rate))

    @property
    def settling_samples(self) -> int:
        """Number of samples at the start that are not averaged."""
        return round(self.settling * self.rate)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the features, in order."""
        kinds = ("yaw level leading", "yaw level trailing", "lateral over yaw leading", "lateral over yaw trailing",
               "in phase leading", "quadrature leading", "in phase trailing", "quadrature trailing",
               "yaw in phase", "yaw quadrature")  # fmt: skip
        return (*(f"{name}, {centre:g} Hz" for centre in self.centres for name in kinds), "log speed")

    def means(self, lateral: Array, yaw: Array, speed: Array) -> Array:
        """Return running means of products, shape (n, bands, 2 bogies, 10).

        Args:
            lateral, yaw: Accelerations at `rate`, in axes that point forwards, leading wheelset first [m/s²], shape
                (n, 4).
            speed: Speed of the vehicle [m/s], shape (n,).
        """
        weight = np.where(np.arange(len(lateral)) < self.settling_samples, 0.0, self.weight(speed, np))
        result = np.empty((len(lateral), len(self.centres), 2, PRODUCTS))
        for k, centre in enumerate(self.centres):
            swing, turn = self._band_and_integral(centre, lateral), self._band_and_integral(centre, yaw)
            for bogie in range(2):
                lead, trail = 2 * bogie, 2 * bogie + 1
                means = products(
                    (swing[0][:, lead], swing[1][:, lead]), (swing[0][:, trail], swing[1][:, trail]),
                    (turn[0][:, lead], turn[1][:, lead]), (turn[0][:, trail], turn[1][:, trail]),
                )  # fmt: skip
                result[:, k, bogie] = np.stack(means, axis=-1)
        # A mean over metres, not seconds: its weights change with the speed, so SciPy's filters cannot compute it. It
        # is divided by the sum of the weights so far, so that the zero at the start does not bias it.
        mean, total = np.zeros(result.shape[1:]), 0.0
        for k, w in enumerate(weight):
            total += w * (1 - total)
            mean += w * (result[k] - mean)
            result[k] = mean / max(total, TINY)
        return result

    def features(self, lateral: Array, yaw: Array, speed: Array) -> Array:
        """Return the features, shape (n, features); arguments as for `means`."""
        means = self.means(lateral, yaw, speed).sum(axis=2)
        result = [value for k in range(len(self.centres)) for value in ratios(list(means[:, k].T), np)]
        return np.stack([*result, np.log(np.maximum(np.abs(speed), SLOWEST))], axis=-1)

    def _band_and_integral(self, centre: float, signal: Array) -> Array:
        a, b, c, d = self.band(centre)
        denominator = np.poly(a)
        # The transfer function of each output, for one vectorised filter instead of a loop over samples.
        numerators = [np.poly(a - b @ c[row : row + 1]) + (d[row, 0] - 1) * denominator for row in range(2)]
        return np.stack([np.asarray(lfilter(numerator, denominator, signal, axis=0)) for numerator in numerators])


def products(swing_lead: Pair, swing_trail: Pair, turn_lead: Pair, turn_trail: Pair) -> list[Any]:
    """Return the ten products of a bogie; each signal is (band, integral), in NumPy or in CasADi."""
    return [
        turn_lead[0] * turn_lead[0],
        turn_trail[0] * turn_trail[0],
        swing_lead[0] * swing_lead[0],
        swing_trail[0] * swing_trail[0],
        swing_lead[0] * turn_lead[0],
        swing_lead[1] * turn_lead[0],
        swing_trail[0] * turn_trail[0],
        swing_trail[1] * turn_trail[0],
        turn_lead[0] * turn_trail[0],
        turn_lead[1] * turn_trail[0],
    ]


def ratios(means: list[Any], library: Any) -> list[Any]:
    """Return the features of one band from the mean products of both bogies together.

    Args:
        means: Means in the order of `products`.
        library: `numpy` or `casadi`, for log and sqrt.
    """
    turn_lead, turn_trail, swing_lead, swing_trail = (m + TINY for m in means[:4])
    lead, trail = library.sqrt(turn_lead * swing_lead), library.sqrt(turn_trail * swing_trail)
    between = library.sqrt(turn_lead * turn_trail)
    return [
        library.log(turn_lead),
        library.log(turn_trail),
        library.log(swing_lead / turn_lead),
        library.log(swing_trail / turn_trail),
        means[4] / lead,
        means[5] / lead,
        means[6] / trail,
        means[7] / trail,
        means[8] / between,
        means[9] / between,
    ]
