"""What is seen of a body: its faces, its outline and where it is held."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices, in_space
from fenics_nnm.output.pictures.scene import PLANE, View
from fenics_nnm.output.surface import face_normals, feature_edges, surface_faces
from fenics_nnm.results.stored_branch import StoredBranch

#: VTK's line cells of order one, two and any.
_LINES = (3, 21, 68)

#: Height of the strip that a rod is drawn as, as a part of its length.
_STRIP = 0.06

#: Directions that a body in space is looked at from, in degrees.
_AZIMUTHS = range(-165, 180, 15)
_ELEVATIONS = (25, -25)

#: Contact directions are seen well enough at this cosine; and what a view from below costs.
_FACING, _FROM_BELOW = 0.35, 0.2

#: Below this length of their mean, contact directions have none in common.
_COMMON = 0.5


@dataclass(frozen=True, slots=True)
class Skin:
    """Faces of a body, as drawn.

    Attributes:
        places: Places of the drawn nodes at rest in m, shape (p, 3).
        faces: Drawn nodes of each face, shape (f, 3 or 4).
        edges: Drawn nodes of the lines of the outline, shape (e, 2).
        source: Node of the body that each drawn node moves with, shape (p,).
        dim: Dimension of the body.
    """

    places: Array
    faces: Indices
    edges: Indices
    source: Indices
    dim: int

    def moved(self, displacement: Array, factor: float) -> Array:
        """Places in m under an enlarged displacement of the body's nodes (n, dim), (p, 3)."""
        return self.places + factor * in_space(displacement)[self.source]


def skin_of(body: StoredBranch) -> Skin:
    """The skin of a body; a rod becomes a strip.

    Raises:
        OutputError: if its cells have no faces.
    """
    dim = body.shapes.shape[2]
    if body.cell_type in _LINES:
        return skin_around(body.nodes, body.cells[:, :2], dim)
    return skin_around(body.nodes, surface_faces(body.cells, body.cell_type), dim)


def skin_around(nodes: Array, faces: Indices, dim: int) -> Skin:
    """The skin of a body of nodes (n, 3) with outer faces (f, 3 or 4), or lines (f, 2)."""
    if faces.shape[1] == 2:
        return _strip(nodes, faces)
    source, drawn = np.unique(faces, return_inverse=True)
    faces, places = drawn.reshape(faces.shape), nodes[source]
    return Skin(places, faces, feature_edges(places, faces), source, dim)


def _strip(nodes: Array, cells: Indices) -> Skin:
    """Quadrangles about the lines between nodes of shape (n, 3)."""
    half = _STRIP / 2 * np.ptp(nodes[:, 0]) * np.array([0.0, 1.0, 0.0])
    count, (first, last) = len(nodes), (np.argmin(nodes[:, 0]), np.argmax(nodes[:, 0]))
    faces = np.hstack([cells, cells[:, ::-1] + count])
    edges = np.vstack([cells, cells + count, [[first, first + count], [last, last + count]]])
    source = np.tile(np.arange(count), 2)
    return Skin(np.vstack([nodes - half, nodes + half]), faces, edges, source, 1)


def held(body: StoredBranch) -> Array:
    """Whether each node of a body stays where it is in all modes, shape (n,)."""
    return np.asarray(~body.shapes.any(axis=(0, 2)))


def best_view(skin: Skin, directions: Array, displacement: Array | None = None) -> View:
    """The view that shows the contact surface, the motion, and as much of the body as it can.

    Args:
        skin: Skin of the body.
        directions: Unit vectors at the contact points towards the obstacle, shape (n_c, dim).
        displacement: A displacement of the drawn nodes, shape (p, dim), if there is one.
    """
    if skin.dim < 3:
        return PLANE
    mean = directions.sum(axis=0) / max(1, len(directions))
    up = "xyz"[int(np.argmax(np.abs(mean)))] if np.abs(mean).max() > _COMMON else "z"
    corners = skin.places[skin.faces]
    normals = face_normals(corners)
    areas = _areas(corners)
    views = [View(e, a, up) for e in _ELEVATIONS for a in _AZIMUTHS]
    towards = np.array([view.frame[2] for view in views])
    shown = np.maximum(towards @ normals.T, 0) @ areas
    below = np.array([view.elevation < 0 for view in views])
    score = shown / shown.max() - _FROM_BELOW * below
    if displacement is not None and displacement.any():
        along = np.sum((towards @ displacement.T) ** 2, axis=1)
        score += 1 - along / float(np.sum(displacement**2))
    if len(directions):
        score += np.clip(towards @ directions.T, -_FACING, _FACING).mean(axis=1) / _FACING
    return views[int(np.argmax(np.round(score, 9)))]


def _areas(corners: Array) -> Array:
    """Areas of triangles or quadrangles, (f, 3 or 4, 3), shape (f,)."""
    diagonals = corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1]
    return np.asarray(np.linalg.norm(np.cross(*diagonals), axis=1) / 2)
