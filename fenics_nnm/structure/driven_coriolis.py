"""Coriolis forces of a driven body."""

from __future__ import annotations

from functools import partial

from fenics_nnm.fem.gyroscopic import coriolis_forces
from fenics_nnm.fem.solid import Solid
from fenics_nnm.reduction.driven import DrivenPlaces
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.study import MeshStudy

#: Static displacements under the Coriolis forces of so many of the lowest modes are added.
_LOWEST = 6


def turning(
    study: MeshStudy, solid: Solid, places: DrivenPlaces, modes: LinearModes
) -> DrivenPlaces:
    """Places of a driven body with its Coriolis forces, if its study asks for them."""
    if not study.coriolis or solid.state is None or solid.state.loads.rotation is None:
        return places
    forces = partial(coriolis_forces, solid, solid.state.loads.rotation)
    return places.turning(forces, modes.shapes[:, :_LOWEST])
