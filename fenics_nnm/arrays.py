"""Types of arrays."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]
"""Real numbers."""

Indices = NDArray[np.integer[Any]]
"""Whole numbers, most often places in another array."""
