"""What files of results keep of a body besides its shapes: contact points, mesh as it was read."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_nnm.fem.blocks import KEPT_MESH, Data
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.solid import Solid


def with_mesh(basis: Data, solid: Solid, interface: ContactInterface) -> Data:
    """Mesh and shapes of a body, with its contact points and the mesh as it was read."""
    contact = {
        "contact/points": interface.points,
        "contact/directions": interface.directions,
        "contact/areas": interface.areas,
        "contact/patches": interface.patch,
        "contact/patch_names": np.array([name.encode() for name in interface.names]),
    }
    kept = solid.tagged.as_read.arrays
    packed = {f"{KEPT_MESH}/{name}": values for name, values in kept.items()}
    return replace(basis, arrays={**contact, **basis.arrays}, packed=packed)
