"""Structures given by matrices: closed forms, both reductions, and matrices that cannot be."""

from typing import Any

import numpy as np
import pytest
from scipy import sparse

from fenics_nnm.backbone.follow import EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.errors import ConvergenceError, ModelError
from fenics_nnm.reduction import matrix_modes
from fenics_nnm.reduction.matrices import Matrices
from fenics_nnm.reduction.matrix_analysis import MatrixAnalysis, matrix_analysis

METHODS = ["massless", "craig-bampton"]


def rod_matrices(elements: int) -> tuple[Any, Any, np.ndarray]:
    """Linear elements of a clamped-free rod of unit length, E A and rho A."""
    size = 1 / elements
    diagonal = np.r_[np.full(elements - 1, 2.0), 1.0]
    off = np.ones(elements - 1)
    K = sparse.diags([-off, diagonal, -off], [-1, 0, 1], format="csc") / size
    M = sparse.diags([off, 2 * diagonal, off], [-1, 0, 1], format="csc") * size / 6
    B = np.zeros((1, elements))
    B[0, -1] = 1.0
    return K, M, B


def rod(elements: int = 60, modes: int = 5, **options: Any) -> MatrixAnalysis:
    return matrix_analysis(Matrices(*rod_matrices(elements), 1.0), modes=modes, **options)


def static_flexibility(analysis: MatrixAnalysis) -> np.ndarray:
    scaled = analysis.model.Phi / analysis.model.omega
    return scaled @ scaled.T + analysis.model.R


def test_rod_has_the_odd_multiples_of_a_quarter_wave() -> None:
    exact = (2 * np.arange(1, 6) - 1) * np.pi / 2
    for elements, tolerance in ((60, 3e-3), (4000, 1e-6)):
        model = rod(elements).model
        np.testing.assert_allclose(model.omega, exact, rtol=tolerance)
        np.testing.assert_allclose(model.Phi[0], np.sqrt(2), rtol=2 * tolerance)


def test_frequencies_are_those_of_the_discrete_rod() -> None:
    """The eigenvalues of linear elements are known: 6 (1 - c) / (2 + c) / h^2."""
    for elements in (60, 4000):
        c = np.cos((2 * np.arange(1, 6) - 1) * np.pi / 2 / elements)
        exact = elements * np.sqrt(6 * (1 - c) / (2 + c))
        np.testing.assert_allclose(rod(elements).modes.omega, exact, rtol=2e-8)


@pytest.mark.parametrize("elements", [60, 4000])
@pytest.mark.parametrize("method", METHODS)
def test_static_flexibility_is_exact(elements: int, method: str) -> None:
    analysis = rod(elements, method=method)
    assert static_flexibility(analysis)[0, 0] == pytest.approx(1.0, rel=1e-8)  # L / E A
    # a unit force on the whole structure: the displacement is x / E A
    reduction = analysis.reduction
    q = -reduction.model.Phi[0] / reduction.model.omega**2
    x = np.arange(1, elements + 1) / elements
    moved = -reduction.displacement(q, np.array([1.0]))
    np.testing.assert_allclose(moved, x, atol=1e-8)


@pytest.mark.parametrize("elements", [60, 1000])
def test_craig_bampton_holds_the_end_and_comes_from_above(elements: int) -> None:
    """With the end held the rod has the frequencies n pi; the basis is theirs and one static."""
    K, M, B = rod_matrices(elements)
    solver = matrix_modes.MatrixSolver(Matrices(K, M, B, 1.0))
    held = solver.held_modes(solver.attachments(), 4)
    assert np.abs(B @ held).max() < 1e-9 * np.abs(held).max()
    squared = np.einsum("ij,ij->j", held, K @ held)
    np.testing.assert_allclose(np.sqrt(squared), np.arange(1, 5) * np.pi, rtol=2e-3)
    analysis = rod(elements, modes=4, method="craig-bampton")
    assert analysis.model.modes == 5 and not analysis.model.R.any()
    above = analysis.model.omega[:3] / analysis.modes.omega[:3] - 1
    assert above.min() > -1e-9 and above.max() < 0.02


@pytest.mark.parametrize("method", METHODS)
def test_dense_and_sparse_ways_agree(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    dense = rod(120, method=method)
    monkeypatch.setattr(matrix_modes, "_DENSE", 10)
    iterated = rod(120, method=method)
    np.testing.assert_allclose(iterated.model.omega, dense.model.omega, rtol=1e-9)
    np.testing.assert_allclose(iterated.model.Phi, dense.model.Phi, rtol=1e-6)
    np.testing.assert_allclose(iterated.model.R, dense.model.R, rtol=1e-6, atol=1e-12)
    assert iterated.modes.checked_below == pytest.approx(dense.modes.checked_below, rel=1e-9)


def test_dense_arrays_and_lists_are_taken_too() -> None:
    K, M, B = rod_matrices(60)
    plain = matrix_analysis(Matrices(K.toarray(), M.toarray().tolist(), B, [1.0]), modes=5)
    np.testing.assert_allclose(plain.model.omega, rod().model.omega, rtol=1e-12)


def test_branch_of_matrices_hardens() -> None:
    branch = follow(
        rod(modes=3).model,
        EnergyContinuation(1.4, 1.8, 0.1),
        HarmonicBalance(3, 64),
        mode=0,
    )
    assert branch.complete
    # the exact rod: 1.1026 at 1.8; three harmonics of three modes are about 1 % high
    assert branch.points[-1].frequency_ratio == pytest.approx(1.1026, rel=0.02)


def test_unknowns_without_mass_are_condensed() -> None:
    """A rod of lumped masses at every second node has the modes of half as many springs."""
    size = 40
    K = rod_matrices(size)[0]
    mass = np.zeros(size)
    mass[1::2] = 2 / size
    mass[-1] /= 2
    for limit in (600, 10):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(matrix_modes, "_DENSE", limit)
            matrices = Matrices(K, sparse.diags(mass), np.eye(size)[-1:], 1.0)
            omega = matrix_analysis(matrices, modes=5).modes.omega
        c = np.cos((2 * np.arange(1, 6) - 1) * np.pi / 2 / (size // 2))
        np.testing.assert_allclose(omega, size // 2 * np.sqrt(2 * (1 - c)), rtol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_few_masses_on_many_unknowns(method: str) -> None:
    """Ten masses on a string of 1000 springs: as many modes as masses, and no more."""
    K, _, B = rod_matrices(1000)
    mass = np.zeros(1000)
    mass[99::100] = 0.1
    mass[-1] = 0.05
    given = Matrices(K, sparse.diags(mass), B, 1.0)
    c = np.cos((2 * np.arange(1, 10) - 1) * np.pi / 20)
    analysis = matrix_analysis(given, modes=9, method=method)
    np.testing.assert_allclose(analysis.modes.omega, 10 * np.sqrt(2 * (1 - c)), rtol=1e-9)
    with pytest.raises(ModelError, match=r"not above 10, the number of unknowns with mass"):
        matrix_analysis(given, modes=11, method=method)


def test_no_mode_is_missed_of_two_equal_rods(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every frequency twice: Lanczos methods may lose one of each pair."""
    monkeypatch.setattr(matrix_modes, "_DENSE", 10)
    K, M, B = rod_matrices(100)
    twice = [sparse.block_diag([matrix, matrix], format="csc") for matrix in (K, M)]
    rows = np.zeros((2, 200))
    rows[0, :100] = rows[1, 100:] = B[0]
    analysis = matrix_analysis(Matrices(*twice, rows, 1.0), modes=7)
    np.testing.assert_allclose(analysis.modes.omega[:6:2], analysis.modes.omega[1:6:2], rtol=1e-9)
    assert analysis.modes.checked_below > analysis.modes.omega[-1]


def test_a_missed_mode_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    original = matrix_modes.eigsh

    def forgetful(*arguments: Any, **keywords: Any) -> Any:
        squared, shapes = original(*arguments, **keywords)
        return np.delete(squared, 2), np.delete(shapes, 2, axis=1)

    monkeypatch.setattr(matrix_modes, "eigsh", forgetful)
    monkeypatch.setattr(matrix_modes, "_check_mass", lambda M: None)
    with pytest.raises(ConvergenceError, match="a mode was missed"):
        rod(700)


K3 = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
TIP = [[0.0, 0.0, 1.0]]
FREE = np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])

BAD = {
    r"mass M has shape \(2, 2\): must be \(3, 3\)": {"M": np.eye(2)},
    r"stiffness K has shape \(2, 3\): must be \(2, 2\)": {"K": np.ones((2, 3))},
    r"stiffness K has shape \(0, 0\)": {"K": np.empty((0, 0))},
    "stiffness K is not symmetric: .* up to 1; a file of one triangle": {"K": np.triu(K3)},
    "mass M is not symmetric": {"M": np.triu(np.ones((3, 3)))},
    "stiffness K has entries that are not finite": {"K": np.diag([1.0, np.nan, 1.0])},
    "mass M has entries of type complex128: must be real": {"M": np.eye(3) * 1j},
    "contact rows B has entries of type object|of type <U": {"B": [["a", "b", "c"]]},
    "contact rows B have 2 columns: must be 3": {"B": [[1.0, 0.0]]},
    "stiffness K has 0 on the diagonal of row 2: must be positive": {"K": np.diag([1.0, 0, 1])},
    "stiffness K has -1 on the diagonal of row 1": {"K": -np.eye(3)},
    "mass M has -1 on the diagonal of row 3: must be positive": {"M": np.diag([1.0, 1, -1])},
    "mass M has 0 on the diagonal of row 1: .* the whole row zero": {
        "M": np.array([[0.0, 0.1, 0.0], [0.1, 1.0, 0.0], [0.0, 0.0, 1.0]])
    },
    "mass M is zero": {"M": np.zeros((3, 3))},
    "contact row 2 is zero": {"B": [[0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]},
    "contact rows 1 and 3 are multiples": {"B": [*TIP, [1.0, 0, 0], [0.0, 0, 2.0]]},
    "contact rows 1 and 2 are multiples": {"B": [*TIP, [0.0, 0, -1.0]]},
    r"^gap has 2 values: must be one number, or one for each of the 1": {"gap": [1.0, 2.0]},
    "^gap = nan: must be a length in m": {"gap": [np.nan]},
}


@pytest.mark.parametrize("message", BAD)
def test_matrices_that_are_no_structure_are_refused(message: str) -> None:
    given = {"K": K3, "M": np.eye(3), "B": TIP, "gap": 1.0, **BAD[message]}
    with pytest.raises(ModelError, match=message):
        Matrices(**given)


UNFIT = {
    "stiffness K is singular: the structure is not held": {"K": FREE},
    "stiffness K is not positive definite": {"K": np.array([[1.0, 2, 0], [2, 1, 0], [0, 0, 1]])},
    "mass M has a negative eigenvalue": {"M": np.array([[1.0, 2, 0], [2, 1, 0], [0, 0, 1]])},
    "contact rows B depend on each other": {"B": [*TIP, [1.0, 0, 0], [1.0, 0, 1.0]]},
    "^modes = 3: .* not above 2, the number of unknowns with mass": {
        "M": np.diag([1.0, 0.0, 1.0]),
        "modes": 3,
    },
    "residual flexibility .* use fewer modes": {"modes": 3},
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("message", UNFIT)
def test_structures_that_cannot_be_reduced_are_refused(message: str, method: str) -> None:
    given = {"K": K3, "M": np.eye(3), "B": TIP, **UNFIT[message]}
    modes = given.pop("modes", 1)
    if message.startswith("residual") and method == "craig-bampton":
        message = "^modes = 3: the matrices have only 2 modes with the contact points held"
    with pytest.raises(ModelError, match=message):
        matrix_analysis(Matrices(**given, gap=1.0), modes=modes, method=method)


def free_rod(elements: int) -> tuple[Any, Any, np.ndarray]:
    """A rod that nothing holds."""
    K, M, B = rod_matrices(elements)
    K, M = K.tolil(), M.tolil()
    K[0, 0] /= 2
    M[0, 0] /= 2
    return K, M, B


@pytest.mark.parametrize("elements", [61, 700])
def test_a_free_structure_is_refused(elements: int) -> None:
    K, M, B = free_rod(elements)
    with pytest.raises(ModelError, match="the structure is not held"):
        matrix_analysis(Matrices(K, M, B, 1.0), modes=5)


def test_a_free_structure_is_noticed_without_a_look_at_pivots(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(matrix_modes, "_CHEAP", 0)
    with pytest.raises(ModelError, match="the structure is not held"):
        matrix_analysis(Matrices(*free_rod(701), 1.0), modes=5)


def test_a_large_indefinite_mass_is_noticed() -> None:
    K, M, B = rod_matrices(1500)
    M = M.tolil()
    M[700, 701] = M[701, 700] = 2 * M[700, 700]
    with pytest.raises(ModelError, match="mass M has a negative eigenvalue"):
        matrix_analysis(Matrices(K, M, B, 1.0), modes=5)


def test_a_slender_beam_is_not_taken_for_a_free_one() -> None:
    """Euler-Bernoulli elements, 400 of them: the stiffness has a condition of 1e12."""
    elements = 400
    h = 1 / elements
    bending = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2]])
    bending = np.vstack([bending, [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]])
    inertia = np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2]])
    inertia = np.vstack(
        [inertia, [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h**2, -22 * h, 4 * h**2]]
    )
    K, M = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
    for element in range(elements):
        place = slice(2 * element, 2 * element + 4)
        K[place, place] += bending / h**3
        M[place, place] += inertia * h / 420
    rows = np.zeros((1, 2 * elements))
    rows[0, -2] = 1.0
    analysis = matrix_analysis(Matrices(K[2:, 2:], M[2:, 2:], rows, 1.0), modes=4)
    exact = np.array([1.8751040687, 4.6940911330, 7.8547574382, 10.9955407349]) ** 2
    np.testing.assert_allclose(analysis.modes.omega, exact, rtol=1e-4)
    assert static_flexibility(analysis)[0, 0] == pytest.approx(1 / 3, rel=1e-4)
