"""A posteriori error of a truncated series: what more harmonics and more samples would change.

The motion of N harmonics and m samples, put into the equations of another series, leaves a defect:
force harmonics above N, and forces between the samples. One linearised step from there, at the
same gamma, gives the change of frequency; the defect that remains tells whether the equations are
linear enough in between for that.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.nonlinear.equations import HarmonicEquations, force_harmonics
from fenics_nnm.nonlinear.linear_step import linear_step
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns

#: The finer series has more harmonics and samples by these factors. Errors of samples fall with
#: the square of m, so 4 m has a sixteenth left; 2 m may err alike where a change of contact lies
#: in the middle between two samples.
MORE_HARMONICS, MORE_SAMPLES = 2, 4

#: The finer equations are not solved beyond this number of unknowns (half a GB).
_MOST_UNKNOWNS = 8000

#: A defect below this part of the motion is round-off.
_ROUND_OFF = 1e-13

#: A linearised step that leaves more than this part of the defect does not hold.
HOLDS = 0.5


@dataclass(frozen=True, slots=True)
class SeriesError:
    """Error of a motion that comes from its series in time alone.

    Attributes:
        harmonics: Expected relative error of the frequency, at the same gamma, from N.
        samples: The same from m.
        remainder: Defect that the linearised step leaves over the one it begins with; above
            `HOLDS` the errors are orders of magnitude at best.
    """

    harmonics: float
    samples: float
    remainder: float


@dataclass(frozen=True, slots=True)
class _Step:
    frequency: float
    remainder: float


def series_error(equations: HarmonicEquations, solution: Solution) -> SeriesError | None:
    """Error of a solution that is due to its series.

    At full order the step is that of the explicit modes: of the others it has the static part
    alone, also where added harmonics are near their frequencies.

    Args:
        equations: Equations of the reduced model under complementarity, dimensionless or not.
        solution: A converged solution, of these or of the full-order equations.

    Returns:
        None where the finer equations are too large, or the step is not defined.
    """
    coarse = equations.series
    samples = MORE_SAMPLES * coarse.samples
    dense = _with_series(equations, coarse.harmonics, samples)
    rich = _with_series(equations, MORE_HARMONICS * coarse.harmonics, samples)
    if rich.shape[0] * rich.shape[1] > _MOST_UNKNOWNS:
        return None
    by_samples, by_both = (_step(equations, solution, finer) for finer in (dense, rich))
    if by_samples is None or by_both is None:
        return None
    return SeriesError(
        harmonics=-(by_both.frequency - by_samples.frequency) / solution.omega,
        samples=-by_samples.frequency / solution.omega,
        remainder=max(by_samples.remainder, by_both.remainder),
    )


def _with_series(equations: HarmonicEquations, harmonics: int, samples: int) -> HarmonicEquations:
    """The same equations in a series of the same kind with other numbers."""
    return replace(equations, series=type(equations.series)(harmonics, samples))


def _step(coarse: HarmonicEquations, solution: Solution, finer: HarmonicEquations) -> _Step | None:
    """One linearised step to the solution of the finer equations, None if it is not defined."""
    series, Phi = finer.series, finer.model.Phi
    q, omega, free = series.fitted(solution.q), solution.omega, series.fitted(solution.free)
    basis, closing = series.synthesis, finer.closing
    forces = finer.law(closing.displaced(basis @ free, basis, q))
    at = Unknowns.of(q, omega).completed(len(finer.parameters))
    known = series.fitted(force_harmonics(coarse, solution.at, solution.forces))
    defect = force_harmonics(finer, at, forces) - known
    begins = float(np.linalg.norm(defect / finer.row_scale(omega)))
    if begins <= _ROUND_OFF * np.linalg.norm(q):
        return _Step(0.0, 0.0)
    step = linear_step(finer, at, forces, defect)
    if step is None:
        return None
    moved = q + step.q
    after = finer.law(closing.displaced(basis @ (free + step.q @ Phi.T), basis, moved))
    remains = (
        defect
        + finer.residual(Unknowns.of(moved, omega + step.omega), after)
        - finer.residual(at, forces)
    )
    return _Step(step.omega, float(np.linalg.norm(remains / finer.row_scale(omega))) / begins)
