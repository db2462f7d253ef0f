"""Stress of a cantilever that bends far, against its geometrically exact static bending."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from conftest import PLATE, Ended
from mpi4py import MPI

from fenics_nnm.fem.gathering import gathering
from fenics_nnm.fields.body import field_body
from fenics_nnm.fields.shapes import motion_shapes
from fenics_nnm.fields.stress_basis import stress_basis
from fenics_nnm.results.stored_branch import read_stored_branch
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.structure.mesh_structure import MeshLinear
from fenics_nnm.structure.static_bending import statically_bent
from fenics_nnm.study import read_study


def test_stress_of_second_order_is_that_of_exact_bending(
    study_file: Callable[..., Path], command: Callable[..., Ended]
) -> None:
    """At tip motions of 5 and 10 % of the length; fields have the second-order displacement."""
    path = study_file(
        PLATE,
        mesh={"height": 0.02, "elements": [8, 1]},
        body={"kinematics": "second-order", "masters": [1]},
        contact={"direction": [0.985, 0.174], "points": 1, "gap": 6e-3},
        reduction={"modes": 4},
        mode={"harmonics": 3, "samples": 32},
        continuation={"energies": {"from": 0.5, "to": 0.8, "step": 0.3}, "report_at": []},
    )
    assert command("run", path).code == 0
    branch = read_stored_branch(Path("results/study/branch.h5"))
    shapes = motion_shapes(branch, branch.points)
    phase = np.array([0.0, 1.0])
    for moved, stored in (
        (shapes.amounts, branch.displacement),
        (shapes.rates, branch.velocity),
    ):
        fields = shapes.fields(moved(branch.points[-1], phase))
        expected = stored(branch.points[-1], phase)
        np.testing.assert_allclose(fields, expected, atol=1e-12 * np.abs(expected).max())

    linear = linear_analysis(read_study(path), MPI.COMM_SELF)
    assert isinstance(linear, MeshLinear)
    body = field_body(branch)
    every = np.arange(len(body.mesh.nodes))
    recovery, basis = body.recovery(every), stress_basis(body, shapes, every)
    theta = branch.bent_shapes[:, body.mesh.origin]
    without_rotations = recovery.at_nodes_of_each(theta)[0]
    model = branch.header.model
    alpha = model.kinematics.tensors["alpha"][:, 0, 0]
    errors = []
    unit = 0.1 / float(np.abs(branch.shapes[0]).max())  # a tenth of the length
    for state in statically_bent(linear, 0, [unit / 2, unit]):
        u = gathering(linear.solid).nodal(state.displacement[:, None])[:, body.mesh.origin]
        exact = recovery.at_nodes_of_each(u)[0] + recovery.at_nodes_of_pairs(u, u)[0] / 2
        q = -alpha * state.coordinate**2 / model.omega**2
        q[0] = state.coordinate
        products = np.array([q[0] ** 2 / 2])
        found = basis.stress(np.concatenate([q, [0.0], products])[None])[0]
        linear_alone = basis.stress(np.concatenate([q, [0.0, 0.0]])[None])[0]
        with_theta_alone = linear_alone + products * without_rotations
        three = (found, linear_alone, with_theta_alone)
        errors.append([np.abs(each - exact).max() / np.abs(exact).max() for each in three])
    small, large = np.array(errors)
    assert large[0] < 3e-3 and large[0] > 3.5 * small[0]  # of third order beside the stress
    assert small[1] > 2e-3 and large[1] < 2.5 * small[1]  # of second order without theta
    assert small[2] > 1  # theta without the squares of its masters' rotations
