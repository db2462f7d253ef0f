"""Which motions of a branch are wanted, and what following it gives."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

from fenics_nnm.backbone.cascade import Cascade
from fenics_nnm.backbone.outlook import Horizon, Outlook
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.backbone.quantities import PLAIN, Measures
from fenics_nnm.nonlinear.newton import Newton

#: Newton's configuration, unless another one is given.
NEWTON = Newton(iterations=25, wildest_leap=1e3, crawls=4, wild=100.0)

#: A point belongs to the wanted ones if it misses their ends by this part at most.
_SAME = 1e-9

Failures = tuple[tuple[float, str], ...]
"""Wanted positions without a point, each with the reason."""


@dataclass(frozen=True, slots=True)
class Followed:
    """What following a branch gave.

    Attributes:
        points: Points in the order of the branch.
        failures: Wanted positions without a point, each with the reason.
        reason: Why the branch ended.
        connected: Whether each point was followed continuously from the one before it.
        of_energies: Whether the place of a point is its energy alone, so that another motion of
            that energy may take it.
    """

    points: tuple[BranchPoint, ...]
    failures: Failures
    reason: str
    connected: bool = False
    of_energies: bool = False

    def without(self, failures: Failures) -> Followed:
        """The same with further wanted motions that have no point."""
        if not failures:
            return self
        reason = failures[0][1] if not self.failures else self.reason
        return replace(self, failures=self.failures + failures, reason=reason)


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a branch is: what was found before, and what hears of the rest.

    Attributes:
        known: Points found before, in SI units; they are part of the branch as they are.
        on_point: Called with each converged point before the next one is begun; a later point at
            the same position replaces the earlier one. The check of periodicity comes at the end.
        on_position: Called with each position that has been dealt with.
        measures: Quantities of motions that values may be asked of.
    """

    known: Sequence[BranchPoint] = ()
    on_point: Callable[[BranchPoint], None] = lambda point: None
    on_position: Callable[[float], None] = lambda position: None
    measures: Measures = field(default_factory=lambda: PLAIN)


#: A branch from its beginning, of which nobody hears on the way.
SILENT = Progress()


class Wanted(Horizon, Protocol):
    """Energies or frequencies to visit, or a branch to follow by its length."""

    @property
    def start(self) -> float:
        """First ratio of what is named `name`."""

    @property
    def stop(self) -> float:
        """Last ratio."""

    @property
    def name(self) -> str:
        """Name of what is stepped, or bounds the branch."""

    @property
    def harmonic(self) -> int:
        """Harmonic k that the linear mode is written in at first; above 1 if subharmonic."""

    @property
    def certain_ratios(self) -> Sequence[float]:
        """Gamma ratios that have a point on any branch that is complete, ascending."""

    def follow(self, cascade: Cascade, maker: PointMaker, progress: Progress) -> Followed:
        """Follow the branch.

        Args:
            cascade: Levels, and their motions of given energy.
            maker: Makes points of solutions.
            progress: Points found before, and what hears of new ones.

        Raises:
            ModelError: if contact points carry mass, and other conditions than the energy are
                needed.
        """

    def span(self, ahead: Callable[[], Outlook]) -> tuple[float, float]:
        """Gamma ratios that it begins and ends at; nan where the branch does not come there.

        Args:
            ahead: Looks ahead, where that is needed to know.
        """

    def still_wanted(self, points: Iterable[BranchPoint]) -> tuple[BranchPoint, ...]:
        """Those points of an earlier run, in its order, that are wanted again."""


def inside(value: float, start: float, stop: float) -> bool:
    """Whether a ratio lies in a range, apart from round-off."""
    return start * (1 - _SAME) <= value <= stop * (1 + _SAME)
