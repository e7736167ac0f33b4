"""A belief: mean and covariance."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.errors import EstimatorError

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """A Gaussian belief about the vehicle at one instant.

    Attributes:
        mean: Shape (n,); order and units are those of the prediction's `states`.
        covariance: Of `mean`, shape (n, n), symmetric positive definite.

    Raises:
        EstimatorError: The shapes do not belong together.
    """

    mean: Vector
    covariance: Matrix

    def __post_init__(self) -> None:
        """Refuse shapes that do not belong together.

        Definiteness costs a factorisation, so it is checked where a belief enters from outside (`start`), not
        here.
        """
        n = len(self.mean)
        if self.covariance.shape != (n, n):
            raise EstimatorError(
                f"Estimate: a mean of {n} states wants a covariance of shape ({n}, {n}), "
                f"got {self.covariance.shape}; give both in the order of the prediction's states."
            )

    @property
    def deviation(self) -> Vector:
        """Standard deviation of each state, shape (n,), in the units of `mean`."""
        return np.sqrt(np.diagonal(self.covariance))
