"""A converged point of a branch in physical units, with the proof that it carries."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.mechanics.model import Scales
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.reduction_error import ReductionError
from fenics_nnm.nonlinear.series_error import SeriesError
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns

#: The penetration is sought on a time grid finer than the samples by this factor.
_FINER = 8


@dataclass(frozen=True, slots=True)
class BranchPoint:
    """A periodic motion of the branch.

    Attributes:
        position: Place along the branch, by which points are ordered: what is stepped, so the
            gamma ratio, the frequency ratio, or the length of the arc from the first point.
        gamma_ratio: Modal energy coordinate over its value where the linear motion about the state
            of rest ends: at grazing, or where a closed point lifts off.
        frequency: Physical frequency in Hz.
        frequency_ratio: Frequency over that of the linear mode, times the harmonic it began in.
        rayleigh_frequency: sqrt(r) / 2 pi in Hz, the paper's quantity; it is not the frequency
            once there is a gap.
        energy: Total energy in J, from the state of rest.
        residual: Relative residual of the harmonic equations.
        penetration: Largest penetration between the samples in m, the contact forces
            taken linear between them.
        tension: The contrary, force across an open gap, in m: the largest of the smaller of open
            gap and static deflection S_cc lambda_c, at all contact points c and on the same grid.
            With the penetration it is how far min(gap - w, S_cc lambda) is from zero, which it is
            where Signorini's conditions hold; S is the static flexibility.
        complementarity: Largest |lambda (w - gap)| at the samples over max lambda times the unit
            of length: the smallest gap if that is positive, else the motion at gamma ratio 1.
        reduction_residual: Residual of the motion in the full-order harmonic equations, in the
            norm of K^-1, over the square root of k^; 0 at full order, nan if unknown.
        reduction_error: Relative error of the frequency that is expected of the reduction.
        virial_error: Relative error of omega^2 m^ = k^ + virial, see `nonlinear.energies`.
        energy_variation: Largest less smallest total energy at the samples, over its mean; the
            energy of a motion in time is constant.
        contact_fraction: Share of the period with contact somewhere.
        iterations: Newton steps at the finest level.
        status: What may be believed: "verified", "converged", "inside resonance" or "failed", see
            `time_domain.verdict`. All points solve the discrete equations.
        reason: Why the point is not verified; empty if it is.
        resonance: Mode and harmonic of an internal resonance, or nothing.
        skipped: Mode and harmonic of an internal resonance that hid the main branch at this
            place, and was left; or nothing.
        slope_ratio: d omega / d gamma over that of the followed mode alone; below 0.1 the
            frequency stands still while energy flows into other modes. nan below grazing, and
            where it is not known.
        event: What the branch does there, found by its length: "fold in gamma", "fold in omega",
            "branch point", or nothing.
        return_error: Distance of the state after one period of time integration from its start,
            relative in the energy norm; nan before it is known, or where it is not defined.
        return_error_10: The same after ten periods.
        energy_drift: Largest relative change of the energy in these ten periods, by rounding.
        shot_frequency: Frequency in Hz of the periodic motion of the same energy that shooting
            finds nearby, exact in time; nan if none was found, or looked for.
        shot_distance: Distance of its state from that of the point, relative in the energy norm.
        shot_return_error: Its own return error.
        largest_multiplier: Largest modulus of its Floquet multipliers: 1 if it is stable.
        stability: "stable", or the kind of instability of the largest one, see
            `time_domain.stability`; empty if not known.
        harmonics_error: Relative error of the frequency that is expected of N harmonics; nan where
            contact points carry mass.
        samples_error: The same of m samples.
        error_remainder: Defect that the linearised step behind these two leaves over the one it
            begins with: they are orders of magnitude above 1/2.
        q: Harmonics of the modal coordinates in kg^1/2 m, shape (N + 1, J), or (2 N + 1, J) for a
            general series: cosines, then sines.
        force: Contact forces in N at the samples of the series: of the first half period, shape
            (m // 2 + 1, n_c), or of all of it, shape (m, n_c), for a general series.
        free: Harmonics of the free displacement of the contact points in m, shape (N + 1, n_c), or
            (2 N + 1, n_c): they move by this less R lambda.
        multipliers: Floquet multipliers of the motion that shooting finds, besides the two that are
            1, by falling modulus, shape (2 J - 2,); empty where they are not known.
    """

    position: float
    gamma_ratio: float
    frequency: float
    frequency_ratio: float
    rayleigh_frequency: float
    energy: float
    residual: float
    penetration: float
    tension: float
    complementarity: float
    reduction_residual: float
    reduction_error: float
    virial_error: float
    energy_variation: float
    contact_fraction: float
    iterations: int
    status: str
    reason: str
    resonance: str
    skipped: str
    event: str
    slope_ratio: float
    return_error: float
    return_error_10: float
    energy_drift: float
    shot_frequency: float
    shot_distance: float
    shot_return_error: float
    largest_multiplier: float
    stability: str
    harmonics_error: float
    samples_error: float
    error_remainder: float
    q: Array
    force: Array
    free: Array
    multipliers: Complex


@dataclass(frozen=True, slots=True)
class PointMaker:
    """Turns dimensionless solutions of the finest level into points.

    Attributes:
        equations: Equations of the finest level, dimensionless.
        scales: Units of the dimensionless model.
        error: From a solution to the error of the reduction.
        series_error: From a solution to the error of its series in time.
        harmonic: Harmonic that the followed mode is written in.
    """

    equations: HarmonicEquations
    scales: Scales
    error: Callable[[Solution], ReductionError]
    series_error: Callable[[Solution], SeriesError]
    harmonic: int = 1

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
        energies, error = solution.energies, self.error(solution)
        series = self.series_error(solution)
        hertz = self.scales.omega / (2 * np.pi)
        in_contact = (solution.forces.force > 0).any(axis=1)
        penetration, tension = self._between_samples(solution)
        nan = float("nan")
        return BranchPoint(
            position=position,
            gamma_ratio=gamma_ratio,
            frequency=solution.omega * hertz,
            frequency_ratio=solution.omega * self.harmonic,
            rayleigh_frequency=float(np.sqrt(energies.rayleigh_quotient)) * hertz,
            energy=energies.total(solution.omega) * self.scales.energy,
            residual=solution.residual,
            penetration=penetration * self.scales.length,
            tension=tension * self.scales.length,
            complementarity=self._complementarity(solution),
            reduction_residual=error.residual,
            reduction_error=error.frequency,
            virial_error=energies.virial_error(solution.omega),
            energy_variation=self._energy_variation(solution),
            contact_fraction=float(self.equations.series.weight @ in_contact),
            iterations=solution.iterations,
            status="converged",
            reason="the run was stopped before the motion was checked in time",
            resonance="",
            skipped=skipped,
            event=event,
            slope_ratio=slope_ratio,
            return_error=nan,
            return_error_10=nan,
            energy_drift=nan,
            shot_frequency=nan,
            shot_distance=nan,
            shot_return_error=nan,
            largest_multiplier=nan,
            stability="",
            harmonics_error=series.harmonics,
            samples_error=series.samples,
            error_remainder=series.remainder,
            q=solution.q * self.scales.amplitude,
            force=solution.forces.force * self.scales.force,
            free=solution.free * self.scales.length,
            multipliers=np.empty(0, dtype=complex),
        )

    def solution(self, point: BranchPoint) -> Solution:
        """The solution that a stored point came from, without the flexibility of its forces."""
        q, omega = point.q / self.scales.amplitude, 2 * np.pi * point.frequency / self.scales.omega
        forces = ContactForces.alone(point.force / self.scales.force)
        at = Unknowns.of(q, omega)
        return Solution(
            at=at,
            forces=forces,
            free=point.free / self.scales.length,
            energies=self.equations.energy.energies(at, forces),
            residual=point.residual,
            iterations=0,
        )

    def _between_samples(self, solution: Solution) -> tuple[float, float]:
        """Penetration and tension on a finer grid."""
        model, series = self.equations.model, self.equations.series
        phase = 2 * np.pi * np.arange(_FINER * series.samples) / (_FINER * series.samples)
        force = series.interpolated(solution.forces.force, phase)
        open_by = model.gap - series.basis_at(phase) @ solution.free + force @ model.R
        pushed = np.minimum(open_by, model.static_flexibility * force)
        return max(0.0, float(-open_by.min())), max(0.0, float(pushed.max()))

    def _energy_variation(self, solution: Solution) -> float:
        model, series, force = self.equations.model, self.equations.series, solution.forces.force
        q = series.synthesis @ solution.q
        velocity = solution.omega * series.rate_at(series.phase) @ solution.q
        rest = self.equations.rest
        change = force - rest.force
        open_by = model.gap - series.synthesis @ solution.free + force @ model.R
        modal = np.sum((model.omega * (q - rest.q)) ** 2 + velocity**2, axis=1)
        twice = modal + np.einsum("sc,cd,sd->s", change, model.R, change)
        twice += 2 * np.where(force == 0, open_by, 0.0) @ rest.force
        return float(np.ptp(twice) / (series.weight @ twice))

    def _complementarity(self, solution: Solution) -> float:
        model, force = self.equations.model, solution.forces.force
        if not force.any():
            return 0.0
        displacement = self.equations.series.synthesis @ solution.free - force @ model.R
        product = np.abs(force * (displacement - model.gap)).max()
        return float(product / force.max())
