"""Solids between sections of two sides each: smooth sides, flat edges, stretched ends.

The sides interpolate all sections by cubic splines: along the section, and by chord length along
the span (Piegl and Tiller, The NURBS Book, 1997, section 9.2.5). OCC's own loft only approximates
the sections, and makes surfaces that it cannot always cut.
"""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from fenics_nnm.geometry.parameters import GmshModel
from fenics_nnm.geometry.section_lines import SectionLines


class Solid(NamedTuple):
    """Tags of the blade in gmsh: faces but `volume`, and `edges`, the spanwise curves."""

    volume: int
    root: int
    tip: int
    surface: list[int]
    edges: list[int]


def loft(gmsh_model: GmshModel, lines: list[SectionLines]) -> Solid:
    """Make the solid through sections, hub first; they share their parameter."""
    occ = gmsh_model.occ
    points = np.stack([line.sides for line in lines])  # sections, sides, stations, 3
    span = make_interp_spline(_chord_length(points), points, k=min(3, len(lines) - 1))
    side = make_interp_spline(lines[0].parameter, np.moveaxis(span.c, 2, 0), k=3)
    straight = BSpline(np.array([0.0, 0, 1, 1]), np.zeros(2), 1)
    control = np.moveaxis(side.c, 0, 2)
    sides = [_add_surface(occ, control[:, s], (side, span)) for s in (0, 1)]
    strips = [_add_surface(occ, control[:, :, end], (straight, span)) for end in (-1, 0)]
    return _closed(gmsh_model, [sides[0], strips[0], sides[1], strips[1]])


def _chord_length(points: np.ndarray) -> np.ndarray:
    """Mean share of the spanwise distance that is reached at each section, from 0 to 1."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=-1)
    share = (steps / steps.sum(axis=0)).mean(axis=(1, 2))
    return np.concatenate([[0.0], np.cumsum(share)])


def _add_surface(occ: GmshModel, control: np.ndarray, splines: tuple[BSpline, BSpline]) -> int:
    """Add the surface of control points of shape (spanwise, along the section, 3)."""
    (u, u_times), (v, v_times) = (np.unique(spline.t, return_counts=True) for spline in splines)
    points = [occ.addPoint(*point) for point in control.reshape(-1, 3)]
    surface = occ.addBSplineSurface(
        points,
        control.shape[1],
        degreeU=splines[0].k,
        degreeV=splines[1].k,
        knotsU=u.tolist(),
        knotsV=v.tolist(),
        multiplicitiesU=u_times.tolist(),
        multiplicitiesV=v_times.tolist(),
    )
    occ.remove([(0, point) for point in points])
    return int(surface)


def _closed(gmsh_model: GmshModel, sides: list[int]) -> Solid:
    """The solid inside four faces, in turn around the span and sewn together, and two ends."""
    occ = gmsh_model.occ
    occ.synchronize()
    rims: tuple[list[int], list[int]] = ([], [])
    for face in sides:
        curves = gmsh_model.getBoundary([(2, face)], oriented=False)
        by_radius = sorted((tag for _, tag in curves), key=lambda tag: _radius(occ, 1, tag))
        rims[0].append(by_radius[0])
        rims[1].append(by_radius[-1])
    ends = [occ.addBSplineFilling(occ.addWire(rim), type="Stretch") for rim in rims]
    volume = occ.addVolume([occ.addSurfaceLoop([*sides, *ends], sewing=True)])
    occ.remove([(2, face) for face in [*sides, *ends]], recursive=True)
    occ.synchronize()
    boundary = gmsh_model.getBoundary([(3, volume)], oriented=False)
    faces = sorted((tag for _, tag in boundary), key=lambda tag: _radius(occ, 2, tag))
    root, *surface, tip = faces
    return Solid(int(volume), root, tip, surface, shared_curves(gmsh_model, surface))


def shared_curves(gmsh_model: GmshModel, faces: list[int]) -> list[int]:
    """Curves between two of the faces."""
    whole = [(2, face) for face in faces]
    every = gmsh_model.getBoundary(whole, combined=False, oriented=False)
    rims = gmsh_model.getBoundary(whole, combined=True, oriented=False)
    return sorted({tag for _, tag in every} - {tag for _, tag in rims})


def _radius(occ: GmshModel, dim: int, tag: int) -> float:
    """Distance of a centre of mass from the x axis."""
    _, y, z = occ.getCenterOfMass(dim, tag)
    return float(np.hypot(y, z))
