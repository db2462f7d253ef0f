"""All pictures of a results folder, and the list of them."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import cache, partial
from pathlib import Path

from fenics_nnm.errors import OutputError
from fenics_nnm.output.picture import Picture
from fenics_nnm.output.pictures.accuracy import accuracy_plots
from fenics_nnm.output.pictures.animation import plan_animation
from fenics_nnm.output.pictures.backbone import frequency_plots
from fenics_nnm.output.pictures.body import plan_energies, plan_mesh, view_of
from fenics_nnm.output.pictures.contact import contact_plots
from fenics_nnm.output.pictures.linear_shapes import plan_linear
from fenics_nnm.output.pictures.motion import motion_plots
from fenics_nnm.output.pictures.multipliers import multiplier_plots
from fenics_nnm.output.pictures.panels import Animation, Plan
from fenics_nnm.output.pictures.renderer import RenderError, render
from fenics_nnm.output.pictures.results import Results, read_results
from fenics_nnm.output.pictures.shares import share_plots
from fenics_nnm.output.pictures.space_time import space_time_plots
from fenics_nnm.output.pictures.style import Plot
from fenics_nnm.output.shared_pictures import in_formats, kept_pictures
from fenics_nnm.results.durable import write_whole

logger = logging.getLogger(__name__)

#: File with the list of the pictures, in their folder.
MANIFEST = "pictures.json"

#: Formats that plots can be written in.
FORMATS = ("png", "svg", "pdf")

#: Formats of pictures of bodies, which vectors would not make smaller.
_OF_BODIES = ("png",)

#: What makes plots, in the order of the list.
_PLOTS: tuple[Callable[[Results], list[Plot]], ...] = (
    frequency_plots,
    contact_plots,
    motion_plots,
    space_time_plots,
    share_plots,
    accuracy_plots,
    multiplier_plots,
)


def make_pictures(
    results: Path, folder: Path, *, formats: Sequence[str] = ("png", "svg")
) -> tuple[Picture, ...]:
    """Draw all that makes sense for a results folder, and write the list of it.

    Args:
        results: Results folder of a run, of a mesh or of matrices.
        folder: Folder of the pictures, made if need be.
        formats: Formats of the plots, the first one that of `Picture.file`; pictures of the body
            are PNG and GIF files.

    Raises:
        OutputError: if there is no branch to draw, or the pictures cannot be written.
    """
    found = read_results(results)

    @cache
    def plots() -> list[Plot]:
        return [plot for make in _PLOTS for plot in make(found)]

    def drawn() -> tuple[Picture, ...]:
        each = [
            kept_pictures(results, folder, kind, partial(_all_saved, plots, folder, kind))
            for kind in formats
        ]
        return (*in_formats(each), *_of_body(results, folder, body_plans(found)))

    return drawn_in(folder, drawn)


def _all_saved(plots: Callable[[], list[Plot]], folder: Path, kind: str) -> tuple[Picture, ...]:
    """Plots in one format."""
    return tuple(saved(plot, folder, (kind,)) for plot in plots())


def _of_body(results: Path, folder: Path, plans: Sequence[Plan]) -> tuple[Picture, ...]:
    """Pictures of the body, as far as they can be drawn."""
    return kept_pictures(
        results, folder, "body", lambda: tuple(draw(plans, folder)), count=len(plans)
    )


def drawn_in(folder: Path, draw_all: Callable[[], tuple[Picture, ...]]) -> tuple[Picture, ...]:
    """Pictures in a folder, made if need be, with the list of them.

    Raises:
        OutputError: if something cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        pictures = draw_all()
        write_manifest(folder, pictures)
    except OSError as error:
        raise OutputError(
            f"{error.filename or folder}: cannot be written: {error.strerror or error}"
        ) from error
    return pictures


def body_plans(results: Results) -> list[Plan]:
    """Mesh, shapes at several energies and motion of a body; nothing for matrices."""
    body = results.body
    if body is None:
        return []
    view = view_of(body, results.shown[-1], results.tip)
    return [
        plan_mesh(body, view),
        plan_energies(results, body, view),
        *plan_linear(results, body, view),
        plan_animation(results, body, view),
    ]


def draw(plans: Sequence[Plan], folder: Path) -> list[Picture]:
    """Draw planned pictures of bodies; where there is no renderer, say so in a line and go on.

    Args:
        plans: Pictures with their scenes.
        folder: Folder of the PNG and GIF files.

    Raises:
        OSError: if they cannot be written.
    """
    if not plans:
        return []
    try:
        images = iter(render([scene for plan in plans for scene in plan.scenes]))
    except RenderError as error:
        logger.warning("pictures of the body are left out, as they cannot be drawn: %s", error)
        return []
    return [
        saved(plan.finish([next(images) for _ in plan.scenes]), folder, _OF_BODIES)
        for plan in plans
    ]


def write_manifest(folder: Path, pictures: Sequence[Picture]) -> None:
    """Write the list of the pictures in a folder.

    Raises:
        OSError: if it cannot be written.
    """
    listed = {"pictures": [asdict(picture) for picture in pictures]}
    write_whole(folder / MANIFEST, f"{json.dumps(listed, indent=2)}\n".encode())


def saved(plot: Plot | Animation, folder: Path, formats: Sequence[str]) -> Picture:
    """Save a picture in some formats, the first one that of `Picture.file`."""
    file, *also = plot.save(folder, formats)
    return Picture(file, plot.title, plot.caption, plot.group, tuple(also))
