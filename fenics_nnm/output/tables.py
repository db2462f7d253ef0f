"""backbone.csv and summary.json."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from fenics_nnm.nonlinear.point import BranchPoint

#: Columns of backbone.csv and where each comes from; other programs rely on the names.
COLUMNS = {
    "gamma_ratio": "gamma_ratio",
    "frequency_Hz": "frequency",
    "frequency_ratio": "frequency_ratio",
    "rayleigh_frequency_Hz": "rayleigh_frequency",
    "energy_J": "energy",
    "penetration_m": "penetration",
    "virial_error": "virial_error",
    "contact_fraction": "contact_fraction",
    "status": "status",
    "reduction_residual": "reduction_residual",
    "reduction_error": "reduction_error",
    "return_error": "return_error",
    "shot_frequency_Hz": "shot_frequency",
    "largest_multiplier": "largest_multiplier",
}


def write_backbone(path: Path, points: Iterable[BranchPoint]) -> None:
    """Write the frequency-energy curve, one row a point in the given order.

    Raises:
        OSError: if it cannot be written.
    """
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["point", *COLUMNS])
        for number, point in enumerate(points, start=1):
            values = [getattr(point, source) for source in COLUMNS.values()]
            writer.writerow([number, *(_printed(value) for value in values)])


def write_summary(path: Path, summary: dict[str, Any]) -> None:
    """Write summary.json.

    Raises:
        OSError: if it cannot be written.
    """
    path.write_text(json.dumps(summary, indent=2, allow_nan=False) + "\n")


def _printed(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.10g}"
