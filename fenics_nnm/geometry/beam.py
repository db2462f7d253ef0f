"""A box in three dimensions, straight or tapered."""

import math
from typing import Literal, Self

from pydantic import Field, model_validator

from fenics_nnm.geometry.lengths import LengthUnit
from fenics_nnm.geometry.parameters import (
    Count,
    Factor,
    GeometryRecord,
    GmshModel,
    Length,
    check_count,
)

# Corner i + 2 j + 4 k lies at (x, y, z) = (i length, j width, k height).
_FACES = {
    "left": (0, 2, 6, 4),
    "right": (1, 3, 7, 5),
    "front": (0, 1, 5, 4),
    "back": (2, 3, 7, 6),
    "bottom": (0, 1, 3, 2),
    "top": (4, 5, 7, 6),
}


class Beam(GeometryRecord):
    """Box from the origin to (`length`, `width`, `height`), meshed in a regular grid.

    The cross-section at x = `length` is `tip_scale` times that at x = 0, about the centre line
    y = `width`/2, z = `height`/2, and varies linearly in between.

    Groups: cells "body"; faces "left" and "right" (small and large x), "front" and "back"
    (y), "bottom" and "top" (z).
    """

    model: Literal["beam"] = "beam"
    length_unit: LengthUnit = Field(
        default="m", description="unit of the lengths here and of the mesh"
    )
    length: Length = Field(description="size along x, in length_unit")
    width: Length = Field(description="size along y at x = 0, in length_unit")
    height: Length = Field(description="size along z at x = 0, in length_unit")
    tip_scale: Factor = Field(
        default=1.0, description="width and height at x = length over those at x = 0 (no unit)"
    )
    elements: tuple[Count, Count, Count] = Field(description="grid intervals along x, y and z")
    cells: Literal["tetrahedron", "hexahedron"] = Field(
        default="hexahedron", description="each grid cell is one hexahedron or six tetrahedra"
    )

    @model_validator(mode="after")
    def _few_elements(self) -> Self:
        check_count("elements", math.prod(self.elements))
        return self

    def build(self, gmsh_model: GmshModel) -> None:
        """Fill the current gmsh model with geometry, mesh and named groups."""
        points = [gmsh_model.geo.addPoint(*self._corner(c)) for c in range(8)]
        lines = self._add_lines(gmsh_model.geo, points)
        faces = {name: _add_face(gmsh_model.geo, c, lines) for name, c in _FACES.items()}
        loop = gmsh_model.geo.addSurfaceLoop(list(faces.values()))
        volume = gmsh_model.geo.addVolume([loop])
        gmsh_model.geo.synchronize()
        for (start, end), line in lines.items():
            intervals = self.elements[(end - start).bit_length() - 1]
            gmsh_model.mesh.setTransfiniteCurve(line, intervals + 1)
        for name, face in faces.items():
            gmsh_model.mesh.setTransfiniteSurface(
                face, cornerTags=[points[c] for c in _FACES[name]]
            )
            gmsh_model.addPhysicalGroup(2, [face], name=name)
            if self.cells == "hexahedron":
                gmsh_model.mesh.setRecombine(2, face)
        gmsh_model.mesh.setTransfiniteVolume(volume, [points[c] for c in (0, 1, 3, 2, 4, 5, 7, 6)])
        gmsh_model.addPhysicalGroup(3, [volume], name="body")
        gmsh_model.mesh.generate(3)

    def _corner(self, corner: int) -> tuple[float, float, float]:
        """Coordinates of a corner, in length_unit."""
        at_tip, at_back, at_top = corner & 1, corner >> 1 & 1, corner >> 2 & 1
        scale = self.tip_scale if at_tip else 1.0
        y = self.width * (0.5 + scale * (at_back - 0.5))
        z = self.height * (0.5 + scale * (at_top - 0.5))
        return self.length * at_tip, y, z

    def _add_lines(self, geo: GmshModel, points: list[int]) -> dict[tuple[int, int], int]:
        """Add the twelve edges, each towards larger coordinates; tags by corner pair."""
        pairs = [(c, c | bit) for c in range(8) for bit in (1, 2, 4) if not c & bit]
        return {pair: geo.addLine(points[pair[0]], points[pair[1]]) for pair in pairs}


def _add_face(geo: GmshModel, corners: tuple[int, ...], lines: dict[tuple[int, int], int]) -> int:
    """Add the plane face through four corners, given in turn."""
    turn = zip(corners, corners[1:] + corners[:1], strict=True)
    loop = [lines[a, b] if a < b else -lines[b, a] for a, b in turn]
    return geo.addPlaneSurface([geo.addCurveLoop(loop)])
