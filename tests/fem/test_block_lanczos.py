"""Block Lanczos against dense eigenvalues: small, many equal, negative, wide apart; restarts."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.linalg import block_diag, eigh

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ConvergenceError
from fenics_nnm.fem import block_lanczos
from fenics_nnm.fem.block_lanczos import BLOCK, BlockLanczos


class Dense:
    """K^-1 and M of dense matrices."""

    def __init__(self, K: Array, M: Array) -> None:
        self.K, self.M, self.generator = K, M, np.random.default_rng(0)
        self.solved = 0

    def solve(self, forces: Array) -> Array:
        self.solved += forces.shape[1]
        return np.asfortranarray(np.linalg.solve(self.K, forces))

    def mass(self, columns: Array) -> Array:
        return np.asfortranarray(self.M @ columns)

    def inner(self, left: Array, right: Array) -> Array:
        return left.T @ right

    def random(self, count: int) -> Array:
        return self.generator.standard_normal((len(self.K), count))


def chain(size: int, stiffness: float = 1e9, mass: float = 2e-3) -> tuple[Array, Array]:
    """Masses in a row, held at one end; the masses grow along it."""
    K = 2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1)
    K[-1, -1] = 1
    return K * stiffness, np.diag(mass * np.linspace(1, 2, size))


def found(K: Array, M: Array, count: int) -> tuple[BlockLanczos, Dense]:
    dense = Dense(K, M)
    lanczos = BlockLanczos(dense, len(K), len(K), count, 4)
    lanczos.run()
    return lanczos, dense


def assert_modes(lanczos: BlockLanczos, K: Array, M: Array, count: int) -> None:
    exact = eigh(K, M, eigvals_only=True)
    exact = exact[np.argsort(np.abs(exact), kind="stable")][:count]
    np.testing.assert_allclose(1 / lanczos.theta[:count], exact, rtol=1e-11)
    X = lanczos.shapes(count)
    np.testing.assert_allclose(X.T @ M @ X, np.eye(count), atol=1e-11)
    np.testing.assert_allclose(X.T @ K @ X, np.diag(exact), atol=1e-10 * np.abs(exact).max())


@pytest.mark.parametrize("size", [1, 2, BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK + 1, 40, 200])
def test_lowest_modes_of_a_chain(size: int) -> None:
    count = min(5, size)
    K, M = chain(size)
    lanczos, _ = found(K, M, count)
    assert_modes(lanczos, K, M, count)


def test_all_modes_of_a_body_are_found() -> None:
    K, M = chain(30)
    assert_modes(found(K, M, 30)[0], K, M, 30)


def test_few_columns_are_solved_for() -> None:
    _, dense = found(*chain(400), 40)
    assert dense.solved <= 4 * 44 + BLOCK


def test_a_full_basis_is_restarted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(block_lanczos, "_ROOM", 2)
    K, M = chain(200)
    lanczos, dense = found(K, M, 20)
    assert dense.solved > 2 * 24 + 2 * BLOCK + BLOCK  # columns that the basis has room for
    assert_modes(lanczos, K, M, 20)


def test_more_modes_of_one_frequency_than_a_block_has_columns() -> None:
    """The first search finds one of each for each column; the next ones find the others."""
    K, M = (block_diag(*[each] * 20) for each in chain(12))
    lanczos, _ = found(K, M, 30)
    for _ in range(2):
        lanczos.search_again(lanczos.settled(34))
    exact = eigh(K, M, eigvals_only=True)[:30]
    np.testing.assert_allclose(1 / lanczos.theta[:30], exact, rtol=1e-11)
    assert exact[19] == pytest.approx(exact[0])  # twenty modes of one frequency


def test_negative_stiffness_is_found() -> None:
    K, M = chain(60)
    K -= 0.5 * (eigh(K, M, eigvals_only=True)[1] + eigh(K, M, eigvals_only=True)[0]) * M
    lanczos, _ = found(K, M, 6)
    assert lanczos.theta.min() < 0
    assert_modes(lanczos, K, M, 6)


def test_masses_of_very_different_size() -> None:
    K, M = chain(80)
    M[np.diag_indices(80)] *= np.logspace(0, -5, 80)
    assert_modes(found(K, M, 12)[0], K, M, 12)


@pytest.mark.parametrize("bad", [lambda K: K * np.nan, lambda K: K * 1e-300])
def test_numbers_that_are_too_far_apart_are_refused(bad: Callable[[Array], Array]) -> None:
    K, M = chain(20)
    with np.errstate(all="ignore"), pytest.raises(ConvergenceError, match="too far apart"):
        found(bad(K), M, 3)


def test_no_convergence_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(block_lanczos, "_BLOCKS", 2)
    with pytest.raises(ConvergenceError, match="of 20 modes converged in 2 blocks"):
        found(*chain(400), 20)
