"""The way of the data: from a study to the branch of a nonlinear mode.

Every step is one function call whose result is a frozen record.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from mpi4py import MPI

from fenics_nnm.backbone.arc_start import Begin
from fenics_nnm.backbone.follow import Branch
from fenics_nnm.errors import ModelError, StudyError
from fenics_nnm.fem.kept_mesh import StoredMesh
from fenics_nnm.reduction.flexibility import FlexibilitySource
from fenics_nnm.stages import Stages
from fenics_nnm.structure.matrix_structure import MatrixStructure
from fenics_nnm.structure.mesh_structure import MeshStructure
from fenics_nnm.structure.motions import (
    assert_still_gaps,
    assert_without_coriolis,
    harmonic_balance,
    wanted_motions,
)
from fenics_nnm.structure.prepared import Prepared, prepared
from fenics_nnm.structure.structure import Linear, Structure
from fenics_nnm.study import MatrixStudy, MeshStudy, Study

__all__ = [
    "Analyse",
    "Linear",
    "Prepared",
    "harmonic_balance",
    "linear_analysis",
    "nonlinear_mode",
    "prepared",
    "structure_of",
    "wanted_motions",
    "with_reference",
]

Analyse = Callable[..., Linear]
"""A function with the arguments of `linear_analysis`."""

_STRUCTURES: Mapping[type, Callable[[Any, StoredMesh | None], Structure]] = {
    MeshStudy: MeshStructure,
    MatrixStudy: lambda study, stored: MatrixStructure(study),
}


def structure_of(study: Study, stored: StoredMesh | None = None) -> Structure:
    """The structure of a study; nothing is computed.

    Args:
        study: Study.
        stored: Its mesh as an earlier run has kept it, if it is to be that.
    """
    return _STRUCTURES[type(study)](study, stored)


def linear_analysis(
    study: Study,
    comm: MPI.Comm,
    stages: Stages | None = None,
    *,
    at_most: int | None = None,
    stored: StoredMesh | None = None,
) -> Linear:
    """All that is linear of a study: modes, attachment solutions and the reduced model.

    A mesh is dealt with by all ranks together, matrices by the first one for all.

    Args:
        study: Study.
        comm: Communicator of the mesh.
        stages: Timings and progress.
        at_most: Number of modes in place of that of the study; fewer where the structure has fewer.
        stored: The mesh of the study as an earlier run has kept it, in place of its file.

    Raises:
        NonlinearModeError: as `Structure.linear`, or as `with_reference`.
    """
    found = structure_of(study, stored).linear(comm, stages or Stages(), at_most=at_most)
    return with_reference(found, study)


def with_reference(linear: Linear, study: Study) -> Linear:
    """The analysis, with the reference displacement of points that touch at rest in its model.

    Raises:
        ModelError: if a gap is not positive at full order.
        StudyError: if the reference displacement has no effect.
    """
    reference, model = study.contact.reference_displacement, linear.model
    rest = model.at_rest()
    if study.full_order and model.gap.min() <= 0:
        raise ModelError(
            f"contact.gap = {model.gap.min():g}: must be positive at full order; gaps of "
            'any sign need reduction.method = "massless"'
        )
    if reference is None:
        return linear
    if not rest.touching.any():
        raise StudyError(
            f"contact.reference_displacement = {reference:g}: has no effect: no contact point "
            "touches without force at rest"
        )
    reduction = replace(linear.reduction, model=replace(model, reference=reference))
    return linear.reduced_to(linear.modes, reduction)


def nonlinear_mode(
    study: Study,
    linear: Linear,
    *,
    flexibility: FlexibilitySource | None = None,
    begin: Begin | None = None,
) -> Branch:
    """Follow the nonlinear mode of a study.

    Args:
        study: Study.
        linear: All that is linear of it.
        flexibility: Residual flexibility of the whole model, for a study of full order.
        begin: Motion of an earlier run to begin at, see `fenics_nnm.results.start.beginning`; the
            linear mode if not given.

    Raises:
        StudyError: if the study names such a motion and none is given, or the other way round.
    """
    assert_without_coriolis(study)
    assert_still_gaps(study)
    if (begin is None) != (study.continuation.beginning is None):
        given = "is not given" if begin is None else "is given"
        raise StudyError(
            f"continuation.start: the motion to begin at {given}: must be given by `begin` where "
            "the study names one, see fenics_nnm.results.start.beginning"
        )
    ready = prepared(study, linear)
    return (ready.beginning_at(begin) if begin else ready).followed(flexibility=flexibility)
