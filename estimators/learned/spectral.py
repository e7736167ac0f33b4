"""Features of lateral and yaw acceleration that depend on friction, but not on the roughness of the track.

Uneven rails move a wheelset laterally and in yaw, and creep forces couple both motions: the slope of the creep curve
and its saturation change the ratio and the phase of lateral and yaw acceleration. Ratios and phases do not depend on
the roughness of the track; levels, which determine the saturation of the contact, are additional features.

All steps are causal: band filters with two outputs a quarter of a period apart, products of them, and their mean over
the last metres travelled, weighted exponentially.
"""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from scipy.signal import cont2discrete, lfilter

from railgrip.estimators.belief import Array

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
