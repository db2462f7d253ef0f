"""Frequencies of a structure besides those of its modes: at rest, and with Coriolis forces."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fem.gyroscopic import gyroscopic_matrix
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.system import FreeSystem
from fenics_nnm.reduction.gyroscopic import gyroscopic_frequencies


@dataclass(frozen=True, slots=True)
class Frequencies:
    """Frequencies in Hz, ascending; none where nothing loads the structure.

    Attributes:
        unloaded: Without steady loads, shape (J,).
        gyroscopic: About the static state with Coriolis forces projected on the modes, shape (J,);
            empty without speed.
    """

    unloaded: Array
    gyroscopic: Array


def frequencies_of(analysis: LinearAnalysis) -> Frequencies:
    """Frequencies of a body besides those of its modes; to be called on all ranks."""
    solid, state = analysis.solid, analysis.solid.state
    if state is None:
        return Frequencies(np.empty(0), np.empty(0))
    modes = analysis.modes
    K = state.unloaded
    with DirectModalSolver(replace(solid, stiffness=K, system=FreeSystem(K, solid.mass))) as solver:
        unloaded = solver.modes(len(modes.omega)).frequencies
    gyroscopic: Array = np.empty(0)
    if state.loads.rotation is not None and state.loads.speed:
        G = gyroscopic_matrix(solid, state.loads.rotation, modes.shapes)
        gyroscopic = gyroscopic_frequencies(modes.omega, G) / (2 * np.pi)
    return Frequencies(unloaded, gyroscopic)
