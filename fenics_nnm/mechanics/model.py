"""The reduced model: all that the nonlinear solver knows of a structure."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.contact_points import MASSLESS, ContactPoints
from fenics_nnm.mechanics.definite import surely_above
from fenics_nnm.mechanics.kinematics import LINEAR, Kinematics
from fenics_nnm.mechanics.rest import RestState, rest_state

#: R may be indefinite by this much, relative to its largest entry, from round-off in the modes.
_INDEFINITE_TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True)
class ReducedModel:
    r"""A structure in modal form with residual flexibility at its contact points.

    With modal coordinates q, contact forces lambda >= 0 and contact displacements w,

        q_j'' + omega_j^2 q_j + (Phi^T lambda)_j = 0,      w = Phi q - R lambda,
        lambda >= 0,   w - gap <= 0,   lambda (w - gap) = 0.

    Monjaraz-Tec, Gross, Krack, Comput. Struct. 260 (2022) 106698 for contact points without mass
    (R > 0); a basis whose contact points carry mass (Craig-Bampton) has R = 0.

    Attributes:
        omega: Natural circular frequencies of the basis in rad/s, ascending, shape (J,).
        Phi: Displacement of each contact point in its contact direction per modal
            coordinate, mass-normalised (kg^-1/2), shape (n_c, J).
        R: Residual flexibility of the contact points in m/N, shape (n_c, n_c), symmetric.
        gap: Initial gaps in m, shape (n_c,), of any sign; negative is an interference.
        reference: Displacement in m at gamma ratio 1 of points that touch without force at rest.
        contact: Whether the contact points carry mass, as the reduction chose.
        kinematics: What large deflection adds: nothing, or second-order kinematics and stiffness.

    Raises:
        ModelError: if shapes disagree, values are not finite, frequencies are not positive and
            ascending, or R is not symmetric positive semidefinite, or not what such points need.
    """

    omega: Array
    Phi: Array
    R: Array
    gap: Array
    reference: float | None = None
    contact: ContactPoints = MASSLESS
    kinematics: Kinematics = LINEAR
    _rest: list[RestState] = field(init=False, repr=False, compare=False, default_factory=list)
    _ends: dict[int, tuple[float, ...]] = field(
        init=False, repr=False, compare=False, default_factory=dict
    )

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
        scale = max(float(np.abs(self.R).max()), np.finfo(float).tiny)
        if np.abs(self.R - self.R.T).max() > 1e-8 * scale:
            raise ModelError("reduced model: R is not symmetric")
        self._check_definite(-_INDEFINITE_TOLERANCE * scale)
        if objection := self.contact.objection(self.R):
            raise ModelError(f"reduced model: {objection}")
        self.kinematics.assert_fits(self)

    def _check_definite(self, least: float) -> None:
        if surely_above(self.R, least):
            return
        lowest = float(np.linalg.eigvalsh(self.R)[0])
        if lowest < least:
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
        """Whether the contact points carry no mass."""
        return self.contact.massless

    @property
    def static_flexibility(self) -> Array:
        """Static flexibility of each contact point in m/N, shape (n_c,)."""
        modal = np.sum((self.Phi / self.omega) ** 2, axis=1)
        return np.asarray(modal + np.diagonal(self.R))

    @property
    def points(self) -> int:
        """Number of contact points n_c."""
        return int(np.size(self.gap))

    def with_modes(self, chosen: Indices | list[int]) -> ReducedModel:
        """Keep some modes; the static flexibility of the others goes to R.

        Args:
            chosen: Indices of the modes to keep, ascending.

        Raises:
            ModelError: if a master of second-order kinematics is left out.
        """
        dropped = np.setdiff1d(np.arange(self.modes), chosen)
        flexible = self.Phi[:, dropped] / self.omega[dropped]
        R = self.R + flexible @ flexible.T
        return replace(
            self,
            omega=self.omega[chosen],
            Phi=self.Phi[:, chosen],
            R=R,
            contact=self.contact.of_part(R),
            kinematics=self.kinematics.without_modes(np.asarray(chosen), self),
        )

    def spanned_by(
        self, rest: RestState, chosen: Indices | list[int]
    ) -> tuple[ReducedModel, Array]:
        """Keep the inertia of some modes about the state of rest; all else follows statically.

        Static flexibility and gaps stay as they are, so the state of rest does, too; about it the
        part has the chosen frequencies.

        Args:
            rest: State of rest.
            chosen: Indices of its modes to keep, ascending.

        Returns:
            The part, and its modes as orthonormal columns, shape (J, k).
        """
        if not rest.closed.any():
            return self.with_modes(chosen), np.eye(self.modes)[:, chosen]
        if len(chosen) == self.modes:
            return self, np.eye(self.modes)
        V, W = rest.shapes[:, chosen], np.delete(rest.shapes, chosen, axis=1)
        K = self.omega[:, None] ** 2
        dropped = W.T @ (K * W)
        coupling = W.T @ (K * V)
        follows = np.linalg.solve(dropped, coupling)
        squares, U = np.linalg.eigh(V.T @ (K * V) - coupling.T @ follows)
        free = self.Phi @ W
        R = self.R + free @ np.linalg.solve(dropped, free.T)
        Phi = (self.Phi @ V - free @ follows) @ U
        part = replace(self, omega=np.sqrt(squares), Phi=Phi, R=(R + R.T) / 2)
        return part, V @ U

    @property
    def linearised(self) -> ReducedModel:
        """The same with linear kinematics."""
        return replace(self, kinematics=LINEAR)

    def grazing_amplitude(self, mode: int = 0) -> float:
        """Amplitude of linear mode `mode` about the state of rest (kg^1/2 m) at gamma ratio 1.

        There the first point closes or lifts off, see `RestState.amplitude`.

        Args:
            mode: Index of the linear mode, from 0.

        Raises:
            ModelError: if the mode does not move any contact point in its contact direction, or
                points touch at rest and there is no reference.
        """
        return self.at_rest().amplitude(mode)

    def at_rest(self) -> RestState:
        """State of rest, and linear modes about it; it is computed once.

        Raises:
            ModelError: if a gap is not positive and contact points carry mass.
        """
        if not self._rest:
            self._rest.append(rest_state(self))
        return self._rest[0]

    def ends_alone(self, mode: int) -> tuple[float, ...]:
        """Circular frequencies of a mode alone with all contact points open, and all closed.

        The others follow statically. Nothing where contact points carry mass; computed once.

        Args:
            mode: Index of a linear mode about the state of rest.
        """
        if mode not in self._ends:
            alone, _ = self.linearised.spanned_by(self.at_rest(), np.array([mode]))
            self._ends[mode] = _ends(alone) if alone.massless else ()
        return self._ends[mode]

    def dimensionless(self, mode: int = 0) -> tuple[ReducedModel, Scales]:
        """The model in units in which mode `mode` at rest has omega = 1, and gamma ratio 1 at 1."""
        rest = self.at_rest()
        amplitude, length = rest.amplitude(mode), float(self.gap.min())
        if length <= 0:
            length = amplitude * float(np.abs(rest.motion[:, mode]).max())
        scales = Scales(omega=float(rest.omega[mode]), amplitude=amplitude, length=length)
        model = ReducedModel(
            omega=self.omega / scales.omega,
            Phi=self.Phi * scales.amplitude / scales.length,
            R=self.R * scales.force / scales.length,
            gap=self.gap / scales.length,
            reference=None if self.reference is None else self.reference / scales.length,
            contact=self.contact,
            kinematics=self.kinematics.scaled(
                omega=scales.omega, amplitude=scales.amplitude, length=scales.length
            ),
        )
        return model, scales


def _ends(alone: ReducedModel) -> tuple[float, float]:
    """Circular frequencies of a model of one mode with all contact points open, and all closed."""
    opened = float(alone.omega[0])
    stiffness = float(alone.Phi[:, 0] @ np.linalg.solve(alone.R, alone.Phi[:, 0]))
    return opened, float(np.sqrt(opened**2 + stiffness))


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
