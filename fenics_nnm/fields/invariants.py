"""Numbers of a stress state that do not depend on the axes."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fem.elasticity import VTK_ORDER

#: Cosines of 3 theta nearer to -1 or 1 than this belong to two principal stresses near each other.
_CLOSE = 1e-4


def von_mises(stress: Array) -> Array:
    """Von Mises stress in Pa of stresses (..., 6) in VTK's order.

    sqrt(3/2 s:s) with the deviator s, which is |sigma| in uniaxial stress.
    """
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    shear = xy**2 + yz**2 + xz**2
    return np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * shear)


def principal(stress: Array) -> Array:
    """Principal stresses in Pa of stresses (..., 6), shape (..., 3), the largest first.

    With the mean p, von Mises' q and the third invariant J3 of the deviator they are

        p + 2/3 q cos(theta + 2 pi k / 3),   cos(3 theta) = 27/2 J3 / q^3,   k = 0, -1, 1,

    which loses digits where two of them are nearly the same; they are found by iteration there.
    """
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    mean, size = (xx + yy + zz) / 3, von_mises(stress)
    xx, yy, zz = xx - mean, yy - mean, zz - mean
    third = xx * (yy * zz - yz**2) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = 13.5 * third / size**3
        theta = np.arccos(cosine) / 3
    turns = 2 * np.pi / 3 * np.array([0, -1, 1])
    found = np.stack([mean + 2 / 3 * size * np.cos(theta + turn) for turn in turns])
    close = ~(np.abs(cosine) < 1 - _CLOSE)
    found[:, close] = _eigenvalues(stress[close]).T
    return np.moveaxis(found, 0, -1)


def _eigenvalues(stress: Array) -> Array:
    tensor = np.empty((len(stress), 3, 3))
    for component, (row, column) in enumerate(VTK_ORDER):
        tensor[:, row, column] = tensor[:, column, row] = stress[:, component]
    return np.linalg.eigvalsh(tensor)[:, ::-1]
