"""Largest displacements, stresses and contact forces of points, against files and closed forms."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import BEAM, PLATE, ROD, Ended
from written_fields import arrays_of

from fenics_nnm.backbone.extremes import CLAMP_EDGE, CONTACT, CORNER, KINDS, packed, unpacked
from fenics_nnm.fem.reference_cell import reference_cell
from fenics_nnm.fields.body import field_body
from fenics_nnm.fields.invariants import principal, von_mises
from fenics_nnm.fields.screening import length_screen, stress_screen, with_largest
from fenics_nnm.fields.shapes import motion_shapes
from fenics_nnm.fields.singular import singular_corners, singular_kinds
from fenics_nnm.fields.stress_basis import stress_basis
from fenics_nnm.fields.thinned import thinned
from fenics_nnm.results.stored_branch import StoredBranch, read_stored_branch

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

YOUNG, YIELD, TENSILE, FATIGUE = 2.1e11, 4e8, 6e8, 2e8

#: A beam at speed with second-order kinematics, strong by numbers that are easily told apart.
SPINNING: dict[str, Any] = {
    "material": {
        "yield_strength": "400 MPa",
        "tensile_strength": TENSILE,
        "fatigue_strength": "0.2 GPa",
    },
    "body": {"kinematics": "second-order", "masters": [1]},
    "rotation": {"axis": "z", "speed": 300.0},
    "contact": {"points": 3, "gap": 5e-3},
    "reduction": {"modes": 4},
    "continuation": {"energies": {"from": 0.9, "to": 1.2, "step": 0.3}, "report_at": [1.2]},
}


def rows_of(folder: Path) -> list[dict[str, str]]:
    with (folder / "backbone.csv").open() as file:
        return list(csv.DictReader(file))


def test_columns_are_the_largest_values_of_the_exported_file_of_a_point(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    assert command("run", study_file(BEAM, **SPINNING), "--output", "out").code == 0
    row, out = rows_of(tmp_path / "out")[-1], tmp_path / "out"
    peaks = arrays_of(out / "fields" / "peak_stress_1.2.vtu")
    branch = read_stored_branch(out / "branch.h5")
    point = branch.points[-1]
    kinds = singular_kinds(branch, field_body(branch).mesh)
    assert {0, KINDS.index(CLAMP_EDGE), KINDS.index(CONTACT)} == set(kinds.tolist())
    for name, column in (("von Mises", "von_mises"), ("largest principal", "principal")):
        values = peaks[f"peak {name} stress (Pa)"]
        at = int(np.argmax(values))
        assert float(row[f"{column}_anywhere_Pa"]) == pytest.approx(values[at], rel=1e-9)
        place = [float(x) for x in row[f"{column}_anywhere_place_m"].split()]
        assert place == pytest.approx(list(peaks["Points"][at]), abs=1e-6)
        assert row[f"{column}_anywhere_kind"] == KINDS[kinds[at]]
        assert float(row[f"{column}_Pa"]) == pytest.approx(values[kinds == 0].max(), rel=1e-9)
        quantile = np.quantile(values, 0.999)
        assert float(row[f"{column}_quantile_Pa"]) == pytest.approx(quantile, rel=1e-9)
    assert_margins(branch, kinds, row)
    displacement = branch.largest_displacement(point, instants=128)
    assert float(row["displacement_m"]) == pytest.approx(displacement.max(), rel=1e-9)
    assert int(row["displacement_node"]) == np.argmax(displacement)
    assert unpacked(*packed(point.extremes).values()) == point.extremes
    largest = json.loads((out / "summary.json").read_text())["largest"]
    believed = [float(r["von_mises_Pa"]) for r in rows_of(out) if r["status"] != "failed"]
    assert largest["von_mises_Pa"] == pytest.approx(max(believed))


def assert_margins(branch: StoredBranch, kinds: np.ndarray, row: dict[str, str]) -> None:
    """Margins are those of all stresses at all instants, one after the other."""
    body = field_body(branch)
    shapes = motion_shapes(branch, ())
    basis = stress_basis(body, shapes, np.arange(len(kinds)))
    phase = 2 * np.pi * np.arange(128) / 128
    stress = basis.stress(shapes.amounts(branch.points[-1], phase))[:, kinds == 0]
    static = body.recovery(np.arange(len(kinds))).of_samples(body.steady)[kinds == 0]
    assert von_mises(static).max() > 1e7
    assert float(row["yield_margin"]) == pytest.approx(YIELD / von_mises(stress).max(), rel=1e-5)
    change = von_mises(stress - static).max(axis=0)
    goodman = 1 / (change / FATIGUE + von_mises(static) / TENSILE).max()
    assert float(row["goodman_margin"]) == pytest.approx(goodman, rel=1e-5)
    beyond = "yield" if float(row["yield_margin"]) < 1 else "fatigue" if goodman < 1 else ""
    assert row["beyond"] == beyond


def test_a_rod_has_the_stress_of_its_mode_and_the_mean_of_its_contact_force(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """sigma = E u' at the clamp; the mean displacement of the tip is that of the mean force."""
    study = study_file(
        ROD,
        mesh={"elements": 12},
        body={"degree": 2},
        reduction={"modes": 6},
        mode={"harmonics": 8, "samples": 64},
        continuation={"energies": {"from": 0.5, "to": 1.5, "step": 1.0}, "report_at": []},
    )
    assert command("run", study, "--output", "out").code == 0
    linear, touching = rows_of(tmp_path / "out")
    moved = float(linear["displacement_m"])
    assert moved == pytest.approx(1e-3 * np.sqrt(0.5), rel=1e-9)
    assert float(linear["von_mises_Pa"]) == pytest.approx(YOUNG * np.pi / 2 * moved, rel=2e-3)
    assert linear["von_mises_Pa"] == linear["principal_Pa"]
    assert float(linear["contact_force_N"]) == float(linear["contact_impulse_Ns"]) == 0
    assert (linear["yield_margin"], linear["goodman_margin"], linear["beyond"]) == ("", "", "")
    branch = read_stored_branch(tmp_path / "out" / "branch.h5")
    phase = 2 * np.pi * np.arange(512) / 512
    tip = branch.node_at((1.0, 0.0, 0.0))
    mean = branch.displacement(branch.points[-1], phase, np.array([tip])).mean()
    impulse, hertz = float(touching["contact_impulse_Ns"]), float(touching["frequency_Hz"])
    assert impulse * hertz > 1
    assert -impulse * hertz / (YOUNG * 9e-4) == pytest.approx(mean, rel=1e-2)
    force = branch.forces(branch.points[-1], phase).max()
    assert float(touching["contact_force_N"]) == pytest.approx(force, rel=2e-2)
    assert float(touching["patch_displacement_m"]) <= float(touching["displacement_m"])


def test_a_slender_beam_has_the_stress_of_bending_at_its_clamp(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """sigma = E h w'' / 2, where w'' at the clamp is 1.8751^2 / L^2 of the tip's motion."""
    study = study_file(
        PLATE,
        mesh={"height": 0.02, "elements": [24, 1]},
        material={"poisson": 0.0},
        contact={"points": 1},
        continuation={"energies": {"from": 0.5, "to": 0.8, "step": 0.3}, "report_at": []},
    )
    assert command("run", study, "--output", "out").code == 0
    row = rows_of(tmp_path / "out")[0]
    bending = YOUNG * 0.01 * 1.8751**2 * float(row["displacement_m"])
    assert float(row["von_mises_anywhere_Pa"]) == pytest.approx(bending, rel=1e-2)
    assert row["von_mises_anywhere_kind"] == CLAMP_EDGE
    assert float(row["displacement_place_m"].split()[0]) == 1.0


def test_several_patches_have_columns_of_their_own_and_full_order_has_none(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    both = {
        "=": {
            "patch": [
                {"facets": "right", "direction": [0.0, 1.0], "gap": 1e-3},
                {"facets": "pad", "direction": [0.0, 1.0], "gap": 1.5e-3, "points": 2},
            ]
        }
    }
    pad = {"pad": {"box": {"from": [0.4, 0.2], "to": [0.8, 0.3]}}}
    study = study_file(PLATE, contact=both, groups=pad, continuation={"report_at": []})
    assert command("run", study, "--output", "two").code == 0
    row = rows_of(tmp_path / "two")[-1]
    own = [float(row[f"patch{n}_displacement_m"]) for n in (1, 2)]
    assert max(own) == float(row["patch_displacement_m"])
    forces = [float(row[f"patch{n}_contact_force_N"]) for n in (1, 2)]
    assert forces[0] > 0 and max(forces) <= float(row["contact_force_N"]) <= sum(forces)
    whole = study_file(PLATE, reduction={"method": "none"}, continuation={"report_at": []})
    assert command("run", whole, "--output", "whole").code == 0
    row = rows_of(tmp_path / "whole")[-1]
    assert row["displacement_m"] == row["von_mises_Pa"] == row["contact_force_N"] == ""


def test_the_inner_corner_of_an_angle_is_singular_and_its_outer_ones_are_not() -> None:
    """Three unit squares, and three unit cubes, in the shape of an L; the clamp is below."""
    flat = np.array([[x, y, 0.0] for y in range(3) for x in range(3)])
    squares = np.array([[a, a + 1, a + 4, a + 3] for a in (0, 1, 3)])
    above = flat + np.array([0.0, 0.0, 1.0])
    for nodes, cells, kind, dim in (
        (flat, squares, 9, 2),
        (np.vstack([flat, above]), np.hstack([squares, squares + 9]), 12, 3),
    ):
        shapes = np.ones((1, len(nodes), dim))
        shapes[:, nodes[:, 1] == 0] = 0.0
        branch: Any = SimpleNamespace(nodes=nodes, cells=cells, shapes=shapes)
        inner, edge = singular_corners(branch, reference_cell(kind))
        assert np.all(nodes[inner][:, :2] == 1) and len(inner) == dim - 1
        held = nodes[edge]
        assert np.all(held[:, 1] == 0)
        assert len(held) == (2 if dim == 2 else 6)
    assert KINDS.index(CORNER) == 1


def test_bounds_find_the_largest_values() -> None:
    rng = np.random.default_rng(5)
    values = rng.uniform(0, 1, 500)
    bound = values * rng.uniform(1, 1.5, 500)
    found, exact = with_largest(bound, lambda few: values[few], 4)
    assert sorted(exact)[-4:] == sorted(values)[-4:]
    assert np.array_equal(values[found], exact) and len(found) < 250
    assert with_largest(bound[:2], lambda few: values[few], 4)[1] == pytest.approx(values[:2])


@pytest.mark.parametrize("size", [1.0, 1e30, 1e-30])
def test_bounds_of_the_same_instants_are_the_stresses(size: float) -> None:
    """Of shapes of a body of micrometres, too, whose squares single precision has not."""
    rng = np.random.default_rng(6)
    shapes, rest = rng.standard_normal((3, 6, 40)), rng.standard_normal((6, 40))
    steady, amounts = rng.standard_normal((6, 40)), rng.standard_normal((2, 3))
    screen = stress_screen(size * shapes, rest, steady)
    other = thinned(rng.standard_normal((2, 3)) / size, np.arange(2))
    _, bounds = screen.bounds([other, thinned(amounts / size, np.arange(2))])
    at = rng.standard_normal((3, 40, 3))
    (bound,) = length_screen(40, 3, lambda few: size * at[:, few]).bounds([other])
    lengths = np.linalg.norm(np.tensordot(size * other.amounts, at, 1), axis=2)
    assert bound == pytest.approx(lengths.max(axis=0), rel=1e-5)
    stress = np.moveaxis(np.tensordot(amounts, shapes, 1) + steady, 1, 2)
    assert bounds.mises == pytest.approx(von_mises(stress).max(axis=0), rel=1e-5)
    assert bounds.change == pytest.approx(von_mises(stress - rest.T).max(axis=0), rel=1e-5)
    assert np.all(bounds.tension * (1 + 1e-5) >= principal(stress)[..., 0].max(axis=0))


def test_bounds_hold_between_the_instants_that_are_looked_at() -> None:
    rng = np.random.default_rng(7)
    shapes, at = rng.standard_normal((4, 6, 60)), rng.standard_normal((4, 60, 3))
    phase = np.sort(rng.uniform(0, np.pi, 41))
    amounts = np.cos(np.outer(phase, [1, 2, 5, 9])) * [5.0, 1.0, 0.5, 0.3]
    motion = thinned(amounts, phase)
    assert len(motion.few) < 10
    (bounds,) = stress_screen(shapes, shapes[0], np.empty((6, 0))).bounds([motion])
    (bound,) = length_screen(60, 3, lambda few: at[:, few]).bounds([motion])
    stress = np.moveaxis(np.tensordot(amounts, shapes, 1), 1, 2)
    lengths = np.linalg.norm(np.tensordot(amounts, at, 1), axis=2)
    of_all = {
        "mises": (bounds.mises, von_mises(stress)),
        "change": (bounds.change, von_mises(stress - shapes[0].T)),
        "tension": (bounds.tension, principal(stress)[..., 0]),
        "length": (bound, lengths),
    }
    for above, values in of_all.values():
        assert np.all(above * (1 + 1e-5) >= values.max(axis=0))
    assert np.all(bounds.mises < 1.7 * von_mises(stress).max(axis=0))
    assert np.all(bound < 1.7 * lengths.max(axis=0))


def test_values_below_the_least_are_not_looked_at() -> None:
    values = np.arange(10.0)
    assert sorted(with_largest(values, lambda few: values[few], 3, 8.0)[1]) == [8.0, 9.0]
    assert len(with_largest(values, lambda few: values[few], 3, 20.0)[0]) == 0
