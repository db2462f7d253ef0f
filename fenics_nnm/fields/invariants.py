"""Numbers of a stress state that do not depend on the axes."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fem.elasticity import VTK_ORDER


def von_mises(stress: Array) -> Array:
    """Von Mises stress in Pa of stresses (..., 6) in VTK's order.

    sqrt(3/2 s:s) with the deviator s, which is |sigma| in uniaxial stress.
    """
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    shear = xy**2 + yz**2 + xz**2
    return np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * shear)


def principal(stress: Array) -> Array:
    """Principal stresses in Pa of stresses (..., 6), shape (..., 3), the largest first."""
    tensor = np.empty((*stress.shape[:-1], 3, 3))
    for component, (row, column) in enumerate(VTK_ORDER):
        tensor[..., row, column] = tensor[..., column, row] = stress[..., component]
    return np.linalg.eigvalsh(tensor)[..., ::-1]
