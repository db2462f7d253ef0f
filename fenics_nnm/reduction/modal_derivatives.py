"""Static modal derivatives of a few masters, and the second-order kinematics that they make.

With f the internal force of the structure at its state of rest, phi_i the masters among its modes,

    K theta_ij = -f''[phi_i, phi_j],    theta_ij M-orthogonal to all modes of the model,

    alpha_ajk  = 1/2 phi_a . f''[phi_j, phi_k],
    beta_ijkl  = 1/6 phi_i . f'''[phi_j, phi_k, phi_l] + 1/2 theta_kl . f''[phi_i, phi_j],
    D_ijkl     = theta_ij . M theta_kl,
    Theta_c,ij = closing of contact point c by theta_ij + curvature of its obstacle,

beta symmetrised, see `mechanics.second_order`. What theta would share with modes that are no
masters is in the coordinates of these, moved by alpha.

Shapes r that were added to the modes for springs that are not linear are orthogonal to them, and to
each other, in K and in M, but they are no modes: with m_rjk = r . M K^-1 f''[phi_j, phi_k], what
theta would share with them,

    r . K theta_jk = omega_r^2 m_rjk - r . f''[phi_j, phi_k]

is not zero as for modes, so that alpha_rjk = omega_r^2 m_rjk / 2, and beta grows by the symmetric
part of (r . K theta_ij) m_rkl / 2; see also `SecondOrder.among_more`.

S. R. Idelsohn, A. Cardona, Comput. Methods Appl. Mech. Eng. 49 (1985) 253-279; S. Jain, P. Tiso, J.
B. Rutzmoser, D. J. Rixen, Comput. Struct. 188 (2017) 80-94.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement, permutations

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.pairs import Pairs
from fenics_nnm.mechanics.second_order import SecondOrder, symmetrised
from fenics_nnm.mechanics.second_order_effect import ASKED
from fenics_nnm.reduction.operators import Operators, Product
from fenics_nnm.reduction.reduction import Reduction

#: Derivatives may lack symmetry by this part of what their entries are products of.
_ROUND_OFF = 1e-9


@dataclass(frozen=True, slots=True)
class Deflection:
    """What large deflection adds to the internal force f of a structure at its state of rest.

    Attributes:
        second: f''[phi_i, phi_j] in N of columns phi in m at the n degrees of freedom, shape
            (n, k), by their pairs, shape (n, k (k + 1) / 2).
        third: phi_i . f'''[phi_j, phi_k, phi_l] of the same, shape (k, k, k, k).
        obstacle: How much the curvature of obstacles closes contact points: from displacements
            (n, k) to second derivatives of the closing, in 1/m times these, shape (n_c, k, k).
    """

    second: Product
    third: Callable[[Array], Array]
    obstacle: Callable[[Array], Array]


@dataclass(frozen=True, slots=True)
class ModalDerivatives:
    """Second-order kinematics of masters, and the way back to the structure.

    Attributes:
        order: Second-order kinematics of the reduced model.
        theta: Modal derivatives, M-orthogonal to all modes of the model, 1/(kg m), shape
            (n, k (k + 1) / 2), by pairs (0, 0), (0, 1), ..., (1, 1), ...
    """

    order: SecondOrder
    theta: Array

    def displacement(self, x: Array) -> Array:
        """Second-order displacement 1/2 theta x x in m, shape (n,), of masters x (k,)."""
        return np.asarray(self.theta @ Pairs.of(len(x)).products(x))


def with_second_order(
    reduction: Reduction, masters: Indices, operators: Operators, deflection: Deflection
) -> Reduction:
    """A massless reduction with second-order kinematics; arguments as of `modal_derivatives`."""
    found = modal_derivatives(reduction, masters, operators, deflection)
    model = replace(reduction.model, kinematics=found.order)
    return replace(reduction, model=model, bent_shapes=found.theta, choice=ASKED)


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
        ModelError: if the tensors lack a symmetry: the internal force has no potential; or if a
            master is no mode.
    """
    if masters[-1] >= reduction.free:
        raise ModelError(
            f"mode {masters[-1] + 1} is a shape of a spring or an excitation: masters must be "
            f"among the {reduction.free} modes"
        )
    shapes, pairs = reduction.shapes, Pairs.of(len(masters))
    phi, place = shapes[:, masters], pairs.place
    forces = deflection.second(phi)
    raw = operators.static(forces)
    inertia = operators.mass(raw)
    shared = operators.inner(shapes, inertia)
    theta = -raw
    theta += shapes @ shared
    pulled, stretched = _added(reduction, operators.inner(shapes, forces), shared)
    alpha = pulled[:, place] / 2
    size = _norm(operators.inner, phi) * _norm(operators.inner, forces)
    alpha[masters] = _of_potential("second", alpha[masters], size)
    both = place[:, :, None, None], place
    cubic = deflection.third(phi)
    order = SecondOrder(
        masters=masters,
        Theta=operators.contact(theta)[:, place] + deflection.obstacle(phi),
        alpha=alpha,
        beta=cubic / 6 + symmetrised((operators.gram(theta, forces) + stretched)[both]) / 2,
        # M theta: what theta lacks of -raw is M-orthogonal to it
        D=_not_negative(operators.gram(theta, -inertia), operators.gram(raw, inertia))[both],
    )
    return ModalDerivatives(order, theta)


def _added(reduction: Reduction, pulled: Array, shared: Array) -> tuple[Array, Array]:
    """Quadratic forces on all coordinates, and what shapes that are no modes add to beta.

    Args:
        reduction: Reduced model.
        pulled: Forces along its shapes, (shape) . f''[phi_j, phi_k], by pairs, shape (J, p).
        shared: What theta would share with them, (shape) . M K^-1 f''[phi_j, phi_k], (J, p).

    Returns:
        Twice alpha by pairs, shape (J, p), and (r . K theta) m, shape (p, p).
    """
    own = slice(reduction.free, None)
    forces = reduction.model.omega[own, None] ** 2 * shared[own]
    found = pulled.copy()
    found[own] = forces
    return found, (forces - pulled[own]).T @ shared[own]


def _not_negative(gram: Array, whole: Array) -> Array:
    """Products of columns without what is negative in them by round-off, shape (p, p).

    Args:
        gram: The products, a difference that cancels where modes make up nearly all.
        whole: Those of the columns that modes were taken from, whose round-off they have.
    """
    values, vectors = np.linalg.eigh((gram + gram.T) / 2)
    least = -_ROUND_OFF * float(np.diag(whole).max(initial=0.0))
    values[(least <= values) & (values < 0)] = 0.0
    return np.asarray((vectors * values) @ vectors.T)


def pairwise(second: Callable[[Array, Array], Array], phi: Array) -> Array:
    """f''[phi_i, phi_j] of columns (n, k) by their pairs, from f''[a, b] of two, see `Deflection`.

    Args:
        second: From two displacements in m, each at the n degrees of freedom, to f''[a, b] in N.
        phi: Columns.
    """
    pairs = Pairs.of(phi.shape[1])
    columns = zip(pairs.first, pairs.second, strict=True)
    return np.column_stack([second(phi[:, i], phi[:, j]) for i, j in columns])


def polarised(square: Product, inner: Callable[[Array, Array], Array], phi: Array) -> Array:
    """The same of a symmetric f'', from f''[a, a] of one displacement, which takes less work.

    2 f''[a, b] = f''[a + b, a + b] - f''[a, a] - f''[b, b], where a and b are columns times such
    factors that forces f''[a, a] are of one size, so that little of f''[a, b] cancels.

    Args:
        square: From a displacement in m at the n degrees of freedom to f''[a, a] in N, (n,) each.
        inner: As of `Operators`.
        phi: Columns, shape (n, k).
    """
    pairs = Pairs.of(phi.shape[1])
    own = np.column_stack([square(column) for column in phi.T])
    norms = np.array([_norm(inner, column[:, None]) for column in own.T])
    size = np.sqrt(np.where(norms > 0, norms, 1.0))
    unit, own = phi / size, own / size**2
    found = np.empty((len(phi), len(pairs.first)), order="F")
    for at, (i, j) in enumerate(zip(pairs.first, pairs.second, strict=True)):
        if i == j:
            found[:, at] = size[i] ** 2 * own[:, i]
        else:
            both = square(unit[:, i] + unit[:, j]) - own[:, i] - own[:, j]
            found[:, at] = size[i] * size[j] / 2 * both
    return found


def by_triples(
    third: Callable[[Array, Array, Array], Array],
    inner: Callable[[Array, Array], Array],
    phi: Array,
) -> Array:
    """phi_i . f'''[phi_j, phi_k, phi_l], from f'''[a, b, c] of three, see `Deflection`.

    Args:
        third: From three displacements in m, each at the n degrees of freedom, to f''' in N.
        inner: As of `Operators`.
        phi: Columns, shape (n, k).

    Raises:
        ModelError: if it lacks a symmetry: the internal force has no potential.
    """
    count, size = phi.shape[1], 0.0
    whole = np.empty((count,) * 4)
    for triple in combinations_with_replacement(range(count), 3):
        force = third(*(phi[:, i] for i in triple))[:, None]
        row = inner(phi, force)[:, 0]
        size = max(size, _norm(inner, phi) * _norm(inner, force))
        for a, b, c in permutations(triple):
            whole[:, a, b, c] = row
    return _of_potential("third", whole, size)


def _of_potential(name: str, tensor: Array, size: float) -> Array:
    """A derivative of a force along masters, whose indices can all be exchanged.

    Args:
        name: Which derivative it is.
        tensor: The derivative.
        size: What its entries are products of.

    Raises:
        ModelError: if they cannot.
    """
    found = symmetrised(tensor)
    wrong = float(np.abs(found - tensor).max())
    if wrong > _ROUND_OFF * size:
        raise ModelError(
            f"{name} derivative of the internal force: entries differ by up to {wrong:.3g} from "
            f"their mean over all orders, {np.abs(found).max():.3g}: must be that of a potential"
        )
    return found


def _norm(inner: Callable[[Array, Array], Array], columns: Array) -> float:
    """Norm of all columns, over all ranks."""
    return float(np.sqrt(np.trace(inner(columns, columns))))
