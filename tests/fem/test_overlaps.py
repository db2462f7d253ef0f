"""Bodies that reach into each other are refused, however little, and those that touch are not."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.cell_shapes import facet_table
from fenics_nnm.fem.overlaps import assert_single

Part = tuple[Array, Indices]


def brick(counts: tuple[int, ...], shift: tuple[float, ...], size: float = 1.0) -> Part:
    """Hexahedra, or quadrangles of the plane, with edges of a length, from a corner on."""
    dim = len(counts)
    grid = np.indices([n + 1 for n in counts]).reshape(dim, -1).T
    number = np.arange(len(grid)).reshape([n + 1 for n in counts])
    around = [
        (0, 0, 0),
        (1, 0, 0),
        (1, 1, 0),
        (0, 1, 0),
        (0, 0, 1),
        (1, 0, 1),
        (1, 1, 1),
        (0, 1, 1),
    ]
    corners = around if dim == 3 else [each[:2] for each in around[:4]]
    lowest = np.indices(counts).reshape(dim, -1).T
    cells = np.stack([number[tuple((lowest + corner).T)] for corner in corners], axis=1)
    points = np.zeros((len(grid), 3))
    points[:, :dim] = size * grid + np.array(shift)
    return points, cells


def sleeve(inner: float, outer: float, around: int, turn: float = 0.0) -> Part:
    """One layer of hexahedra between two cylinders about the z axis."""
    angle = 2 * np.pi * (np.arange(around) + turn) / around
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    up = np.array([0, 0, 0.5])
    points = np.concatenate([inner * ring, outer * ring, inner * ring + up, outer * ring + up])
    first = np.arange(around)
    after = (first + 1) % around
    bottom = np.stack([first, first + around, after + around, after], axis=1)
    return points, np.concatenate([bottom, bottom + 2 * around], axis=1)


def check(kind: str, *parts: Part) -> None:
    starts = np.cumsum([0, *(len(points) for points, _ in parts)])
    rows = np.concatenate([c + start for (_, c), start in zip(parts, starts, strict=False)])
    cells = {kind: rows}
    points = np.concatenate([points for points, _ in parts])
    assert_single("mesh", points, cells, np.arange(len(rows)) + 1, facet_table(cells))


@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.3, 0.45), (1.0, 0.5)])
@pytest.mark.parametrize("size", [1.0, 0.4, 2.5])
def test_bricks(shift: tuple[float, float], size: float) -> None:
    """The second one lies above the first, in line with it or not, with elements of its own."""
    first = brick((3, 3, 2), (0.0, 0.0, 0.0))
    for depth in (0.02, 0.05, 0.1, 0.14, 0.3, 0.5):
        with pytest.raises(MeshError) as error:
            check("hexahedron", first, brick((2, 2, 2), (*shift, 2 - depth), size))
        found = re.search(r"reaches ([\d.e-]+), which is ([\d.]+) of the height", str(error.value))
        if found:
            assert float(found[1]) == pytest.approx(depth, rel=0.01)
    for gap in (0.0, 1e-9, 0.01):
        check("hexahedron", first, brick((2, 2, 2), (*shift, 2 + gap), size))


def test_rectangles_of_the_plane() -> None:
    first = brick((3, 2), (0.0, 0.0))
    check("quad", first, brick((2, 2), (0.3, 2.0)))
    for depth in (0.02, 0.1):
        with pytest.raises(MeshError, match=r"reaches .* into"):
            check("quad", first, brick((2, 2), (0.3, 2 - depth)))


@pytest.mark.parametrize(("around", "within"), [(7, 9), (12, 12), (24, 17), (40, 90)])
def test_a_shaft_in_a_bore_is_no_overlap(around: int, within: int) -> None:
    """Chords of the bore reach into the shaft by their rise over the arc, which is no fault."""
    bore = sleeve(1.0, 1.5, around)
    check("hexahedron", bore, sleeve(0.5, 1.0, within, turn=0.4))
    rise = 1 - np.cos(np.pi / min(around, within))
    with pytest.raises(MeshError, match="overlap"):
        check("hexahedron", bore, sleeve(0.5, 1.03 + 2 * rise, within, turn=0.4))


def test_neighbours_of_very_different_size_may_touch() -> None:
    parts = [brick((1, 1, 1), (0, 0, 4.0), 4.0), brick((12, 12, 2), (0, 0, 3.4), 0.3)]
    check("hexahedron", *parts)
    for lower, upper in pairwise((0.02, 0.05, 0.1)):
        moved = brick((12, 12, 2), (0, 0, 3.4 + lower + 0.5 * upper), 0.3)
        with pytest.raises(MeshError, match="overlap"):
            check("hexahedron", parts[0], moved)
