"""Blades cut by hub and casing, root blocks and fillets, against closed forms."""

from pathlib import Path
from typing import Any

import gmsh
import numpy as np
import pytest
from built_meshes import Mesh, assert_facets_bound_cells, build, facet_area
from scipy.interpolate import PchipInterpolator

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry import Blade
from fenics_nnm.geometry.walls import Wall

MESHES = Path(__file__).parents[2] / "meshes"
WALLS = MESHES / "rotor37_hub_shroud.csv"
RADIUS, SPAN, CHORD = 1000.0, 60.0, 40.0
THICK, EDGE = 4.0, 2.0
BLOCK = {"blades": 60, "bore": RADIUS - 20, "overhang": 12.0, "fillet": 5.0}
AREA = CHORD * (EDGE + 2 / 3 * (THICK - EDGE))


def prism(span: float = SPAN, **keys: Any) -> Blade:
    """A straight biconvex blade in mm on a hub of constant radius."""
    row = {"chord": CHORD, "stagger": 0.0, "thickness": THICK, "edge_thickness": EDGE}
    study = {
        "length_unit": "mm",
        "element_size": 4.0,
        "profile": "biconvex",
        "design": [{**row, "r": RADIUS}, {**row, "r": RADIUS + span}],
        "hub": [[-100.0, RADIUS], [100.0, RADIUS]],
        **keys,
    }
    return Blade.model_validate(study)


def shroud_radius_mm(x_mm: np.ndarray) -> np.ndarray:
    """Casing of rotor 37 as monotone cubics, read without the package."""
    rows = [line.split(",") for line in WALLS.read_text().splitlines() if line.startswith("shroud")]
    z, r = np.array([[float(cell) for cell in row[1:]] for row in rows]).T * 10
    return np.asarray(PchipInterpolator(z, r)(x_mm))


@pytest.fixture(scope="module")
def rotor37() -> Mesh:
    return build(
        Blade(
            sections=MESHES / "rotor37_blade_sections.csv",
            length_unit="mm",
            hub=WALLS,
            casing=WALLS,
            clearance=0.356,
            element_size=3.0,
        )
    )


def test_tip_follows_the_casing_at_its_clearance(rotor37: Mesh) -> None:
    x, y, z = rotor37.nodes("tip").T
    radius = np.hypot(y, z)
    clearance = shroud_radius_mm(x) - radius
    np.testing.assert_allclose(clearance, 0.356, atol=1e-6 * radius.max())
    assert np.ptp(radius) > 1, "the casing is a cone"


def table_volume_mm3(file: Path, last: int) -> float:
    """Integral of r (theta1 - theta2) dr dz over the first sections of a table in feet."""
    rows = np.loadtxt(file, delimiter=",", comments=("#", "section"))
    corners = np.stack([rows[rows[:, 0] == s, 2:] for s in range(1, last + 1)])
    z, r, one, other = np.moveaxis(corners, 2, 0)
    width = r * (one - other)
    dz, dr = z[1:, 1:] - z[:-1, :-1], r[1:, 1:] - r[:-1, :-1]
    ez, er = z[:-1, 1:] - z[1:, :-1], r[:-1, 1:] - r[1:, :-1]
    middle = (width[1:, 1:] + width[:-1, 1:] + width[1:, :-1] + width[:-1, :-1]) / 4
    return float((np.abs(dz * er - dr * ez) / 2 * middle).sum() * 304.8**3)


def test_rotor_67_has_the_volume_and_the_length_of_its_table() -> None:
    file = MESHES / "rotor67_blade_sections.csv"
    blade = Blade(sections=file, length_unit="mm", last_section=14, element_size=8.0)
    mesh = build(blade)
    assert mesh.volume == pytest.approx(table_volume_mm3(file, 14), rel=1e-2)
    assert mesh.worst_shape > 0.15
    radius = np.hypot(*mesh.points[:, 1:].T)
    expected = np.array([0.313693, 0.838238]) * 304.8  # table: leading edge at hub and casing
    assert (radius.min(), radius.max()) == pytest.approx(expected, abs=0.3)


def test_cut_blade_is_a_sound_mesh(rotor37: Mesh) -> None:
    assert set(rotor37.groups) == {"body", "root", "tip", "surface"}
    assert_facets_bound_cells(rotor37)
    assert rotor37.worst_shape > 0.2
    assert len(np.unique(rotor37.groups["body"])) == len(rotor37.points)


def test_conical_casing_gives_the_volume_below_the_cone() -> None:
    """Between a cylinder and a cone; the sections end before the cone and are continued."""
    mesh = build(
        prism(casing=[[-50.0, RADIUS + SPAN - 5], [50.0, RADIUS + SPAN + 15]], clearance=2.0)
    )
    x, y, z = mesh.nodes("tip").T
    np.testing.assert_allclose(np.hypot(y, z), RADIUS + SPAN + 3 + 0.2 * x, rtol=1e-9)
    np.testing.assert_allclose(np.hypot(*mesh.nodes("root")[:, 1:].T), RADIUS, rtol=1e-9)
    assert mesh.volume == pytest.approx(AREA * (SPAN + 3), rel=2e-3)


@pytest.fixture(scope="module")
def filleted() -> Mesh:
    return build(prism(block=BLOCK, element_size=3.0))


def volumes(blade: Blade) -> dict[str, float]:
    """Exact volumes of the parts, before meshing."""
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("test")
        blade.build(gmsh.model)
        found = {}
        for dim, group in gmsh.model.getPhysicalGroups(3):
            tags = gmsh.model.getEntitiesForPhysicalGroup(dim, group)
            name = gmsh.model.getPhysicalName(dim, group)
            found[name] = sum(gmsh.model.occ.getMass(3, tag) for tag in tags)
        return found
    finally:
        gmsh.finalize()


@pytest.mark.parametrize("radius", [2.0, 5.0])
def test_fillet_adds_what_a_circular_arc_adds(radius: float) -> None:
    """Area (1 - pi / 4) r^2 along both sides and edges, and the mitred corners between them.

    The cross-section of a corner at the angle phi of the arc is the square of r (1 - sin phi).
    """
    found = volumes(prism(block={**BLOCK, "fillet": radius}, element_size=8.0))
    rise = THICK - EDGE
    sides = 2 * (CHORD + 2 / 3 * rise**2 / CHORD)  # length of shallow arcs
    corners = 4 * radius**3 * (1 - np.pi / 2 + 2 / 3)
    added = (1 - np.pi / 4) * radius**2 * (sides + 2 * EDGE) + corners
    assert found["collar"] - AREA * radius == pytest.approx(added, rel=2e-2)
    assert found["blade"] == pytest.approx(AREA * (SPAN - radius), rel=1e-3)
    block = (RADIUS**2 - (RADIUS - 20) ** 2) * np.pi / 60 * (CHORD + 24)
    assert found["block"] == pytest.approx(block, rel=1e-9)


def test_sector_has_its_groups(filleted: Mesh) -> None:
    names = {"root", "bore", "sides", "ends", "platform", "fillet", "surface", "tip"}
    assert names < set(filleted.groups)
    assert {"block", "collar", "blade", "body"} < set(filleted.groups)
    assert_bounded(filleted, names)
    assert filleted.worst_shape > 0.15
    height = 20 * (CHORD + 24)
    assert facet_area(filleted, "sides") == pytest.approx(2 * height, rel=1e-6)
    arc = 2 * np.pi / 60 * (RADIUS**2 - (RADIUS - 20) ** 2) / 2
    assert facet_area(filleted, "ends") == pytest.approx(2 * arc, rel=1e-4)
    np.testing.assert_allclose(np.hypot(*filleted.nodes("bore")[:, 1:].T), RADIUS - 20, rtol=1e-9)
    heights = np.hypot(*filleted.nodes("fillet")[:, 1:].T) - RADIUS
    assert (heights.min(), heights.max()) == pytest.approx((0, 5), abs=1e-6)


def assert_bounded(mesh: Mesh, names: set[str]) -> None:
    groups = {name: mesh.groups[name] for name in (*names, "body")}
    assert_facets_bound_cells(mesh._replace(groups=groups))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (
            {"block": {"blades": 1000, "bore": 980.0, "overhang": 9.0, "fillet": 3.0}},
            "is narrower than the foot",
        ),
        ({"block": {"blades": 60, "bore": 1010.0, "overhang": 9.0}}, "must be below the radius"),
        (
            {"block": {"blades": 60, "bore": 980.0, "overhang": 3.0, "fillet": 4.0}},
            "overhang = 3: must be larger than fillet = 4",
        ),
        (
            {"block": {"blades": 60, "bore": 980.0, "overhang": 30.0, "fillet": 19.0}},
            "fillet = 19: is too large for the blade",
        ),
        ({"hub": [[-100.0, 900.0], [100.0, 900.0]]}, "mesh.hub: lies up to 100 beyond"),
        ({"hub": [[100.0, 1000.0], [-100.0, 1000.0]]}, "mesh.hub: x must rise"),
        ({"hub": [[-100.0, 1100.0], [100.0, 1100.0]]}, "mesh.hub: all sections"),
        ({"hub": MESHES / "README.md"}, "line 5: 4 cells, must be 1"),
    ],
)
def test_what_does_not_fit_is_refused_in_a_line(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(GeometryError, match=message) as raised:
        build(prism(**keys))
    assert "\n" not in str(raised.value)


def test_wall_is_a_monotone_cubic_and_straight_beyond_its_ends() -> None:
    x, r = np.array([0.0, 1.0, 3.0, 4.0]), np.array([1.0, 1.0, 2.0, 4.0])
    wall, reference = Wall.through(x, r), PchipInterpolator(x, r)
    inside = np.linspace(0, 4, 17)
    np.testing.assert_allclose(wall.at(inside), reference(inside), atol=1e-14)
    part = wall.between(-1.0, 3.5)
    beyond = np.linspace(-1, 3.5, 19)
    np.testing.assert_allclose(part.at(beyond), wall.at(beyond), atol=1e-14)
    assert wall.at(np.array([5.0]))[0] == pytest.approx(4 + reference(4.0, 1))
