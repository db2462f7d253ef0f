"""Archives of Ansys: blocks of nodes, elements and components, shrunken shapes, middle nodes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from brick_beams import bricks, cdb, eblock, nodes
from mpi4py import MPI

from fenics_nnm.errors import MeshError
from fenics_nnm.fem.boundary import boundary
from fenics_nnm.fem.cell_shapes import shape_of
from fenics_nnm.fem.mesh import TaggedMesh, read_mesh, spread_mesh
from fenics_nnm.fem.mesh_file import ReadMesh

N = (4, 1, 1)
COMPONENTS = """CMBLOCK,ROOT,NODE,       4  ! users node component definition
(8i10)
         1         6        11        16
CMBLOCK,TIP     ,NODE,       6
(8i10)
         5        10        15        20         1        -3
CMBLOCK,HALF,ELEM,       2
(8i10)
         1        -2"""


def read(path: Path, text: str, unit: str = "m") -> TaggedMesh:
    path.write_text(text)
    return read_mesh(path, unit, MPI.COMM_SELF)


def areas(tagged: TaggedMesh, name: str) -> tuple[float, float]:
    """Area of a group and its middle along x."""
    surface = boundary(tagged.mesh)
    chosen = surface.mask(tagged.facets[name]) != 0
    return float(surface.areas[chosen].sum()), float(surface.centres[chosen][:, 0].mean())


@pytest.mark.parametrize("ending", ["cdb", "dat", "inp"])
@pytest.mark.parametrize("width", [8, 9, 10])
def test_components_of_nodes_and_elements(width: int, ending: str, tmp_path: Path) -> None:
    tagged = read(tmp_path / f"a.{ending}", cdb(COMPONENTS, N, width=width))
    assert tagged.mesh.topology.cell_name() == "hexahedron"
    assert areas(tagged, "ROOT") == pytest.approx((2e-4, 0.0))
    assert areas(tagged, "TIP") == pytest.approx((2e-4, 0.2))
    counts = {name: len(cells) for name, cells in tagged.cells.items()}
    assert counts == {"HALF": 2, "TYPE 1": 4, "MAT 1": 4, "body": 4}


def quadratic(cells: list[list[int]], x: np.ndarray) -> tuple[str, list[list[int]]]:
    """Nodes between those of hexahedra whose corners may stand twice, and all rows."""
    known: dict[tuple[int, int], int] = {}
    lines, rows = [], []
    for row in cells:
        full = list(row)
        for a, b in shape_of("hexahedron").edges:
            ends = min(row[a], row[b]), max(row[a], row[b])
            if ends[0] == ends[1]:
                full.append(ends[0])
                continue
            if ends not in known:
                known[ends] = len(x) + len(known) + 1
                middle = (x[ends[0] - 1] + x[ends[1] - 1]) / 2
                values = "".join(f"{value:21.13E}" for value in middle)
                lines.append(f"{known[ends]:9d}{0:9d}{0:9d}{values}")
            full.append(known[ends])
        rows.append(full)
    return "\n".join(["NBLOCK,6,SOLID", "(3i9,6e21.13e3)", *lines, "N,R5.3,LOC,       -1,"]), rows


def shrunken(n: tuple[int, int, int]) -> list[list[int]]:
    """The last brick as two prisms, written as hexahedra with nodes that stand twice."""
    *whole, last = bricks(n)
    a, b, c, d, e, f, g, h = last
    return [*whole, [a, b, c, c, e, f, g, g], [a, c, d, d, e, g, h, h]]


@pytest.mark.parametrize("kind", [185, 45])
def test_hexahedra_with_prisms(kind: int, tmp_path: Path) -> None:
    text = cdb(COMPONENTS, N, kind=kind).replace(eblock(bricks(N)), eblock(shrunken(N)))
    tagged = read(tmp_path / "a.cdb", text)
    assert "5 hexahedra are split into 24 tetrahedra" in tagged.notes
    assert areas(tagged, "TIP") == pytest.approx((2e-4, 0.2))
    assert areas(tagged, "ROOT") == pytest.approx((2e-4, 0.0))


@pytest.mark.parametrize("kind", [186, 95])
def test_quadratic_hexahedra_with_prisms(kind: int, tmp_path: Path) -> None:
    block, rows = quadratic(shrunken(N), nodes(N))
    text = cdb("", N, kind=kind).replace(eblock(bricks(N)), f"{block}\n{eblock(rows)}")
    tagged = read(tmp_path / "a.cdb", text)
    assert "5 hexahedra are split into 24 tetrahedra" in tagged.notes
    surface = boundary(tagged.mesh)
    assert surface.areas.sum() == pytest.approx(2 * (2e-4 + 2e-3 + 4e-3))


def test_middle_nodes_that_are_left_out_lie_half_way(tmp_path: Path) -> None:
    block, rows = quadratic(bricks(N), nodes(N))
    some = [row[:8] + [0 if i % 3 else node for i, node in enumerate(row[8:])] for row in rows]
    text = cdb("", N, kind=186).replace(eblock(bricks(N)), f"{block}\n{eblock(some)}")
    tagged = read(tmp_path / "a.cdb", text)
    surface = boundary(tagged.mesh)
    assert surface.areas.sum() == pytest.approx(2 * (2e-4 + 2e-3 + 4e-3))
    assert any("middle nodes that the file leaves out" in note for note in tagged.notes)
    linear = [[*row[:8], *[0] * 12] for row in rows]
    tagged = read(
        tmp_path / "a.cdb", cdb("", N, kind=186).replace(eblock(bricks(N)), eblock(linear))
    )
    assert len(tagged.mesh.geometry.x) == len(nodes(N))


def test_tetrahedra_of_both_kinds(tmp_path: Path) -> None:
    """Each brick in six, as SOLID285 of 4 nodes, or SOLID185 of 8 with nodes that stand twice."""
    parts = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
    four = [[row[i] for i in part] for row in bricks(N) for part in parts]
    eight = [[a, b, c, c, d, d, d, d] for a, b, c, d in four]
    for kind, rows in ((285, four), (185, eight)):
        text = cdb(COMPONENTS, N, kind=kind).replace(eblock(bricks(N)), eblock(rows))
        tagged = read(tmp_path / "a.cdb", text.replace("1        -2", "1       -12"))
        assert tagged.mesh.topology.index_map(3).size_global == 24
        assert len(tagged.cells["HALF"]) == 12
        assert areas(tagged, "TIP") == pytest.approx((2e-4, 0.2))


#: Surface elements without SOLID, as Workbench writes them.
SURFACE = "ET,2,154\nTYPE,2\nEBLOCK,10\n(15i9)\n" + "".join(
    f"{value:9d}" for value in [90, 2, 1, 1, 0, 1, 2, 7, 6]
)


def test_surface_elements_are_a_group(tmp_path: Path) -> None:
    tagged = read(tmp_path / "a.dat", cdb(f"{SURFACE}\n{-1:9d}"))
    assert areas(tagged, "TYPE 2") == pytest.approx((0.05 * 0.02, 0.025))


def test_edges_under_pressure_and_the_unit_of_the_file_are_told(tmp_path: Path) -> None:
    """SURF153 of two nodes stands on edges of plane bodies; /UNITS has no effect in Ansys."""
    edge = SURFACE.replace("154", "153").replace(f"{7:9d}{6:9d}", "")
    tagged = read(tmp_path / "a.dat", cdb(f"/UNITS,MPA\n{edge}\n{-1:9d}"))
    assert "1 surface elements are left out" in tagged.notes
    assert '/UNITS,MPA: says that lengths are in "mm"' in tagged.notes


REFUSED = [
    ("CE,R5.0,DEFI,   2,  1,  0.0", "CE cannot be followed: it joins nodes"),
    ("CP,1,UX,1,2", "CP cannot be followed"),
    ("EN,1,1,2,3,4", "EN cannot be followed: must be NBLOCK and EBLOCK"),
    (SURFACE.replace("154", "174") + f"\n{-1:9d}", "element 90, CONTA174 with 4 nodes"),
    (SURFACE.replace("154", "21") + f"\n{-1:9d}", "element 90, MASS21 with 4 nodes"),
    ("/INPUT,other,inp", "must be one file"),
    ("NUMM,NODE", "NUMM cannot be followed: it merges nodes"),
    ("FINISH $ CYCLIC", "CYCLIC cannot be followed: it joins the two sides"),
    ("N,R5.3,LOC,-1,\nNDELE,3", "NDELE cannot be followed: must be left out"),
    ("ET,5,182\nKEYOP,5,3,1", "KEYOP cannot be followed: elements of type 5 are axisymmetric"),
    ("ET,5,PLANE183,,,5", "ET cannot be followed: elements of type 5 are of generalised plane"),
]


@pytest.mark.parametrize(("rest", "words"), REFUSED)
def test_what_changes_the_structure_is_refused(rest: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(MeshError) as error:
        read(tmp_path / "a.cdb", cdb(rest))
    assert words in str(error.value) and ", line " in str(error.value)


def test_damaged_archives_are_refused_in_one_line(tmp_path: Path) -> None:
    text, path = cdb(COMPONENTS), tmp_path / "a.cdb"
    for place in range(0, len(text), 97):
        for damaged in (text[:place], f"{text[:place]}x{text[place + 1 :]}"):
            path.write_text(damaged)
            try:
                spread_mesh(lambda: ReadMesh(path)(tmp_path), 1.0, MPI.COMM_SELF)
            except MeshError as error:
                assert "\n" not in str(error)
