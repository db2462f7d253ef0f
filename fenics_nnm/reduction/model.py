"""The reduced model: all that the nonlinear solver knows of a structure."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ModelError

#: R may be indefinite by this much, relative to its largest entry, from round-off in the modes.
_INDEFINITE_TOLERANCE = 1e-9

#: R with a smaller ratio of eigenvalues than this is singular.
_SINGULAR = 1e-10


@dataclass(frozen=True, slots=True)
class ReducedModel:
    r"""A structure in modal form with residual flexibility at its contact points.

    With modal coordinates q, contact forces lambda >= 0 and contact displacements w,

        q_j'' + omega_j^2 q_j + (Phi^T lambda)_j = 0,      w = Phi q - R lambda,
        lambda >= 0,   w - gap <= 0,   lambda (w - gap) = 0.

    Monjaraz-Tec, Gross, Krack, Comput. Struct. 260 (2022) 106698 for R > 0 (massless
    boundary); R = 0 is a basis whose contact points carry mass (Craig-Bampton).

    Attributes:
        omega: Natural circular frequencies of the basis in rad/s, ascending, shape (J,).
        Phi: Displacement of each contact point in its contact direction per modal
            coordinate, mass-normalised (kg^-1/2), shape (n_c, J).
        R: Residual flexibility of the contact points in m/N, shape (n_c, n_c), symmetric.
        gap: Initial gaps in m, shape (n_c,).

    Raises:
        ModelError: if shapes disagree, values are not finite, frequencies are not positive and
            ascending, a gap is not positive, or R is not symmetric positive semidefinite.
    """

    omega: Array
    Phi: Array
    R: Array
    gap: Array

    def __post_init__(self) -> None:
        for name in ("omega", "Phi", "R", "gap"):
            value = np.array(getattr(self, name), dtype=np.float64)
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        self._check_shapes()
        self._check_values()

    def _check_shapes(self) -> None:
        expected = {
            "omega": (self.modes,),
            "gap": (self.points,),
            "Phi": (self.points, self.modes),
            "R": (self.points, self.points),
        }
        for name, shape in expected.items():
            found = getattr(self, name).shape
            if found != shape or 0 in shape:
                raise ModelError(f"reduced model: {name} has shape {found}: must be {shape}")

    def _check_values(self) -> None:
        for name in ("omega", "Phi", "R", "gap"):
            if not np.all(np.isfinite(getattr(self, name))):
                raise ModelError(f"reduced model: {name} has entries that are not finite")
        if self.omega[0] <= 0 or np.any(np.diff(self.omega) < 0):
            raise ModelError("reduced model: omega must be positive and ascending, in rad/s")
        if self.gap.min() <= 0:
            raise ModelError(f"reduced model: gap = {self.gap.min():g} m: must be positive")
        scale = max(float(np.abs(self.R).max()), np.finfo(float).tiny)
        if np.abs(self.R - self.R.T).max() > 1e-8 * scale:
            raise ModelError("reduced model: R is not symmetric")
        lowest = float(np.linalg.eigvalsh(self.R)[0])
        if lowest < -_INDEFINITE_TOLERANCE * scale:
            raise ModelError(
                f"reduced model: R has the eigenvalue {lowest:.3g} m/N: must not be negative"
                " (modes and attachment solutions are of different models, or not converged)"
            )

    @property
    def modes(self) -> int:
        """Number of modal coordinates J."""
        return int(np.size(self.omega))

    @property
    def massless(self) -> bool:
        """Whether the contact points carry no mass: R is positive definite."""
        eigenvalues = np.linalg.eigvalsh(self.R)
        return bool(eigenvalues[0] > _SINGULAR * eigenvalues[-1])

    @property
    def points(self) -> int:
        """Number of contact points n_c."""
        return int(np.size(self.gap))

    def with_modes(self, chosen: Indices | list[int]) -> ReducedModel:
        """Keep some modes; the static flexibility of the others goes to R.

        Args:
            chosen: Indices of the modes to keep, ascending.
        """
        dropped = np.setdiff1d(np.arange(self.modes), chosen)
        flexible = self.Phi[:, dropped] / self.omega[dropped]
        return replace(
            self,
            omega=self.omega[chosen],
            Phi=self.Phi[:, chosen],
            R=self.R + flexible @ flexible.T,
        )

    def grazing_amplitude(self, mode: int = 0) -> float:
        """Amplitude of modal coordinate `mode` (kg^1/2 m) at which the linear motion just touches.

        Args:
            mode: Index of the linear mode, from 0.

        Raises:
            ModelError: if the mode does not move any contact point in its contact direction.
        """
        motion = np.abs(self.Phi[:, mode])
        if motion.max() <= 1e-10 * np.abs(self.Phi).max():
            raise ModelError(
                f"mode {mode + 1} does not move any contact point in the contact direction: "
                "it never touches the obstacle; choose another mode.number or contact.direction"
            )
        with np.errstate(divide="ignore", over="ignore"):
            return float(np.min(self.gap / motion))

    def dimensionless(self, mode: int = 0) -> tuple[ReducedModel, Scales]:
        """The model in units in which mode `mode` has omega = 1 and touches at amplitude 1."""
        scales = Scales(
            omega=float(self.omega[mode]),
            amplitude=self.grazing_amplitude(mode),
            length=float(self.gap.min()),
        )
        model = ReducedModel(
            omega=self.omega / scales.omega,
            Phi=self.Phi * scales.amplitude / scales.length,
            R=self.R * scales.force / scales.length,
            gap=self.gap / scales.length,
        )
        return model, scales


@dataclass(frozen=True, slots=True)
class Reduction:
    """A reduced model and the way back to the displacement of the whole structure.

    With modal coordinates q and contact forces lambda the displacement in m is

        u = shapes q - residual_shapes lambda.

    Attributes:
        model: Reduced model.
        shapes: Displacement per modal coordinate, kg^-1/2, shape (n, J), signed so that the contact
            point that moves most moves towards its obstacle; n degrees of freedom, of this rank.
        residual_shapes: Displacement per unit contact force that these do not bring, m/N,
            shape (n, n_c); zero where the contact points carry mass.
    """

    model: ReducedModel
    shapes: Array
    residual_shapes: Array

    def displacement(self, q: Array, force: Array) -> Array:
        """Displacement u in m, shape (n,), of coordinates (J,) and contact forces in N (n_c,)."""
        return np.asarray(self.shapes @ q - self.residual_shapes @ force)


def towards_obstacle(Phi: Array) -> Array:
    """Signs that make the contact point that moves most move towards its obstacle, shape (J,).

    Args:
        Phi: Displacement of the contact points per modal coordinate, shape (n_c, J).
    """
    largest = Phi[np.argmax(np.abs(Phi), axis=0), np.arange(Phi.shape[1])]
    return np.where(largest < 0, -1.0, 1.0)


@dataclass(frozen=True, slots=True)
class Scales:
    """Units of a dimensionless model: rad/s, kg^1/2 m, m; force and energy follow."""

    omega: float
    amplitude: float
    length: float

    @property
    def energy(self) -> float:
        """Unit of energy in J."""
        return (self.omega * self.amplitude) ** 2

    @property
    def force(self) -> float:
        """Unit of contact force in N."""
        return self.energy / self.length
