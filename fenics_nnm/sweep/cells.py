"""Numbers in the cells of sweep.csv."""

from __future__ import annotations


def printed(value: float | None) -> str:
    """A number with ten digits; an empty cell for none."""
    return "" if value is None else f"{value:.10g}"
