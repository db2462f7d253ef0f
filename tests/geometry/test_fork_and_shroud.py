"""Tuning fork and shrouded cantilever: sizes, groups and first frequencies."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from built_meshes import build, facet_area
from mpi4py import MPI
from pydantic import ValidationError

from fenics_nnm.geometry import Fork, Shroud
from fenics_nnm.geometry.fork import Pads
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import study_from

FORK = Fork(length=100.0, width=5.0, distance=8.0, foot=20.0, element_size=2.5, length_unit="mm")
SHROUD = Shroud(
    length=100.0,
    width=6.0,
    shroud_length=40.0,
    shroud_height=4.0,
    element_size=2.0,
    length_unit="mm",
)


def test_fork_has_its_area_and_facing_sides() -> None:
    mesh = build(FORK)
    assert mesh.volume == pytest.approx(2 * 100 * 5 + 20 * 18)
    assert mesh.worst_shape > 0.5
    np.testing.assert_allclose(mesh.box("left inner"), [[-4, 0, 0], [-4, 100, 0]], atol=1e-9)
    np.testing.assert_allclose(mesh.box("right inner"), [[4, 0, 0], [4, 100, 0]], atol=1e-9)
    np.testing.assert_allclose(mesh.box("foot"), [[-9, -20, 0], [9, -20, 0]], atol=1e-9)
    np.testing.assert_allclose(mesh.box("right tip"), [[4, 100, 0], [9, 100, 0]], atol=1e-9)
    left, right = (mesh.nodes(f"{side} inner") for side in ("left", "right"))
    np.testing.assert_allclose(np.sort(left[:, 1]), np.sort(right[:, 1]), atol=1e-9)


def test_fork_with_a_depth_is_a_prism_over_the_plane_one() -> None:
    mesh = build(FORK.model_copy(update={"depth": 5.0}))
    assert mesh.volume == pytest.approx((2 * 100 * 5 + 20 * 18) * 5)
    assert facet_area(mesh, "left inner") == pytest.approx(100 * 5)
    assert facet_area(mesh, "foot") == pytest.approx(18 * 5)
    np.testing.assert_allclose(mesh.box("left outer"), [[-9, 0, 0], [-9, 100, 5]], atol=1e-9)


def test_shroud_is_a_blade_under_a_plate() -> None:
    mesh = build(SHROUD)
    assert mesh.volume == pytest.approx(100 * 6 + 40 * 4)
    np.testing.assert_allclose(mesh.box("root"), [[-3, 0, 0], [3, 0, 0]], atol=1e-9)
    np.testing.assert_allclose(mesh.box("shroud left"), [[-20, 100, 0], [-20, 104, 0]], atol=1e-9)
    np.testing.assert_allclose(mesh.box("shroud right"), [[20, 100, 0], [20, 104, 0]], atol=1e-9)
    np.testing.assert_allclose(mesh.box("shroud top"), [[-20, 104, 0], [20, 104, 0]], atol=1e-9)
    with pytest.raises(ValidationError, match="shroud_length = 5: must be above width = 6"):
        Shroud.model_validate({**SHROUD.model_dump(), "shroud_length": 5.0})


def test_pads_of_the_fork_face_each_other_and_are_a_part_of_the_body() -> None:
    mesh = build(FORK.model_copy(update={"pads": Pads(length=10.0, thickness=3.0)}))
    assert mesh.volume == pytest.approx(2 * 100 * 5 + 20 * 18 + 2 * 10 * 3)
    np.testing.assert_allclose(mesh.box("left pad"), [[-1, 90, 0], [-1, 100, 0]], atol=1e-9)
    np.testing.assert_allclose(mesh.box("right pad"), [[1, 90, 0], [1, 100, 0]], atol=1e-9)
    np.testing.assert_allclose(mesh.box("left inner"), [[-4, 0, 0], [-4, 90, 0]], atol=1e-9)
    np.testing.assert_allclose(mesh.box("right outer"), [[9, 0, 0], [9, 100, 0]], atol=1e-9)
    for pads, message in (
        ({"length": 100.0, "thickness": 1.0}, "pads.length = 100: must be below length = 100"),
        ({"length": 9.0, "thickness": 4.0}, "pads.thickness = 4: must be below 4, half"),
    ):
        with pytest.raises(ValidationError, match=message):
            Fork.model_validate({**FORK.model_dump(), "pads": pads})


def test_pads_of_the_shroud_are_a_part_of_it() -> None:
    mesh = build(SHROUD.model_copy(update={"pad_length": 4.0}))
    assert mesh.volume == pytest.approx(100 * 6 + 40 * 4)
    np.testing.assert_allclose(mesh.box("shroud left"), [[-20, 100, 0], [-20, 104, 0]], atol=1e-9)
    np.testing.assert_allclose(mesh.box("left"), [[-3, 0, 0], [-3, 100, 0]], atol=1e-9)
    with pytest.raises(ValidationError, match="pad_length = 17: must be below 17"):
        Shroud.model_validate({**SHROUD.model_dump(), "pad_length": 17.0})


def frequencies(mesh: dict[str, Any], clamp: str, contact: str) -> np.ndarray:
    study = {
        "mesh": mesh,
        "body": {"theory": "plane-stress", "thickness": 0.005, "degree": 2},
        "material": {"young": 2e11, "poisson": 0.3, "density": 7800.0},
        "clamp": {"facets": clamp},
        "contact": {"facets": contact, "gap": 1e-4, "points": 2},
        "reduction": {"modes": 3},
    }
    analysis = linear_analysis(study_from(study, Path("study.toml")), MPI.COMM_SELF)
    return np.asarray(analysis.reduction.model.omega / (2 * np.pi))


def test_slender_tines_have_the_frequency_of_a_cantilever_twice() -> None:
    """The foot gives a little, as if the tines were longer by a part of their width."""
    slender = FORK.model_copy(update={"width": 2.0, "element_size": 2.0})
    low, high = frequencies(slender.model_dump(), "foot", "left inner")[:2]
    expected = 1.8751041**2 / (2 * np.pi * 0.1**2) * np.sqrt(2e11 * 0.002**2 / 12 / 7800)
    for frequency in (low, high):
        longer = np.sqrt(expected / frequency) - 1  # f is as 1 / length^2
        assert 0 < longer < 2.0 / 100
    assert high - low < 0.02 * low


def test_shrouded_blade_has_the_frequency_of_a_cantilever_with_a_rigid_tip() -> None:
    """Rayleigh-Ritz over polynomials, with mass, moment and inertia of the plate at the tip."""
    length, width, wide, high = 0.1, 0.006, 0.04, 0.004
    stiffness, line = 2e11 * width**3 / 12, 7800.0 * width
    mass = 7800.0 * wide * high
    inertia = mass * (wide**2 + high**2) / 12
    p = np.arange(2, 8)
    total = p[:, None] + p
    curvature = np.outer(p * (p - 1), p * (p - 1)) / (total - 3) / length**3 * stiffness
    tip, slope = np.ones(len(p)), p / length
    centre = tip + slope * high / 2
    kinetic = line * length / (total + 1) + mass * np.outer(centre, centre)
    kinetic = kinetic + inertia * np.outer(slope, slope)
    lowest = np.sqrt(np.linalg.eigvals(np.linalg.solve(kinetic, curvature)).real.min())
    found = frequencies(SHROUD.model_dump(), "root", "shroud right")[0]
    assert found == pytest.approx(lowest / (2 * np.pi), rel=0.01)
