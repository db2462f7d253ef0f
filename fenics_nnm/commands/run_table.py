"""The table that ends a run on the terminal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

    from fenics_nnm.backbone.extremes import Extremes
    from fenics_nnm.backbone.point import BranchPoint
    from fenics_nnm.run import RunResult
    from fenics_nnm.study import Study

#: Columns of a terminal that has room for displacement and stress.
_WIDE = 80

#: Columns that a family, and a mark, take.
_FAMILY, _MARKED = 10, 4

#: Branches of so many points are shown whole; of longer ones about half as many.
_MOST = 20

#: Stands beside points whose material would yield.
_MARK = "*"


def result_table(result: RunResult, study: Study, width: int = 0) -> Table:
    """The points of a short branch; of a long one both ends and those that were asked for.

    Where there is room for it the largest displacement and von Mises stress are among the columns.
    Points beyond yield have a mark, see `line_of_marks`.
    """
    from rich.table import Table

    table = Table(title=study.title or None, box=None, padding=(0, 3, 0, 0))
    points = result.branch.points
    several = any(point.family > 1 for point in points)
    marked = any(map(_yields, points))
    sizes = _sizes_of(points, width - _FAMILY * several - _MARKED * marked)
    family, mark = ("family",) * several, ("",) * marked
    for heading in ("gamma ratio", "frequency (Hz)", "ratio", *sizes, "status", *mark, *family):
        table.add_column(heading, justify="right", no_wrap=True)
    for point in shown_points(points, study.continuation.report_at):
        table.add_row(
            f"{point.gamma_ratio:g}",
            f"{point.motion.frequency:.4f}",
            f"{point.frequency_ratio:.5f}",
            *(f"{of(point.extremes):.4g}" for of in sizes.values()),
            point.status,
            *((_MARK if _yields(point) else "",) * marked),
            *((str(point.family),) * several),
        )
    return table


def shown_points(points: Sequence[BranchPoint], ratios: Sequence[float]) -> list[BranchPoint]:
    """All points of a short branch; else both ends, and those asked for or evenly spread ones."""
    from fenics_nnm.backbone.quantities import asked_points

    if len(points) <= _MOST:
        return list(points)
    chosen = asked_points(points, ratios) or points[:: len(points) // (_MOST // 2)]
    kept = {id(point) for point in (points[0], *chosen, points[-1])}
    return [point for point in points if id(point) in kept]


def line_of_marks(points: Sequence[BranchPoint]) -> str:
    """What the mark of some points means; empty where none has it."""
    beyond = sum(map(_yields, points))
    if not beyond:
        return ""
    return (
        f"{_MARK} beyond yield, {beyond} of {len(points)} points: the material would yield there, "
        "and all results are those of an elastic body"
    )


def _yields(point: BranchPoint) -> bool:
    return point.extremes.yield_margin.value < 1


def _sizes_of(points: Sequence[BranchPoint], width: int) -> dict[str, Callable[[Extremes], float]]:
    """Columns of displacement and stress by their heading: those that are known and fit."""
    if width < _WIDE:
        return {}
    columns: dict[str, Callable[[Extremes], float]] = {
        "u (mm)": lambda own: 1e3 * own.displacement.value,
        "s (MPa)": lambda own: 1e-6 * own.von_mises.away.value,
    }
    return {
        heading: of
        for heading, of in columns.items()
        if any(of(point.extremes) == of(point.extremes) for point in points)
    }
