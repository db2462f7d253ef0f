"""Types of arrays, and vectors in space."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]
"""Real numbers."""

Complex = NDArray[np.complexfloating[Any, Any]]
"""Complex numbers."""

Mask = NDArray[np.bool_]
"""Which of some things are meant."""

Indices = NDArray[np.integer[Any]]
"""Whole numbers, most often places in another array."""


def in_space(vectors: Array) -> Array:
    """Vectors (n, dim) with three components, zero where the body has fewer."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))
