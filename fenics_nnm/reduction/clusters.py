"""Modes of equal frequency: of their many bases the one that moves the contact points most first.

Any rotation of such modes is one too, and the eigensolver gives just one of them. Of a group with
displacements Phi of the contact points the right singular vectors of Phi make a basis that is
unique as long as the singular values differ: its first mode moves the contact points as much as any
of the group can, the second one as much as any that is orthogonal to it, and so on.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fenics_nnm.arrays import Array, Indices

#: Frequencies nearer than this part of each other are equal: symmetry, apart from round-off.
EQUAL = 1e-6


def groups(omega: Array) -> Iterator[Indices]:
    """Modes of equal frequency, two or more at a time.

    Args:
        omega: Circular frequencies, ascending, shape (J,).
    """
    starts = np.flatnonzero(np.diff(omega, prepend=-np.inf) > EQUAL * omega)
    for group in np.split(np.arange(len(omega)), starts[1:]):
        if len(group) > 1:
            yield group


def unique_basis(omega: Array, Phi: Array) -> Array:
    """Rotation of the modes to the unique basis, shape (J, J); the identity without groups.

    Args:
        omega: Circular frequencies, ascending, shape (J,).
        Phi: Displacement of the contact points per modal coordinate, shape (n_c, J).
    """
    rotation = np.eye(len(omega))
    for group in groups(omega):
        _, _, directions = np.linalg.svd(Phi[:, group])
        rotation[np.ix_(group, group)] = directions.T
    return rotation
