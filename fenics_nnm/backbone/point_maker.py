"""From converged solutions of the harmonic equations to points of a branch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.estimates import SlopeEstimate, no_slope
from fenics_nnm.backbone.point import (
    FREQUENCY_RATIO,
    GAMMA_RATIO,
    Balance,
    BranchPoint,
    ContinuationNotes,
    ExpectedErrors,
)
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.mechanics.model import Scales
from fenics_nnm.mechanics.motion import Motion
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.reduction_error import ReductionError
from fenics_nnm.nonlinear.series_error import SeriesError
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns

#: The penetration is sought on a time grid finer than the samples by this factor.
_FINER = 8

#: A force that presses a contact point in by less than this part of the smallest gap is round-off.
_NO_CONTACT = 1e-10


@dataclass(frozen=True, slots=True)
class PointMaker:
    """Turns dimensionless solutions of the finest level into points.

    Attributes:
        equations: Equations of the finest level, dimensionless.
        scales: Units of the dimensionless model.
        error: From a solution to the error of the reduction, None where it is not known.
        series_error: From a solution to the error of its series in time, None where it is not
            known.
        harmonic: Harmonic that the followed mode is written in.
        slope: From a solution to the slope of its family, nan where it is not known.
    """

    equations: HarmonicEquations
    scales: Scales
    error: Callable[[Solution], ReductionError | None]
    series_error: Callable[[Solution], SeriesError | None]
    harmonic: int = 1
    slope: SlopeEstimate = no_slope

    def point(
        self,
        position: float,
        gamma_ratio: float,
        solution: Solution,
        *,
        skipped: str = "",
        event: str = "",
        slope_ratio: float = float("nan"),
    ) -> BranchPoint:
        """The point that belongs to a converged solution.

        Args:
            position: Place along the branch.
            gamma_ratio: Gamma ratio, as it was asked for.
            solution: Solution of the finest level.
            skipped: Internal resonance that was left for it.
            event: What the branch does there.
            slope_ratio: d omega / d gamma over that of the followed mode alone.
        """
        ratios = {GAMMA_RATIO: gamma_ratio, FREQUENCY_RATIO: solution.omega * self.harmonic}
        return BranchPoint(
            position=position,
            at=ratios,
            motion=self.motion(solution),
            balance=self._balance(solution),
            expected=ExpectedErrors(self.error(solution), self.series_error(solution)),
            notes=ContinuationNotes(
                solution.iterations, slope_ratio, skipped, event, self.slope(solution)
            ),
        )

    def solution(self, point: BranchPoint) -> Solution:
        """The solution that a stored point came from, without the flexibility of its forces."""
        motion, scales = point.motion, self.scales
        q, omega = motion.q / scales.amplitude, 2 * np.pi * motion.frequency / scales.omega
        forces = ContactForces.alone(motion.force / scales.force)
        at = Unknowns.of(q, omega)
        return Solution(
            at=at,
            forces=forces,
            free=motion.free / scales.length,
            energies=self.equations.energy.energies(at, forces),
            residual=point.balance.residual,
            iterations=0,
        )

    def motion(self, solution: Solution) -> Motion:
        """The motion in physical units."""
        scales, energies = self.scales, solution.energies
        hertz = scales.omega / (2 * np.pi)
        force = self._forces(solution)
        in_contact = (force > 0).any(axis=1)
        return Motion(
            q=solution.q * scales.amplitude,
            force=force * scales.force,
            free=solution.free * scales.length,
            frequency=solution.omega * hertz,
            rayleigh_frequency=float(np.sqrt(energies.rayleigh_quotient)) * hertz,
            energy=energies.total(solution.omega) * scales.energy,
            contact_fraction=float(self.equations.series.weight @ in_contact),
        )

    def _forces(self, solution: Solution) -> Array:
        """Contact forces at the samples, without those that are round-off."""
        force = solution.forces.force
        pressed = force * self.equations.model.static_flexibility
        return np.where(pressed > _NO_CONTACT, force, 0.0)

    def _balance(self, solution: Solution) -> Balance:
        """How well the solution keeps to the equations, and to what they stand for."""
        penetration, tension = self._between_samples(solution)
        return Balance(
            residual=solution.residual,
            penetration=penetration * self.scales.length,
            tension=tension * self.scales.length,
            complementarity=self._complementarity(solution),
            virial_error=solution.energies.virial_error(solution.omega),
            energy_variation=self._energy_variation(solution),
        )

    def _between_samples(self, solution: Solution) -> tuple[float, float]:
        """Penetration and tension on a finer grid."""
        model, series = self.equations.model, self.equations.series
        phase = 2 * np.pi * np.arange(_FINER * series.samples) / (_FINER * series.samples)
        force = series.interpolated(solution.forces.force, phase)
        basis = series.basis_at(phase)
        moved = self.equations.closing.displaced(basis @ solution.free, basis, solution.q)
        open_by = model.gap - moved + force @ model.R
        pushed = np.minimum(open_by, model.static_flexibility * force)
        return max(0.0, float(-open_by.min())), max(0.0, float(pushed.max()))

    def _energy_variation(self, solution: Solution) -> float:
        model, series, force = self.equations.model, self.equations.series, solution.forces.force
        q = series.synthesis @ solution.q
        velocity = solution.omega * series.rate_at(series.phase) @ solution.q
        rest = self.equations.rest
        change = force - rest.force
        open_by = model.gap - self._moved(solution) + force @ model.R
        modal = np.sum((model.omega * (q - rest.q)) ** 2 + velocity**2, axis=1)
        twice = modal + np.sum((change @ model.R) * change, axis=1)
        twice += 2 * np.where(force == 0, open_by, 0.0) @ rest.force
        for each in self.equations.mechanics.forces:
            twice += 2 * each.energy_at(q, velocity)
        return float(np.ptp(twice) / (series.weight @ twice))

    def _complementarity(self, solution: Solution) -> float:
        model, force = self.equations.model, solution.forces.force
        if not force.any():
            return 0.0
        displacement = self._moved(solution) - force @ model.R
        product = np.abs(force * (displacement - model.gap)).max()
        return float(product / force.max())

    def _moved(self, solution: Solution) -> Array:
        """Free displacement of the contact points at the samples, shape (s, n_c)."""
        basis, closing = self.equations.series.synthesis, self.equations.closing
        return closing.displaced(basis @ solution.free, basis, solution.q)
