"""Rigid couplings, mean motions and equations: against CalculiX, closed forms, merged meshes."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from brick_beams import bdf, bricks, inp, nodes
from calculix import KEPT_JOINED, mesh
from cell_boxes import write_inp
from constrained_beams import (
    DENSITY,
    JOINED,
    YOUNG,
    assembled,
    cantilever,
    joined,
    listed,
    modes,
    numbers_at,
    read_here,
    rigid_misfit,
)
from scipy.sparse import csr_array

from fenics_nnm.errors import MeshError, ModelError
from fenics_nnm.fem.abaqus_mesh import read_abaqus
from fenics_nnm.fem.block import product
from fenics_nnm.fem.clamp import Clamp
from fenics_nnm.fem.elimination import Equations, eliminated
from fenics_nnm.fem.iterative_modes import IterativeModalSolver
from fenics_nnm.fem.mesh_file import ReadMesh
from fenics_nnm.fem.raw_mesh import read_written, write_raw
from fenics_nnm.fem.solid import Solid

CALCULIX: dict[str, list[float]] = json.loads(KEPT_JOINED.read_text())


@pytest.mark.parametrize("name", JOINED)
def test_frequencies_of_calculix_on_the_same_file(name: str, tmp_path: Path) -> None:
    solid = assembled(read_here(tmp_path / "a.inp", joined(name)), 1)
    np.testing.assert_allclose(modes(solid).frequencies, CALCULIX[name], rtol=5e-7)


#: The beam of the files, which bends along z.
LENGTH, HEIGHT, WIDTH = 0.2, 0.01, 0.02
N = (8, 1, 1)
TIP = numbers_at(LENGTH, N)


def with_tip_mass(mass: float, inertia: float) -> float:
    """First frequency of the beam that bends along z, with a mass at its tip, in Hz."""
    stiffness = YOUNG * WIDTH * HEIGHT**3 / 12, DENSITY * WIDTH * HEIGHT
    return cantilever(*stiffness, LENGTH, mass=mass, inertia=inertia)


def at_the_tip(cards: str) -> str:
    """A beam whose end has its centre at GRID 900."""
    return bdf(f"GRID,900,,{LENGTH},{WIDTH / 2},{HEIGHT / 2}\n{cards}", N)


RBE2 = "RBE2,1,900,123456," + ",".join(map(str, TIP))
RBE3 = f"RBE3,1,,900,123456,1.,123,{TIP[0]},{TIP[1]},+\n+,{TIP[2]},{TIP[3]}"
CONM2 = "CONM2,7,900,,0.4,,,,\n,1.-4,,2.-4,,,3.-4"


def test_tip_mass_with_rotary_inertia_against_euler_and_bernoulli(tmp_path: Path) -> None:
    tagged = read_here(tmp_path / "a.bdf", at_the_tip(f"{RBE2}\n{CONM2}"))
    found = modes(assembled(tagged, 2, poisson=0.0), 1).frequencies[0]
    wanted = with_tip_mass(0.4, 2e-4)
    assert found == pytest.approx(wanted, rel=2e-3)
    assert abs(with_tip_mass(0.4, 0.0) / wanted - 1) > 4e-3  # the inertia shows
    assert "RBE2 1: 4 nodes follow GRID 900" in tagged.notes


def total_mass(solid: Solid) -> np.ndarray:
    """1^T M 1 along each axis in kg, without what is lost at the clamp."""
    ones = np.tile(np.eye(3), (solid.owned // 3, 1))
    return np.asarray(ones.T @ product(solid.mass, ones))


@pytest.mark.parametrize("spider", [RBE2, RBE3], ids=["RBE2", "RBE3"])
def test_mass_at_a_reference_point_counts_whole(spider: str, tmp_path: Path) -> None:
    heavy = read_here(
        tmp_path / "a.bdf", at_the_tip(f"{spider}\n{CONM2.replace('0.4,', '0.4,,.1')}")
    )
    light = read_here(tmp_path / "b.bdf", at_the_tip(spider))
    added = total_mass(assembled(heavy, 1)) - total_mass(assembled(light, 1))
    np.testing.assert_allclose(added, 0.4 * np.eye(3), atol=1e-12)


def test_mean_motion_alone_leaves_the_body_as_it_is(tmp_path: Path) -> None:
    """A point that follows the mean adds no stiffness; with a mass it lowers frequencies."""
    plain = modes(assembled(read_here(tmp_path / "a.bdf", bdf("", N)), 1)).frequencies
    mean = modes(assembled(read_here(tmp_path / "b.bdf", at_the_tip(RBE3)), 1)).frequencies
    np.testing.assert_allclose(mean, plain, rtol=1e-10)
    heavy = at_the_tip(f"{RBE3}\n{CONM2}")
    rigid = at_the_tip(f"{RBE2}\n{CONM2}")
    soft, hard = (modes(assembled(read_here(tmp_path / "c.bdf", x), 2)) for x in (heavy, rigid))
    assert (soft.frequencies <= hard.frequencies * (1 + 1e-10)).all()
    assert soft.frequencies[0] == pytest.approx(hard.frequencies[0], rel=1e-2)


def test_rigid_elements_of_all_kinds_are_one_body(tmp_path: Path) -> None:
    """RBE2 about a GRID outside or of the body, and RBARs one by one: what lies between follows."""
    bars = "\n".join(f"RBAR,{i},900,{node},123456" for i, node in enumerate(TIP, start=1))
    own = f"RBE2,1,{TIP[0]},123456," + ",".join(map(str, TIP[1:]))
    found = [
        modes(assembled(read_here(tmp_path / "a.bdf", at_the_tip(cards)), 2)).frequencies
        for cards in (RBE2, own, bars)
    ]
    for other in found[1:]:
        np.testing.assert_allclose(other, found[0], rtol=1e-10)


def test_held_reference_point_is_a_clamp_of_its_nodes(tmp_path: Path) -> None:
    """The set of a reference node in clamp.nodes: all of it, or in one direction."""
    tagged = read_here(tmp_path / "a.bdf", at_the_tip(RBE2))
    whole = Clamp("clamp", (), ("GRID 900",), (0, 1, 2), turns=False)
    held = modes(assembled(tagged, 2, clamps=(whole,))).frequencies
    text = inp("*NSET, NSET=tip\n" + listed(TIP), N)
    nodes_held = Clamp("clamp", (), ("tip",), (0, 1, 2), turns=False)
    direct = assembled(read_here(tmp_path / "a.inp", text), 2, clamps=(nodes_held,))
    np.testing.assert_allclose(held, modes(direct).frequencies, rtol=1e-10)
    sliding = Clamp("clamp", (), ("GRID 900",), (2,))
    free = modes(assembled(tagged, 2, clamps=(sliding,))).frequencies
    assert 0 < free[0] < 0.9 * held[0]


#: Cut at the middle: nodes of the right half have numbers 1000 higher.
HALF = (4, 1, 1)


def two_halves(rest: str, degree: int, folder: Path, shift: float = 0.0) -> Solid:
    """Two halves of the beam whose nodes at the cut are joined by `rest`."""
    moved = nodes(HALF) * 0.5 + np.array([0.1 + shift, 0, 0])
    moved[:, 1:] *= 2
    left = nodes(HALF) * np.array([0.5, 1, 1])
    lines = ["*NODE"]
    for start, points in ((1, left), (1001, moved)):
        lines += [", ".join(map(str, (start + i, *x))) for i, x in enumerate(points.tolist())]
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=Eall"]
    for start in (0, 1000):
        lines += [
            ", ".join(map(str, (i + 1 + start, *(n + start for n in row))))
            for i, row in enumerate(bricks(HALF))
        ]
    return assembled(read_here(folder / "a.inp", "\n".join([*lines, rest, ""])), degree)


def at_the_cut() -> list[tuple[int, int]]:
    """Pairs of nodes at the cut."""
    return [(number, number - 4 + 1000) for number in numbers_at(0.2, HALF)]


def plain_equations() -> str:
    rows = [f"2\n{a}, {i}, 1., {b}, {i}, -1." for a, b in at_the_cut() for i in (1, 2, 3)]
    return "\n".join(["*EQUATION", *rows])


def mixed_equations() -> str:
    """The same, summed and subtracted, so that no single one says that nodes are one."""
    rows = [f"2\n{a}, 3, 1., {b}, 3, -1." for a, b in at_the_cut()]
    for a, b in at_the_cut():
        for sign in (1.0, -1.0):
            rows.append(f"4\n{a}, 1, 1., {b}, 1, -1., {a}, 2, {sign}\n{b}, 2, {-sign}")
    return "\n".join(["*EQUATION", *rows])


def test_equations_of_nodes_at_one_place_are_the_merged_mesh(tmp_path: Path) -> None:
    """Of both kinds: nodes are merged, or displacements eliminated."""
    whole = modes(assembled(read_here(tmp_path / "w.inp", inp("", N)), 1)).frequencies
    merged, kept = (
        two_halves(rest, 1, tmp_path) for rest in (plain_equations(), mixed_equations())
    )
    assert merged.dofs < kept.dofs and merged.free == kept.free
    assert "equations: 4 nodes are merged with those at their places" in merged.tagged.notes
    for solid in (merged, kept):
        np.testing.assert_allclose(modes(solid).frequencies, whole, rtol=1e-10)
    pins = "*MPC\n" + "\n".join(f"PIN, {a}, {b}" for a, b in at_the_cut())
    quadratic = modes(assembled(read_here(tmp_path / "w.inp", inp("", N)), 2)).frequencies
    found = modes(two_halves(pins, 2, tmp_path)).frequencies
    np.testing.assert_allclose(found, quadratic, rtol=1e-10)


def test_equations_in_a_file_of_their_own_are_read(tmp_path: Path) -> None:
    equation = "2\n1, 2, 1., 9, 2, -1.\n"
    (tmp_path / "eq.txt").write_text(f"** of nodes 1 and 9\n{equation}")
    tagged = read_here(tmp_path / "a.inp", inp("*EQUATION, INPUT=eq.txt"))
    assert "*EQUATION: 1 equations between displacements" in tagged.notes


def test_equations_on_faces_with_values_of_their_own_are_refused(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"\*EQUATION cannot be followed: equations join whole"):
        two_halves(mixed_equations(), 2, tmp_path)


def test_bars_that_are_rigid_make_one_body(tmp_path: Path) -> None:
    """Halves a millimetre apart, joined by RBE2s in a chain and by *MPC BEAM, move alike."""
    pairs = at_the_cut()
    sides = ["\n".join(map(str, side)) for side in zip(*pairs, strict=True)]
    chain = f"*NODE\n5000, .1005, .01, .005\n5001, .1, .01, .005\n*NSET, NSET=a\n{sides[0]}\n"
    chain += f"*NSET, NSET=b\n{sides[1]}\n*RIGID BODY, NSET=a, REF NODE=5001\n"
    chain += "*RIGID BODY, NSET=b, REF NODE=5000\n*MPC\nBEAM, 5000, 5001\n"
    solid = two_halves(chain, 2, tmp_path, shift=1e-3)
    found = modes(solid)
    x = solid.space.tabulate_dof_coordinates()
    cut = (x[:, 0] > 0.1 - 1e-9) & (x[:, 0] < 0.101 + 1e-9)
    assert cut.sum() == 18
    for shape in found.shapes.T:
        assert rigid_misfit(x[cut], shape.reshape(-1, 3)[cut]) < 1e-9
    assert solid.dofs - solid.free == 27 + 18 * 3 - 6
    np.testing.assert_allclose(
        found.shapes.T @ product(solid.mass, found.shapes), np.eye(4), atol=1e-10
    )
    np.testing.assert_allclose(
        np.diag(found.shapes.T @ product(solid.stiffness, found.shapes)), found.omega**2, rtol=1e-8
    )


def test_links_keep_their_length(tmp_path: Path) -> None:
    """*MPC LINK between two corners: they come no nearer, and nothing else is held."""
    solid = assembled(read_here(tmp_path / "a.inp", inp(f"*MPC\nLINK, {TIP[0]}, 5", N)), 2)
    found = modes(solid)
    x, apart = solid.space.tabulate_dof_coordinates(), []
    for number in (TIP[0], 5):
        place = nodes(N)[number - 1]
        apart.append(int(np.argmin(np.linalg.norm(x - place, axis=1))))
    along = x[apart[0]] - x[apart[1]]
    moved = found.shapes.reshape(-1, 3, 4)
    stretch = np.einsum("i,ij->j", along, moved[apart[0]] - moved[apart[1]])
    assert np.abs(stretch).max() < 1e-10 * np.abs(moved).max()
    assert solid.free == solid.dofs - 27 - 1


def test_elimination_solves_any_equations() -> None:
    """Random equations between 30 columns and 10 outside, the last two in one of them alone."""
    rng = np.random.default_rng(1)
    C = rng.standard_normal((20, 40)) * (rng.random((20, 40)) < 0.4)
    C[:, 38:] = 0.0
    C[4, 38:] = 1.0, -2.0
    C = np.vstack([C, C[:3].sum(axis=0)])  # which says nothing new
    found = eliminated(Equations(csr_array(C), 30, np.full(len(C), -1)))
    assert found.loose == {38, 39} and set(found.outside) == set(range(30, 38))
    ranks = [int(np.linalg.matrix_rank(part)) for part in (C, C[:, 30:])]
    assert len(found.dependent) == ranks[0] - ranks[1] == 11
    v = np.zeros(40)
    free = [column for column in range(30) if column not in found.dependent]
    v[free] = rng.standard_normal(len(free))
    for column, row in {**found.dependent, **found.outside}.items():
        v[column] = sum(value * v[other] for other, value in row.items())
    left = C @ v
    assert abs(left[4]) > 0.1  # the equation that the loose ones obey
    assert np.abs(np.delete(left, 4)).max() < 1e-10


REFUSED = [
    ("*MPC\nPLANE, 1, 2", r"\*MPC PLANE cannot be followed: must be one of BEAM, PIN"),
    ("*EQUATION\n2\n1, 4, 1., 2, 1, -1.", r"\*EQUATION cannot be followed: .* no direction 4"),
    ("*EQUATION\n1\n1, 1, 0.", "all its coefficients are zero"),
    ("*EQUATION\n1000000000\n1, 1, 1.", r"\*EQUATION: 1000000000 terms"),
    ("*EQUATION\n2\n1, 1, 1., 777, 1, -1.", "there is no node 777"),
    ("*EQUATION, INPUT=gone.txt", r"gone.txt: cannot be read"),
    ("*EQUATION, INPUT=a.inp", r"a.inp, line 1: \*NODE.*: must be data alone"),
    ("*EQUATION\n2\n1, 1, 1., 2, 1, inf", "its coefficients must be finite"),
    ("*ELEMENT, TYPE=MASS, ELSET=m\n90, 9\n*MASS, ELSET=m\n-1.", "must not be negative"),
    ("*MASS, ELSET=Eall\n1.", "element 1 must be one of one node"),
    ("*RIGID BODY, NSET=Nall", r"must have REF NODE ="),
    ("*KINEMATIC\n1, 3", r"\*KINEMATIC: must stand after \*COUPLING"),
    ("*COUPLING, REF NODE=1, SURFACE=s\n*MASS, ELSET=m\n1.", "must be followed by"),
    ("*ELEMENT, TYPE=SPRING2, ELSET=e\n90, 1, 2", "element type SPRING2"),
    (
        "*TRANSFORM, NSET=Nall\n0, 1, 0, 1, 0, 0\n*EQUATION\n2\n1, 1, 1., 2, 1, -1.",
        r"\*EQUATION cannot be followed beside \*TRANSFORM",
    ),
    (
        "*NODE\n900, .3, 0, 0\n*ELEMENT, TYPE=MASS, ELSET=m\n90, 900\n*MASS, ELSET=m\n1.\n"
        "*COUPLING, REF NODE=900, SURFACE=Nall\n*DISTRIBUTING\n1, 3",
        r"\*COUPLING with \*DISTRIBUTING cannot be followed: its reference node 900",
    ),
    (
        "*NODE\n900, .3, 0, 0\n*ELEMENT, TYPE=MASS, ELSET=m\n90, 900\n*MASS, ELSET=m\n1.",
        "node 900 cannot be followed: it has mass or springs, and no node of the body holds its "
        "motion along x",
    ),
]


@pytest.mark.parametrize(("text", "words"), REFUSED)
def test_constraints_that_cannot_be_followed(text: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=words):
        assembled(read_here(tmp_path / "a.inp", inp(text)), 1)


def test_iterative_solver_refuses_constraints_by_name(tmp_path: Path) -> None:
    solid = assembled(read_here(tmp_path / "a.bdf", at_the_tip(RBE2)), 2)
    with pytest.raises(ModelError, match="RBE2: constraints cannot be followed by the iterative"):
        IterativeModalSolver(solid)


def test_springs_and_masses_at_single_nodes(tmp_path: Path) -> None:
    """*SPRING and *MASS at a corner against CELAS2 and CONM2 there."""
    element = "*ELEMENT, TYPE={}, ELSET={}\n{}, 9\n"
    spring = element.format("SPRING1", "s", 91) + "*SPRING, ELSET=s\n3\n1e5\n"
    mass = element.format("MASS", "m", 92) + "*MASS, ELSET=m\n0.1\n"
    one = modes(assembled(read_here(tmp_path / "a.inp", inp(spring + mass, N)), 1)).frequencies
    cards = "CELAS2,901,1.+5,9,3\nCONM2,900,9,,0.1"
    two = modes(assembled(read_here(tmp_path / "a.bdf", bdf(cards, N)), 1)).frequencies
    np.testing.assert_allclose(one, two, rtol=1e-10)


def test_keywords_of_a_part_hold_in_each_of_its_instances(tmp_path: Path) -> None:
    """And those of the assembly join the instances."""
    part = inp(f"*NODE\n900, .22, .01, .005\n*NSET, NSET=tip\n{listed(TIP)}", N)
    text = f"*PART, NAME=beam\n{part}*RIGID BODY, NSET=tip, REF NODE=900\n*END PART\n*ASSEMBLY\n"
    for name, shift in (("a", 0), ("b", 1)):
        text += f"*INSTANCE, NAME={name}, PART=beam\n0, 0, {shift}\n*END INSTANCE\n"
    text += "*EQUATION\n2\na.9, 1, 1., b.9, 1, -1.\n*END ASSEMBLY\n"
    (tmp_path / "a.inp").write_text(text)
    found = read_abaqus(tmp_path / "a.inp").constraints
    assert [each.point for each in found.references] == [(0.22, 0.01, 0.005), (0.22, 0.01, 1.005)]
    assert [len(each.nodes) for each in found.couplings] == [4, 4]
    assert all("node 900" in each.names for each in found.references)
    (first, _, one), (second, _, two) = found.equations[0].terms
    assert second - first == len(nodes(N)) + 1 and one == -two


def test_constraints_go_through_a_file_as_they_are(tmp_path: Path) -> None:
    """As from the process that reads a mesh; rows that are not there are refused."""
    text = inp(f"*NODE\n900, .3, 0, 0\n*RIGID BODY, NSET=Nall, REF NODE=900\n{PIN}", N)
    (tmp_path / "a.inp").write_text(text)
    raw = ReadMesh(tmp_path / "a.inp")(tmp_path)
    write_raw(tmp_path / "a.npz", raw)
    assert read_written(tmp_path / "a.npz").constraints == raw.constraints
    assert len(raw.constraints.equations) == 3
    write_raw(
        tmp_path / "b.npz", replace(raw, points=raw.points[:-1], cells=raw.cells[:1], nodes={})
    )
    with pytest.raises(IndexError, match="constraints name a row"):
        read_written(tmp_path / "b.npz")


PIN = "*MPC\nPIN, 1, 900"

MPC = "MPC,3,9,1,1.,18,1,-2."


def test_equations_of_nastran_are_those_of_the_case(tmp_path: Path) -> None:
    plain, joined_bulk = (read_here(tmp_path / "a.bdf", bdf(rest, N)) for rest in ("", MPC))
    assert not plain.constraints.joining and len(joined_bulk.constraints.equations) == 1
    case = "SUBCASE 1\n  MPC = {}\n"
    asked = read_here(tmp_path / "b.bdf", case.format(3) + bdf(f"{MPC}\nMPC,4,9,2,1.", N))
    assert asked.constraints.equations[0].terms == joined_bulk.constraints.equations[0].terms
    assert "not read: MPC 4, which no case asks for" in asked.notes
    added = read_here(tmp_path / "b.bdf", case.format(7) + bdf(f"MPCADD,7,3\n{MPC}", N))
    assert len(added.constraints.equations) == 1
    with pytest.raises(MeshError, match="MPC cannot be followed: sets 3, 4 stand there"):
        read_here(tmp_path / "b.bdf", bdf(f"{MPC}\nMPC,4,9,2,1.", N))


@pytest.mark.parametrize("name", ["C3D15", "C3D4"])
def test_couplings_take_what_lies_between_their_nodes_along(name: str, tmp_path: Path) -> None:
    """New middle nodes of prisms that are split, and middles of edges that a file does not have."""
    foreign = mesh(name)
    end = np.flatnonzero(np.abs(foreign.points[:, 0] - LENGTH) < 1e-9) + 1
    keywords = f"*NODE\n9000, .2, .01, .005\n*NSET, NSET=end\n{listed(end.tolist())}\n"
    write_inp(foreign, tmp_path / "a.inp", f"{keywords}*RIGID BODY, NSET=end, REF NODE=9000")
    solid = assembled(read_here(tmp_path / "a.inp", (tmp_path / "a.inp").read_text()), 2)
    x = solid.space.tabulate_dof_coordinates()
    at = np.abs(x[:, 0] - LENGTH) < 1e-9
    assert solid.system.dependent == 3 * at.sum() - 6
    for shape in modes(solid, 2).shapes.T:
        assert rigid_misfit(x[at], shape.reshape(-1, 3)[at]) < 1e-9
