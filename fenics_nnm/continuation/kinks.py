"""Ways out of a kink of a branch, where contact opens or closes at a sample.

To both sides of a kink the equations are smooth. The tangent before it may lead nowhere, by an
angle of more than 90 degrees; then the branch goes on along the tangent of the other piece, in the
sense that keeps the sign of the determinant of the bordered Jacobian (E. L. Allgower, K. Georg,
Introduction to Numerical Continuation Methods, SIAM, 2003). Where several samples open or close at
once, as on motions with a symmetry in time, more than two pieces meet, and all are tried.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.continuation.arc_length import CurvePoint, Problem, curve_point
from fenics_nnm.nonlinear.solution import evaluated
from fenics_nnm.nonlinear.unknowns import Unknowns

#: Number of motions about a corner that are looked at for the pieces that meet there.
_PROBES = 24


def ways_on(problem: Problem, here: CurvePoint, length: float) -> Iterator[tuple[Array, Unknowns]]:
    """Directions past a kink less than a length ahead, each with a guess; the likeliest first.

    Directions are unit vectors in the scaled unknowns about the point. Where more than two pieces
    meet the orientation says nothing: the ways that turn least come first.
    """
    ahead = here.at.moved(here.metric.unscaled(here.tangent), length)
    likely = _tangent(problem, here, ahead)
    yield likely, ahead.moved(here.metric.unscaled(likely), length)
    probes = _other_pieces(problem, here, length, ahead)
    tangents = [likely, *(_tangent(problem, here, probe) for probe in probes)]
    both = [way for tangent in tangents for way in (tangent, -tangent)]
    for direction in sorted(both, key=lambda way: -float(way @ here.tangent)):
        yield direction, here.at.moved(here.metric.unscaled(direction), length)


def _tangent(problem: Problem, here: CurvePoint, probe: Unknowns) -> Array:
    """Tangent of the piece that a motion lies in, with the orientation of the point."""
    equations = problem.about(probe.omega)
    found = curve_point(equations, evaluated(equations, probe), here.tangent)
    led = found if found.orientation * here.orientation >= 0 else found.turned()
    direction = here.metric.scaled(led.metric.unscaled(led.tangent))
    return np.asarray(direction / np.linalg.norm(direction))


def _other_pieces(
    problem: Problem, here: CurvePoint, length: float, ahead: Unknowns
) -> Iterator[Unknowns]:
    """Motions about a point, one for each set of samples and points in contact, besides `ahead`."""
    known = {_contact(problem, here.at), _contact(problem, ahead)}
    directions = np.random.default_rng(0).normal(size=(_PROBES, here.tangent.size))
    for direction in directions:
        unit = direction / np.linalg.norm(direction)
        probe = ahead.moved(here.metric.unscaled(unit), length)
        contact = _contact(problem, probe)
        if contact not in known:
            known.add(contact)
            yield probe


def _contact(problem: Problem, at: Unknowns) -> bytes:
    """Which points are in contact at which samples."""
    forces = problem.about(at.omega).forces(at)
    return (forces.force > 0).tobytes()
