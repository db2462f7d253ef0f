"""From the clamps of a study to facets that are held in all directions, and other clamps."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Indices
from fenics_nnm.fem.clamp import Clamp
from fenics_nnm.fem.mesh import TaggedMesh
from fenics_nnm.study import MeshStudy


def clamped_facets(study: MeshStudy, tagged: TaggedMesh) -> Indices:
    """Local facets that are held in all directions.

    Raises:
        MeshError: if a group is unknown or empty.
    """
    found: list[Indices] = [np.empty(0, dtype=np.int32)]
    for number, clamp in enumerate(study.clamp, start=1):
        if clamp.facets and not clamp.nodes and not clamp.directions:
            found.append(tagged.facets_of(clamp.facets, f"{_key(study, number)}.facets"))
    return np.unique(np.concatenate(found)).astype(np.int32)


def other_clamps(study: MeshStudy, dim: int) -> list[Clamp]:
    """Clamps of nodes, or in some directions alone."""
    found = []
    for number, clamp in enumerate(study.clamp, start=1):
        if clamp.nodes or clamp.directions:
            axes = tuple(sorted("xyz".index(name) for name in clamp.directions or "xyz"[:dim]))
            key = _key(study, number)
            turns = bool(clamp.directions)
            found.append(Clamp(key, clamp.facets or (), clamp.nodes or (), axes, turns))
    return found


def _key(study: MeshStudy, number: int) -> str:
    return "clamp" if len(study.clamp) == 1 else f"clamp[{number}]"
