"""Frequencies of modes that a gyroscopic matrix couples."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.reduction.attached import enriched
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.reduction.operators import Operators, Product

#: Part of a gyroscopic matrix that may be symmetric, by round-off.
_SKEW = 1e-8


def coriolis_frequencies(
    modes: LinearModes, forces: Product, operators: Operators, count: int | None = None
) -> Array:
    """Circular frequencies with Coriolis forces in rad/s, one for each mode; on all ranks.

    The modes alone bring the motion along the span that these forces of a bending blade excite
    slowly, so that their static displacements under the forces are added to them.

    Args:
        modes: Modes without Coriolis forces.
        forces: From shapes to their Coriolis forces, but for the sign, per unit rate, in N.
        operators: Products with the matrices of the structure.
        count: Number of modes, from the lowest one, that these displacements are added of, and
            whose frequencies are given; all of them by default.

    Raises:
        ModelError: if a shape that is added moves no mass, or the forces are not gyroscopic.
    """
    rows = forces(modes.shapes[:, :count])
    if not float(operators.inner(rows, rows).trace()):
        return modes.omega[:count]
    whole = enriched(modes.omega, modes.shapes, rows, operators)
    G = operators.inner(whole.shapes, forces(whole.shapes))
    return gyroscopic_frequencies(whole.omega, (G - G.T) / 2)[: rows.shape[1]]


def gyroscopic_frequencies(omega: Array, G: Array) -> Array:
    r"""Circular frequencies of q'' + G q' + diag(omega^2) q = 0 in rad/s, ascending, shape (J,).

    With y = (omega q, q') the equations are y' = S y,

        S = [[0, diag(omega)], [-diag(omega), -G]],

    which is skew, so that i S is Hermitian: its eigenvalues are the frequencies and their
    negatives (L. Meirovitch, Computational Methods in Structural Dynamics, 1980, section 3.6).

    Args:
        omega: Circular frequencies without gyroscopic forces in rad/s, shape (J,).
        G: Gyroscopic matrix in 1/s, skew, shape (J, J).

    Raises:
        ModelError: if G is not skew.
    """
    if np.abs(G + G.T).max(initial=0.0) > _SKEW * np.abs(G).max(initial=0.0):
        raise ModelError("gyroscopic matrix: must be skew, G^T = -G")
    count, stiffness = len(omega), np.diag(omega)
    S = np.block([[np.zeros((count, count)), stiffness], [-stiffness, -(G - G.T) / 2]])
    return np.asarray(np.linalg.eigvalsh(1j * S)[count:])
