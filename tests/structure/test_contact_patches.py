"""Several patches, gaps from casings, stops on both sides: by closed forms, from study files."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from conftest import BEAM, PLATE, ROD, Ended, changed, toml
from fork_mesh import fork, fork_study
from mpi4py import MPI
from small_meshes import QUADRANGLE, explicit

from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.results.resume import difference
from fenics_nnm.structure.analysis import linear_analysis, nonlinear_mode
from fenics_nnm.study import read_study, study_from

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

UP = {"facets": "right", "direction": [0.0, 0.0, 1.0], "gap": 1e-3}
SIDE = {"name": "side", "facets": "right", "direction": [0.0, 1.0, 0.0], "gap": 3e-3, "points": 2}


def analysed(base: dict[str, Any], folder: Path = Path(), **changes: Any) -> LinearAnalysis:
    study = study_from(changed(base, changes), folder / "study.toml")
    analysis = linear_analysis(study, MPI.COMM_SELF)
    assert isinstance(analysis, LinearAnalysis)
    return analysis


def interface(contact: dict[str, Any], base: dict[str, Any] = BEAM) -> ContactInterface:
    return analysed(base, contact={"=": contact}, reduction={"modes": 2}).interface


def test_patches_are_those_of_their_own_studies_one_after_the_other() -> None:
    both = interface({"patch": [UP, SIDE]})
    alone = [interface(UP), interface(SIDE)]
    for name in ("points", "directions", "areas", "gap"):
        whole = np.concatenate([getattr(part, name) for part in alone])
        np.testing.assert_array_equal(getattr(both, name), whole)
    assert both.names == ("right", "side")
    np.testing.assert_array_equal(both.patch, [0, 0, 0, 0, 1, 1])
    motion = np.random.default_rng(1).normal(size=(3 * both.weights.shape[1], 2))
    expected = np.vstack([part.displacement(motion) for part in alone])
    np.testing.assert_array_equal(both.displacement(motion), expected)
    np.testing.assert_allclose(both.unit_forces(len(motion)).T @ motion, expected, rtol=1e-13)


@pytest.mark.parametrize(("letter", "vector"), [("z", [0.0, 0.0, 1.0]), ("-y", [0.0, -1.0, 0.0])])
def test_directions_along_an_axis_are_vectors(letter: str, vector: list[float]) -> None:
    named, given = (interface({**UP, "direction": each}) for each in (letter, vector))
    np.testing.assert_array_equal(named.directions, np.tile(vector, (len(named.points), 1)))
    np.testing.assert_array_equal(named.directions, given.directions)


def test_shared_vertices_move_once_in_all_directions() -> None:
    both = interface({"patch": [UP, SIDE]})
    owned = 3 * both.weights.shape[1]
    forces = both.unit_forces_all_directions(owned)
    assert forces.shape == (owned, 12)
    np.testing.assert_array_equal(forces, interface(UP).unit_forces_all_directions(owned))


@pytest.mark.parametrize("base", [PLATE, BEAM])
@pytest.mark.parametrize("points", ["all", 2])
def test_averaged_rows_are_means_over_the_hats(base: dict[str, Any], points: int | str) -> None:
    """Of u = y^2 on a face: int h y^2 / int h, with the hat functions of one element each way."""
    contact = {**base["contact"], "points": points, "rows": "averaged"}
    analysis = analysed(base, contact={"=": contact}, reduction={"modes": 2})
    found = analysis.interface
    places = analysis.solid.space.tabulate_dof_coordinates()
    dim = found.points.shape[1]
    height = 0.25 if dim == 2 else 0.15
    field = np.zeros((len(places), dim))
    field[:, -1] = (places[:, 1] / height) ** 2
    low, high = 1 / 6, 1 / 2  # int (1 - s) s^2 / int (1 - s), int s^3 / int s
    expected = np.where(found.points[:, 1] > height / 2, high, low)
    np.testing.assert_allclose(found.displacement(field.reshape(-1, 1))[:, 0], expected, rtol=1e-12)
    np.testing.assert_allclose(found.weights.sum(axis=1), 1, rtol=1e-13)


CASING = {"axis": "x", "origin": [0.0, 0.07, 0.02]}


@pytest.mark.parametrize(
    ("casing", "radius"),
    [
        ({"shape": "cylinder", "radius": 0.2}, 0.2),
        ({"shape": "cylinder", "radius": 0.2, "clearance": 1e-3}, 0.2),
        ({"shape": "cone", "radius": 0.1, "half_angle_deg": math.degrees(math.atan(0.1))}, 0.2),
        ({"shape": "cone", "radius": 0.3, "end_radius": 0.1, "length": 2.0}, 0.2),
        ({"shape": "lobed", "radius": 0.2, "lobes": 3, "amplitude": 1e-15}, 0.2),
        (
            {"shape": "lobed", "profile": [[0, 0.1], [2, 0.3]], "lobes": 3, "amplitude": 1e-15},
            0.2,
        ),
    ],
)
def test_gap_to_a_round_casing_along_a_vector(casing: dict[str, Any], radius: float) -> None:
    """Points of the face x = 1 below the arc z = z_0 + sqrt(R^2 - (y - y_0)^2)."""
    found = interface({**UP, "gap": None, "casing": {**CASING, **casing}})
    y, z = found.points[:, 1], found.points[:, 2]
    gap = np.sqrt(radius**2 - (y - 0.07) ** 2) - (z - 0.02) + casing.get("clearance", 0.0)
    np.testing.assert_allclose(found.gap, gap, rtol=0, atol=1e-12 * radius)


def test_direction_towards_the_casing_is_radial_in_a_cylinder() -> None:
    cylinder = {"shape": "cylinder", "radius": 0.2, **CASING}
    found = interface({"facets": "right", "direction": "casing", "casing": cylinder})
    away = found.points[:, 1:] - [0.07, 0.02]
    distance = np.linalg.norm(away, axis=1)
    np.testing.assert_allclose(found.directions[:, 1:], away / distance[:, None], atol=1e-14)
    np.testing.assert_allclose(found.directions[:, 0], 0, atol=1e-15)
    np.testing.assert_allclose(found.gap, 0.2 - distance, rtol=1e-13)


def test_casings_of_bodies_in_one_and_two_dimensions() -> None:
    plane = {"shape": "plane", "origin": [1.002], "normal": [1.0], "clearance": 5e-4}
    rod = interface({"facets": "right", "direction": [1.0], "casing": plane}, ROD)
    np.testing.assert_allclose(rod.gap, [2.5e-3], rtol=1e-12)
    ring = {"shape": "cylinder", "axis": "z", "origin": [0.5, 0.0], "radius": 0.7}
    plate = interface({"facets": "right", "direction": "casing", "casing": ring}, PLATE)
    away = np.linalg.norm(plate.points - [0.5, 0.0], axis=1)
    np.testing.assert_allclose(plate.gap, 0.7 - away, rtol=1e-12)


def test_table_of_radii_is_found_beside_the_study(tmp_path: Path) -> None:
    rows = [f"{90 * i},{x},{0.2 + 0.01 * x}" for i in range(4) for x in (0, 2)]
    (tmp_path / "casing.csv").write_text("\n".join(["theta_deg,x_m,r_m", *rows]))
    casing = {"shape": "table", "file": "casing.csv", **CASING}
    contact = {"=": {"facets": "right", "direction": "casing", "casing": casing}}
    found = analysed(BEAM, tmp_path, contact=contact).interface
    distance = np.linalg.norm(found.points[:, 1:] - [0.07, 0.02], axis=1)
    np.testing.assert_allclose(found.gap, (0.21 - distance) / math.hypot(1, 0.01), rtol=1e-9)


def slender(path: Path) -> dict[str, Any]:
    """A cantilever in the plane; of three vertices on each face that at 0.4 m can meet a stop."""
    xs, ys = [0.0, 0.25, 0.3, 0.4, 0.7, 1.0], np.linspace(-0.02, 0.02, 3)

    def node(i: int, j: int) -> int:
        return i * len(ys) + j + 1

    nodes = [(float(x), float(y), 0.0) for x in xs for y in ys]
    cells = [
        [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]
        for i in range(5)
        for j in range(2)
    ]
    edges = {
        "left": [[node(0, 0), node(0, 1)], [node(0, 1), node(0, 2)]],
        "upper": [[node(i, 2), node(i + 1, 2)] for i in (1, 2)],
        "lower": [[node(i, 0), node(i + 1, 0)] for i in (1, 2)],
    }
    explicit(path, nodes, {QUADRANGLE: cells}, edges)
    stops = [
        {"facets": name, "direction": [0.0, side], "gap": 1e-3, "points": 1}
        for name, side in (("upper", 1.0), ("lower", -1.0))
    ]
    return changed(
        PLATE,
        {
            "mesh": {"=": {"file": path.name, "length_unit": "m"}},
            "contact": {"=": {"patch": stops}},
            "reduction": {"modes": 1},
            "mode": {"harmonics": 9, "samples": 256},
            "continuation": {"energies": {"from": 0.9, "to": 2.0, "step": 0.55}},
        },
    )


def test_stops_on_both_sides_give_the_trilinear_oscillator(tmp_path: Path) -> None:
    """One mode: free flight between the stops, and a stiffer half sine in each of them.

    With e the amplitude at grazing, k = omega^2 and K = phi^2 / R: a flight from stop to stop
    takes 2 asin(e sqrt(k / 2E)) / sqrt(k), a contact 2 acos(e k / sqrt(2E (K + k) - K k e^2)) /
    sqrt(K + k), and the period is two of each.
    """
    base = slender(tmp_path / "slender.msh")
    study = study_from(base, tmp_path / "study.toml")
    analysis = linear_analysis(study, MPI.COMM_SELF)
    model = analysis.model
    np.testing.assert_allclose(model.Phi[0], -model.Phi[1], rtol=1e-9)
    branch = nonlinear_mode(study, analysis)
    assert branch.complete
    k, e = model.omega[0] ** 2, 1e-3 / abs(model.Phi[0, 0])
    K = model.Phi[0, 0] ** 2 / model.R[0, 0]
    np.testing.assert_allclose(analysis.interface.points[:, 0], 0.4)
    for point in branch.points[-2:]:
        E = point.motion.energy
        flight = 2 / math.sqrt(k) * math.asin(e * math.sqrt(k / (2 * E)))
        contact = 2 / math.sqrt(K + k)
        contact *= math.acos(e * k / math.sqrt(2 * E * (K + k) - K * k * e**2))
        assert point.motion.frequency == pytest.approx(1 / (2 * (flight + contact)), rel=3e-5)
        odd = np.abs(point.motion.q[1::2]).max()
        assert np.abs(point.motion.q[::2]).max() < 1e-9 * odd
        assert point.motion.force.max(axis=0).min() > 0
    assert branch.points[-1].frequency_ratio > 1.05


def test_results_tell_of_each_patch(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    study = study_file(BEAM, contact={"=": {"patch": [UP, SIDE]}})
    shown = command("check", study).out
    assert "contact          6 points, 0.03 m^2" in shown
    assert "  right: 4 points, 0.015 m^2, gap 0.001 m, towards (0, 0, 1)\n" in shown
    assert "  side: 2 points, 0.015 m^2, gap 0.003 m, towards (0, 1, 0)\n" in shown
    assert command("run", study, "--output", "out").code == 0
    patches = json.loads((tmp_path / "out" / "summary.json").read_text())["contact_patches"]
    assert [patch["name"] for patch in patches] == ["right", "side"]
    assert patches[1]["smallest_gap_m"] == patches[1]["largest_gap_m"] == 3e-3
    with h5py.File(tmp_path / "out" / "branch.h5") as file:
        np.testing.assert_array_equal(file["contact/patches"][:], [0, 0, 0, 0, 1, 1])
        assert list(file["contact/patch_names"][:]) == [b"right", b"side"]


def test_an_only_patch_has_one_name_everywhere(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """Where its value is refused, where another study is resumed, and where it is used."""
    only, wider, bad = (
        {**BEAM, "contact": {"patch": [{**UP, **gap}]}}
        for gap in ({}, {"gap": 2e-3}, {"gap": "wide"})
    )
    told = difference(toml(only), toml(wider))
    assert told == f"contact.patch[1].gap was {UP['gap']:g} and is 0.002 now"
    command("check", study_file(bad)).assert_one_line(2, 'contact.patch[1].gap = "wide"')
    contact = read_study(study_file(only)).contact
    assert list(contact.patches) == ["contact.patch[1]"]


def test_what_lies_beside_the_other_side_is_left_out(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    fork(tmp_path / "fork.msh", right=12)
    values = fork_study(tmp_path / "fork.msh", facets="right tine", against="left tine")
    shown = command("check", study_file(values)).out
    assert "right tine: 7 points" in shown
    assert "1 vertices with nothing opposite left out" in shown


CYLINDER = {"shape": "cylinder", "axis": "x", "radius": 0.2}
PATCHES: list[tuple[dict[str, Any], str, str]] = [
    ({"gap": "wide"}, 'contact.patch[2].gap = "wide"', "initial gap in m"),
    ({"gap": None}, "contact.patch[2].gap: is missing", "casing"),
    ({"gap": [1.0]}, "contact.patch[2].gap = [1.0]", "one number"),
    ({"gapp": 1.0}, "contact.patch[2].gapp: unknown key", 'did you mean "gap"'),
    ({"facets": None}, "contact.patch[2].facets: is missing", "name of a group"),
    ({"facets": "tip"}, 'contact.patch[2].facets = "tip"', "no such group"),
    ({"against": "tip", "gap": None}, 'contact.patch[2].against = "tip"', "no such group"),
    ({"against": "left", "gap": None}, 'contact.patch[2].against = "left"', "must lie opposite"),
    ({"direction": "radial"}, 'contact.patch[2].direction = "radial"', "needs axis"),
    ({"direction": [1.0]}, "contact.patch[2].direction = [1.0]", "must have 3 components"),
    ({"direction": "casing"}, 'contact.patch[2].direction = "casing"', "needs a section casing"),
    ({"points": 9}, "contact.patch[2].points = 9", "only 4 vertices"),
    (
        {"direction": [0, 0, -1]},
        "contact.patch[2]: the point at (1, 0, 0) m",
        "along the same line",
    ),
    (
        {"rows": "averaged", "gap": None, "against": "left"},
        'contact.patch[2].rows = "averaged"',
        "does not go with against",
    ),
    ({"name": "up"}, 'contact.patch: 2 have the name "up"', "must differ"),
    ({"casing": CYLINDER}, "contact.patch[2].gap: does not go with casing", "clearance"),
    (
        {"gap": None, "casing": {**CYLINDER, "radius": "wide"}},
        'contact.patch[2].casing.radius = "wide"',
        "radius at the origin in m",
    ),
    (
        {"gap": None, "casing": {**CYLINDER, "radius": None}},
        "contact.patch[2].casing.radius: is missing",
        'shape = "cylinder" needs radius (radius at the origin in m',
    ),
    (
        {"gap": None, "casing": {**CYLINDER, "lobes": 2}},
        "contact.patch[2].casing.lobes: does not belong",
        '"cylinder"',
    ),
    (
        {"gap": None, "casing": {**CYLINDER, "shape": "round"}},
        'contact.patch[2].casing.shape = "round"',
        '"cone"',
    ),
    (
        {"gap": None, "casing": {**CYLINDER, "shape": "cone"}},
        'contact.patch[2].casing.shape = "cone"',
        "either half_angle_deg or end_radius and length",
    ),
    (
        {"gap": None, "casing": {**CYLINDER, "shape": "table", "radius": None, "file": "no.csv"}},
        "contact.patch[2].casing: ",
        "no.csv: cannot be read",
    ),
    (
        {"gap": None, "casing": {**CYLINDER, "origin": [0.0, 0.0, 5.0]}},
        "contact.patch[2].casing: the point at (1, 0, 0) m",
        "does not meet the casing",
    ),
]


@pytest.mark.parametrize(("change", "named", "right"), PATCHES)
def test_wrong_key_of_a_patch_is_named_with_its_number(
    change: dict[str, Any], named: str, right: str, study_file: StudyFile, command: Command
) -> None:
    second = changed(SIDE, change)
    study = study_file(BEAM, contact={"=": {"patch": [{**UP, "name": "up"}, second]}})
    command("check", study).assert_one_line(2, named, right)


WHOLE: list[tuple[Any, str, str]] = [
    (
        {"patch": [UP], "gap": 1.0},
        "contact.gap: belongs to one of the patches",
        "[[contact.patch]]",
    ),
    ({"patch": []}, "contact.patch = []", "too few items"),
    ({"patch": [3]}, "contact.patch = [3]", "must be a section with keys"),
    ([UP, SIDE], "contact: is a list of sections", "[[contact.patch]]"),
]


@pytest.mark.parametrize(("contact", "named", "right"), WHOLE)
def test_wrong_list_of_patches(
    contact: Any, named: str, right: str, study_file: StudyFile, command: Command
) -> None:
    command("check", study_file(BEAM, contact={"=": contact})).assert_one_line(2, named, right)
