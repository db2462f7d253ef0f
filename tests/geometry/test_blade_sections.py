"""Blades from tables made here: closed-form volumes, the cut of the edges, bad tables."""

from pathlib import Path

import gmsh
import numpy as np
import pytest

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry import Blade
from fenics_nnm.geometry.section_lines import section_lines
from fenics_nnm.geometry.sections import Section, read_sections

ROTOR37 = Path(__file__).parents[2] / "meshes" / "rotor37_blade_sections.csv"
HEADER = "section,j,z_in,r_in,theta1_rad,theta2_rad"


def straight_rows(radii: list[float], points: int) -> list[str]:
    """Rows of an untwisted blade, chord 2 in, with parabolic sides at +-0.02 rad."""
    z = np.linspace(0, 2, points)
    half = 0.02 * (1 - (z - 1) ** 2)
    return [
        f"{section},{j + 1},{z[j]:.12g},{radius},{half[j]:.12g},{-half[j]:.12g}"
        for section, radius in enumerate(radii, 1)
        for j in range(points)
    ]


def write_table(folder: Path, rows: list[str], header: str = HEADER) -> Path:
    file = folder / "table.csv"
    file.write_text("\n".join(["# made for a test", header, *rows]) + "\n", encoding="utf-8")
    return file


def node_radii(group: str) -> np.ndarray:
    """Distance of the nodes of a facet group from the x axis."""
    tags = {gmsh.model.getPhysicalName(2, tag): tag for _, tag in gmsh.model.getPhysicalGroups(2)}
    _, coordinates = gmsh.model.mesh.getNodesForPhysicalGroup(2, tags[group])
    return np.hypot(*coordinates.reshape(-1, 3)[:, 1:].T)


@pytest.mark.parametrize(
    ("radii", "points"), [([10.0, 12.0], 60), ([10.0, 12.0], 9), ([10.0, 10.5, 11.5, 12.0], 25)]
)
def test_straight_blade_has_the_closed_form_volume(
    tmp_path: Path, radii: list[float], points: int
) -> None:
    file = write_table(tmp_path, straight_rows(radii, points))
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("test")
        Blade(sections=file, last_section=len(radii), element_size=0.2, length_unit="in").build(
            gmsh.model
        )
        cells = gmsh.model.mesh.getElements(3)[1][0]
        volume = gmsh.model.mesh.getElementQualities(cells, "volume").sum()
        root, tip = node_radii("root"), node_radii("tip")
    finally:
        gmsh.finalize()
    assert volume == pytest.approx((12**2 - 10**2) / 2 * 0.04 * 4 / 3, rel=1e-2)
    assert root == pytest.approx(10.0, abs=0.002)
    assert tip == pytest.approx(12.0, abs=0.003)


def test_blade_without_last_section_ends_before_the_last(tmp_path: Path) -> None:
    file = write_table(tmp_path, straight_rows([10.0, 11.0, 12.0], 9))
    sections = Blade(sections=file, element_size=1.0).selected_sections()
    assert [section.number for section in sections] == [1, 2]
    assert sections[1].radius == pytest.approx(11.0 * 0.0254)


def test_section_cut_is_perpendicular_to_a_staggered_mean_line() -> None:
    """A flat plate at 60 degrees, 1 long and 0.01 thick: strips 0.01 wide, not 0.02."""
    along = np.linspace(0, 1, 200)
    shift = 0.01 / np.cos(np.radians(60)) * np.minimum(1, np.minimum(along, 1 - along) / 0.005)
    mean, radius = np.sin(np.radians(60)) * along, np.full(200, 1e3)
    theta = np.column_stack([mean + shift / 2, mean - shift / 2]) / 1e3
    section = Section(1, np.cos(np.radians(60)) * along, radius, theta)
    one, other = section_lines(section, edge_cut=0.03, count=9).sides
    widths = np.linalg.norm(one - other, axis=1)
    assert widths[[0, -1]] == pytest.approx(0.01, rel=0.02)


ROWS = straight_rows([10.0, 11.0, 12.0], 9)
BAD_TABLES = {
    "column r_m or .* is missing": (ROWS, HEADER.replace("r_in", "r")),
    "column r_m or .* is given 2 times": ([r + ",1" for r in ROWS], HEADER + ",r_mm"),
    "column theta2_rad is missing": (ROWS, HEADER.replace("2_rad", "2_deg")),
    'line 4: r_in = "wide": must be a number': ([ROWS[0], "1,2,1,wide,0,0"], HEADER),
    'line 3: theta1_rad = "nan": must be a number': (["1,1,0,10,nan,0"], HEADER),
    "line 3: section = 1.5: must be a whole number": (["1.5,1,0,10,0,0"], HEADER),
    "line 3: r_in = -1: must be positive": (["1,1,0,-1,0,0"], HEADER),
    "line 3: 5 cells, must be 6": (["1,1,0,10,0"], HEADER),
    "has no table": ([], HEADER),
    "section 1: 3 points, must be 5 or more": (ROWS[:3] + ROWS[9:], HEADER),
    "section 1: column j must rise": ([ROWS[1], ROWS[0], *ROWS[2:]], HEADER),
    "section 2: mean radius is not larger": (straight_rows([11.0, 10.0, 12.0], 9), HEADER),
    "section 1: points 1 and 2 are the same": (
        [ROWS[0], ROWS[0].replace("1,1,", "1,2,"), *ROWS[2:]],
        HEADER,
    ),
    "section 1: theta1_rad and theta2_rad touch or cross at 50.0%": (
        [*ROWS[:4], "1,5,1,10,0.001,0.002", *ROWS[5:]],
        HEADER,
    ),
}


@pytest.mark.parametrize("message", BAD_TABLES)
def test_bad_table_is_refused_with_its_place(tmp_path: Path, message: str) -> None:
    file = write_table(tmp_path, *BAD_TABLES[message])
    with pytest.raises(GeometryError, match=rf"table\.csv: ({message})"):
        Blade(sections=file, element_size=0.01).build(None)


def test_missing_table_is_refused() -> None:
    with pytest.raises(GeometryError, match=r"nowhere\.csv: cannot be read"):
        read_sections(Path("nowhere.csv"), "m")


@pytest.mark.parametrize(
    ("first", "last", "message"),
    [(1, 14, r"last_section = 14: the table has 1\.\.13"), (5, 5, "must be larger than")],
)
def test_sections_outside_the_table_are_refused(first: int, last: int, message: str) -> None:
    blade = Blade(sections=ROTOR37, first_section=first, last_section=last, element_size=1.0)
    with pytest.raises(GeometryError, match=message):
        blade.selected_sections()
