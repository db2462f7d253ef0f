"""How finely a study is resolved: the numbers that "auto" leaves open."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Resolution:
    """Truncation of a branch.

    Attributes:
        harmonics: Number of harmonics N.
        samples: Number of time samples m of a period.
        modes: Number of modes J of the reduction.
    """

    harmonics: int
    samples: int
    modes: int

    def __str__(self) -> str:
        return f"harmonics = {self.harmonics}, samples = {self.samples}, modes = {self.modes}"
