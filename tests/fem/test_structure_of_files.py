"""What changes a structure in files of other programs is followed or refused by name and line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from brick_beams import SIZE, bdf, bricks, inp, nodes
from conftest import BEAM, Ended
from mpi4py import MPI

from fenics_nnm.errors import MeshError
from fenics_nnm.fem.mesh import TaggedMesh, read_mesh

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]


def read(path: Path, text: str, unit: str = "m") -> TaggedMesh:
    path.write_text(text)
    return read_mesh(path, unit, MPI.COMM_SELF)


LINE = len(inp().splitlines())

REFUSED = [
    ("*RIGID BODY, ANALYTICAL SURFACE=s, REF NODE=1", "*RIGID BODY with ANALYTICAL SURFACE"),
    ("*FASTENER, INTERACTION NAME=f\n1", "*FASTENER"),
    ("*CONNECTOR SECTION, ELSET=c\nWELD", "*CONNECTOR SECTION"),
    ("*DASHPOT, ELSET=e\n1\n1e3", "*DASHPOT"),
    ("*CYCLIC SYMMETRY MODEL, N=12, TIE=t\n0, 0, 0, 0, 0, 1", "*CYCLIC SYMMETRY MODEL"),
    ("*TIE, CYCLIC SYMMETRY, NAME=t\na, b", "*TIE of cyclic symmetry"),
    ("*PRE-TENSION SECTION, SURFACE=a, NODE=9", "*PRE-TENSION SECTION"),
    ("*CONTACT PAIR, INTERACTION=i, TIED\na, b", "*CONTACT PAIR with TIED"),
    ("*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TIED\n1e9", "*SURFACE BEHAVIOR with TIED"),
    ("*EMBEDDED ELEMENT\nEall", "*EMBEDDED ELEMENT"),
    ("*NONSTRUCTURAL MASS, UNITS=TOTAL MASS\n1.", "*NONSTRUCTURAL MASS"),
    ("*SUBSTRUCTURE PATH", "*SUBSTRUCTURE PATH"),
    ("*INITIAL CONDITIONS, TYPE=STRESS\nEall, 1e9", "*INITIAL CONDITIONS"),
    ("*SYSTEM\n0, 0, 1", "*SYSTEM"),
    ("*NGEN\n1, 9, 1", "*NGEN"),
]


@pytest.mark.parametrize(("text", "name"), REFUSED, ids=[name for _, name in REFUSED])
def test_keywords_that_change_the_structure_are_refused(
    text: str, name: str, tmp_path: Path
) -> None:
    with pytest.raises(MeshError) as error:
        read(tmp_path / "a.inp", inp(f"** here\n{text}"))
    message = str(error.value)
    assert f"line {LINE + 1}: {name} cannot be followed: it " in message or "NGEN" in message
    assert "\n" not in message


def test_what_the_study_states_is_left_out_and_listed(tmp_path: Path) -> None:
    rest = """*MATERIAL, NAME=S
*ELASTIC
2.1e11, .3
*solid section, elset=Eall, material=S
*ORIENTATION, NAME=o
*TRANSFORM, NSET=Nall
*BOUNDARY
1, 1, 3
*NODE
99, 0.3, 0, 0
*COUPLING, REF NODE=99, SURFACE=s, CONSTRAINT NAME=c
*DISTRIBUTING
*NODE PRINT, NSET=Nall
U
*STEP
*FREQUENCY
4
*EQUATION, REMOVE=ALL
*MPC
BEAM, 1, 2
*END STEP"""
    notes = read(tmp_path / "a.inp", inp(rest)).notes
    assert notes[0].startswith("not read: *MATERIAL, *ELASTIC, *SOLID SECTION, *ORIENTATION, ")
    assert "*TRANSFORM, *BOUNDARY, which the study states" in notes[0]
    assert notes[1].startswith("not read: *STEP, *FREQUENCY, *EQUATION, *MPC, *END STEP, ")
    assert "*DISTRIBUTING of node 99" in notes[2]


@pytest.mark.parametrize("remove", ["REMOVE ALL", "REMOVE=ALL", "REMOVEALL"])
def test_equations_that_are_removed_again_are_none(remove: str, tmp_path: Path) -> None:
    equation = "*EQUATION\n2\n1, 1, 1., 2, 1, -1.\n"
    assert read(tmp_path / "a.inp", inp(f"{equation}*EQUATION, {remove}")).dim == 3
    with pytest.raises(MeshError, match=rf"line {LINE}: \*EQUATION"):
        read(tmp_path / "a.inp", inp(f"{equation}*EQUATION, REMOVE\n1, 1, 1"))


def test_two_couplings_of_one_node_join_their_surfaces(tmp_path: Path) -> None:
    twice = "*COUPLING, REF NODE=9, SURFACE={}, CONSTRAINT NAME=c\n*DISTRIBUTING\n"
    with pytest.raises(MeshError, match="reference node 9 is that of"):
        read(tmp_path / "a.inp", inp(twice.format("a") + twice.format("b")))


#: The second half of a beam with nodes of its own, 100 higher, tied to the first half.
TIED = """*NODE
{nodes}
*ELEMENT, TYPE=C3D8, ELSET=second
{elements}
*SURFACE, NAME=end
4, S4
*SURFACE, NAME=start
101, S6
*TIE, NAME=t, POSITION TOLERANCE=1e-5
start, end
"""


def tied(shift: float) -> str:
    moved = nodes((4, 1, 1)) + np.array([SIZE[0] + shift, 0, 0])
    listed = [", ".join(map(str, (i + 101, *x))) for i, x in enumerate(moved.tolist())]
    rows = [[i + 101, *(node + 100 for node in row)] for i, row in enumerate(bricks((4, 1, 1)))]
    elements = [", ".join(map(str, row)) for row in rows]
    return inp(TIED.format(nodes="\n".join(listed), elements="\n".join(elements)))


def test_ties_of_nodes_at_the_same_places_merge_them(tmp_path: Path) -> None:
    tagged = read(tmp_path / "a.inp", tied(0.0))
    assert len(tagged.mesh.geometry.x) == len(nodes((8, 1, 1)))
    assert "*TIE of start and end: 4 nodes are merged" in tagged.notes
    with pytest.raises(MeshError, match=r"4 of 4 nodes of start have no node of end"):
        read(tmp_path / "a.inp", tied(1e-3))


CARDS = [
    "RBE1,9,1,123456,,,,,,UM,2,123",
    "RBE3,9,,1,123,1.,123,2,UM",
    "RBAR,9,1,2,123,456",
    "RJOINT,9,1,2,123456",
    "CELAS2,9,1.+3,1,1,2,1",
    "CELAS2,9,1.+3,1,4",
    "CONM2,9,1,,1.,.1",
    "CBUSH,9,1,1,2",
    "CDAMP2,9,1.,1,1",
    "CONROD,9,1,2,1,.1",
    "CGAP,9,1,1,2",
    "DMIG,K2,0,6,1",
    "BGSET,1,1,2,3",
    "XYZZY,1",
]


@pytest.mark.parametrize("card", CARDS)
def test_cards_that_change_the_structure_are_refused(card: str, tmp_path: Path) -> None:
    line = len(bdf(card).splitlines()) - 1
    with pytest.raises(MeshError, match=rf"line {line}: {card.split(',')[0]} cannot be followed"):
        read(tmp_path / "a.dat", bdf(card))


GROUPS = {"root": {"x": 0.0}, "pad": {"box": {"from": [0.15, -1.0, 0.0099], "to": [1.0, 1.0, 1.0]}}}


@pytest.fixture
def checked(study_file: StudyFile, command: Command, tmp_path: Path) -> Callable[..., str]:
    """What check says of a beam in a file of Nastran, with its first frequency."""

    def check(rest: str, **changes: Any) -> str:
        (tmp_path / "beam.bdf").write_text(bdf(rest, (8, 1, 1)))
        study = study_file(
            BEAM,
            mesh={"=": {"file": "beam.bdf", "length_unit": "m"}},
            groups={"=": GROUPS},
            clamp={"facets": "root"},
            contact={"facets": "pad"},
            **changes,
        )
        ended = command("check", study)
        assert ended.code == 0, ended.err
        return ended.out

    return check


def first(out: str) -> float:
    return float(next(line.split()[1] for line in out.splitlines() if line.split()[:1] == ["1"]))


#: The node at the tip, in the middle of nothing: a corner.
TIP = 9
PLACE = [0.2, 0.0, 0.0]


def test_masses_and_springs_of_nastran_are_those_of_the_study(
    checked: Callable[..., str],
) -> None:
    """CONM2 and CELAS to the ground against [[mass]] and [[spring]]."""
    plain = first(checked(""))
    mass = checked(f"CONM2,900,{TIP},,0.1,,,,\n,1.-6,,1.-6")
    assert "0.1 kg at the vertex (0.2, 0, 0) m" in mass
    assert first(mass) == first(checked("", mass={"mass": 0.1, "at": PLACE}))
    spring = first(checked(f"CELAS2,901,1.+5,{TIP},3\nCELAS1,902,7,,,{TIP},2\nPELAS,7,2.+5"))
    own = {"stiffness": [0.0, 2e5, 1e5], "at": PLACE}
    assert spring == pytest.approx(first(checked("", spring=own)), rel=1e-9)
    assert first(mass) < 0.9 * plain and spring > 1.1 * plain


def test_masses_of_unknown_units_are_refused(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"CONM2 cannot be followed: the unit .*\[\[mass\]\]"):
        read(tmp_path / "a.bdf", bdf("CONM2,900,9,,0.1"), "mm")


TWICE = [
    (lambda n: "*ELEMENT, TYPE=C3D8\n77, " + ", ".join(map(str, bricks(n)[1])), "77 has the nodes"),
    (lambda n: "*ELEMENT, TYPE=C3D8\n77, " + ", ".join(map(str, long_brick(n))), "overlap"),
    (lambda n: "*ELEMENT, TYPE=C3D8\n2, " + ", ".join(map(str, bricks(n)[0])), "2 stands twice"),
    (lambda n: "*NODE\n2, 5, 5, 5", "node 2 stands twice"),
]


def long_brick(n: tuple[int, int, int]) -> list[int]:
    """A brick over the first two."""
    one, two = bricks(n)[:2]
    return [one[0], two[1], two[2], one[3], one[4], two[5], two[6], one[7]]


@pytest.mark.parametrize(("more", "words"), TWICE)
def test_elements_that_stand_twice_or_overlap(
    more: Callable[..., str], words: str, tmp_path: Path
) -> None:
    with pytest.raises(MeshError, match=words):
        read(tmp_path / "a.inp", inp(more((4, 1, 1))))


def test_parts_that_share_their_volume_are_refused(tmp_path: Path) -> None:
    """A copy with nodes of its own, half a brick along the beam."""
    with pytest.raises(MeshError, match=r"elements overlap: .* lies both in"):
        read(tmp_path / "a.inp", tied(-0.125).replace("*TIE", "*HEADING"))


def test_node_numbers_to_spare_are_left_out(tmp_path: Path) -> None:
    text = inp().replace("\n1, 1, 2, 7, 6, 11, 12, 17, 16", "\n1, 1, 2, 7, 6, 11, 12, 17, 16, 0, 0")
    assert "2 numbers to spare" in read(tmp_path / "a.inp", text).notes[-1]


def test_skins_and_lines_are_left_out_and_told(tmp_path: Path) -> None:
    """Triangles on quadrangles, lines along edges, a rigid wall that does not touch."""
    rest = """*ELEMENT, TYPE=S3, ELSET=skin
80, 1, 2, 7
81, 1, 7, 6
*ELEMENT, TYPE=T3D2, ELSET=edge
82, 1, 2
*NODE
91, 9, 0, 0
92, 9, 1, 0
93, 9, 1, 1
*ELEMENT, TYPE=M3D3, ELSET=wall
83, 91, 92, 93"""
    tagged = read(tmp_path / "a.inp", inp(rest))
    assert '3 triangles of "skin", "wall" are no facets of the body: left out' in tagged.notes
    assert '1 lines of "edge" are no facets of the body: left out' in tagged.notes
    assert len(tagged.mesh.geometry.x) == len(nodes((4, 1, 1)))


SYSTEMS = """CORD2R,1,0,0.,0.,0.,0.,0.,1.,+
+,0.,1.,0.
CORD2C,2,1,0.,0.,0.,0.,0.,1.,+
+,1.,0.,0.
CORD2S,3,0,0.,0.,0.,0.,0.,1.,+
+,1.,0.,0.
CORD1R,4,101,102,103
GRID,101,,1.,1.,1.
GRID,102,,1.,1.,2.
GRID,103,,2.,1.,1.
GRID,1,1,0.,-1.,0.
GRID,2,2,1.,0.,0.
GRID,3,3,1.,90.,45.
GRID,4,4,0.,0.,1.
CTETRA,1,1,1,2,3,4
"""


def test_grids_in_systems_of_their_own(tmp_path: Path) -> None:
    """System 1 has its x axis along y; 2 is a cylinder in it; 3 a sphere; 4 begins at (1, 1, 1)."""
    (tmp_path / "systems.inc").write_text(SYSTEMS)
    tagged = read(tmp_path / "a.dat", "SOL 103\nBEGIN BULK\nINCLUDE 'systems.inc'\nENDDATA\n")
    half = np.sqrt(0.5)
    wanted = [[1, 0, 0], [0, 1, 0], [half, half, 0], [1, 1, 2]]
    x = tagged.mesh.geometry.x[np.argsort(tagged.mesh.geometry.input_global_indices)]
    np.testing.assert_allclose(x, wanted, atol=1e-12)


def test_nodes_of_abaqus_in_cylindrical_coordinates(tmp_path: Path) -> None:
    text = "*NODE, SYSTEM=C\n1, 1, 0, 0\n2, 1, 90, 0\n3, 0, 0, 0\n4, 0, 0, 2\n"
    tagged = read(tmp_path / "a.inp", f"{text}*ELEMENT, TYPE=C3D4\n1, 3, 1, 2, 4\n")
    x = tagged.mesh.geometry.x
    np.testing.assert_allclose(
        sorted(x.tolist()), [[0, 0, 0], [0, 0, 2], [0, 1, 0], [1, 0, 0]], atol=1e-12
    )


def test_lines_of_gmsh_in_nastran_are_left_out(tmp_path: Path) -> None:
    assert "1 lines" in read(tmp_path / "a.bdf", bdf("CBAR,77,9,1,2,0.,0.,0.")).notes[-1]


def test_parts_that_are_not_joined_are_named(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    (tmp_path / "a.inp").write_text(tied(0.0).replace("*TIE", "*HEADING"))
    study = study_file(
        BEAM,
        mesh={"=": {"file": "a.inp", "length_unit": "m"}},
        groups={"=": {"root": {"x": 0.0}, "tip": {"x": 0.4}}},
        clamp={"facets": "root"},
        contact={"facets": "tip"},
    )
    ended = command("check", study)
    ended.assert_one_line(
        *(2, "6 rigid-body modes found", "2 parts without common nodes", "[0.2, 0.4] x"),
        *("4 pairs of nodes lie at one place, one at (0.2, ", "merge the nodes"),
    )
