"""What the state of rest and closed points need to know of a reduced model."""

from __future__ import annotations

from typing import Protocol

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.kinematics import Kinematics


class FlexiblePoints(Protocol):
    """Modes, and contact points with residual flexibility; see `mechanics.model.ReducedModel`."""

    @property
    def omega(self) -> Array:
        """Natural circular frequencies, shape (J,)."""

    @property
    def Phi(self) -> Array:
        """Displacement of the contact points per modal coordinate, shape (n_c, J)."""

    @property
    def R(self) -> Array:
        """Residual flexibility, shape (n_c, n_c)."""

    @property
    def gap(self) -> Array:
        """Gaps, shape (n_c,)."""

    @property
    def reference(self) -> float | None:
        """Displacement at gamma ratio 1 of points that touch without force at rest."""

    @property
    def massless(self) -> bool:
        """Whether the contact points carry no mass."""

    @property
    def kinematics(self) -> Kinematics:
        """What large deflection adds."""

    @property
    def modes(self) -> int:
        """Number of modes J."""

    @property
    def points(self) -> int:
        """Number of contact points n_c."""
