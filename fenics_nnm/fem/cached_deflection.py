"""What makes second-order kinematics, kept for commands that need the same again.

Second and third derivatives of the internal force along masters depend on the body and its static
state: on the mesh, the stiffness without and with loads and the displacement between them, and the
shapes of the masters. Static displacements depend on the stiffness and the forces besides, and on
the kind of solver. A key is a digest of all of these, of all ranks.
"""

from __future__ import annotations

import logging
from functools import cached_property

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fem.cached_modes import digest_of, kept_by_all, key_of_all
from fenics_nnm.fem.compat import cell_nodes
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.surroundings import surroundings
from fenics_nnm.files.cache import cache_of_user
from fenics_nnm.reduction.operators import Product

logger = logging.getLogger(__name__)


class DeflectionKeeper:
    """Keeps functions of shapes of a body; its method is to be called on all ranks."""

    def __init__(self, solid: Solid) -> None:
        """Nothing is kept of bodies with constraints, which bring a third matrix.

        Args:
            solid: Assembled body, about its static state or unloaded.
        """
        self._solid = solid
        self._cache = None if solid.system.keys else cache_of_user()

    def kept(self, name: str, function: Product, columns: Array) -> Array:
        """The value of a function, made and kept if it was not before.

        Args:
            name: What distinguishes it from other functions of the same body.
            function: The function.
            columns: What it is of, shape (n_owned, k).
        """
        if self._cache is None:
            return function(columns)
        comm = self._solid.tagged.mesh.comm
        shape, values = repr(columns.shape), np.ascontiguousarray(columns).tobytes()
        key = key_of_all(comm, "deflection", name, *self._body, shape, values)
        found = kept_by_all(comm, self._cache, key)
        if found is not None:
            logger.info("%s are taken from %s", name, self._cache.folder)
            return np.asarray(found["value"])
        value = function(columns)
        self._cache.write(key, {"value": value})
        return value

    @cached_property
    def _body(self) -> tuple[bytes | str, ...]:
        """What the body is, with its static state."""
        solid, mesh = self._solid, self._solid.tagged.mesh
        of_state: tuple[bytes, ...] = ()
        if solid.state is not None:
            moved = solid.state.displacement.x.array.tobytes()
            of_state = digest_of(solid.state.unloaded), moved
        return (
            surroundings(),
            digest_of(solid.stiffness),
            digest_of(solid.mass),
            solid.clamped.tobytes(),
            mesh.geometry.x.tobytes(),
            cell_nodes(mesh).tobytes(),
            *of_state,
        )
