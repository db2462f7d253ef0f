"""What is missing of a response, in lines."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

from fenics_nnm.mechanics.second_order_effect import KinematicsChoice
from fenics_nnm.response.isolas import FIRST_BRANCH
from fenics_nnm.response.levels import Response
from fenics_nnm.response.phase_resonance import DampedBackbone


def incomplete(found: Response) -> Iterator[str]:
    """What is missing of a response, a line each."""
    missing = found.missing
    if missing:
        yield (
            f"{len(missing)} of {len(found.points)} points without amplitudes, the first at "
            f"{missing[0].frequency:g} Hz: {missing[0].reason}"
        )
    refuted = found.refuted
    if refuted:
        yield (
            f"{len(refuted)} of {len(found.points)} points are no motions, the first at "
            f"{refuted[0].frequency:g} Hz: {refuted[0].reason}"
        )
    for reason in found.reasons:
        yield f"the curve ends: {reason}"


def pieces(found: Response) -> Iterator[str]:
    """Pieces of the response that are not connected to its ends, a line each."""
    for level in found.levels:
        own = [p for p in found.at_level(level) if p.branch >= FIRST_BRANCH]
        for branch, points in itertools.groupby(own, key=lambda point: point.branch):
            frequency = [point.frequency for point in points]
            yield (
                f"level {level:g}: another piece of the response, not connected to its ends, from "
                f"{min(frequency):.6g} to {max(frequency):.6g} Hz (branch {branch}); a sweep may "
                "pass without it"
            )


def kinematics_note(found: Response, choice: KinematicsChoice) -> Iterator[str]:
    """Which kinematics a driven body has, and what linear ones put in doubt, a line."""
    if choice.second_order:
        yield f"kinematics are of second order: {choice.reason}"
    elif any(point.touches for point in found.points):
        yield (
            f"no motion in contact is verified: {choice.doubt}"
            if choice.doubt
            else "kinematics are linear; fenics-nnm check says how much second order would change"
        )


def short_of(backbone: DampedBackbone) -> Iterator[str]:
    """What a damped backbone lacks, a line each; the response is complete without."""
    if refuted := backbone.refuted:
        yield (
            f"{len(refuted)} of {len(backbone.points)} points are no motions, the first at level "
            f"{refuted[0].point.level:g}: {refuted[0].point.reason}"
        )
    yield from backbone.reasons
