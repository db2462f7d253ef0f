"""Small .msh files, good and bad, made with gmsh."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import gmsh

#: Element types of gmsh.
LINE, TRIANGLE, QUADRANGLE, TETRAHEDRON, PRISM, PYRAMID, POINT = 1, 2, 3, 4, 6, 7, 15


@contextmanager
def saved_model(path: Path) -> Iterator[None]:
    """A gmsh model whose mesh is saved when the context ends."""
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add(path.stem)
        yield
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def square(path: Path, *, name_body: bool = True, name_edges: bool = True) -> None:
    """Unit square of quadrangles with groups body, left, right and an inner line "middle"."""
    with saved_model(path):
        geo = gmsh.model.geo
        points = [geo.addPoint(x, y, 0) for x in (0, 0.5, 1) for y in (0, 1)]
        left, middle, right = (geo.addLine(points[i], points[i + 1]) for i in (0, 2, 4))
        below = [geo.addLine(points[i], points[i + 2]) for i in (0, 2)]
        above = [geo.addLine(points[i], points[i + 2]) for i in (1, 3)]
        sides = ((left, middle), (middle, right))
        faces = [
            geo.addPlaneSurface([geo.addCurveLoop([below[i], end, -above[i], -start])])
            for i, (start, end) in enumerate(sides)
        ]
        geo.synchronize()
        for dim, tag in gmsh.model.getEntities():
            if dim == 1:
                gmsh.model.mesh.setTransfiniteCurve(tag, 3)
            if dim == 2:
                gmsh.model.mesh.setTransfiniteSurface(tag)
                gmsh.model.mesh.setRecombine(2, tag)
        if name_body:
            gmsh.model.addPhysicalGroup(2, faces, name="body")
        if name_edges:
            for name, tag in (("left", left), ("middle", middle), ("right", right)):
                gmsh.model.addPhysicalGroup(1, [tag], name=name)
        gmsh.model.mesh.generate(2)
        if not name_body and not name_edges:
            gmsh.option.setNumber("Mesh.SaveAll", 1)


def two_segments(path: Path, elements: int, *, overlap: bool = False) -> None:
    """A line from 0 to 1 of two groups, "inner" up to 0.4 and "outer", with ends left and right."""
    with saved_model(path):
        geo = gmsh.model.geo
        points = [geo.addPoint(x, 0, 0) for x in (0.0, 0.4, 1.0)]
        lines = [geo.addLine(*points[i : i + 2]) for i in (0, 1)]
        geo.synchronize()
        for line, share in zip(lines, (2, 3), strict=True):
            gmsh.model.mesh.setTransfiniteCurve(line, share * elements + 1)
        gmsh.model.addPhysicalGroup(1, lines[:1], name="inner")
        gmsh.model.addPhysicalGroup(1, lines if overlap else lines[1:], name="outer")
        for name, point in (("left", points[0]), ("right", points[2])):
            gmsh.model.addPhysicalGroup(0, [point], name=name)
        gmsh.model.mesh.generate(1)


def halves(path: Path) -> None:
    """A rectangle 2 x 1 of triangles in two groups, "west" and "east", with left and right ends."""
    with saved_model(path):
        occ = gmsh.model.occ
        occ.fragment([(2, occ.addRectangle(0, 0, 0, 1, 1))], [(2, occ.addRectangle(1, 0, 0, 1, 1))])
        occ.synchronize()
        for name, start in (("west", 0.0), ("east", 1.0)):
            box = (start - 0.1, -0.1, -0.1, start + 1.1, 1.1, 0.1)
            found = gmsh.model.getEntitiesInBoundingBox(*box, 2)
            gmsh.model.addPhysicalGroup(2, [tag for _, tag in found], name=name)
        for name, x in (("left", 0.0), ("right", 2.0)):
            found = gmsh.model.getEntitiesInBoundingBox(x - 0.1, -0.1, -0.1, x + 0.1, 1.1, 0.1, 1)
            gmsh.model.addPhysicalGroup(1, [tag for _, tag in found], name=name)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.25)
        gmsh.model.mesh.generate(2)


def loose_part(path: Path, dim: int) -> None:
    """Two boxes, squares or lines side by side, of which only the left one has a group "left"."""
    with saved_model(path):
        shapes = [_shape(dim, start) for start in (0.0, 2.0)]
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(dim, shapes, name="body")
        for name, (low, high) in {"left": (-0.1, 0.1), "right": (2.9, 3.1)}.items():
            found = gmsh.model.getEntitiesInBoundingBox(low, -1, -1, high, 2, 2, dim - 1)
            gmsh.model.addPhysicalGroup(dim - 1, [tag for _, tag in found], name=name)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.25)
        gmsh.model.mesh.generate(dim)


def _shape(dim: int, start: float) -> int:
    occ = gmsh.model.occ
    if dim == 3:
        return int(occ.addBox(start, 0, 0, 1, 1, 1))
    if dim == 2:
        return int(occ.addRectangle(start, 0, 0, 1, 1))
    return int(occ.addLine(occ.addPoint(start, 0, 0), occ.addPoint(start + 1, 0, 0)))


def extruded(path: Path, *, recombine: bool) -> None:
    """A box of prisms, or of prisms' cousins the hexahedra."""
    with saved_model(path):
        occ = gmsh.model.occ
        base = occ.addRectangle(0, 0, 0, 1, 1)
        parts = occ.extrude([(2, base)], 0, 0, 1, numElements=[2], recombine=recombine)
        occ.synchronize()
        volume = next(tag for dim, tag in parts if dim == 3)
        gmsh.model.addPhysicalGroup(3, [volume], name="body")
        gmsh.model.addPhysicalGroup(2, [base], name="left")
        gmsh.model.addPhysicalGroup(2, [parts[0][1]], name="right")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 1.0)
        gmsh.model.mesh.generate(3)


def explicit(
    path: Path,
    nodes: list[tuple[float, float, float]],
    cells: dict[int, list[list[int]]],
    edges: dict[str, list[list[int]]],
    dim: int = 2,
) -> None:
    """A mesh written out: node numbers from 1, cells by gmsh type, named groups of edges."""
    facet = {1: POINT, 2: LINE, 3: TRIANGLE}[dim]
    with saved_model(path):
        body = gmsh.model.addDiscreteEntity(dim)
        flat = [x for node in nodes for x in node]
        gmsh.model.mesh.addNodes(dim, body, list(range(1, len(nodes) + 1)), flat)
        for kind, rows in cells.items():
            gmsh.model.mesh.addElementsByType(body, kind, [], [n for row in rows for n in row])
        gmsh.model.addPhysicalGroup(dim, [body], name="body")
        for name, rows in edges.items():
            entity = gmsh.model.addDiscreteEntity(dim - 1)
            gmsh.model.mesh.addElementsByType(entity, facet, [], [n for row in rows for n in row])
            gmsh.model.addPhysicalGroup(dim - 1, [entity], name=name)


def unit_square(height: float = 0.0) -> list[tuple[float, float, float]]:
    """Six nodes, three in each of two rows, as `explicit` numbers them from 1."""
    return [(x, y, height * x) for y in (0.0, 1.0) for x in (0.0, 1.0, 2.0)]


#: Edges at both ends of the two cells on `unit_square`.
ENDS = {"left": [[1, 4]], "right": [[3, 6]]}


def mixed(path: Path) -> None:
    """One quadrangle beside two triangles."""
    cells = {QUADRANGLE: [[1, 2, 5, 4]], TRIANGLE: [[2, 3, 6], [2, 6, 5]]}
    explicit(path, unit_square(), cells, ENDS)


def flat(path: Path) -> None:
    """Two triangles and one whose corners lie on a line."""
    cells = {TRIANGLE: [[1, 2, 5], [1, 5, 4], [1, 2, 3]]}
    explicit(path, unit_square(), cells, {"left": [[1, 4]], "right": [[2, 5]]})


def shell(path: Path) -> None:
    """Quadrangles that leave the x-y plane."""
    explicit(path, unit_square(0.5), {QUADRANGLE: [[1, 2, 5, 4], [2, 3, 6, 5]]}, ENDS)


def curved_rod(path: Path) -> None:
    """Lines that leave the x axis."""
    nodes = [(0.0, 0.0, 0.0), (1.0, 0.5, 0.0), (2.0, 0.0, 0.0)]
    explicit(path, nodes, {LINE: [[1, 2], [2, 3]]}, {"left": [[1]], "right": [[3]]}, dim=1)


def pyramid(path: Path) -> None:
    """One pyramid."""
    nodes = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1)]
    cells = {PYRAMID: [[1, 2, 3, 4, 5]]}
    explicit(path, nodes, cells, {"left": [[1, 2, 5]], "right": [[3, 4, 5]]}, dim=3)


MAKERS: dict[str, Callable[[Path], None]] = {
    "mixed": mixed,
    "flat": flat,
    "shell": shell,
    "curved rod": curved_rod,
    "pyramid": pyramid,
    "prisms": lambda path: extruded(path, recombine=True),
    "no groups": lambda path: square(path, name_body=False, name_edges=False),
    "no facet groups": lambda path: square(path, name_edges=False),
    "no body": lambda path: square(path, name_body=False),
    "empty": lambda path: path.write_bytes(b"") and None,
    "garbage": lambda path: path.write_bytes(bytes(range(256)) * 9) and None,
    "truncated": lambda path: (square(path), path.write_bytes(path.read_bytes()[:700])) and None,
    "missing": lambda path: None,
    "folder": lambda path: path.mkdir(),
}
