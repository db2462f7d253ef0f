"""Stages and rules of steps are kept up to a number and a size."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.kept import Kept, bytes_of


def test_things_are_made_once_until_they_are_too_many_or_too_large() -> None:
    made: list[int] = []

    def asked(kept: Kept[Array], *sizes: int) -> list[int]:
        made.clear()
        for size in sizes:
            found = kept.at(size, lambda size=size: made.append(size) or np.zeros(size))
            assert found.nbytes == bytes_of(found) == 8 * size
        return list(made)

    assert asked(Kept(3), 1, 2, 1, 3, 2) == [1, 2, 3]
    assert asked(Kept(2), 1, 2, 3, 3, 1) == [1, 2, 3, 1]
    assert asked(Kept(9, most_bytes=80), 4, 6, 4, 1, 6, 4) == [4, 6, 1, 6, 4]
