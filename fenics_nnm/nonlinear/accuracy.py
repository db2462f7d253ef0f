"""Whether the points of a branch are accurate enough, and what they lack most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.nonlinear.series_error import HOLDS

#: Sources of error, in the order of the columns of `_sizes`.
SOURCES = ("harmonics", "samples", "modes")

#: Among internal resonances this part of the points may miss the tolerance: each truncation has
#: others, which none makes vanish.
_MAY_MISS = 0.1


@dataclass(frozen=True, slots=True)
class Accuracy:
    """Expected relative errors of the frequency over a branch, at the same gamma.

    Points inside an internal resonance do not count. Where the linearised steps behind the errors
    hold at all other points, these are the errors of the worst point. Where they do not hold
    everywhere, there are internal resonances among the harmonics that the series lacks; then a
    point in ten is left out, and points whose step does not hold count in the median alone.

    Attributes:
        harmonics: Error from N.
        samples: Error from m.
        modes: Error from J.
        at: Gamma ratio of the point that these are of; nan for the median.
    """

    harmonics: float
    samples: float
    modes: float
    at: float

    @property
    def total(self) -> float:
        """Sum of the errors; 0 of nothing."""
        return self.harmonics + self.samples + self.modes

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
    counted = [p for p in points if not p.resonance] or list(points)
    if not counted:
        return Accuracy(0.0, 0.0, 0.0, float("nan"))
    sizes = np.array([_sizes(point) for point in counted])
    sizes[:, SOURCES.index("samples")] *= samples_factor
    chosen = [SOURCES.index(name) for name in sources]
    totals = sizes[:, chosen].sum(axis=1)
    holds = np.array([not point.error_remainder > HOLDS for point in counted])
    median = int(np.argsort(totals)[len(totals) // 2])
    among = np.flatnonzero(holds)
    worst = _worst(totals, among, int(_MAY_MISS * len(counted)) if not holds.all() else 0)
    if worst is None or totals[worst] < totals[median]:
        return Accuracy(*_floats(sizes[median]), at=float("nan"))
    return Accuracy(*_floats(sizes[worst]), at=counted[worst].gamma_ratio)


def _worst(totals: Array, among: Indices, left_out: int) -> int | None:
    ordered = among[np.argsort(totals[among])]
    kept = ordered[: max(len(ordered) - left_out, 0)]
    return int(kept[-1]) if len(kept) else None


def _sizes(point: BranchPoint) -> tuple[float, float, float]:
    """Sizes of the errors; what is unknown counts as none."""
    errors = (point.harmonics_error, point.samples_error, point.reduction_error)
    harmonics, samples, modes = (0.0 if np.isnan(error) else abs(error) for error in errors)
    return harmonics, samples, modes


def _floats(row: Array) -> tuple[float, float, float]:
    harmonics, samples, modes = (float(value) for value in row)
    return harmonics, samples, modes
