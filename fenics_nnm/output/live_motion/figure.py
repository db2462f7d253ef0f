"""The figure of a page in which a motion is turned and played, with its scripts."""

from __future__ import annotations

import gzip
import json
from base64 import b64encode
from collections.abc import Sequence
from importlib.resources import files
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from fenics_nnm.arrays import Array
from fenics_nnm.output.html_report.elements import Html, element, joined, text, void
from fenics_nnm.output.html_report.page import Script
from fenics_nnm.output.live_motion.library import Library, installed_library
from fenics_nnm.output.live_motion.motion import LiveMotion, live_motion, written
from fenics_nnm.output.live_motion.scene import Part, scene_file
from fenics_nnm.output.pictures.body import view_of
from fenics_nnm.output.pictures.casing_sheet import CASING
from fenics_nnm.output.pictures.obstacle import OPACITY, Sheet
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.scene import Camera, View, size_of
from fenics_nnm.output.pictures.style import OUTLINE, RED, SIZE, unit_for

#: Time in ms that a period takes at first.
_PERIOD = 3000

#: So many contact points have room for large dots.
_FEW = 30

#: The look of the surface: brightness shows its slope.
_LIT = {"ambient": 0.65, "diffuse": 0.45, "specular": 0.0}

#: Instants of a period at which it is looked how far the motion reaches.
_LOOKS = 8

#: Colours of the scale, and of contact points that are not pressed.
_COLOURS, _APART = 64, "#404040"


def live_figure(results: Results) -> tuple[Html, tuple[Script, ...]]:
    """The figure of the last of the chosen motions, and the scripts that it needs.

    There is none of matrices, and none where vtk.js is not installed.

    Raises:
        OutputError: if the cells have no faces.
    """
    body, library = results.body, installed_library()
    if body is None or library is None:
        return Html(""), ()
    point = results.chosen[-1]
    motion = live_motion(results, body, point)
    view = view_of(body, results.shown[-1], results.tip)
    own = files("fenics_nnm.output.live_motion").joinpath("viewer.js").read_text("utf-8")
    told = (
        f"Motion at gamma ratio {point.gamma_ratio:.4g}, {point.motion.frequency:.6g} Hz: to turn "
        "and to play"
    )
    return (
        joined(
            [_figure(motion, told), *_data(motion, view, library), element("script", Html(own))]
        ),
        (Script(own), Script(library.script)),
    )


def _figure(motion: LiveMotion, title: str) -> Html:
    keys = (
        "Motion of the body. Arrow keys turn it, plus and minus zoom, Home shows it as at first, "
        "the space bar plays and pauses"
    )
    stage = element(
        "div", id="live-stage", class_="stage", tabindex="0", role="application", aria_label=keys
    )
    caption = element("figcaption", element("strong", text(f"{title}. ")), text(_words(motion)))
    return element(
        "figure",
        stage,
        element("div", *_controls(), class_="controls"),
        _scale(motion),
        caption,
        id="live-figure",
        class_="wide turning",
        hidden="",
    )


def _words(motion: LiveMotion) -> str:
    words = (
        "Drag to turn, click and use the wheel to zoom; or use the arrow keys, + and -, Home and "
        "the space bar. Lines: at rest. Red: contact points that are pressed."
    )
    if motion.sheets:
        words += " Brown: the obstacle, its gap enlarged like the displacements."
    if motion.coarser:
        words += (
            f" The surface is drawn with {motion.surface_nodes} of its nodes, to keep this page "
            "small; pictures and ParaView files have all."
        )
    return words


def _controls() -> Sequence[Html]:
    return (
        element("button", text("Play"), type="button", id="live-play"),
        element("button", text("View as at first"), type="button", id="live-home"),
        _slider("time", "t / T", "0", "1", "0.005", "instant"),
        _slider("factor", "enlarged", "-1", "1", "0.01", "times"),
    )


def _slider(name: str, label: str, low: str, high: str, step: str, shown: str) -> Html:
    slider = {"id": f"live-{name}", "type": "range", "min": low, "max": high, "step": step}
    value = element("output", id=f"live-{shown}", for_=f"live-{name}")
    return element("label", element("span", text(label)), void("input", **slider), value)


def _scale(motion: LiveMotion) -> Html:
    """The scale of colours of displacements."""
    unit = unit_for(np.array([motion.largest]), "m")
    stops = ", ".join(
        f"rgb({red} {green} {blue})" for red, green, blue in _table()[:: _COLOURS // 8]
    )
    return element(
        "div",
        element("span", text("0")),
        element("span", class_="bar", style=f"background: linear-gradient(to right, {stops})"),
        element("span", text(f"{unit.factor * motion.largest:.3g} {unit.name} displacement")),
        class_="scale",
    )


def _table() -> NDArray[np.uint8]:
    """Colours of the scale, shape (_COLOURS, 3)."""
    return np.round(255 * colormaps[SIZE](np.linspace(0, 1, _COLOURS))[:, :3]).astype(np.uint8)


def _data(motion: LiveMotion, view: View, library: Library) -> Sequence[Html]:
    """What the script reads, in elements that nothing runs."""
    told = json.dumps({**written(motion), **_seen(motion, view)}, separators=(",", ":"))
    packed = gzip.compress(library.script.encode(), mtime=0)
    notice = library.notice.replace("--", "- -")
    return (
        _kept("motion", "application/json", told.replace("</", "<\\/")),
        _kept("scene", "text/plain", b64encode(scene_file(_parts(motion))).decode()),
        Html(f"<!-- {notice} -->"),
        _kept("library", "text/plain", b64encode(packed).decode()),
    )


def _kept(name: str, kind: str, contents: str) -> Html:
    return element("script", Html(contents), type=kind, id=f"live-{name}")


def _seen(motion: LiveMotion, view: View) -> dict[str, Any]:
    """Camera, colours and the first instant."""
    camera = Camera.around(_reached(motion), view, pixels=1)
    _, up, towards = view.frame
    flat = (camera.low + camera.high) / 2
    middle = flat @ view.frame[:2] + (motion.places.mean(axis=0) @ towards) * towards
    return {
        "middle": middle.tolist(),
        "half": ((camera.high - camera.low) / 2).tolist(),
        "away": 3 * size_of(motion.places),
        "up": up.tolist(),
        "towards": towards.tolist(),
        "colours": b64encode(_table().tobytes()).decode(),
        "touched": _rgb(RED),
        "apart": _rgb(_APART),
        "start": 0.5,
        "milliseconds": _PERIOD,
    }


def _reached(motion: LiveMotion) -> Array:
    """Places that the motion and the obstacle reach as they are drawn at first, shape (p, 3)."""
    phase = np.linspace(0, 2 * np.pi, _LOOKS, endpoint=False)
    moved = motion.places + motion.factor * motion.waves.at(phase)
    sheets = [each.at(motion.factor) for each in motion.sheets]
    return np.vstack([motion.places, moved.reshape(-1, 3), *sheets])


def _rgb(colour: str) -> list[int]:
    return [round(255 * part) for part in to_rgb(colour)]


def _parts(motion: LiveMotion) -> list[Part]:
    """The surface, its outline at rest, contact points and the obstacle."""
    surface = motion.places[: motion.surface_nodes]
    points = motion.places[motion.surface_nodes :]
    dots, size = np.arange(len(points))[:, None], 7 if len(points) <= _FEW else 4
    return [
        Part(surface, motion.faces, "polys", _LIT, coloured=True),
        Part(surface, motion.edges, "lines", {**_in(OUTLINE), "lineWidth": 1}),
        Part(points, dots, "verts", {"pointSize": size, "lighting": False}, coloured=True),
        *(_obstacle(each, motion.factor) for each in motion.sheets),
    ]


def _obstacle(sheet: Sheet, factor: float) -> Part:
    places = sheet.at(factor)
    if sheet.corners.shape[1] == 2:
        return Part(places, sheet.corners, "lines", {**_in(CASING), "lineWidth": 3})
    return Part(places, sheet.corners, "polys", {**_in(CASING), "opacity": OPACITY})


def _in(colour: str) -> dict[str, Any]:
    """The look of one colour in any light."""
    return {"color": to_rgb(colour), "diffuseColor": to_rgb(colour), "lighting": False}
