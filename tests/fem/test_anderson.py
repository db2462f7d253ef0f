"""Accelerated steps with one stiffness, and the least ratio of two stiffnesses."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from mpi4py import MPI
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.fem.anderson import Anderson
from fenics_nnm.fem.block import solved
from fenics_nnm.fem.factorisation import factorise, use_mumps
from fenics_nnm.fem.least_ratio import least_ratio


def test_a_linear_problem_ends_after_as_many_steps_as_it_has_eigenvalues() -> None:
    """As GMRES does: without acceleration x + g(x) diverges here."""
    ratios = np.array([0.2, 1.0, 1.0, 1.0, 3.5])
    wanted, x, faster = np.arange(1.0, 6.0), np.zeros(5), Anderson(MPI.COMM_SELF)
    for _ in range(4):
        x = faster.following(x, ratios * (wanted - x))
    assert x == pytest.approx(wanted, rel=1e-10)


@pytest.mark.parametrize(("lowest", "found"), [(0.3, 0.3), (-0.02, -0.02)])
def test_least_ratio(lowest: float, found: float) -> None:
    """Of diagonal matrices whose ratios are one but for a few."""
    ratios = np.r_[lowest, 0.6, 1.7, np.linspace(0.97, 1.03, 97)]
    stiffness = np.linspace(1.0, 50.0, 100)
    ksp = PETSc.KSP().create(MPI.COMM_SELF)
    ksp.setOperators(_diagonal(stiffness))
    use_mumps(ksp)
    factorise(ksp)
    least = least_ratio(_diagonal(ratios * stiffness), partial(solved, ksp))
    assert found - 0.1 * abs(found) <= least <= found / 2 + abs(found) / 2
    ksp.destroy()


def test_a_bound_that_is_enough_ends_the_search() -> None:
    """It is a bound still: what is above it is positive definite, what is not is searched on."""
    spread = np.linspace(0.5, 2.5, 400)
    ksp = PETSc.KSP().create(MPI.COMM_SELF)
    ksp.setOperators(_diagonal(np.ones(400)))
    use_mumps(ksp)
    factorise(ksp)
    solve = partial(solved, ksp)
    closer, enough = (least_ratio(_diagonal(spread), solve, each) for each in (np.inf, 0.2))
    assert 0.2 < enough < closer <= 0.5
    soft = np.r_[0.15, spread[1:]]
    assert 0.15 * 0.9 <= least_ratio(_diagonal(soft), solve, 0.2) <= 0.15
    ksp.destroy()


def _diagonal(values: Array) -> PETSc.Mat:
    rows = np.arange(len(values) + 1, dtype=np.int32)
    matrix = PETSc.Mat().createAIJ((len(values),) * 2, csr=(rows, rows[:-1], values))
    matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    return matrix
