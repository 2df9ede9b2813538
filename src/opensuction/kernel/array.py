"""The one kind of array that the core computes with."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Of doubles; each docstring says of what shape."""
