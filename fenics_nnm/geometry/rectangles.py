"""Plane bodies made of rectangles of a grid, and prisms over them."""

import math
from dataclasses import dataclass

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry.parameters import GmshModel, check_count

Edge = tuple[str, int, int]
"""("x" or "y", i, j): the edge from grid point (i, j) to the next one along x or y."""

Cell = tuple[int, int]
"""(i, j): the rectangle between the grid lines i and i + 1 of x, j and j + 1 of y."""


@dataclass(frozen=True, slots=True)
class Rectangles:
    """Some of the rectangles of a grid, each meshed in a regular grid of its own.

    Attributes:
        x: Rising coordinates of the grid lines.
        y: The same along y.
        filled: Rectangles (i, j) between lines i and i + 1, j and j + 1 that are body.
        size: Largest edge length of an element.
        depth: Length of the prism along z; None for a body in the plane.
    """

    x: tuple[float, ...]
    y: tuple[float, ...]
    filled: tuple[Cell, ...]
    size: float
    depth: float | None = None

    def build(
        self,
        gmsh_model: GmshModel,
        groups: dict[str, list[Edge]],
        regions: dict[str, list[Cell]] | None = None,
    ) -> None:
        """Mesh with quadrilaterals or hexahedra, and name facets and cells.

        Args:
            gmsh_model: Where to mesh.
            groups: Names of facets, with the edges that they are on or over.
            regions: Names of cells, with the rectangles that they are in; all cells are "body" too.
        """
        self._check_count()
        edges = self._add_edges(gmsh_model.geo)
        surfaces = [self._add_surface(gmsh_model.geo, edges, cell) for cell in self.filled]
        facets, bodies = edges, surfaces
        if self.depth is not None:
            facets, bodies = self._extruded(gmsh_model.geo, edges, surfaces)
        gmsh_model.geo.synchronize()
        dim = 2 if self.depth is None else 3
        gmsh_model.addPhysicalGroup(dim, bodies, name="body")
        made = dict(zip(self.filled, bodies, strict=True))
        for name, cells in (regions or {}).items():
            gmsh_model.addPhysicalGroup(dim, [made[cell] for cell in cells], name=name)
        for name, members in groups.items():
            gmsh_model.addPhysicalGroup(dim - 1, [facets[edge] for edge in members], name=name)
        gmsh_model.mesh.generate(dim)

    def _check_count(self) -> None:
        """Refuse a size that gives more elements than anybody means."""
        layers = 1 if self.depth is None else self._intervals(self.depth)
        count = layers * sum(
            self._intervals(self.x[i + 1] - self.x[i]) * self._intervals(self.y[j + 1] - self.y[j])
            for i, j in self.filled
        )
        try:
            check_count(f"mesh.element_size = {self.size:g}", count)
        except ValueError as error:
            raise GeometryError(str(error)) from error

    def _around(self, cell: Cell) -> tuple[Edge, Edge, Edge, Edge]:
        """Edges of a rectangle: bottom, right, top, left."""
        i, j = cell
        return ("x", i, j), ("y", i + 1, j), ("x", i, j + 1), ("y", i, j)

    def _add_edges(self, geo: GmshModel) -> dict[Edge, int]:
        wanted = sorted({edge for cell in self.filled for edge in self._around(cell)})
        ends = {edge: _ends(edge) for edge in wanted}
        corners = sorted({corner for pair in ends.values() for corner in pair})
        points = {(i, j): geo.addPoint(self.x[i], self.y[j], 0) for i, j in corners}
        edges = {edge: geo.addLine(*(points[corner] for corner in ends[edge])) for edge in wanted}
        for (direction, i, j), line in edges.items():
            grid, k = (self.x, i) if direction == "x" else (self.y, j)
            geo.mesh.setTransfiniteCurve(line, self._intervals(grid[k + 1] - grid[k]) + 1)
        return edges

    def _intervals(self, length: float) -> int:
        return max(1, math.ceil(length / self.size - 1e-9))

    def _add_surface(self, geo: GmshModel, edges: dict[Edge, int], cell: Cell) -> int:
        bottom, right, top, left = (edges[edge] for edge in self._around(cell))
        surface = geo.addPlaneSurface([geo.addCurveLoop([bottom, right, -top, -left])])
        geo.mesh.setTransfiniteSurface(surface)
        geo.mesh.setRecombine(2, surface)
        return int(surface)

    def _extruded(
        self, geo: GmshModel, edges: dict[Edge, int], surfaces: list[int]
    ) -> tuple[dict[Edge, int], list[int]]:
        """Faces over the edges, and volumes over the surfaces."""
        depth = self.depth or 0.0
        layers = [self._intervals(depth)]
        faces: dict[Edge, int] = {}
        volumes = []
        for cell, surface in zip(self.filled, surfaces, strict=True):
            made = geo.extrude([(2, surface)], 0, 0, depth, numElements=layers, recombine=True)
            volumes.append(made[1][1])
            faces.update(zip(self._around(cell), (tag for _, tag in made[2:]), strict=True))
        return {edge: faces[edge] for edge in edges}, volumes


def _ends(edge: Edge) -> tuple[tuple[int, int], tuple[int, int]]:
    direction, i, j = edge
    return (i, j), (i + 1, j) if direction == "x" else (i, j + 1)
