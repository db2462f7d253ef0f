"""A branch: its points, and why it ended."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.backbone.family_jumps import Jump
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.light_damping import LightDamping
from fenics_nnm.time_domain.bifurcations import Bifurcations


@dataclass(frozen=True, slots=True)
class Encounter:
    """An internal resonance that a branch came to.

    Attributes:
        name: Mode and harmonic.
        entered: Gamma ratios of the points inside it.
        skipped: Gamma ratios of the points of the main branch that it hid at first.
        frequency: Mean frequency of these points in Hz.
    """

    name: str
    entered: tuple[float, ...]
    skipped: tuple[float, ...]
    frequency: float


@dataclass(frozen=True, slots=True)
class Branch:
    """A branch and the reason of its end.

    Attributes:
        points: Converged points in the order of the branch.
        failures: Wanted gamma ratios, or frequency ratios, without a point, each with the reason.
        reason: Why the branch ended.
        bifurcations: Bifurcations of the exact motions near the points.
        jumps: Neighbours whose frequencies do not follow from each other.
    """

    points: tuple[BranchPoint, ...]
    failures: tuple[tuple[float, str], ...]
    reason: str
    bifurcations: Bifurcations = field(default_factory=Bifurcations)
    jumps: tuple[Jump, ...] = ()

    def kept_up(self, damping: LightDamping, series: Series) -> Branch:
        """The same with what damping takes from each motion, and the force that keeps it up."""
        points = tuple(
            replace(
                point,
                sustained=damping.of(series, point.motion.q, 2 * np.pi * point.motion.frequency),
            )
            for point in self.points
        )
        return replace(self, points=points)

    @property
    def complete(self) -> bool:
        """Whether everything that was wanted has a point."""
        return not self.failures

    @property
    def encounters(self) -> tuple[Encounter, ...]:
        """Internal resonances that were entered or skipped, by their frequency."""
        names = {name for p in self.points for name in (p.resonance, p.notes.skipped) if name}
        found = []
        for name in names:
            entered = [p for p in self.points if p.resonance == name]
            skipped = [p for p in self.points if p.notes.skipped == name and p.resonance != name]
            both = [*entered, *skipped]
            found.append(
                Encounter(
                    name=name,
                    entered=tuple(p.gamma_ratio for p in entered),
                    skipped=tuple(p.gamma_ratio for p in skipped),
                    frequency=sum(p.motion.frequency for p in both) / len(both),
                )
            )
        return tuple(sorted(found, key=lambda encounter: encounter.frequency))
