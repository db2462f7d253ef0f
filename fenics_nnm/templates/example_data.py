"""Files of the example studies that are made rather than kept: a mesh and matrices."""

from __future__ import annotations

from pathlib import Path

_CORNERS = ((0, 0), (100, 0), (100, 20), (20, 20), (20, 80), (0, 80))
"""Outline of the bracket in mm."""

_MASSES = 8
_MASS = 0.5  # kg
_SPRING = 2e6  # N/m
_PAD = 6e5  # N/m


def write_bracket(path: Path) -> None:
    """Write the mesh of an L-shaped body in the plane, in mm, with the groups body, wall, nose."""
    import gmsh

    from fenics_nnm.fem.gmsh_mesh import gmsh_session

    with gmsh_session("bracket"):
        geo = gmsh.model.geo
        points = [geo.addPoint(x, y, 0, 5) for x, y in _CORNERS]
        lines = [geo.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]
        surface = geo.addPlaneSurface([geo.addCurveLoop(lines)])
        geo.synchronize()
        for dim, tag, name in ((2, surface, "body"), (1, lines[4], "wall"), (1, lines[1], "nose")):
            gmsh.model.addPhysicalGroup(dim, [tag], name=name)
        gmsh.model.mesh.generate(2)
        gmsh.write(str(path))


def write_chain(path: Path) -> None:
    """Write stiffness K, mass M and contact row B of a chain of equal masses and springs.

    Its first spring holds on to a wall. Its last mass has a soft pad, a spring whose end is an
    unknown without mass, and the pad can meet a stop.
    """
    import numpy as np

    count = _MASSES + 1
    springs = np.array([_SPRING] * _MASSES + [_PAD])
    ends = np.eye(count) - np.eye(count, k=-1)  # how much longer each spring gets
    mass = np.diag([_MASS] * _MASSES + [0.0])
    np.savez(path, K=ends.T @ np.diag(springs) @ ends, M=mass, B=np.eye(count)[-1:])
