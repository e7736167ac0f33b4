"""Types of arrays; docstrings state the shapes."""

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Array = NDArray[np.float64]
"""An array of any shape."""
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]
