"""What loads a body steadily: rotation, temperature, pressures and forces, in SI units."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.warming import UniformWarming, Warming


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
        warming: Temperature less that at which the body is free of stress.
        pressures: Pressures on facets.
        forces: Forces at vertices or spread over facets, which keep their directions.
    """

    rotation: Rotation | None = None
    warming: Warming = field(default_factory=UniformWarming)
    pressures: tuple[Pressure, ...] = ()
    forces: tuple[Attachment, ...] = ()

    @property
    def any(self) -> bool:
        """Whether there is a load at all."""
        return bool(self.speed or self.warming.any or self.pressures or self.forces)

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
