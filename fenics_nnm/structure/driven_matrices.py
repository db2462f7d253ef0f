"""Places of matrices of another code where forces act, and their damping."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.moving_gap import STILL, GapMotion
from fenics_nnm.reduction.attached import AttachedPoints
from fenics_nnm.reduction.driven import DrivenPlaces
from fenics_nnm.reduction.matrices import Matrices
from fenics_nnm.structure.matrix_files import read_matrix
from fenics_nnm.study import MatrixStudy

#: Parts of the largest entry of a matrix that are round-off of the program that wrote it.
_ROUND_OFF = 1e-8

#: Size up to which all eigenvalues of a damping matrix are looked at.
_LARGEST_DENSE = 1500


def driven_places(study: MatrixStudy, matrices: Matrices, springs: AttachedPoints) -> DrivenPlaces:
    """Where the matrices of a study are driven, damped and watched.

    Raises:
        ModelError: if there is no such unknown, or the damping matrix does not fit.
    """
    forces = np.array([each.force for each in study.excitation])
    excited = unit_rows(matrices, "excitation", [each.unknown for each in study.excitation])
    dampers = unit_rows(matrices, "dashpot", [each.unknown for each in study.dashpot])
    values = np.array([each.damping for each in study.dashpot])
    matrix = _damping_matrix(study, matrices)
    return DrivenPlaces(
        springs=springs,
        excited=excited * np.sign(forces),
        sizes=np.abs(forces),
        monitored=unit_rows(matrices, "monitor", [each.unknown for each in study.monitor]),
        dampers=dampers,
        contact=matrices.forces,
        gap=matrices.gap,
        damping=lambda u: matrix @ u + dampers @ (values[:, None] * (dampers.T @ u)),
        gap_motion=_gap_motion(study, matrices.points),
    )


def _gap_motion(study: MatrixStudy, points: int) -> GapMotion:
    """How gaps move, in harmonics of the speed.

    Raises:
        ModelError: if a list has another length than there are contact rows.
    """
    sections = study.contact.gap_motion
    for number, each in enumerate(sections, start=1):
        for key in ("amplitude", "phase_deg"):
            size = np.size(getattr(each, key))
            if size not in (1, points):
                raise ModelError(
                    f"contact.gap_motion[{number}].{key}: has {size} numbers: must have one, or "
                    f"{points}, one a contact row"
                )
    if not sections:
        return STILL
    turns = [np.exp(1j * np.deg2rad(each.phase_deg)) for each in sections]
    amplitudes = [
        np.broadcast_to(np.array(each.amplitude) * turn, (points,))
        for each, turn in zip(sections, turns, strict=True)
    ]
    return GapMotion(study.contact.passing_orders, np.array(amplitudes))


def _damping_matrix(study: MatrixStudy, matrices: Matrices) -> sparse.csr_matrix:
    """The damping matrix of a study; zero without one.

    Raises:
        ModelError: if it cannot be read, has another size, or entries that are not finite.
    """
    size, place = matrices.size, study.damping.place if study.damping else None
    if place is None:
        return sparse.csr_matrix((size, size))
    found = read_matrix(*place)
    if found.shape != (size, size):
        raise ModelError(f"damping matrix has shape {found.shape}: must be {(size, size)}")
    matrix = sparse.csr_matrix(found)
    if matrix.dtype.kind not in "biuf" or not np.all(np.isfinite(matrix.data)):
        raise ModelError("damping matrix has entries that are not finite real numbers")
    largest = abs(matrix).max()
    lowest = _lowest_damping(matrix)
    if lowest < -_ROUND_OFF * largest:
        raise ModelError(
            f"damping matrix: its symmetric part has an eigenvalue of {lowest:g} or "
            "less: must have none below zero, or it feeds motions"
        )
    return matrix


def _lowest_damping(matrix: sparse.csr_matrix) -> float:
    """The lowest eigenvalue of the symmetric part; of a large matrix a bound of it from above.

    This part alone does work; its lowest eigenvalue lies at or below the lowest diagonal entry.
    """
    if matrix.shape[0] > _LARGEST_DENSE:
        return float(matrix.diagonal().min())
    return float(np.linalg.eigvalsh((matrix + matrix.T).toarray() / 2)[0])


def unit_rows(matrices: Matrices, section: str, unknowns: list[int]) -> Array:
    """Unit forces at unknowns, counted from 1, of several sections, shape (n, p)."""
    rows = np.zeros((matrices.size, len(unknowns)))
    for number, unknown in enumerate(unknowns, start=1):
        if unknown > matrices.size:
            raise ModelError(
                f"{section}[{number}].unknown = {unknown}: must not be above "
                f"{matrices.size}, the number of unknowns of the stiffness"
            )
        rows[unknown - 1, number - 1] = 1.0
    return rows
