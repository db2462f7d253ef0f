"""Reduced models from matrices of another code."""

from pathlib import Path

import numpy as np
import pytest
from scipy import sparse
from scipy.io import mmwrite, savemat

from fenics_nnm.errors import ModelError
from fenics_nnm.nonlinear.continuation import EnergyContinuation, follow
from fenics_nnm.nonlinear.levels import HarmonicBalance
from fenics_nnm.reduction.matrices import massless_from_matrices, read_matrix

ELEMENTS = 60


@pytest.fixture
def rod() -> tuple[sparse.csc_matrix, sparse.csc_matrix, np.ndarray]:
    """Linear elements of a clamped-free rod of unit length, E A and rho A."""
    size = 1 / ELEMENTS
    diagonal = np.r_[np.full(ELEMENTS - 1, 2.0), 1.0]
    off = np.ones(ELEMENTS - 1)
    K = sparse.diags([-off, diagonal, -off], [-1, 0, 1], format="csc") / size
    M = sparse.diags([off, 2 * diagonal, off], [-1, 0, 1], format="csc") * size / 6
    B = np.zeros((1, ELEMENTS))
    B[0, -1] = 1.0
    return K, M, B


def test_model_of_a_rod(rod: tuple) -> None:
    model = massless_from_matrices(*rod, [1.0], modes=5)
    exact = (2 * np.arange(1, 6) - 1) * np.pi / 2
    np.testing.assert_allclose(model.omega, exact, rtol=3e-3)
    np.testing.assert_allclose(model.Phi[0], np.sqrt(2), rtol=5e-3)
    static = model.R[0, 0] + np.sum((model.Phi / model.omega) ** 2)
    assert static == pytest.approx(1.0, rel=1e-10)  # L / E A


def test_branch_of_matrices_hardens(rod: tuple) -> None:
    model = massless_from_matrices(*rod, [1.0], modes=3)
    branch = follow(model, EnergyContinuation(1.4, 1.8, 0.1), HarmonicBalance(3, 64), mode=0)
    assert branch.complete
    # the exact rod: 1.1026 at 1.8; three harmonics of three modes are about 1 % high
    assert branch.points[-1].frequency_ratio == pytest.approx(1.1026, rel=0.02)


def test_files_give_the_same_matrix(rod: tuple, tmp_path: Path) -> None:
    K, M, _ = rod
    mmwrite(tmp_path / "K.mtx", K)
    savemat(tmp_path / "rod.mat", {"K": K, "M": M})
    np.savez(tmp_path / "rod.npz", K=K.toarray(), M=M.toarray())
    sparse.save_npz(tmp_path / "K.npz", K)
    np.save(tmp_path / "K.npy", K.toarray())
    read = [
        read_matrix(tmp_path / "K.mtx"),
        read_matrix(tmp_path / "rod.mat", "K"),
        read_matrix(tmp_path / "rod.npz", "K"),
        read_matrix(tmp_path / "K.npz"),
        read_matrix(tmp_path / "K.npy"),
    ]
    for matrix in read:
        np.testing.assert_allclose(sparse.csc_matrix(matrix).toarray(), K.toarray())


def test_missing_matrix_is_named(tmp_path: Path) -> None:
    np.savez(tmp_path / "rod.npz", K=np.eye(2), M=np.eye(2))
    with pytest.raises(ModelError, match='no matrix "C"; it has K, M'):
        read_matrix(tmp_path / "rod.npz", "C")
    with pytest.raises(ModelError, match=r"must be a \.mtx"):
        read_matrix(tmp_path / "rod.txt")
    with pytest.raises(ModelError, match="cannot be read"):
        read_matrix(tmp_path / "none.mtx")


def test_matrices_that_do_not_fit_are_refused(rod: tuple) -> None:
    K, M, B = rod
    with pytest.raises(ModelError, match=r"M has shape \(59, 59\): must be \(60, 60\)"):
        massless_from_matrices(K, M[:-1, :-1], B, [1.0], modes=3)
    with pytest.raises(ModelError, match="K is not symmetric"):
        massless_from_matrices(sparse.triu(K), M, B, [1.0], modes=3)
    with pytest.raises(ModelError, match="contact rows have 59 columns"):
        massless_from_matrices(K, M, B[:, :-1], [1.0], modes=3)
    with pytest.raises(ModelError, match="modes = 60: must be at least 1 and below 60"):
        massless_from_matrices(K, M, B, [1.0], modes=60)


def test_a_free_structure_is_refused() -> None:
    K = np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    with pytest.raises(ModelError, match="not held"):
        massless_from_matrices(K, np.eye(3), [[0.0, 0.0, 1.0]], [1.0], modes=2)
