"""Vectors of a study as those of a mesh."""

from __future__ import annotations

from fenics_nnm.errors import ModelError


def fitted(vector: tuple[float, ...], dim: int, name: str) -> tuple[float, ...]:
    """A vector with as many components as the mesh has dimensions."""
    if len(vector) < dim or any(vector[dim:]):
        raise ModelError(f"{name} = {list(vector)}: must have {dim} components as the mesh has")
    return vector[:dim]
