"""Actuation that is none."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


class Direct:
    """The plant takes the demanded pressures themselves."""

    def command(self, demands: Sequence[float], measured: NDArray[np.float64]) -> Sequence[float]:
        """Return the demands [Pa]."""
        return demands
