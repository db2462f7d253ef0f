"""From a gmsh model or file to a distributed mesh with named facets."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gmsh
import numpy as np
from dolfinx import mesh as dmesh
from dolfinx.cpp.mesh import cell_entity_type, to_type
from dolfinx.graph import adjacencylist
from mpi4py import MPI

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.compat import cell_permutation, distribute_entity_data, ufl_mesh
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.geometry import Geometry
from fenics_nnm.geometry.parameters import METRES

#: Element shapes of gmsh that can be used, by the first word of their name.
_SHAPES = ("Line", "Triangle", "Quadrilateral", "Tetrahedron", "Hexahedron")

#: An element whose signed inverse condition number is below this is taken as flat.
_FLAT = 1e-6


@dataclass(frozen=True, slots=True)
class TaggedMesh:
    """A distributed mesh in metres, and its named facets.

    Attributes:
        mesh: Mesh of one cell type, whose geometric and topological dimensions agree.
        facets: Local facet indices of each named group; the names are alike on all ranks.
    """

    mesh: dmesh.Mesh
    facets: dict[str, Indices]

    @property
    def dim(self) -> int:
        """Dimension of the body: 1, 2 or 3."""
        return int(self.mesh.topology.dim)

    def facets_of(self, names: tuple[str, ...], what: str) -> Indices:
        """Local facets of all the named groups together.

        Args:
            names: Names of groups.
            what: The study's key, for the message.

        Raises:
            MeshError: if a name is not in the mesh.
        """
        for name in names:
            if name not in self.facets:
                known = ", ".join(f'"{known}"' for known in sorted(self.facets)) or "none"
                raise MeshError(f'{what} = "{name}": the mesh has no such group; it has {known}')
        return np.unique(np.concatenate([self.facets[name] for name in names]))


@dataclass(frozen=True, slots=True)
class _RawMesh:
    """What rank 0 reads from gmsh; empty on the other ranks."""

    cell_type: int
    dim: int
    points: Array
    cells: Indices
    groups: Mapping[str, Indices]


def read_mesh(path: Path, length_unit: str, comm: MPI.Comm) -> TaggedMesh:
    """Read a .msh file with named physical groups.

    Args:
        path: File that gmsh can open as a mesh.
        length_unit: Unit of its coordinates, a key of `METRES`.
        comm: Communicator of the mesh.

    Raises:
        MeshError: if the file cannot be used; the message says why.
    """
    return _distributed(lambda: _open(path), str(path), METRES[length_unit], comm)


def generate_mesh(geometry: Geometry, comm: MPI.Comm) -> TaggedMesh:
    """Mesh a built-in geometry.

    Raises:
        GeometryError: if the geometry cannot be made.
        MeshError: if its mesh cannot be used.
    """
    name = f'mesh.model "{geometry.model}"'
    metres = METRES[geometry.length_unit]
    return _distributed(lambda: geometry.build(gmsh.model), name, metres, comm)


def _distributed(fill: Callable[[], None], name: str, metres: float, comm: MPI.Comm) -> TaggedMesh:
    raw = None

    def read() -> tuple[int, int, int, list[str]]:
        nonlocal raw
        with _gmsh_session(name):
            fill()
            raw = _extract(name)
        return raw.cell_type, raw.dim, raw.cells.shape[1], list(raw.groups)

    cell_type, dim, nodes, names = on_root(comm, read)
    if raw is None:
        raw = _RawMesh(cell_type, dim, np.empty((0, dim)), np.empty((0, nodes), dtype=np.int64), {})
    mesh = dmesh.create_mesh(
        comm, raw.cells, raw.points * metres, ufl_mesh(cell_type, dim, np.float64)
    )
    mesh.topology.create_connectivity(dim - 1, dim)
    mesh.topology.create_connectivity(dim, dim - 1)
    return TaggedMesh(mesh, {group: _local_facets(mesh, raw, group) for group in names})


def _local_facets(mesh: dmesh.Mesh, raw: _RawMesh, group: str) -> Indices:
    width = mesh.comm.bcast(raw.groups[group].shape[1] if mesh.comm.rank == 0 else 0, root=0)
    nodes = raw.groups.get(group, np.empty((0, width), dtype=np.int64))
    dim = raw.dim - 1
    entities, values = distribute_entity_data(
        mesh, dim, nodes, np.zeros(len(nodes), dtype=np.int32)
    )
    tags = dmesh.meshtags_from_entities(mesh, dim, adjacencylist(entities), values)
    return tags.indices


@contextmanager
def _gmsh_session(name: str) -> Iterator[None]:
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


def _open(path: Path) -> None:
    if not path.is_file():
        what = "is not a file" if path.exists() else "there is no such file"
        raise MeshError(f"mesh.file = {path}: {what}")
    try:
        gmsh.merge(str(path))
    except Exception as error:  # gmsh raises bare Exception
        raise MeshError(f"mesh.file = {path}: gmsh cannot read it: {error}") from error
    if not gmsh.model.mesh.getNodes()[0].size:
        raise MeshError(f"mesh.file = {path}: holds no mesh")


def _extract(name: str) -> _RawMesh:
    """Points, cells and named facets of the current gmsh model."""
    groups = _named_groups()
    dim = max((d for d, _ in groups), default=0)
    if dim == 0:
        raise MeshError(
            f"{name}: no physical groups with elements: name the body, the clamped and the "
            "contact facets (gmsh: Physical Volume, Physical Surface ...)"
        )
    cell_type, cells = _cells(name, dim, [tags for (d, _), tags in groups.items() if d == dim])
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
    return _RawMesh(cell_type, dim, np.ascontiguousarray(points[:, :dim]), row[cells], facets)


def _named_groups() -> dict[tuple[int, str], Indices]:
    """Entities of each physical group that has elements, by dimension and name."""
    groups = {}
    for dim, tag in gmsh.model.getPhysicalGroups():
        entities = gmsh.model.getEntitiesForPhysicalGroup(dim, tag)
        if any(sum(map(len, gmsh.model.mesh.getElements(dim, e)[1])) for e in entities):
            groups[dim, gmsh.model.getPhysicalName(dim, tag) or str(tag)] = entities
    return groups


def _cells(name: str, dim: int, groups: list[Indices]) -> tuple[int, Indices]:
    """Element type and node tags of the cells, in dolfinx's order of nodes."""
    blocks: dict[int, list[Any]] = {}
    for entity in np.unique(np.concatenate(groups)):
        types, tags, nodes = gmsh.model.mesh.getElements(dim, int(entity))
        for kind, kind_tags, kind_nodes in zip(types, tags, nodes, strict=True):
            _check_elements(name, int(kind), kind_tags)
            blocks.setdefault(int(kind), []).append(kind_nodes.reshape(len(kind_tags), -1))
    if len(blocks) > 1:
        kinds = ", ".join(_shape(kind) for kind in blocks)
        raise MeshError(f"{name}: mixes the cell types {kinds}: must be of one type")
    kind, parts = next(iter(blocks.items()))
    nodes = np.concatenate(parts).astype(np.int64)
    permutation = cell_permutation(
        to_type(str(ufl_mesh(kind, dim, np.float64).ufl_cell())), nodes.shape[1]
    )
    return kind, nodes[:, permutation]


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
