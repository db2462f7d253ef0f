"""What is drawn of a body in space, and from where, before it is drawn.

Bodies are projected onto the plane of the picture without perspective, so that lengths in that
plane are true.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol, Self

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.output.surface import face_normals

#: The three axes, the upward one last.
_AXES = {"x": (1, 2, 0), "y": (2, 0, 1), "z": (0, 1, 2)}

#: Pictures are larger than what they show by this part on each side.
_MARGIN = 0.04

#: Faces with a smaller cosine to the viewer are seen edgewise.
_EDGEWISE = 0.02

#: No places, shape (0, 3).
_NOWHERE: Array = np.empty((0, 3))


def size_of(places: Array) -> float:
    """Diagonal of the box around places of shape (p, 3), in m."""
    return float(np.linalg.norm(np.ptp(places, axis=0)))


@dataclass(frozen=True, slots=True)
class View:
    """Where a body is looked at from.

    Attributes:
        elevation: Angle above the plane normal to the upward axis, in degrees.
        azimuth: Angle about the upward axis, in degrees.
        up: Axis that points upwards: x, y or z.
    """

    elevation: float = 20.0
    azimuth: float = -60.0
    up: str = "z"

    @property
    def opposite(self) -> View:
        """The view from the other side; of a convex body it shows what this one hides."""
        return View(-self.elevation, self.azimuth + 180, self.up)

    @property
    def frame(self) -> Array:
        """Unit vectors to the right, upwards, and towards the viewer, shape (3, 3)."""
        elevation, azimuth = np.radians([self.elevation, self.azimuth])
        sin_e, cos_e = np.sin(elevation), np.cos(elevation)
        sin_a, cos_a = np.sin(azimuth), np.cos(azimuth)
        frame = np.empty((3, 3))
        frame[:, list(_AXES[self.up])] = [
            [-sin_a, cos_a, 0.0],
            [-sin_e * cos_a, -sin_e * sin_a, cos_e],
            [cos_e * cos_a, cos_e * sin_a, sin_e],
        ]
        return frame


#: The x-y plane from above, for bodies in the plane.
PLANE = View(elevation=90.0, azimuth=-90.0)


@dataclass(frozen=True, slots=True)
class Camera:
    """A rectangle of the picture plane.

    Attributes:
        frame: As `View.frame`.
        low: Lower left corner in m, along right and up, shape (2,).
        high: Upper right corner.
        pixels: Width and height of the picture.
    """

    frame: Array
    low: Array
    high: Array
    pixels: tuple[int, int]

    @classmethod
    def around(
        cls, places: Array, view: View, *, pixels: int, slenderness: float | None = None
    ) -> Camera:
        """A camera that sees all places.

        Args:
            places: In m, shape (p, 3).
            view: Where it is looked at from.
            pixels: Longer side of the picture.
            slenderness: Least height over width of the picture, and least width over height.
        """
        frame = view.frame
        flat = places @ frame[:2].T
        low, high = flat.min(axis=0), flat.max(axis=0)
        size = high - low
        middle = (low + high) / 2
        size = np.maximum(size, (slenderness or 0.05) * size.max()) + 2 * _MARGIN * size.max()
        width, height = np.maximum(1, np.round(pixels * size / size.max())).astype(int)
        return cls(frame, middle - size / 2, middle + size / 2, (int(width), int(height)))

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top in m, as matplotlib has them."""
        return (
            float(self.low[0]),
            float(self.high[0]),
            float(self.low[1]),
            float(self.high[1]),
        )

    def seen(self, places: Array) -> Array:
        """Places in the picture plane in m, shape (p, 2)."""
        return np.asarray(places @ self.frame[:2].T)


class Layer(Protocol):
    """A part of what is drawn."""

    @property
    def symbol(self) -> str:
        """How it is shown in a legend: "face", "line", "ball" or "arrow"."""

    @property
    def reach(self) -> Array:
        """Places in m that it reaches to besides the body, shape (p, 3)."""

    @property
    def extent(self) -> Array:
        """Places in m that it reaches to beside a body that is no part of it, shape (p, 3)."""

    def nearer(self, faces: Array, lines: Array) -> Self:
        """The same nearer to the viewer: faces by one vector in m, lines by another."""

    def is_seen(self, towards: Array) -> bool:
        """Whether any of it is turned to a viewer in the direction of a unit vector."""


@dataclass(frozen=True, slots=True)
class Faces:
    """Triangles or quadrangles, of one colour or coloured by values at the nodes.

    Attributes:
        nodes: Places in m, shape (p, 3).
        corners: Nodes of each face, shape (f, 3 or 4).
        colour: Colour of all faces, if there are no values.
        values: Value at each node, shape (p,).
        limits: Values of the first and of the last colour.
        colours: Colour map of the values.
        opacity: 1 for faces that nothing is seen through.
        edges: Whether the edges of the faces are drawn.
        lit: Whether brightness shows the slope of the faces.
    """

    nodes: Array
    corners: Indices
    colour: str = "white"
    values: Array | None = None
    limits: tuple[float, float] = (0.0, 1.0)
    colours: str = "viridis"
    opacity: float = 1.0
    edges: bool = False
    lit: bool = True

    @property
    def symbol(self) -> str:
        """As `Layer.symbol`."""
        return "face"

    @property
    def reach(self) -> Array:
        """None: faces are those of the body, or of a casing whose edge is drawn."""
        return _NOWHERE

    @property
    def extent(self) -> Array:
        """Its nodes."""
        return self.nodes

    def nearer(self, faces: Array, lines: Array) -> Faces:
        """As `Layer.nearer`."""
        return replace(self, nodes=self.nodes + faces)

    def is_seen(self, towards: Array) -> bool:
        """Whether a face is turned to the viewer."""
        return bool((face_normals(self.nodes[self.corners]) @ towards > _EDGEWISE).any())


@dataclass(frozen=True, slots=True)
class Lines:
    """Straight lines with ends of shape (s, 2, 3) in m, of a width in pixels."""

    ends: Array
    colour: str = "black"
    width: float = 2.0

    @property
    def symbol(self) -> str:
        """As `Layer.symbol`."""
        return "line"

    @property
    def reach(self) -> Array:
        """The ends."""
        return self.ends.reshape(-1, 3)

    @property
    def extent(self) -> Array:
        """As `reach`."""
        return self.reach

    def nearer(self, faces: Array, lines: Array) -> Lines:
        """As `Layer.nearer`."""
        return replace(self, ends=self.ends + lines)

    def is_seen(self, towards: Array) -> bool:
        """Lines are seen from anywhere."""
        return True


@dataclass(frozen=True, slots=True)
class Balls:
    """Balls at places of shape (b, 3) in m, with radii in m, shape (b,)."""

    places: Array
    radii: Array
    colour: str = "black"

    @property
    def symbol(self) -> str:
        """As `Layer.symbol`."""
        return "ball"

    @property
    def reach(self) -> Array:
        """None: balls are small, and on the body."""
        return _NOWHERE

    @property
    def extent(self) -> Array:
        """As `reach`."""
        return self.reach

    def nearer(self, faces: Array, lines: Array) -> Balls:
        """The same: balls stand out of the body."""
        return self

    def is_seen(self, towards: Array) -> bool:
        """Balls are seen from anywhere."""
        return True


@dataclass(frozen=True, slots=True)
class Arrows:
    """Arrows from places along vectors, both of shape (a, 3) in m."""

    places: Array
    vectors: Array
    colour: str = "black"

    @property
    def symbol(self) -> str:
        """As `Layer.symbol`."""
        return "arrow"

    @property
    def reach(self) -> Array:
        """The tips."""
        return self.places + self.vectors

    @property
    def extent(self) -> Array:
        """As `reach`."""
        return self.reach

    def nearer(self, faces: Array, lines: Array) -> Arrows:
        """The same: arrows stand out of the body."""
        return self

    def is_seen(self, towards: Array) -> bool:
        """Arrows are seen from anywhere."""
        return True


@dataclass(frozen=True, slots=True)
class Scene:
    """All that one picture shows.

    Attributes:
        layers: What is drawn.
        camera: What part of it is seen.
    """

    layers: Sequence[Layer]
    camera: Camera
