"""Shared linear analyses are those that a study would have found alone, to the last bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import BEAM, PLATE, ROD, changed
from mpi4py import MPI

from fenics_nnm.errors import StudyError
from fenics_nnm.structure.analysis import Linear, linear_analysis
from fenics_nnm.structure.shared_analysis import SharedAnalysis
from fenics_nnm.study import Study, study_from

COMM = MPI.COMM_SELF


def study(base: dict[str, Any] = ROD, **changes: Any) -> Study:
    return study_from(changed(base, changes), Path("study.toml"))


def assert_equal(found: Linear, wanted: Linear) -> None:
    for name in ("omega", "Phi", "R", "gap"):
        assert np.array_equal(getattr(found.model, name), getattr(wanted.model, name)), name
    assert found.model.reference == wanted.model.reference
    for name in ("shapes", "residual_shapes"):
        assert np.array_equal(getattr(found.reduction, name), getattr(wanted.reduction, name))


@pytest.mark.parametrize("method", ["massless", "craig-bampton"])
@pytest.mark.parametrize("base", [ROD, PLATE, BEAM], ids=["rod", "plate", "beam"])
def test_gaps_share_an_analysis(base: dict[str, Any], method: str) -> None:
    shared = SharedAnalysis()
    for gap in (1e-3, 1.7e-4, 2e-3):
        wanted = study(base, contact={"gap": gap}, reduction={"method": method, "modes": 2})
        found = shared(wanted, COMM)
        assert_equal(found, linear_analysis(wanted, COMM))
        assert np.all(found.model.gap == gap)
    assert shared.made == 1


def test_gaps_and_modes_with_large_deflection_have_their_own() -> None:
    """Whether second order matters, and which modes bend, depends on both."""
    shared = SharedAnalysis()
    for gap, number in ((1e-2, 1), (1e-5, 1), (1e-5, 2)):
        mode = {"number": number, "harmonics": 3, "samples": 32}
        wanted = study(PLATE, body={"kinematics": "auto"}, contact={"gap": gap}, mode=mode)
        found, alone = shared(wanted, COMM), linear_analysis(wanted, COMM)
        assert_equal(found, alone)
        masters = [list(each.model.kinematics.masters) for each in (found, alone)]
        assert masters[0] == masters[1]
    assert shared.made == 2  # linear kinematics of the same mode are taken over


def test_motions_share_an_analysis() -> None:
    shared = SharedAnalysis()
    shared(study(), COMM)
    shared(study(mode={"number": 2, "harmonics": 5}, continuation={"energies": {"to": 1.3}}), COMM)
    shared(study(title="another", output={"frames": 30}), COMM)
    assert shared.made == 1


@pytest.mark.parametrize(
    "changes",
    [
        {"mesh": {"elements": [4, 2]}},
        {"body": {"thickness": 0.02}},
        {"material": {"density": 7000.0}},
        {"contact": {"points": 1}},
        {"contact": {"direction": [0.0, -1.0]}},
        {"contact": {"facets": "top"}, "clamp": {"facets": "bottom"}},
        {"reduction": {"modes": 3}},
        {"mass": {"facets": ["right"], "mass": 2.0}},
    ],
)
def test_other_structures_do_not(changes: dict[str, Any]) -> None:
    shared = SharedAnalysis()
    shared(study(PLATE), COMM)
    wanted = study(PLATE, **changes)
    assert_equal(shared(wanted, COMM), linear_analysis(wanted, COMM))
    assert shared.made == 2


def test_a_reference_displacement_is_that_of_its_own_study() -> None:
    shared = SharedAnalysis()
    closed = study(contact={"gap": 0.0, "reference_displacement": 2e-4})
    assert shared(closed, COMM).model.reference == 2e-4
    assert shared(study(contact={"gap": 1e-3}), COMM).model.reference is None
    with pytest.raises(StudyError, match=r"reference_displacement.*no effect"):
        shared(study(contact={"gap": 1e-3, "reference_displacement": 2e-4}), COMM)
    assert shared.made == 1


def matrices(folder: Path, stiffness: float = 4.0, **contact: Any) -> Study:
    """A chain of three masses whose last two can touch something."""
    K = 1e6 * np.array([[stiffness, -2.0, 0.0], [-2.0, 4.0, -2.0], [0.0, -2.0, 2.0]])
    np.savez(folder / "chain.npz", K=K, M=np.diag([1.0, 2.0, 3.0]), B=np.eye(3)[1:])
    values = {
        "matrices": {"file": "chain.npz"},
        "contact": contact,
        "reduction": {"modes": 1},
    }
    return study_from(values, folder / "study.toml")


def test_matrices_share_an_analysis_until_their_file_changes(tmp_path: Path) -> None:
    shared = SharedAnalysis()
    for gap in (1e-3, [1e-3, 2e-3]):
        wanted = matrices(tmp_path, gap=gap)
        assert_equal(shared(wanted, COMM), linear_analysis(wanted, COMM))
    assert shared.made == 1
    other = matrices(tmp_path, stiffness=5.0, gap=1e-3)
    assert_equal(shared(other, COMM), linear_analysis(other, COMM))
    assert shared.made == 2
