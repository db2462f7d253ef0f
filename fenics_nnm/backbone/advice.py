"""What to change in a study whose branch has not all that it was asked for."""

from __future__ import annotations

from fenics_nnm.mechanics.fourier import Series

#: From this number of samples on, more of them did not help the studies that were tried.
_ENOUGH_SAMPLES = 64

#: What may help where internal resonances hide motions.
_OTHER_TRUNCATION = "another number of mode.harmonics, or fewer reduction.modes, may reach more"


def advice(series: Series, otherwise: str = _OTHER_TRUNCATION) -> str:
    """Keys of the study that may help where motions are missing.

    Few samples see a contact of short duration at one instant or none, so the sampled force jumps
    as the contact moves past them. With enough of them it is internal resonances that hide
    motions, and these are others in other truncations.

    Args:
        series: Series in time of the finest level.
        otherwise: What may help where there are enough samples.
    """
    if series.samples < _ENOUGH_SAMPLES:
        return f"raise mode.samples = {series.samples}, as contact may be short: 128 are usual"
    return otherwise
