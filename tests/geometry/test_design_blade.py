"""Blades of a design table: areas, angles and frequencies against closed forms."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from built_meshes import Mesh, build
from mpi4py import MPI
from pydantic import ValidationError

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry import Blade
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import study_from

ROW = {"r": 1000.0, "chord": 40.0, "stagger": 0.0, "thickness": 4.0}


def design(*rows: dict[str, float], **keys: Any) -> Blade:
    """A blade in mm through rows that begin as ROW."""
    table = [{**ROW, **row} for row in rows]
    return Blade.model_validate({"length_unit": "mm", "element_size": 4.0, "design": table, **keys})


def unrolled(points: np.ndarray, radius: float) -> np.ndarray:
    """Points of a cylinder in its plane (x, r theta)."""
    return np.column_stack([points[:, 0], radius * np.arctan2(points[:, 1], points[:, 2])])


def section_polygon(blade: Blade, number: int) -> np.ndarray:
    """Outline of a section in the plane of its cylinder, as lofted."""
    one, other = blade.lines()[number].sides
    radius = float(np.hypot(*one[0, 1:]))
    return unrolled(np.vstack([one, other[::-1]]), radius)


def area(polygon: np.ndarray) -> float:
    x, y = polygon.T
    return float(abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2)


def test_a_constant_biconvex_section_has_the_volume_of_its_area_times_the_span() -> None:
    """Also on strongly curved cylinders, staggered and cambered: the unrolled area counts."""
    rows = [{"r": r, "stagger": 30.0, "camber": 20.0, "edge_thickness": 1.0} for r in (60.0, 90.0)]
    mesh = build(design(*rows, profile="biconvex", element_size=1.5))
    half = np.radians(20) / 2
    length = 40.0 * half / np.sin(half)  # of the circular arc over its chord
    assert mesh.volume == pytest.approx(length * (1 + 3 * 2 / 3) * 30, rel=2e-3)
    assert mesh.worst_shape > 0.15


def test_naca_sections_have_the_area_of_the_closed_four_digit_series() -> None:
    """Area 0.681 t c, less the cut of the nose, plus half the opened trailing edge."""
    blade = design({}, {"r": 1100.0}, edge_cut=1e-4)
    polygon = section_polygon(blade, 0)
    xi = np.array([2 / 3, 1 / 2, 1 / 3, 1 / 4, 1 / 5])
    closed = 10 * 4.0 * 40.0 * np.array([0.2969, -0.1260, -0.3516, 0.2843, -0.1036]) @ xi
    assert area(polygon) == pytest.approx(closed + 0.4 * 40 / 2, rel=5e-3)
    assert np.ptp(polygon[:, 1]) == pytest.approx(4.0 + 0.3 * 0.4, rel=2e-3)
    assert polygon.mean(axis=0)[1] == pytest.approx(0.0, abs=1e-9)


def chord_angle(points: np.ndarray) -> float:
    """Angle of the line through the ends of a section from the axis, in degrees."""
    first, last = (points[np.isclose(points[:, 0], x, atol=0.5)] for x in ends(points))
    return float(np.degrees(np.arctan2(*(last - first.mean(axis=0)).mean(axis=0)[::-1])))


def ends(points: np.ndarray) -> tuple[float, float]:
    return points[:, 0].min(), points[:, 0].max()


@pytest.fixture(scope="module")
def twisted() -> Mesh:
    """A slender twisted blade of thin sections in mm."""
    root = {"r": 200.0, "stagger": 20.0, "camber": 30.0, "thickness": 3.0}
    tip = {"r": 280.0, "stagger": 55.0, "chord": 30.0, "thickness": 1.5}
    return build(design(root, tip, element_size=3.0))


def test_stagger_is_that_of_the_mesh(twisted: Mesh) -> None:
    for name, radius, stagger in (("root", 200.0, 20.0), ("tip", 280.0, 55.0)):
        points = unrolled(twisted.nodes(name), radius)
        assert chord_angle(points) == pytest.approx(stagger, abs=0.5)
    assert twisted.worst_shape > 0.15


def test_camber_is_the_turning_of_the_mean_line() -> None:
    """A circular arc: largest camber c / 2 tan(camber / 4), towards larger theta if positive."""
    camber = 40.0
    row = {"camber": camber, "edge_thickness": 0.5}
    one, other = design(row, {**row, "r": 1100.0}, profile="biconvex").lines()[0].sides
    mean = unrolled((one + other) / 2, 1000.0)
    height = np.ptp(mean[:, 1])
    assert height == pytest.approx(20 * np.tan(np.radians(camber) / 4), rel=1e-2)
    assert mean[15, 1] > mean[0, 1]
    first, last = np.diff(mean, axis=0)[[0, -1]]
    turned = np.degrees(np.arctan2(first[1], first[0]) - np.arctan2(last[1], last[0]))
    assert turned == pytest.approx(camber, rel=5e-3)


def test_lean_and_sweep_move_a_section() -> None:
    straight = design({}, {"r": 1100.0})
    moved = design({}, {"r": 1100.0, "lean": 7.0, "sweep": -3.0})
    shift = section_polygon(moved, -1) - section_polygon(straight, -1)
    np.testing.assert_allclose(shift, np.broadcast_to([-3.0, 7.0], shift.shape), atol=1e-9)


def test_a_table_in_a_file_gives_the_same_blade_in_any_units(tmp_path: Path) -> None:
    camber = 20 * np.tan(np.radians(30) / 4)
    file = tmp_path / "design.csv"
    file.write_text(
        "# made for a test\n"
        "r_m,chord_cm,stagger_deg,camber_mm,thickness_mm,edge_thickness_mm,lean_mm\n"
        f"0.2,4,20,{camber:.12g},4,0.5,1\n0.3,3,50,0,2,0.3,0\n"
    )
    common: dict[str, Any] = {"length_unit": "mm", "element_size": 4.0, "profile": "biconvex"}
    root = {"r": 200.0, "stagger": 20.0, "camber": 30.0, "edge_thickness": 0.5, "lean": 1.0}
    tip = {"r": 300.0, "chord": 30.0, "stagger": 50.0, "thickness": 2.0, "edge_thickness": 0.3}
    for one, other in zip(
        Blade(sections=file, **common).lines(), design(root, tip, **common).lines(), strict=True
    ):
        np.testing.assert_allclose(one.sides, other.sides, atol=1e-6)


def test_first_frequency_is_that_of_a_slender_beam() -> None:
    """Flap of a constant biconvex section, in its plane of least stiffness."""
    span, chord, thickness, edge = 0.4, 0.04, 0.004, 0.0038
    row = {"chord": chord, "stagger": 0.0, "thickness": thickness, "edge_thickness": edge}
    study = {
        "mesh": {
            "model": "blade",
            "design": [{**row, "r": 50.0}, {**row, "r": 50.0 + span}],
            "profile": "biconvex",
            "element_size": 0.02,
        },
        "body": {"theory": "solid", "degree": 2},
        "material": {"young": 2e11, "poisson": 0.0, "density": 7800.0},
        "clamp": {"facets": "root"},
        "contact": {"facets": "tip", "direction": [0.0, 1.0, 0.0], "gap": 1e-3, "points": 4},
        "reduction": {"modes": 3},
    }
    analysis = linear_analysis(study_from(study, Path("study.toml")), MPI.COMM_SELF)
    xi, weight = np.polynomial.legendre.leggauss(12)
    height = edge + 4 * (thickness - edge) * (xi + 1) / 2 * (1 - xi) / 2
    inertia, section = (weight / 2 * chord * power for power in (height**3 / 12, height))
    stiffness = 2e11 * inertia.sum() / (7800.0 * section.sum())
    expected = 1.8751041**2 / (2 * np.pi * span**2) * np.sqrt(stiffness)
    assert analysis.reduction.model.omega[0] / (2 * np.pi) == pytest.approx(expected, rel=1e-2)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"edge_thickness": 4.0}, "edge_thickness = 4: must be below thickness"),
        ({"thickness": 30.0}, "thickness = 30: must be at most half the chord"),
        ({"stagger": 95.0}, "less than 90"),
        ({"r": 2000.0}, "r must rise from section to section"),
        ({"twist": 1.0}, "twist"),
    ],
)
def test_wrong_design_sections_are_refused(change: dict[str, float], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        design(change, {"r": 1100.0})


BAD_TABLES = {
    "column chord_m or .* is given 2 times": "r_m,chord_m,chord_mm,stagger_deg,thickness_m",
    "column stagger_deg is missing": "r_m,chord_m,thickness_m",
    "column twist_deg: is not one of": "r_m,chord_m,stagger_deg,thickness_m,twist_deg",
    "column camber_deg or .* is given 2 times": (
        "r_m,chord_m,stagger_deg,thickness_m,camber_deg,camber_mm"
    ),
    "line 2: stagger = 120: must be less than 90": "r_m,chord_m,stagger_deg,thickness_m",
}


@pytest.mark.parametrize("message", BAD_TABLES)
def test_wrong_design_tables_are_refused_in_a_line(tmp_path: Path, message: str) -> None:
    header = BAD_TABLES[message]
    values = ["1", "0.1", "120", "0.01", "0", "0"][: header.count(",") + 1]
    file = tmp_path / "design.csv"
    file.write_text(f"{header}\n{','.join(values)}\n")
    with pytest.raises(GeometryError, match=message) as raised:
        Blade(sections=file, element_size=0.01).lines()
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"first_section": 2}, "first_section: belongs to a table of sections"),
        ({"casing": [[-1.0, 1.0], [1.0, 1.0]]}, "clearance: is missing"),
        ({"clearance": 1.0}, "casing: is missing"),
        ({"block": {"blades": 9, "bore": 9.0, "overhang": 1.0}}, "hub: is missing"),
        ({"sections": "table.csv"}, "design: does not go with sections"),
    ],
)
def test_keys_that_do_not_go_together_are_refused(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        design({}, {"r": 1100.0}, **keys)
