"""Curved elements of the current gmsh model that are bad, made straight one by one.

gmsh's optimiser of such elements may crash, or not end, and it ends elsewhere each time.
"""

from __future__ import annotations

import gmsh
import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask

#: Smallest ratio of the least to the largest Jacobian of an element that stays curved.
_LEAST_RATIO = 0.1

#: Number of places that are named.
_NAMED = 3


def straighten(dim: int) -> None:
    """Move the middle nodes of bad elements to where they are in straight ones.

    Elements that share such a node may become bad by that: it goes on until none is bad but
    straight ones. A line that begins with "note: " is printed.
    """
    moved: set[int] = set()
    places: list[Array] = []
    while True:
        found = 0
        for kind, tags, nodes in _elements(dim):
            bad = _bad(tags)
            bad[bad] &= ~_all_known(nodes[bad], moved, kind)
            if bad.any():
                places += list(_move(kind, nodes[bad]))
                moved.update(nodes[bad].ravel().tolist())
                found += int(bad.sum())
        if not found:
            break
    if places:
        named = "; ".join(f"({', '.join(f'{x:.4g}' for x in at)})" for at in places[:_NAMED])
        more = " ..." if len(places) > _NAMED else ""
        _note(f"{len(places)} curved elements were folded and are made straight, at {named}{more}")


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


def _move(kind: int, nodes: Indices) -> Array:
    """Move the middle nodes of elements; the centres of these."""
    weights = _weights(kind)
    corners = weights.shape[1]
    wanted, place = np.unique(nodes, return_inverse=True)
    points = np.array([gmsh.model.mesh.getNode(int(tag))[0] for tag in wanted])
    of_corners = points[place.reshape(nodes.shape)[:, :corners]]
    straight = np.einsum("mc,ecd->emd", weights, of_corners)
    flat = nodes[:, corners:].ravel()
    _, first = np.unique(flat, return_index=True)
    for index in first:
        gmsh.model.mesh.setNode(int(flat[index]), straight.reshape(-1, 3)[index], [])
    return np.asarray(of_corners.mean(axis=1))


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
