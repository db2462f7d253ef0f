"""From the current gmsh model to points, cells and named groups."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import gmsh
import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.raw_mesh import RawMesh
from fenics_nnm.fem.serendipity import completed

#: Element shapes of gmsh that can be used, by the first word of their name.
_SHAPES = ("Line", "Triangle", "Quadrilateral", "Tetrahedron", "Hexahedron")

#: An element whose signed inverse condition number is below this is taken as flat.
_FLAT = 1e-6

#: Options without which gmsh's meshes could differ from time to time.
_SAME_EACH_TIME = {
    "General.NumThreads": 1,
    "Mesh.MaxNumThreads1D": 1,
    "Mesh.MaxNumThreads2D": 1,
    "Mesh.MaxNumThreads3D": 1,
    "Mesh.RandomSeed": 1,
}


@contextmanager
def gmsh_session(name: str, *, talks: bool = False) -> Iterator[None]:
    """An empty gmsh model for a while, of a gmsh that gives the same mesh each time.

    Args:
        name: Name of the model.
        talks: Whether gmsh prints its steps.
    """
    started = not gmsh.isInitialized()
    if started:
        gmsh.initialize(["-noenv"], readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 1 if talks else 0)
    for option, value in _SAME_EACH_TIME.items():
        gmsh.option.setNumber(option, value)
    gmsh.model.add(name)
    try:
        yield
    finally:
        gmsh.model.remove()
        if started:
            gmsh.finalize()


def open_mesh(path: Path, given: Path, fault: Callable[[], str]) -> None:
    """Read a file with a mesh into the current gmsh model.

    Args:
        path: The file, for messages.
        given: Under which path gmsh gets it.
        fault: What is wrong with it as far as can be seen without gmsh; empty if nothing is.

    Raises:
        MeshError: if gmsh cannot read it or it holds no mesh.
    """
    try:
        gmsh.merge(str(given))
    except Exception as error:  # gmsh raises bare Exception
        reason = fault() or str(error).replace(str(given), str(path))
        raise MeshError(
            f"mesh file {path}: gmsh cannot read it: {reason}", code=Code.MESH_FILE
        ) from error
    if not gmsh.model.mesh.getNodes()[0].size:
        raise MeshError(f"mesh file {path}: holds no mesh", code=Code.MESH_FILE)


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
    first, place = _each_once(name, tags, owner, list(bodies.values()))
    tags = tags[first]
    points, row = _used_nodes(name, tags)
    if dim < 3 and np.abs(points[:, dim:]).max() > 1e-9 * np.ptp(points, axis=0).max():
        raise MeshError(
            f"{name}: the largest elements have dimension {dim}, but the mesh leaves "
            f"{'the x axis' if dim == 1 else 'the x-y plane'} (no shells or curved beams; "
            "the body needs a physical group too)"
        )
    whole = completed(kind, points, row[tags])
    facets = {}
    for (d, group), entities in groups.items():
        if d == dim - 1:
            nodes = row[_facet_nodes(dim - 1, entities)]
            facets[group] = whole.facets(np.unique(nodes[(nodes >= 0).all(axis=1)], axis=0))
    return RawMesh(
        whole.cell_type,
        dim,
        np.ascontiguousarray(whole.points[:, :dim]),
        whole.cells,
        {group: nodes for group, nodes in facets.items() if len(nodes)},
        {group: np.unique(place[np.isin(owner, entities)]) for group, entities in bodies.items()},
    )


def _each_once(
    name: str, tags: Indices, owner: Indices, groups: list[Indices]
) -> tuple[Indices, Indices]:
    """Row of each cell the first time, and for all rows which of these cells they are.

    Format 2.2 lists a cell once for each of its groups; other cells that stand twice are refused.
    """
    keys = np.sort(tags, axis=1)
    _, first, place, count = np.unique(
        keys, axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    first, place, count = first[order], rank[place.ravel()], count[order]
    once = np.unique(np.column_stack([place, owner]), axis=0)
    groups_of = sum(np.isin(once[:, 1], entities).astype(np.int64) for entities in groups)
    allowed = np.bincount(once[:, 0], weights=groups_of, minlength=len(first))
    if (count > allowed).any():
        at = first[np.argmax(count > allowed)]
        corner = ", ".join(f"{x:.6g}" for x in gmsh.model.mesh.getNode(int(tags[at, 0]))[0])
        raise MeshError(
            f"{name}: {int((count > allowed).sum())} elements stand there more than once, one at "
            f"({corner}): mesh again, or remove the copies"
        )
    return first, place


def _used_nodes(name: str, tags: Indices) -> tuple[Array, Indices]:
    """Coordinates of the nodes of cells, and the row of each tag, -1 for nodes of no cell."""
    number, coordinates, _ = gmsh.model.mesh.getNodes()
    missing = np.setdiff1d(tags, number)
    if missing.size:
        raise MeshError(f"{name}: an element has the node {missing[0]}, which is not there")
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
    bad = degenerate(kind, tags)
    if bad.size:
        _, nodes, _, _ = gmsh.model.mesh.getElement(int(bad[0]))
        corner = ", ".join(f"{x:.6g}" for x in gmsh.model.mesh.getNode(int(nodes[0]))[0])
        raise MeshError(
            f"{name}: {bad.size} degenerate elements (flat or folded), the first is number "
            f"{int(bad[0])} at ({corner}): mesh again or heal the geometry"
        )


def degenerate(kind: int, tags: Any) -> Any:
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
