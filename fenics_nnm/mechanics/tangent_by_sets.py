r"""Derivative of the harmonics of contact forces where few sets of points are in contact in turn.

Of points without mass the derivative of the forces depends on the set A in contact alone, so that
the instants k of each set come together:

    sum_k A_nk S_kn' Phi^T D_k Phi = sum_A (sum_(k in A) A_nk S_kn') Phi_A^T R_AA^-1 Phi_A.
"""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.mechanics.fourier import Series


def tangent_by_sets(series: Series, shapes: Array, forces: ContactForces) -> Array:
    """What `ContactForces.tangent` is, shape (c J, c J), rows and columns by (n, j).

    Args:
        series: Series in time.
        shapes: Phi, shape (n_c, J).
        forces: Contact forces, of points without mass.
    """
    forces.assert_complete()
    rows, modes = len(series.order), shapes.shape[1]
    if forces.local is None:
        return np.zeros((rows * modes, rows * modes))
    at = forces.samples
    sets, own = np.unique(forces.force[at] > 0, axis=0, return_inverse=True)
    analysis, synthesis = forces.instants.analysis(series), forces.instants.synthesis(series)
    stiffness = forces.local.stiffness(sets, shapes)
    mixing = np.empty((len(sets), rows, rows))
    for number in range(len(sets)):
        chosen = at[own.ravel() == number]
        mixing[number] = analysis[:, chosen] @ synthesis[chosen]
    both = mixing.reshape(len(sets), -1).T @ stiffness.reshape(len(sets), -1)
    by_row = both.reshape(rows, rows, modes, modes).swapaxes(1, 2)
    return np.ascontiguousarray(by_row).reshape(rows * modes, -1)
