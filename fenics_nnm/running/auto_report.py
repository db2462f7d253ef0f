"""What became of numbers that were "auto": for summary.json, the terminal and the log."""

from __future__ import annotations

import logging
import math
from typing import Any

from fenics_nnm.backbone.branch import Branch
from fenics_nnm.backbone.point import RESONANT
from fenics_nnm.backbone.verdict import contradicted
from fenics_nnm.resolution.accuracy import SOURCES, Accuracy
from fenics_nnm.resolution.auto import Choice
from fenics_nnm.resolution.finer import needed

logger = logging.getLogger(__name__)


def summary_of(chosen: Choice, branch: Branch) -> dict[str, Any]:
    """The entry "auto" of summary.json; nothing where all numbers were given."""
    if not chosen.automatic:
        return {}
    found = chosen.achieved(branch.points)
    entry = {
        "found": list(chosen.asked.automatic),
        "tolerance": chosen.study.tolerance,
        "limits": chosen.limits,
        "branches_followed": chosen.round + 1,
    }
    if found is None:
        return {"auto": {**entry, "met": None}}
    doubt = doubt_of(branch)
    return {
        "auto": {
            **entry,
            "met": found.meets(chosen.study.tolerance) and not doubt,
            "doubt": doubt,
            "errors_without_damping": chosen.prepared.damping.follows,
            "harmonics_error": found.harmonics,
            "samples_error": found.samples,
            "reduction_error": found.modes,
            "at_gamma_ratio": None if math.isnan(found.at) else found.at,
        }
    }


def message_of(chosen: Choice, branch: Branch) -> str:
    """The numbers found and what they achieve, in a line; nothing where all were given."""
    if not chosen.automatic:
        return ""
    found = chosen.achieved(branch.points)
    if found is None:
        return f"{chosen.study.resolution}, as the run before found them"
    doubt = doubt_of(branch)
    undamped = " without damping" if chosen.prepared.damping.follows else ""
    return (
        f"{chosen.study.resolution}: expected error of the frequency{undamped} {found.total:.1e} "
        f"{_at(found)}"
        f" (tolerance {chosen.study.tolerance:g})" + (f", but {doubt}" if doubt else "")
    )


def doubt_of(branch: Branch) -> str:
    """Why the expected errors of a branch mean nothing, or nothing.

    Integration in time contradicts points that failed; those of which a large error is expected are
    judged by that, with all others. Points inside an internal resonance do not
    count, and those without contact are linear motions, whose errors are zero with any numbers.
    """
    points = branch.points
    if not points:
        return "no point was found"
    if failed := sum(map(contradicted, points)):
        return f"{failed} points failed the check in time"
    touching = [point for point in points if point.motion.contact_fraction > 0]
    if touching and all(point.status == RESONANT for point in touching):
        return "all points in contact are inside an internal resonance"
    return ""


def warn_of(chosen: Choice, branch: Branch) -> None:
    """Say where a tolerance is not met, why, and what it would need."""
    if not chosen.automatic:
        return
    found, tolerance = chosen.achieved(branch.points), chosen.study.tolerance
    if found is None:
        return
    if doubt := doubt_of(branch):
        logger.warning("mode.tolerance = %g is not known to be met: %s", tolerance, doubt)
    if doubt or found.meets(tolerance):
        return
    source = max(SOURCES, key=found.of)
    number, error = getattr(chosen.study.resolution, source), found.of(source)
    why = chosen.limits.get(source, "")
    if not why:
        why = "as given" if source not in chosen.asked.automatic else "the branch needs more"
    logger.warning(
        "mode.tolerance = %g is not met: the expected error of the frequency is %.1e %s, %.1e of "
        "it from %s = %d (%s); it would take about %d",
        tolerance,
        found.total,
        _at(found),
        error,
        source,
        number,
        why,
        needed(source, number, error, found.allowance * tolerance / 2),
    )


def _at(found: Accuracy) -> str:
    return "in the median" if math.isnan(found.at) else f"at gamma ratio {found.at:g}"
