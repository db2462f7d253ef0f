"""Factorisations that MUMPS has too little workspace for, and options of the user."""

from __future__ import annotations

import logging
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from petsc4py import PETSc

from fenics_nnm.errors import ConvergenceError
from fenics_nnm.fem.factorisation import (
    factorise,
    limited_memory,
    negative_pivots,
    use_fastest,
    use_mumps,
)
from fenics_nnm.processes import environment_of_child

PREFIX = "test_factorisation_"

#: Side of a square grid: its factors are a few times as large as what MUMPS needs otherwise.
SIDE = 20


def grid() -> PETSc.Mat:
    """The five-point Laplacian of a square grid."""
    matrix = PETSc.Mat().createAIJ((SIDE**2, SIDE**2), nnz=5, comm=PETSc.COMM_SELF)
    for row in range(SIDE**2):
        i, j = divmod(row, SIDE)
        matrix[row, row] = 4.0
        for k, m in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
            if 0 <= k < SIDE and 0 <= m < SIDE:
                matrix[row, k * SIDE + m] = -1.0
    matrix.assemble()
    matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    return matrix


def solver(matrix: PETSc.Mat, *, workspace: int | None = None) -> PETSc.KSP:
    """A solver by MUMPS whose first try has `workspace` per cent more than was estimated."""
    ksp = PETSc.KSP().create(matrix.comm)
    ksp.setOptionsPrefix(PREFIX)
    ksp.setOperators(matrix)
    use_mumps(ksp)
    if workspace is not None:
        ksp.getPC().setFactorSetUpSolverType()
        ksp.getPC().getFactorMatrix().setMumpsIcntl(14, workspace)
    return ksp


@contextmanager
def option(name: str, value: Any) -> Iterator[None]:
    options = PETSc.Options(PREFIX)
    options[name] = value
    try:
        yield
    finally:
        options.delValue(name)


def test_workspace_is_doubled_until_it_is_enough(caplog: Any) -> None:
    matrix = grid()
    ksp = solver(matrix, workspace=-90)
    with caplog.at_level(logging.INFO, logger="fenics_nnm"):
        factorise(ksp)
    told = [record.getMessage() for record in caplog.records]
    assert told[:2] == [
        f"MUMPS lacks workspace: once more with ICNTL(14) = {per_cent}" for per_cent in (-80, -60)
    ]
    right, left = matrix.createVecs()
    right.array[:] = np.sin(np.arange(SIDE**2))
    ksp.solve(right, left)
    rest = right - matrix * left
    assert rest.norm() < 1e-12 * right.norm()


def test_limit_of_memory_reserves_no_more_than_a_dense_matrix_can_need() -> None:
    def reserved() -> int:
        status = Path("/proc/self/status").read_text()
        return 1024 * int(status.split("VmSize:")[1].split()[0])

    ksp, before = solver(grid()), reserved()
    with limited_memory(ksp, 2.0**36):
        factorise(ksp)
    assert ksp.getPC().getFactorMatrix().getMumpsIcntl(23) <= (16 * SIDE**4 + 2**30) / 1e6
    assert reserved() - before < 2**31
    ksp.destroy()


def test_workspace_of_the_user_is_not_raised() -> None:
    with (
        option("mat_mumps_icntl_14", -90),
        pytest.raises(ConvergenceError, match=r"MUMPS INFOG\(1\) = -9"),
    ):
        factorise(solver(grid()))


def test_singular_matrix_is_refused_at_once(caplog: Any) -> None:
    matrix = grid()
    matrix.zeroRowsColumns(list(range(SIDE)), diag=0.0)
    with (
        caplog.at_level(logging.INFO, logger="fenics_nnm"),
        pytest.raises(ConvergenceError, match=r"MUMPS INFOG\(1\) = -10"),
    ):
        factorise(solver(matrix))
    assert not caplog.records


def test_other_solver_of_the_user_is_taken() -> None:
    with option("pc_type", "jacobi"), option("ksp_type", "cg"):
        ksp = solver(grid())
        factorise(ksp)
    assert (ksp.getType(), ksp.getPC().getType()) == ("cg", "jacobi")


def fastest(matrix: PETSc.Mat, memory: float | None = None) -> PETSc.KSP:
    ksp = PETSc.KSP().create(matrix.comm)
    ksp.setOptionsPrefix(PREFIX)
    ksp.setOperators(matrix)
    use_fastest(ksp, memory, ())
    return ksp


def test_fastest_factors_of_a_positive_definite_matrix() -> None:
    matrix = grid()
    ksp = fastest(matrix)
    factorise(ksp)
    right, left = matrix.createVecs()
    right.array[:] = np.sin(np.arange(SIDE**2))
    ksp.solve(right, left)
    assert (right - matrix * left).norm() < 1e-12 * right.norm()
    assert negative_pivots(ksp) == 0
    assert fastest(matrix, 2.0**10).getPC().getFactorSolverType() == "mumps"  # which keeps to it
    with option("pc_factor_mat_solver_type", "petsc"):
        assert fastest(matrix).getPC().getFactorSolverType() == "petsc"


def test_fastest_factors_are_those_of_positive_definite_matrices() -> None:
    """CHOLMOD refuses others, MUMPS counts: the Laplacian of the grid has one eigenvalue below 0.1.

    Its lowest ones are 8 sin^2(pi / 42) = 0.045 and 0.111.
    """
    matrix = grid()
    matrix.shift(-0.1)
    ksp = fastest(matrix)
    try:
        factorise(ksp)
    except ConvergenceError as error:
        assert "PETSc error" in str(error)
    else:
        assert negative_pivots(ksp) == 1
    counting = solver(matrix)
    factorise(counting)
    assert negative_pivots(counting) == 1


SETTINGS = """
from conftest import BEAM
from mpi4py import MPI
from pathlib import Path
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import study_from
linear_analysis(study_from(dict(BEAM), Path("study.toml")), MPI.COMM_SELF)
"""


def test_options_of_the_user_win() -> None:
    given = "-nnm_st_mat_mumps_icntl_7 0 -nnm_inertia_mat_mumps_icntl_7 0"
    ended = subprocess.run(
        [sys.executable, "-c", SETTINGS],
        env=environment_of_child(PETSC_OPTIONS=f"{given} -nnm_st_ksp_view -options_left"),
        cwd=Path(__file__).parents[1],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "nnm_st_" in ended.stdout
    assert "There are no unused options" in ended.stdout
