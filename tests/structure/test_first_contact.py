"""First contact does not depend on how many vertices of a patch are contact points."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PLATE, Ended, changed
from fork_mesh import fork, fork_study
from mpi4py import MPI

from fenics_nnm.errors import GeometryError
from fenics_nnm.fem.contact_sites import contact_sites
from fenics_nnm.fem.mesh import generate_mesh
from fenics_nnm.fem.patch_sites import Patch
from fenics_nnm.fem.regions import Region
from fenics_nnm.fem.solid import Body, assemble_solid
from fenics_nnm.geometry import Plate
from fenics_nnm.materials.elasticity import Isotropic
from fenics_nnm.materials.material import Material
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.structure.first_contact import FirstContact
from fenics_nnm.structure.mesh_structure import MeshLinear, MeshStructure
from fenics_nnm.structure.shared_analysis import SharedAnalysis
from fenics_nnm.study import MeshStudy, study_from

COMM = MPI.COMM_SELF

#: The free part of the upper edge of a plate clamped at both ends: 15 vertices.
SPAN = {"facets": "span", "direction": [0.0, 1.0], "gap": 1e-3}
ARCH: dict[str, Any] = changed(
    PLATE,
    {
        "mesh": {"elements": [16, 1]},
        "clamp": {"facets": ["left", "right"]},
        "groups": {"span": {"facets": "top", "box": {"from": [0.06, -1.0], "to": [0.8, 1.0]}}},
        "contact": {"=": SPAN},
        "reduction": {"modes": 4},
    },
)


def study(**changes: Any) -> MeshStudy:
    found = study_from(changed(ARCH, changes), Path("study.toml"))
    assert isinstance(found, MeshStudy)
    return found


def linear(**changes: Any) -> MeshLinear:
    return MeshStructure(study(**changes)).linear(COMM, Stages())


@pytest.mark.parametrize("method", ["massless", "craig-bampton"])
@pytest.mark.parametrize("number", [1, 2, 3])
def test_first_contact_is_that_of_all_vertices(number: int, method: str) -> None:
    changes = {"mode": {"number": number}, "reduction": {"method": method}}
    everywhere = linear(**changes).first_contact(number - 1)
    assert not everywhere.limited
    for points in (1, 2, 4):
        found = linear(contact={"points": points}, **changes).first_contact(number - 1)
        assert (found.points, found.vertices) == (points, everywhere.points)
        if method == "massless":  # another basis for other points with mass
            assert found.energy == pytest.approx(everywhere.energy, rel=1e-9)
        assert found.over_all == pytest.approx(found.energy, rel=5e-3)
        assert found.warning == ""


def test_even_points_alone_would_be_far_off() -> None:
    """Without a choice by the mode the two ends of the span would be the points."""
    tips = {"facets": "span", "direction": [0.0, 1.0], "gap": 1e-3, "points": 2}
    third = linear(contact={"=": tips}, mode={"number": 1})
    assert not np.allclose(np.sort(third.interface.points[:, 0]), [0.0625, 0.75])
    even = third.sites.parts[0].points[:, 0]
    np.testing.assert_allclose([even.min(), even.max()], [0.0625, 0.75])
    motion = np.abs(third.sites.displacement(third.modes.shapes[:, :1])[:, 0])
    assert motion.max() > 1.5 * motion[[np.argmin(even), np.argmax(even)]].max()


def test_points_about_a_pressed_state_are_those_that_touch_first() -> None:
    pressed = {**SPAN, "facets": "pad", "direction": [0.0, -1.0], "gap": -2e-4, "name": "pad"}
    groups = {"pad": {"facets": "bottom", "box": {"from": [0.05, -1.0], "to": [0.2, 1.0]}}}
    found = []
    for points in (2, "all"):
        patches = {"patch": [{**pressed, "points": 2}, {**SPAN, "points": points}]}
        one = linear(contact={"=": patches}, groups=groups, mode={"number": 2})
        assert one.model.at_rest().closed.any()
        found.append(one.first_contact(1))
    assert found[0].energy == pytest.approx(found[1].energy, rel=2e-3)
    assert found[0].over_all == pytest.approx(found[1].over_all, rel=2e-3)


def test_another_mode_has_other_points_in_a_shared_analysis() -> None:
    shared = SharedAnalysis()
    for number, made in ((1, 1), (1, 1), (3, 2)):
        wanted = study(contact={"points": 2}, mode={"number": number})
        found, alone = shared(wanted, COMM), MeshStructure(wanted).linear(COMM, Stages())
        np.testing.assert_array_equal(found.body.interface.points, alone.interface.points)
        assert shared.made == made


def test_patches_that_meet_do_not_take_the_same_vertex() -> None:
    groups = {
        name: {"facets": "top", "box": {"from": [low, -1.0], "to": [high, 1.0]}}
        for name, low, high in (("span", 0.06, 0.51), ("rest", 0.49, 0.95))
    }
    one, other = {**SPAN, "points": 1}, {**SPAN, "facets": "rest", "points": 1}
    found = linear(contact={"=": {"patch": [one, other]}}, groups=groups)
    np.testing.assert_allclose(found.interface.points[:, 0], [0.4375, 0.5])


def test_a_vertex_without_an_obstacle_in_its_way_is_never_in_contact() -> None:
    def gap(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
        if (points[:, 0] > 0.9).any():
            raise GeometryError("does not meet the casing")
        return 1e-3 * points[:, 0]

    tagged = generate_mesh(Plate(length=1.0, height=0.25, elements=(4, 1)), COMM)
    region = Region(Material(Isotropic(1.0, 0.3), 1.0))
    body = Body("plane-stress", (region,), extent=0.1, degree=1)
    solid = assemble_solid(tagged, body, tagged.facets_of(("bottom",), "clamp.facets"))
    up = lambda points, normals: np.tile([0.0, 1.0], (len(points), 1))  # noqa: E731
    facets = tagged.facets_of(("top",), "contact.facets")
    sites = contact_sites(solid, [Patch("contact", "top", facets, "top", up, gap, count=2)])
    order = np.argsort(sites.points[:, 0])
    np.testing.assert_allclose(sites.gap[order], [0, 2.5e-4, 5e-4, 7.5e-4, np.inf])


def test_vertices_of_facing_patches_move_as_their_contact_points(tmp_path: Path) -> None:
    fork(tmp_path / "fork.msh", right=8)
    facing = {"facets": "right tine", "against": "left tine", "points": 2}
    values = fork_study(tmp_path / "fork.msh", **facing)
    found = linear_analysis(study_from(values, tmp_path / "study.toml"), COMM)
    assert isinstance(found, MeshLinear)
    motion = np.random.default_rng(2).normal(size=(found.solid.owned, 2))
    chosen = found.choices[0].chosen
    assert len(found.sites.gap) == 5
    np.testing.assert_array_equal(
        found.sites.displacement(motion)[chosen], found.interface.displacement(motion)
    )
    np.testing.assert_array_equal(found.sites.gap[chosen], found.interface.gap)


def test_first_contact_that_depends_on_the_points_is_warned_about() -> None:
    assert FirstContact(3, 9, 1.009, 1.0).warning == ""
    warning = FirstContact(3, 9, 1.5, 1.0).warning
    assert "1.5 J at the 3 contact points, 50 % above the 1 J of all 9 vertices" in warning
    assert "all 9 vertices are contact points" in str(FirstContact(9, 9, 1.0, 1.0))
    assert str(FirstContact(3, 9, 1.0 + 1e-15, 1.0)).endswith("contact points are 0 % above that")
    assert str(FirstContact(3, 9, 1.0 + 2e-8, 1.0)).endswith("are 2e-06 % above that")


def test_check_and_summary_tell_both_energies(
    study_file: Callable[..., Path], command: Callable[..., Ended], tmp_path: Path
) -> None:
    below = {"energies": {"from": 0.8, "to": 0.9, "step": 0.1}, "shooting": False}
    changes = {"contact": {"points": 3}, "reduction": {"modes": 2}, "continuation": {"=": below}}
    file = study_file(base=ARCH, **changes)
    checked = command("check", file)
    assert "with all 12 vertices it is at" in checked.out
    command("run", file, "--output", tmp_path / "out")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    first = summary["first_contact"]
    assert (first["contact_points"], first["vertices"]) == (3, 12)
    assert first["energy_J"] == summary["grazing_energy_J"]
    assert first["over_all_vertices_J"] == pytest.approx(first["energy_J"], rel=2e-3)
    assert abs(first["above_all_vertices_percent"]) < 0.2
