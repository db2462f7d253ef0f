"""A last look at points that are failed or inside a resonance, once there are verdicts.

Another motion of the same energy takes the place of such a point where the branch is better for
it: has more verified points, or as many and fewer failed ones, or as many of both and more that are
confirmed in time. It must be confirmed itself, or have an exact motion nearby. No point that was
verified is given up for it, and none is verified by it alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fenics_nnm.backbone.other_motions import OtherMotions
from fenics_nnm.backbone.point import FAILED, RESONANT, STATUSES, VERIFIED, BranchPoint
from fenics_nnm.backbone.verdict import Judge, Judged

#: After so many points on end without a better motion no more is looked at.
_FRUITLESS = 8


def revised(
    judge: Judge, motions: OtherMotions, known: Judged, on_point: Callable[[BranchPoint], None]
) -> Judged:
    """A branch whose points are other motions of their energies where these are better.

    A stretch of points that are alike is looked at from its ends, inwards where that leads on.

    Args:
        judge: Judges the branch.
        motions: Finds other motions.
        known: The branch.
        on_point: Called with each point that takes the place of another one.
    """
    if not (known.found.of_energies and judge.costs_little and motions.able):
        return known
    doubted = [i for i, point in enumerate(known.points) if point.status in (FAILED, RESONANT)]
    ahead = [i for i in doubted if not _enclosed(known.points, i)]
    fruitless = 0
    while ahead and fruitless < _FRUITLESS:
        i = ahead.pop(0)
        doubted.remove(i)
        better = _better(judge, motions, known, i)
        fruitless += 1
        if better is not known:
            known, fruitless = better, 0
            on_point(known.found.points[i])
            ahead += [k for k in (i - 1, i + 1) if k in doubted and k not in ahead]
    return known


def _enclosed(points: Sequence[BranchPoint], i: int) -> bool:
    """Whether a point lies between two that are like it."""
    like = [(each.status, each.family, each.resonance) for each in points[max(i - 1, 0) : i + 2]]
    return len(like) == 3 and len(set(like)) == 1


def _better(judge: Judge, motions: OtherMotions, known: Judged, i: int) -> Judged:
    """The branch with the best motion of the energy of a point.

    Of equally good ones it is that whose frequency is nearest to what the neighbours say.
    """
    others = (judge.exchanged(known, i, point) for point in motions.of(known.points, i))
    able = [
        each
        for each in others
        if _worth(each) > _worth(known) and _exists(each.points[i]) and _keeps(known, each, i)
    ]
    expected = _expected_frequency(known.points, i)

    def rank(each: Judged) -> tuple[tuple[int, int, int], float]:
        return _worth(each), -abs(each.points[i].frequency_ratio / expected - 1)

    return max(able, key=rank, default=known)


def _worth(branch: Judged) -> tuple[int, int, int]:
    """By which the better of two branches is known."""
    statuses = [point.status for point in branch.points]
    confirmed = sum(point.confirmed for point in branch.points)
    return statuses.count(VERIFIED), -statuses.count(FAILED), confirmed


def _exists(point: BranchPoint) -> bool:
    """Whether time confirms a motion, or knows an exact one of its energy nearby."""
    return point.confirmed or point.orbit is not None


def _keeps(known: Judged, other: Judged, i: int) -> bool:
    """Whether the other points that were verified still are, and no more of them.

    A better verdict on a motion that has not changed would rest on the slope of its new neighbour,
    which may be steep beside a fold and then bridges a jump.
    """
    pairs = list(zip(known.points, other.points, strict=True))
    others = pairs[:i] + pairs[i + 1 :]
    return all(
        STATUSES.index(now.status) >= STATUSES.index(was.status)
        and (now.status == VERIFIED or was.status != VERIFIED)
        for was, now in others
    )


def _expected_frequency(points: Sequence[BranchPoint], i: int) -> float:
    """Frequency ratio between the nearest neighbours that are not failed, or that of one."""
    beside = [
        next((point for point in side if point.status != FAILED), None)
        for side in (points[i + 1 :], points[:i][::-1])
    ]
    sound = sorted((p.gamma_ratio, p.frequency_ratio) for p in beside if p is not None)
    if not sound:
        return points[i].frequency_ratio
    ratios, frequencies = np.transpose(sound)
    return float(np.interp(points[i].gamma_ratio, ratios, frequencies))
