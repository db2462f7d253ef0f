"""Which mode about a state of rest has the shape of a mode without contact."""

from __future__ import annotations

import numpy as np

from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.rest import RestState

#: Squared likeness above which two modes are each most like the other.
_HALF = 0.5


def held_mode(rest: RestState, mode: int) -> int:
    """Index of the linear mode about a state of rest with the shape of one without contact.

    The squared likenesses of all of them to one mode without contact sum to 1, as both sets of
    shapes are orthonormal in the mass. So one with more than half is the only one, and is like no
    other mode without contact as much.

    Args:
        rest: State of rest.
        mode: Index of a mode of the structure without contact.

    Raises:
        ModelError: if none has more than half.
    """
    likeness = rest.shapes[mode] ** 2
    found = int(np.argmax(likeness))
    if likeness[found] <= _HALF:
        raise ModelError(
            f"mode {mode + 1} without contact is no single mode at rest, where "
            f"{np.count_nonzero(rest.closed)} contact points are closed: mode {found + 1} there is "
            f"most like it, with a squared likeness of {likeness[found]:.2f}: must be above {_HALF}"
        )
    return found
