"""Largest displacements, stresses and contact forces of the points of a run, on rank 0."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from fenics_nnm.backbone.branch import Branch
from fenics_nnm.backbone.extremes import UNKNOWN, Extremes, PatchExtremes, Spot
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.quantities import PLAIN, Measures
from fenics_nnm.fields.extremes import extremes_of
from fenics_nnm.fields.strength import strengths_of
from fenics_nnm.mechanics.force_history import force_history, instants_of
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.motion import Motion, free_displacement
from fenics_nnm.reduction.displacement_basis import DisplacementBasis
from fenics_nnm.results.stored_branch import body_in
from fenics_nnm.running.preparing import Ready


class Measuring(Protocol):
    """Finds extremes of motions."""

    def of(self, points: Sequence[BranchPoint]) -> Sequence[Extremes]:
        """Extremes of points, in their order."""

    def amplitude(self, motion: Motion) -> float:
        """Largest displacement in m."""

    def stress(self, motion: Motion) -> float:
        """Largest von Mises stress in Pa away from singular places."""


def measuring_of(ready: Ready) -> Measuring:
    """What measures the motions of a run, whose branch.h5 is begun."""
    chosen = ready.chosen
    study, linear = chosen.study, chosen.linear
    if study.full_order:  # what full order adds to a motion is known of reported ones alone
        return Unmeasured()
    if linear.body is None:
        prepared = chosen.prepared
        basis, series = linear.displacement_basis(), prepared.balance.series
        return MatrixMeasures(basis, prepared.model_in_contact, series)
    ready.bases.forget()
    strengths = strengths_of([region.material for region in linear.body.solid.body.regions])
    branch = body_in(ready.staging.branch, ready.header)
    return extremes_of(branch, study.output.frames, strengths, ready.bases)


def measured(measuring: Measuring, branch: Branch) -> Branch:
    """The branch with the extremes of its points."""
    if not branch.points:
        return branch
    found = measuring.of(branch.points)
    points = (replace(p, extremes=each) for p, each in zip(branch.points, found, strict=True))
    return replace(branch, points=tuple(points))


def measures(measuring: Measuring) -> Measures:
    """Quantities of motions, by their names."""
    return {**PLAIN, "amplitude": measuring.amplitude, "stress": measuring.stress}


@dataclass(frozen=True, slots=True)
class Unmeasured:
    """Knows nothing of motions."""

    def of(self, points: Sequence[BranchPoint]) -> Sequence[Extremes]:
        """As `Measuring.of`."""
        return [UNKNOWN for _ in points]

    def amplitude(self, motion: Motion) -> float:
        """As `Measuring.amplitude`."""
        return float("nan")

    def stress(self, motion: Motion) -> float:
        """As `Measuring.stress`."""
        return float("nan")


@dataclass(frozen=True, slots=True)
class MatrixMeasures:
    """Finds extremes of motions of matrices, which have displacements and contact forces alone.

    Attributes:
        basis: Displacement of the unknowns.
        model: Model that the motions obey.
        series: Series that they are written in.
    """

    basis: DisplacementBasis
    model: ReducedModel
    series: Series

    def of(self, points: Sequence[BranchPoint]) -> Sequence[Extremes]:
        """As `Measuring.of`; all contact rows are one patch, displaced along their directions."""
        return [self._of(point.motion) for point in points]

    def amplitude(self, motion: Motion) -> float:
        """As `Measuring.amplitude`."""
        return self.basis.largest(self.model, self.series, motion)

    def stress(self, motion: Motion) -> float:
        """As `Measuring.stress`."""
        return float("nan")

    def _of(self, motion: Motion) -> Extremes:
        forces = force_history(self.model, self.series, motion)
        free = free_displacement(self.model, self.series, motion, instants_of(self.series))
        moved = free - forces @ self.model.R
        force = float(forces.sum(axis=1).max())
        impulse = float((self.series.weight @ motion.force).sum() / motion.frequency)
        value, unknown = self.basis.largest_at(self.model, self.series, motion)
        return Extremes(
            displacement=Spot(value, unknown),
            patches=(PatchExtremes(float(np.abs(moved).max()), force, impulse),),
            force=force,
            impulse=impulse,
        )
