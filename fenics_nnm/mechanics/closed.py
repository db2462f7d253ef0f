"""A reduced model with some contact points held closed: margins, stiffness and constant force."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, eigvalsh

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.flexible_points import FlexiblePoints


@dataclass(frozen=True, slots=True)
class ClosedPoints:
    r"""Linear equations of motion with the points A held at their gaps, and when they end.

        q'' + stiffness q = pull,      stiffness = diag(omega^2) + Phi_A^T R_AA^-1 Phi_A,
        pull = Phi_A^T R_AA^-1 gap_A.

    They hold while all margins, gradient @ q + offset, are positive. The margin of an open point is
    its gap, that of a closed point the length lambda_c / (R_AA^-1)_cc by which it would move past
    its obstacle if it were let through: so a margin changes sign, not size, where a point opens or
    closes.

    Attributes:
        gradient: Margins per modal coordinate, shape (n_c, J).
        offset: Margins in m at q = 0, shape (n_c,).
        stiffness: Shape (J, J), symmetric.
        pull: Constant force, shape (J,).
        force_per_margin: (R_AA^-1)_cc of the closed points, 0 for open ones, shape (n_c,).
    """

    gradient: Array
    offset: Array
    stiffness: Array
    pull: Array
    force_per_margin: Array

    @classmethod
    def of(cls, model: FlexiblePoints, active: NDArray[np.bool_]) -> ClosedPoints:
        """The equations with the given points closed, at least one, shape (n_c,)."""
        Phi, gap = model.Phi[active], model.gap[active]
        factor = cho_factor(model.R[np.ix_(active, active)])
        inverse = cho_solve(factor, np.eye(len(gap)))
        force, force_at_gap = inverse @ Phi, inverse @ gap
        gradient, offset = -model.Phi, model.gap
        coupling = model.R[:, active]
        gradient, offset = gradient + coupling @ force, offset - coupling @ force_at_gap
        given_way = 1 / np.diagonal(inverse)
        gradient[active] = given_way[:, None] * force
        offset[active] = -given_way * force_at_gap
        stiffness = np.diag(model.omega**2) + Phi.T @ force
        per_margin = np.zeros(model.points)
        per_margin[active] = np.diagonal(inverse)
        pull = Phi.T @ force_at_gap
        return cls(gradient, offset, (stiffness + stiffness.T) / 2, pull, per_margin)


def effects_of_gaps(model: FlexiblePoints, active: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Derivatives of the constant force and of the margins by all gaps, with some points closed.

    Args:
        model: Model.
        active: Closed points, any number, shape (n_c,).

    Returns:
        That of the force, shape (J, n_c), and that of the margins, shape (n_c, n_c).
    """
    by_force, by_margin = np.zeros(model.Phi.T.shape), np.eye(model.points)
    closed = np.flatnonzero(active)
    if len(closed):
        inverse = cho_solve(cho_factor(model.R[np.ix_(closed, closed)]), np.eye(len(closed)))
        by_force[:, closed] = model.Phi[closed].T @ inverse
        by_margin[:, closed] -= model.R[:, closed] @ inverse
        by_margin[np.ix_(closed, closed)] = -inverse / np.diagonal(inverse)[:, None]
    return by_force, by_margin


def highest_frequency(model: FlexiblePoints) -> float:
    """Highest circular frequency with all points closed in rad/s: no set of them has a higher one.

    Raises:
        numpy.linalg.LinAlgError: if R is not positive definite.
    """
    held = model.Phi.T @ cho_solve(cho_factor(model.R), model.Phi)
    return float(np.sqrt(eigvalsh(np.diag(model.omega**2) + (held + held.T) / 2)[-1]))
