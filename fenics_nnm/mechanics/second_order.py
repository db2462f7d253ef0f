r"""Second-order kinematics: what large deflection adds to a reduced model.

With a few *masters* among the modal coordinates q and their static modal derivatives theta_ij the
displacement is

    u = sum phi_i q_i + 1/2 sum theta_ij q_i q_j - (residual shapes) lambda,
    w_c = Phi_c q + 1/2 q^T Theta_c q - (R lambda)_c,

and with V the polynomial part of the potential and D the inertia of the second-order displacement

    V = 1/3 alpha_ijk q_i q_j q_k (i a master) + alpha_ajk q_a q_j q_k (a none)
        + 1/4 beta_ijkl q_i q_j q_k q_l,
    T = 1/2 q'^T M(q) q',    M_ij = delta_ij + D_ikjl q_k q_l,    D_ikjl = theta_ik . M theta_jl,

sums over masters i, j, k, l. All theta are M-orthogonal to all modes of the model: what they would
share with modes that are no masters is in the coordinates of these, moved by alpha. So Lagrange's
equations of 1/2 q'^T M q' and the potential are

    q_i'' + omega_i^2 q_i + dV/dq_i + D_ikjl q_k (q_j'' q_l + q_j' q_l')
        + ((Phi + Theta q)^T lambda)_i = 0,

with one master m = 1 + D q^2 and the inertial force D q (q q'' + q'^2). Stiffness without this
inertia misleads. S. R. Idelsohn, A. Cardona, Comput. Methods Appl. Mech. Eng. 49 (1985) 253-279,
for static modal derivatives; S. Jain, P. Tiso, J. B. Rutzmoser, D. J. Rixen, Comput. Struct. 188
(2017) 80-94, for the quadratic manifold.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import permutations

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.closing import Closing, QuadraticClosing
from fenics_nnm.mechanics.force import MasterForce
from fenics_nnm.mechanics.inertia import Inertia, QuadraticInertia
from fenics_nnm.mechanics.kinematics import ModalShapes
from fenics_nnm.mechanics.second_order_forces import InertialForce, PolynomialStiffness

#: Names of the tensors.
_TENSORS = ("Theta", "alpha", "beta", "D")

#: Tensors may lack symmetry by this much, relative to their largest entry, from round-off.
_ASYMMETRY = 1e-6

#: D may have an eigenvalue below zero by this much of the largest.
_INDEFINITE = 1e-8


@dataclass(frozen=True, slots=True)
class SecondOrder:
    """Second-order kinematics and stiffness of k masters among the J modes of a model.

    Attributes:
        masters: Places of the masters among the modes, from 0, ascending, shape (k,).
        Theta: Second derivative of each contact displacement by the masters, with the curvature of
            the obstacle, m per (kg^1/2 m)^2 = 1/(kg m), shape (n_c, k, k).
        alpha: Quadratic force alpha_ijk q_j q_k on each coordinate, 1/(kg^1/2 m s^2), shape
            (J, k, k), symmetric in j and k, among the masters in all three.
        beta: Cubic force beta_ijkl q_j q_k q_l on the masters, 1/(kg m^2 s^2), shape
            (k, k, k, k), symmetric in all four.
        D: D_ijkl = theta_ij . M theta_kl, 1/(kg m^2), shape (k, k, k, k), symmetric in i and
            j, in k and l, and under exchange of both pairs; positive semidefinite.

    Raises:
        ModelError: if shapes disagree, values are not finite, masters are not ascending places of
            modes, or a symmetry is missing.
    """

    masters: Indices
    Theta: Array
    alpha: Array
    beta: Array
    D: Array
    _forces: tuple[MasterForce, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        masters = np.array(self.masters, dtype=np.int64)
        masters.setflags(write=False)
        object.__setattr__(self, "masters", masters)
        for name in _TENSORS:
            value = np.array(getattr(self, name), dtype=np.float64)
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        self._check_shapes()
        self._check_symmetry()
        stiffness = PolynomialStiffness(self.masters, self.alpha, self.beta)
        object.__setattr__(self, "_forces", (stiffness, InertialForce(self.masters, self.D)))

    @property
    def count(self) -> int:
        """Number of masters k."""
        return len(self.masters)

    @property
    def closing(self) -> Closing:
        """1/2 q^T Theta q beyond Phi q."""
        return QuadraticClosing(self.masters, self.Theta)

    @property
    def forces(self) -> tuple[MasterForce, ...]:
        """Polynomial stiffness, and inertia of the second-order displacement."""
        return self._forces

    @property
    def inertia(self) -> Inertia:
        """M(q)."""
        return QuadraticInertia(self.masters, self.D)

    @property
    def tensors(self) -> Mapping[str, Array]:
        """Tensors by name."""
        return {name: getattr(self, name) for name in _TENSORS}

    def curvature(self, model: ModalShapes) -> Array:
        """Theta_cjj of masters j with what the other modes add, else nothing, shape (n_c, J)."""
        curvature = np.array(model.Phi @ self.following(model))
        curvature[:, self.masters] += np.einsum("cjj->cj", self.Theta)
        return curvature

    def following(self, model: ModalShapes) -> Array:
        """-2 alpha_ajj / omega_a^2 of modes a that are no masters, along masters j, (J, J)."""
        moved = np.zeros((len(model.omega), len(model.omega)))
        others = np.setdiff1d(np.arange(len(model.omega)), self.masters)
        moved[np.ix_(others, self.masters)] = np.einsum("ajj->aj", self._follow(others, model))
        return moved

    def _follow(self, modes: Indices, model: ModalShapes) -> Array:
        """-2 alpha_ajk / omega_a^2 of modes a that follow the masters, shape (a, k, k)."""
        return -2 * self.alpha[modes] / (model.omega[modes] ** 2)[:, None, None]

    def assert_fits(self, model: ModalShapes) -> None:
        """Theta must have a matrix for each contact point, alpha one for each mode.

        Raises:
            ModelError: if there are others.
        """
        for name, found, wanted in (
            ("Theta", len(self.Theta), len(model.Phi)),
            ("alpha", len(self.alpha), len(model.omega)),
        ):
            if found != wanted:
                raise ModelError(f"second order: {name} has {found} matrices: must be {wanted}")

    def without_modes(self, chosen: Indices, model: ModalShapes) -> SecondOrder:
        """The kinematics of a part of the modes; the others follow statically.

        A mode a that is left out has q_a = -(alpha_ajk q_j q_k + Phi_a^T lambda) / omega_a^2: its
        shape joins theta.

        Args:
            chosen: Places of the modes to keep, ascending; all masters are among them.
            model: Modes and contact points before.

        Raises:
            ModelError: if a master is left out.
        """
        lacking = np.setdiff1d(self.masters, chosen)
        if len(lacking):
            raise ModelError(
                f"mode {lacking[0] + 1} is a master of the second-order displacement: must be "
                "among the modes that are kept"
            )
        dropped = np.setdiff1d(np.arange(len(model.omega)), chosen)
        left, follows = self.alpha[dropped], self._follow(dropped, model)
        return replace(
            self,
            masters=np.searchsorted(chosen, self.masters),
            Theta=self.Theta + np.einsum("ca,ajk->cjk", model.Phi[:, dropped], follows),
            alpha=self.alpha[chosen],
            beta=self.beta + symmetrised(np.einsum("ajk,alm->jklm", left, follows)),
            D=self.D + np.einsum("ajk,alm->jklm", follows, follows),
        )

    def among_more(self, omega: Array, Phi: Array, shared: Array) -> SecondOrder:
        """The kinematics with further coordinates above the modes, which no longer follow.

        What theta shares with the shapes of these, theta = theta' - (shape) m, goes to them: the
        reverse of `without_modes`, and exact for shapes that are no modes, too.

        Args:
            omega: Circular frequencies of the further coordinates in rad/s, shape (r,).
            Phi: Displacement of the contact points per further coordinate, shape (n_c, r).
            shared: m = -(shape) . M theta, 1/(kg^1/2 m), shape (r, k, k).
        """
        moved = omega[:, None, None] ** 2 * shared
        return replace(
            self,
            Theta=self.Theta + np.einsum("ca,ajk->cjk", Phi, shared),
            alpha=np.concatenate([self.alpha, moved / 2]),
            beta=self.beta + symmetrised(np.einsum("ajk,alm->jklm", moved, shared)) / 2,
            D=self.D - np.einsum("ajk,alm->jklm", shared, shared),
        )

    def scaled(self, *, omega: float, amplitude: float, length: float) -> SecondOrder:
        """The same in units of a frequency (rad/s), a coordinate (kg^1/2 m) and a length (m)."""
        return replace(
            self,
            Theta=self.Theta * amplitude**2 / length,
            alpha=self.alpha * amplitude / omega**2,
            beta=self.beta * (amplitude / omega) ** 2,
            D=self.D * amplitude**2,
        )

    def _check_shapes(self) -> None:
        k, modes, points = self.count, len(self.alpha), len(self.Theta)
        expected = {
            "Theta": (points, k, k),
            "alpha": (modes, k, k),
            "beta": (k, k, k, k),
            "D": (k, k, k, k),
        }
        if not k or self.masters.ndim != 1 or np.any(np.diff(self.masters) <= 0):
            raise ModelError(
                "second order: masters must be places of modes, ascending, one or more"
            )
        for name, shape in expected.items():
            value = getattr(self, name)
            if value.shape != shape:
                raise ModelError(f"second order: {name} has shape {value.shape}: must be {shape}")
            if not np.all(np.isfinite(value)):
                raise ModelError(f"second order: {name} has entries that are not finite")
        if self.masters[0] < 0 or self.masters[-1] >= modes:
            raise ModelError(
                f"second order: masters are modes {self.masters[0] + 1} to {self.masters[-1] + 1}: "
                f"must be between 1 and {modes}"
            )

    def _check_symmetry(self) -> None:
        pairs = (1, 0, 2, 3), (0, 1, 3, 2), (2, 3, 0, 1)
        _assert_symmetric("Theta", self.Theta, ((0, 2, 1),))
        _assert_symmetric("alpha", self.alpha, ((0, 2, 1),))
        _assert_symmetric("alpha of the masters", self.alpha[self.masters], ((1, 0, 2), (0, 2, 1)))
        _assert_symmetric("beta", self.beta, ((1, 0, 2, 3), (1, 2, 3, 0)))
        _assert_symmetric("D", self.D, pairs)
        values = np.linalg.eigvalsh(self.D.reshape(self.count**2, -1))
        if values[0] < -_INDEFINITE * max(values[-1], 0.0) - np.finfo(float).tiny:
            raise ModelError(
                f"second order: D has the eigenvalue {values[0]:.3g} 1/(kg m^2): must not be "
                "negative"
            )


def symmetrised(tensor: Array) -> Array:
    """Mean of a tensor over all orders of its indices."""
    orders = list(permutations(range(tensor.ndim)))
    return np.asarray(sum(tensor.transpose(order) for order in orders) / len(orders))


def _assert_symmetric(name: str, tensor: Array, orders: tuple[tuple[int, ...], ...]) -> None:
    """Refuse a tensor that is another one with its indices in some other order.

    Raises:
        ModelError: if it is.
    """
    largest = np.abs(tensor).max(initial=0.0)
    for order in orders:
        difference = np.abs(tensor - tensor.transpose(order)).max(initial=0.0)
        if difference > _ASYMMETRY * largest:
            raise ModelError(
                f"second order: {name} is not symmetric: entries differ from their mirror images "
                f"by up to {difference:.3g}, the largest is {largest:.3g}"
            )
