"""Types of arrays."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]
"""Real numbers."""

Mask = NDArray[np.bool_]
"""Which of some things are meant."""

Indices = NDArray[np.integer[Any]]
"""Whole numbers, most often places in another array."""
