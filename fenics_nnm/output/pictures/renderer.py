"""Drawing of scenes by VTK, off the screen and in a process of its own.

Without a display or a driver VTK may end its process instead of raising an error, and must not take
a finished run with it.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_nnm.output.pictures.scene import Arrows, Balls, Camera, Faces, Lines, Scene

Image = NDArray[np.uint8]
"""Colours red, green and blue of shape (height, width, 3)."""

#: Longest time for all scenes of a call in s.
_PATIENCE = 600.0

#: Pictures are drawn larger by this factor and then made smaller, for smooth edges.
_FINER = 2

#: Faces are drawn nearer to the viewer than those of the layer before, and lines than all faces,
#: by these parts of the picture's size, so that of two that coincide the later one is seen.
_NEARER, _LINES_NEARER = 2e-4, 4e-3


class RenderError(Exception):
    """Scenes cannot be drawn here; the message says why in a line."""


def render(scenes: Sequence[Scene]) -> list[Image]:
    """Draw scenes, in another process.

    Raises:
        RenderError: if that process has no VTK, or cannot draw.
    """
    with tempfile.TemporaryDirectory(prefix="fenics-nnm-") as folder:
        asked, drawn = Path(folder) / "scenes", Path(folder) / "images"
        asked.write_bytes(pickle.dumps(list(scenes)))
        try:
            ended = subprocess.run(
                [sys.executable, "-P", "-m", __spec__.name, str(asked), str(drawn)],
                env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
                capture_output=True,
                text=True,
                timeout=_PATIENCE,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise RenderError(" ".join(str(error).split())) from error
        if ended.returncode or not drawn.exists():
            raise RenderError(_reason(ended))
        return list(pickle.loads(drawn.read_bytes()))


def _reason(ended: subprocess.CompletedProcess[str]) -> str:
    """Why a process failed: the last line that it wrote."""
    lines = [line for line in ended.stderr.splitlines() if line.strip()]
    message = lines[-1].strip() if lines else ""
    if ended.returncode < 0:
        return f"VTK ended by signal {-ended.returncode}" + (f": {message}" if message else "")
    return message or f"VTK ended with code {ended.returncode}"


def _drawn(scene: Scene, pyvista: Any) -> Image:
    camera = scene.camera
    width, height = camera.pixels
    plotter = pyvista.Plotter(off_screen=True, window_size=(_FINER * width, _FINER * height))
    plotter.set_background("white")
    size = float(np.max(camera.high - camera.low))
    for number, layer in enumerate(scene.layers):
        faces = number * _NEARER * size * camera.frame[2]
        lines = _LINES_NEARER * size * camera.frame[2]
        _ADD[type(layer)](plotter, layer.nearer(faces, lines), pyvista)
    _aim(plotter, camera)
    image = np.asarray(plotter.screenshot(return_img=True))[:, :, :3].astype(np.float64)
    plotter.close()
    blocks = image.reshape(height, _FINER, width, _FINER, 3)
    return np.asarray(blocks.mean(axis=(1, 3)).round(), dtype=np.uint8)


def _aim(plotter: Any, camera: Camera) -> None:
    """Show the camera's rectangle without perspective, from far away."""
    right, up, towards = camera.frame
    middle = (camera.low + camera.high) / 2
    lowest, highest = np.array(plotter.bounds)[::2], np.array(plotter.bounds)[1::2]
    away = 2 * float(np.linalg.norm(highest - lowest)) + float(np.max(camera.high - camera.low))
    focus = middle[0] * right + middle[1] * up + ((lowest + highest) / 2 @ towards) * towards
    plotter.enable_parallel_projection()
    plotter.camera.focal_point = focus
    plotter.camera.position = focus + away * towards
    plotter.camera.up = up
    plotter.camera.parallel_scale = float(camera.high[1] - camera.low[1]) / 2
    plotter.camera.clipping_range = (1e-3 * away, 10 * away)


def _add_faces(plotter: Any, faces: Faces, pyvista: Any) -> None:
    width = np.full((len(faces.corners), 1), faces.corners.shape[1])
    mesh = pyvista.PolyData(np.asarray(faces.nodes), np.hstack([width, faces.corners]))
    values: dict[str, Any] = {"color": faces.colour}
    if faces.values is not None:
        values = {"scalars": faces.values, "clim": faces.limits, "cmap": faces.colours}
    plotter.add_mesh(
        mesh,
        **values,
        opacity=faces.opacity,
        show_edges=faces.edges,
        edge_color="#606060",
        line_width=_FINER * 0.6,
        lighting=faces.lit,
        ambient=0.6,
        diffuse=0.55,
        show_scalar_bar=False,
        interpolate_before_map=True,
    )


def _add_lines(plotter: Any, lines: Lines, pyvista: Any) -> None:
    plotter.add_lines(
        np.asarray(lines.ends).reshape(-1, 3), color=lines.colour, width=_FINER * lines.width
    )


def _add_balls(plotter: Any, balls: Balls, pyvista: Any) -> None:
    points = pyvista.PolyData(np.asarray(balls.places))
    points["radius"] = balls.radii
    ball = pyvista.Sphere(radius=1.0, theta_resolution=16, phi_resolution=16)
    plotter.add_mesh(points.glyph(geom=ball, scale="radius", orient=False), color=balls.colour)


def _add_arrows(plotter: Any, arrows: Arrows, pyvista: Any) -> None:
    points = pyvista.PolyData(np.asarray(arrows.places))
    points["vector"] = arrows.vectors
    arrow = pyvista.Arrow(tip_length=0.3, tip_radius=0.09, shaft_radius=0.03)
    plotter.add_mesh(points.glyph(geom=arrow, orient="vector", scale="vector"), color=arrows.colour)


_ADD: dict[type, Any] = {
    Faces: _add_faces,
    Lines: _add_lines,
    Balls: _add_balls,
    Arrows: _add_arrows,
}


def _main(asked: str, drawn: str) -> None:
    """Draw the scenes of one file into another."""
    import pyvista

    scenes = pickle.loads(Path(asked).read_bytes())
    Path(drawn).write_bytes(pickle.dumps([_drawn(scene, pyvista) for scene in scenes]))


if __name__ == "__main__":
    _main(*sys.argv[1:])
