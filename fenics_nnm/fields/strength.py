"""How far stress is from what a material bears.

Yield: von Mises stress over the yield strength. Fatigue: Goodman's line (J. Goodman, *Mechanics
Applied to Engineering*, 1899; N. E. Dowling, *Mechanical Behavior of Materials*, 4th ed., eq. 9.20)

    sigma_a / sigma_f + sigma_m / sigma_u = 1 / n

with the safety factor n, the amplitude sigma_a, the mean stress sigma_m, the fatigue strength
sigma_f of fully reversed stress and the tensile strength sigma_u. Where sigma_u is not known, the
yield strength takes its place (Soderberg's line), on the safe side. sigma_m is the von Mises stress
of the state of rest, sigma_a the largest one over the period of the change from it, so that neither
compression nor a mean of the motion itself counts in favour.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.materials.material import Material


@dataclass(frozen=True, slots=True)
class Strengths:
    """Strengths of the materials of a body by their number, in Pa; nan where not known.

    Attributes:
        yields: Yield strength, shape (regions,).
        fatigue: Fatigue strength of fully reversed stress, shape (regions,).
        tensile: Tensile strength, or yield strength where that is not known, shape (regions,).
    """

    yields: Array
    fatigue: Array
    tensile: Array

    @property
    def any_fatigue(self) -> bool:
        """Whether Goodman's line is known of a material."""
        return bool(np.any(np.isfinite(self.fatigue) & np.isfinite(self.tensile)))

    def yield_share(self, peak: Array, region: Indices) -> Array:
        """Largest von Mises stress of nodes (n,) over the yield strength of their material."""
        return peak / self.yields[region]

    def goodman_share(self, amplitude: Array, mean: Array, region: Indices) -> Array:
        """1 / n of Goodman's line at nodes (n,)."""
        return amplitude / self.fatigue[region] + mean / self.tensile[region]


def strengths_of(materials: Sequence[Material]) -> Strengths:
    """Strengths of materials, in the order of the numbers of their regions."""

    def listed(values: Sequence[float | None]) -> Array:
        return np.array([np.nan if value is None else value for value in values])

    yields = listed([each.yield_strength for each in materials])
    tensile = listed([each.tensile_strength for each in materials])
    return Strengths(
        yields=yields,
        fatigue=listed([each.fatigue_strength for each in materials]),
        tensile=np.where(np.isnan(tensile), yields, tensile),
    )
