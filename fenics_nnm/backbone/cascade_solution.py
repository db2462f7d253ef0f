"""Solutions of all levels at one position of a branch."""

from __future__ import annotations

from dataclasses import dataclass, replace

from fenics_nnm.nonlinear.solution import Solution

#: A fall of the share from one point to the next by this much asks for a second look.
_SHARE_DROP = 0.02


@dataclass(frozen=True, slots=True)
class CascadeSolution:
    """Solutions of all levels at one position of a branch, None where a level has none.

    Attributes:
        position: Position along the branch: gamma ratio, or frequency ratio.
        gamma_ratio: gamma over its value at grazing.
        solutions: One entry a level, coarse to fine.
        share: Share of the kinetic energy of the finest level in the first harmonic of the
            followed mode; 0 without a solution. Internal resonances draw on it.
        failure: Why the finest level has none; empty where it has one.
        skipped: Internal resonance that was left for this motion, or nothing.
        slope_ratio: d omega / d gamma of the finest motion over that of the followed mode alone.
        refused: A motion that the finest level ended with and that is not on the branch, or none.
    """

    position: float
    gamma_ratio: float
    solutions: tuple[Solution | None, ...]
    share: float = 0.0
    failure: str = ""
    skipped: str = ""
    slope_ratio: float = float("nan")
    refused: Solution | None = None

    @property
    def finest(self) -> Solution | None:
        """Solution at the truncation that the study asks for."""
        return self.solutions[-1]

    def has_lost_share(self, neighbour: CascadeSolution) -> bool:
        """Whether it has a clearly smaller share in the followed mode than a neighbour."""
        return self.share < neighbour.share - _SHARE_DROP

    def frequency_change(self, neighbour: CascadeSolution | None) -> float:
        """Relative change of frequency from a neighbour's motion; nan without one of both."""
        if self.finest is None or neighbour is None or neighbour.finest is None:
            return float("nan")
        return abs(self.finest.omega / neighbour.finest.omega - 1)

    def light(self) -> CascadeSolution:
        """The same without factors."""
        refused = self.refused.light() if self.refused else None
        solutions = tuple(found.light() if found else None for found in self.solutions)
        return replace(self, solutions=solutions, refused=refused)

    def thinned(self, *, levels: bool) -> CascadeSolution:
        """What a neighbour needs: no slopes of forces; all levels, or the finest alone."""
        below = self.solutions if levels else (*(None,) * (len(self.solutions) - 1), self.finest)
        solutions = tuple(found.thinned() if found else None for found in below)
        return replace(self, solutions=solutions, refused=None)
