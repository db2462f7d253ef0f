"""Compact parts of a body, as many as its size asks for: they do not depend on the ranks."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array, Indices

#: Nodes of a part of a body, at most.
NODES_OF_PART = 8192

#: More parts than this are made a multiple of it, so that two or four ranks have equally many.
_ALIKE = 4


def compact_parts(places: Array, size: int) -> list[Indices]:
    """Divide places again and again across their longest extent, into parts of about one size.

    Args:
        places: Places, shape (n, 3).
        size: Most places of a part.

    Returns:
        The numbers of the places of each part, ascending.
    """
    count = -(-len(places) // size)
    count += -count % _ALIKE if count > _ALIKE else 0
    waiting: list[tuple[Indices, int]] = [(np.arange(len(places)), count)]
    found: list[Indices] = []
    while waiting:
        part, count = waiting.pop()
        if count == 1:
            found.append(np.sort(part))
            continue
        first = count // 2
        end = len(part) * first // count
        axis = np.argmax(np.ptp(places[part], axis=0))
        order = np.argsort(places[part, axis], kind="stable")
        waiting += [(part[order[end:]], count - first), (part[order[:end]], first)]
    return found
