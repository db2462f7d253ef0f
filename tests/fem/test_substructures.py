"""Factors of the parts of several ranks solve as those of the whole do."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpi4py import MPI
from ranks import on_ranks
from scipy.sparse import csr_matrix

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ConvergenceError
from fenics_nnm.fem import cholesky
from fenics_nnm.fem.cholesky import Cholesky
from fenics_nnm.fem.substructures import _with_end

SCRIPT = Path(__file__).parents[1] / "substructures_on_ranks.py"


def grid(size: int) -> Array:
    """Stiffness of a grid of springs, some stiffer than others, shape (size^2, size^2)."""
    chain = 2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1)
    across = np.diag(np.linspace(1.0, 3.0, size))
    return np.kron(chain, across) + np.kron(np.eye(size), chain)


def factors(matrix: Array, inner: int) -> Cholesky:
    code = cholesky.kernel(MPI.COMM_SELF)
    assert code is not None, "cholesky.c cannot be compiled, and several ranks take longer"
    return Cholesky(code, *_with_end(csr_matrix(matrix[:inner]), matrix[inner:, inner:]))


def test_factors_are_those_of_the_matrix_with_its_end_last() -> None:
    K, inner = grid(12), 130
    found = factors(K, inner)
    order = found.order
    assert sorted(order) == list(range(144)) and min(order[inner:]) == inner
    L = np.linalg.cholesky(K[np.ix_(order, order)])
    assert found.last(14) == pytest.approx(L[inner:, inner:], abs=1e-12)
    columns = np.asfortranarray(np.sin(np.arange(432.0)).reshape(144, 3))
    forces = columns.copy(order="F")
    found.forward(columns)
    assert columns == pytest.approx(np.linalg.solve(L, forces), abs=1e-12)
    found.backward(columns)
    assert columns == pytest.approx(np.linalg.solve(L @ L.T, forces), abs=1e-11)
    found.release()


def test_an_end_has_all_entries_of_its_block() -> None:
    K = grid(5)
    starts, columns, values = _with_end(csr_matrix(K[:20]), K[20:, 20:])
    found = csr_matrix((values, columns, starts)).toarray()
    assert found[:20] == pytest.approx(K[:20])
    assert found[20:, 20:] == pytest.approx(K[20:, 20:]) and not found[20:, :20].any()
    assert np.diff(starts)[20:].tolist() == [5] * 5


def test_more_entries_than_cholmod_counts_are_refused() -> None:
    code = cholesky.kernel(MPI.COMM_SELF)
    assert code is not None
    with pytest.raises(ConvergenceError, match="2147483648 entries"):
        Cholesky(code, np.array([0, 2**31]), np.zeros(1), np.ones(1))


def test_a_matrix_that_is_not_definite_has_no_factors() -> None:
    with pytest.raises(ConvergenceError, match="no factors"):
        factors(grid(6) - 1.5 * np.eye(36), 30)


def test_a_kernel_that_cannot_be_compiled_is_none_and_says_why(
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    capfd: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    wrong = tmp_path / "cholesky.c"
    wrong.write_text("#include <no_cholmod.h>\n")
    monkeypatch.setattr(cholesky, "_SOURCE", wrong)
    monkeypatch.setattr(cholesky.jit, "get_options", lambda: {"cache_dir": tmp_path / "kept"})
    with caplog.at_level("INFO", logger="fenics_nnm"):
        assert cholesky.kernel(MPI.COMM_SELF) is None
    assert "cholesky.c cannot be compiled, MUMPS factorises: " in caplog.text
    assert "no_cholmod.h" in caplog.text and "no_cholmod.h" not in capfd.readouterr().err
    assert not list((tmp_path / "kept").iterdir())


@pytest.mark.parametrize("change", ["damaged", "version"])
def test_a_kernel_that_does_not_go_with_cholmod_is_compiled_again(
    change: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    """As after a new CHOLMOD, which has other records, or another file."""
    monkeypatch.setattr(cholesky.jit, "get_options", lambda: {"cache_dir": tmp_path})
    place = cholesky._place()
    if change == "damaged":
        place.write_bytes(b"no library")
    else:
        other = tmp_path / "other.c"
        other.write_text(
            cholesky._SOURCE.read_text().replace("return version[0] ==", "return 9 ==")
        )
        with monkeypatch.context() as before:
            before.setattr(cholesky, "_SOURCE", other)
            before.setattr(cholesky, "_loaded", lambda path: None)
            cholesky._compiled(place)
    with caplog.at_level("INFO", logger="fenics_nnm"):
        code = cholesky.kernel(MPI.COMM_SELF)
    assert code is not None and code.lib.nnm_fits()
    assert "cholesky.c is compiled again" in caplog.text
    assert [path.name for path in tmp_path.glob("nnm_*")] == [place.name]


@pytest.fixture(scope="module", params=[2, 3])
def found(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder = tmp_path_factory.mktemp("ranks")
    ended = on_ranks(request.param, SCRIPT, "found.json", folder=folder)
    assert ended.code == 0, ended.err
    return json.loads((folder / "found.json").read_text())


def test_solutions_have_no_residual(found: dict[str, Any]) -> None:
    """Forces are of the order of one; the work is that of MUMPS's solution on one rank."""
    assert found["shared"] > 0
    assert found["residual"] < 1e-9
    assert found["work"] == pytest.approx(2014.964245903, rel=1e-10)


def test_modes_and_states_are_those_of_mumps(found: dict[str, Any]) -> None:
    assert (found["kind"], found["kind without"]) == ("Substructures", "Ordered")
    assert found["omega"] == pytest.approx(found["omega without"], rel=1e-11)
    assert found["solvers of the state"] == 1
    assert found["state"] == pytest.approx(found["state without"], rel=1e-9)


def test_others_factorise_where_substructures_cannot(found: dict[str, Any]) -> None:
    for reason in (
        "indefinite",
        "little memory",
        "little memory beside factors",
        "no memory on one rank",
        "large interface",
        "no compiler",
    ):
        assert found[reason], reason
