"""What the curves of the studies of a sweep look like, and their legend."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fenics_nnm.output.pictures.style import BLUE, CURVES, GREY, shades
from fenics_nnm.sweep.variation import Variation

#: Of more values than this the legend shows a few.
_MOST_ENTRIES = 10

_STYLES = ("-", "--", "-.", ":")
_MARKERS = ("o", "s", "^", "D", "v", "P")

#: What the first three keys that vary change of a curve.
_ARGUMENTS = ("color", "ls", "marker")

Looks = list[dict[str, Any]]
"""Colour, line and marker of each value of the first three keys that vary."""


def looks(keys: Sequence[Variation]) -> Looks:
    """What each value of the first three keys looks like; values beyond begin anew."""
    found: Looks = []
    for place, key in enumerate(keys[: len(_ARGUMENTS)]):
        kinds: Sequence[Any] = (_colours(key), _STYLES, _MARKERS)[place]
        found.append({name: kinds[i % len(kinds)] for i, name in enumerate(key.levels)})
    return found


def looks_of(index: int, keys: Sequence[Variation], kinds_of: Looks) -> dict[str, Any]:
    """Arguments of `plot` for a study, by its place in the plan."""
    chosen = {"color": BLUE, "ls": "-", "marker": ".", "ms": 3}
    for argument, key, kinds in zip(_ARGUMENTS, keys, kinds_of, strict=False):
        chosen[argument] = kinds[key.names[index]]
    return chosen


def _colours(key: Variation) -> Sequence[Any]:
    """Colours from dark to light of numbers, colours that differ most of other values."""
    many = key.numeric or len(key.levels) > len(CURVES)
    return list(shades(len(key.levels))) if many else [colour for colour, _ in CURVES]


def legend(
    figure: Figure, keys: Sequence[Variation], kinds_of: Looks, marks: Sequence[Line2D] = ()
) -> None:
    """Below all axes: one key in lines from left to right, several in columns of their own.

    Args:
        figure: Figure.
        keys: Keys that vary.
        kinds_of: What their values look like.
        marks: Entries of points with a mark.
    """
    columns = [
        [handle(name, **{argument: kinds[name]}) for name in _some(key.levels)]
        for argument, key, kinds in zip(_ARGUMENTS, keys, kinds_of, strict=False)
    ]
    titles = [key.label for key in keys[: len(columns)]]
    if marks:
        columns, titles = [*columns, list(marks)], [*titles, "points"]
    alike = ", ".join(key.label for key in keys[len(_ARGUMENTS) :])
    only = columns[0] if len(columns) == 1 else None
    figure.legend(
        handles=only or _in_columns(columns, titles),
        loc="outside lower center",
        ncols=min(5, len(only)) if only else max(1, len(columns)),
        fontsize=8,
        title=titles[0] if only else f"the same colour: {alike}" if alike else None,
        title_fontsize=8,
        frameon=False,
    )


def _in_columns(columns: Sequence[Sequence[Line2D]], titles: Sequence[str]) -> list[Line2D]:
    """Entries of a legend that is filled column by column, each with its title on top."""
    height = max((len(column) for column in columns), default=0)
    return [
        entry
        for title, column in zip(titles, columns, strict=True)
        for entry in (
            handle(title, ls=""),
            *column,
            *(handle(" ", ls="") for _ in range(height - len(column))),
        )
    ]


def handle(name: str, **looks: Any) -> Line2D:
    """An entry of a legend; arguments as of `plot`."""
    return Line2D([], [], label=name, **{"color": GREY, "lw": 1.4, "ms": 4, **looks})


def _some(levels: Sequence[str]) -> list[str]:
    """All values, or evenly spread ones where they are many."""
    if len(levels) <= _MOST_ENTRIES:
        return list(levels)
    chosen = np.unique(np.linspace(0, len(levels) - 1, _MOST_ENTRIES).round().astype(int))
    return [levels[index] for index in chosen]
