"""Solutions by substructures on the ranks that run this; rank 0 writes them to a file."""

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from conftest import BEAM, changed
from mpi4py import MPI

from fenics_nnm.fem import dissection, substructures
from fenics_nnm.fem.block import product
from fenics_nnm.fem.cholesky import Cholesky
from fenics_nnm.fem.loads import Loads, Rotation
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.static_state import loaded
from fenics_nnm.fem.substructures import Substructures
from fenics_nnm.stages import Stages
from fenics_nnm.structure.mesh_structure import MeshStructure
from fenics_nnm.study import study_from

dissection._WORTHWHILE = 1
comm = MPI.COMM_WORLD
mesh = {"length": 0.4, "width": 0.1, "height": 0.1, "elements": [8, 3, 2]}
study = study_from(changed(BEAM, {"mesh": mesh}), Path("study.toml"))
solid = MeshStructure(study).assembled(comm, Stages()).solid


def state_under_speed() -> tuple[float, int]:
    """Displacements at some speed, and how many solvers were made by substructures."""
    made: list[int] = []
    init = Substructures.__init__

    def counted(self: Substructures, *given: Any) -> None:
        made.append(1)
        init(self, *given)

    Substructures.__init__ = counted  # type: ignore[method-assign]
    rotation = Rotation((0.0, 1.0, 0.0), (-0.1, 0.0, 0.0), 300.0)
    state = loaded(solid, Loads(rotation)).state
    Substructures.__init__ = init  # type: ignore[method-assign]
    assert state is not None
    return comm.allreduce(float((state.displacement.x.array[: solid.owned] ** 2).sum())), len(made)


found: dict[str, Any] = {}
inverse = Substructures.of(solid, None)
assert inverse is not None
place = solid.space.tabulate_dof_coordinates()[: solid.owned // 3]
forces = np.asfortranarray(np.stack([np.sin((k + 1) * place).ravel() for k in range(70)], axis=1))
moved = inverse.solve(forces)
left = product(solid.stiffness, moved) - forces
found["shared"] = inverse._shared
found["residual"] = max(comm.allgather(float(np.abs(left).max())))
found["work"] = comm.allreduce(float((moved * forces).sum()))
inverse.release()

solver = DirectModalSolver(solid)
found["kind"] = type(solver._inverse).__name__
found["omega"] = solver.modes(12).omega.tolist()
solver.release()
found["state"], found["solvers of the state"] = state_under_speed()

shifted = solid.stiffness.copy()
shifted.axpy(-4 * found["omega"][3] ** 2, solid.mass)
found["indefinite"] = Substructures.of(replace(solid, stiffness=shifted), None) is None
found["little memory"] = Substructures.of(solid, 1e3) is None
substructures.cholmod_fits = lambda rows, memory: True
found["little memory beside factors"] = Substructures.of(solid, 1e5) is None
cholesky = substructures.Cholesky


def without_memory(*given: Any) -> Cholesky:
    """Factors on all ranks but the first."""
    if comm.rank == 0:
        raise MemoryError
    return cholesky(*given)


substructures.Cholesky = without_memory  # type: ignore[assignment, misc]
found["no memory on one rank"] = Substructures.of(solid, None) is None
substructures.Cholesky = cholesky  # type: ignore[misc]
substructures._MOST_SHARED = 10
found["large interface"] = Substructures.of(solid, None) is None
substructures._MOST_SHARED = 6000
substructures.kernel = lambda comm: None
found["no compiler"] = Substructures.of(solid, None) is None
solver = DirectModalSolver(solid)
found["kind without"] = type(solver._inverse).__name__
found["omega without"] = solver.modes(12).omega.tolist()
solver.release()
found["state without"], _ = state_under_speed()
if comm.rank == 0:
    Path(sys.argv[1]).write_text(json.dumps(found))
