"""How all plots look: sizes, colours for every kind of eye, labels and files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colorbar import Colorbar
from matplotlib.colors import hsv_to_rgb, to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, ScalarFormatter

from fenics_nnm.arrays import Array
from fenics_nnm.output.pictures.written import WrittenFigure
from fenics_nnm.results.durable import replacing

#: Colours that can be told apart with any colour vision (Okabe and Ito, 2008).
BLUE, ORANGE, GREEN, RED = "#0072b2", "#e69f00", "#009e73", "#d55e00"
PURPLE, SKY, BLACK, GREY = "#cc79a7", "#56b4e9", "#000000", "0.55"

#: Colour of the outline of a body at rest.
OUTLINE = "#707070"

#: Colours and markers of curves that have no colour of their own, in this order.
CURVES = tuple(zip((BLUE, RED, GREEN, PURPLE, SKY, ORANGE, BLACK), "osD^vPX", strict=True))

#: Colour maps: of a quantity without sign, of contact pressure, of displacement, of velocity.
AMOUNT, PRESSURE, SIGNED, SIGNED_RATE = "viridis", "plasma_r", "PuOr_r", "RdBu_r"

#: The same of the size of a displacement on a body that is shaded: light where there is none.
SIZE = "YlGnBu"

#: Labels of axes that many plots share.
GAMMA = "gamma ratio  (1)"
TIME = "time over period  t / T  (1)"

#: Width of a plot in inches; with letters of 9 points it is still read at 8 cm.
WIDTH = 4.6

_PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "": 1.0, "m": 1e-3, "\N{MICRO SIGN}": 1e-6, "n": 1e-9}

#: Dots per inch of PNG files.
DPI = 200

#: Colours for parts beyond these (Tol's "muted"), and the part of a turn that the hues of any
#: further ones are apart, so that none comes again.
_MUTED = ("#332288", "#999933", "#882255", "#117733", "#aa4499", "#661100")
_TURN = (5**0.5 - 1) / 2

_SETTINGS = {"svg.hashsalt": "fenics-nnm", "pdf.compression": 6}

#: Files carry no date, so that the same results give the same file.
_METADATA: dict[str, dict[str, None]] = {
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
}


@dataclass(frozen=True, slots=True)
class Plot:
    """A drawn figure with what is said of it.

    Attributes:
        name: Name of its files, without the ending.
        title: A few words.
        caption: What is seen, in sentences, with units.
        group: What kind of picture it is: "frequency", "contact", "motion", "accuracy", "body" or
            "linear".
        figure: The figure.
    """

    name: str
    title: str
    caption: str
    group: str
    figure: Figure

    def save(self, folder: Path, formats: Sequence[str]) -> tuple[str, ...]:
        """Write it in all formats; the names of its files.

        Raises:
            OSError: if it cannot be written.
        """
        return save(self.figure, folder, self.name, formats)


def new_figure(height: float = 3.3, width: float = WIDTH) -> Figure:
    """An empty figure whose parts find room for themselves; sizes in inches."""
    figure = WrittenFigure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def new_axes(figure: Figure, abscissa: str, ordinate: str) -> Axes:
    """The only axes of a figure, with labels and a grid."""
    axes = figure.subplots()
    label(axes, abscissa, ordinate)
    return axes


def label(axes: Axes, abscissa: str, ordinate: str) -> None:
    """Labels, letters and grid of axes."""
    axes.set_xlabel(abscissa, fontsize=9, parse_math=False)
    axes.set_ylabel(ordinate, fontsize=9, parse_math=False)
    axes.tick_params(labelsize=8)
    axes.grid(alpha=0.3, lw=0.6)
    for axis in (axes.xaxis, axes.yaxis):
        if axis.get_scale() == "linear":
            axis.set_major_locator(MaxNLocator(6))
            axis.set_major_formatter(ScalarFormatter(useOffset=False))


def label_bar(bar: Colorbar, name: str) -> None:
    """Label and letters of a colour bar."""
    bar.set_label(name, fontsize=9)
    bar.ax.tick_params(labelsize=8)


def legend_below(figure: Figure, axes: Axes, columns: int = 2, title: str = "") -> None:
    """The legend of some axes below all axes, where it hides nothing."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        figure.legend(
            handles,
            labels,
            loc="outside lower center",
            ncols=columns,
            fontsize=8,
            title=title or None,
            title_fontsize=8,
            frameon=False,
        )


class Unit(NamedTuple):
    """A unit with its prefix, and how many of it are one unit without."""

    name: str
    factor: float


def unit_for(values: Array, base: str) -> Unit:
    """The unit that makes the largest value an easy number, such as mm or MPa.

    Args:
        values: Values in the unit without prefix.
        base: That unit: "m", "m/s", "N", "Pa" or "J". Lengths get no prefix above 1.
    """
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    length = base.startswith("m")
    for prefix, size in _PREFIXES.items():
        if not (length and size > 1) and largest >= size * (0.1 if length else 1.0):
            return Unit(prefix + base, 1 / size)
    return Unit(base, 1.0)


def shades(count: int) -> Array:
    """Colours of a sequence such as energies, from dark to light, shape (count, 4)."""
    return np.asarray(colormaps[AMOUNT](np.linspace(0.0, 0.85, count)))


def colours_of_parts(count: int, *, light: bool = False) -> list[str]:
    """Colours of parts that lie side by side, no two alike; light ones for a background.

    The first six are told apart with any colour vision.
    """
    known = [*(colour for colour, _ in CURVES if colour != BLACK), *_MUTED]
    hues = (np.arange(count) * _TURN + 0.13) % 1
    depth = np.where(np.arange(count) % 2, 0.55, 0.85)
    further = hsv_to_rgb(np.column_stack([hues, np.full(count, 0.75), depth]))
    colours = (known + [to_hex(colour) for colour in further[len(known) :]])[:count]
    if light:
        return [to_hex(1 - 0.25 * (1 - np.array(to_rgb(colour)))) for colour in colours]
    return colours


def save(figure: Figure, folder: Path, name: str, formats: Sequence[str]) -> tuple[str, ...]:
    """Write a figure in all formats; the names of its files.

    Raises:
        OSError: if it cannot be written; an older picture is as it was then.
    """
    files = tuple(f"{name}.{kind}" for kind in formats)
    with rc_context(_SETTINGS):
        for kind, file in zip(formats, files, strict=True):
            with replacing(folder / file) as part:
                figure.savefig(part, format=kind, dpi=DPI, metadata=_METADATA.get(kind))
    return files
