"""Which warnings of Python a user sees, each as one line.

NumPy and SciPy warn where a number overflows, is undefined or comes of a singular matrix: it may be
wrong, and nobody may miss that. What other libraries say to programmers is for --verbose.
"""

from __future__ import annotations

import logging
import warnings
from pathlib import Path
from typing import TextIO

logger = logging.getLogger(__name__)

#: Where categories are defined that concern numbers, besides `RuntimeWarning` and its kinds.
_OF_NUMBERS = ("numpy", "scipy")

#: Names of those among them that concern speed alone.
_OF_SPEED = ("SparseEfficiencyWarning",)


def show_by_line() -> None:
    """Have this process show warnings of numbers by a line each, and others on request."""
    warnings.showwarning = _show


def _show(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    place = "/".join(Path(filename).parts[-2:])
    text = " ".join(str(message).split())
    if of_numbers(category):
        logger.warning("%s (%s, line %d): numbers may be wrong", text, place, lineno)
    else:
        logger.info("%s: %s (%s, line %d)", category.__name__, text, place, lineno)


def of_numbers(category: type[Warning]) -> bool:
    """Whether a warning may mean that a number is wrong."""
    room = category.__module__.partition(".")[0]
    known = issubclass(category, RuntimeWarning) or room in _OF_NUMBERS
    return known and category.__name__ not in _OF_SPEED
