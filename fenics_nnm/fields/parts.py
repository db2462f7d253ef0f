"""Compact parts of a body, as many as its size asks for: they do not depend on the ranks."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array, Indices


def compact_parts(places: Array, size: int) -> list[Indices]:
    """Divide places again and again by halves across their longest extent.

    Args:
        places: Places, shape (n, 3).
        size: Most places of a part.

    Returns:
        The numbers of the places of each part, ascending.
    """
    waiting: list[Indices] = [np.arange(len(places))]
    found: list[Indices] = []
    while waiting:
        part = waiting.pop()
        if len(part) <= size:
            found.append(np.sort(part))
            continue
        axis = np.argmax(np.ptp(places[part], axis=0))
        half = len(part) // 2
        order = np.argsort(places[part, axis], kind="stable")
        waiting += [part[order[half:]], part[order[:half]]]
    return found
