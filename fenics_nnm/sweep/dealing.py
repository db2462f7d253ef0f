"""Which study a worker takes next: one that shares the linear analysis it holds, if there is one.

Studies stand in groups that are likely to share an analysis. A worker stays with its group until
that is used up, and goes on with the group that has most left then. Several workers may be in one
group; each of them makes the analysis once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from fenics_nnm.structure.shared_analysis import values_of_structure
from fenics_nnm.sweep.case import Case

#: Keys of contact that modes and attachment solutions do not depend on.
_OF_GAPS = {"gap", "law", "name", "reference_displacement"}


class Counters(Protocol):
    """How many studies of each group have been taken, by all workers together."""

    def take(self, group: int) -> int:
        """Count one more study of a group; the number before that."""

    def taken(self) -> Sequence[int]:
        """Studies taken of each group; may be more than there are."""


@dataclass(slots=True)
class LocalCounters:
    """Counters of one process."""

    counts: list[int]

    def take(self, group: int) -> int:
        """Count one more study of a group; the number before that."""
        self.counts[group] += 1
        return self.counts[group] - 1

    def taken(self) -> Sequence[int]:
        """Studies taken of each group."""
        return self.counts


@dataclass(slots=True)
class Hand:
    """What one worker takes.

    Attributes:
        groups: Studies by their groups.
        counters: Counters that all workers share.
        held: Group of the last study taken, or the one to begin with.
    """

    groups: Sequence[Sequence[Case]]
    counters: Counters
    held: int

    def take(self) -> Case | None:
        """The next study; None if all are taken."""
        for group in self._order():
            number = self.counters.take(group)
            if number < len(self.groups[group]):
                self.held = group
                return self.groups[group][number]
        return None

    def _order(self) -> list[int]:
        """Groups that may have studies left: the one held, then by how many they have left."""
        taken = self.counters.taken()
        left = [len(cases) - count for cases, count in zip(self.groups, taken, strict=True)]
        others = sorted(range(len(left)), key=lambda group: (group != self.held, -left[group]))
        return [group for group in others if left[group] > 0]


def grouped(cases: Sequence[Case]) -> list[list[Case]]:
    """Studies in groups that are likely to share a linear analysis, in the order of the first."""
    groups: dict[str, list[Case]] = {}
    for case in cases:
        groups.setdefault(_likeness(case), []).append(case)
    return list(groups.values())


def _likeness(case: Case) -> str:
    """Text that is equal for studies that are likely to share their linear analysis."""
    return repr((values_of_structure(case.study), _without_gaps(case.study.contact.model_dump())))


def _without_gaps(contact: Any) -> Any:
    if isinstance(contact, tuple) and contact and isinstance(contact[0], dict):
        return [_without_gaps(patch) for patch in contact]
    if not isinstance(contact, dict):
        return contact
    kept = {key: _without_gaps(value) for key, value in contact.items() if key not in _OF_GAPS}
    if contact.get("direction") != "casing":
        kept.pop("casing", None)
    elif kept.get("casing"):
        kept["casing"].pop("clearance", None)
    return kept
