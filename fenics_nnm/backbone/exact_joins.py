"""Which neighbours of a branch exact motions join, though the course of the frequency parts them.

Slopes tell families apart where a family is smooth between its points. In contact with a stiff stop
it crosses narrow internal resonances, and turns into wide ones, between two of them. A walk along
the family of an exact motion, to the energy of the next one, tells whether that is of it.
"""

from __future__ import annotations

from collections.abc import Sequence

from fenics_nnm.backbone.families import Families
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.time_domain.bifurcations import Witness
from fenics_nnm.time_domain.integrator import Integrator
from fenics_nnm.time_domain.joining import joined


def exact_joins(
    flow: Integrator,
    points: Sequence[BranchPoint],
    witnesses: Sequence[Witness | None],
    known: Families,
    *,
    reversible: bool,
) -> frozenset[int]:
    """Numbers of the points that an exact family joins to the next one, which has another number.

    Args:
        flow: Integrator of the model, in SI units.
        points: Points in the order of the branch.
        witnesses: The exact motion of each point, None where there is none.
        known: Families by the course of the frequency.
        reversible: Whether the motions are time-reversible and start at rest.
    """
    found = set()
    for i, number in enumerate(known.numbers[:-1]):
        one, other = witnesses[i], witnesses[i + 1]
        bent = not (points[i].is_linear or points[i + 1].is_linear)
        if (
            number != known.numbers[i + 1]
            and bent
            and one
            and other
            and joined(flow, one.shot, other.shot, reversible=reversible)
        ):
            found.add(i)
    return frozenset(found)
