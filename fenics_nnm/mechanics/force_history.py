"""Contact forces of a motion over its period, finely enough for their largest value."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.motion import Motion, forces_at

#: Instants a sample.
_FINER = 4

#: A force that presses a contact point in by less than this part of the gap is round-off.
_ROUND_OFF = 1e-10


def instants_of(series: Series) -> Array:
    """Phases of a period at which forces are sought, evenly spread, shape (s,)."""
    count = _FINER * series.samples
    return 2 * np.pi * np.arange(count) / count


def force_history(model: ReducedModel, series: Series, motion: Motion) -> Array:
    """Contact forces in N at `instants_of` the series, shape (s, n_c); round-off is 0.

    Args:
        model: Model that the motion obeys, in SI units.
        series: Series that it is written in.
        motion: Motion.
    """
    forces = forces_at(model, series, motion, instants_of(series))
    if not model.massless:
        return forces
    pressed = forces * model.static_flexibility
    return np.where(pressed > _ROUND_OFF * np.abs(model.gap).max(), forces, 0.0)
