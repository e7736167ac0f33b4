"""The array that numbers come in."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Of any shape; which one, its docstring says."""
