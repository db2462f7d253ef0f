"""What is said at the end of a run of points that are not to be trusted as they are."""

from __future__ import annotations

import logging
from collections.abc import Iterable

import numpy as np

from fenics_nnm.backbone.follow import Branch
from fenics_nnm.backbone.point import CONVERGED, FAILED, RESONANT, STATUSES, BranchPoint
from fenics_nnm.backbone.point_numbers import reduction_error, return_error
from fenics_nnm.backbone.verdict import LARGEST_REDUCTION_ERROR

logger = logging.getLogger(__name__)

#: What to do about points that failed, where the numbers of a study were given.
RAISE = "raise mode.harmonics and mode.samples"

#: The same where it is the reduction that is expected to put their frequencies off.
MORE_MODES = "raise reduction.modes"


def log_warnings(lines: Iterable[str]) -> None:
    """Show warnings about a study, a line each."""
    for line in lines:
        logger.warning("%s", line)


def warn_of_points(branch: Branch, advice: str = RAISE) -> None:
    """Say which points are not to be trusted as they are.

    Args:
        branch: Branch.
        advice: What to do about points that failed.
    """
    total = len(branch.points)
    by_status = {status: [p for p in branch.points if p.status == status] for status in STATUSES}
    if failed := by_status[FAILED]:
        logger.warning(
            "%d of %d points failed the check in time: %s; %s",
            len(failed),
            total,
            _first_reason(failed),
            MORE_MODES if all(map(_lacks_modes, failed)) else advice,
        )
    if resonant := by_status[RESONANT]:
        logger.warning(
            "%d of %d points are inside an internal resonance (%s): their frequency is off "
            "that of the main branch",
            len(resonant),
            total,
            "; ".join(sorted({point.resonance for point in resonant})),
        )
    if converged := by_status[CONVERGED]:
        unchecked = any(point.returned is None for point in converged)
        logger.log(
            logging.WARNING if unchecked else logging.INFO,
            "%d of %d points solve their equations, but are not verified in time: %s",
            len(converged),
            total,
            _first_reason(converged),
        )


def _lacks_modes(point: BranchPoint) -> bool:
    """Whether the reduction puts the frequency of a point too far off."""
    return abs(reduction_error(point)) > LARGEST_REDUCTION_ERROR


def _first_reason(points: list[BranchPoint]) -> str:
    """Why the worst of some points is not verified, or what is said of all of them."""
    if len({point.reason for point in points}) == 1:
        return points[0].reason
    worst = max(points, key=lambda point: np.nan_to_num(return_error(point), nan=np.inf))
    return f"at gamma ratio {worst.gamma_ratio:g} {worst.reason}"
