"""How the gaps of a body move that turns past casings which stand still."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import in_space
from fenics_nnm.errors import GeometryError
from fenics_nnm.fem.contact_sites import Chosen, ContactSites
from fenics_nnm.mechanics.moving_gap import STILL, GapMotion

#: Harmonics whose amplitudes are below this part of the largest one are left out.
_SMALLEST = 1e-6


def gap_motion_of(sites: ContactSites, chosen: Chosen) -> GapMotion:
    """How the gaps of contact points move, in harmonics of the speed.

    Args:
        sites: Vertices of the patches.
        chosen: Which of them are contact points.

    Raises:
        GeometryError: if a contact direction does not meet its casing somewhere in a turn.
    """
    found: dict[int, np.ndarray] = {}
    total, first = sum(len(some) for some in chosen), 0
    for part, some in zip(sites.parts, chosen, strict=True):
        last, patch = first + len(some), part.patch
        try:
            parts = patch.passing(in_space(part.places[some]), in_space(part.directions[some]))
        except GeometryError as error:
            raise GeometryError(f"{patch.key}.casing: {error}") from error
        for multiple, amplitudes in parts.items():
            whole = found.setdefault(multiple, np.zeros(total, complex))
            whole[first:last] = amplitudes
        first = last
    return _without_round_off(found)


def _without_round_off(found: dict[int, np.ndarray]) -> GapMotion:
    """The harmonics that are not round-off."""
    size = {multiple: float(np.abs(each).max()) for multiple, each in found.items()}
    largest = max(size.values(), default=0.0)
    kept = tuple(sorted(m for m, each in size.items() if each > _SMALLEST * largest))
    return GapMotion(kept, np.array([found[m] for m in kept])) if kept else STILL
