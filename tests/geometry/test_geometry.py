"""Built-in geometries: sizes, named groups, element shapes and errors."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from built_meshes import Mesh, assert_facets_bound_cells, build, facet_area
from pydantic import TypeAdapter, ValidationError
from scipy.interpolate import CubicSpline

from fenics_nnm.geometry import Beam, Blade, Geometry, Plate, Rod

ROTOR37 = Path(__file__).parents[2] / "meshes" / "rotor37_blade_sections.csv"


def test_rod_has_equal_intervals_between_named_ends() -> None:
    mesh = build(Rod(length=2.5, elements=5))
    assert set(mesh.groups) == {"body", "left", "right"}
    np.testing.assert_allclose(np.sort(mesh.points[:, 0]), np.linspace(0, 2.5, 6), atol=1e-12)
    lengths = np.ptp(mesh.points[mesh.groups["body"]][:, :, 0], axis=1)
    np.testing.assert_allclose(lengths, 0.5)
    assert mesh.nodes("left")[0, 0] == 0
    assert mesh.nodes("right")[0, 0] == 2.5


@pytest.mark.parametrize(("cells", "count"), [("triangle", 24), ("quadrilateral", 12)])
def test_plate_fills_the_rectangle(cells: Any, count: int) -> None:
    mesh = build(Plate(length=3.0, height=2.0, elements=(4, 3), cells=cells))
    assert len(mesh.groups["body"]) == count
    assert mesh.volume == pytest.approx(6.0)
    assert len(mesh.points) == 5 * 4
    expected: dict[str, Any] = {
        "left": [[0, 0, 0], [0, 2, 0]],
        "right": [[3, 0, 0], [3, 2, 0]],
        "bottom": [[0, 0, 0], [3, 0, 0]],
        "top": [[0, 2, 0], [3, 2, 0]],
    }
    assert set(mesh.groups) == {"body", *expected}
    for name, box in expected.items():
        np.testing.assert_allclose(mesh.box(name), box, atol=1e-12)


@pytest.mark.parametrize(("cells", "count"), [("tetrahedron", 144), ("hexahedron", 24)])
def test_tapered_beam_has_the_volume_of_a_frustum(cells: Any, count: int) -> None:
    beam = Beam(length=4.0, width=1.0, height=0.5, tip_scale=0.6, elements=(4, 3, 2), cells=cells)
    mesh = build(beam)
    assert len(mesh.groups["body"]) == count
    assert mesh.volume == pytest.approx(4.0 * 0.5 * (1 + 0.6 + 0.6**2) / 3)
    assert mesh.worst_shape > 0.2
    assert_facets_bound_cells(mesh)
    assert facet_area(mesh, "left") == pytest.approx(0.5)
    assert facet_area(mesh, "right") == pytest.approx(0.5 * 0.6**2)
    np.testing.assert_allclose(mesh.box("right"), [[4, 0.2, 0.1], [4, 0.8, 0.4]])
    np.testing.assert_allclose(mesh.box("front"), [[0.0, 0, 0], [4, 0.2, 0.5]], atol=1e-12)
    np.testing.assert_allclose(mesh.box("back"), [[0, 0.8, 0], [4, 1, 0.5]], atol=1e-12)
    np.testing.assert_allclose(mesh.box("bottom"), [[0.0, 0, 0], [4, 1, 0.1]], atol=1e-12)
    np.testing.assert_allclose(mesh.box("top"), [[0, 0, 0.4], [4, 1, 0.5]], atol=1e-12)


@pytest.fixture(scope="module")
def rotor37() -> Iterator[Mesh]:
    yield build(Blade(sections=ROTOR37, last_section=12, element_size=3.0, length_unit="mm"))


def table_mm(section: int) -> np.ndarray:
    """Rows z, r (mm), theta1, theta2 of a section, read without the package."""
    rows = np.loadtxt(ROTOR37, delimiter=",", comments=("#", "section"))
    rows = rows[rows[:, 0] == section, 2:]
    rows[:, :2] *= 10
    return rows


def table_volume(last: int) -> float:
    """Integral of r (theta1 - theta2) dr dz over the table, in mm^3; noses included."""
    z, r, angle1, angle2 = np.stack([table_mm(s).T for s in range(1, last + 1)], axis=1)
    width = r * (angle1 - angle2)
    (dz, dr), (ez, er) = (
        (c[1:, 1:] - c[:-1, :-1] for c in (z, r)),
        (c[:-1, 1:] - c[1:, :-1] for c in (z, r)),
    )
    area = np.abs(dz * er - dr * ez) / 2
    middle = (width[1:, 1:] + width[:-1, :-1] + width[:-1, 1:] + width[1:, :-1]) / 4
    return float((area * middle).sum())


def test_blade_volume_is_the_integral_of_the_table(rotor37: Mesh) -> None:
    assert rotor37.volume == pytest.approx(table_volume(12), rel=5e-3)


def test_blade_groups_and_element_shapes(rotor37: Mesh) -> None:
    assert set(rotor37.groups) == {"body", "root", "tip", "surface"}
    assert rotor37.worst_shape > 0.25
    assert 3000 < len(rotor37.groups["body"]) < 8000
    assert len(np.unique(rotor37.groups["body"])) == len(rotor37.points), "nodes of no element"
    assert_facets_bound_cells(rotor37)


def beside_table_mm(mesh: Mesh, name: str, section: int) -> np.ndarray:
    """Distance of end nodes from the two table sides, along the circumference; (nodes, 2)."""
    x, y, z = mesh.nodes(name).T
    axial, _, *angles = table_mm(section).T
    sides = np.stack([CubicSpline(axial, angle)(x) for angle in angles], axis=1)
    return (np.arctan2(y, z)[:, None] - sides) * np.hypot(y, z)[:, None]


@pytest.mark.parametrize(("name", "section"), [("root", 1), ("tip", 12)])
def test_blade_ends_lie_on_their_table_sections(rotor37: Mesh, name: str, section: int) -> None:
    x, y, z = rotor37.nodes(name).T
    axial, radius, *_ = table_mm(section).T
    assert np.abs(np.hypot(y, z) - np.interp(x, axial, radius)).max() < 0.04
    beside = beside_table_mm(rotor37, name, section)
    assert beside[:, 0].max() < 0.02
    assert beside[:, 1].min() > -0.02


def test_blade_edges_are_cut_by_less_than_a_nose(rotor37: Mesh) -> None:
    for section, name in ((1, "root"), (12, "tip")):
        table = table_mm(section)[:, 0]
        lost = np.abs(rotor37.box(name)[:, 0] - [table.min(), table.max()])
        assert np.all(lost < 0.2)


def test_blade_tip_has_contact_points_along_both_sides(rotor37: Mesh) -> None:
    tip = rotor37.nodes("tip")
    for distance in beside_table_mm(rotor37, "tip", 12).T:
        nodes = tip[np.abs(distance) < 0.02]
        nodes = nodes[np.argsort(nodes[:, 0])]
        assert len(nodes) >= 20
        assert np.linalg.norm(np.diff(nodes, axis=0), axis=1).max() < 1.2 * 3.0


def test_blade_mesh_is_the_same_every_time(rotor37: Mesh) -> None:
    again = build(Blade(sections=ROTOR37, last_section=12, element_size=3.0, length_unit="mm"))
    np.testing.assert_array_equal(again.points, rotor37.points)


def test_blade_mesh_is_in_its_length_unit() -> None:
    metres = build(Blade(sections=ROTOR37, element_size=0.006))
    inches = build(Blade(sections=ROTOR37, element_size=0.006 / 0.0254, length_unit="in"))
    assert metres.volume == pytest.approx(table_volume(12) * 1e-9, rel=1e-2)
    assert inches.volume == pytest.approx(metres.volume / 0.0254**3, rel=1e-3)
    np.testing.assert_allclose(inches.box("tip"), metres.box("tip") / 0.0254, rtol=1e-6)


def test_a_geometry_is_told_apart_by_its_model() -> None:
    read = TypeAdapter[Any](Geometry).validate_python
    assert read({"model": "rod", "length": 1, "elements": 4}) == Rod(length=1.0, elements=4)
    plate = read({"model": "plate", "length": 1, "height": 2, "elements": [4, 5]})
    assert plate == Plate(length=1.0, height=2.0, elements=(4, 5))


@pytest.mark.parametrize(
    "wrong",
    [
        {"model": "shell"},
        {"length": -1.0},
        {"length": float("inf")},
        {"length": "1"},
        {"length": True},
        {"elements": 0},
        {"elements": 2.5},
        {"length_unit": "km"},
        {"lenght": 1.0},
    ],
)
def test_wrong_parameters_are_refused(wrong: dict[str, Any]) -> None:
    good = {"model": "rod", "length": 1.0, "elements": 4}
    with pytest.raises(ValidationError):
        TypeAdapter(Geometry).validate_python(good | wrong)


def test_blade_edges_coarser_than_the_rest_are_refused() -> None:
    with pytest.raises(ValidationError, match=r"edge_size = 2\.0: must be at most element_size"):
        Blade(sections=ROTOR37, element_size=1.0, edge_size=2.0)
