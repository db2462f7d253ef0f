"""Pages and pictures on a full disk: the older ones stay whole."""

from __future__ import annotations

import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from fenics_nnm.errors import OutputError
from fenics_nnm.output.gallery import write_manifest
from fenics_nnm.output.html_report.page import write_page
from fenics_nnm.output.picture import Picture
from fenics_nnm.output.pictures.gif import write_gif
from fenics_nnm.output.pictures.style import new_axes, new_figure, save


@contextmanager
def full(most: int) -> Iterator[None]:
    """No file can grow beyond some bytes."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def _page(folder: Path) -> None:
    write_page(folder / "a.html", "x" * 5000)


def _plot(folder: Path) -> None:
    figure = new_figure()
    new_axes(figure, "x", "y").plot([1, 2], [3, 4])
    save(figure, folder, "a", ["png"])


def _animation(folder: Path) -> None:
    noise = np.random.default_rng(1).integers(0, 255, (2, 60, 60, 3), dtype=np.uint8)
    write_gif(folder / "a.gif", list(noise))


def _manifest(folder: Path) -> None:
    write_manifest(folder, [Picture("a.png", "title", "caption" * 500, "group")])


@pytest.mark.parametrize("write", [_page, _plot, _animation, _manifest])
def test_what_was_there_stays_whole(write: Callable[[Path], None], tmp_path: Path) -> None:
    write(tmp_path)
    (path,) = tmp_path.iterdir()
    before = path.read_bytes()
    assert len(before) > 2000
    with full(2000), pytest.raises((OutputError, OSError)):
        write(tmp_path)
    assert [each.read_bytes() for each in tmp_path.iterdir()] == [before]
