"""A structure given by the matrices of another code."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from mpi4py import MPI
from scipy import sparse

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.fem.blocks import Data
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.reduction.attached import AttachedPoints
from fenics_nnm.reduction.displacement_basis import DisplacementBasis
from fenics_nnm.reduction.driven import BentModes, DrivenBasis, driven_basis
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.reduction.massless import massless_reduction
from fenics_nnm.reduction.matrices import Matrices
from fenics_nnm.reduction.matrix_analysis import (
    Bent,
    MatrixAnalysis,
    matrix_analysis,
    unbent,
)
from fenics_nnm.reduction.matrix_modes import MatrixSolver
from fenics_nnm.reduction.matrix_terms import Entries, MatrixTerms
from fenics_nnm.reduction.modal_derivatives import (
    Deflection,
    by_triples,
    pairwise,
    with_second_order,
)
from fenics_nnm.reduction.operators import Operators
from fenics_nnm.reduction.reduction import Reduction
from fenics_nnm.stages import Stages
from fenics_nnm.structure.coriolis import Frequencies
from fenics_nnm.structure.damped_rows import DampedRows, rows_of_matrices
from fenics_nnm.structure.driven_linear import DrivenMatrices
from fenics_nnm.structure.driven_matrices import driven_places, unit_rows
from fenics_nnm.structure.first_contact import FirstContact
from fenics_nnm.structure.kinematics_lines import kinematics_lines
from fenics_nnm.structure.matrix_files import read_matrix
from fenics_nnm.structure.mode_count import mode_count
from fenics_nnm.study import MatrixStudy


@dataclass(frozen=True, slots=True)
class MatrixStructure:
    """The matrices of a study; the first rank deals with them for all.

    Attributes:
        study: Study.
    """

    study: MatrixStudy

    @property
    def outline(self) -> None:
        """Nothing: there is no mesh to draw."""

    def linear(self, comm: MPI.Comm, stages: Stages, *, at_most: int | None = None) -> MatrixLinear:
        """As `Structure.linear`."""
        return on_root(comm, self._analysed, stages, at_most)

    def driven(self, comm: MPI.Comm, stages: Stages) -> DrivenMatrices:
        """As `Structure.driven`."""
        return DrivenMatrices(on_root(comm, self._driven, stages))

    def _driven(self, stages: Stages) -> DrivenBasis:
        matrices = self.matrices_at_speed(stages)
        places = driven_places(self.study, matrices, _cubic_springs(self.study, matrices))
        with stages.stage("modes"):
            solver = MatrixSolver(matrices)
            modes = solver.modes(mode_count(self.study, None, matrices.massive))
        if self.study.coriolis:
            _assert_straight(self.study)
            places = places.turning(lambda u: np.asarray(matrices.G @ u), modes.shapes)
        with stages.stage("attachments"):
            return driven_basis(
                self._bent_modes(matrices, modes, solver), places, solver.operators()
            )

    def _bent_modes(
        self, matrices: Matrices, modes: LinearModes, solver: MatrixSolver
    ) -> BentModes:
        """Free modes with second-order kinematics, where the study has terms for it.

        Raises:
            ModelError: if contact points have no flexibility of their own, or a master is no mode.
        """
        if not self.study.matrices.bends:
            return BentModes.straight(modes)
        operators = solver.operators()
        unique = modes.unique(matrices.contact_displacement)
        reduction = massless_reduction(
            unique.omega, unique.shapes, solver.attachments(), matrices.gap, operators
        )
        return BentModes.of(unique, self._bent(matrices)(reduction, operators))

    def damped_rows(self, linear: MatrixAnalysis) -> DampedRows:
        """As `Structure.damped_rows`."""
        springs = _cubic_springs(self.study, linear.matrices)
        places = driven_places(self.study, linear.matrices, springs)
        return rows_of_matrices(linear.modes.shapes, places)

    def matrices_at_speed(self, stages: Stages) -> Matrices:
        """Read the matrices; stiffness and gaps are those at the speed of the study.

        Raises:
            ModelError: if they cannot be read, or are not of a structure.
        """
        with stages.stage("matrices"):
            K, M, B = (read_matrix(path, name) for path, name in self.study.matrices.places)
            return Matrices(self._at_speed(K), M, B, gap_at_speed(self.study), self._gyroscopic())

    def _at_speed(self, K: Any) -> Any:
        """Stiffness at the speed of the study.

        Raises:
            ModelError: if what the speed adds has another shape.
        """
        place = self.study.matrices.further.get("speed_stiffness")
        if place is None:
            return K
        added = read_matrix(*place)
        if added.shape != K.shape:
            raise ModelError(f"speed stiffness has shape {added.shape}: must be {K.shape}")
        speed = self.study.matrices.speed or 0.0
        return sparse.csc_matrix(K) + speed**2 * sparse.csc_matrix(added)

    def _gyroscopic(self) -> Any:
        """Coriolis forces per unit rate at the speed of the study; None without any."""
        place = self.study.matrices.further.get("gyroscopic")
        if place is None:
            return None
        return sparse.csc_matrix(read_matrix(*place)) * (self.study.matrices.speed or 0.0)

    def _terms(self, matrices: Matrices) -> MatrixTerms:
        """What is not linear of the structure."""
        n, points = matrices.size, matrices.points
        shapes = {
            "quadratic_stiffness": (n, n, n),
            "cubic_stiffness": (n, n, n, n),
            "quadratic_rows": (points, n, n),
        }
        given = self.study.matrices.further
        found = [
            Entries.of(key.replace("_", " "), read_matrix(*given[key]), shape)
            if key in given
            else Entries.none(len(shape))
            for key, shape in shapes.items()
        ]
        for key, entries in zip(shapes, found[:2], strict=False):
            entries.assert_potential(key.replace("_", " "), n)
        return MatrixTerms(n, points, *found)

    def _bent(self, matrices: Matrices) -> Bent:
        """What adds second-order kinematics, where the study has terms for it."""
        study = self.study
        if not study.matrices.bends:
            return unbent
        terms = self._terms(matrices)
        masters = np.array(study.matrices.masters or (study.mode.number,)) - 1

        def bent(reduction: Reduction, operators: Operators) -> Reduction:
            deflection = Deflection(
                partial(pairwise, terms.second),
                partial(by_triples, terms.third, operators.inner),
                terms.curvature,
            )
            return with_second_order(reduction, masters, operators, deflection)

        return bent

    def _analysed(self, stages: Stages, at_most: int | None) -> MatrixLinear:
        study, chosen = self.study, self.study.reduction
        matrices = self.matrices_at_speed(stages)
        assert chosen.method != "none"  # refused by the study
        modes = mode_count(study, at_most, matrices.massive - matrices.massive_points)
        points = _cubic_springs(study, matrices)
        found = matrix_analysis(
            matrices,
            modes=modes,
            method=chosen.method,
            points=points,
            bent=self._bent(matrices),
            stages=stages,
        )
        return MatrixLinear(found.matrices, found.modes, found.reduction, found.coriolis)


@dataclass(frozen=True, slots=True)
class MatrixLinear(MatrixAnalysis):
    """An analysis of matrices as all that is linear of a structure, the same on all ranks."""

    @property
    def body(self) -> None:
        """Nothing: there is no mesh."""

    def reduced_to(self, modes: LinearModes, reduction: Reduction) -> MatrixLinear:
        """As `Linear.reduced_to`."""
        return replace(self, modes=modes, reduction=reduction)

    def with_contact(self, study: MatrixStudy) -> MatrixLinear | None:
        """As `Linear.with_contact`: without masters gaps are all that a study says of contact."""
        if study.matrices.bends:
            return None
        matrices = replace(self.matrices, gap=gap_at_speed(study))
        return replace(self, matrices=matrices, reduction=self.reduction.with_gap(matrices.gap))

    def first_contact(self, mode: int) -> FirstContact:
        """As `Linear.first_contact`: each contact row is a contact point."""
        rest = self.model.at_rest()
        energy = float(rest.omega[mode] * rest.amplitude(mode)) ** 2 / 2
        place = f"contact row {rest.first(mode) + 1}"
        return FirstContact(self.model.points, self.model.points, energy, energy, place)

    def frequencies(self) -> Frequencies:
        """As `Linear.frequencies`: matrices are those at speed, which have none unloaded."""
        return Frequencies(gyroscopic=self.coriolis / (2 * np.pi))

    def flexibility(self, harmonics: int) -> None:
        """Nothing: full order is refused by the study."""

    def displacement_basis(self) -> DisplacementBasis:
        """As `Linear.displacement_basis`: each unknown is a node with one component."""
        found = self.reduction
        parts = (found.shapes, found.residual_shapes, found.bent_shapes)
        return DisplacementBasis(*(columns.T[:, :, None] for columns in parts))

    def sizes(self) -> dict[str, Any]:
        """Numbers of unknowns and contact rows."""
        return {"dofs": self.matrices.size, "contact_points": self.matrices.points}

    def data(self) -> Data:
        """Shapes and residual shapes in the order of the unknowns."""
        return Data(
            {
                "basis/shapes": self.reduction.shapes.T,
                "basis/residual_shapes": self.reduction.residual_shapes.T,
                **self._bent_shapes(),
            }
        )

    def _bent_shapes(self) -> dict[str, Array]:
        """Second-order shapes, if there are any."""
        shapes = self.reduction.bent_shapes
        return {"basis/bent_shapes": shapes.T} if shapes.size else {}

    def heading(self) -> list[str]:
        """Matrices and contact rows in words."""
        matrices = self.matrices
        low, high = matrices.gap.min(), matrices.gap.max()
        gaps = f"{low:.4g} m" if low == high else f"{low:.4g} to {high:.4g} m"
        return [
            f"matrices         {matrices.size} unknowns, {matrices.size - matrices.massive} "
            "without mass",
            *kinematics_lines(self.reduction),
            f"contact          {matrices.points} rows, gap {gaps}",
        ]

    def groups(self) -> list[str]:
        """Nothing: matrices have no groups."""
        return []

    def notes(self) -> list[str]:
        """Nothing: matrices are taken as they are."""
        return []

    def largest(self, q: Array, force: Array) -> str:
        """Largest unknown of coordinates in kg^1/2 m and contact forces in N."""
        largest = np.abs(self.reduction.displacement(q, force)).max()
        return f"{largest:.4g} m (rad, if it is a rotation)"

    def warnings(self, study: MatrixStudy, mode: int) -> list[str]:
        """Nothing: matrices say neither how large the body is, nor of what material."""
        return []


def _assert_straight(study: MatrixStudy) -> None:
    """Refuse Coriolis forces of motions that bend in second order.

    Raises:
        ModelError: if they do.
    """
    if study.matrices.bends:
        raise ModelError(
            "matrices.coriolis = true: Coriolis forces of a response are those of linear "
            "kinematics: must be false with terms of second order"
        )


def gap_at_speed(study: MatrixStudy) -> Any:
    """Gaps in m at the speed of a study: one number, or one a contact row."""
    growth = study.contact.gap_growth
    if growth is None:
        return study.contact.gap
    speed = study.matrices.speed or 0.0
    gap, added = np.array(study.contact.gap), speed**2 * np.array(growth)
    if gap.ndim and added.ndim and gap.shape != added.shape:
        raise ModelError(
            f"contact.gap_growth has {added.size} values: must be one number, or one for each of "
            f"the {gap.size} gaps"
        )
    return gap + added


def _cubic_springs(study: MatrixStudy, matrices: Matrices) -> AttachedPoints:
    """Unknowns with cubic springs.

    Raises:
        ModelError: if there is no such unknown.
    """
    rows = unit_rows(matrices, "spring", [each.unknown for each in study.spring])
    return AttachedPoints(rows, np.array([each.cubic for each in study.spring]))
