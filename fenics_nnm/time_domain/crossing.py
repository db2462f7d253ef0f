"""Where multipliers leave the unit circle between two motions, from smooth functions of them.

a = mu + 1 / mu is real for a pair on the circle or on the real axis. Functions that are positive
while a pair is on the circle, and negative beyond, change sign where it leaves:

    2 - a              through +1
    a + 2              through -1
    (a_1 - a_2)^2      in a collision of the pairs 1 and 2
"""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.time_domain.stability import COMPLEX, REAL, Stability


def crossing(kind: str, before: Stability, after: Stability) -> float:
    """Share of the way between two motions at which a kind of instability begins or ends.

    One of the motions is unstable in this way, the other is not. The function of the pair that
    leaves is taken linear between them; 0.5 where it has the same sign at both.
    """
    begins = kind in after.kinds
    unstable, stable = (after, before) if begins else (before, after)
    outside, inside = _values(kind, unstable, stable)
    if not outside < 0 < inside:
        return 0.5
    share = inside / (inside - outside)
    return share if begins else 1 - share


def _values(kind: str, unstable: Stability, stable: Stability) -> tuple[float, float]:
    """The function of the pair that leaves, at both motions."""
    leaving = _sums(unstable.multipliers)[unstable.kinds.index(kind)]
    others = _sums(stable.multipliers).real
    if kind != COMPLEX:
        distances = 2 - others if kind == REAL else 2 + others
        own = 2 - leaving if kind == REAL else 2 + leaving
        return float(own.real), float(distances[np.argmin(np.abs(distances))])
    pairs = _one_of_each_pair(others)
    first, second = pairs[np.argsort(np.abs(pairs - leaving.real))[:2]]
    return float(-4 * leaving.imag**2), float((first - second) ** 2)


def _sums(multipliers: Complex) -> Complex:
    return multipliers + 1 / multipliers


def _one_of_each_pair(a: Array) -> Array:
    """Values of mu + 1 / mu, each of which is there twice, once."""
    return np.sort(a)[::2]
