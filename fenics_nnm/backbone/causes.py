"""What keeps a point from being verified, by its numbers: what it would take another run for."""

from __future__ import annotations

from enum import Enum

from fenics_nnm.backbone.point import FAILED, RESONANT, VERIFIED, BranchPoint
from fenics_nnm.backbone.point_numbers import harmonics_error, reduction_error, samples_error
from fenics_nnm.backbone.verdict import VERIFIED_CHANGE, contradicted


class Cause(Enum):
    """What keeps a point from being verified."""

    MASS = "contact points carry mass"
    RESONANCE = "another mode draws energy"
    MODES = "the reduction leaves out too much"
    HARMONICS = "the series has too few harmonics"
    SAMPLES = "contact is looked for at too few instants"


def cause_of(point: BranchPoint, *, massless: bool) -> Cause | None:
    """What keeps a point from being verified; None of one that is, or that nobody judged.

    The order is that of `backbone.verdict`: a motion that integration in time contradicts is none
    of the reduced model, and a larger one would not mend that.

    Args:
        point: Point.
        massless: Whether contact points carry no mass.
    """
    if point.verdict is None or point.status == VERIFIED:
        return None
    if point.status == RESONANT:
        return Cause.RESONANCE
    if not massless:
        return Cause.MASS
    refuted = point.status == FAILED and contradicted(point)
    if abs(reduction_error(point)) > VERIFIED_CHANGE and not refuted:
        return Cause.MODES
    few = abs(samples_error(point)) > abs(harmonics_error(point))
    return Cause.SAMPLES if few else Cause.HARMONICS
