"""Modes over speed: which is which, and where engine orders meet them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import linear_sum_assignment

from fenics_nnm.arrays import Array, Indices


@dataclass(frozen=True, slots=True)
class Crossing:
    """Where n times the speed is the frequency of a mode.

    Attributes:
        order: Engine order n.
        mode: Index of the mode, from 0.
        speed: Speed in rad/s.
        frequency: Frequency in Hz.
    """

    order: int
    mode: int
    speed: float
    frequency: float


def same_modes(products: Array) -> Indices:
    """The mode of a set that each mode before is most like, no mode twice, shape (k,).

    It maximises the sum of the modal assurance criteria (phi_i^T M phi_j)^2 of mass-normalised
    shapes (R. J. Allemang and D. L. Brown, 1st Int. Modal Analysis Conf., 1982, with the mass), so
    that a mode keeps its name where its line veers away from that of another.

    Args:
        products: phi_i^T M phi_j of k modes before and m modes of the set, shape (k, m), m >= k.
    """
    return np.asarray(linear_sum_assignment(-(products**2))[1])


def crossings(speeds: Array, frequencies: Array, order: int) -> Iterator[Crossing]:
    """Where engine order n meets lines of modes, by ascending mode and speed.

    Squares of frequencies are taken as linear in the square of the speed between two speeds, as
    they are for a mode whose shape keeps (Southwell).

    Args:
        speeds: Speeds in rad/s, ascending, shape (s,).
        frequencies: Frequencies in Hz, not a number where there is none, shape (s, k).
        order: n.
    """
    x = speeds**2
    excess = frequencies**2 - (order / (2 * np.pi)) ** 2 * x[:, None]
    for mode in range(frequencies.shape[1]):
        for first, last in pairwise(range(len(x))):
            low, high = excess[first, mode], excess[last, mode]
            if low * high < 0 or (high == 0 and low != 0):
                speed = float(np.sqrt(x[first] + low / (low - high) * (x[last] - x[first])))
                yield Crossing(order, mode, speed, order * speed / (2 * np.pi))
