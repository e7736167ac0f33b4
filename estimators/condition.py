"""Condition of the rail from an estimate of friction: one of a few named levels, or undecided."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from railgrip.base.errors import EstimatorError
from railgrip.estimators.belief import Vector

UNDECIDED = -1
"""Label before any condition has been probable enough for long enough."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionDetector:
    """Detects the probable condition from a Gaussian estimate of friction, with hysteresis in time.

    A condition covers the friction between the midpoints to its neighbours. It is announced when its probability has
    been `confidence` or more for `hold` seconds without interruption, and remains until another one is announced.

    Attributes:
        levels: Friction of each condition.
        confidence: Required probability, between one half and one.
        hold: Time for which it must last [s].
        model_deviation: Standard deviation added to that of the estimate, for model errors that its covariance does
            not include.

    Raises:
        EstimatorError: Fewer than two levels, equal ones, or an invalid confidence or time.
    """

    levels: Mapping[str, float]
    confidence: float
    hold: float
    model_deviation: float

    def __post_init__(self) -> None:
        if len(set(self.levels.values())) != len(self.levels) or len(self.levels) < 2:
            raise EstimatorError(f"ConditionDetector: requires two different levels or more, got {dict(self.levels)}.")
        if not (0.5 <= self.confidence < 1.0 and self.hold >= 0.0 and self.model_deviation >= 0.0):
            raise EstimatorError(
                "ConditionDetector: confidence is in [0.5, 1), hold and model_deviation are not negative; "
                f"got {self.confidence}, {self.hold} s, {self.model_deviation}."
            )

    def probabilities(self, mean: Vector, deviation: Vector) -> NDArray[np.float64]:
        """Return the probability of each condition at each sample, shape (k, number of levels), rows summing to one."""
        values = np.array(list(self.levels.values()))
        order = np.argsort(values)
        bounds = 0.5 * (values[order][1:] + values[order][:-1])
        total_deviation = np.hypot(deviation, self.model_deviation)
        below = ndtr((bounds - mean[:, np.newaxis]) / total_deviation[:, np.newaxis])
        edges = np.column_stack([np.zeros(len(mean)), below, np.ones(len(mean))])
        shares = np.empty((len(mean), values.size))
        shares[:, order] = np.diff(edges, axis=1)
        return shares

    def labels(self, mean: Vector, deviation: Vector, period: float) -> NDArray[np.intp]:
        """Return the condition announced at each sample, shape (k,): its index in `levels`, or `UNDECIDED`.

        Args:
            mean: Estimated friction, shape (k,); NaN without an estimate.
            deviation: Standard deviation of the estimate, shape (k,).
            period: Time between samples [s].
        """
        shares = self.probabilities(mean, deviation)
        best = np.argmax(np.where(np.isnan(shares), -1.0, shares), axis=1)
        sure = np.take_along_axis(shares, best[:, np.newaxis], axis=1)[:, 0] >= self.confidence
        hold_steps = max(1, round(self.hold / period))
        labels = np.full(len(mean), UNDECIDED)
        label, candidate, since = UNDECIDED, UNDECIDED, 0
        for k in range(len(mean)):
            if sure[k] and best[k] == candidate:
                since += 1
            else:
                candidate, since = (int(best[k]), 1) if sure[k] else (UNDECIDED, 0)
            if candidate != UNDECIDED and since >= hold_steps:
                label = candidate
            labels[k] = label
        return labels


def confusion(truth: NDArray[np.intp], labels: NDArray[np.intp], levels: int) -> NDArray[np.int64]:
    """Return the number of samples of each true condition by label, shape (levels, levels + 1).

    The last column counts undecided samples.
    """
    counts = np.zeros((levels, levels + 1), dtype=np.int64)
    np.add.at(counts, (truth, np.where(labels == UNDECIDED, levels, labels)), 1)
    return counts
