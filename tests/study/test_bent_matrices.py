"""Matrices at speed, and matrices that bend far: closed forms, and the same model from arrays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bent_body import BentBody
from mpi4py import MPI
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from fenics_nnm.backbone.point import VERIFIED, BranchPoint
from fenics_nnm.errors import ModelError, StudyError
from fenics_nnm.fem.blocks import Data
from fenics_nnm.reduction.comparison import model_difference
from fenics_nnm.reduction.matrix_terms import Entries
from fenics_nnm.results import branch_file
from fenics_nnm.structure.analysis import linear_analysis, prepared
from fenics_nnm.study import study_from
from fenics_nnm.time_domain.flow import Flow
from fenics_nnm.time_domain.shooting import OrbitGuess, shoot

REFERENCE = Path(__file__).parents[1] / "reference" / "nonlinear_campbell_1dof.csv"
STOP = 50.0


def closed_form(speed: float, energy: float, stop: float = STOP) -> float:
    """Frequency in Hz of a mass at an elastic stop, of the head of the reference file."""
    k, e = 1 + 1.17 * speed**2, 1 - 0.5 * speed**2
    if energy <= k * e**2 / 2:
        return float(np.sqrt(k) / (2 * np.pi))
    open_ = 2 / np.sqrt(k) * np.arccos(-e * np.sqrt(k / (2 * energy)))
    root = np.sqrt(2 * energy * (k + stop) - stop * k * e**2)
    return float(1 / (open_ + 2 / np.sqrt(k + stop) * np.arccos(e * k / root)))


def study_at(folder: Path, speed: float, ratios: list[float], stop: float = STOP) -> Any:
    """A mass whose spring and gap change with speed; it touches through a massless unknown."""
    np.savez(
        folder / "mass.npz",
        K=[[1 + stop, -stop], [-stop, stop]],
        M=np.diag([1.0, 0.0]),
        B=[[0.0, 1.0]],
        softening=np.diag([1.17, 0.0]),
    )
    ends = {"from": ratios[0], "to": ratios[-1], "step": 50.0}
    return study_from(
        {
            "matrices": {"file": "mass.npz", "speed": speed, "speed_stiffness": "softening"},
            "contact": {"gap": 1.0, "gap_growth": -0.5},
            "reduction": {"modes": 1},
            "mode": {"number": 1, "harmonics": 30, "samples": 512},
            "continuation": {"energies": ends, "report_at": ratios, "shooting": False},
        },
        folder / "study.toml",
    )


def points_at(folder: Path, speed: float, ratios: list[float]) -> tuple[BranchPoint, ...]:
    study = study_at(folder, speed, ratios)
    branch = prepared(study, linear_analysis(study, MPI.COMM_SELF)).followed()
    assert branch.complete, branch.reason
    return branch.points


def test_closed_form_is_that_of_the_reference() -> None:
    for speed, _, _, energy, _, elastic in np.loadtxt(REFERENCE, delimiter=",", skiprows=4):
        assert closed_form(speed, energy) == pytest.approx(elastic, abs=2e-8)


@pytest.mark.parametrize("speed", [0.4, 1.0])
def test_frequencies_over_speed_are_the_closed_form(tmp_path: Path, speed: float) -> None:
    points = points_at(tmp_path, speed, [0.5, 1.3, 4.0])
    assert points[-1].motion.frequency > 1.1 * points[0].motion.frequency
    for point in points:
        exact = closed_form(speed, point.motion.energy)
        assert point.motion.frequency == pytest.approx(exact, rel=1e-4)


def test_engine_order_four_crosses_where_the_closed_form_says(tmp_path: Path) -> None:
    """At E = 2; without a stop it would be at 0.259675."""
    speed = brentq(lambda s: closed_form(s, 2.0) - 4 * s / (2 * np.pi), 0.3, 0.5)
    points = points_at(tmp_path, speed, [2.4, 2.6, 2.8, 3.0])
    energies = [point.motion.energy for point in points]
    assert energies[0] < 2 < energies[-1]
    frequency = CubicSpline(energies, [point.motion.frequency for point in points])(2.0)
    assert 2 * np.pi * frequency / 4 == pytest.approx(speed, rel=1e-4)


def test_engine_order_four_crosses_a_rigid_stop_at_0_409998(tmp_path: Path) -> None:
    """The limit of stiff stops, whose exact motions are shot: the way there goes as stop^-1/2."""

    def excess(speed: float, stop: float) -> float:
        study = study_at(tmp_path, speed, [0.5, 3.0], stop)
        model = linear_analysis(study, MPI.COMM_SELF).model
        away = -np.sign(model.Phi[0]) * np.sqrt(2 * 2.0) / model.omega
        period = 2 * np.pi / (4 * speed)
        guess = OrbitGuess(away, np.zeros(1), period, 2.0, touches=True, reversible=True)
        shot = shoot(Flow(model), guess)
        assert shot.converged and shot.return_error < 1e-9
        assert shot.frequency == pytest.approx(closed_form(speed, 2.0, stop), rel=1e-10)
        return shot.frequency - 4 * speed / (2 * np.pi)

    one, other = (brentq(excess, 0.40, 0.42, args=(stop,), xtol=1e-9) for stop in (1e5, 4e5))
    assert other - one == pytest.approx(6.3e-4, rel=0.1)
    assert 2 * other - one == pytest.approx(0.409998, abs=5e-6)


def test_arrays_of_a_body_give_its_model(tmp_path: Path) -> None:
    body = BentBody.random(6, 2, seed=3)
    masters = np.array([0, 2])
    expected = body.reduction(4, masters).model
    curved = np.zeros((2, 6, 6))
    curved[0, 1, 4] = curved[1, 0, 0] = 0.5
    K2, K3 = body.f2 / 2, body.f3 / 6
    table = np.array([[i + 1, j + 1, k + 1, K2[i, j, k]] for i, j, k in np.ndindex(6, 6, 6)])
    np.savez(
        tmp_path / "body.npz",
        K=np.diag(body.omega**2),
        M=np.eye(6),
        B=body.B,
        K2=table,
        K3=K3,
        B2=curved,
    )
    study = study_from(
        {
            "matrices": {
                "file": "body.npz",
                "quadratic_stiffness": "K2",
                "cubic_stiffness": "K3",
                "quadratic_rows": "B2",
                "masters": [1, 3],
            },
            "contact": {"gap": 1.0},
            "reduction": {"modes": 4},
            "mode": {"number": 1, "harmonics": 4, "samples": 32},
        },
        tmp_path / "study.toml",
    )
    found = linear_analysis(study, MPI.COMM_SELF)
    sign = np.diagonal(found.reduction.shapes)  # modes are signed towards the obstacle
    tensors, wanted = found.model.kinematics.tensors, expected.kinematics.tensors
    own = sign[masters]
    pairs = np.multiply.outer(own, own)
    np.testing.assert_allclose(
        tensors["alpha"], wanted["alpha"] * np.multiply.outer(sign, pairs), atol=1e-12
    )
    np.testing.assert_allclose(
        tensors["beta"], wanted["beta"] * np.multiply.outer(pairs, pairs), atol=1e-12
    )
    np.testing.assert_allclose(
        tensors["D"], wanted["D"] * np.multiply.outer(pairs, pairs), atol=1e-12
    )
    bent = wanted["Theta"] * pairs
    bent[1, 0, 0] += 1.0
    np.testing.assert_allclose(tensors["Theta"], bent, atol=1e-12)


def test_mass_on_a_bent_way_to_a_stop(tmp_path: Path) -> None:
    """q'' + w^2 q + a q^2 + (1 + 2 b q) (q + b q^2 - g)_+ / R = 0, exact by a quadrature."""
    k, stop, a, b, gap = 4.0, 20.0, 0.8, -0.3, 0.4
    np.savez(
        tmp_path / "way.npz",
        K=[[k + stop, -stop], [-stop, stop]],
        M=np.diag([1.0, 0.0]),
        B=[[0.0, 1.0]],
        K2=[[1, 1, 1, a]],
        B2=[[1, 1, 1, b]],
    )
    study = study_from(
        {
            "matrices": {"file": "way.npz", "quadratic_stiffness": "K2", "quadratic_rows": "B2"},
            "contact": {"gap": gap},
            "reduction": {"modes": 1},
            "mode": {"number": 1, "harmonics": 20, "samples": 256},
            "continuation": {"energies": {"from": 0.5, "to": 1.5, "step": 1.0}, "shooting": True},
        },
        tmp_path / "study.toml",
    )
    linear = linear_analysis(study, MPI.COMM_SELF)
    points = prepared(study, linear).followed().points
    assert linear.model.kinematics.tensors["Theta"][0, 0, 0] == pytest.approx(2 * b)

    def potential(q: Any) -> Any:
        over = np.maximum(q + b * q**2 - gap, 0.0)
        return k * q**2 / 2 + a * q**3 / 3 + stop * over**2 / 2

    assert [point.motion.contact_fraction > 0 for point in points] == [False, True]
    for point in points:
        energy = point.motion.energy
        ends = [brentq(lambda q: potential(q) - energy, *span) for span in ((-2, 0), (0, 2))]
        kink = (-1 + np.sqrt(1 + 4 * b * gap)) / (2 * b)
        stations = sorted({ends[0], 0.0, min(kink, ends[1]), ends[1]})
        half = sum(_time(potential, energy, s, e) for s, e in pairwise(stations))
        assert point.motion.frequency == pytest.approx(1 / (2 * half), rel=3e-5)
        assert point.verdict is not None and point.verdict.status == VERIFIED, point.verdict


def _time(potential: Callable[[Any], Any], energy: float, start: float, end: float) -> float:
    nodes, weights = np.polynomial.legendre.leggauss(40)
    s, middle, total = (nodes + 1) / 2, (start + end) / 2, 0.0
    for turn in (start, end):
        q = turn + (middle - turn) * s**2  # no singular end
        speed = np.sqrt(2 * (energy - potential(q)))
        total += float(weights @ (s * abs(middle - turn) / speed))
    return total


def test_a_force_without_potential_is_refused() -> None:
    body = BentBody.random(4, 1, seed=2)
    twisted = replace(body, f2=body.f2 + np.arange(4.0)[:, None, None] * np.eye(4)[0])
    with pytest.raises(ModelError, match="second derivative of the internal force"):
        twisted.reduction(3, np.array([0, 1]))


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        ([[1, 1, 1, 5.0], [1, 2, 1, 2e6], [2, 1, 1, 1e6]], ""),  # of u1^2 u2
        ([[1, 1, 2, 1e6], [1, 2, 1, 1e6], [2, 1, 1, 1e6]], ""),
        ([[1, 2, 1, 1e6]], "places [1, 1, 2]"),  # nothing on unknown 2
        ([[2, 1, 1, 1e6]], "places [1, 1, 2]"),
        ([[1, 2, 3, 2.0], [2, 1, 3, 2.0], [3, 1, 2, 1.9]], "places [1, 2, 3]"),
        ([[1, 1, 1, 1, 2.0], [1, 1, 1, 2, 3.0], [2, 1, 1, 1, 1.0]], ""),  # of u1^3 u2
        ([[1, 1, 1, 1, 2.0], [1, 1, 1, 2, 1.0], [2, 1, 1, 1, 1.0]], "places [1, 1, 1, 2]"),
    ],
)
def test_entries_must_be_forces_of_one_potential(entries: list[list[float]], words: str) -> None:
    """A lone master sees one number of its own force, which cannot tell that energy is not kept."""
    shape = (3,) * (len(entries[0]) - 1)
    found = Entries.of("quadratic stiffness", np.array(entries), shape)
    if not words:
        found.assert_potential("quadratic stiffness", 3)
        return
    with pytest.raises(ModelError, match="has no potential") as error:
        found.assert_potential("quadratic stiffness", 3)
    assert words in str(error.value)


def test_study_with_forces_of_no_potential_is_refused(tmp_path: Path) -> None:
    arrays = {"K": np.diag([1.0, 2.0]), "M": np.eye(2), "B": np.eye(2)[:1]}
    np.savez(tmp_path / "m.npz", **arrays, K3=[[2, 1, 1, 1, 1.0]])
    values = {
        "matrices": {"file": "m.npz", "cubic_stiffness": "K3"},
        "contact": {"gap": 1.0},
        "reduction": {"modes": 1},
        "mode": {"number": 1, "harmonics": 3, "samples": 32},
    }
    study = study_from(values, tmp_path / "study.toml")
    with pytest.raises(ModelError, match="cubic stiffness: has no potential"):
        linear_analysis(study, MPI.COMM_SELF)


def test_branch_file_keeps_second_order_kinematics(tmp_path: Path) -> None:
    model = BentBody.random(6, 2, seed=3).reduction(4, np.array([0, 2])).model
    header = branch_file.BranchHeader("", {}, 1, 4, 32, 4, "time-reversible", model)
    branch_file.create(tmp_path / "branch.h5", header, Data({}))
    stored = branch_file.read(tmp_path / "branch.h5")[0].model
    assert model_difference(stored, model) == ""
    assert stored.kinematics.masters.tolist() == [0, 2]
    other = replace(model.kinematics, alpha=1.01 * model.kinematics.tensors["alpha"])
    assert "alpha of second-order" in model_difference(stored, replace(model, kinematics=other))
    assert "with one of them alone" in model_difference(stored, model.linearised)


def test_what_makes_no_sense_is_refused(tmp_path: Path) -> None:
    def study(matrices: dict[str, Any], **changes: Any) -> None:
        values = {
            "matrices": {"file": "m.npz", **matrices},
            "contact": {"gap": 1.0},
            "reduction": {"modes": 2},
            "mode": {"number": 1, "harmonics": 5, "samples": 32},
            **changes,
        }
        study_from(values, tmp_path / "study.toml")

    bends = {"quadratic_stiffness": "K2"}
    for matrices, changes, message in (
        ({"speed_stiffness": "S"}, {}, "speed: is missing"),
        ({"masters": [1]}, {}, "masters: has no effect"),
        ({**bends, "masters": [2, 1]}, {}, "must be numbers of modes, ascending"),
        ({**bends, "masters": [3]}, {}, "masters = .3.: must not be above reduction.modes = 2"),
        ({}, {"contact": {"gap": 1.0, "gap_growth": 0.1}}, "gap_growth: has no effect"),
        (bends, {"mode": {"number": 1, "harmonics": 8, "samples": 32}}, "must be above 4"),
        (bends, {"reduction": {"method": "craig-bampton", "modes": 2}}, '"massless"'),
    ):
        with pytest.raises(StudyError, match=message):
            study(matrices, **changes)
    for given, message in (
        (np.zeros((2, 2)), r"must be \(2, 2, 2\), or a table with 4 columns"),
        ([[1, 1, 3, 1.0]], "place 3 in row 1, column 3: must be a whole number from 1 to 2"),
        ([[1, 1.5, 1, 1.0]], "place 1.5"),
        ([[1, 1, 1, np.nan]], "not finite"),
    ):
        with pytest.raises(ModelError, match=message):
            Entries.of("quadratic stiffness", given, (2, 2, 2))
