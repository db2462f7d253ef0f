"""What loads a body steadily: rotation, temperature, pressures and forces, in SI units."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.fem.attachment import Attachment

#: A component of a unit vector, or a distance over a body's size, that is zero to round-off.
_ZERO = 1e-12


@dataclass(frozen=True, slots=True)
class Rotation:
    """Steady rotation about a fixed axis.

    Attributes:
        axis: Direction of the axis, shape (3,); any length.
        origin: A point on it in m, shape (3,).
        speed: Omega in rad/s; its sign is that of a right-handed turn about the axis.
        coriolis: Whether Coriolis forces belong to the linear modes.
    """

    axis: tuple[float, float, float]
    origin: tuple[float, float, float]
    speed: float
    coriolis: bool = False

    @property
    def unit(self) -> Array:
        """Unit vector along the axis."""
        return np.asarray(np.array(self.axis) / np.linalg.norm(self.axis))

    @property
    def normal(self) -> Array:
        """P = I - e e^T, the projection normal to the axis, shape (3, 3)."""
        return np.eye(3) - np.outer(self.unit, self.unit)

    @property
    def spin(self) -> Array:
        """W with W u = e x u, shape (3, 3)."""
        x, y, z = self.unit
        return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])

    def arm(self, points: Array) -> Array:
        """P (X - o): from the axis to points (n, 3) in m."""
        return np.asarray((points - np.array(self.origin)) @ self.normal)

    def assert_within(self, dim: int) -> None:
        """Refuse an axis whose centrifugal force leaves the dimensions of a body.

        Raises:
            ModelError: if it does, or has no part in them.
        """
        P, out = self.normal, slice(dim, 3)
        offset = np.abs((P @ np.array(self.origin))[out]).max(initial=0.0)
        if np.abs(P[out, :dim]).max(initial=0.0) > _ZERO or offset > _ZERO:
            needs = "normal to x and through y = z = 0" if dim == 1 else "z, or lie in z = 0"
            raise ModelError(
                f"rotation.axis = {list(self.axis)} through rotation.origin = {list(self.origin)}: "
                f"its centrifugal force leaves the {dim} dimensions of the mesh: must be {needs}"
            )
        if np.abs(P[:dim, :dim]).max() <= _ZERO:
            raise ModelError(
                f"rotation.axis = {list(self.axis)}: the body lies along it, so that speed has no "
                "effect: must not be along x"
            )


@dataclass(frozen=True, slots=True)
class Pressure:
    """Pressure on facets, positive towards the body.

    Attributes:
        key: The study's section, for messages.
        facets: Names of groups of facets.
        value: Pressure in Pa.
        follower: Whether it stays normal to the deformed surface, per deformed area; else it keeps
            the direction and the area of the unloaded one.
    """

    key: str
    facets: tuple[str, ...]
    value: float
    follower: bool = False


@dataclass(frozen=True, slots=True)
class Loads:
    """All that loads a body steadily.

    Attributes:
        rotation: Rotation; None for a body that stands still.
        warming: Temperature less that at which the body is free of stress, in K.
        pressures: Pressures on facets.
        forces: Forces at vertices or spread over facets, which keep their directions.
    """

    rotation: Rotation | None = None
    warming: float = 0.0
    pressures: tuple[Pressure, ...] = ()
    forces: tuple[Attachment, ...] = ()

    @property
    def any(self) -> bool:
        """Whether there is a load at all."""
        return bool(self.speed or self.warming or self.pressures or self.forces)

    @property
    def speed(self) -> float:
        """Omega in rad/s."""
        return self.rotation.speed if self.rotation else 0.0

    @property
    def follows(self) -> bool:
        """Whether a pressure follows the surface, so that no potential need exist."""
        return any(each.follower for each in self.pressures)

    def at_rest(self) -> Loads:
        """The same without rotation."""
        return replace(self, rotation=None)
