"""Modes that are kept for commands that need the same again.

Modes depend on stiffness and mass and on nothing else. So the key is a digest of these matrices as
they were assembled, of all ranks: whatever in a study changes the structure changes it, and what
does not, such as a gap or an energy, does not.
"""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Mapping
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fenics_nnm.fem.modal_solver import ModalSolver
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.surroundings import surroundings
from fenics_nnm.files.cache import Cache, cache_of_user, key_of
from fenics_nnm.reduction.linear_modes import LinearModes

logger = logging.getLogger(__name__)


def kept_modes(solid: Solid, solver: ModalSolver, count: int) -> LinearModes:
    """The `count` lowest modes of a body, found and kept if they were not before; on all ranks.

    Modes of which it is not known whether one was missed are not kept: memory may allow to count
    them the next time. Nor are those of bodies with constraints, which bring a third matrix.

    Args:
        solid: Assembled body.
        solver: Finds its modes.
        count: Number of modes.

    Raises:
        ModelError, ConvergenceError: as `DirectModalSolver.modes`.
    """
    cache = cache_of_user()
    if cache is None or solid.system.keys:
        return solver.modes(count)
    comm = solid.tagged.mesh.comm
    key = _key(solid, type(solver).__name__, count)
    found = kept_by_all(comm, cache, key)
    if found is not None:
        logger.info("modes are taken from %s", cache.folder)
        return LinearModes(found["omega"], found["shapes"], float(found["checked_below"]))
    modes = solver.modes(count)
    if modes.checked_below:
        values = {"omega": modes.omega, "shapes": modes.shapes}
        cache.write(key, {**values, "checked_below": np.float64(modes.checked_below)})
    return modes


def kept_by_all(comm: MPI.Comm, cache: Cache, key: str) -> Mapping[str, Any] | None:
    """What is kept under the keys of all ranks; None on all of them where one has nothing."""
    found = cache.read(key)
    return found if comm.allreduce(found is not None, MPI.LAND) else None


def key_of_all(comm: MPI.Comm, *parts: bytes | str) -> str:
    """A key of this rank that depends on the parts of all ranks, and on their number."""
    every = comm.allgather(key_of(*parts))
    return key_of(f"rank {comm.rank}", *every)


def digest_of(matrix: PETSc.Mat) -> bytes:
    """Digest of the rows of a matrix that this rank has, with where they begin and end."""
    total = hashlib.sha256(repr((matrix.getSize(), matrix.getOwnershipRange())).encode())
    for values in matrix.getValuesCSR():
        total.update(f"{values.dtype.str} {values.shape}".encode())
        total.update(np.ascontiguousarray(values).data)
    return total.digest()


def _key(solid: Solid, solver: str, count: int) -> str:
    parts = digest_of(solid.stiffness), digest_of(solid.mass), solid.clamped.tobytes()
    of_all = (solver, str(count), surroundings(), *parts)
    return key_of_all(solid.tagged.mesh.comm, "modes", *of_all)
