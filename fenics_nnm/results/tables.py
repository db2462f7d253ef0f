"""backbone.csv and summary.json."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from fenics_nnm.backbone.point import BranchPoint

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
    "harmonics_error": "harmonics_error",
    "samples_error": "samples_error",
    "error_remainder": "error_remainder",
    "resonance": "resonance",
    "skipped": "skipped",
    "event": "event",
    "return_error_10": "return_error_10",
    "energy_variation": "energy_variation",
    "energy_drift": "energy_drift",
    "tension_m": "tension",
    "complementarity": "complementarity",
    "shot_distance": "shot_distance",
    "shot_return_error": "shot_return_error",
    "stability": "stability",
    "reason": "reason",
    "slope_ratio": "slope_ratio",
}

#: Errors below this are round-off, and printed as zero.
_ROUND_OFF = dict.fromkeys(
    (
        "reduction_residual",
        "reduction_error",
        "return_error",
        "harmonics_error",
        "samples_error",
        "return_error_10",
        "energy_variation",
        "energy_drift",
        "complementarity",
        "shot_distance",
    ),
    1e-12,
)

#: Digits of what is known to fewer than ten.
_DIGITS = {
    **dict.fromkeys((*_ROUND_OFF, "error_remainder", "slope_ratio"), 4),
    "shot_frequency": 9,
    "largest_multiplier": 7,
    "shot_return_error": 2,
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
            values = [_printed(name, getattr(point, name)) for name in COLUMNS.values()]
            writer.writerow([number, *values])


def write_summary(path: Path, summary: dict[str, Any]) -> None:
    """Write summary.json.

    Raises:
        OSError: if it cannot be written.
    """
    path.write_text(json.dumps(summary, indent=2, allow_nan=False) + "\n")


def _printed(name: str, value: float | str) -> str:
    if isinstance(value, str):
        return value
    return f"{0.0 if abs(value) < _ROUND_OFF.get(name, 0) else value:.{_DIGITS.get(name, 10)}g}"
