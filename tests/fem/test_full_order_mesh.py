"""Full order on meshes: against dense matrices, against the reduced models, and the rotor blade."""

from pathlib import Path

import numpy as np
import pytest
from conftest import PLATE, ROD, changed
from mpi4py import MPI
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.follow import Branch, EnergyContinuation, FullOrder, ReducedOrder, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.fem.harmonic import HarmonicSolver
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import read_study, study_from

ROTOR37 = Path(__file__).parents[2] / "demos" / "rotor37" / "rotor37.toml"
BALANCE = HarmonicBalance(5, 128)


def plate(**reduction: object) -> LinearAnalysis:
    study = changed(PLATE, {"reduction": {"modes": 4, **reduction}})
    return linear_analysis(study_from(study, Path("study.toml")), MPI.COMM_SELF)


def rotor37(modes: int) -> LinearAnalysis:
    """The blade of NASA rotor 37 on a coarse mesh."""
    study = read_study(ROTOR37)
    coarse = study.mesh.model_copy(update={"element_size": 0.006})
    reduction = study.reduction.model_copy(update={"modes": modes})
    changes = {"mesh": coarse, "reduction": reduction}
    return linear_analysis(study.model_copy(update=changes), MPI.COMM_SELF)


def followed(analysis: LinearAnalysis, *, full: bool = False, stop: float = 2.0) -> Branch:
    energies = EnergyContinuation(1.0, stop, 0.2)
    if not full:
        order = ReducedOrder(analysis.reduction.truncation)
        return follow(analysis.model, energies, BALANCE, mode=0, order=order)
    with HarmonicSolver(analysis, harmonics=5) as flexibility:
        order = FullOrder(flexibility)
        return follow(analysis.model, energies, BALANCE, mode=0, order=order)


def dense(matrix: PETSc.Mat) -> Array:
    copy = matrix.convert("dense", out=PETSc.Mat())
    return np.array(copy.getDenseArray())


def test_flexibility_against_dense_matrices() -> None:
    analysis = plate()
    K, M = dense(analysis.solid.stiffness), dense(analysis.solid.mass)
    B = analysis.interface.unit_forces(analysis.solid.owned).T
    model = analysis.model
    first = model.omega[0]
    with HarmonicSolver(analysis, harmonics=5) as solver:
        for omega in (1e-3 * first, 1.07 * first, model.omega[1] / 2, model.omega[1]):
            D, slope, _ = solver(omega).at(omega)
            for n in range(6):
                s = (n * omega) ** 2
                if min(abs(s / model.omega**2 - 1)) < 1e-6:
                    continue  # the dense inverse is singular, the solver's is not
                G = B @ np.linalg.solve(K - s * M, B.T)
                modal = (model.Phi / (model.omega**2 - s)) @ model.Phi.T
                scale = np.abs(model.R).max()
                assert np.abs(D[n] - (G - modal - model.R)).max() < 1e-8 * scale
                assert np.allclose(D[n], D[n].T)
            step = 1e-4 * omega
            ends = [solver(omega).at(omega + sign * step)[0] for sign in (1, -1)]
            growth = 2 * np.arange(6)[:, None, None] ** 2 * omega
            difference = (ends[0] - ends[1]) / (2 * step)
            assert np.abs(slope * growth - difference).max() < 1e-6 * np.abs(slope * growth).max()


def test_coarse_rod_at_its_own_frequency_has_a_full_order_branch() -> None:
    """Of 9 unknowns the harmonic equations of the linear motion are singular to the last digit."""
    mesh = {"model": "rod", "length": 1.0, "elements": 4}
    study = changed(ROD, {"mesh": {"=": mesh}, "body": {"degree": 2}, "reduction": {"modes": 2}})
    analysis = linear_analysis(study_from(study, Path("study.toml")), MPI.COMM_SELF)
    first = analysis.model.omega[0]
    with HarmonicSolver(analysis, harmonics=2) as solver:
        at, beside = (solver(omega).at(omega)[0] for omega in (first, first * (1 + 1e-5)))
        assert solver.factorisations == 2
    np.testing.assert_allclose(at, beside, rtol=1e-4)


def test_harmonics_are_factorised_again_only_where_the_frequency_moved() -> None:
    analysis = plate()
    omega = 1.05 * analysis.model.omega[0]
    with HarmonicSolver(analysis, harmonics=5) as solver:
        solver(omega)
        first = solver.factorisations
        assert 0 < first <= 5
        solver(omega)
        solver(omega * (1 + 1e-9))
        assert solver.factorisations == first
        solver(1.5 * omega)
        assert first < solver.factorisations <= 2 * first


def residual_norm(analysis: LinearAnalysis, point: BranchPoint, U: Array) -> float:
    """Of Z_n U_n + B^T lambda_n in the norm of K^-1, over sqrt(k^), with dense matrices."""
    K, M = dense(analysis.solid.stiffness), dense(analysis.solid.mass)
    forces = analysis.interface.unit_forces(analysis.solid.owned)
    ell = BALANCE.series.analysis @ point.motion.force
    omega, total = 2 * np.pi * point.motion.frequency, 0.0
    for n, weight in enumerate(BALANCE.series.mean_square):
        residual = (K - (n * omega) ** 2 * M) @ U[n] + forces @ ell[n]
        total += weight * residual @ np.linalg.solve(K, residual)
    stiffness = (
        point.motion.energy
        / (1 + (point.motion.frequency / point.motion.rayleigh_frequency) ** 2)
        * 2
    )
    return float(np.sqrt(total / stiffness))


@pytest.mark.parametrize("method", ["massless", "craig-bampton"])
def test_residual_of_the_reconstructed_motion(method: str) -> None:
    analysis = plate(method=method)
    point = followed(analysis, stop=1.4).points[-1]
    ell = BALANCE.series.analysis @ point.motion.force
    U = point.motion.q @ analysis.reduction.shapes.T - ell @ analysis.reduction.residual_shapes.T
    assert point.expected.reduction.residual > 1e-5
    assert point.expected.reduction.residual == pytest.approx(
        residual_norm(analysis, point, U), rel=1e-6
    )


def test_motion_of_full_order_has_no_residual() -> None:
    analysis = plate()
    point = followed(analysis, full=True, stop=1.4).points[-1]
    ell = BALANCE.series.analysis @ point.motion.force
    U = point.motion.q @ analysis.reduction.shapes.T - ell @ analysis.reduction.residual_shapes.T
    without = residual_norm(analysis, point, U)
    with HarmonicSolver(analysis, harmonics=5) as solver:
        U -= solver.inertial_displacement(
            2 * np.pi * point.motion.frequency, BALANCE.series.order, ell
        )
    assert residual_norm(analysis, point, U) < 1e-6 * without


def test_rotor37_reduced_models_converge_to_full_order_as_predicted() -> None:
    """Frequency ratio within 0.1 % at J = 40; the difference falls about like J^-2."""
    worst = []
    for modes in (10, 20, 40):
        analysis = rotor37(modes)
        reduced, full = followed(analysis), followed(analysis, full=True)
        assert reduced.complete
        assert full.complete
        errors = []
        for point, exact in list(zip(reduced.points, full.points, strict=True))[1:]:
            error = point.frequency_ratio / exact.frequency_ratio - 1
            errors.append(abs(error))
            assert 0.1 < point.expected.reduction.frequency / error < 10
            assert point.expected.reduction.frequency == pytest.approx(error, rel=0.05)
            assert exact.balance.virial_error < 1e-8
            assert exact.balance.complementarity < 1e-10
            assert exact.status in ("verified", "converged")
        worst.append(max(errors))
    assert worst[-1] < 1e-3
    assert worst[0] > worst[1] > worst[2]
    assert np.log(worst[0] / worst[2]) / np.log(4) > 1.5
