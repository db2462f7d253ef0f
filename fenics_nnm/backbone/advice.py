"""What to change in a study whose branch has not all that it was asked for."""

from __future__ import annotations

from fenics_nnm.backbone.targets import ArcContinuation, Continuation, FrequencyContinuation
from fenics_nnm.mechanics.fourier import Series

#: From this number of samples on, more of them did not help the studies that were tried.
_ENOUGH_SAMPLES = 64


def advice(continuation: Continuation, series: Series) -> str:
    """Keys of the study that may help where motions are missing.

    Few samples see a contact of short duration at one instant or none, so the sampled force jumps
    as the contact moves past them. With enough of them it is internal resonances that hide
    motions, and these are others in other truncations.

    Args:
        continuation: Which motions were wanted.
        series: Series in time of the finest level.
    """
    few = series.samples < _ENOUGH_SAMPLES
    hint = "another number of mode.harmonics, or fewer reduction.modes, may reach more"
    if few:
        hint = f"raise mode.samples = {series.samples}, as contact may be short: 128 are usual"
    elif isinstance(continuation, ArcContinuation):
        hint = "the bounds of steps are keys of continuation.arc_length"
    if isinstance(continuation, FrequencyContinuation):
        return f"contact may not raise this mode to all continuation.frequencies; {hint}"
    return hint
