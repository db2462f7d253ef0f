"""Steady loads of a body and the state that they make, in words."""

from __future__ import annotations

import math

import numpy as np
from mpi4py import MPI

from fenics_nnm.fem.loads import Loads
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.state_stress import largest_von_mises
from fenics_nnm.materials.elasticity import listed


def load_lines(solid: Solid) -> list[str]:
    """One line a load, and what they do together; none where nothing loads the body."""
    if solid.state is None:
        return []
    state, comm = solid.state, solid.tagged.mesh.comm
    moved = state.owned(solid.owned).reshape(-1, solid.tagged.dim)
    largest = comm.allreduce(np.linalg.norm(moved, axis=1).max(initial=0.0), op=MPI.MAX)
    steps = f"{state.steps} steps"
    if state.load_steps > 1:
        steps += f", loads in {state.load_steps} parts"
    lines = [
        *_of(state.loads),
        f"static state     largest displacement {largest:.4g} m, largest von Mises stress "
        f"{largest_von_mises(solid) / 1e6:.4g} MPa; {steps}",
    ]
    if state.asymmetry:
        lines.append(
            f"                 follower pressures: {state.asymmetry:.1e} of their stiffness is not "
            "symmetric and is left out"
        )
    return lines


def _of(loads: Loads) -> list[str]:
    lines = []
    if loads.rotation is not None and loads.speed:
        turns = loads.speed * 30 / math.pi
        lines.append(
            f"rotation         {loads.speed:.6g} rad/s ({turns:.6g} rpm) about "
            f"({listed(loads.rotation.unit)}) through ({listed(loads.rotation.origin)}) m"
        )
    if loads.warming.any:
        lines.append(f"temperature      {loads.warming.words}")
    for each in loads.pressures:
        kind = "follows the surface" if each.follower else "keeps its direction"
        facets = ", ".join(each.facets)
        lines.append(f"{each.key:<17}{each.value:.6g} Pa on {facets}, {kind}")
    for force in loads.forces:
        place = f"spread over {', '.join(force.facets)}"
        if force.point:
            place = f"at the vertex nearest to ({listed(force.point)}) m"
        lines.append(f"{force.key:<17}({listed(force.values)}) N {place}")
    return lines
