"""Whether the points of a branch are accurate enough, and what they lack most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone import point_numbers as numbers
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.resonance import UNNAMED
from fenics_nnm.nonlinear.series_error import HOLDS

#: Sources of error, in the order of the columns of `_sizes`.
SOURCES = ("harmonics", "samples", "modes")

#: Among internal resonances single points may miss the tolerance by this factor: each truncation
#: has others, which none makes vanish.
_ALLOWANCE = 3.0

#: There one point in so many is left out, and at least one.
_LEFT_OUT = 10


@dataclass(frozen=True, slots=True)
class Accuracy:
    """Expected relative errors of the frequency over a branch, at the same gamma.

    Points inside an internal resonance that has a name do not count. Where the linearised steps
    behind the errors hold at all other points, these are the errors of the worst point. Where they
    do not hold everywhere, there are internal resonances among the harmonics that the series lacks;
    then these are the errors of the median, or of the worst point whose step holds, one in ten left
    out and at least one, where that misses the tolerance by a factor above 3.

    Attributes:
        harmonics: Error from N.
        samples: Error from m.
        modes: Error from J.
        at: Gamma ratio of the point that these are of; nan for the median.
        allowance: Factor by which they may exceed the tolerance.
    """

    harmonics: float
    samples: float
    modes: float
    at: float
    allowance: float = 1.0

    @property
    def total(self) -> float:
        """Sum of the errors; 0 of nothing."""
        return self.harmonics + self.samples + self.modes

    def meets(self, tolerance: float) -> bool:
        """Whether the errors add up to no more than allowed."""
        return self.total <= self.allowance * tolerance

    def of(self, source: str) -> float:
        """Error from one of `SOURCES`."""
        return float(getattr(self, source))

    def only(self, sources: Sequence[str]) -> Accuracy:
        """The part of the errors that comes from some sources."""
        return replace(self, **{name: 0.0 for name in SOURCES if name not in sources})


def accuracy(
    points: Sequence[BranchPoint], sources: Sequence[str] = SOURCES, *, samples_factor: float = 1.0
) -> Accuracy:
    """The accuracy of points.

    Args:
        points: Points of a branch, or some of them.
        sources: The worst point is that with the largest sum of these errors.
        samples_factor: Factor on the error of the samples, whose size and sign vary from energy to
            energy, for points that stand for others between them.
    """
    counted = [p for p in points if p.resonance in ("", UNNAMED)] or list(points)
    if not counted:
        return Accuracy(0.0, 0.0, 0.0, float("nan"))
    sizes = np.array([_sizes(point) for point in counted])
    sizes[:, SOURCES.index("samples")] *= samples_factor
    chosen = [SOURCES.index(name) for name in sources]
    totals = sizes[:, chosen].sum(axis=1)
    holds = np.array([not numbers.error_remainder(point) > HOLDS for point in counted])
    median = int(np.argsort(totals)[len(totals) // 2])
    smooth = bool(holds.all())
    ordered = [int(index) for index in np.argsort(totals) if holds[index]]
    kept = ordered if smooth else ordered[: -max(1, len(counted) // _LEFT_OUT)]
    allowance = 1.0 if smooth else _ALLOWANCE
    if not kept or (not smooth and totals[kept[-1]] <= allowance * totals[median]):
        return Accuracy(*_floats(sizes[median]), at=float("nan"))
    worst = kept[-1]
    return Accuracy(*_floats(sizes[worst]), at=counted[worst].gamma_ratio, allowance=allowance)


def _sizes(point: BranchPoint) -> tuple[float, float, float]:
    """Sizes of the errors; what is unknown counts as none."""
    errors = (
        numbers.harmonics_error(point),
        numbers.samples_error(point),
        numbers.reduction_error(point),
    )
    harmonics, samples, modes = (0.0 if np.isnan(error) else abs(error) for error in errors)
    return harmonics, samples, modes


def _floats(row: Array) -> tuple[float, float, float]:
    harmonics, samples, modes = (float(value) for value in row)
    return harmonics, samples, modes
