"""What is said at the end of a run of points that are not to be trusted as they are."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Iterable

import numpy as np

from fenics_nnm.backbone.follow import Branch
from fenics_nnm.backbone.point import CONVERGED, FAILED, RESONANT, STATUSES, BranchPoint
from fenics_nnm.backbone.point_numbers import return_error

logger = logging.getLogger(__name__)


def log_warnings(lines: Iterable[str]) -> None:
    """Show warnings about a study, a line each."""
    for line in lines:
        logger.warning("%s", line)


def warn_of_points(branch: Branch) -> None:
    """Say which points are not to be trusted as they are; `running.advice` says what to try."""
    total = len(branch.points)
    by_status = {status: [p for p in branch.points if p.status == status] for status in STATUSES}
    if failed := by_status[FAILED]:
        logger.warning(
            "%d of %d points failed: %s",
            len(failed),
            total,
            _first_reason(failed),
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


def warn_of_strength(branch: Branch) -> None:
    """Say which points are beyond what their material bears, and the first of them."""
    beyond = [point for point in branch.points if point.extremes.beyond]
    if not beyond:
        return
    first = beyond[0]
    stress = first.extremes.von_mises.away
    counts = Counter(point.extremes.beyond for point in beyond)
    listed = " and ".join(
        f"at {counts[kind]} points of {len(branch.points)} beyond its {kind} strength"
        for kind in sorted(counts)
    )
    logger.warning(
        "the material is %s: at gamma ratio %g von Mises stress is %.4g MPa at (%s) m",
        listed,
        first.gamma_ratio,
        stress.value / 1e6,
        stress.at.replace(" ", ", "),
    )


def _first_reason(points: list[BranchPoint]) -> str:
    """Why the worst of some points is not verified, or what is said of all of them."""
    if len({point.reason for point in points}) == 1:
        return points[0].reason
    worst = max(points, key=lambda point: np.nan_to_num(return_error(point), nan=np.inf))
    return f"at gamma ratio {worst.gamma_ratio:g} {worst.reason}"
