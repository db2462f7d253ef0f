"""Pictures of a stored response: all its levels, and each with all places that are watched."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from fenics_nnm.errors import OutputError
from fenics_nnm.output.gallery import drawn_in, saved
from fenics_nnm.output.picture import Picture
from fenics_nnm.output.pictures.response import response_plot
from fenics_nnm.output.pictures.style import Plot
from fenics_nnm.response.levels import Response
from fenics_nnm.results.response_file import NAME, StoredResponse, read

_DASHED = "Dashed: unstable. Grey bands: no amplitude is known, as where a gap would close."


def make_response_pictures(
    results: Path, folder: Path, *, formats: Sequence[str] = ("png", "svg")
) -> tuple[Picture, ...]:
    """Draw a stored response, and write the list of the pictures.

    Args:
        results: Folder of a response, or its response.h5.
        folder: Folder of the pictures, made if need be.
        formats: Formats of the plots, the first one that of `Picture.file`.

    Raises:
        OutputError: if there is no response to draw, or the pictures cannot be written.
    """
    plots = response_plots(stored_response(results))
    return drawn_in(folder, lambda: tuple(saved(plot, folder, formats) for plot in plots))


def stored_response(results: Path) -> StoredResponse:
    """The response in a folder, or in its file.

    Raises:
        OutputError: if it cannot be read, or has no points.
    """
    path = results / NAME if results.is_dir() else results
    stored = read(path)
    if not stored.found.points:
        raise OutputError(f"{path}: has no points to draw")
    return stored


def response_plots(stored: StoredResponse) -> Iterator[Plot]:
    """The curves of all levels over the damped backbone, then each level by itself."""
    found, title = stored.found, str(stored.header.values.get("title", ""))
    first = stored.watched.names[0]
    several = len(found.levels) > 1
    yield Plot(
        name="response",
        title="Response over frequency",
        caption=f"Amplitude of the first harmonic (0-peak) and its lag, {_shown(found, first)} "
        f"Dotted: damped backbone. {_DASHED}",
        group="frequency",
        figure=response_plot(stored.watched.names, found, title),
    )
    for level in found.levels if several else ():
        own = found.only((level,))
        if own.points:
            yield Plot(
                name=f"response_level{level:g}",
                title=f"Response at level {level:g}",
                caption="Amplitude of the first harmonic (0-peak) and its lag of all places that "
                f"are watched, and the contact point that moves most. {_DASHED}",
                group="frequency",
                figure=response_plot(stored.watched.names, own, f"{title}, level {level:g}"),
            )


def _shown(found: Response, first: str) -> str:
    if len(found.levels) > 1:
        return f"of {first} at all levels of the forces."
    return "of the places that are watched and the contact point that moves most."
