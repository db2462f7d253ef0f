"""The way of the data: from a study to the branch of a nonlinear mode.

Every step is one function call whose result is a frozen record.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.backbone.follow import (
    ArcContinuation,
    Branch,
    Continuation,
    EnergyContinuation,
    FrequencyContinuation,
    follow,
)
from fenics_nnm.backbone.levels import HarmonicBalance, contact_model
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.continuation.trace_options import ArcLength, Predictor
from fenics_nnm.errors import ModelError, StudyError
from fenics_nnm.fem.clamp import Clamp
from fenics_nnm.fem.contact import ContactInterface, contact_interface
from fenics_nnm.fem.linear import LinearAnalysis, craig_bampton_reduced, massless_reduced
from fenics_nnm.fem.mesh import TaggedMesh
from fenics_nnm.fem.modal_solver import DirectModalSolver, ModalSolver, modal_solver
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.fem.solid import Solid, assemble_solid
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.augmented_lagrangian import MultiplierLoop
from fenics_nnm.nonlinear.full_order_solver import FlexibilitySource
from fenics_nnm.reduction.matrices import Matrices
from fenics_nnm.reduction.matrix_analysis import MatrixAnalysis, matrix_analysis
from fenics_nnm.reduction.matrix_files import read_matrix
from fenics_nnm.results.start import beginning
from fenics_nnm.stages import Stages
from fenics_nnm.structure.body import body_of
from fenics_nnm.structure.contact_patches import contact_patches
from fenics_nnm.structure.meshing import tagged_mesh
from fenics_nnm.study import MatrixStudy, MeshStudy, Study
from fenics_nnm.study.continuation import ArcLengthSection

Analysis = LinearAnalysis | MatrixAnalysis
"""All that is linear of a study."""

Analyse = Callable[..., Analysis]
"""A function with the arguments of `linear_analysis`."""


def linear_analysis(
    study: Study, comm: MPI.Comm, stages: Stages | None = None, *, at_most: int | None = None
) -> LinearAnalysis | MatrixAnalysis:
    """All that is linear of a study: modes, attachment solutions and the reduced model.

    A mesh is dealt with by all ranks together, matrices by the first one for all.

    Args:
        study: Study.
        comm: Communicator of the mesh.
        stages: Timings and progress.
        at_most: Number of modes in place of that of the study; fewer where the structure has fewer.

    Raises:
        MeshError: if the mesh lacks a group, or contact facets touch the clamp.
        ModelError: if matrices cannot be read or are not of a structure, the body or structure is
            not held, or it cannot be reduced as asked.
        ConvergenceError: if the eigensolver fails or misses a mode.
    """
    stages = stages or Stages()
    if isinstance(study, MatrixStudy):
        analysis = on_root(comm, lambda: _analysis_of_matrices(study, stages, at_most))
        return with_reference(analysis, study)
    return with_reference(_analysis_of_mesh(study, comm, stages, at_most), study)


def with_reference(analysis: Analysis, study: Study) -> Analysis:
    """The analysis, with the reference displacement of points that touch at rest in its model.

    Raises:
        ModelError: if a gap is not positive at full order.
        StudyError: if the reference displacement has no effect.
    """
    reference, rest = study.contact.reference_displacement, analysis.model.at_rest()
    if study.full_order and analysis.model.gap.min() <= 0:
        raise ModelError(
            f"contact.gap = {analysis.model.gap.min():g}: must be positive at full order; gaps of "
            'any sign need reduction.method = "massless"'
        )
    if reference is None:
        return analysis
    if not rest.touching.any():
        raise StudyError(
            f"contact.reference_displacement = {reference:g}: has no effect: no contact point "
            "touches without force at rest"
        )
    model = replace(analysis.model, reference=reference)
    return replace(analysis, reduction=replace(analysis.reduction, model=model))


def _analysis_of_matrices(
    study: MatrixStudy, stages: Stages, at_most: int | None
) -> MatrixAnalysis:
    """Read and reduce matrices of another code."""
    with stages.stage("matrices"):
        K, M, B = (read_matrix(path, name) for path, name in study.matrices.places)
        matrices = Matrices(K, M, B, study.contact.gap)
    chosen = study.reduction
    assert chosen.method != "none"  # refused by the study
    modes = _mode_count(study, at_most, matrices.massive - matrices.massive_points)
    return matrix_analysis(matrices, modes=modes, method=chosen.method, stages=stages)


def _analysis_of_mesh(
    study: MeshStudy, comm: MPI.Comm, stages: Stages, at_most: int | None
) -> LinearAnalysis:
    """Mesh, assemble, find modes and attachment solutions, reduce."""
    with stages.stage("mesh"):
        tagged = tagged_mesh(study, comm)
        clamped, clamps = _clamped_facets(study, tagged), _clamps(study, tagged.dim)
        patches = contact_patches(study.contact, tagged)
    with stages.stage("assembly"):
        solid = assemble_solid(tagged, body_of(study, tagged.dim), clamped, clamps)
        interface = contact_interface(solid, patches)
    with stages.stage("factors"):
        found = _modal_solver(study, solid)
    with found as solver:
        forces = _interface_forces(study, solid, interface)
        count = _mode_count(study, at_most, solver.free - forces.shape[1])
        with stages.stage("modes"):
            modes = solver.modes(count)
        with stages.stage("attachments"):
            if study.reduction.method != "craig-bampton":
                reduction = massless_reduced(solid, interface, modes, solver)
            else:
                assert isinstance(solver, DirectModalSolver)  # the study refuses others
                reduction = craig_bampton_reduced(solid, interface, forces, count, solver)
    return LinearAnalysis(solid, interface, modes, reduction)


def _modal_solver(study: MeshStudy, solid: Solid) -> ModalSolver:
    """The solver of a study; reductions other than the massless one need factors."""
    chosen = study.solver.linear
    if chosen == "auto" and study.reduction.method != "massless":
        chosen = "direct"
    return modal_solver(solid, chosen, study.solver.memory)


def _mode_count(study: Study, at_most: int | None, spanned: int) -> int:
    """Number of modes of a study, or `at_most` of those that hold still at the contact points."""
    if at_most is not None:
        return max(1, min(at_most, spanned))
    modes = study.reduction.modes
    if modes == "auto":
        raise StudyError(
            'reduction.modes = "auto": is not found yet: see fenics_nnm.resolution.auto.choice'
        )
    return modes


def nonlinear_mode(
    study: Study,
    analysis: LinearAnalysis | MatrixAnalysis,
    *,
    flexibility: FlexibilitySource | None = None,
    known: Sequence[BranchPoint] = (),
    on_point: Callable[[BranchPoint], None] = lambda point: None,
    stages: Stages | None = None,
) -> Branch:
    """Follow the nonlinear mode of a study.

    Args:
        study: Study.
        analysis: All that is linear of it.
        flexibility: Residual flexibility of the whole model, for a study of full order.
        known: Points found before.
        on_point: Called with each converged point before the next one is begun.
        stages: Told how far the branch is.
    """
    stages = stages or Stages()
    wanted = _with_beginning(wanted_motions(study), study, analysis)
    span = wanted.stop - wanted.start
    with stages.stage("backbone"):
        return follow(
            analysis.model,
            wanted,
            harmonic_balance(study),
            mode=study.mode.number - 1,
            flexibility=flexibility,
            truncation=analysis.reduction.truncation,
            shooting=study.continuation.shooting,
            known=known,
            on_point=on_point,
            on_progress=lambda place: stages.report((place - wanted.start) / span),
        )


def linear_frequencies(analysis: Analysis) -> Array:
    """Frequencies of the linear modes about the state of rest in Hz, ascending."""
    rest = analysis.model.at_rest()
    closed = bool(rest.closed.any())
    return rest.omega / (2 * np.pi) if closed else np.asarray(analysis.modes.frequencies)


def wanted_motions(study: Study) -> Continuation:
    """Energies or frequencies that a study visits, or the range that it follows a branch in.

    The motion that a branch begins at is not read from its file yet.
    """
    chosen = study.continuation
    if chosen.frequencies:
        over = chosen.frequencies
        return FrequencyContinuation(over.start, over.stop, over.step, report_at=chosen.report_at)
    energies = chosen.energies
    if not chosen.by_arc:
        return EnergyContinuation(
            energies.start, energies.stop, energies.step, report_at=chosen.report_at
        )
    steps = chosen.arc_length or ArcLengthSection()
    predictor = Predictor(steps.predictor)
    return ArcContinuation(
        energies.start,
        energies.stop,
        energies.step if chosen.parameter == "energy" else None,
        report_at=chosen.report_at,
        arc=ArcLength(**{**steps.model_dump(), "predictor": predictor}),
        harmonic=study.mode.harmonic,
    )


def _with_beginning(
    wanted: Continuation, study: Study, analysis: LinearAnalysis | MatrixAnalysis
) -> Continuation:
    """What is wanted, with the motion of an earlier run to begin at, if there is one."""
    chosen = study.continuation.start
    if chosen is None or not isinstance(wanted, ArcContinuation):
        return wanted
    return replace(wanted, begin=beginning(chosen, analysis.model, harmonic_balance(study)))


def harmonic_balance(study: Study) -> HarmonicBalance:
    """How the motions of a study are written in time, and contact is found."""
    return HarmonicBalance(
        harmonics=study.resolution.harmonics,
        samples=study.resolution.samples,
        general=study.mode.series == "general",
        multipliers=_multipliers(study),
    )


def model_in_contact(study: Study, analysis: LinearAnalysis | MatrixAnalysis) -> ReducedModel:
    """The model that the motions of a study obey, R = 0 where contact points carry mass."""
    return contact_model(analysis.model, harmonic_balance(study), full_order=study.full_order)


def _interface_forces(study: MeshStudy, solid: Solid, interface: ContactInterface) -> Array:
    """Unit forces of the interface coordinates that the reduction keeps, shape (n_owned, i)."""
    chosen = study.reduction
    if chosen.method == "craig-bampton" and chosen.interface != "contact":
        return interface.unit_forces_all_directions(solid.owned)
    return interface.unit_forces(solid.owned)


def _multipliers(study: Study) -> MultiplierLoop | None:
    if not study.carries_mass:
        return None
    chosen = study.augmented_lagrangian
    return MultiplierLoop(**chosen.model_dump()) if chosen else MultiplierLoop()


def _clamped_facets(study: MeshStudy, tagged: TaggedMesh) -> Indices:
    """Local facets that are held in all directions."""
    found: list[Indices] = [np.empty(0, dtype=np.int32)]
    for number, clamp in enumerate(study.clamp, start=1):
        if clamp.facets and not clamp.nodes and not clamp.directions:
            found.append(tagged.facets_of(clamp.facets, f"{_clamp_key(study, number)}.facets"))
    return np.unique(np.concatenate(found)).astype(np.int32)


def _clamps(study: MeshStudy, dim: int) -> list[Clamp]:
    """Clamps of nodes, or in some directions."""
    found = []
    for number, clamp in enumerate(study.clamp, start=1):
        if clamp.nodes or clamp.directions:
            axes = tuple(sorted("xyz".index(name) for name in clamp.directions or "xyz"[:dim]))
            key = _clamp_key(study, number)
            found.append(Clamp(key, clamp.facets or (), clamp.nodes or (), axes))
    return found


def _clamp_key(study: MeshStudy, number: int) -> str:
    return "clamp" if len(study.clamp) == 1 else f"clamp[{number}]"
