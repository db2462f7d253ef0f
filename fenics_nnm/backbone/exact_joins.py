"""Which neighbours of a branch exact motions join, though the course of the frequency parts them.

Slopes tell families apart where a family is smooth between its points. In contact with a stiff stop
it crosses narrow internal resonances, and turns into wide ones, between two of them. A walk along
the family of an exact motion, to the energy of the next one, tells whether that is of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from fenics_nnm.backbone.families import Families
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.time_domain.bifurcations import Witness
from fenics_nnm.time_domain.integrator import Integrator
from fenics_nnm.time_domain.joining import joined


@dataclass(frozen=True, slots=True)
class Joins:
    """Which exact motions a family joins: each two of them are asked for once.

    Attributes:
        flow: Integrator of the model, in SI units.
        reversible: Whether the motions are time-reversible and start at rest.
    """

    flow: Integrator
    reversible: bool
    _known: dict[tuple[int, int], tuple[Witness, Witness, bool]] = field(default_factory=dict)

    def between(self, one: Witness, other: Witness) -> bool:
        """Whether the family of a motion leads to another one."""
        key = id(one), id(other)  # of motions that are kept, so that no other one has the same
        if key not in self._known:
            found = joined(self.flow, one.shot, other.shot, reversible=self.reversible)
            self._known[key] = one, other, found
        return self._known[key][-1]


def exact_joins(
    joins: Joins,
    points: Sequence[BranchPoint],
    witnesses: Sequence[Witness | None],
    known: Families,
) -> frozenset[int]:
    """Numbers of the points that an exact family joins to the next one, which has another number.

    Args:
        joins: Which exact motions a family joins.
        points: Points in the order of the branch.
        witnesses: The exact motion of each point, None where there is none.
        known: Families by the course of the frequency.
    """
    found = set()
    for i, number in enumerate(known.numbers[:-1]):
        one, other = witnesses[i], witnesses[i + 1]
        bent = not (points[i].is_linear or points[i + 1].is_linear)
        parted = number != known.numbers[i + 1]
        if parted and bent and one and other and joins.between(one, other):
            found.add(i)
    return frozenset(found)
