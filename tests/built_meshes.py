"""Built-in geometries meshed in a gmsh session of their own, as arrays."""

from itertools import combinations
from typing import Any, NamedTuple

import gmsh
import numpy as np


class Mesh(NamedTuple):
    """What the tests look at: all node coordinates, and the elements of each group."""

    points: np.ndarray
    groups: dict[str, np.ndarray]
    volume: float
    worst_shape: float

    def nodes(self, name: str) -> np.ndarray:
        return self.points[np.unique(self.groups[name])]

    def box(self, name: str) -> Any:
        nodes = self.nodes(name)
        return np.array([nodes.min(axis=0), nodes.max(axis=0)])


def build(geometry: Any) -> Mesh:
    """Build in a gmsh session of its own."""
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("test")
        geometry.build(gmsh.model)
        return _read_model()
    finally:
        gmsh.finalize()


def _read_model() -> Mesh:
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    index = np.zeros(int(tags.max()) + 1, dtype=int)
    index[tags] = np.arange(len(tags))
    groups, cells = {}, []
    for dim, group in gmsh.model.getPhysicalGroups():
        name = gmsh.model.getPhysicalName(dim, group)
        blocks = []
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dim, group):
            kinds, (elements,), (nodes,) = gmsh.model.mesh.getElements(dim, entity)
            assert len(kinds) == 1
            blocks.append(index[nodes].reshape(len(elements), -1))
            cells += elements.tolist() if name == "body" else []
        groups[name] = np.vstack(blocks)
    points = coordinates.reshape(-1, 3)
    if len(groups["body"][0]) == 2:
        return Mesh(points, groups, float(np.ptp(points[:, 0])), 1.0)
    volume = gmsh.model.mesh.getElementQualities(cells, "volume").sum()
    worst = gmsh.model.mesh.getElementQualities(cells, "minSICN").min()
    return Mesh(points, groups, float(volume), float(worst))


def facet_area(mesh: Mesh, name: str) -> float:
    """Area of plane facets: triangles, or quadrilaterals by their diagonals."""
    corners = mesh.points[mesh.groups[name]]
    if corners.shape[1] == 3:
        spans = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    else:
        spans = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    return float(np.linalg.norm(np.cross(*spans), axis=1).sum() / 2)


def assert_facets_bound_cells(mesh: Mesh) -> None:
    """Every facet has its nodes in some cell: grid diagonals of faces and cells agree."""
    size = next(facets.shape[1] for name, facets in mesh.groups.items() if name != "body")
    faces = {
        frozenset(face)
        for cell in mesh.groups["body"].tolist()
        for face in combinations(cell, size)
    }
    for name, facets in mesh.groups.items():
        if name != "body":
            assert all(frozenset(facet) in faces for facet in facets.tolist()), name
