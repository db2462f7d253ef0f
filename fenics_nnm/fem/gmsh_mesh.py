"""From the current gmsh model to points, cells and named groups."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import gmsh
import numpy as np
from dolfinx.cpp.mesh import cell_entity_type, to_type

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.compat import cell_permutation, ufl_mesh
from fenics_nnm.fem.raw_mesh import RawMesh

#: Element shapes of gmsh that can be used, by the first word of their name.
_SHAPES = ("Line", "Triangle", "Quadrilateral", "Tetrahedron", "Hexahedron")

#: An element whose signed inverse condition number is below this is taken as flat.
_FLAT = 1e-6


@contextmanager
def gmsh_session(name: str) -> Iterator[None]:
    """An empty gmsh model for a while."""
    started = not gmsh.isInitialized()
    if started:
        gmsh.initialize(["-noenv"], interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add(name)
    try:
        yield
    finally:
        gmsh.model.remove()
        if started:
            gmsh.finalize()


def open_mesh(path: Path) -> None:
    """Read a file with a mesh into the current gmsh model.

    Raises:
        MeshError: if there is no such file, gmsh cannot read it or it holds no mesh.
    """
    if not path.is_file():
        what = "is not a file" if path.exists() else "there is no such file"
        raise MeshError(f"mesh.file = {path}: {what}")
    try:
        gmsh.merge(str(path))
    except Exception as error:  # gmsh raises bare Exception
        raise MeshError(f"mesh.file = {path}: gmsh cannot read it: {error}") from error
    if not gmsh.model.mesh.getNodes()[0].size:
        raise MeshError(f"mesh.file = {path}: holds no mesh")


def extracted(name: str) -> RawMesh:
    """Points, cells and named groups of the current gmsh model.

    Args:
        name: What is read, for messages.

    Raises:
        MeshError: if there is no named body, or its cells cannot be used.
    """
    groups = _named_groups()
    dim = max((d for d, _ in groups), default=0)
    if dim == 0:
        raise MeshError(
            f"{name}: no physical groups with elements: name the body, the clamped and the "
            "contact facets (gmsh: Physical Volume, Physical Surface ...)"
        )
    bodies = {group: entities for (d, group), entities in groups.items() if d == dim}
    cell_type, cells, owner = _cells(name, dim, list(bodies.values()))
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    points = coordinates.reshape(-1, 3)
    if dim < 3 and np.abs(points[:, dim:]).max() > 1e-9 * np.ptp(points, axis=0).max():
        raise MeshError(
            f"{name}: the largest elements have dimension {dim}, but the mesh leaves "
            f"{'the x axis' if dim == 1 else 'the x-y plane'} (no shells or curved beams; "
            "the body needs a physical group too)"
        )
    row = np.full(int(tags.max()) + 1, -1, dtype=np.int64)
    row[tags.astype(np.int64)] = np.arange(len(tags))
    facets = {
        group: row[_facet_nodes(cell_type, dim - 1, entities)]
        for (d, group), entities in groups.items()
        if d == dim - 1
    }
    facets = {group: nodes for group, nodes in facets.items() if len(nodes)}
    return RawMesh(
        cell_type,
        dim,
        np.ascontiguousarray(points[:, :dim]),
        row[cells],
        facets,
        {group: np.flatnonzero(np.isin(owner, entities)) for group, entities in bodies.items()},
    )


def _named_groups() -> dict[tuple[int, str], Indices]:
    """Entities of each physical group that has elements, by dimension and name."""
    groups = {}
    for dim, tag in gmsh.model.getPhysicalGroups():
        entities = gmsh.model.getEntitiesForPhysicalGroup(dim, tag)
        if any(sum(map(len, gmsh.model.mesh.getElements(dim, e)[1])) for e in entities):
            groups[dim, gmsh.model.getPhysicalName(dim, tag) or str(tag)] = entities
    return groups


def _cells(name: str, dim: int, groups: list[Indices]) -> tuple[int, Indices, Indices]:
    """Element type, node tags in dolfinx's order of nodes, and entity of the cells."""
    blocks: dict[int, list[Any]] = {}
    owners = []
    for entity in np.unique(np.concatenate(groups)):
        types, tags, nodes = gmsh.model.mesh.getElements(dim, int(entity))
        for kind, kind_tags, kind_nodes in zip(types, tags, nodes, strict=True):
            _check_elements(name, int(kind), kind_tags)
            blocks.setdefault(int(kind), []).append(kind_nodes.reshape(len(kind_tags), -1))
            owners.append(np.full(len(kind_tags), entity))
    if len(blocks) > 1:
        kinds = ", ".join(_shape(kind) for kind in blocks)
        raise MeshError(f"{name}: mixes the cell types {kinds}: must be of one type")
    kind, parts = next(iter(blocks.items()))
    nodes = np.concatenate(parts).astype(np.int64)
    permutation = cell_permutation(
        to_type(str(ufl_mesh(kind, dim, np.float64).ufl_cell())), nodes.shape[1]
    )
    return kind, nodes[:, permutation], np.concatenate(owners)


def _shape(kind: int) -> str:
    return str(gmsh.model.mesh.getElementProperties(kind)[0])


def _check_elements(name: str, kind: int, tags: Any) -> None:
    shape = _shape(kind)
    order = gmsh.model.mesh.getElementProperties(kind)[2]
    if not shape.startswith(_SHAPES):
        raise MeshError(
            f"{name}: has cells of the type {shape}: must be intervals, triangles, quadrangles, "
            "tetrahedra or hexahedra (mesh again without prisms and pyramids)"
        )
    if order > 2:
        raise MeshError(f"{name}: has elements of order {order}: must be of order 1 or 2")
    bad = _degenerate(kind, tags)
    if bad.size:
        _, nodes, _, _ = gmsh.model.mesh.getElement(int(bad[0]))
        corner = ", ".join(f"{x:.6g}" for x in gmsh.model.mesh.getNode(int(nodes[0]))[0])
        raise MeshError(
            f"{name}: {bad.size} degenerate elements (flat or folded), the first is number "
            f"{int(bad[0])} at ({corner}): mesh again or heal the geometry"
        )


def _degenerate(kind: int, tags: Any) -> Any:
    """Tags of the elements without volume, or whose Jacobian changes sign."""
    if gmsh.model.mesh.getElementProperties(kind)[1] == 1:
        lengths = gmsh.model.mesh.getElementQualities(tags, "volume")
        return tags[np.abs(lengths) <= _FLAT * np.abs(lengths).max()]
    quality = gmsh.model.mesh.getElementQualities
    folded = np.sign(quality(tags, "minDetJac")) != np.sign(quality(tags, "maxDetJac"))
    return tags[folded | (np.abs(quality(tags, "minSICN")) < _FLAT)]


def _facet_nodes(cell_type: int, dim: int, entities: Any) -> Indices:
    """Node tags of all elements of a facet group, in dolfinx's order of nodes."""
    parts = []
    for entity in entities:
        types, tags, nodes = gmsh.model.mesh.getElements(dim, int(entity))
        parts += [n.reshape(len(t), -1) for _, t, n in zip(types, tags, nodes, strict=True)]
    if not parts:
        return np.empty((0, 1), dtype=np.int64)
    nodes = np.concatenate(parts).astype(np.int64)
    cell = to_type(str(ufl_mesh(cell_type, dim + 1, np.float64).ufl_cell()))
    return nodes[:, cell_permutation(cell_entity_type(cell, dim, 0), nodes.shape[1])]
