"""Curved elements of the current gmsh model that are bad, made straight one by one.

gmsh's optimiser of such elements may crash, or not end, and it ends elsewhere each time.
"""

from __future__ import annotations

import gmsh
import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask

#: Smallest ratio of the least to the largest Jacobian of an element that stays curved.
_LEAST_RATIO = 0.05

#: Number of places that are named.
_NAMED = 3


def straighten(dim: int) -> None:
    """Move the middle nodes of bad elements to where they are in straight ones.

    First those inside the body, then those on its surface too, and those on the edges of the
    geometry where nothing else helps. Elements that share a node may become bad by that: it goes on
    until none is bad but straight ones. A line that begins with "note: " is printed.
    """
    places = {at for lowest in (dim, dim - 1, 0) for at in _straightened(dim, lowest)}
    if not places:
        return
    first = sorted(places)[:_NAMED]
    named = "; ".join(f"({', '.join(f'{x:.4g}' for x in at)})" for at in first)
    more = " ..." if len(places) > _NAMED else ""
    _note(
        f"{len(places)} curved elements were folded, or nearly so, and are made straight, at "
        f"{named}{more}: smaller elements there (mesh.curvature, mesh.refine) follow the surface"
    )


def _straightened(dim: int, lowest: int) -> set[tuple[float, ...]]:
    """Straighten bad elements by nodes on entities of a dimension or more; their centres."""
    moved: set[int] = set()
    places: set[tuple[float, ...]] = set()
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
    """Print a line that becomes a warning of the run."""
    print(f"note: {text}", flush=True)  # noqa: T201
