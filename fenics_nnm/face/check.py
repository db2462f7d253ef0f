"""What a study means, up to its linear modes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array, in_space
from fenics_nnm.running.beginning import begin
from fenics_nnm.running.checking import checked
from fenics_nnm.running.trust import log_warnings
from fenics_nnm.structure.analysis import Analyse
from fenics_nnm.structure.structure import Linear
from fenics_nnm.study import Study


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Check:
    """A study up to its linear modes; `print` shows it as `fenics-nnm check` does.

    With closed points at rest the modes are those about the state of rest.

    Attributes:
        text: What the study means, in lines.
        warnings: What looks like a wrong unit or direction, a line each.
        frequency_Hz: Frequencies of the linear modes in Hz, ascending, shape (J,).
        shapes_at_contact: Displacement of each contact point towards its obstacle in each
            mass-normalised mode, in kg^-1/2, shape (n_c, J).
        gap_m: Gaps of the contact points in m, shape (n_c,).
        contact_points_m: Places of the contact points in m, shape (n_c, 3); no rows for matrices.
        contact_directions: Unit vectors towards the obstacle, shape (n_c, 3); no rows for matrices.
        first_contact_J: Energy in J at which the mode that is followed first touches.
    """

    text: str
    warnings: tuple[str, ...]
    frequency_Hz: Array
    shapes_at_contact: Array
    gap_m: Array
    contact_points_m: Array
    contact_directions: Array
    first_contact_J: float

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return f"Check({len(self.frequency_Hz)} modes from {self.frequency_Hz[0]:.6g} Hz)"


def check_of(study: Study, analyse: Analyse) -> Check:
    """Look at a study; to be called on all ranks.

    Args:
        study: Study.
        analyse: Finds what is linear of it.

    Raises:
        NonlinearModeError: if it cannot be run.
    """
    begin()
    found = checked(study, MPI.COMM_WORLD, analyse=analyse)
    if MPI.COMM_WORLD.rank == 0:
        log_warnings(found.warnings)
    prepared = found.chosen.prepared
    linear, frequency = prepared.linear, prepared.linear_frequencies
    places, directions = _contact(linear)
    return Check(
        text=found.text,
        warnings=found.warnings,
        frequency_Hz=frequency,
        shapes_at_contact=linear.model.at_rest().motion[:, : len(frequency)],
        gap_m=linear.model.gap,
        contact_points_m=places,
        contact_directions=directions,
        first_contact_J=linear.first_contact(prepared.mode).energy,
    )


def _contact(linear: Linear) -> tuple[Array, Array]:
    """Places and directions of the contact points of a mesh; no rows of matrices."""
    body = linear.body
    if body is None:
        return np.empty((0, 3)), np.empty((0, 3))
    return in_space(body.interface.points), in_space(body.interface.directions)
