"""A dumbbell in the plane, clamped at its left end, whose right face lands flat on a line.

A grid of rectangles, symmetric about the x axis:

    stem   0.3 m x 0.2 m, clamped at x = 0 (group "wall")
    block  0.4 m x 0.8 m, the mass
    foot   0.1 m x 0.2 m, whose end x = 0.8 m is the contact face (group "face")

The mass between two springs makes contact about as soft as the body itself, and the next symmetric
modes are at 2.54, 3.57 and 5.32 times the axial frequency, away from whole numbers. A plain
rectangle is a rod: internal resonances everywhere. Some remain here too, in high harmonics.
"""

from pathlib import Path

import gmsh

#: Lines of the grid in m.
_X = (0.0, 0.3, 0.7, 0.8)
_Y = (-0.4, -0.1, 0.1, 0.4)

#: Rectangles of the body, by column and row.
_CELLS = ((0, 1), (1, 0), (1, 1), (1, 2), (2, 1))

_ALONG_X = (10, 14, 8)
_BESIDE = 8


def write_mesh(path: Path, *, intervals: int = 40, cells: str = "quad", bump: float = 1.0) -> None:
    """Write the mesh as a .msh file.

    Args:
        path: File to write; its folder is made.
        intervals: Elements along the contact face; one more contact points.
        cells: "quad" or "triangle".
        bump: 1 for equal elements along the face; smaller shrinks them towards its corners,
            larger towards its middle.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add(path.stem)
        lines, surfaces = _rectangles()
        for (start, end), tag in lines.items():
            _divide(tag, start, end, intervals, bump)
        for surface in surfaces:
            gmsh.model.mesh.setTransfiniteSurface(surface, "Alternate")
            if cells == "quad":
                gmsh.model.mesh.setRecombine(2, surface)
        gmsh.model.addPhysicalGroup(2, surfaces, name="body")
        for name, column in (("wall", 0), ("face", len(_X) - 1)):
            ends = [tag for (a, b), tag in lines.items() if a[0] == b[0] == column]
            gmsh.model.addPhysicalGroup(1, ends, name=name)
        gmsh.model.mesh.generate(2)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


Corner = tuple[int, int]


def _rectangles() -> tuple[dict[tuple[Corner, Corner], int], list[int]]:
    """Lines by their end points, and surfaces, of the grid."""
    geo = gmsh.model.geo
    points: dict[Corner, int] = {}
    lines: dict[tuple[Corner, Corner], int] = {}

    def point(at: Corner) -> int:
        if at not in points:
            points[at] = geo.addPoint(_X[at[0]], _Y[at[1]], 0)
        return points[at]

    def line(start: Corner, end: Corner) -> int:
        if start > end:
            return -line(end, start)
        if (start, end) not in lines:
            lines[start, end] = geo.addLine(point(start), point(end))
        return lines[start, end]

    surfaces = []
    for i, j in _CELLS:
        ring = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
        loop = geo.addCurveLoop([line(ring[k], ring[(k + 1) % 4]) for k in range(4)])
        surfaces.append(geo.addPlaneSurface([loop]))
    geo.synchronize()
    return lines, surfaces


def _divide(tag: int, start: Corner, end: Corner, intervals: int, bump: float) -> None:
    divide = gmsh.model.mesh.setTransfiniteCurve
    if start[1] == end[1]:
        divide(tag, _ALONG_X[start[0]] + 1)
    elif start[1] == 1:
        divide(tag, intervals + 1, "Bump", bump)
    else:
        divide(tag, _BESIDE + 1)
