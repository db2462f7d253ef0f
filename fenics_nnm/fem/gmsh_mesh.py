"""From the current gmsh model to points, cells and named groups."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import gmsh
import numpy as np
from dolfinx.cpp.mesh import cell_entity_type, to_type

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.compat import cell_permutation, ufl_mesh
from fenics_nnm.fem.raw_mesh import RawMesh
from fenics_nnm.fem.serendipity import completed

#: Element shapes of gmsh that can be used, by the first word of their name.
_SHAPES = ("Line", "Triangle", "Quadrilateral", "Tetrahedron", "Hexahedron")

#: An element whose signed inverse condition number is below this is taken as flat.
_FLAT = 1e-6

#: Bytes of a file that are looked at before gmsh reads it.
_HEAD = 1_000_000


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
        MeshError: if gmsh cannot read it or it holds no mesh.
    """
    assert_text(path)
    try:
        gmsh.merge(str(path))
    except Exception as error:  # gmsh raises bare Exception
        raise MeshError(
            f"mesh file {path}: gmsh cannot read it: {error}", code=Code.MESH_FILE
        ) from error
    if not gmsh.model.mesh.getNodes()[0].size:
        raise MeshError(f"mesh file {path}: holds no mesh", code=Code.MESH_FILE)


def assert_text(path: Path) -> None:
    """Refuse a file of other bytes than text, if gmsh would take it for its own language.

    A zero byte leaves gmsh's parser unusable: the process could not read another .geo file.

    Raises:
        MeshError: if there is one.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD)
    language = path.suffix.lower() == ".geo" or head[:1] != b"$"
    if language and path.suffix.lower() in (".geo", ".msh") and b"\0" in head:
        raise MeshError(
            f"mesh file {path}: gmsh cannot read it: is neither a mesh nor text",
            code=Code.MESH_FILE,
        )


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
    kind, tags, owner = _cells(name, dim, list(bodies.values()))
    points, row = _used_nodes(tags)
    if dim < 3 and np.abs(points[:, dim:]).max() > 1e-9 * np.ptp(points, axis=0).max():
        raise MeshError(
            f"{name}: the largest elements have dimension {dim}, but the mesh leaves "
            f"{'the x axis' if dim == 1 else 'the x-y plane'} (no shells or curved beams; "
            "the body needs a physical group too)"
        )
    whole = completed(kind, points, row[tags])
    cell = to_type(str(ufl_mesh(whole.cell_type, dim, np.float64).ufl_cell()))
    facets = {}
    for (d, group), entities in groups.items():
        if d == dim - 1:
            nodes = row[_facet_nodes(dim - 1, entities)]
            nodes = whole.facets(nodes[(nodes >= 0).all(axis=1)])
            shape = cell_entity_type(cell, dim - 1, 0)
            facets[group] = nodes[:, cell_permutation(shape, nodes.shape[1])]
    return RawMesh(
        whole.cell_type,
        dim,
        np.ascontiguousarray(whole.points[:, :dim]),
        whole.cells[:, cell_permutation(cell, whole.cells.shape[1])],
        {group: nodes for group, nodes in facets.items() if len(nodes)},
        {group: np.flatnonzero(np.isin(owner, entities)) for group, entities in bodies.items()},
    )


def _used_nodes(tags: Indices) -> tuple[Array, Indices]:
    """Coordinates of the nodes of cells, and the row of each tag, -1 for nodes of no cell."""
    number, coordinates, _ = gmsh.model.mesh.getNodes()
    used = np.isin(number, tags)
    row = np.full(int(number.max()) + 1, -1, dtype=np.int64)
    row[number[used].astype(np.int64)] = np.arange(used.sum())
    return coordinates.reshape(-1, 3)[used], row


def _named_groups() -> dict[tuple[int, str], Indices]:
    """Entities of each physical group that has elements, by dimension and name."""
    groups: dict[tuple[int, str], Indices] = {}
    for dim, tag in gmsh.model.getPhysicalGroups():
        entities = gmsh.model.getEntitiesForPhysicalGroup(dim, tag)
        if any(sum(map(len, gmsh.model.mesh.getElements(dim, e)[1])) for e in entities):
            key = dim, gmsh.model.getPhysicalName(dim, tag) or str(tag)
            groups[key] = np.union1d(groups.get(key, entities), entities)
    return groups


def _cells(name: str, dim: int, groups: list[Indices]) -> tuple[int, Indices, Indices]:
    """Element type, node tags in gmsh's order, and entity of the cells."""
    blocks: dict[int, list[Any]] = {}
    owners = []
    for entity in np.unique(np.concatenate(groups)):
        types, tags, nodes = gmsh.model.mesh.getElements(dim, int(entity))
        for kind, kind_tags, kind_nodes in zip(types, tags, nodes, strict=True):
            _check_elements(name, int(kind), kind_tags)
            blocks.setdefault(int(kind), []).append(kind_nodes.reshape(len(kind_tags), -1))
            owners.append(np.full(len(kind_tags), entity))
    check_one_type(name, {_shape(kind): sum(map(len, parts)) for kind, parts in blocks.items()})
    kind, parts = next(iter(blocks.items()))
    return kind, np.concatenate(parts).astype(np.int64), np.concatenate(owners)


def check_one_type(name: str, counts: Mapping[str, int]) -> None:
    """Refuse cells of several types.

    Args:
        name: What is read, for messages.
        counts: Number of cells of each type.

    Raises:
        MeshError: if there is more than one type.
    """
    if len(counts) > 1:
        kinds = " and ".join(f"{count} {kind}" for kind, count in counts.items())
        raise MeshError(f"{name}: mixes the cell types {kinds}: must be of one type")


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


def _facet_nodes(dim: int, entities: Any) -> Indices:
    """Node tags of all elements of a facet group, in gmsh's order of nodes."""
    parts = []
    for entity in entities:
        types, tags, nodes = gmsh.model.mesh.getElements(dim, int(entity))
        parts += [n.reshape(len(t), -1) for _, t, n in zip(types, tags, nodes, strict=True)]
    return np.concatenate(parts).astype(np.int64)
