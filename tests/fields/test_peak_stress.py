"""Peaks of stress over a period, against searches of all instants."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import BEAM, Ended, changed

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.fem.elasticity import VTK_ORDER
from fenics_nnm.fields.body import FieldBody, field_body
from fenics_nnm.fields.frames import Frames
from fenics_nnm.fields.invariants import principal, von_mises
from fenics_nnm.fields.kept_bases import KeptBases
from fenics_nnm.fields.peak import largest_tension
from fenics_nnm.fields.shapes import motion_shapes
from fenics_nnm.fields.stress_basis import StressBasis, stress_basis, used_shapes
from fenics_nnm.fields.stress_rows import StressRows
from fenics_nnm.results.stored_branch import read_stored_branch

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]


def test_largest_tension_is_that_of_all_instants() -> None:
    rng = np.random.default_rng(3)
    stress = rng.standard_normal((40, 50, 6))
    stress[:, 0] = 0.0  # no stress at all
    stress[:, 1, :] = [-1.0, -1.0, -1.0, 0.0, 0.0, 0.0]  # pressure: all instants and axes alike
    stress[:, 2, 1:] = 0.0  # one axis: the bound is reached
    value, instant = largest_tension(stress, von_mises(stress))
    every = principal(stress)[..., 0]
    np.testing.assert_allclose(value, every.max(axis=0), rtol=1e-13, atol=1e-13)
    np.testing.assert_array_equal(instant[2:], every.argmax(axis=0)[2:])


def test_principal_stresses_are_eigenvalues_where_they_are_near_each_other_too() -> None:
    rng = np.random.default_rng(4)
    turned = np.linalg.qr(rng.standard_normal((600, 3, 3)))[0]
    apart = 10.0 ** -rng.uniform(0, 17, 600)
    values = np.stack([np.ones(600), 1 - apart, rng.uniform(-2, 1, 600)], axis=1)
    values[:100] *= -1
    values[100:110] = 0.0
    tensor = np.einsum("nij,nj,nkj->nik", turned, values, turned)
    stress = np.stack([tensor[:, i, j] for i, j in VTK_ORDER], axis=1)
    wanted = -np.sort(-values, axis=1)
    np.testing.assert_allclose(principal(stress), wanted, rtol=0, atol=1e-12)


def assert_kept_bases_know_what_is_used(
    body: FieldBody, rows: StressRows, point: BranchPoint, whole: StressBasis
) -> None:
    """A basis of the shapes that a motion is made of gives its stress, one of fewer none."""
    shapes, every = whole.shapes, np.arange(len(body.mesh.nodes))
    amounts = rows.amounts(shapes, point)[0].copy()
    amounts[:, [0, 2]] = 0.0
    used = used_shapes(shapes, [amounts])
    np.testing.assert_array_equal(used, [1, *range(3, shapes.count)])
    bases = KeptBases()
    few = bases.get(0, used, lambda: stress_basis(body, shapes, every, used))
    stress = whole.stress(amounts)
    np.testing.assert_allclose(few.stress(amounts), stress, atol=1e-12 * np.abs(stress).max())
    assert bases.get(0, used[1:], lambda: whole) is few
    assert bases.get(0, np.array([0, 1]), lambda: whole) is whole
    amounts[0, 0] = 1.0
    with pytest.raises(ValueError, match="not known"):
        few.stress(amounts)


def test_peaks_are_those_of_stresses_recovered_one_by_one(
    study_file: StudyFile, command: Command
) -> None:
    changes = {"reduction": {"modes": 4}, "contact": {"points": 3}}
    for method in ("massless", "none"):
        chosen = changed(BEAM, changed(changes, {"reduction": {"method": method}}))
        assert command("run", study_file(chosen), "--output", method).code == 0
        branch = read_stored_branch(Path(method) / "branch.h5")
        body, point = field_body(branch), branch.points[-1]
        if method == "none":
            point = next(p for p in branch.points if p.position in branch.inertia)
        rows = StressRows(["peak_stress"], Frames(24, reversible=True))
        every = np.arange(len(body.mesh.nodes))
        basis = stress_basis(body, motion_shapes(branch, branch.points), every)
        peaks = dict(zip(rows.peak_names, rows.at(basis, point), strict=True))
        assert_kept_bases_know_what_is_used(body, rows, point, basis)
        recovery = body.recovery(every)
        times = np.unique(np.concatenate([np.arange(n) / n for n in (24, 128)]))
        fields = branch.displacement(point, 2 * np.pi * times)
        stresses = [recovery.at_nodes(body.on_grid(field)) for field in fields]
        mises = np.array([von_mises(stress) for stress in stresses])
        tension = np.array([principal(stress)[:, 0] for stress in stresses])
        for name, values in (("von Mises", mises), ("largest principal", tension)):
            found = peaks[f"peak {name} stress (Pa)"]
            np.testing.assert_allclose(found, values.max(axis=0), atol=1e-9 * values.max())
