"""Static states that are kept for commands that need the same again.

A state is found by what the residual is without displacement under all loads, besides the stiffness
of the unloaded body. It counts only if residual and tangent stiffness at its displacement are, bit
for bit, those that were kept with it: so it is a state of these loads and of this body, whatever
they depend on.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from fenics_nnm.fem.cached_modes import digest_of, kept_by_all, key_of_all
from fenics_nnm.fem.loaded_residual import LoadedResidual
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.surroundings import surroundings
from fenics_nnm.files.cache import Cache, cache_of_user

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class StepsTaken:
    """What it took to find a static state.

    Attributes:
        solutions: Solutions of linear equations.
        load_steps: Steps in which the loads were applied.
    """

    solutions: int
    load_steps: int


@dataclass(frozen=True, slots=True)
class StateKeeper:
    """Keeps the state of a body under its loads; methods are to be called on all ranks.

    Attributes:
        comm: Communicator of the mesh.
        residual: Residual of the body.
        cache: Where states are kept; None if nowhere.
        key: Key of the state.
    """

    comm: MPI.Comm
    residual: LoadedResidual
    cache: Cache | None = None
    key: str = ""

    def restored(self) -> StepsTaken | None:
        """Move the residual to a kept state and assemble its tangent; None leaves it at u = 0."""
        found = self.cache and kept_by_all(self.comm, self.cache, self.key)
        if not found or self.cache is None:
            return None
        self.residual.apply(1.0)
        self.residual.move(found["displacement"])
        same = np.array_equal(self.residual.value(), found["residual"])
        same &= digest_of(self.residual.assemble()) == found["tangent"].tobytes()
        if not self.comm.allreduce(bool(same), MPI.LAND):
            self.residual.move(np.zeros_like(found["displacement"]))
            return None
        logger.info("the static state is taken from %s", self.cache.folder)
        return StepsTaken(int(found["solutions"]), int(found["load_steps"]))

    def keep(self, taken: StepsTaken) -> None:
        """Keep the state that the residual is at, with its tangent assembled."""
        if self.cache is None:
            return
        tangent = digest_of(self.residual.tangent)
        state = {
            "displacement": self.residual.owned.copy(),
            "residual": self.residual.value(),
            "tangent": np.frombuffer(tangent, dtype=np.uint8),
            "solutions": np.int64(taken.solutions),
            "load_steps": np.int64(taken.load_steps),
        }
        self.cache.write(self.key, state)


def keeper_of(solid: Solid, residual: LoadedResidual, proven: bool) -> StateKeeper:
    """What keeps the state of a body; to be called on all ranks.

    Args:
        solid: Assembled body, without loads.
        residual: Its residual, at u = 0.
        proven: Whether states are known to be stable. Others are kept apart.
    """
    comm, cache = solid.tagged.mesh.comm, cache_of_user()
    if cache is None:
        return StateKeeper(comm, residual)
    residual.apply(1.0)
    kind = "stable state" if proven else "state"
    parts = digest_of(solid.stiffness), solid.clamped.tobytes(), residual.value().tobytes()
    return StateKeeper(comm, residual, cache, key_of_all(comm, kind, surroundings(), *parts))
