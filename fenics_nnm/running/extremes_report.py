"""The largest displacement, stress and contact force of a branch, for summary.json."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from math import isfinite
from typing import Any

from fenics_nnm.backbone.extremes import Extremes
from fenics_nnm.backbone.point import BranchPoint, believable

#: What is listed of all points, and by which the point is chosen; margins are the smallest ones.
_LARGEST: dict[str, Callable[[Extremes], float]] = {
    "displacement_m": lambda own: own.displacement.value,
    "contact_force_N": lambda own: own.force,
    "contact_impulse_Ns": lambda own: own.impulse,
    "von_mises_Pa": lambda own: own.von_mises.away.value,
    "principal_Pa": lambda own: own.principal.away.value,
}
_SMALLEST: dict[str, Callable[[Extremes], float]] = {
    "yield_margin": lambda own: own.yield_margin.value,
    "goodman_margin": lambda own: own.goodman_margin.value,
}


def largest_in_summary(points: Sequence[BranchPoint]) -> dict[str, Any]:
    """Extremes of all points that did not fail, and how many are beyond a strength."""
    own = [point.extremes for point in believable(points)]
    found: dict[str, float] = {}
    for listed, chosen in ((_LARGEST, max), (_SMALLEST, min)):
        for name, of in listed.items():
            values = [value for value in map(of, own) if isfinite(value)]
            if values:
                found[name] = chosen(values)
    beyond = Counter(each.beyond for each in own if each.beyond)
    return {"largest": found, "points_beyond": dict(beyond)}
