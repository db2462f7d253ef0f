"""A motion as few shapes times functions of time, exact enough to be looked at.

The displacements of all nodes at instants of a period are a matrix of low rank, as motions are made
of few modes. Its singular vectors are the shapes; the functions of time are Fourier series, so that
any number of frames can be played.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array

#: Largest error of a displacement, as a part of the largest one.
_ERROR = 2e-3


@dataclass(frozen=True, slots=True)
class Waves:
    """Displacement = sum over r of shapes[r] times (cos[n, r] cos n phase + sin[n, r] sin n phase).

    Attributes:
        shapes: In m, shape (R, nodes, 3).
        cos: Coefficients of cosines, n = 0 to N, shape (N + 1, R).
        sin: Coefficients of sines, shape (N + 1, R).
    """

    shapes: Array
    cos: Array
    sin: Array

    def at(self, phase: Array) -> Array:
        """Displacements at phases in m, shape (len(phase), nodes, 3)."""
        angle = np.outer(phase, np.arange(len(self.cos)))
        factors = np.cos(angle) @ self.cos + np.sin(angle) @ self.sin
        return np.asarray(np.tensordot(factors, self.shapes, 1))


def waves_of(displacement: Array) -> Waves:
    """The waves of a motion.

    Args:
        displacement: At instants at equal steps of a period, its end left out, shape (s, nodes, 3).
    """
    instants, nodes, _ = displacement.shape
    rows = displacement.reshape(instants, -1)
    courses, sizes, shapes = np.linalg.svd(rows, full_matrices=False)
    rank = _rank(rows, courses * sizes, shapes)
    series = np.fft.rfft(courses[:, :rank] * sizes[:rank], axis=0) / instants
    doubled = np.full((len(series), 1), 2.0)
    doubled[0] = 1.0
    if instants % 2 == 0:
        doubled[-1] = 1.0
    return Waves(
        shapes[:rank].reshape(rank, nodes, 3), doubled * series.real, -doubled * series.imag
    )


def _rank(rows: Array, courses: Array, shapes: Array) -> int:
    """Fewest shapes with which no displacement is off by more than the error."""
    most = _ERROR * float(np.abs(rows).max(initial=0.0))
    rank = 1
    while rank < len(shapes) and np.abs(courses[:, rank:] @ shapes[rank:]).max() > most:
        rank += 1
    return rank
