"""Input files of Abaqus and CalculiX as users write them, and those that cannot be followed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpi4py import MPI

from fenics_nnm.errors import MeshError
from fenics_nnm.fem.boundary import boundary
from fenics_nnm.fem.mesh import TaggedMesh, read_mesh

#: Two bricks of CalculiX in a row, each 1 x 1 x 1, with all that names a part of them.
BRICKS = """
** nodes in two blocks
*Node, nset=Nall
1, 0., 0., 0.
2, 1., 0., 0.
3, 2., 0., 0.
4, 0., 1., 0.
5, 1., 1., 0.
6, 2., 1.,
*NODE
11, 0., 0., 1.
12, 1., 0., 1.
13, 2., 0., 1.
14, 0., 1., 1.
15, 1., 1., 1.
16, 2., 1., 1.
*ELEMENT, TYPE=C3D8I,
 ELSET=first
1, 1, 2, 5, 4, 11, 12,
15, 14
*ELEMENT, TYPE=C3D8I, ELSET=second
2, 2, 3, 6, 5, 12, 13, 16, 15
*ELSET, ELSET=Both
first, second
*ELSET, ELSET=Range, GENERATE
1, 2, 1
*NSET, NSET=Left, GENERATE
1, 11, 10
4, 14, 10
*NSET, NSET=Plane
1, 2, 3
11, 12, 13
*NSET, NSET=OfSecond, ELSET=second
*SURFACE, NAME=Tip
2, S4
*SURFACE, NAME=Top, TYPE=ELEMENT
Both, S2
*SURFACE, NAME=Skin
first,
*SURFACE, NAME=LeftNodes, TYPE=NODE
Left,
*MATERIAL, NAME=steel
*ELASTIC
2.1e11, 0.3
*STEP
*FREQUENCY
4
*END STEP
"""


def read(path: Path, text: str, unit: str = "m") -> TaggedMesh:
    path.write_text(text)
    return read_mesh(path, unit, MPI.COMM_SELF)


def places(tagged: TaggedMesh, name: str) -> dict[tuple[float, ...], float]:
    """Centres and areas of the facets of a group."""
    surface = boundary(tagged.mesh)
    chosen = surface.mask(tagged.facets[name]) != 0
    centres = surface.centres[chosen].round(12).tolist()
    return dict(zip(map(tuple, centres), surface.areas[chosen].tolist(), strict=True))


def test_sets_and_surfaces_of_calculix(tmp_path: Path) -> None:
    tagged = read(tmp_path / "bricks.inp", BRICKS)
    assert {name: len(cells) for name, cells in tagged.cells.items()} == {
        **{"first": 1, "second": 1, "Both": 2, "Range": 2, "body": 2}
    }
    left, tip = {(0.0, 0.5, 0.5): 1.0}, {(2.0, 0.5, 0.5): 1.0}
    front = {(0.5, 0.0, 0.5): 1.0, (1.5, 0.0, 0.5): 1.0}
    top = {(0.5, 0.5, 1.0): 1.0, (1.5, 0.5, 1.0): 1.0}
    assert places(tagged, "Left") == places(tagged, "LeftNodes") == pytest.approx(left)
    assert places(tagged, "Tip") == pytest.approx(tip)
    assert places(tagged, "Plane") == pytest.approx(front)
    assert places(tagged, "Top") == pytest.approx(top)
    assert len(places(tagged, "Skin")) == 5  # without the side that the bricks share
    assert len(places(tagged, "OfSecond")) == 5
    assert len(places(tagged, "Nall")) == 2  # the first block has the nodes at z = 0 alone


SIDES = {
    "C3D8": {
        **{"S1": (0.5, 0.5, 0), "S2": (0.5, 0.5, 1), "S3": (0.5, 0, 0.5)},
        **{"S4": (1, 0.5, 0.5), "S5": (0.5, 1, 0.5), "S6": (0, 0.5, 0.5)},
    },
    "C3D4": {
        **{"S1": (1 / 3, 1 / 3, 0), "S2": (1 / 3, 0, 1 / 3)},
        **{"S3": (1 / 3, 1 / 3, 1 / 3), "S4": (0, 1 / 3, 1 / 3)},
    },
    "CPS4": {"S1": (0.5, 0), "S2": (1, 0.5), "S3": (0.5, 1), "S4": (0, 0.5)},
    "CPE3": {"S1": (0.5, 0), "S2": (0.5, 0.5), "S3": (0, 0.5)},
}
NODES = {
    "C3D8": [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))],
    "C3D4": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
    "CPS4": [(0, 0), (1, 0), (1, 1), (0, 1)],
    "CPE3": [(0, 0), (1, 0), (0, 1)],
}


@pytest.mark.parametrize(
    ("kind", "side"), [(kind, side) for kind, sides in SIDES.items() for side in sides]
)
def test_numbers_of_sides(kind: str, side: str, tmp_path: Path) -> None:
    """As the element libraries of Abaqus and CalculiX number them."""
    tagged = read(tmp_path / "one.inp", one(kind, f"*SURFACE, NAME=side\n7, {side}"), "mm")
    ((centre, _),) = places(tagged, "side").items()
    np.testing.assert_allclose(centre, np.array(SIDES[kind][side]) / 1000, atol=1e-12)


def one(kind: str, rest: str) -> str:
    """One element, number 7, whose nodes have the numbers 1, 2 ..."""
    nodes = [", ".join(map(str, (i + 1, *x))) for i, x in enumerate(NODES[kind])]
    element = ", ".join(map(str, (7, *range(1, len(nodes) + 1))))
    return "\n".join(["*NODE", *nodes, f"*ELEMENT, TYPE={kind}, ELSET=one", element, rest, ""])


#: A part used twice; the second instance is moved by 3 along x and turned by 90 degrees about z.
ASSEMBLY = """
*PART, NAME=Block
{block}
*NSET, NSET=base
1, 2, 3, 4
*SURFACE, NAME=far
one, S4
*END PART
*ASSEMBLY, NAME=all
*INSTANCE, NAME=A, PART=Block
*END INSTANCE
*INSTANCE, NAME=B, PART=Block
3., 0., 0.
3., 0., 0., 3., 0., 1., 90.
*END INSTANCE
*NSET, NSET=bases
A.base, B.base
*ELSET, ELSET=second, INSTANCE=B
7,
*SURFACE, NAME=ends
A.far_set, S4
B.one, S4
*END ASSEMBLY
"""


def test_parts_and_instances(tmp_path: Path) -> None:
    text = ASSEMBLY.format(block=one("C3D8", "").strip()).replace("A.far_set", "A.one")
    tagged = read(tmp_path / "assembly.inp", text)
    a, b = (1.0, 0.5, 0.5), (2.5, 1.0, 0.5)  # x -> y for the turned one
    assert places(tagged, "A.far").keys() == {a}
    assert places(tagged, "B.far").keys() == {b}
    assert places(tagged, "ends").keys() == {a, b}
    assert places(tagged, "bases").keys() == {(0.5, 0.5, 0.0), (2.5, 0.5, 0.0)}
    assert len(tagged.cells["second"]) == 1 and len(tagged.cells["body"]) == 2


def test_include(tmp_path: Path) -> None:
    (tmp_path / "brick.inc").write_text(one("C3D8", ""))
    tagged = read(tmp_path / "a.inp", "*INCLUDE, INPUT=brick.inc\n*NSET, NSET=base\n1, 2, 3, 4\n")
    assert places(tagged, "base").keys() == {(0.5, 0.5, 0.0)}


BAD: list[tuple[str, list[str]]] = [
    ("*HEADING\nnothing\n", ["holds no *ELEMENT"]),
    ("*INCLUDE, INPUT=none.inc\n", ["none.inc", "No such file"]),
    (one("C3D8", "*NSET, NSET=a\nb"), ['line 12: there is no set "b" before']),
    (one("C3D8", "*NSET, NSET=a\n1, 99"), ["line 12", "1 members are not in the file", "99"]),
    (one("C3D8", "*NSET, NSET=a, GENERATE\n1"), ["line 12", "first, last, step"]),
    (one("C3D8", "*NSET, NSET=a, GENERATE\n1, 4, 0"), ["line 12: 1, 4, 0: the first must not"]),
    (one("C3D8", "*NSET, NSET=a, GENERATE\n4, 1"), ["line 12: 4, 1, 1: the first must not"]),
    (one("C3D8", "*ELSET, ELSET=a, GENERATE\n1, 2000000000"), ["line 12: 2000000000 members"]),
    (one("C3D8", "*SURFACE, NAME=a\n7, S7"), ["line 12: S7 is no side of a hexahedron"]),
    (one("C3D8", "*TIE, NAME=a\nb, c"), ['line 12: there is no surface "b"']),
    (one("C3D8", "*ELEMENT, TYPE=SPRINGA\n9, 1, 2"), ["element type SPRINGA: must be solid"]),
    (one("C3D8", "*ELEMENT, TYPE=T3D2\n9, 1, 7"), ["1 lines hang on the body", "element 9"]),
    (one("C3D8", "*ELEMENT, TYPE=C3D4\n9, 1, 2, 3, 5"), ["elements overlap", "both in", "9"]),
    (one("C3D8", "*ELEMENT, TYPE=C3D4\n9, 1, 2, 3"), ["4 numbers", "own number and 4 nodes"]),
    (
        one("C3D8", "*ELEMENT, TYPE=S4, ELSET=s\n9, 1, 2, 3, 88\n*NODE\n88, 2, 0, 0"),
        ["1 quadrangles hang on the body", "element 9", "cannot be followed"],
    ),
    (
        one("C3D8", "*ELEMENT, TYPE=C3D8\n9, 1, 2, 3, 4, 5, 6, 7, 88"),
        ["element 9", "without *NODE"],
    ),
    (one("C3D8", "*NODE, SYSTEM=X\n9, 1, 2, 3"), ["*NODE, SYSTEM=X: must be R, C or S"]),
    (one("C3D8", "*NODE\n9, 1, two, 3"), ['"two": must be a number']),
]


@pytest.mark.parametrize(("text", "words"), BAD)
def test_files_that_cannot_be_followed(text: str, words: list[str], tmp_path: Path) -> None:
    with pytest.raises(MeshError) as error:
        read(tmp_path / "bad.inp", text)
    message = str(error.value)
    assert not [word for word in words if word not in message], message
    assert "\n" not in message


def test_set_of_nodes_without_facets_is_told_when_it_is_used(tmp_path: Path) -> None:
    tagged = read(tmp_path / "a.inp", one("C3D8", "*NSET, NSET=line\n1, 2"))
    with pytest.raises(MeshError, match=r'clamp.facets = "line": the group has no facets'):
        tagged.facets_of(("line",), "clamp.facets")


def test_second_order_with_middle_nodes_in_sets(tmp_path: Path) -> None:
    """A facet of 8 nodes is named when all of them are in the set; its volume is exact."""
    corners = np.array(NODES["C3D8"], dtype=float)
    ends = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)]
    ends += [(0, 4), (1, 5), (2, 6), (3, 7)]
    nodes: Any = np.concatenate([corners, [(corners[a] + corners[b]) / 2 for a, b in ends]])
    lines = ["*NODE", *(", ".join(map(str, (i + 1, *x))) for i, x in enumerate(nodes.tolist()))]
    lines += ["*ELEMENT, TYPE=C3D20R", ", ".join(map(str, range(0, 15))) + ","]
    lines += [", ".join(map(str, range(15, 21)))]
    lines += ["*NSET, NSET=low", "1, 2, 3, 4, 9, 10, 11, 12", "*NSET, NSET=corners", "1, 2, 3, 4"]
    tagged = read(tmp_path / "c.inp", "\n".join(lines))
    assert places(tagged, "low") == {(0.5, 0.5, 0.0): pytest.approx(1.0)}
    assert places(tagged, "corners") == {}
    assert tagged.mesh.geometry.x.shape == (27, 3)
