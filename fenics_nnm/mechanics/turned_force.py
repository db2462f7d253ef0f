r"""Given forces that turn with the motion, as forces that the motion determines.

The part (theta q)^T F(t) of `excitation`, on the left-hand side -T(t) q with T the sum of theta F
over the places that are pushed: linear in the coordinates, with coefficients that change in time.
Products of N harmonics of both have 2 N, so the harmonics 0..N are exact in 4 N + 1 samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.mechanics.cubic_samples import CubicSamples
from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.force import SampledMotion
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.master_tangent import MasterTangent


@dataclass(frozen=True, slots=True)
class TurnedForce:
    """-T(t) q of the masters.

    Attributes:
        masters: Places of the masters among the coordinates, shape (k,).
        excitations: Forces that turn.
    """

    masters: Indices
    excitations: tuple[Excitation, ...]

    def harmonics(self, motion: SampledMotion) -> Array:
        """Its harmonics, on the left-hand side, shape (c, J)."""
        samples, whole = CubicSamples.of(motion.series), np.zeros_like(motion.q)
        moved = samples.basis[0] @ motion.q[:, self.masters]
        pushed = self._turning(motion.series, samples) @ moved[:, :, None]
        whole[:, self.masters] = -samples.analysis @ pushed[:, :, 0]
        return whole

    def master_tangent(self, motion: SampledMotion) -> MasterTangent:
        """Derivative of the harmonics: -sum_k A_nk T_k S_kn'."""
        samples = CubicSamples.of(motion.series)
        slopes = -self._turning(motion.series, samples)
        own = samples.tangent(slopes[None], motion.omega)
        return MasterTangent.between(self.masters, motion.q.shape[1], own)

    def tangent(self, motion: SampledMotion) -> Array:
        """The same as a whole matrix."""
        return self.master_tangent(motion).whole

    def by_omega(self, motion: SampledMotion) -> Array:
        """It does not depend on the frequency at a given phase."""
        return np.zeros_like(motion.q)

    def mean_virial(self, motion: SampledMotion) -> float:
        """Mean of the force times the coordinates."""
        products = np.sum(motion.q * self.harmonics(motion), axis=1)
        return float(motion.series.mean_square @ products)

    def mean_energy(self, motion: SampledMotion) -> float:
        """It stores none."""
        return 0.0

    def work(self, motion: SampledMotion) -> tuple[float, float]:
        """Mean over the phase of what it puts in by rates by the phase, and of the size of that."""
        samples = CubicSamples.of(motion.series)
        moved, rates = samples.basis[:2] @ motion.q[:, self.masters]
        pushed = (self._turning(motion.series, samples) @ moved[:, :, None])[:, :, 0]
        return (
            float(samples.weight @ np.sum(pushed * rates, axis=1)),
            float(samples.weight @ np.sum(np.abs(pushed * rates), axis=1)),
        )

    def _turning(self, series: Series, samples: CubicSamples) -> Array:
        """T at the samples, shape (s, k, k)."""
        whole = sum(each.turning_harmonics(series) for each in self.excitations)
        return np.tensordot(samples.basis[0], whole, 1)
