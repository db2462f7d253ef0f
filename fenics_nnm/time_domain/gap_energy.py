"""Energy of contact points in the gaps that move."""

from __future__ import annotations

from collections.abc import Callable

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.drive import Drive

Forces = Callable[[Array], Array]
"""From changes of the gaps in m to contact forces in N of one state, both of shape (n_c,)."""


def with_moved_gaps(own: float, R: Array, drive: Drive, phase: float, forces: Forces) -> float:
    """Energy in J of a state, lambda^T R lambda / 2 of the gaps as they are in place of at rest.

    Args:
        own: Energy with gaps that stand still.
        R: Residual flexibility in m/N, shape (n_c, n_c).
        drive: How gaps move.
        phase: Phase of the drive.
        forces: Contact forces of the state.
    """
    if not drive.gap.moves:
        return own
    moved, _ = drive.gap_at(phase, len(R))
    now, still = (float(force @ R @ force) / 2 for force in map(forces, (moved, 0.0 * moved)))
    return own + now - still
