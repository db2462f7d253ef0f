"""Levels of the responses of a sweep, and their peaks."""

from __future__ import annotations

from fenics_nnm.response.levels import Response
from fenics_nnm.response.peaks import Peak
from fenics_nnm.sweep.case import Plan


def levels(plan: Plan) -> list[float]:
    """Levels of all studies, ascending."""
    of_studies = (case.study.response for case in plan.cases)
    return sorted({level for each in of_studies if each for level in each.levels})


def largest_peak(found: Response, level: float) -> Peak | None:
    """The largest peak of the first place that is watched; None if there is none."""
    own = [peak for peak in found.peaks if peak.level == level and peak.monitor == 0]
    own.sort(key=lambda peak: peak.amplitude)
    return own[-1] if own else None
