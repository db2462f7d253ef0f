"""backbone.csv and summary.json."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import isnan
from pathlib import Path
from typing import Any

from fenics_nnm.backbone import point_numbers as numbers
from fenics_nnm.backbone.extremes import Extremes, PatchExtremes
from fenics_nnm.backbone.point import BranchPoint

#: Errors below this are round-off, and printed as zero.
_ROUND_OFF = 1e-12

#: Digits of the numbers in summary.json.
_DIGITS = 12


@dataclass(frozen=True, slots=True)
class Column:
    """What a column of backbone.csv has of a point.

    Attributes:
        of: From a point to its number or text.
        digits: Digits printed.
        round_off: A smaller number is printed as zero.
        empty: Whether the cell of a number that is not known, nan, is empty.
    """

    of: Callable[[BranchPoint], float | str]
    digits: int = 10
    round_off: float = 0.0
    empty: bool = False

    def printed(self, point: BranchPoint) -> str:
        """Its entry in the row of a point."""
        value = self.of(point)
        if isinstance(value, str):
            return value
        if self.empty and isnan(value):
            return ""
        return f"{0.0 if abs(value) < self.round_off else value:.{self.digits}g}"


def _error(of: Callable[[BranchPoint], float]) -> Column:
    """A column of relative errors, of which few digits are known."""
    return Column(of, digits=4, round_off=_ROUND_OFF)


def _known(of: Callable[[Extremes], float], digits: int = 10) -> Column:
    """A column of numbers that are not known of every point, with empty cells there."""
    return Column(lambda point: of(point.extremes), digits, empty=True)


def _text(of: Callable[[Extremes], str]) -> Column:
    return Column(lambda point: of(point.extremes))


#: Columns of the extremes of a point.
EXTREMES = {
    "displacement_m": _known(lambda own: own.displacement.value),
    "displacement_node": _text(
        lambda own: str(own.displacement.node) if own.displacement.known else ""
    ),
    "displacement_place_m": _text(lambda own: own.displacement.at),
    "patch_displacement_m": _known(lambda own: own.patch_displacement),
    "contact_force_N": _known(lambda own: own.force),
    "contact_impulse_Ns": _known(lambda own: own.impulse),
    "von_mises_Pa": _known(lambda own: own.von_mises.away.value),
    "von_mises_place_m": _text(lambda own: own.von_mises.away.at),
    "von_mises_quantile_Pa": _known(lambda own: own.von_mises.quantile),
    "von_mises_anywhere_Pa": _known(lambda own: own.von_mises.anywhere.value),
    "von_mises_anywhere_place_m": _text(lambda own: own.von_mises.anywhere.at),
    "von_mises_anywhere_kind": _text(lambda own: own.von_mises.kind),
    "principal_Pa": _known(lambda own: own.principal.away.value),
    "principal_place_m": _text(lambda own: own.principal.away.at),
    "principal_quantile_Pa": _known(lambda own: own.principal.quantile),
    "principal_anywhere_Pa": _known(lambda own: own.principal.anywhere.value),
    "principal_anywhere_place_m": _text(lambda own: own.principal.anywhere.at),
    "principal_anywhere_kind": _text(lambda own: own.principal.kind),
    "yield_margin": _known(lambda own: own.yield_margin.value, digits=6),
    "goodman_margin": _known(lambda own: own.goodman_margin.value, digits=6),
    "beyond": _text(lambda own: own.beyond),
    "asked_for": Column(lambda point: point.notes.asked),
}

#: Columns of backbone.csv and where each comes from; other programs rely on the names.
COLUMNS = {
    "gamma_ratio": Column(lambda point: point.gamma_ratio),
    "frequency_Hz": Column(lambda point: point.motion.frequency),
    "frequency_ratio": Column(lambda point: point.frequency_ratio),
    "rayleigh_frequency_Hz": Column(lambda point: point.motion.rayleigh_frequency),
    "energy_J": Column(lambda point: point.motion.energy),
    "penetration_m": Column(lambda point: point.balance.penetration),
    "virial_error": Column(lambda point: point.balance.virial_error),
    "contact_fraction": Column(lambda point: point.motion.contact_fraction),
    "status": Column(lambda point: point.status),
    "reduction_residual": _error(numbers.reduction_residual),
    "reduction_error": _error(numbers.reduction_error),
    "return_error": _error(numbers.return_error),
    "shot_frequency_Hz": Column(numbers.shot_frequency, digits=9),
    "largest_multiplier": Column(numbers.largest_multiplier, digits=7),
    "harmonics_error": _error(numbers.harmonics_error),
    "samples_error": _error(numbers.samples_error),
    "error_remainder": Column(numbers.error_remainder, digits=4),
    "resonance": Column(lambda point: point.resonance),
    "skipped": Column(lambda point: point.notes.skipped),
    "event": Column(lambda point: point.notes.event),
    "return_error_10": _error(numbers.return_error_10),
    "energy_variation": _error(lambda point: point.balance.energy_variation),
    "energy_drift": _error(numbers.energy_drift),
    "tension_m": Column(lambda point: point.balance.tension),
    "complementarity": _error(lambda point: point.balance.complementarity),
    "shot_distance": _error(numbers.shot_distance),
    "shot_return_error": Column(numbers.shot_return_error, digits=2),
    "stability": Column(numbers.stability_kind),
    "reason": Column(lambda point: point.reason),
    "slope_ratio": Column(lambda point: point.notes.slope_ratio, digits=4),
    "family": Column(lambda point: str(point.family or "")),
    "confirmed": Column(lambda point: "yes" if point.confirmed else "no"),
    "damping_needed": Column(numbers.damping_needed, digits=4),
    "damping_ratio": Column(numbers.damping_ratio),
    "resonance_force_N": Column(numbers.resonance_force),
    "damped": Column(lambda point: "yes" if numbers.is_damped(point) else "no"),
    **EXTREMES,
}

#: Columns of each patch where there are several, with its number before each.
OF_PATCHES: dict[str, Callable[[PatchExtremes], float]] = {
    "displacement_m": lambda patch: patch.displacement,
    "contact_force_N": lambda patch: patch.force,
    "contact_impulse_Ns": lambda patch: patch.impulse,
}


def write_backbone(path: Path, points: Iterable[BranchPoint]) -> None:
    """Write the frequency-energy curve, one row a point in the given order.

    Raises:
        OSError: if it cannot be written.
    """
    points = tuple(points)
    patches = max((len(point.extremes.patches) for point in points), default=0)
    patches = patches if patches > 1 else 0
    names = [f"patch{number + 1}_{name}" for number in range(patches) for name in OF_PATCHES]
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["point", *COLUMNS, *names])
        for number, point in enumerate(points, start=1):
            own = (column.printed(point) for column in COLUMNS.values())
            writer.writerow([number, *own, *_of_patches(point, patches)])


def _of_patches(point: BranchPoint, count: int) -> list[str]:
    """What each of several patches sees; empty where it is not known."""
    if len(point.extremes.patches) < count:
        return [""] * (count * len(OF_PATCHES))
    own = point.extremes.patches[:count]
    return [f"{of(patch):.10g}" for patch in own for of in OF_PATCHES.values()]


def write_summary(path: Path, summary: dict[str, Any]) -> None:
    """Write summary.json, its numbers to 12 digits: 2.1, where a sum of steps is a bit below.

    Raises:
        OSError: if it cannot be written.
    """
    path.write_text(json.dumps(_readable(summary), indent=2, allow_nan=False) + "\n")


def _readable(value: Any) -> Any:
    """Numbers, also those in lists and dictionaries, without their round-off."""
    if isinstance(value, dict):
        return {key: _readable(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_readable(each) for each in value]
    return float(f"{value:.{_DIGITS}g}") if isinstance(value, float) else value
