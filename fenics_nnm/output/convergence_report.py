"""convergence.csv, convergence.png, and the table of a convergence study."""

from __future__ import annotations

import csv
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.ticker import NullFormatter, ScalarFormatter

from fenics_nnm.errors import OutputError
from fenics_nnm.output.pictures.written import WrittenFigure
from fenics_nnm.resolution.accuracy import SOURCES
from fenics_nnm.resolution.convergence import Convergence, Row
from fenics_nnm.results.durable import replacing

#: Names of the three numbers, with their symbols.
_NAMES = {"harmonics": "harmonics N", "samples": "samples m", "modes": "modes J"}

_COLUMNS = ("varied", "number", "gamma_ratio", "frequency_Hz", "expected_error", "error", "status")

#: Errors below this are round-off, and not drawn.
_ROUND_OFF = 1e-13


def write_convergence(folder: Path, found: Convergence, *, title: str) -> None:
    """Write the rows and the picture of a convergence study to a folder.

    Raises:
        OutputError: if they cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with (
            replacing(folder / "convergence.csv") as part,
            part.open("w", newline="") as file,
        ):
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(_COLUMNS)
            writer.writerows(_printed(row) for row in found.rows)
        _plot(folder / "convergence.png", found, title)
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror or error}") from error


def convergence_lines(found: Convergence) -> list[str]:
    """Median errors over the energies, true and expected, with the rates."""
    lines = [f"around {found.around}; medians over the energies"]
    for source, reference in found.references.items():
        lines += ["", f"{_NAMES[source]:>12}   error against {reference:<5d}   expected"]
        lines += [
            f"{number:12d}   {true:<19.2e}   {expected:.2e}"
            for number, true, expected in found.medians(source)
        ]
        lines.append(f"        rate   {found.rate(source):.1f}")
    missing = sum(row.true != row.true for row in found.rows)
    return [*lines, "", f"{missing} of {len(found.rows)} motions not found"] if missing else lines


def _printed(row: Row) -> list[object]:
    return [
        row.source,
        row.number,
        f"{row.gamma_ratio:.10g}",
        f"{row.frequency:.10g}",
        f"{row.expected:.4g}",
        f"{row.true:.4g}",
        row.status,
    ]


def _plot(path: Path, found: Convergence, title: str) -> None:
    figure = WrittenFigure(figsize=(11, 4.4), layout="constrained")
    FigureCanvasAgg(figure)
    shown = [source for source in SOURCES if found.of(source)]
    panels = figure.subplots(1, max(len(shown), 1), squeeze=False)[0]
    for axes, source in zip(panels, shown, strict=False):
        _panel(axes, found, source)
    panels[0].set_ylabel("relative error of the frequency  (1)")
    figure.suptitle(title, fontsize=11)
    figure.supxlabel(
        "Filled: difference to the largest number at the same gamma ratio. Open: what the motion "
        f"itself expects.\nLine: median, with its rate. The other numbers: {found.around}.",
        fontsize=8.5,
        color="0.35",
    )
    with replacing(path) as part:
        figure.savefig(part, format="png", dpi=150)


def _panel(axes: Axes, found: Convergence, source: str) -> None:
    rows = found.of(source)
    for index, ratio in enumerate(sorted({row.gamma_ratio for row in rows})):
        here = [row for row in rows if row.gamma_ratio == ratio]
        colour, label = f"C{index}", f"gamma ratio {ratio:.3g}"
        for values, face, name in (
            ([abs(row.true) for row in here], colour, label),
            ([abs(row.expected) for row in here], "white", None),
        ):
            drawn = [(r.number, v) for r, v in zip(here, values, strict=True) if v > _ROUND_OFF]
            if drawn:
                axes.plot(*zip(*drawn, strict=True), "o", mfc=face, mec=colour, ms=5, label=name)
    medians = [(number, true) for number, true, _ in found.medians(source) if true > _ROUND_OFF]
    if medians:
        rate = f"rate {found.rate(source):.1f}"
        axes.plot(*zip(*medians, strict=True), "-", color="0.4", lw=1, label=rate)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xticks(sorted({row.number for row in rows}))
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel(f"{_NAMES[source]}  (1), against {found.references[source]}")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
