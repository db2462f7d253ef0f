r"""Static modal derivatives of a few masters, and the second-order kinematics that they make.

With f the internal force of the structure at its state of rest, phi_i the masters among its modes,

    K theta_ij = -f''[phi_i, phi_j],    theta_ij M-orthogonal to the masters,

    alpha_ajk = 1/2 phi_a . f''[phi_j, phi_k],
    beta_ijkl = 1/6 phi_i . f'''[phi_j, phi_k, phi_l] + 1/2 theta_kl . f''[phi_i, phi_j],
    D_ijkl    = theta_ij . M theta_kl,
    Theta_cij = closing of contact point c by theta_ij + curvature of its obstacle,

alpha and beta symmetrised. S. R. Idelsohn, A. Cardona, Comput. Methods Appl. Mech. Eng. 49 (1985)
253-279; S. Jain, P. Tiso, J. B. Rutzmoser, D. J. Rixen, Comput. Struct. 188 (2017) 80-94.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations_with_replacement, permutations

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.mechanics.second_order import SecondOrder, symmetrised
from fenics_nnm.reduction.operators import Operators
from fenics_nnm.reduction.reduction import Reduction


@dataclass(frozen=True, slots=True)
class Deflection:
    """What large deflection adds to the internal force f of a structure at its state of rest.

    Attributes:
        second: f''[a, b] in N of two displacements in m, each at the n degrees of freedom.
        third: f'''[a, b, c] of three.
        obstacle: How much the curvature of obstacles closes contact points: from displacements
            (n, k) to second derivatives of the closing, in 1/m times these, shape (n_c, k, k).
    """

    second: Callable[[Array, Array], Array]
    third: Callable[[Array, Array, Array], Array]
    obstacle: Callable[[Array], Array]


@dataclass(frozen=True, slots=True)
class ModalDerivatives:
    """Second-order kinematics of masters, and the way back to the structure.

    The displacement in m of modal coordinates q, with masters x, is that of the modes and residual
    shapes and 1/2 sum_ij theta_ij x_i x_j besides, less what the shapes of the model have of it,
    see `SecondOrder.apart`.

    Attributes:
        order: Second-order kinematics of the reduced model.
        theta: Modal derivatives, M-orthogonal to all modes of the model, 1/(kg m), shape
            (n, k (k + 1) / 2), by pairs (0, 0), (0, 1), ..., (1, 1), ...
    """

    order: SecondOrder
    theta: Array

    def displacement(self, x: Array) -> Array:
        """Second-order displacement 1/2 theta x x in m, shape (n,), of masters x (k,)."""
        pairs = pairs_of(len(x))
        amounts = [x[i] * x[j] * (0.5 if i == j else 1.0) for i, j in pairs]
        return np.asarray(self.theta @ np.array(amounts))


def pairs_of(count: int) -> list[tuple[int, int]]:
    """Pairs of some numbers in the order of modal derivatives."""
    return list(combinations_with_replacement(range(count), 2))


def modal_derivatives(
    reduction: Reduction, masters: Indices, operators: Operators, deflection: Deflection
) -> ModalDerivatives:
    """Second-order kinematics of a reduced model.

    Args:
        reduction: Reduced model, and its modes at the degrees of freedom.
        masters: Places of the masters among its modes, ascending, shape (k,).
        operators: Products of the structure.
        deflection: What large deflection adds to it.

    Raises:
        ModelError: if the tensors lack a symmetry.
    """
    shapes, model = reduction.shapes, reduction.model
    phi, count = shapes[:, masters], len(masters)
    forces = np.column_stack([deflection.second(phi[:, i], phi[:, j]) for i, j in pairs_of(count)])
    theta = -operators.static(forces)
    theta -= phi @ operators.inner(operators.mass(phi), theta)
    mass_theta = operators.mass(theta)
    alpha = _squared(operators.inner(shapes, forces) / 2, count)
    alpha[masters] = symmetrised(alpha[masters])
    coupled = _fourfold(operators.gram(theta, forces), count)
    cubic = symmetrised(_third(phi, operators, deflection))
    order = SecondOrder(
        masters=masters,
        Theta=_squared(operators.contact(theta), count) + deflection.obstacle(phi),
        alpha=alpha,
        beta=cubic / 6 + symmetrised(coupled) / 2,
        D=_fourfold(operators.gram(theta, mass_theta), count),
    )
    shared = operators.inner(shapes, mass_theta)
    apart = order.apart(model, _squared(shared, count))
    shared[masters] = 0.0
    return ModalDerivatives(apart, theta - shapes @ shared)


def _squared(by_pairs: Array, count: int) -> Array:
    """The last index of an array, one of pairs, as two: shape (..., k, k)."""
    whole = np.empty((*by_pairs.shape[:-1], count, count))
    for number, (i, j) in enumerate(pairs_of(count)):
        whole[..., i, j] = whole[..., j, i] = by_pairs[..., number]
    return whole


def _fourfold(by_pairs: Array, count: int) -> Array:
    """A matrix over pairs as a tensor (k, k, k, k)."""
    half = _squared(by_pairs, count)
    return np.moveaxis(_squared(np.moveaxis(half, 0, -1), count), (0, 1), (2, 3))


def _third(phi: Array, operators: Operators, deflection: Deflection) -> Array:
    """phi_i . f'''[phi_j, phi_k, phi_l], shape (k, k, k, k)."""
    count = phi.shape[1]
    whole = np.empty((count,) * 4)
    for triple in combinations_with_replacement(range(count), 3):
        force = deflection.third(*(phi[:, i] for i in triple))[:, None]
        row = operators.inner(phi, force)[:, 0]
        for a, b, c in permutations(triple):
            whole[:, a, b, c] = row
    return whole
