"""Section about contact: where it can happen, and how hard it is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.output.html_report.elements import Column, Html, folded, table
from fenics_nnm.output.html_report.figures import Gallery
from fenics_nnm.output.html_report.page import Section
from fenics_nnm.output.html_report.words import plain
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.results.stored_branch import StoredBranch

_MOTIONS = (
    Column("gamma ratio (1)"),
    Column("contact (% of period)"),
    Column("points that touch"),
    Column("largest total force (N)"),
    Column("largest force at a point (N)"),
    Column("penetration between samples (µm)"),
)

_PATCHES = (
    Column("patch", "word"),
    Column("points"),
    Column("area (mm²)"),
    Column("smallest gap (mm)"),
    Column("largest gap (mm)"),
    Column("mean direction (1)", "word"),
)

#: Most contact points that are listed.
_MOST_PLACES = 200


def contact(results: Results, gallery: Gallery) -> Section:
    """Forces of some motions, their pictures, and where the contact points are."""
    content: tuple[Html, ...] = ()
    patches = [_patch(each) for each in results.summary.get("contact_patches", [])]
    if patches:
        content += (table(_PATCHES, patches, label="Contact patches"),)
    rows = [_row(point) for point in results.chosen_touching]
    if rows:
        content += (table(_MOTIONS, rows, label="Contact of some motions"),)
    content += gallery.figures("contact")
    if results.body is not None and results.areas is not None:
        content += (_places(results, results.body, results.areas),)
    return Section("contact", "Contact", content, "no motion of the branch touches the obstacle.")


def _patch(patch: dict[str, Any]) -> Sequence[str]:
    return (
        patch["name"],
        str(patch["points"]),
        plain(1e6 * patch["area_m2"]),
        plain(1e3 * patch["smallest_gap_m"]),
        plain(1e3 * patch["largest_gap_m"]),
        _direction(patch["mean_direction"]),
    )


def _direction(mean: Sequence[float]) -> str:
    """The mean direction of a patch; zeros stand for none."""
    if not any(mean):
        return "several sides"
    return "(" + ", ".join(f"{x:.3f}" for x in mean) + ")"


def _row(point: BranchPoint) -> Sequence[str]:
    force = point.motion.force
    return (
        f"{point.gamma_ratio:.6g}",
        f"{100 * point.motion.contact_fraction:.3g}",
        f"{np.count_nonzero(force.max(axis=0) > 0)} of {force.shape[1]}",
        plain(force.sum(axis=1).max()),
        plain(force.max()),
        f"{1e6 * point.balance.penetration:.2g}",
    )


def _places(results: Results, body: StoredBranch, areas: Array) -> Html:
    """Place, direction, gap and area of the contact points, on demand."""
    axes = "xyz"[: body.contact_directions.shape[1]]
    columns = (
        Column("contact point"),
        *(Column(f"{axis} (mm)") for axis in axes),
        *(Column(f"towards the obstacle: {axis} (1)") for axis in axes),
        Column("gap (mm)"),
        Column("area (mm²)"),
    )
    places, gap = body.contact_points[:, : len(axes)], results.model.gap
    values = np.column_stack([1e3 * places, body.contact_directions, 1e3 * gap, 1e6 * areas])
    rows = [
        (str(number), *(f"{value:.5g}" for value in row))
        for number, row in enumerate(values.tolist(), start=1)
    ]
    label = f"The {len(rows)} contact points" if len(rows) > 1 else "The contact point"
    if len(rows) > _MOST_PLACES:
        rows, label = rows[:_MOST_PLACES], f"{label}: the first {_MOST_PLACES}"
    return folded(label, table(columns, rows, label=label))
