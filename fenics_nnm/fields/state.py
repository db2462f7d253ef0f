"""A file of the static state under steady loads."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fenics_nnm.arrays import Array, in_space
from fenics_nnm.fields.body import field_body
from fenics_nnm.fields.invariants import von_mises
from fenics_nnm.fields.motion import DISPLACEMENT
from fenics_nnm.fields.parts import compact_parts
from fenics_nnm.fields.stress_rows import VON_MISES
from fenics_nnm.results.stored_branch import read_stored_branch

WARMING = "temperature above that without stress (K)"

#: Nodes whose stresses are recovered at once.
_NODES_AT_ONCE = 8192


def write_state(path: Path, file: Path) -> None:
    """Write displacement, stress, von Mises stress and temperature of the static state of a branch.

    Nothing is written where there are no steady loads.

    Args:
        path: File to write.
        file: branch.h5 of a run.

    Raises:
        OSError: if it cannot be written.
        OutputError: if the branch cannot be read.
    """
    branch = read_stored_branch(file)
    if branch.state is None:
        return
    body = field_body(branch)
    stress = np.empty((len(body.mesh.nodes), 6))
    for part in compact_parts(body.mesh.nodes, _NODES_AT_ONCE):
        stress[part] = body.recovery(part).of_samples(body.steady)
    fields: dict[str, Array] = {
        DISPLACEMENT: in_space(body.on_grid(branch.state.displacement)),
        VON_MISES: von_mises(stress),
        "stress (Pa)": stress,
    }
    if branch.state.warming.size:
        fields[WARMING] = body.on_grid(branch.state.warming)
    body.grid.write(path, fields)
