"""Curved elements of the current gmsh model: optimised, or those that are bad made straight.

gmsh's optimiser may crash, or not end. Then, and where it leaves elements that are folded, those
of the mesh before it are straightened one by one.
"""

from __future__ import annotations

from pathlib import Path

import gmsh
import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.gmsh_mesh import degenerate
from fenics_nnm.fem.optimiser import optimise

#: Smallest ratio of the least to the largest Jacobian of an element that stays curved.
_LEAST_RATIO = 0.05

#: Largest change of volume and area of the body by straight elements.
_LARGEST_CHANGE = 1e-3

#: Rule that integrates the Jacobian of all elements of order 2.
_RULE = "Gauss6"

#: Number of places that are named.
_NAMED = 3

Coordinates = tuple[float, ...]


def mend(path: Path, dim: int, folder: Path, unit: str) -> None:
    """Optimise the curved elements, or straighten those that are bad.

    Where elements were straightened, a line that begins with "note: " is printed, which becomes a
    note of the mesh.

    Args:
        path: The file, for messages.
        dim: Dimension of the body.
        folder: Private folder.
        unit: Of the coordinates, for messages.

    Raises:
        MeshError: if the body would change by straight elements.
    """
    before = gmsh.model.mesh.getNodes()
    problem = optimise(folder)
    if not problem and _any_invalid(dim):
        problem = "left elements folded"
        _put_back(before[0], before[1].reshape(-1, 3))
    if problem:
        straighten(path, dim, problem, unit)


def _any_invalid(dim: int) -> bool:
    return any(degenerate(kind, tags).size for kind, tags, _ in _elements(dim))


def _put_back(tags: Indices, places: Array) -> None:
    for tag, place in zip(tags, places, strict=True):
        gmsh.model.mesh.setNode(int(tag), place, [])


def straighten(path: Path, dim: int, problem: str, unit: str) -> None:
    """Move the middle nodes of bad elements to where they are in straight ones.

    First those inside the body, then those on its surface too, and those on the edges of the
    geometry where nothing else helps. Elements that share a node may become bad by that: it goes on
    until none is bad but straight ones.

    Args:
        path: The file, for messages.
        dim: Dimension of the body.
        problem: Why gmsh's optimiser was of no use.
        unit: Of the coordinates, for messages.

    Raises:
        MeshError: if that changes volume or area of the body by more than 0.1 %.
    """
    sizes = [_size(dim), _size(dim - 1)]
    places = {at for lowest in (dim, dim - 1, 0) for at in _straightened(dim, lowest)}
    if not places:
        return
    change = max(abs(_size(d) / size - 1) for d, size in zip((dim, dim - 1), sizes, strict=True))
    if change > _LARGEST_CHANGE:
        raise MeshError(
            f"mesh file {path}: {len(places)} curved elements are folded, or nearly so, at "
            f"{_named(places, unit)}: gmsh's optimiser {problem}, and straight ones would change "
            f"the body by {change:.2g} of its size: must have a smaller element size (or "
            "curvature, refine), or elements of order 1",
            code=Code.CURVED_ELEMENTS,
        )
    _note(
        f"{len(places)} curved elements were folded, or nearly so, and are made straight (gmsh's "
        f"optimiser {problem}), at {_named(places, unit)}: smaller elements there (curvature, "
        "refine) follow the surface"
    )


def _named(places: set[Coordinates], unit: str) -> str:
    """The first of some places that differ in four digits."""
    texts = list(dict.fromkeys(f"({', '.join(f'{x:.4g}' for x in at)})" for at in sorted(places)))
    more = " ..." if len(texts) > _NAMED else ""
    return f"{'; '.join(texts[:_NAMED])} {unit}{more}"


def _size(dim: int) -> float:
    """Volume, area or length of all elements of a dimension."""
    return abs(sum(_integral(kind) for kind, _, _ in _elements(dim)))


def _integral(kind: int) -> float:
    """Integral of the Jacobian of all elements of a type; what is folded counts as negative."""
    local, weights = gmsh.model.mesh.getIntegrationPoints(kind, _RULE)
    jacobians, determinants, _ = gmsh.model.mesh.getJacobians(kind, local)
    if gmsh.model.getDimension() == 2 == gmsh.model.mesh.getElementProperties(kind)[1]:
        (xu, yu, _, xv, yv), _ = np.split(jacobians.reshape(-1, 9).T, [5])
        determinants = xu * yv - yu * xv  # gmsh's have no sign in a plane
    return float(determinants.reshape(-1, len(weights)).sum(axis=0) @ weights)


def _straightened(dim: int, lowest: int) -> set[Coordinates]:
    """Straighten bad elements by nodes on entities of a dimension or more; their centres."""
    moved: set[int] = set()
    places: set[Coordinates] = set()
    while True:
        before = len(moved)
        for kind, tags, nodes in _elements(dim):
            bad = nodes[_bad(tags)]
            bad = bad[~_all_known(bad, moved, kind)]
            if len(bad):
                nodes_moved, centres = _move(kind, bad, lowest)
                if nodes_moved - moved:
                    places.update((float(x), float(y), float(z)) for x, y, z in centres)
                moved |= nodes_moved
        if len(moved) == before:
            return places


def _elements(dim: int) -> list[tuple[int, Indices, Indices]]:
    """Type, tags and nodes of the elements of the highest dimension, by types."""
    types, tags, nodes = gmsh.model.mesh.getElements(dim)
    return [
        (int(kind), kind_tags, kind_nodes.reshape(len(kind_tags), -1))
        for kind, kind_tags, kind_nodes in zip(types, tags, nodes, strict=True)
    ]


def _bad(tags: Indices) -> Mask:
    """Elements whose Jacobian changes its sign, or nearly so."""
    ends = [gmsh.model.mesh.getElementQualities(tags, f"{end}DetJac") for end in ("min", "max")]
    sizes = np.abs(ends)
    turns = np.sign(ends[0]) != np.sign(ends[1])
    bad: Mask = turns | (sizes.min(axis=0) < _LEAST_RATIO * sizes.max(axis=0))
    return bad


def _all_known(nodes: Indices, moved: set[int], kind: int) -> Mask:
    """Elements that are straight already."""
    corners = gmsh.model.mesh.getElementProperties(kind)[5]
    return np.asarray(np.isin(nodes[:, corners:], list(moved)).all(axis=1))


def _move(kind: int, nodes: Indices, lowest: int) -> tuple[set[int], Array]:
    """Move the middle nodes of elements that lie on entities of a dimension or more.

    Returns:
        Tags of these nodes, and the centres of the elements.
    """
    weights = _weights(kind)
    corners = weights.shape[1]
    wanted, place = np.unique(nodes, return_inverse=True)
    known = [gmsh.model.mesh.getNode(int(tag)) for tag in wanted]
    points = np.array([coordinates for coordinates, _, _, _ in known])
    free = {int(tag) for tag, (_, _, dim, _) in zip(wanted, known, strict=True) if dim >= lowest}
    of_corners = points[place.reshape(nodes.shape)[:, :corners]]
    straight = np.einsum("mc,ecd->emd", weights, of_corners).reshape(-1, 3)
    middle = nodes[:, corners:].ravel()
    _, first = np.unique(middle, return_index=True)
    chosen = [index for index in first if int(middle[index]) in free]
    for index in chosen:
        gmsh.model.mesh.setNode(int(middle[index]), straight[index], [])
    return {int(middle[index]) for index in chosen}, of_corners.mean(axis=1)


def _weights(kind: int) -> Array:
    """Part of each corner in the place of each middle node of a straight element."""
    shape, dim, _, _, local, corners = gmsh.model.mesh.getElementProperties(kind)
    middle = np.zeros((len(local) // dim - corners, 3))
    middle[:, :dim] = np.reshape(local, (-1, dim))[corners:]
    linear = gmsh.model.mesh.getElementType(shape.split()[0], 1)
    _, values, _ = gmsh.model.mesh.getBasisFunctions(linear, middle.ravel(), "Lagrange")
    return np.asarray(values).reshape(len(middle), corners)


def _note(text: str) -> None:
    """Print a line that becomes a note of the mesh."""
    print(f"note: {text}", flush=True)  # noqa: T201
