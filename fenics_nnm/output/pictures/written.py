"""Figures that write titles and names as they stand in a study."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from matplotlib.figure import Figure
from matplotlib.text import Text


class WrittenFigure(Figure):
    """A figure in whose titles, labels and legends `$` is a letter, and begins no formula.

    Numbers of ticks may be formulas, as powers of ten are.
    """

    def draw(self, renderer: Any) -> None:
        """Draw it."""
        ticks = {id(text) for text in self._of_ticks()}
        for text in self.findobj(Text):
            if id(text) not in ticks and isinstance(text, Text):
                text.set_parse_math(False)
        super().draw(renderer)

    def _of_ticks(self) -> Iterator[Text]:
        for axis in (axis for axes in self.axes for axis in (axes.xaxis, axes.yaxis)):
            yield axis.offsetText
            for tick in (*axis.majorTicks, *axis.minorTicks):
                yield from (tick.label1, tick.label2)
