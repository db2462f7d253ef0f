"""Named groups of a mesh in a table, so that users see what they picked."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from fenics_nnm.arrays import Array
from fenics_nnm.fem.boundary import Boundary, boundary
from fenics_nnm.fem.mesh import TaggedMesh

#: Most groups that are listed; the others are counted.
_MOST_LISTED = 80

#: Distance over the smallest facet below which two nodes are at one place.
_COINCIDENT = 1e-6


def group_table(tagged: TaggedMesh) -> list[str]:
    """Facets, area, centre and bounding box of each group of facets; the same on all ranks."""
    surface = boundary(tagged.mesh)
    unit = {1: "", 2: "length (m)", 3: "area (m^2)"}[tagged.dim]
    width = max([11, *map(len, tagged.facets)])
    lines = ["", f"{'facet group':<{width}}   facets   {unit:>12}   centre (m), bounding box (m)"]
    for name in list(tagged.facets)[:_MOST_LISTED]:
        lines.append(f"{name:<{width}}   {_measures(tagged, surface, name)}")
    more = len(tagged.facets) - _MOST_LISTED
    lines += [f"and {more} more groups"] if more > 0 else []
    notes = ["", *(f"mesh file        {note}" for note in tagged.notes)] if tagged.notes else []
    return lines + _cells(tagged) + notes + _coincident(surface)


def facet_counts(tagged: TaggedMesh) -> dict[str, int]:
    """Number of facets of each group, of as many groups as are listed; the same on all ranks."""
    here = tagged.mesh.topology.index_map(tagged.dim - 1).size_local
    return {
        name: tagged.mesh.comm.allreduce(int((tagged.facets[name] < here).sum()))
        for name in list(tagged.facets)[:_MOST_LISTED]
    }


def _measures(tagged: TaggedMesh, surface: Boundary, name: str) -> str:
    """Numbers of one group; facets inside the body are counted alone."""
    facets = tagged.facets[name]
    mesh = tagged.mesh
    owned = facets < mesh.topology.index_map(tagged.dim - 1).size_local
    count = mesh.comm.allreduce(int(owned.sum()))
    chosen = surface.mask(facets) != 0
    inside = count - int(chosen.sum())
    if not chosen.any():
        return f"{count:6d}   {'all inside the body' if count else ''}".rstrip()
    areas = surface.areas[chosen]
    corners = surface.corners[chosen].reshape(-1, tagged.dim)
    ranges = zip(corners.min(axis=0), corners.max(axis=0), strict=True)
    box = " x ".join(f"[{_number(low)}, {_number(high)}]" for low, high in ranges)
    centre = ", ".join(map(_number, areas @ surface.centres[chosen] / areas.sum()))
    area = f"{areas.sum():12.6g}" if tagged.dim > 1 else f"{'':12}"
    more = f", {inside} inside the body" if inside else ""
    return f"{count:6d}   {area}   ({centre}), {box}{more}"


def _number(x: float) -> str:
    """Five digits, without those of rounding."""
    return f"{0.0 if abs(x) < 1e-12 else x:.5g}"


def _cells(tagged: TaggedMesh) -> list[str]:
    """Numbers of cells of each named group."""
    here = tagged.mesh.topology.index_map(tagged.dim).size_local
    counts = {
        name: tagged.mesh.comm.allreduce(int((cells < here).sum()))
        for name, cells in tagged.cells.items()
    }
    listed = [f"{name} ({count})" for name, count in list(counts.items())[:_MOST_LISTED]]
    return ["", f"cell groups      {', '.join(listed)}"] if listed else []


def _coincident(surface: Boundary) -> list[str]:
    """Pairs of surface nodes at one place, as of parts that touch and are not joined."""
    _, first = np.unique(surface.vertices, return_index=True)
    points: Array = surface.corners.reshape(-1, surface.dim)[first]
    pairs = KDTree(points).query_pairs(_COINCIDENT * float(surface.sizes.min()))
    if not pairs:
        return []
    where = ", ".join(map(_number, points[min(pairs)[0]]))
    return [
        "",
        f"coincident nodes {len(pairs)} pairs, one at ({where}) m: parts touch there and are not "
        "joined; merge the nodes where they should be",
    ]
