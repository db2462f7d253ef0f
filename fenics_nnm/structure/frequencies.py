"""Frequencies of a body besides those of its modes: at rest, and with Coriolis forces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_nnm.fem.gyroscopic import coriolis_frequencies
from fenics_nnm.fem.linear import LinearAnalysis, operators_of
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.system import FreeSystem
from fenics_nnm.structure.coriolis import Frequencies


def frequencies_of(analysis: LinearAnalysis) -> Frequencies:
    """Frequencies of a body besides those of its modes; to be called on all ranks."""
    solid, state = analysis.solid, analysis.solid.state
    if state is None:
        return Frequencies()
    modes, rotation, K = analysis.modes, state.loads.rotation, state.unloaded
    with DirectModalSolver(replace(solid, stiffness=K, system=FreeSystem(K, solid.mass))) as solver:
        unloaded = solver.modes(len(modes.omega)).frequencies
    if rotation is None or not rotation.speed:
        return Frequencies(unloaded)
    with DirectModalSolver(solid) as solver:
        operators = operators_of(solid, analysis.interface, solver)
        omega = coriolis_frequencies(solid, rotation, modes, operators)
    return Frequencies(unloaded, omega / (2 * np.pi))
