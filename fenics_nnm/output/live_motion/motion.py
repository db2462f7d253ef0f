"""The motion that a page plays: few shapes of the surface, rounded, and their courses in time."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_nnm.arrays import Array, Indices, Mask, in_space
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.output.live_motion.coarser import coarser
from fenics_nnm.output.live_motion.waves import Waves, waves_of
from fenics_nnm.output.pictures.body import factor_for
from fenics_nnm.output.pictures.obstacle import Sheet, obstacle_sheets
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.scene import size_of
from fenics_nnm.output.pictures.skin import skin_of
from fenics_nnm.output.surface import feature_edges
from fenics_nnm.results.stored_branch import StoredBranch

#: Instants of a period at which the motion and contact are taken.
INSTANTS = 120

#: Most bytes of the motion of the surface: with more nodes than have room it is drawn coarser.
MOST_BYTES = 3_000_000

#: Bytes of a coordinate of a place, and of one of a shape; both are written by 4 letters for 3.
_PLACE, _SHAPE, _WRITTEN = 4, 2, 4 / 3

#: Contact points are raised by this part of the body's size.
_RAISED = 0.004

#: Largest whole number of a rounded shape.
_LARGEST = 32_767


@dataclass(frozen=True, slots=True)
class LiveMotion:
    """A motion of a surface over a period.

    Attributes:
        places: Places at rest in m: nodes of the surface, then contact points, shape (p + n_c, 3).
        faces: Nodes of the faces, shape (f, 3 or 4).
        edges: Nodes of the lines of the outline, shape (e, 2).
        waves: Their displacements.
        pressed: Whether each contact point is pressed at each instant, shape (INSTANTS, n_c).
        sheets: The obstacle.
        factor: How many times displacements are enlarged at first.
        coarser: Whether it has fewer nodes than the surface of the mesh.
    """

    places: Array
    faces: Indices
    edges: Indices
    waves: Waves
    pressed: Mask
    sheets: Sequence[Sheet]
    factor: float
    coarser: bool

    @property
    def surface_nodes(self) -> int:
        """Number of nodes of the surface: contact points come after them."""
        return len(self.places) - self.pressed.shape[1]

    @property
    def largest(self) -> float:
        """Largest displacement of a node over the period in m."""
        moved = self.waves.at(_phase())[:, : self.surface_nodes]
        return float(np.linalg.norm(moved, axis=2).max())


def live_motion(results: Results, body: StoredBranch, point: BranchPoint) -> LiveMotion:
    """The motion of a point of a branch on its mesh.

    Raises:
        OutputError: if the cells have no faces.
    """
    skin = skin_of(body)
    phase = _phase() + results.middle(point) - np.pi
    moved = body.displacement(point, phase, skin.source)
    factor = factor_for(skin, list(moved))
    touching = body.contact_nodes
    at_contact = body.displacement(point, phase, touching)
    both = np.concatenate([moved, at_contact], axis=1)
    waves = waves_of(np.pad(both, ((0, 0), (0, 0), (0, 3 - both.shape[2]))))
    kept, faces = coarser(skin.places, skin.faces, _most_nodes(len(waves.shapes)))
    few = len(kept) < len(skin.places)
    places = skin.places[kept]
    own = np.append(kept, len(skin.places) + np.arange(len(touching)))
    return LiveMotion(
        np.vstack([places, _raised(body)]),
        faces,
        feature_edges(places, faces) if few else skin.edges,
        Waves(waves.shapes[:, own], waves.cos, waves.sin),
        results.forces(point, phase) > 0,
        obstacle_sheets(results, body),
        factor,
        few,
    )


def _raised(body: StoredBranch) -> Array:
    """The contact points, raised a little out of the surface so that they are seen."""
    raised = _RAISED * size_of(body.nodes) * in_space(body.contact_directions)
    return np.asarray(body.contact_points + raised)


def _phase() -> Array:
    return 2 * np.pi * np.arange(INSTANTS) / INSTANTS


def _most_nodes(shapes: int) -> int:
    """Most nodes whose motion in so many shapes has room."""
    return int(MOST_BYTES / _WRITTEN / 3 / (_PLACE + _SHAPE * shapes))


def written(motion: LiveMotion) -> dict[str, Any]:
    """What the script reads: plain numbers and rounded arrays, in letters."""
    shapes = motion.waves.shapes
    scale = np.abs(shapes).max(axis=(1, 2)) / _LARGEST
    scale[scale == 0] = 1.0
    rounded = np.round(shapes / scale[:, None, None]).astype("<i2")
    return {
        "places": _floats(motion.places),
        "shapes": _letters(rounded),
        "scale": scale.tolist(),
        "cos": _short(motion.waves.cos),
        "sin": _short(motion.waves.sin),
        "surface": motion.surface_nodes,
        "instants": INSTANTS,
        "pressed": _letters(np.packbits(motion.pressed, axis=1)),
        "largest": motion.largest,
        "factor": motion.factor,
        "sheets": [
            {
                "places": _letters(each.places.astype("<f4")),
                "gaps": _letters(each.gaps.astype("<f4")),
            }
            for each in motion.sheets
        ],
    }


def _floats(array: Array) -> str:
    return _letters(array.astype("<f4"))


def _letters(array: NDArray[Any]) -> str:
    return b64encode(np.ascontiguousarray(array).tobytes()).decode()


def _short(coefficients: Array) -> list[list[float]]:
    """Coefficients of six digits."""
    return [[float(f"{value:.6g}") for value in row] for row in coefficients]
