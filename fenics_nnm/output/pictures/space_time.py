"""Motions of slender bodies over their length and time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.style import (
    SIGNED,
    SIGNED_RATE,
    TIME,
    Plot,
    label,
    label_bar,
    new_figure,
    unit_for,
)
from fenics_nnm.results.stored_branch import StoredBranch

#: Bodies longer than this many times their width are drawn over their length.
_SLENDER = 2.5

#: Most cross-sections of a body that is drawn, and fewest.
_MOST, _FEWEST = 80, 5

#: Steps of the period.
_INSTANTS = 180

#: Cross-sections whose mean moves by less than this part of a node have no common motion.
_COMMON = 0.05


class Sections(NamedTuple):
    """Cross-sections of a body along an axis.

    Attributes:
        axis: Number of the axis, from 0.
        place: Coordinate of each in m, ascending, shape (s,).
        mean: Takes the mean over the nodes of each, shape (s, n).
    """

    axis: int
    place: Array
    mean: csr_array


def cross_sections(nodes: Array) -> Sections | None:
    """Cross-sections of a slender body; None if it is not slender, or has too few nodes.

    Args:
        nodes: Places of the nodes in m, shape (n, 3).
    """
    extent = np.ptp(nodes, axis=0)
    axis = int(np.argmax(extent))
    if extent[axis] < _SLENDER * np.sort(extent)[-2]:
        return None
    section = _numbered(nodes[:, axis])
    count = np.bincount(section)
    if len(count) < _FEWEST:
        return None
    mean = csr_array((1 / count[section], (section, np.arange(len(nodes)))))
    return Sections(axis, mean @ nodes[:, axis], mean)


def _numbered(place: Array) -> Indices:
    """Number of the cross-section of each node: nodes at one place, or in one slice."""
    fine = np.round((place - place.min()) / np.ptp(place) * 1e6).astype(np.int64)
    _, number = np.unique(fine, return_inverse=True)
    if number.max() < _MOST:
        return number
    slices = np.minimum((fine * _MOST) // 1_000_000, _MOST - 1)
    _, number = np.unique(slices, return_inverse=True)
    return number


def space_time_plots(results: Results) -> list[Plot]:
    """Displacement and velocity of the cross-sections of a slender body over one period."""
    body = results.body
    sections = cross_sections(body.nodes) if body is not None else None
    if body is None or sections is None:
        return []
    point = results.chosen[-1]
    time, phase = results.period_about(point, _INSTANTS)
    displacement, velocity = _means(body, point, phase, sections)
    component = int(np.argmax(np.abs(displacement).max(axis=(0, 1))))
    largest = np.abs(displacement[:, :, component]).max()
    if largest < _COMMON * body.largest_displacement(point).max():
        return []
    along, letter = "xyz"[sections.axis], "xyz"[component]
    figure = new_figure(4.6)
    length, speed = unit_for(displacement, "m"), unit_for(velocity, "m/s")
    rows = (
        (displacement, "displacement", length, SIGNED),
        (velocity, "velocity", speed, SIGNED_RATE),
    )
    grid = figure.subplots(2, 1, sharex=True)
    for axes, (field, name, unit, colours) in zip(grid, rows, strict=True):
        values = unit.factor * field[:, :, component].T
        limit = float(np.abs(values).max())
        image = axes.pcolormesh(
            time,
            1e3 * sections.place,
            values,
            cmap=colours,
            vmin=-limit,
            vmax=limit,
            shading="gouraud",
            rasterized=True,
        )
        label(axes, TIME if axes is grid[-1] else "", f"place along {along}  (mm)")
        axes.grid(visible=False)
        label_bar(figure.colorbar(image, ax=axes), f"{name} {letter}  ({unit.name})")
    caption = (
        f"Displacement in {length.name} and velocity in {speed.name} along {letter}, means over "
        f"the nodes of each cross-section, over the place along {along} in mm and one period, "
        f"at gamma ratio {point.gamma_ratio:.4g} ({point.motion.frequency:.5g} Hz). The middle of "
        "contact is at time 0."
    )
    return [Plot("space_time", "Motion over place and time", caption, "motion", figure)]


def _means(
    body: StoredBranch, point: BranchPoint, phase: Array, sections: Sections
) -> tuple[Array, Array]:
    """Mean displacement and velocity of cross-sections, each (len(phase), s, dim)."""
    fields = (body.displacement, body.velocity)
    instants = [np.array([each]) for each in phase]
    return tuple(  # type: ignore[return-value]
        np.array([sections.mean @ field(point, instant)[0] for instant in instants])
        for field in fields
    )
