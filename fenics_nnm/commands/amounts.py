"""Options that name points by an amount with its unit: --amplitude 2mm, --stress 300MPa."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING

from fenics_nnm.errors import StudyError

if TYPE_CHECKING:
    from fenics_nnm.backbone.quantities import Sought

#: Quantities that points are named by, with an example of each.
EXAMPLES = {
    "amplitude": "2mm",
    "energy": "1.2J",
    "stress": "300MPa",
    "frequency": "410Hz",
}


def add_amounts(command: argparse.ArgumentParser, words: str) -> None:
    """Add an option for each quantity; the words say what it does, after its example."""
    for name, example in EXAMPLES.items():
        command.add_argument(
            f"--{name}",
            nargs="+",
            default=[],
            metavar="VALUE",
            help=f"{name} with its unit, as in {example}{words}",
        )


def amounts_of(arguments: argparse.Namespace) -> dict[str, Sought]:
    """Values of quantities that are named, by the text that was given.

    Raises:
        StudyError: if one is no positive amount of its quantity.
    """
    return {
        text: _sought(name, text) for name in EXAMPLES for text in getattr(arguments, name) or ()
    }


def _sought(name: str, text: str) -> Sought:
    from fenics_nnm.backbone.quantities import UNITS, Sought
    from fenics_nnm.geometry.amounts import amount

    try:
        value, _ = amount(text, UNITS[name])
    except ValueError as error:
        raise StudyError(f"--{name} {text}: {error}") from error
    if not 0 < value < math.inf:
        raise StudyError(f"--{name} {text}: must be positive")
    return Sought(name, value)
