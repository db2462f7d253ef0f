"""Where a structure touches: contact patches laid flat, with the largest pressure of the period."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import Normalize

from fenics_nnm.arrays import Array
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.style import (
    GREY,
    OUTLINE,
    PRESSURE,
    Plot,
    Unit,
    label,
    label_bar,
    new_figure,
    unit_for,
)
from fenics_nnm.output.pictures.unrolled import Unrolling
from fenics_nnm.results.stored_branch import StoredBranch

#: Fewest points of a patch that is drawn, and of patches that are: more have no room.
_FEWEST, _MOST_PATCHES = 3, 4

#: Height of the picture of one patch in inches: least and most.
_HEIGHTS = (1.3, 3.2)

#: Patches wider than this part of their length are drawn to scale; others would be lines.
_TO_SCALE = 0.2


def footprints(results: Results) -> list[Plot]:
    """Patches of a body laid flat, at the largest of the chosen energies; none of matrices."""
    body, areas = results.body, results.areas
    if body is None or areas is None or body.nodes.shape[1] < 3 or body.shapes.shape[2] < 3:
        return []
    patches = [n for n in np.unique(body.contact_patches) if _count(body, n) >= _FEWEST]
    if not patches:
        return []
    point = results.chosen_touching[-1]
    largest = point.motion.force.max(axis=0) / areas
    unit = unit_for(largest, "Pa")
    drawn = patches[:_MOST_PATCHES]
    figure = new_figure(0.9 + sum(_height(body, patch) for patch in drawn))
    heights = [_height(body, patch) for patch in drawn]
    grid = figure.subplots(len(drawn), 1, squeeze=False, height_ratios=heights)[:, 0]
    norm = Normalize(0, unit.factor * float(largest.max()))
    for axes, patch in zip(grid, drawn, strict=True):
        marks = _draw(axes, body, int(patch), unit.factor * largest, norm)
        label(axes, "place along the patch  (mm)", "across  (mm)")
    bar = figure.colorbar(marks, ax=list(grid))
    label_bar(bar, f"largest pressure  ({unit.name})")
    return [Plot("footprint", "Footprint of the contact", _words(results, unit), "contact", figure)]


def _words(results: Results, unit: Unit) -> str:
    point = results.chosen_touching[-1]
    touching = int(np.count_nonzero(point.motion.force.max(axis=0) > 0))
    return (
        f"The contact patch laid flat, at gamma ratio {point.gamma_ratio:.4g} "
        f"({point.motion.frequency:.5g} Hz): place along it and distance across from its middle "
        f"line, in mm. Discs are contact points; coloured by their largest pressure of the period "
        f"in {unit.name} are the {touching} that touch. Lines are the mesh."
    )


def _count(body: StoredBranch, patch: int) -> int:
    return int(np.count_nonzero(body.contact_patches == patch))


def _height(body: StoredBranch, patch: int) -> float:
    size = np.ptp(_flat_points(body, patch), axis=0)
    return float(np.clip(3.6 * size[1] / max(size[0], 1e-12), *_HEIGHTS))


def _flat_points(body: StoredBranch, patch: int) -> Array:
    places = body.contact_points[body.contact_patches == patch]
    return Unrolling.of(places).flat(places)


def _draw(
    axes: Axes, body: StoredBranch, patch: int, pressure: Array, norm: Normalize
) -> PathCollection:
    own = body.contact_patches == patch
    places = body.contact_points[own]
    way = Unrolling.of(places)
    axes.add_collection(LineCollection(_edges(body, patch, way), colors=OUTLINE, lw=0.4, alpha=0.6))
    x, y = 1e3 * way.flat(places).T
    touching = pressure[own] > 0
    axes.scatter(x[~touching], y[~touching], s=16, facecolors="white", edgecolors=GREY, zorder=2)
    marks = axes.scatter(
        x[touching],
        y[touching],
        c=pressure[own][touching],
        s=70,
        cmap=PRESSURE,
        norm=norm,
        edgecolors="black",
        lw=0.5,
        zorder=3,
    )
    axes.autoscale_view()
    if np.ptp(y) > _TO_SCALE * np.ptp(x):
        axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.06, 0.25)
    return marks


def _edges(body: StoredBranch, patch: int, way: Unrolling) -> Sequence[Array]:
    """Edges of the facets of a patch laid flat in mm, each of shape (2, 2)."""
    own = (body.facet_patch == patch) & (body.facet_side == 0)
    facets = body.contact_facets[own]
    corners = 4 if facets.shape[1] in (4, 8, 9) else 3
    facets = facets[:, :corners]
    pairs = np.concatenate([facets[:, [n, (n + 1) % corners]] for n in range(corners)])
    pairs = np.unique(np.sort(pairs, axis=1), axis=0)
    flat = 1e3 * way.flat(body.nodes[pairs.ravel()]).reshape(-1, 2, 2)
    return list(flat)
